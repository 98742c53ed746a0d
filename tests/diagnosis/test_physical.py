"""What no machine can be is no explanation; the machines are simulated here by Euler's method."""

import itertools

import numpy as np
import pytest

import cogging
from cogging.diagnosis.physical import at_end, ends, moving_command, obeyed_command, unphysical
from cogging.effects.effect import VOCABULARY
from tests.fixtures import measured

STEPS = 10


def record(seed, *, limit=np.inf, speed=6.0, width=0.05, seconds=6.0, rate=1000.0, mass=0.2, coulomb=2.0):
    """A rotary axis that a PID swings to and fro; its amplifier cuts commands at a limit (Nm), the log does not."""
    random, time = np.random.default_rng([33, seed]), np.arange(int(seconds * rate)) / rate
    turns = random.uniform(0.5, 2.0, 4)
    waves = [np.sin(2 * np.pi * f * time + f) / (2 * np.pi * f) for f in turns]
    reference = 0.5 * speed * np.sum(waves, axis=0) * np.minimum(1.0, time) ** 2
    x, v, last, total = reference[0], 0.0, None, 0.0
    kp, kd = mass * 3600.0, mass * 100.0
    position, command = np.empty(len(time)), np.empty(len(time))
    for i, wanted in enumerate(reference):
        error = 1e-5 * round(x / 1e-5) - wanted
        total += 2.0 * kp * error / rate
        u = -kp * error - total - kd * (error - (error if last is None else last)) * rate
        position[i], command[i], last = error + wanted, u, error
        for _ in range(STEPS):
            push = max(min(u, limit), -limit) - coulomb * np.tanh(v / width)
            v += push / mass / rate / STEPS
            x += v / rate / STEPS
    return cogging.Log(time, position, command)


AXIS = cogging.AxisParameters(mass=0.2, viscous=0.01, coulomb=2.0, coulomb_width=0.05)
STATED = cogging.Model(axis=AXIS, encoder=cogging.EncoderParameters(resolution=1e-5))


@pytest.mark.parametrize("seed", range(2))
def test_no_limit_is_below_commands_that_were_obeyed(seed):
    free = record(seed, speed=20.0)
    largest = float(np.abs(free.command).max())
    law = VOCABULARY["command_saturation"]
    assert obeyed_command([free]) > 0.5 * largest
    assert "limit is " in at_end(law.replace(limit=0.5 * largest), [free])
    assert ends([record(seed, speed=20.0, limit=0.6 * largest)], law.ROLES["limit"])[0] < 0.6 * largest


def test_no_tone_and_no_resonance_is_slower_than_three_periods():
    log, least = record(0, seconds=3.5), 3.0 / 3.5
    slow = cogging.EFFECTS["flexible_mode"](frequency=least, damping_ratio=0.1, mass_ratio=0.3)
    assert "frequency is 0.857" in at_end(slow, [log])
    assert at_end(slow.replace(frequency=20.0), [log]) == ""


def test_no_friction_is_above_the_command_that_moved_the_axis():
    log = record(4)
    most = moving_command([log])
    assert np.abs(log.command).max() >= most
    for name in ("stribeck_friction", "coulomb_asymmetry"):
        field = next(iter(VOCABULARY[name].ROLES))
        assert at_end(VOCABULARY[name].replace(**{field: most}), [log]).startswith(f"its {field} is")


def test_no_friction_pushes():
    log = record(4)
    low, high = float(log.position.min()), float(log.position.max())
    for levels, pushes in (([0.0, -1.9], False), ([0.0, -3.0], True)):
        uneven = cogging.EFFECTS["position_dependent_friction"](nodes=[low, high], levels=levels)
        assert ("it would push the axis" in unphysical(STATED.replace(effects=(uneven,)), 0, [log])) is pushes
    for difference, pushes in ((3.8, False), (6.0, True)):
        model = STATED.replace(effects=(cogging.EFFECTS["coulomb_asymmetry"](difference=difference),))
        assert ("it would push the axis" in unphysical(model, 1, [log])) is pushes


@pytest.mark.data
@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # the confirm log of two_mass, predicted with its mode, diverges
@pytest.mark.parametrize("machine", ["pendulum", "two_mass"])
def test_no_real_machine_gets_a_term_that_it_cannot_have(machine, request):
    measured.needs(machine)
    if machine == "pendulum":
        axis = {"mass": 0.147, "viscous": 0.02, "coulomb": 0.15, "coulomb_width": 0.05}
        files = [measured.FOLDER / "pendulum" / f"{name}.csv" for name in ("ddp", "direct_collocation")]
        logs = [cogging.read_log(file, columns={"command": "torque"}) for file in files]
        resolution, stated = 0.002914, {}
    else:
        axis = {"mass": 0.0096, "viscous": 0.02, "coulomb": 0.1, "coulomb_width": 0.05}
        logs = [request.getfixturevalue("two_mass")(letter, slice(2500, 10_000)) for letter in "AB"]
        resolution, stated = 6e-6, {"mass": 0.3, "viscous": 1.0, "coulomb": 1.0}
    encoder, units = cogging.EncoderParameters(resolution=resolution), cogging.Units(position="rad")
    model = cogging.Model(axis=cogging.AxisParameters(**axis), encoder=encoder, uncertainty=stated, units=units)
    for given, confirm in itertools.permutations(logs):
        result = cogging.diagnose(given, model, confirm=confirm)
        assert result.model.axis.coulomb <= moving_command([given])
        assert unphysical(result.model, 0, [given]) == ""
