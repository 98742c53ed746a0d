"""Recognise the motion of a log: rest, sine, point-to-point moves, or samples."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cogging._core import PointToPoint, PointToPointParameters
from cogging.arrays import FloatArray
from cogging.model.units import Units

REST = 0.02  # of the top speed: slower is rest
STILL = 3.0  # quanta within a window: less is rest
WINDOW = 0.004  # of a log, over which a speed is estimated
SINE = 0.05  # of its amplitude: largest rms residual of a sine
FEWEST_PERIODS = 1.0
SAME = 0.03  # of their length or time, by which moves there and back may differ
SHAPE = 0.01  # of its length: largest rms residual of a jerk-limited move
ROWS_OF_MOVE = 400
NO_JERK = 0.02  # of a ramp's time, in which the jerk acts: less counts as unlimited jerk


@dataclass(frozen=True)
class Motion:
    """The recognised motion of a log."""

    kind: str  # rest, sine, point_to_point or sampled
    description: str  # in words
    fields: Mapping[str, float] = field(default_factory=dict)  # of the reference file's type
    left: float = 0.0  # rms residual of the motion with these fields, m
    moves: int = 0  # number of moves between rests


def motion_of_log(time: FloatArray, position: FloatArray, quantum: float, units: Units) -> Motion:
    """Recognise a motion from the reference of a log, or else its position (`quantum`: of the readings, m)."""
    t, span = time - time[0], float(np.ptp(position))
    if span <= STILL * quantum or span == 0.0:
        return Motion("rest", f"it rests: {span:.3g} {units.position} from end to end")
    half = max(1, round(0.5 * WINDOW * len(t)))
    rows = np.arange(len(t))
    before, after = np.maximum(rows - half, 0), np.minimum(rows + half, len(t) - 1)
    speed = np.abs(position[after] - position[before]) / (t[after] - t[before])
    still = max(REST * float(np.quantile(speed, 0.99)), STILL * quantum / (2.0 * half * float(np.median(np.diff(t)))))
    edges = np.flatnonzero(np.diff(np.concatenate([[False], speed > still, [False]]).astype(np.int8)))
    pairs = zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True)  # first and last row between two rests
    moves = [(a, b) for a, b in pairs if abs(position[b] - position[a]) > SAME * span and b - a > 4]
    seen = [_sine(t, position, units), _point_to_point(t, position, moves, units) if moves else None]
    found = [motion for motion in seen if motion is not None]
    if found:
        return min(found, key=lambda motion: motion.left)
    parts = f"{len(moves)} moves between rests" if moves else "no rests"
    said = f"{parts}, not there and back with one length, profile and rest: kept as samples"
    return Motion("sampled", said, moves=len(moves))


def _sine(t: FloatArray, x: FloatArray, units: Units) -> Motion | None:
    """Fit a sine about a center; None if it does not fit."""
    from scipy.optimize import minimize_scalar

    y = np.interp(np.linspace(0.0, t[-1], min(len(t), 8192)), t, x)
    power = np.abs(np.fft.rfft((y - y.mean()) * np.hanning(len(y)))) ** 2
    peak = int(np.argmax(power[1:])) + 1
    every = max(1, len(t) // 4000)
    t, x = t[::every], x[::every]

    def left(frequency: float) -> tuple[float, FloatArray]:
        phase = 2.0 * np.pi * frequency * t
        columns = np.column_stack([np.ones(len(t)), np.sin(phase), np.cos(phase)])
        weights = np.linalg.lstsq(columns, x, rcond=None)[0]
        return float(np.sqrt(np.mean((x - columns @ weights) ** 2))), np.asarray(weights)

    low, high = max(peak - 1.0, 0.3) / t[-1], (peak + 1.0) / t[-1]
    frequency = float(minimize_scalar(lambda f: left(f)[0], bounds=(low, high), method="bounded").x)
    rms, weights = left(frequency)
    amplitude = float(np.hypot(weights[1], weights[2]))
    if rms > SINE * amplitude or frequency * t[-1] < FEWEST_PERIODS:
        return None
    fields = {"center": _round(float(weights[0]), amplitude), "amplitude": _round(amplitude, amplitude)}
    fields["frequency"] = float(f"{frequency:.4g}")
    text = "a sine of amplitude {amplitude:.4g} {m} at {frequency:.4g} Hz about {center:.4g} {m}"
    return Motion("sine", text.format(**fields, m=units.position), fields, rms)


def _point_to_point(t: FloatArray, x: FloatArray, moves: list[tuple[int, int]], units: Units) -> Motion | None:
    """Fit moves there and back of one length and profile, or one move; None if they do not fit."""
    edges = [0, *(row for move in moves for row in move), len(x) - 1]
    levels = [float(np.median(x[a : b + 1])) for a, b in zip(edges[::2], edges[1::2], strict=True)]  # at rest
    lengths = np.diff(levels)
    distance = float(np.median(np.abs(lengths))) * math.copysign(1.0, lengths[0])
    turns = np.sign(lengths) == np.sign(distance) * (-1.0) ** np.arange(len(lengths))
    if not turns.all() or np.any(np.abs(np.abs(lengths) - abs(distance)) > SAME * abs(distance)):
        return None
    rests = [0, *((b + a) // 2 for (_, b), (a, _) in itertools.pairwise(moves)), len(t) - 1]
    chosen = min(1, len(moves) - 1)  # the second, whose start is in the log for certain
    shape = _shape(t, x, moves[chosen], (rests[chosen], rests[chosen + 1]), abs(distance))
    if shape is None or shape[3] > SHAPE * abs(distance):
        return None
    velocity, acceleration, jerk, left = shape
    limits: dict[str, Any] = {"velocity": velocity, "acceleration": acceleration, "jerk": jerk}
    course = PointToPoint(PointToPointParameters(distance=abs(distance), **limits))
    ways = [x[a : b + 1] * np.sign(x[b] - x[a]) for a, b in moves]
    middles = np.array([t[a + int(np.argmax(y > 0.5 * (y[0] + y[-1])))] for (a, _), y in zip(moves, ways, strict=True)])
    # Every move must have this profile, about its own middle.
    for (a, b), middle in zip(moves, middles.tolist(), strict=True):
        rows = np.unique(np.linspace(a, b, ROWS_OF_MOVE).astype(int))
        times = np.clip(t[rows] - middle + 0.5 * course.move_time, 0.0, course.move_time)
        off = course.sample(times)[0] - np.abs(x[rows] - x[a])
        if float(np.sqrt(np.mean(off**2))) > left + SHAPE * abs(distance):
            return None
    # The rest: from middle to middle less the move time; of one move, to the end of the log.
    passed = np.diff(middles) if len(moves) > 1 else t[-1:]
    between = float(np.median(passed))
    if np.abs(passed - between).max() > SAME * between:
        return None
    dwell = max(between - course.move_time, 0.0)
    fields = {"start": _round(levels[0], distance), "distance": _round(distance, distance)}
    fields |= {"velocity": float(f"{velocity:.3g}"), "acceleration": float(f"{acceleration:.3g}")}
    fields |= {"jerk": float(f"{jerk:.2g}")} if math.isfinite(jerk) else {}
    fields |= {"dwell": float(f"{dwell:.3g}"), "repeats": max(1, (len(moves) + 1) // 2)}
    of, length = units.of, f"{abs(distance):.4g} {units.position}"
    text = f"{len(moves)} moves of {length} there and back" if len(moves) > 1 else f"one move of {length}, one way"
    text += f", {velocity:.3g} {of('m/s')}, {acceleration:.3g} {of('m/s^2')}, "
    text += f"about {jerk:.2g} {of('m/s^3')}" if math.isfinite(jerk) else "no limit on the jerk"
    text += f", rests of {dwell:.3g} s" * (len(moves) > 1)
    return Motion("point_to_point", text, fields, left, len(moves))


def _shape(
    t: FloatArray, x: FloatArray, move: tuple[int, int], within: tuple[int, int], distance: float
) -> tuple[float, float, float, float] | None:
    """Velocity, acceleration and jerk of a move, and the rms residual of the fastest move with these limits, m."""
    from scipy.optimize import least_squares

    margin = (move[1] - move[0]) // 8 + 2
    a, b = max(move[0] - margin, within[0]), min(move[1] + margin, within[1])
    rows = np.unique(np.linspace(a, b, ROWS_OF_MOVE).astype(int))
    times, path = t[rows] - t[rows[0]], np.abs(x[rows] - x[rows[0]])
    began = float(t[move[0]] - t[rows[0]])
    length = float(t[move[1]] - t[move[0]])
    top = float(np.quantile(np.diff(path) / np.diff(times), 0.97))
    if top <= 0.0 or length <= 0.0:
        return None
    path = path / distance

    def limits(values: FloatArray) -> tuple[float, float, float]:
        """Velocity, acceleration and jerk from velocity, time of the ramp and the share of it in which jerk acts."""
        velocity, ramp, share = values[0] * top, values[1] * length, values[2]
        acceleration = velocity / (ramp * (1.0 - share))
        return velocity, acceleration, acceleration / (ramp * share)

    def residual(values: FloatArray) -> FloatArray:
        fields: dict[str, Any] = dict(zip(("velocity", "acceleration", "jerk"), limits(values), strict=True))
        motion = PointToPoint(PointToPointParameters(distance=distance, dwell=2.0 * times[-1], **fields))
        moved = motion.sample(np.maximum(times - values[3] * length, 0.0))[0]
        return np.asarray(moved / distance - path)

    ramp = float(np.clip(1.0 - distance / (top * length), 0.05, 0.5))
    low, high = [0.8, 0.002, 1e-4, (began / length) - 0.3], [1.3, 0.75, 0.5, (began / length) + 0.3]
    starts = [[1.0, ramp, share, began / length] for share in (0.05, 0.4)]
    options = {"bounds": (low, high), "x_scale": [0.1, 0.1, 0.1, 0.01]}
    best = min((least_squares(residual, start, **options) for start in starts), key=lambda fit: fit.cost)
    velocity, acceleration, jerk = limits(best.x)
    left = distance * float(np.sqrt(2.0 * best.cost / len(rows)))
    return velocity, acceleration, jerk if best.x[2] > NO_JERK else math.inf, left


def _round(value: float, size: float) -> float:
    """Round a value to a ten-thousandth of a size."""
    return round(value, 4 - math.floor(math.log10(abs(size))))
