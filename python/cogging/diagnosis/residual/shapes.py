"""What is left, against a generic basis: forces of any shape in position, velocity, time, command and so on."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from cogging.arrays import FloatArray
from cogging.diagnosis.evidence.evidence import Evidence, Test
from cogging.diagnosis.evidence.log_p_value import log_survival
from cogging.estimation.innovations import Innovations
from cogging.estimation.residuals import quiet_plant
from cogging.model.model import Model

PHASES = 8  # places in a pitch
ANSWERS = ("command", "acceleration", "velocity", "gain")  # in which the loop answers what the gap does, noise too
PLAIN = 0.15  # of the gap's power, from which what explains it is judged against the noise that it leaves
PROMISING = 6.0  # T above its freedom from which a shape is judged against the noise that it leaves


@dataclass(frozen=True)
class Shape:
    """A force of any shape in one coordinate, as far as the residual asks for one.

    Attributes:
        coordinate: what the force depends on.
        unit: of the coordinate.
        test: of its columns.
        places: where the shape is told, in the coordinate, (m,).
        force: V, the force that the model lacks there, (p,); for `position` first forward, then backward.
        deviation: 1-sigma of each, (p,).
        log_p_value: ln of the probability that noise alone shows as much in any of the coordinates.
        share: of the whitened residual's power below 60 Hz that it explains.
    """

    coordinate: str
    unit: str
    test: Test
    places: FloatArray
    force: FloatArray
    deviation: FloatArray
    log_p_value: float
    share: float

    @property
    def score(self) -> float:
        """2 ln likelihood less what the free parameters cost."""
        return self.test.statistic - 2.0 * self.test.freedom


def hats(values: FloatArray, places: FloatArray) -> FloatArray:
    """Linear interpolation between places as columns, (m, n)."""
    return np.array([np.interp(values, places, one) for one in np.eye(len(places))])


def coordinates(source: Innovations, model: Model) -> dict[str, tuple[str, FloatArray, FloatArray, FloatArray]]:
    """Unit, places, columns (m, n) of V per V, and values of each coordinate along a log."""
    x, v = source.along.middle_position, source.along.middle_velocity
    t = source.log.time - source.log.time[0]
    u = source.log.command
    a = source.predictor.net_force([quiet_plant(model)], x, v)[0] / model.axis.mass
    moving = source.counts > 0
    direction = np.sign(v)

    def spread(values: FloatArray, count: int) -> FloatArray:
        places = np.unique(np.quantile(values[moving], np.linspace(0.0, 1.0, count)))
        return places if len(places) > 2 else np.linspace(places[0] - 1e-9, places[-1] + 1e-9, 3)

    ends = np.linspace(float(x.min()), float(x.max()), 9)
    forward = hats(x, ends)
    speeds = np.unique(np.concatenate([-one_way(-v[moving]), [0.0], one_way(v[moving])]))
    times, ages = np.linspace(0.0, float(t[-1]), 13), np.linspace(0.0, float(t[-1]), 7)
    commands, accelerations, paces = spread(u, 9), spread(a, 9), spread(np.abs(v), 6)
    # Each coordinate's shape is free for either direction where that makes a difference.
    both = np.vstack([forward * (direction > 0), forward * (direction < 0)])
    speed_columns = hats(v, speeds)
    return {
        "position": ("m", ends, both, x),
        "velocity": ("m/s", speeds, speed_columns, v),
        "time": ("s", times, hats(t, times), t),
        "command": ("V", commands, hats(u, commands), u),
        "acceleration": ("m/s^2", accelerations, hats(a, accelerations), a),
        "friction over time": ("s", times, hats(t, times) * direction, t),
        "drag over time": ("s", ages, hats(t, ages) * v, t),
        "gain over time": ("s", times, hats(t, times) * u, t),
        "gain over position": ("m", ends, forward * u, x),
        "gain over speed": ("m/s", paces, hats(np.abs(v), paces) * u, np.abs(v)),
        "drag over position": ("m", ends, forward * v, x),
        **over_pitch(x, v, u, model),
    }


def over_pitch(
    position: FloatArray, velocity: FloatArray, command: FloatArray, model: Model
) -> dict[str, tuple[str, FloatArray, FloatArray, FloatArray]]:
    """Drag, friction and gain of any shape over the longest period of the known cogging, as `coordinates` has them."""
    if model.cogging is None or len(model.cogging.basis.wavenumbers) == 0:
        return {}
    pitch = float(2.0 * np.pi / np.min(model.cogging.basis.wavenumbers))
    places = np.linspace(0.0, pitch, PHASES + 1)
    phase = np.mod(position, pitch)
    wave = hats(phase, places)
    wave = np.vstack([wave[0] + wave[-1], wave[1:-1]])  # the last place is the first
    return {
        "drag over the pitch": ("m", places[:-1], wave * velocity, phase),
        "friction over the pitch": ("m", places[:-1], wave * np.sign(velocity), phase),
        "gain over the pitch": ("m", places[:-1], wave * command, phase),
    }


def one_way(velocity: FloatArray) -> FloatArray:
    """Places for the positive velocities among these: seven quantiles, or their end where there are few."""
    up = velocity[velocity > 0]
    if len(up) == 0:
        return up  # the axis never moves this way
    if len(up) < 50:
        return np.array([float(up.max())])
    return np.asarray(np.quantile(up, np.linspace(0.0, 1.0, 7)))


def shapes(evidence: Evidence, *, plain: bool = False, known: Sequence[Shape] = ()) -> list[Shape]:
    """The generic shapes, the likeliest first, each against the noise that it would leave (see scan.profiled).

    Args:
        evidence: in which they are looked for.
        plain: also where it is the gap itself that asks for them, not only what is left of it when filters have taken
            for noise what is slow and large. That sees more; it would doubt names, which are not looked at so.
        known: shapes of the same evidence that were not looked at so.
    """
    model = evidence.model
    tables: dict[str, list[FloatArray]] = {}
    facts: dict[str, tuple[str, FloatArray]] = {}
    usual = {shape.coordinate: shape for shape in known}
    for source, along in zip(evidence.sources, evidence.alongs, strict=True):
        for name, (unit, places, columns, _) in coordinates(source, model).items():
            facts[name] = (unit, places)
            if name not in usual or (plain and not is_answered(name)):
                tables.setdefault(name, []).append(source.rows_of_forces(along, columns, model.axis.mass))
    power = low_power(evidence)
    _ = evidence.overdispersion, evidence.freedom  # made here once, not by every thread

    def shape(name: str) -> Shape | None:
        parts = tables[name]
        # Each log has its own places, but equally many unless a direction is missing.
        if len({len(part) for part in parts}) != 1:
            return None
        amplitudes, share = evidence.unwhitened_fit(parts) if plain and not is_answered(name) else (np.empty(0), 0.0)
        if name in usual and share <= PLAIN:
            return usual[name]
        first = evidence.test(evidence.whitened(parts))
        if first.freedom == 0:
            return None
        test, statistic = first, evidence.bounded(first)
        starts = [first.amplitudes] if statistic > first.freedom + PROMISING else []
        starts += [amplitudes] if share > PLAIN else []
        for start in starts:
            quiet = evidence.cleaned([start @ part for part in parts])
            again = quiet.test(quiet.whitened(parts))
            if quiet.bounded(again) > statistic:
                test, statistic = again, quiet.bounded(again)
        unit, places = facts[name]
        return Shape(
            name,
            unit,
            replace(test, statistic=statistic),
            places,
            -test.amplitudes,
            test.deviations,
            min(0.0, log_survival(statistic, test.freedom) + float(np.log(len(facts)))),
            float(min(1.0, max(0.0, first.statistic - first.freedom) / power)),
        )

    with ThreadPoolExecutor(os.cpu_count()) as threads:
        found = [one for one in threads.map(shape, tables) if one is not None]
    found += [one for one in known if one.coordinate not in tables]
    return sorted(found, key=lambda one: one.log_p_value)


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
        total += 2.0 * float(spectrum[frequency < 60.0].sum()) / n
    return max(total, 1.0)
