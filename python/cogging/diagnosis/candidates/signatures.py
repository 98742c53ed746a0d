"""What an effect would do to the residuals, from what the effect says of itself: no effect is known by name here."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cogging._core import EFFECTS
from cogging.arrays import FloatArray
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.estimation.innovations import LINEAR_HOOKS, Innovations
from cogging.estimation.residuals import quiet_plant
from cogging.model.model import Model

TURNS = 3.0  # of a wave in the travel, at least, for its amplitude to change along it
NODES = 6  # of an amplitude that is given as a list along the travel
POINTS = {1: 12, 2: 4, 3: 2}  # values of each shape parameter, by how many the effect has
MOMENTS = 10  # at which something may begin or end
FREQUENCIES = 96  # of a resonance: it is narrow
DAMPING = 0.03  # of a resonance, to begin with
SMALL = 0.02  # of what is relative and starts from nothing: the columns are nearly proportional to it
EXPONENTS = (1.0, 2.0)


@dataclass(frozen=True)
class Candidate:
    """An effect at one shape: columns for its amplitudes, or one for a small effect that has none.

    Attributes:
        name: of the effect.
        shape: values of the fields that are no amplitudes.
        amplitudes: (field, index or None) of each column; empty where the shape alone makes the effect.
        unit: amplitude by which the columns were made.
    """

    name: str
    shape: dict[str, Any]
    amplitudes: tuple[tuple[str, int | None], ...]
    unit: tuple[float, ...]

    def effect(self, amplitudes: Sequence[float] = ()) -> Any:
        """The effect with these amplitudes (as many as columns), or its shape alone."""
        fields: dict[str, Any] = dict(self.shape)
        for (field, index), value in zip(self.amplitudes, amplitudes, strict=True):
            if index is None:
                fields[field] = float(value)
            else:
                fields.setdefault(field, [0.0] * self.length(field))[index] = float(value)
        for field, index in self.amplitudes:  # lists that got no amplitude
            if index is not None and field not in fields:
                fields[field] = [0.0] * self.length(field)
        return EFFECTS[self.name](**fields)

    def length(self, field: str) -> int:
        """Entries of a list of amplitudes."""
        return sum(1 for name, _ in self.amplitudes if name == field)


def quantities(evidence: Evidence) -> dict[str, float]:
    """The value in these logs of each quantity that an effect's ROLES name (see cogging.effects)."""
    model, scales = evidence.model, evidence.scales
    force = max(float(np.abs(s.log.command).max()) for s in evidence.sources) or 1.0
    friction = model.axis.coulomb if model.axis.coulomb > 0.0 else 0.1 * force
    span = scales.position
    return {
        "force": force,
        "command": force,
        "friction": friction,
        "position": span,
        "distance": span,
        "velocity": scales.velocity,
        "time": scales.time,
        "sample_time": scales.sample_time,
        "frequency": 0.5 / scales.sample_time,
        "force_per_position": force / span,
        "force_per_velocity": force / scales.velocity,
        "force_per_velocity_squared": force / scales.velocity**2,
        "stiffness": friction / span,
        "relative": 1.0,
        "exponent": 1.0,
        "one": 1.0,
    }


def place(evidence: Evidence) -> tuple[float, float]:
    """Lower and upper end of the positions in the logs, m."""
    low = min(float(s.log.position.min()) for s in evidence.sources)
    high = max(float(s.log.position.max()) for s in evidence.sources)
    return low, high


def shape_range(evidence: Evidence, role: dict[str, Any]) -> tuple[float, float]:
    """Between which values a shape is looked for: as its effect says, as far as these logs can show it.

    Nothing shorter than a count of the encoder is seen, nothing slower than what counts as rest; and friction that
    gives way elastically is not, where it has done so before the axis is fast enough for its rows to count.
    """
    size = quantities(evidence)[role["quantity"]]
    low, high = role["low"] * size, role["high"] * size
    if role["quantity"] == "distance":
        low = max(low, evidence.model.encoder.resolution)
    if role["quantity"] == "velocity":
        low = max(low, min(source.rest for source in evidence.sources))
    if role["quantity"] == "stiffness":
        reach = min(source.rest * source.settle for source in evidence.sources)
        high = min(high, quantities(evidence)["friction"] / max(reach, 1e-300))
    return low, high


def shape_values(evidence: Evidence, field: str, role: dict[str, Any], count: int) -> list[float]:
    """Where to look along one shape parameter."""
    low_end, high_end = place(evidence)
    low, high = shape_range(evidence, role)
    if role["quantity"] == "exponent":
        return list(EXPONENTS)
    if role["quantity"] == "one" and role["neutral"] is None:
        return [DAMPING]
    if role["quantity"] == "relative" and role["neutral"] == 0.0:
        return [SMALL]
    if role["quantity"] == "frequency":
        count = FREQUENCIES
    if role["quantity"] == "time" and role["role"] == "shape" and field in ("start", "stop"):
        count = MOMENTS
    if role["quantity"] == "position":
        return [
            float(v) for v in low_end + (high_end - low_end) * np.linspace(role["low"], role["high"], count + 2)[1:-1]
        ]
    if role["quantity"] == "command" and role["neutral"] == np.inf:  # a limit: felt just below the largest command
        return [float(v) for v in high / role["high"] * (1.0 - np.geomspace(0.005, 1.0 - role["low"], count))]
    if role["logarithmic"] or role["neutral"] == 0.0:
        if role["neutral"] != 0.0 or not role["logarithmic"]:
            low = max(low, 2e-3 * high)
        return [float(v) for v in np.geomspace(low, high, count)] if low < high else []
    values = np.linspace(low, high, count + 2)[1:-1]
    return [float(v) for v in values]


def candidates(evidence: Evidence, name: str, periods: Sequence[float] = ()) -> Iterator[Candidate]:
    """The grid of an effect that is no wave; `periods` (m): beside those of the known cogging, for what has one."""
    effect = EFFECTS[name]
    neutral = effect()
    roles = effect.ROLES
    low, high = place(evidence)
    sizes = quantities(evidence)
    shapes: dict[str, list[Any]] = {}
    scalar_shapes = [f for f, r in roles.items() if r["role"] == "shape" and not isinstance(getattr(neutral, f), list)]
    alone = [f for f in scalar_shapes if roles[f]["quantity"] not in ("one", "relative", "exponent")]
    count = POINTS.get(len(alone), 3)
    for field in scalar_shapes:
        shapes[field] = shape_values(evidence, field, roles[field], count)
    fixed: dict[str, Any] = {}
    for field, role in roles.items():  # a list of places: nodes along the travel
        if role["role"] == "shape" and isinstance(getattr(neutral, field), list):
            fixed[field] = [float(v) for v in np.linspace(low, high, NODES)]
    amplitudes: list[tuple[str, int | None]] = []
    units: list[float] = []
    listed = [f for f, r in roles.items() if r["role"] == "amplitude" and isinstance(getattr(neutral, f), list)]
    if listed and {"pitch", "order", "origin"} <= set(roles):  # amplitudes on knots: few of them, over the travel
        knots = NODES - 1
        fixed |= {"pitch": (high - low) / (knots - 2), "order": 3, "origin": low}
        if "period" in shapes:
            # A wave with hardly a turn in the travel has no amplitude that changes along it.
            shapes["period"] = [*known_periods(evidence.model), *(p for p in periods if TURNS * p < high - low)]
            if not shapes["period"]:
                return
        length = knots
    elif listed and not fixed:  # amplitudes at places of the user's own choice: nothing to look for
        return
    else:
        length = NODES
    for field, role in roles.items():
        if role["role"] != "amplitude":
            continue
        step = 0.02 * sizes[role["quantity"]] * min(1.0, abs(role["high"]))
        indexes: list[int | None] = list(range(length)) if field in listed else [None]
        amplitudes += [(field, index) for index in indexes]
        units += [step] * len(indexes)
    if "travel" in roles:
        fixed["travel"] = (
            list(evidence.model.axis.travel) if np.isfinite(evidence.model.axis.travel).all() else [low, high]
        )
    for values in itertools.product(*shapes.values()):
        shape = dict(zip(shapes, values, strict=True))
        if {"start", "stop"} <= set(shape) and shape["start"] >= shape["stop"]:
            continue
        yield Candidate(name, {**fixed, **shape}, tuple(amplitudes), tuple(units))


def known_periods(model: Model) -> list[float]:
    """Periods (m) of the cogging that the model has."""
    if model.cogging is None:
        return []
    return [float(2.0 * np.pi / w) for w in model.cogging.basis.wavenumbers]


def tables(evidence: Evidence, wanted: Sequence[Candidate]) -> list[list[FloatArray]]:
    """What each candidate's columns do to the residuals of each log, V per unit of amplitude: [candidate][log] (p, n).

    Laws that are linear along the prediction (forces, friction levels, gains, errors of the reading) are evaluated
    along it and passed through the observer's loop, and so is what a changed command or a load of its own does there,
    of the finite size that the shape says; what remains, such as friction with a memory, is predicted anew.
    """
    result: list[list[FloatArray]] = [[] for _ in wanted]
    for number, source in enumerate(evidence.sources):
        for i, table in enumerate(_tables_of_log(evidence, number, source, wanted)):
            result[i].append(table)
    return result


def _tables_of_log(
    evidence: Evidence, number: int, source: Innovations, wanted: Sequence[Candidate]
) -> list[FloatArray]:
    model, along = evidence.model, evidence.alongs[number]
    plant = quiet_plant(model)
    linear, memory, readings = [], [], []
    for i, candidate in enumerate(wanted):
        hooks = set(EFFECTS[candidate.name].HOOKS)
        if "reading" in hooks and len(candidate.amplitudes) > 1:
            readings.append(i)
        elif hooks <= LINEAR_HOOKS:
            linear.append(i)
        else:
            memory.append(i)
    out: list[FloatArray] = [np.empty(0)] * len(wanted)
    n = len(source.log)
    if linear:
        made = [(i, effect, unit) for i in linear for effect, unit in _unit_effects(wanted[i])]
        rows = source.rows_of_effects(along, plant, [e for _, e, _ in made], [unit for _, _, unit in made])
        start = 0
        for i in linear:
            columns = max(1, len(wanted[i].amplitudes))
            out[i] = rows[start : start + columns]
            start += columns
    for i in readings:
        errors = np.array(
            [(effect.reading_at(along.position) - along.position) / unit for effect, unit in _unit_effects(wanted[i])]
        )
        out[i] = source.rows_of_readings(along, errors, model.axis.mass)
    keys = {i: (number, wanted[i].name, *sorted(wanted[i].shape.items(), key=str)) for i in memory}
    keys = {i: tuple(str(part) for part in key) for i, key in keys.items()}
    for i in memory:
        if keys[i] in evidence.memory:
            out[i] = evidence.memory[keys[i]][0]
    memory = [i for i in memory if keys[i] not in evidence.memory]
    shown = {i: _unit_effects(wanted[i])[0] for i in memory}
    added = [i for i in memory if source.predictor.is_addable(plant, shown[i][0])]
    if added:
        rows = source.rows_of_effects(along, plant, [shown[i][0] for i in added], [shown[i][1] for i in added])
        for k, i in enumerate(added):
            out[i] = rows[k : k + 1]
    whole = [i for i in memory if i not in added]
    if whole:
        rows = source.of([model, *(model.replace(effects=(*model.effects, shown[i][0])) for i in whole)])
        for k, i in enumerate(whole):
            out[i] = ((rows[k + 1] - rows[0]) / shown[i][1]).reshape(1, n)
    for i in memory:
        evidence.memory[keys[i]] = [out[i]]
    return out


def _unit_effects(candidate: Candidate) -> list[tuple[Any, float]]:
    if not candidate.amplitudes:
        return [(candidate.effect(), 1.0)]
    effects = []
    for k, unit in enumerate(candidate.unit):
        values = [0.0] * len(candidate.amplitudes)
        values[k] = unit
        effects.append((candidate.effect(values), unit))
    return effects
