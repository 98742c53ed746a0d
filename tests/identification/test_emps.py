"""From the measured log of a ball-screw axis to its model, and from there to a motion that took no part in the fit."""

import shlex
from pathlib import Path

import pytest

import cogging
from cogging.cli.main import main
from cogging.datasets import emps
from cogging.identification.logged_run import LoggedRun
from tests.fixtures.emps import read
from tests.fixtures.measured import FOLDER

SHIPPED = Path(__file__).parents[2] / "examples" / "emps" / "prior.toml"
data = pytest.mark.data


def prior(width=0.0):
    """The shipped guess with a width of the sign (m/s)."""
    model = cogging.Model.read(SHIPPED)
    return model.replace(axis=model.axis.replace(coulomb_width=width))


@pytest.fixture(scope="module")
def found():
    result = cogging.identify(read(), prior(), names=["DATA_EMPS.mat"])
    print("\n" + result.text())
    return result


def test_the_shipped_prior_has_the_published_controller():
    controller, published = prior().controller, emps.controller()
    for name in ("sample_rate", "kp", "kv", "mass", "viscous", "coulomb", "command_limit"):
        assert getattr(controller, name) == pytest.approx(getattr(published, name), rel=1e-9)


@data
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


@data
@pytest.mark.parametrize(("path", "tolerance"), [*zip(emps.PUBLISHED, (0.015, 0.015, 0.015, 0.05), strict=True)])
def test_the_published_parameters_are_found(found, path, tolerance):
    published, p = emps.PUBLISHED[path], found[path]
    assert p.determined
    assert p.value == pytest.approx(published, rel=tolerance)
    assert p.ci95[0] < published < p.ci95[1]
    assert p.ci95[1] - p.ci95[0] < 0.2 * abs(published)
    assert abs(p.difference) < 3.0


@data
def test_residual_controller_and_replay(found):
    log = found.logs[0]
    assert log.residual_before > 2.0 * log.residual_after
    assert log.residual_after > 20.0 * log.floor  # of what it misses: see the notebook
    assert "the stated cascade gives the command to 3.3 %" in found.controller[0]
    check = found.audits[0].controller
    assert check.fitted["kv"] / check.stated["kv"] == pytest.approx(1.045, abs=0.005)
    assert check.fitted["kp"] / check.stated["kp"] == pytest.approx(1.0, abs=0.005)
    assert check.fitted_rms < 0.4 * check.difference_rms
    run = LoggedRun.of(read("DATA_EMPS_PULSES"), found.model, "DATA_EMPS_PULSES.mat", emps.pulses(FOLDER))
    for name, errors in (("DATA_EMPS", log.replay), ("DATA_EMPS_PULSES", run.relative_errors(found.model))):
        authors = emps.AUTHORS_ERRORS[name]
        print("\n" + ", ".join(f"{k} {100 * e:.3g} % (authors {100 * authors[k]:.3g} %)" for k, e in errors.items()))
        assert all(error < authors[column] for column, error in errors.items()), name


@data
def test_a_width_of_one_millimetre_a_second_moves_friction(found):
    fixed = cogging.identify(read(), prior(1e-3), free=list(emps.PUBLISHED))
    for path, ratio in (("axis.viscous", 0.96), ("axis.coulomb", 1.05)):
        print(f"\nwidth 1 mm/s: {path} {100 * (fixed[path].value / found[path].value - 1):+.1f} %")
        assert fixed[path].value / found[path].value == pytest.approx(ratio, abs=0.015)
    assert fixed["axis.mass"].value == pytest.approx(found["axis.mass"].value, rel=2e-3)
    free = cogging.identify(read(), prior(1e-3))
    width = free["axis.coulomb_width"]
    assert width.determined
    assert 1e-3 < width.ci95[0] < width.ci95[1] < 5e-3
    assert free["axis.viscous"].value < 0.95 * found["axis.viscous"].value
    assert free["axis.coulomb"].value > 1.05 * found["axis.coulomb"].value
    assert free.logs[0].residual_after < found.logs[0].residual_after
