"""Table I of Malaize and Levine 2009: its calibration, machines under conditions, spectra. Numbers: test_numbers.py."""

import importlib.resources

import numpy as np
import pytest

from cogging.files import parse_toml
from cogging.papers.malaize2009.linear_motors import MOTORS, reference
from studies.malaize2009 import calibration, causes_calibration, causes_study
from tests.fixtures.reproduced import table_of

EACH_MOTOR = pytest.mark.parametrize("motor", MOTORS.values(), ids=MOTORS)


def test_table_1_is_calibrated_under_either_cause_and_was_predicted_as_believed():
    lines, friction = table_of("malaize2009", "table1"), table_of("malaize2009", "table1_width")
    assert {row.status for table in (lines, friction) for row in table.rows} == {"calibrated"}
    assert (len(lines.free), len(friction.free), len(lines.before.free)) == (5, 5, 4)
    predicted = {(row.controller, row.index) for row in lines.before.rows if row.status == "predicted"}
    assert predicted == {("observer", "accuracy")}
    for row in lines.rows:
        if row.index == "accuracy":  # a mean over draws, whose label gives their range
            low, high = map(float, row.labels["of 10 draws"].removesuffix(" um").split(" to "))
            assert low < 1e6 * row.simulated < high


@pytest.mark.parametrize("name", ["ironless", pytest.param("ironcore", marks=pytest.mark.study)])
def test_the_calibration_regenerates_the_shipped_values(name):
    text = importlib.resources.files("cogging.papers.malaize2009").joinpath("gains.toml").read_text()
    found, shipped = calibration.calibrate(MOTORS[name]), parse_toml(text)[name]
    assert found.amplitude == shipped["amplitude"]
    assert found.pole_radius == pytest.approx(shipped["pole_radius"], rel=1e-3)
    assert found.lambda_star == pytest.approx(shipped["lambda_star"], rel=1e-3)
    # The solver's last digits differ by machine.
    np.testing.assert_allclose(found.observer_gain, shipped["observer_gain"], rtol=0.02, atol=1e-3 * 1e7)


@pytest.mark.study
def test_the_calibration_regenerates_the_shipped_conditions():
    text = importlib.resources.files("cogging.papers.malaize2009").joinpath("conditions.toml").read_text()
    assert causes_calibration.conditions_toml() == text


@EACH_MOTOR
def test_the_spectrum_proposes_the_papers_periods_in_every_draw_of_the_lines(motor):
    assert causes_study.draws_that_propose(motor, 5) == 5


@pytest.mark.parametrize(("motor", "acceleration"), [("ironcore", 4.0), ("ironless", 2.5)])
def test_the_strokes_have_the_printed_acceleration(motor, acceleration):
    motion = reference(MOTORS[motor])
    _, velocity, found = motion.sample(np.linspace(0.0, motion.period, 20_001))
    assert np.abs(found).max() == pytest.approx(acceleration, rel=1e-9)
    assert [velocity.max(), -velocity.min()] == pytest.approx([MOTORS[motor].velocity] * 2, rel=1e-9)
