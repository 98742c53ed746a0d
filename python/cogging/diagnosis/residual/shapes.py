"""What is left, against a generic basis: forces of any shape in position, velocity, time, command and so on."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.forms import hats
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.gather import refiltered
from cogging.diagnosis.evidence.log_p_value import log_survival
from cogging.diagnosis.evidence.score_test import ScoreTest
from cogging.diagnosis.residual.shape import Shape
from cogging.diagnosis.thresholds import SCORE_TEST, SHAPE
from cogging.estimation.innovations import Innovations
from cogging.estimation.residuals import quiet_plant
from cogging.model.model import Model

ANSWERS = ("command", "acceleration", "velocity", "gain")  # in which the loop answers what the gap does, noise too


Coordinate = tuple[str, FloatArray, Callable[[], FloatArray], FloatArray]


def coordinates(source: Innovations, model: Model) -> dict[str, Coordinate]:
    """Unit, places, what makes the columns (m, n) of V per V, and values of each coordinate along a log.

    Columns of all coordinates together would be a hundred times the log: each are made where they are looked at.
    """
    x, v = source.along.middle_position, source.along.middle_velocity
    t = source.log.time - source.log.time[0]
    u = source.log.command
    a = source.predictor.net_force([quiet_plant(model)], x, v)[0] / model.axis.mass
    moving = source.mask > 0
    direction = np.sign(v)

    def spread(values: FloatArray, count: int) -> FloatArray:
        places = np.unique(np.quantile(values[moving], np.linspace(0.0, 1.0, count)))
        return places if len(places) > 2 else np.linspace(places[0] - 1e-9, places[-1] + 1e-9, 3)

    ends = np.linspace(float(x.min()), float(x.max()), SHAPE.travel_places)
    speeds = np.unique(np.concatenate([-one_way(-v[moving]), [0.0], one_way(v[moving])]))
    times, ages = np.linspace(0.0, float(t[-1]), SHAPE.time_places), np.linspace(0.0, float(t[-1]), SHAPE.ageing_places)
    commands, accelerations = spread(u, SHAPE.value_places), spread(a, SHAPE.value_places)
    paces = spread(np.abs(v), SHAPE.gain_speeds)

    def both() -> FloatArray:  # the shape is free for either direction where that makes a difference
        forward = hats(x, ends)
        return np.vstack([forward * (direction > 0), forward * (direction < 0)])

    return {
        "position": ("m", ends, both, x),
        "velocity": ("m/s", speeds, lambda: hats(v, speeds), v),
        "time": ("s", times, lambda: hats(t, times), t),
        "command": ("V", commands, lambda: hats(u, commands), u),
        "acceleration": ("m/s^2", accelerations, lambda: hats(a, accelerations), a),
        "friction over time": ("s", times, lambda: hats(t, times) * direction, t),
        "drag over time": ("s", ages, lambda: hats(t, ages) * v, t),
        "gain over time": ("s", times, lambda: hats(t, times) * u, t),
        "gain over position": ("m", ends, lambda: hats(x, ends) * u, x),
        "gain over speed": ("m/s", paces, lambda: hats(np.abs(v), paces) * u, np.abs(v)),
        "drag over position": ("m", ends, lambda: hats(x, ends) * v, x),
        **over_pitch(x, v, u, model),
    }


def over_pitch(position: FloatArray, velocity: FloatArray, command: FloatArray, model: Model) -> dict[str, Coordinate]:
    """Drag, friction and gain of any shape over the longest period of the known cogging, as `coordinates` has them."""
    if model.cogging is None or len(model.cogging.basis.wavenumbers) == 0:
        return {}
    pitch = float(2.0 * np.pi / np.min(model.cogging.basis.wavenumbers))
    places = np.linspace(0.0, pitch, SHAPE.pitch_places + 1)
    phase = np.mod(position, pitch)

    def times(factor: FloatArray) -> FloatArray:
        wave = hats(phase, places)
        wave[0] += wave[-1]  # the last place is the first
        return wave[:-1] * factor

    return {
        "drag over the pitch": ("m", places[:-1], lambda: times(velocity), phase),
        "friction over the pitch": ("m", places[:-1], lambda: times(np.sign(velocity)), phase),
        "gain over the pitch": ("m", places[:-1], lambda: times(command), phase),
    }


def one_way(velocity: FloatArray) -> FloatArray:
    """Places for the positive velocities among these: seven quantiles, or their end where there are few."""
    up = velocity[velocity > 0]
    if len(up) == 0:
        return up  # the axis never moves this way
    if len(up) < SHAPE.way_rows:
        return np.array([float(up.max())])
    return np.asarray(np.quantile(up, np.linspace(0.0, 1.0, SHAPE.way_speeds)))


def shapes(evidence: Evidence, *, plain: bool = False, known: Sequence[Shape] = ()) -> list[Shape]:
    """The residual shapes, the likeliest first, each against the noise that it would leave (see findings.profiled).

    Args:
        evidence: the evidence in which they are sought.
        plain: whether to start also from what explains the unwhitened residual, where filters have taken for noise what
            is slow and large. That sees more, and doubts more names: their own shapes are sought without it.
        known: shapes of the same evidence that were sought without `plain`.
    """
    usual = {shape.coordinate: shape for shape in known}
    seen = [coordinates(source, evidence.model) for source in evidence.sources]
    wanted = [name for name in seen[-1] if name not in usual or (plain and not is_answered(name))]
    power = low_power(evidence)
    _ = evidence.overdispersion, evidence.freedom  # made here once, not by every thread

    def shape(name: str) -> Shape | None:
        unit, places = seen[-1][name][:2]
        tables = [
            source.rows_of_forces(along, each[name][2](), evidence.model.axis.mass)
            for source, along, each in zip(evidence.sources, evidence.alongs, seen, strict=True)
        ]
        # Each log has its own places, but equally many unless a direction is missing.
        if len({len(part) for part in tables}) != 1:
            return None
        asked = plain and not is_answered(name)
        start, explained = evidence.unwhitened_fit(tables) if asked else (np.empty(0), 0.0)
        if name in usual and explained <= SHAPE.plain_share:
            return usual[name]
        test, share = best_test(evidence, tables, [start] if explained > SHAPE.plain_share else [], power)
        return None if test is None else shape_of(name, unit, places, test, share, len(seen[-1]))

    with ThreadPoolExecutor(os.cpu_count(), initializer=lambda: np.seterr(all="ignore")) as threads:
        found = [one for one in threads.map(shape, wanted) if one is not None]
    found += [one for one in known if one.coordinate not in wanted]
    return sorted(found, key=lambda one: one.log_p_value)


def best_test(
    evidence: Evidence, tables: Sequence[FloatArray], starts: Sequence[FloatArray], power: float
) -> tuple[ScoreTest | None, float]:
    """The best test of a shape's columns against the noise that it leaves, and its share of the residual's power.

    Args:
        evidence: the evidence.
        tables: columns of the shape, V per V, one (m, n) a log.
        starts: amplitudes (m,) taken from the residual before the filters are estimated, beside those of a first test.
        power: power of the whitened residual below 60 Hz (low_power).
    """
    first = evidence.test(evidence.whitened(tables))
    if first.freedom == 0:
        return None, 0.0
    test, statistic = first, evidence.bounded(first)
    own = [first.amplitudes] if statistic > first.freedom + SHAPE.shape_promising else []
    for start in (*own, *starts):
        quiet = refiltered(evidence, [start @ table for table in tables])
        again = quiet.test(quiet.whitened(tables))
        if quiet.bounded(again) > statistic:
            test, statistic = again, quiet.bounded(again)
    share = float(min(1.0, max(0.0, first.statistic - first.freedom) / power))
    return replace(test, statistic=statistic), share


def shape_of(name: str, unit: str, places: FloatArray, test: ScoreTest, share: float, trials: int) -> Shape:
    """A shape from its test, one of so many coordinates that were tried."""
    log_p_value = min(0.0, log_survival(test.statistic, test.freedom) + float(np.log(trials)))
    return Shape(name, unit, test, places, -test.amplitudes, test.deviations, log_p_value, share)


def is_answered(coordinate: str) -> bool:
    """Whether the loop moves this coordinate in answer to the gap: then noise alone makes the gap go with it."""
    return any(word in coordinate for word in ANSWERS)


def low_power(evidence: Evidence) -> float:
    """Power of the whitened residual below 60 Hz, in rows: what effects could explain, noise among it."""
    total, start = 0.0, 0
    for source in evidence.sources:
        n = len(source.log)
        part = evidence.free_residual[start : start + n]
        start += n
        spectrum = np.abs(np.fft.rfft(part)) ** 2
        frequency = np.fft.rfftfreq(n, source.scales.sample_time)
        total += 2.0 * float(spectrum[frequency < SCORE_TEST.effects_below].sum()) / n
    return max(total, 1.0)
