"""Motions of an experiment: limits files, and references that keep to them on machines drawn at random."""

import numpy as np
import pytest

import cogging
from cogging.design.experiment_motion import KINDS, SURVEY, Machine, drawn, is_known, planned
from cogging.design.motion_limits import taken_of
from cogging.files import FieldError, InputError

GOOD = {"travel": [0.0, 0.4], "velocity": 0.5, "acceleration": 5.0, "jerk": 400.0, "duration": 5.0, "command": 3.0}


def drawn_limits(random):
    """Limits of machines from a stage of some millimetres to a gantry, slow and quick."""
    length = float(np.exp(random.uniform(np.log(5e-3), np.log(3.0))))
    low = float(random.uniform(-1.0, 1.0))
    acceleration = float(np.exp(random.uniform(np.log(0.5), np.log(40.0))))
    return cogging.MotionLimits(
        velocity=float(random.uniform(0.1, 1.0) * np.sqrt(acceleration * length)),
        acceleration=acceleration,
        duration=float(random.uniform(2.0, 6.0)),
        travel=(low, low + length),
        jerk=float(acceleration * np.exp(random.uniform(np.log(5.0), np.log(1000.0)))),
    )


def drawn_model(random, limits):
    """A machine that can do what the limits allow, its controller as quick as it needs."""
    mass = float(np.exp(random.uniform(np.log(0.05), np.log(50.0))))
    force = mass * limits.acceleration
    kp, ki, kd = cogging.pid_gains([-float(random.uniform(60.0, 200.0))] * 3, mass)
    coulomb, viscous = 0.1 * force * random.random(), 0.1 * force * random.random() / limits.velocity
    width = 0.01 * limits.velocity
    length = limits.travel[1] - limits.travel[0]
    return cogging.Model(
        axis=cogging.AxisParameters(
            mass=mass, viscous=viscous, coulomb=coulomb, coulomb_width=width, travel=list(limits.travel)
        ),
        effects=[cogging.effects.CableSpring(stiffness=0.1 * force / length, center=limits.travel[0])],
        encoder=cogging.EncoderParameters(resolution=1e-8 * length),
        noise=cogging.NoiseParameters(force=1e-3 * force),
        controller=cogging.PidParameters(
            sample_rate=float(random.choice([1000.0, 2500.0])),
            kp=kp,
            ki=ki,
            kd=kd,
            mass=mass,
            viscous=viscous,
            coulomb=coulomb,
            coulomb_width=width,
        ),
        controller_type="pid",
    )


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"velocity": 0.0}, "velocity: must be a number above 0"),
        ({"acceleration": "5"}, "acceleration: must be a number above 0"),
        ({"command": float("nan")}, "command: must be a number above 0"),
        ({"command": True}, "command: must be a number above 0"),
        ({"duration": 1.0}, "duration: must be from 2 to 600 s, got 1.0"),
        ({"travel": [0.4, 0.0]}, "travel: must be its lower and its upper end"),
        ({"travel": [0.4]}, "travel: must be its lower and its upper end"),
        ({"speed": 0.5}, "speed: is unknown"),
    ],
)
def test_a_limit_that_is_none_is_refused(change, said):
    with pytest.raises(FieldError, match=said):
        cogging.MotionLimits.from_dict(GOOD | change)


def test_what_may_be_left_out():
    for name in GOOD:
        rest = {key: value for key, value in GOOD.items() if key != name}
        if name in ("velocity", "acceleration", "duration"):
            with pytest.raises(FieldError, match=f"{name}: must be given, got nothing"):
                cogging.MotionLimits.from_dict(rest)
        else:
            assert cogging.MotionLimits.from_dict(rest).to_dict() == rest
    assert cogging.MotionLimits.from_dict(GOOD).to_dict() == GOOD


def test_a_file_says_where_it_is_wrong(tmp_path):
    file = tmp_path / "limits.toml"
    file.write_text("velocity = 0.5\nacceleration = -5.0\nduration = 4.0\n")
    with pytest.raises(InputError, match=r"limits\.toml: line 2: acceleration: must be a number above 0"):
        cogging.MotionLimits.read(file)


def test_the_model_fills_in_and_holds():
    random = np.random.default_rng(3)
    limits = drawn_limits(random)
    model = drawn_model(random, limits)
    low, high = limits.travel
    open_ended = cogging.MotionLimits(limits.velocity, limits.acceleration, 3.0)
    assert open_ended.of(model).travel == (low, high)
    assert open_ended.of(model).jerk == pytest.approx(100.0 * limits.acceleration)
    assert open_ended.of(model).command is None
    limited = model.replace(controller=model.controller.replace(command_limit=2.5))
    assert open_ended.of(limited).command == 2.5
    for wrong in ((low - 0.1, high), (low, high + 0.1)):
        with pytest.raises(FieldError, match="travel: must be inside the model's"):
            cogging.MotionLimits(limits.velocity, limits.acceleration, 3.0, travel=wrong).of(model)
    free = model.replace(axis=model.axis.replace(travel=[-np.inf, np.inf]), effects=())
    with pytest.raises(FieldError, match="travel: must be given where the model states none"):
        open_ended.of(free)


@pytest.mark.parametrize("kind", sorted(KINDS))
@pytest.mark.parametrize("seed", range(3))
def test_a_reference_keeps_to_its_limits_and_moves(kind, seed):
    random = np.random.default_rng([seed, *map(ord, kind)])
    limits = drawn_limits(random)
    chosen = [next(one for one in iter(lambda: drawn(random), None) if one.kind == kind)]
    chosen += [drawn(random) for _ in range(int(random.integers(0, 3)))]
    motion = planned(chosen, limits, rate=2000.0)
    samples = motion.samples
    time, position = samples["time"], samples["reference"]
    velocity, acceleration = samples["reference_velocity"], samples["reference_acceleration"]
    assert limits.duration - 1e-3 < time[-1] <= limits.duration
    assert np.abs(velocity).max() <= limits.velocity
    assert np.abs(acceleration).max() <= limits.acceleration
    assert np.abs(np.diff(acceleration) / np.diff(time)).max() <= limits.jerk
    assert limits.travel[0] < position.min()
    assert position.max() < limits.travel[1]
    assert (velocity[[0, -1]] == 0.0).all()
    assert (acceleration[[0, -1]] == 0.0).all()
    assert np.mean(np.abs(velocity) > 2e-4 * limits.velocity) > 0.1
    covered = position[0] + np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * np.diff(time))])
    assert np.abs(covered - position).max() < 2e-4 * (limits.travel[1] - limits.travel[0])


@pytest.mark.parametrize("seed", range(6))
def test_the_machine_keeps_to_the_limits(seed):
    """Of what is taken to be feasible, by a look of one's own at the simulated run."""
    random = np.random.default_rng([seed, 1])
    limits = drawn_limits(random)
    model = drawn_model(random, limits)
    command = float(random.uniform(0.3, 2.0)) * model.axis.mass * limits.acceleration
    limits = cogging.MotionLimits(**{**limits.to_dict(), "travel": limits.travel, "command": command})
    found = Machine(None, limits, seed).run(model, [drawn(random), drawn(random)])
    if found is None:
        assert command < 0.7 * model.axis.mass * limits.acceleration  # a spring and friction take their part
        return
    log = cogging.simulate(model, found.motion, seed=seed)
    assert np.abs(log.command).max() <= command
    assert np.abs(log.true_velocity).max() <= limits.velocity
    assert limits.travel[0] <= log.true_position.min()
    assert log.true_position.max() <= limits.travel[1]
    stop = log.true_velocity * np.abs(log.true_velocity) / (2.0 * limits.acceleration)
    assert limits.travel[0] <= (log.true_position + stop).min()
    assert (log.true_position + stop).max() <= limits.travel[1]


def test_each_limit_that_is_exceeded_is_seen():
    random = np.random.default_rng(5)
    limits = drawn_limits(random)
    motion = planned([SURVEY], limits, rate=1000.0)
    log = cogging.simulate(drawn_model(random, limits), motion)
    loose = {**limits.to_dict(), "travel": limits.travel, "command": 1e9}
    taken = taken_of(motion, log, cogging.MotionLimits(**loose))
    assert all(0.0 < share <= 1.0 for key, share in taken.items() if key != "acceleration"), taken
    low, high = limits.travel
    tight = {"travel": (low + 0.1 * (high - low), high), "command": 0.5 * float(np.abs(log.command).max())}
    tight |= {key: 0.7 * getattr(limits, key) for key in ("velocity", "acceleration", "jerk")}
    tight["duration"] = motion.end - 0.01
    for name, value in tight.items():
        assert taken_of(motion, log, cogging.MotionLimits(**{**loose, name: value}))[name] > 1.0, name


def test_a_motion_that_a_log_followed_is_known():
    random = np.random.default_rng(6)
    limits = drawn_limits(random)
    model = drawn_model(random, limits)
    motions = [planned([drawn(random), drawn(random)], limits, rate=1000.0) for _ in range(3)]
    for one in motions:
        log = cogging.simulate(model, one, seed=3)
        assert [is_known(other, [log]) for other in motions] == [other is one for other in motions]
        bare = cogging.Log(log.time, log.position, log.command)
        assert is_known(one, [bare])
    assert not is_known(motions[0], [])
