"""A column that was read as something else is reported with a remedy; a log that was read right never is.

The machines lack what makes most of the command, their models know mass and friction within a factor of three.
"""

import functools
from dataclasses import dataclass, replace

import numpy as np
import pytest

import cogging
from cogging import Log, Model, effects
from cogging.files import InputError
from cogging.identification.misreading import misreading
from tests.fixtures import moving_axis
from tests.fixtures.measured import emps_log, emps_model

#: What a machine has and its model lacks.
MISSING = ["nothing", "harmonics", "spring", "gravity", "friction", "drag", "resonance", "payload", "delay", "backlash"]
MISSING += ["dropped rows", "tone"]


@dataclass(frozen=True)
class Unlike:
    """A model, and the log of a machine that it is not."""

    model: Model
    log: Log


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
    seconds = min(random.uniform(8.0, 20.0), 40_000 / rate)
    time = np.arange(int(seconds * rate)) / rate
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
    return Unlike(model, log)


def lacking(missing, random, force, length, top, viscous):
    """Effects that make about `force` (V, rms) of the command."""
    phase, root = random.uniform(0.0, 2 * np.pi), np.sqrt(2.0)
    sine, cosine = root * force * np.sin(phase), root * force * np.cos(phase)
    if missing == "harmonics":
        period = length / random.uniform(1.0, 30.0)
        second = {"sine": 0.4 * cosine, "cosine": 0.4 * sine}
        first = effects.CoggingHarmonic(period=period, sine=sine, cosine=cosine)
        return [first, effects.CoggingHarmonic(period=period / int(random.integers(2, 5)), **second)]
    if missing == "spring":
        return [effects.CableSpring(stiffness=4.0 * force / length, center=length * random.uniform(-0.3, 0.3))]
    if missing == "gravity":
        return [effects.ConstantForce(force=force * random.choice([-1.0, 1.0]))]
    if missing == "friction":
        if random.random() < 0.5:
            return [effects.StribeckFriction(static_excess=force, velocity=top * random.uniform(0.03, 0.3))]
        nodes = length * np.linspace(-0.5, 0.5, 5)
        levels = force * random.uniform(0.2, 1.5, 5)
        return [
            effects.PositionDependentFriction(nodes=nodes.tolist(), levels=levels.tolist()),
            effects.CoulombAsymmetry(difference=0.5 * force),
        ]
    if missing == "drag":
        drag = effects.QuadraticDrag(coefficient=6.0 * force / top**2)
        return [drag, effects.ViscousAsymmetry(difference=viscous)]
    if missing == "resonance":
        return [
            effects.FlexibleMode(
                frequency=random.uniform(3.0, 60.0),
                damping_ratio=random.uniform(0.005, 0.1),
                mass_ratio=random.uniform(0.3, 0.7),
            )
        ]
    if missing == "delay":
        if random.random() < 0.5:
            return [effects.ActuatorLag(time_constant=random.uniform(1e-3, 5e-3))]
        return [effects.CommandDelay(delay=random.uniform(0.5e-3, 4e-3))]
    if missing == "backlash":
        return [effects.Backlash(gap=length * random.uniform(3e-3, 3e-2), mass_ratio=random.uniform(0.2, 0.6))]
    if missing == "tone":
        return [effects.DisturbanceTone(frequency=random.uniform(0.5, 20.0), sine=sine, cosine=cosine)]
    return []


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
        lambda case, columns: columns | {"position": np.round(case.log.position / case.model.encoder.resolution)},
    ),
    "ms": ("time", times(1e3, "time")),
    "us": ("time", times(1e6, "time")),
    "sample number": ("time", lambda case, columns: columns | {"time": np.arange(len(case.log)) * 1.0}),
    "position and command": ("position", swapped("position", "command")),
    "position and reference": ("position", swapped("position", "reference")),
    "reference as position": ("position", lambda case, columns: columns | {"position": columns["reference"]}),
    "reference alone as position": (
        "position",
        lambda case, columns: (
            {name: columns[name] for name in ("time", "command")} | {"position": columns["reference"]}
        ),
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


RATE, MASS, TURNS = 500.0, 0.005, 11


def rotary_model():
    """Mass and friction of the axes, which is all that their user knows."""
    axis = cogging.AxisParameters(mass=MASS, viscous=0.01, coulomb=0.2, coulomb_width=0.01)
    return cogging.Model(axis=axis, encoder=cogging.EncoderParameters(resolution=2e-4))


def rotary_speeds(random, seconds):
    """Speeds of moves of 0.5 and 0.25 rad/s by turns, over equal distances, with or without a way back."""
    time, speed = np.arange(int(seconds * RATE)) / RATE, np.zeros(int(seconds * RATE))
    distance, rise, rest = random.uniform(0.5, 4.0), random.uniform(0.01, 0.3), random.uniform(0.0, 0.5)
    back, start, count = random.random() < 0.6, 0.3, 0
    while start < seconds:
        top = (0.5, 0.25)[count % 2]
        stop = start + distance / top
        way = -1.0 if back and count // 2 % 2 else 1.0
        speed += way * top * np.clip(np.minimum(time - start, stop - time) / rise, 0.0, 1.0)
        start, count = stop + rest, count + 1
    return speed


def rotary_logs(seed, amplitudes, poles, seconds=14.0):
    """Logs of axes with a cogging of these amplitudes (A), 11 a turn, under loops of these triple poles (1/s)."""
    random, found = np.random.default_rng([33, seed]), []
    for amplitude, pole in zip(amplitudes, poles, strict=True):
        phase, speed = random.uniform(0.0, 2.0 * np.pi), rotary_speeds(random, seconds)
        wave = {"sine": amplitude * np.cos(phase), "cosine": amplitude * np.sin(phase)}
        gains = dict(zip(("kp", "ki", "kd"), cogging.pid_gains([-pole] * 3, MASS), strict=True))
        machine = rotary_model().replace(
            effects=[cogging.effects.CoggingHarmonic(period=2.0 * np.pi / TURNS, **wave)],
            noise=cogging.NoiseParameters(force=0.005, bandwidth=8.0),
            controller=cogging.PidParameters(sample_rate=RATE, **gains),
            controller_type="pid",
        )
        reference = cogging.Sampled(np.arange(len(speed)) / RATE, np.cumsum(speed) / RATE, None, None)
        log = cogging.simulate(machine, reference, seed=seed, duration=seconds - 1.0 / RATE)
        found.append(cogging.Log(log.time, log.position, log.command))
    return found


def find(log, model):
    """The misreading; "refused" where the log is refused for its units."""
    try:
        cogging.check_against_model(log, model)
    except InputError:
        return "refused"
    return misreading([log], model)


@pytest.mark.parametrize("missing", MISSING)
def test_a_log_read_right_is_not_doubted(missing):
    for seed, motion in ((59, "multisine"), (45, "slow")):
        case = drawn(seed, missing, motion)
        assert misreading([case.log], case.model) is None, (missing, motion)


def test_nor_is_one_that_cogging_drives_back_and_forth():
    """Under a soft loop the command follows the axis; but it does work, as no command of the other sign does."""
    for log in rotary_logs(0, [0.3, 0.3, 1.0, 1.0], [3.45, 9.0, 5.0, 20.0]):
        assert misreading([log], rotary_model()) is None


#: What two machines lack and how they move, by seed.
PLAIN = {59: ("nothing", "strokes"), 45: ("spring", "multisine")}


def judge(kind, case):
    """right, wrong or nothing: the column of the answer, or of one that this log does not tell from it."""
    found = find(misread(kind, case), case.model)
    if found == "refused":
        return "right"
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
