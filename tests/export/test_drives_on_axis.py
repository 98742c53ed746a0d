"""The exported table at work: feedforward of a drive on a simulated axis, whose controller then has less to do."""

import numpy as np
import pytest

import cogging
from tests.fixtures.drives import READERS

RATE = 5000.0
FORMS = {"csv": "linear", "akd": "linear", "sinamics": "linear", "novanta": "linear"}
FORMS |= {"odrive": "rotary", "moteus": "rotary", "ax8000": "rotary"}


class UnderADrive:
    """A PID whose drive adds its table to the command: of what is applied, `own` is the PID's part."""

    sample_rate = RATE

    def __init__(self, feedforward, gain, rows=8000):
        self.feedforward, self.gain = feedforward, gain
        self.own = np.zeros(rows)
        self.reset()

    def __deepcopy__(self, memo):
        return self  # what its PID did is read after the run

    def reset(self):
        self.total, self.before, self.row = 0.0, None, 0

    def command(self, reference, reading):
        bandwidth = 2 * np.pi * 150.0
        error = reading - reference.position
        self.total += error / RATE
        rate = 0.0 if self.before is None else (error - self.before) * RATE
        self.before = error
        pid = -self.gain * (bandwidth**2 * error + 0.3 * bandwidth**3 * self.total + 1.8 * bandwidth * rate)
        self.own[self.row] = pid
        self.row += 1
        return pid + float(self.feedforward(reading))


def machine(form, seed):
    """Model, options of the export, and the motion: slow, over as much as shows the shape of the map."""
    rng = np.random.default_rng([seed, len(form)])
    size = 10 ** rng.uniform(-1.0, 1.0)
    turn = 2 * np.pi if FORMS[form] == "rotary" else 0.0
    pitch = turn or float(rng.uniform(0.02, 0.06))
    times = [7 * int(rng.integers(3, 6)), 84] if turn else [1, int(rng.integers(2, 4))]
    span = 0.4 if turn else 2.0 * pitch
    start = float(rng.uniform(0.1, 0.3))
    basis = cogging.SplineHarmonics(pitch=pitch, harmonics=times)
    sine, cosine = size * rng.normal(size=(2, 2, 1)) * [[1.0], [0.3]]
    travel = [-np.inf, np.inf] if turn else [start - 0.2 * pitch, start + span + 0.2 * pitch]
    axis = cogging.AxisParameters(mass=0.01 * size / span, travel=travel)
    model = cogging.Model(axis, cogging=cogging.CoggingModel(basis, sine, cosine))
    if seed == 2:  # as a diagnosis patches it
        found = cogging.effects.CoggingHarmonic(period=pitch / (35 if turn else 4), sine=0.2 * size, cosine=0.1 * size)
        model = model.replace(effects=[found])
    options = {"scale": 1.0 / size, "sign": int(rng.choice([-1, 1])), "zero": float(rng.uniform(-0.1, 0.1))}
    options["reverse"] = bool(rng.integers(2))
    options |= {"turn": turn} if turn else {}
    options |= {"entries": 256} if form == "novanta" else {}
    motion = {"type": "point_to_point", "start": start, "distance": span, "velocity": 0.8 * span, "dwell": 0.05}
    motion |= {"acceleration": 16.0 * span, "jerk": 1000.0 * span, "repeats": 1}
    return model, options, motion


class Sitting:
    """How the drive sits on the motor."""

    def __init__(self, model, options):
        self.model, self.options, self.turn = model, options, options.get("turn", 0.0)
        self.pitch, self.pairs = model.cogging.basis.pitch, 1

    def place(self, position):
        return (-1 if self.options["reverse"] else 1) * (position - self.options["zero"])

    def drive_travel(self):
        return sorted(self.place(end) for end in self.model.axis.travel)

    def electrical_period(self):
        return self.pitch

    def feedforward(self, drive, sign):
        pushes = (-1 if self.options["reverse"] else 1) * sign / self.options["scale"]
        return lambda position: pushes * drive.adds(self.place(position))


def work(model, motion, feedforward):
    """What the PID did, V, the position and the error, row by row of the motion."""
    mine = UnderADrive(feedforward, model.axis.mass)
    log = cogging.simulate(model, motion, controller=mine, duration=1.2)
    rows = (log.time > 0.1) & (log.time < 1.15)
    return mine.own[: len(log)][rows], log.position[rows], log.error[rows]


def force_of(model):
    """F_cogging with what an effect adds to it."""
    return lambda x: model.cogging.force(x) - sum(one.force_at(position=x) for one in model.effects)


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("form", FORMS)
def test_the_controller_is_left_with_what_the_drive_cannot_hold(form, seed):
    """Beside the same axis without cogging, the PID makes up for the cogging less what the drive adds."""
    model, options, motion = machine(form, seed)
    exported = cogging.export.to(model, form, **options)
    sitting = Sitting(model, options)
    drive = READERS[form](exported, sitting)
    right = sitting.feedforward(drive, options["sign"])
    smooth, _, error_smooth = work(model.replace(cogging=None, effects=[]), motion, lambda _: 0.0)

    alone, positions, error_alone = work(model, motion, lambda _: 0.0)
    force = force_of(model)
    assert rms(alone - smooth) == pytest.approx(rms(force(positions)), rel=0.1)

    helped, positions, error_helped = work(model, motion, right)
    # What was read at the start of a sample acts until its end: half a sample late.
    left = rms(force(0.5 * (positions[1:] + positions[:-1])) - right(positions[:-1]))
    assert 0.7 * left < rms(helped - smooth) < 1.3 * left
    assert rms(helped - smooth) < 0.05 * rms(alone - smooth)
    # Steps of held entries are quicker than the cogging: the loop forgives them less.
    assert rms(error_helped - error_smooth) < 0.3 * rms(error_alone - error_smooth)

    wrong, *_ = work(model, motion, sitting.feedforward(drive, -options["sign"]))
    assert rms(wrong - smooth) == pytest.approx(2.0 * rms(alone - smooth), rel=0.05)
