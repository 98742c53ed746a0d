"""From the measured log of a ball-screw axis to its model, and from there to a motion that took no part in the fit."""

import pytest

from cogging.datasets import emps
from cogging.identification.identification import identify
from cogging.identification.logged_run import LoggedRun
from tests.fixtures.emps import prior, read
from tests.fixtures.measured import FOLDER

pytestmark = pytest.mark.data


@pytest.fixture(scope="module")
def found():
    result = identify(read(), prior(), names=["DATA_EMPS.mat"])
    print("\n" + result.text())
    return result


@pytest.mark.parametrize(("path", "tolerance"), [*zip(emps.PUBLISHED, (0.015, 0.015, 0.015, 0.05), strict=True)])
def test_finds_the_published_parameters(found, path, tolerance):
    published, p = emps.PUBLISHED[path], found[path]
    assert p.determined
    assert p.value == pytest.approx(published, rel=tolerance)
    assert p.ci95[0] < published < p.ci95[1]
    assert p.ci95[1] - p.ci95[0] < 0.2 * abs(published)
    assert abs(p.difference) < 3.0


def test_the_model_leaves_far_more_than_the_encoder_does(found):
    log = found.logs[0]
    assert log.residual_before > 2.0 * log.residual_after
    assert log.residual_after > 20.0 * log.floor  # of what it misses: see the notebook


def test_the_controller_is_reported_with_gains_four_percent_larger(found):
    (line,) = found.controller
    assert "the stated cascade gives the command to 3.3 %" in line
    check = found.audits[0].controller
    assert check.fitted["kv"] / check.stated["kv"] == pytest.approx(1.045, abs=0.005)
    assert check.fitted["kp"] / check.stated["kp"] == pytest.approx(1.0, abs=0.005)
    assert check.fitted_rms < 0.4 * check.difference_rms


def test_replay_is_no_worse_than_the_authors(found):
    for name, error in found.logs[0].replay.items():
        assert error < emps.AUTHORS_ERRORS["DATA_EMPS"][name], name


def test_pulses_that_took_no_part_in_the_fit_are_foreseen_no_worse_than_by_the_authors(found):
    run = LoggedRun.of(read("DATA_EMPS_PULSES"), found.model, "DATA_EMPS_PULSES.mat", emps.pulses(FOLDER))
    errors = run.relative_errors(found.model)
    authors = emps.AUTHORS_ERRORS["DATA_EMPS_PULSES"]
    print("\n" + run.line)
    print(
        ", ".join(f"{name} {100 * error:.3g} % (authors {100 * authors[name]:.3g} %)" for name, error in errors.items())
    )
    for name, error in errors.items():
        assert error < authors[name], name


def test_without_its_pulses_the_second_log_contradicts_its_controller():
    found = identify(read("DATA_EMPS_PULSES"), prior(), names=["pulses"])
    assert "did not make this log" in found.controller[0]
    assert found["axis.mass"].value == pytest.approx(95.1, rel=0.03)


def test_a_width_of_one_millimetre_a_second_moves_friction(found):
    fixed = identify(read(), prior(1e-3), free=list(emps.PUBLISHED))
    ratios = {path: fixed[path].value / found[path].value for path in ("axis.viscous", "axis.coulomb")}
    print(
        f"\nwidth 1 mm/s: viscous {100 * (ratios['axis.viscous'] - 1):+.1f} %, "
        f"Coulomb {100 * (ratios['axis.coulomb'] - 1):+.1f} %"
    )
    assert ratios["axis.viscous"] == pytest.approx(0.96, abs=0.015)
    assert ratios["axis.coulomb"] == pytest.approx(1.05, abs=0.015)
    assert fixed["axis.mass"].value == pytest.approx(found["axis.mass"].value, rel=2e-3)


def test_a_free_width_is_found_well_above_zero_and_trades_with_both(found):
    free = identify(read(), prior(1e-3))
    print("\n" + free.text())
    width = free["axis.coulomb_width"]
    assert width.determined
    assert 1e-3 < width.ci95[0] < width.ci95[1] < 5e-3
    assert free["axis.viscous"].value < 0.95 * found["axis.viscous"].value
    assert free["axis.coulomb"].value > 1.05 * found["axis.coulomb"].value
    assert free.logs[0].residual_after < found.logs[0].residual_after


def test_direction_explains_most_of_the_offset(found):
    """The publication's offset stands for a viscous friction that differs with direction."""
    from cogging import effects

    model = prior()
    richer = identify(read(), model.replace(effects=(*model.effects, effects.ViscousAsymmetry())))
    offset, difference = richer["effects.constant_force.force"], richer["effects.viscous_asymmetry.difference"]
    assert abs(offset.value) < 0.4 * found["effects.constant_force.force"].value
    assert difference.value == pytest.approx(166.0 - 240.0, rel=0.2)
    assert not difference.ci95[0] < 0.0 < difference.ci95[1]
    assert richer.logs[0].residual_after < 0.9 * found.logs[0].residual_after
