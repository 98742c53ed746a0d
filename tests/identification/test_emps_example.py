"""The prior of the EMPS axis that ships, and the command that its file prints."""

import shlex
from pathlib import Path

import pytest

import cogging
from cogging.cli.main import main
from cogging.datasets import emps
from tests.fixtures.emps import prior
from tests.fixtures.measured import FOLDER

FILE = Path(__file__).parents[2] / "examples" / "emps" / "prior.toml"


def command():
    """The words of the printed command, without the file of the log."""
    lines = [line.removeprefix("##").strip() for line in FILE.read_text().splitlines() if line.startswith("##")]
    first = next(i for i, line in enumerate(lines) if line.startswith("cogging identify"))
    words = shlex.split(f"{lines[first].rstrip(chr(92))} {lines[first + 1]}")
    assert words[:3] == ["cogging", "identify", "$LOG"]
    return words[3:]


def test_the_prior_is_that_of_the_tests():
    shipped, known = cogging.Model.read(FILE), prior()
    assert shipped.axis == known.axis
    assert shipped.effects == known.effects
    assert shipped.controller_type == known.controller_type
    for name in ("sample_rate", "kp", "kv", "mass", "viscous", "coulomb", "command_limit"):
        assert getattr(shipped.controller, name) == pytest.approx(getattr(known.controller, name), rel=1e-9)
    assert shipped.units.command == "N"


@pytest.mark.data
def test_the_printed_command_finds_the_published_numbers(tmp_path, capsys):
    words = command()
    words[words.index("--model") + 1] = str(FILE)
    words[words.index("--out") + 1] = str(tmp_path / "fitted.toml")
    assert main(["identify", str(emps.files(FOLDER)["DATA_EMPS"]), *words]) == 0
    assert "axis.mass" in capsys.readouterr().out
    fitted = cogging.parameters_of(cogging.Model.read(tmp_path / "fitted.toml"))
    for path, published in emps.PUBLISHED.items():
        assert fitted[path].value == pytest.approx(published, rel=0.02)
