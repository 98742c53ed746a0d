"""What would explain Table I of Malaize and Levine 2009: conditions by hand, and how sizes are found."""

import importlib.resources

import numpy as np
import pytest

from cogging.papers.malaize2009.accuracies import lines_at_speed
from cogging.papers.malaize2009.causes import (
    CAUSES,
    DRAWS,
    LINE_COUNT,
    LINE_PERIODS,
    Conditions,
    conditions_file,
    drawn_accuracies,
    machine,
    other,
    shipped_table_1,
    unmodelled_lines,
)
from cogging.papers.malaize2009.linear_motors import (
    MOTORS,
    accuracy,
    batch_errors,
    cogging_rms,
    observer,
    pid,
    plant,
    run,
    shipped,
    true_error,
)
from studies.malaize2009 import causes_calibration, causes_study
from studies.malaize2009.causes_calibration import recalibrated


@pytest.mark.parametrize("cause", CAUSES, ids=lambda cause: cause.name)
def test_the_observers_error_grows_with_the_size(cause):
    for motor in MOTORS.values():
        size = conditions_file()[cause.field][motor.name]["size"]
        ratios = [
            drawn_accuracies(motor, shipped(motor), cause.of(share * size), "observer", 1).mean()
            for share in (1 / 3, 3.0)
        ]
        assert ratios[0] < 0.85**2 * ratios[1], (motor.name, ratios)


def test_no_amplitude_where_the_pid_errs_by_more_without_cogging():
    motor = MOTORS["ironless"]
    with pytest.raises(ValueError, match=r"^ironless: no amplitude gives the PID the printed accuracy"):
        recalibrated(motor, shipped(motor), Conditions(thrust=0.1))


@pytest.mark.study
def test_the_calibration_regenerates_the_shipped_conditions():
    shipped_text = importlib.resources.files("cogging.papers.malaize2009").joinpath("conditions.toml").read_text()
    assert causes_calibration.conditions_toml() == shipped_text


@pytest.mark.parametrize("motor", MOTORS.values(), ids=MOTORS)
def test_a_machine_without_conditions_is_that_of_the_setup(motor):
    gains = shipped(motor)
    by_hand = [
        accuracy(run(plant(motor, gains.amplitude), controller, motor), motor)
        for controller in (pid(), observer(motor, gains))
    ]
    machines = [machine(motor, gains.amplitude, Conditions())] * 2
    assert batch_errors(machines, [pid()] * 2, motor).tolist() == [by_hand[0]] * 2
    assert drawn_accuracies(motor, gains, Conditions(), "observer", 1).tolist() == by_hand[1:]


@pytest.mark.parametrize("draw", range(2))
def test_the_lines_have_the_rms_that_was_asked_for(draw):
    motor = MOTORS["ironcore"]
    rms = 0.03 * cogging_rms(motor, 0.2)
    assert cogging_rms(motor, 0.2) == pytest.approx(0.2 * np.sqrt((1.0 + 0.36 + 0.16) / 2))
    x = np.linspace(0.0, 50.0, 400_001)
    force = np.zeros_like(x)
    for line in unmodelled_lines(draw, rms):
        assert LINE_PERIODS[0] <= line.period <= LINE_PERIODS[1]
        force -= line.sine * np.sin(2 * np.pi * x / line.period) + line.cosine * np.cos(2 * np.pi * x / line.period)
    assert np.sqrt(np.mean(force**2)) == pytest.approx(rms, rel=0.02)
    listed = machine(motor, 0.2, Conditions(lines=0.03), draw).effects
    assert len(listed) == 1 + LINE_COUNT
    assert len({line.period for line in unmodelled_lines(draw + 1, rms)} & {each.period for each in listed[1:]}) == 0


def test_lines_at_speed_finds_a_line_of_known_size():
    motor = MOTORS["ironless"]
    log = run(plant(motor, 0.01635, friction=0.0, resolution=0.0), pid(), motor)
    amplitudes, left = lines_at_speed(log, motor, motor.periods)
    rows = np.abs(log.reference_velocity) >= 0.99 * motor.velocity
    # At constant speed the error is its two lines and the rest of the ramps before them.
    assert np.sqrt(0.5 * np.sum(amplitudes**2)) == pytest.approx(np.std(true_error(log)[rows]), rel=0.1)
    assert 0.0 < left < 0.3


@pytest.mark.parametrize("motor", MOTORS.values(), ids=MOTORS)
def test_the_spectrum_proposes_the_printed_periods_first_in_every_draw_of_the_lines(motor):
    assert causes_study.draws_that_propose(motor) == DRAWS
    assert other(other(motor)) is motor
    assert shipped_table_1(motor)[0] == Conditions(lines=conditions_file()["table_1"]["lines"]["size"], any_phases=True)
    assert shipped_table_1(motor, CAUSES[-1])[0] == Conditions(width=conditions_file()["table_1"]["width"]["size"])
