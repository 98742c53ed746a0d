"""The same cause with another law: forces of any shape within what an effect acts on. No effect is known by name here.

A force close to the ends need not fall exponentially, nor friction as a power of speed; what distinguishes the effect
is where it acts and on what. A form frees the law within that, and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cogging._core import Prediction
from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.signatures import place
from cogging.diagnosis.candidates.waves import plain_wave
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.thresholds import FORM
from cogging.effects.effect import Effect, Knots, Place, SplineKnots, Travel, Wave, Window, kind_of
from cogging.estimation.innovations import Innovations

Columns = Callable[[Innovations, Prediction], FloatArray]


@dataclass(frozen=True)
class Form:
    """Forces, or errors of the reading, that an effect of another law may make.

    Attributes:
        coordinate: name of what they depend on.
        unit: unit of the coordinate.
        places: values of the coordinate, one a column where a column stands for one; else numbers of columns.
        columns: V (or m) per V (or m) in each interval (row) of a log under a prediction, (p, n).
        reading: whether they are errors of the reading.
        along: of a force that goes with position or time alone, that coordinate, nodes (k,), and the columns there,
            (p, k); None else.
    """

    coordinate: str
    unit: str
    places: FloatArray
    columns: Columns
    reading: bool = False
    along: tuple[str, FloatArray, FloatArray] | None = None

    def patch(self, force: FloatArray) -> dict[str, Any] | None:
        """The curve of a force that goes with position or time alone, from the size of each column (p,)."""
        if self.along is None:
            return None
        coordinate, nodes, columns = self.along
        return {"coordinate": coordinate, "places": nodes.tolist(), "force": (force @ columns).tolist()}

    def tables(self, evidence: Evidence) -> list[FloatArray]:
        """What they add to the residuals of each log, (p, n)."""
        mass = evidence.model.axis.mass
        made = []
        for source, along in zip(evidence.sources, evidence.alongs, strict=True):
            columns = self.columns(source, along)
            rows = source.rows_of_readings if self.reading else source.rows_of_forces
            made.append(rows(along, columns, mass))
        return made


def hats(values: FloatArray, places: FloatArray) -> FloatArray:
    """Linear interpolation between places (m,), increasing, as columns, (m, n)."""
    table = np.zeros((len(places), len(values)))
    if len(places) == 1:
        table[0] = 1.0
        return table
    left = np.clip(np.searchsorted(places, values, side="right") - 1, 0, len(places) - 2)
    share = np.clip((1.0 / np.diff(places))[left] * (values - places[left]), 0.0, 1.0)
    rows = np.arange(len(values))
    table[left, rows], table[left + 1, rows] = 1.0 - share, share
    return table


def form_of(effect: Effect, evidence: Evidence) -> Form | None:
    """The form of an effect at the shape it has; None where it acts by a state of its own, or has one law only."""
    hooks = effect.HOOKS
    asked = {role["quantity"] for role in effect.ROLES.values() if role["role"] != "setting"}
    if plain_wave(effect) is not None:
        return _harmonics(effect)
    if kind_of(effect, SplineKnots) is not None:
        return _modulated(effect, evidence)
    if kind_of(effect, Travel) is not None:
        return _near_ends(effect, evidence)
    if kind_of(effect, Window) is not None:
        return _within(effect)
    if kind_of(effect, Place) is not None:
        return _about(effect)
    if "friction_level" in hooks and kind_of(effect, Knots) is not None:
        return _friction_along(evidence)
    if "friction_level" in hooks and "velocity" in asked:
        return _friction_by_speed(evidence)
    if "command_gain" in hooks and "time" in asked:
        return _gain_in_time(evidence)
    if "force" in hooks and "force_per_velocity_squared" in asked:
        return _drag(evidence)
    if "force" in hooks and "force_per_position" in asked:
        return _spring(evidence)
    if "shape_command" in hooks:
        return _by_command(effect, evidence)
    return _lagging(effect) if "lag" in hooks else None


def _harmonics(effect: Effect) -> Form:
    wave = plain_wave(effect)
    if wave is None:
        raise ValueError(f"{effect.NAME}: must be a wave")
    value = float(getattr(effect, wave.shape))
    spatial = effect.ROLES[wave.shape]["quantity"] == "distance"
    orders, reading = np.array(FORM.harmonics), "reading" in effect.HOOKS

    def columns(source: Innovations, along: Prediction) -> FloatArray:
        if spatial:
            turns = (along.position if reading else along.middle_position) / value
        else:
            turns = (source.log.time - source.log.time[0]) * value
        angles = 2.0 * np.pi * orders[:, None] * turns[None, :]
        rows = np.vstack([np.sin(angles), np.cos(angles)])
        return np.asarray(rows * source.log.command) if "command_gain" in effect.HOOKS else rows

    coordinate = "harmonics of the period" if spatial else "harmonics of the frequency"
    return Form(coordinate, "1", np.concatenate([orders, orders]).astype(float), columns, reading)


def _modulated(effect: Effect, evidence: Evidence) -> Form:
    wave = kind_of(effect, Wave)
    if wave is None:
        raise ValueError(f"{effect.NAME}: must be a wave")
    period = float(getattr(effect, wave.shape))
    places = np.linspace(*place(evidence), FORM.places)

    def columns(source: Innovations, along: Prediction) -> FloatArray:
        x = along.middle_position
        parts, angle = hats(x, places), 2.0 * np.pi * x / period
        return np.vstack([parts * np.sin(angle), parts * np.cos(angle)])

    return Form("amplitude along the travel", "m", np.concatenate([places, places]), columns)


def _near_ends(effect: Effect, evidence: Evidence) -> Form:
    travel = kind_of(effect, Travel)
    ends = list(getattr(effect, travel.ends)) if travel is not None else []
    low, high = ends if len(ends) == 2 and np.isfinite(ends).all() and ends[0] < ends[1] else place(evidence)
    steps = np.array(FORM.end_places) * (high - low)

    def at(x: FloatArray) -> FloatArray:
        return np.vstack([hats(x - low, steps)[:-1], hats(high - x, steps)[:-1]])

    nodes = np.concatenate([low + steps, (high - steps)[::-1]])
    return Form(
        "position near the ends",
        "m",
        np.concatenate([low + steps[:-1], high - steps[:-1]]),
        lambda source, along: at(along.middle_position),
        along=("position", nodes, at(nodes)),
    )


def _within(effect: Effect) -> Form:
    window = kind_of(effect, Window)
    if window is None:
        raise ValueError(f"{effect.NAME}: must begin and end")
    begin, end = float(getattr(effect, window.start)), float(getattr(effect, window.stop))
    more = FORM.around * (end - begin)
    places = np.linspace(max(0.0, begin - more), end + more, FORM.pushes + 2)
    return Form(
        "time",
        "s",
        places[1:-1],
        lambda source, along: hats(source.log.time - source.log.time[0], places)[1:-1],
        along=("time", places, np.eye(len(places))[1:-1]),
    )


def _about(effect: Effect) -> Form:
    where = kind_of(effect, Place)
    if where is None:
        raise ValueError(f"{effect.NAME}: must act at a place")
    center, width = float(getattr(effect, where.center)), float(getattr(effect, where.width))
    places = center + width * np.linspace(-FORM.widths, FORM.widths, FORM.pushes + 2)

    def at(x: FloatArray) -> FloatArray:
        return hats(x, places)[1:-1]

    return Form(
        "position about a place",
        "m",
        places[1:-1],
        lambda source, along: at(along.middle_position),
        along=("position", places, np.eye(len(places))[1:-1]),
    )


def _friction_along(evidence: Evidence) -> Form:
    places = np.linspace(*place(evidence), FORM.places)

    def columns(source: Innovations, along: Prediction) -> FloatArray:
        return hats(along.middle_position, places) * np.sign(along.middle_velocity)

    return Form("friction over position", "m", places, columns)


def _friction_by_speed(evidence: Evidence) -> Form:
    slowest = min(source.rest for source in evidence.sources)
    places = np.geomspace(slowest, FORM.slow * evidence.scales.velocity, FORM.slow_speeds)

    def columns(source: Innovations, along: Prediction) -> FloatArray:
        speed = np.maximum(np.abs(along.middle_velocity), slowest)
        return hats(np.log(speed), np.log(places))[:-1] * np.sign(along.middle_velocity)

    return Form("friction over speed", "m/s", places[:-1], columns)


def _gain_in_time(evidence: Evidence) -> Form:
    places = np.linspace(0.0, evidence.scales.time, FORM.pushes)

    def columns(source: Innovations, along: Prediction) -> FloatArray:
        return np.asarray(hats(source.log.time - source.log.time[0], places)[1:] * source.log.command)

    return Form("gain over time", "s", places[1:], columns)


def _drag(evidence: Evidence) -> Form:
    top, powers = evidence.scales.velocity, np.array(FORM.powers)

    def columns(source: Innovations, along: Prediction) -> FloatArray:
        share = along.middle_velocity / top
        return np.asarray(np.sign(share) * np.abs(share) ** powers[:, None])

    return Form("powers of the speed", "1", powers, columns)


def _spring(evidence: Evidence) -> Form:
    (low, high), powers = place(evidence), np.array(FORM.bends)

    def at(x: FloatArray) -> FloatArray:
        share = 2.0 * (x - low) / (high - low) - 1.0
        return np.vstack([np.ones_like(share), share ** powers[:, None]])

    nodes = np.linspace(low, high, FORM.places)
    return Form(
        "powers of the position",
        "1",
        np.concatenate([[0.0], powers]),
        lambda source, along: at(along.middle_position),
        along=("position", nodes, at(nodes)),
    )


def _by_command(effect: Effect, evidence: Evidence) -> Form:
    field, role = next((name, role) for name, role in effect.ROLES.items() if role["role"] == "shape")
    largest = max(float(np.abs(source.log.command).max()) for source in evidence.sources)
    if role["neutral"] == np.inf:  # large commands, either sign by itself
        places = largest * np.array(FORM.large_commands)
    else:
        places = min(float(getattr(effect, field)), FORM.width_max * largest) * np.array(FORM.small_commands)

    def columns(source: Innovations, along: Prediction) -> FloatArray:
        u = source.log.command
        parts = hats(np.abs(u), places)
        parts = parts[1:] if role["neutral"] == np.inf else parts[:-1]
        return np.vstack([parts * (u > 0.0), parts * (u < 0.0)])

    kept = places[1:] if role["neutral"] == np.inf else places[:-1]
    return Form("command", "V", np.concatenate([kept, -kept]), columns)


def _lagging(effect: Effect) -> Form:
    field = next(name for name, role in effect.ROLES.items() if role["role"] == "shape")
    total, ratios = float(getattr(effect, field)), np.array(FORM.lag_dampings)

    def columns(source: Innovations, along: Prediction) -> FloatArray:
        u, h = source.log.command, source.scales.sample_time
        first = lagged(u, [total, 1.0], h)
        return np.array([lagged(u, [(total / (2.0 * z)) ** 2, total, 1.0], h) - first for z in ratios])

    return Form("order of the lag", "1", ratios, columns)


def lagged(command: FloatArray, denominator: Sequence[float], sample_time: float) -> FloatArray:
    """A held command after 1 / denominator(s), the mean over each interval, (n,)."""
    from scipy.signal import cont2discrete, lfilter

    (top,), bottom, _ = cont2discrete(([1.0], list(denominator)), sample_time)
    after = np.asarray(lfilter(top, bottom, command - command[0])) + command[0]
    return np.asarray(0.5 * (after + np.append(after[1:], after[-1])))
