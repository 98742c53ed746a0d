"""A column that was read as something else is reported with a remedy; a log that was read right never is.

The machines lack what makes most of the command, their models know mass and friction within a factor of three.
"""

import functools
from dataclasses import replace

import numpy as np
import pytest

import cogging
from cogging import Log, Model, effects
from cogging.files import InputError
from cogging.identification.misreading import misreading
from tests.fixtures import moving_axis
from tests.fixtures.identify_coverage import Case
from tests.fixtures.measured import emps_log, emps_model

#: What a machine has and its model lacks.
MISSING = ["nothing", "harmonics", "spring", "gravity", "stribeck", "friction", "drag", "resonance", "payload", "lag"]
MISSING += ["delay", "backlash", "dropped rows", "tone"]


def moved(kind, random, time, length):
    """Positions of "strokes", a "multisine" or "slow" moves over a travel of `length` (m)."""
    if kind == "multisine":
        frequencies = random.uniform(0.1, 4.0, 9)
        phases = random.uniform(0.0, 2 * np.pi, 9)
        waves = np.sin(2 * np.pi * frequencies[:, None] * time + phases[:, None]) / (0.5 + frequencies[:, None])
        position = np.sum(waves, axis=0) * np.clip(time, 0.0, 1.0) ** 2
        return 0.45 * length * position / np.abs(position).max()
    position, at, now = np.zeros(len(time)), 0.0, 0.1
    while now < time[-1]:
        goal = length * random.uniform(-0.5, 0.5)
        if kind == "slow":
            goal = length * (0.5 if at <= 0.0 else -0.5)
        mean = length * float(np.exp(random.uniform(*np.log([0.15, 0.4] if kind == "slow" else [0.2, 1.5]))))
        duration = abs(goal - at) / mean + 0.15
        s = np.clip((time - now) / duration, 0.0, 1.0)
        position += (goal - at) * s**3 * (10 - 15 * s + 6 * s * s)
        at, now = goal, now + duration + random.uniform(0.0, 0.2)
    return position


@functools.cache
def drawn(seed, missing, motion, *, with_reference=None):
    """A machine, its log and a model that knows mass and friction within a factor of three, and nothing else."""
    random = np.random.default_rng([17, seed])
    rate = float(np.round(10.0 ** random.uniform(2.0, 4.0)))
    time = np.arange(int(min(random.uniform(8.0, 20.0), 40_000 / rate) * rate)) / rate
    length, mass = 10.0 ** random.uniform(-2.0, 1.5), 10.0 ** random.uniform(-4.0, 2.5)
    position = moved(motion, random, time, length)
    speed, acceleration = np.gradient(position, time), np.gradient(np.gradient(position, time), time)
    inertial = mass * float(np.std(acceleration))
    top = float(np.abs(speed).max())
    viscous = inertial * 10.0 ** random.uniform(-1.0, 0.5) / float(np.std(speed))
    coulomb = inertial * 10.0 ** random.uniform(-1.0, 0.8)
    width = top * 10.0 ** random.uniform(-3.0, -1.5)
    usual = float(np.sqrt(np.mean((mass * acceleration + viscous * speed + coulomb * np.tanh(speed / width)) ** 2)))
    share = random.uniform(0.3, 0.95)
    force = usual * share / (1.0 - share)
    axis = cogging.AxisParameters(mass=mass, viscous=viscous, coulomb=coulomb, coulomb_width=width)
    hidden, rate_of_loop = lacking(missing, random, force, length, top, viscous), min(0.12 * rate, 80.0)
    real = axis.replace(mass=mass * random.choice([1 / 3, 3.0])) if missing == "payload" else axis
    kp, ki, kd = cogging.pid_gains([-random.uniform(0.4, 1.0) * rate_of_loop] * 3, real.mass)
    controller = cogging.PidParameters(
        sample_rate=rate, kp=kp, ki=ki, kd=kd, mass=float(random.choice([0.0, real.mass])), coulomb_width=width
    )
    machine = Model(
        axis=real,
        effects=tuple(hidden),
        encoder=cogging.EncoderParameters(resolution=length * 10.0 ** random.uniform(-6.0, -3.5)),
        noise=cogging.NoiseParameters(force=usual * 10.0 ** random.uniform(-3.0, -1.3), bandwidth=40.0),
        controller=controller,
        controller_type="pid",
    )
    log = cogging.simulate(machine, cogging.Sampled(time, position, None, None), seed=seed, duration=float(time[-1]))
    if missing == "dropped rows":
        keep = random.random(len(log)) >= random.uniform(0.01, 0.1)
        log = Log.of({name: column[keep] for name, column in log.columns().items()})
    wrong = np.exp(random.uniform(-1.0, 1.0, 3) * np.log(3.0 if random.random() < 0.7 else 1.05))
    believed = axis.replace(mass=mass * wrong[0], viscous=viscous * wrong[1], coulomb=coulomb * wrong[2])
    stated = {"controller": controller, "controller_type": "pid"} if random.random() < 0.3 else {}
    model = Model(axis=believed, encoder=machine.encoder, **stated)
    if not (random.random() < 0.5 if with_reference is None else with_reference):
        log = Log(log.time, log.position, log.command)
    return Case(machine, model, log)


def lacking(missing, random, force, length, top, viscous):
    """Effects that make about `force` (V, rms) of the command."""
    draw, phase = random.uniform, random.uniform(0.0, 2 * np.pi)
    sine, cosine = np.sqrt(2.0) * force * np.array([np.sin(phase), np.cos(phase)])
    period = length / draw(1.0, 30.0)
    nodes, levels = length * np.linspace(-0.5, 0.5, 5), force * draw(0.2, 1.5, 5)
    return {
        "harmonics": [
            effects.CoggingHarmonic(period=period, sine=sine, cosine=cosine),
            effects.CoggingHarmonic(period=period / random.integers(2, 5), sine=0.4 * cosine, cosine=0.4 * sine),
        ],
        "spring": [effects.CableSpring(stiffness=4.0 * force / length, center=length * draw(-0.3, 0.3))],
        "gravity": [effects.ConstantForce(force=force * random.choice([-1.0, 1.0]))],
        "stribeck": [effects.StribeckFriction(static_excess=force, velocity=top * draw(0.03, 0.3))],
        "friction": [
            effects.PositionDependentFriction(nodes=nodes, levels=levels),
            effects.CoulombAsymmetry(difference=0.5 * force),
        ],
        "drag": [effects.QuadraticDrag(coefficient=6.0 * force / top**2), effects.ViscousAsymmetry(difference=viscous)],
        "resonance": [
            effects.FlexibleMode(frequency=draw(3, 60), damping_ratio=draw(5e-3, 0.1), mass_ratio=draw(0.3, 0.7))
        ],
        "lag": [effects.ActuatorLag(time_constant=draw(1e-3, 5e-3))],
        "delay": [effects.CommandDelay(delay=draw(0.5e-3, 4e-3))],
        "backlash": [effects.Backlash(gap=length * draw(3e-3, 3e-2), mass_ratio=draw(0.2, 0.6))],
        "tone": [effects.DisturbanceTone(frequency=draw(0.5, 20.0), sine=sine, cosine=cosine)],
    }.get(missing, [])


def times(factor, *names):
    """Columns with some of them times a factor."""
    return lambda case, columns: columns | {name: factor * columns[name] for name in names if name in columns}


def swapped(one, other):
    return lambda case, columns: columns | {one: columns[other], other: columns[one]}


POSITIONS = ("position", "reference", "reference_velocity", "reference_acceleration")
#: What may be wrong with a log: the column of the answer, and the columns that are read. The command is moved apart.
WRONG = {
    "sign of command": ("command", times(-1.0, "command")),
    "sign of position": ("position", times(-1.0, "position")),
    "sign of reference": ("reference", times(-1.0, *POSITIONS[1:])),
    "thousandths": ("command", times(1e3, "command")),
    "percent": ("command", times(100.0, "command")),
    "volts for newtons": ("command", times(1 / 35.15, "command")),
    "mm": ("position", times(1e3, *POSITIONS)),
    "degrees": ("position", times(180 / np.pi, *POSITIONS)),
    "counts": (
        "position",
        lambda case, columns: columns | {"position": np.round(case.log.position / case.nominal.encoder.resolution)},
    ),
    "ms": ("time", times(1e3, "time")),
    "us": ("time", times(1e6, "time")),
    "sample number": ("time", lambda case, columns: columns | {"time": np.arange(len(case.log)) * 1.0}),
    "position and command": ("position", swapped("position", "command")),
    "position and reference": ("position", swapped("position", "reference")),
    "reference as position": ("position", lambda case, columns: columns | {"position": columns["reference"]}),
    "reference alone as position": (
        "position",
        lambda case, columns: {
            "time": columns["time"],
            "command": columns["command"],
            "position": columns["reference"],
        },
    ),
    "velocity as position": (
        "position",
        lambda case, columns: columns | {"position": np.gradient(case.log.position, case.log.time)},
    ),
    "command late": ("command", None),
    "command early": ("command", None),
}
MISREADINGS = {kind: column for kind, (column, _) in WRONG.items()}


def misread(kind, case, seconds=0.1):
    """The log of a case read wrongly, or None where it lacks the column; seconds: by which a command is moved."""
    columns = case.log.columns()
    if "reference" in kind and "reference" not in columns:
        return None
    if kind in ("command late", "command early"):
        moved = max(1, round(seconds / float(np.median(np.diff(case.log.time)))))
        first, last = slice(0, -moved), slice(moved, None)
        command, others = (first, last) if kind == "command late" else (last, first)
        return Log.of({name: column[command if name == "command" else others] for name, column in columns.items()})
    return Log.of(WRONG[kind][1](case, columns))


@pytest.mark.parametrize("missing", MISSING)
def test_a_log_read_right_is_not_doubted(missing):
    for seed, motion in ((59, "multisine"), (45, "slow")):
        case = drawn(seed, missing, motion)
        assert misreading([case.log], case.nominal) is None, (missing, motion)


@pytest.mark.parametrize(("seed", "motion"), [(48, "multisine"), (58, "slow"), (134, "slow")])
def test_nor_is_one_with_a_tone_whose_phase_a_shift_of_the_command_would_explain(seed, motion):
    case = drawn(seed, "tone", motion)
    assert misreading([case.log], case.nominal) is None


@pytest.mark.parametrize(("amplitude", "pole"), [(0.3, 3.45), (0.3, 9.0), (1.0, 5.0), (1.0, 20.0)])
def test_nor_is_one_that_cogging_drives_back_and_forth(amplitude, pole):
    """Under a soft loop the command follows the axis; but it does work, as no command of the other sign does."""
    axis = cogging.AxisParameters(mass=0.005, viscous=0.01, coulomb=0.2, coulomb_width=0.01)
    model = Model(axis=axis, encoder=cogging.EncoderParameters(resolution=2e-4))
    gains = dict(zip(("kp", "ki", "kd"), cogging.pid_gains([-pole] * 3, axis.mass), strict=True))
    machine = model.replace(
        effects=[effects.CoggingHarmonic(period=2.0 * np.pi / 11, sine=amplitude)],
        noise=cogging.NoiseParameters(force=0.005, bandwidth=8.0),
        controller=cogging.PidParameters(sample_rate=500.0, **gains),
        controller_type="pid",
    )
    motion = {"type": "point_to_point", "distance": 3.0, "velocity": 0.5, "acceleration": 5.0, "jerk": 500.0}
    log = cogging.simulate(machine, motion)
    assert misreading([Log(log.time, log.position, log.command)], model) is None


#: What two machines lack and how they move, by seed.
PLAIN = {59: ("nothing", "strokes"), 45: ("spring", "multisine")}


def judge(kind, case):
    """right, wrong or nothing: the column of the answer, or of one that this log does not tell from it."""
    log = misread(kind, case)
    try:
        cogging.check_against_model(log, case.nominal)
    except InputError:  # refused for its units
        return "right"
    found = misreading([log], case.nominal)
    if found is None:
        return "nothing"
    options = [found.column, *(option.split()[1] for option in found.alternatives)]
    return "right" if any(option.startswith(MISREADINGS[kind]) for option in options) else "wrong"


@pytest.mark.parametrize("kind", MISREADINGS)
def test_a_misreading_is_found(kind):
    """Where the motion is rich, in both logs; a command that lies a tenth of a second off its rows in one."""
    answers = [judge(kind, drawn(seed, *which, with_reference=True)) for seed, which in PLAIN.items()]
    assert "wrong" not in answers, answers
    assert answers.count("right") >= (1 if kind.startswith("command") else 2), answers


@pytest.mark.data
def test_volts_for_newtons_on_a_real_machine():
    model, log = emps_model(controller=False), emps_log()
    assert misreading([log], model) is None
    found = misreading([replace(log, command=log.command / 35.15)], model)
    assert (found.column, found.misreading) == ("command", "scale")
    assert found.factor == pytest.approx(35.15, rel=0.05)
    assert found.explained_otherwise > 0.98 > 0.2 > found.explained


@pytest.fixture(scope="module")
def right():
    log = moving_axis.record(moving_axis.machine(), 3)
    return Log(log.time, log.position, log.command, log.reference)


def test_the_report_names_log_column_remedy_and_shares(right):
    wrong = replace(right, command=-right.command)
    found = misreading([right, wrong], moving_axis.machine(), ["a.csv", "b.csv"])
    assert (found.logs, found.column, found.misreading, found.factor) == (("b.csv",), "command", "sign", -1.0)
    assert found.option == "--scale b.csv:command=-1"
    assert found.explained < 0.1 < 0.9 < found.explained_otherwise <= 1.0
    assert "b.csv: command has the opposite sign" in found.text
    fit = cogging.identify([right, wrong], moving_axis.machine(), names=["a.csv", "b.csv"], free=["axis.mass"])
    assert any("b.csv: command has the opposite sign" in note for note in fit.notes), fit.notes
    both = misreading([wrong, wrong], moving_axis.machine())
    assert (both.logs, both.option) == (("log 1", "log 2"), "--scale command=-1")


@pytest.mark.parametrize("rows", [3, -40])
def test_a_shift_is_reported_in_rows_where_the_controller_is_known(right, rows):
    log = replace(right, command=np.roll(right.command, rows))[abs(rows) : -abs(rows)]
    found = misreading([log], moving_axis.machine())
    assert (found.misreading, found.rows, found.option) == ("shift", rows, "")
    assert f"{abs(rows)} rows" in found.text
    assert ("late" in found.text) == (rows > 0)
