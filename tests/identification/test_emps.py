"""The shipped prior of a measured ball-screw axis: its command finds the published numbers (notebook measured_axes)."""

import shlex
from pathlib import Path

import pytest

import cogging
from cogging.cli.main import main
from cogging.datasets import emps
from tests.fixtures.measured import FOLDER

SHIPPED = Path(__file__).parents[2] / "examples" / "emps" / "prior.toml"


def test_the_shipped_prior_has_the_published_controller():
    controller, published = cogging.Model.read(SHIPPED).controller, emps.controller()
    for name in ("sample_rate", "kp", "kv", "mass", "viscous", "coulomb", "command_limit"):
        assert getattr(controller, name) == pytest.approx(getattr(published, name), rel=1e-9)


@pytest.mark.data
def test_the_printed_command_finds_the_published_numbers(tmp_path, capsys):
    lines = [line.removeprefix("##").strip() for line in SHIPPED.read_text().splitlines() if line.startswith("##")]
    first = next(i for i, line in enumerate(lines) if line.startswith("cogging identify"))
    words = shlex.split(f"{lines[first].rstrip(chr(92))} {lines[first + 1]}")
    assert words[:3] == ["cogging", "identify", "$LOG"]
    words[words.index("--model") + 1] = str(SHIPPED)
    words[words.index("--out") + 1] = str(tmp_path / "fitted.toml")
    assert main(["identify", str(emps.files(FOLDER)["DATA_EMPS"]), *words[3:]]) == 0
    assert "axis.mass" in capsys.readouterr().out
    fitted = cogging.parameters_of(cogging.Model.read(tmp_path / "fitted.toml"))
    for path, published in emps.PUBLISHED.items():
        assert fitted[path].value == pytest.approx(published, rel=0.02)
