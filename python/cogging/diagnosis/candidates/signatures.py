"""What an effect would do to the residuals, from what the effect says of itself: no effect is known by name here."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from cogging.diagnosis.physical import ends
from cogging.diagnosis.thresholds import GRID
from cogging.effects.effect import VOCABULARY, Effect, SplineKnots, Travel, Turn, Wave, Window, kind_of
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.parameters import Scales


class SeenLog(Protocol):
    """One log, as far as it decides which shapes can be seen in it."""

    @property
    def log(self) -> Log:
        """The log."""

    @property
    def rest(self) -> float:
        """Speed below which rows do not count, m/s."""

    @property
    def settle(self) -> float:
        """Time after a start from which rows count, s."""


class Seen(Protocol):
    """Logs under a model, as far as they decide which shapes are tried."""

    @property
    def model(self) -> Model:
        """The model."""

    @property
    def sources(self) -> Sequence[SeenLog]:
        """The logs."""

    @property
    def scales(self) -> Scales:
        """Sizes of all logs together."""


TURN = math.tau  # rad


def vocabulary_of(model: Model, own: Iterable[Effect] = ()) -> dict[str, Effect]:
    """Effects that are tried, as they are when they do nothing, by name: the list, and a user's own.

    Only a rotary axis has one that goes with the angle of its turn.
    """
    tried = [*VOCABULARY.values(), *own]
    return {law.NAME: law for law in tried if is_rotary(model) or kind_of(law, Turn) is None}


def is_rotary(model: Model) -> bool:
    """Whether the position is an angle."""
    return model.units.position == "rad"


@dataclass(frozen=True)
class Candidate:
    """An effect at one shape: columns for its amplitudes, or one for a small effect that has none.

    Attributes:
        law: effect, as it is when it does nothing.
        shape: values of the fields that are no amplitudes.
        amplitudes: field and index (or None) of each column; empty where the shape alone makes the effect.
        unit: amplitudes by which the columns were made, one a column.
    """

    law: Effect
    shape: dict[str, Any]
    amplitudes: tuple[tuple[str, int | None], ...]
    unit: tuple[float, ...]

    @property
    def name(self) -> str:
        """Of the effect."""
        return self.law.NAME

    @property
    def period(self) -> float | None:
        """Of what comes and goes with a period along the travel, m."""
        wave = kind_of(self.law, Wave)
        if wave is None or wave.shape not in self.shape or self.law.ROLES[wave.shape]["quantity"] != "distance":
            return None
        return float(self.shape[wave.shape])

    def effect(self, amplitudes: Sequence[float] = ()) -> Effect:
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
        return self.law.replace(**fields)

    def length(self, field: str) -> int:
        """Entries of a list of amplitudes."""
        return sum(1 for name, _ in self.amplitudes if name == field)


def quantities(evidence: Seen) -> dict[str, float]:
    """The value in these logs of each quantity that an effect's ROLES name (see cogging.effects)."""
    model, scales = evidence.model, evidence.scales
    force = max(float(np.abs(s.log.command).max()) for s in evidence.sources) or 1.0
    friction = model.axis.coulomb if model.axis.coulomb > 0.0 else GRID.assumed_friction * force
    span = scales.position
    return {
        "force": force,
        "command": force,
        "friction": friction,
        "position": span,
        "distance": span,
        "angle": TURN,
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
        "absolute": 1.0,
    }


def place(evidence: Seen) -> tuple[float, float]:
    """Lower and upper end of the positions in the logs, m."""
    low = min(float(s.log.position.min()) for s in evidence.sources)
    high = max(float(s.log.position.max()) for s in evidence.sources)
    return low, high


def shape_range(evidence: Seen, role: Mapping[str, Any]) -> tuple[float, float]:
    """Between which values a shape is looked for: as its effect says, as far as these logs can show it.

    Nothing shorter than a count of the encoder is seen, nothing slower than what counts as rest; and friction that
    gives way elastically is not, where it has done so before the axis is fast enough for its rows to count.
    """
    size = quantities(evidence)[role["quantity"]]
    least, most = ends([source.log for source in evidence.sources], role)
    low, high = max(role["low"] * size, least), min(role["high"] * size, most)
    if role["quantity"] == "distance":
        low = max(low, evidence.model.encoder.resolution)
    if role["quantity"] == "velocity":
        low = max(low, min(source.rest for source in evidence.sources))
    if role["quantity"] == "stiffness":
        reach = min(source.rest * source.settle for source in evidence.sources)
        high = min(high, quantities(evidence)["friction"] / max(reach, 1e-300))
    return low, high


def shape_values(evidence: Seen, law: Effect, field: str, count: int) -> list[float]:
    """Where to look along one shape parameter."""
    role = law.ROLES[field]
    low_end, high_end = place(evidence)
    low, high = shape_range(evidence, role)
    if role["quantity"] == "exponent":
        return list(GRID.exponents)
    if role["quantity"] == "one" and role["neutral"] is None:
        return [GRID.first_damping]
    if role["quantity"] == "relative" and role["neutral"] == 0.0:
        return [GRID.small]
    if role["quantity"] == "frequency":
        count = GRID.resonances
    window = kind_of(law, Window)
    if window is not None and field in (window.start, window.stop):
        count = GRID.moments
    if role["quantity"] == "position":
        return [
            float(v) for v in low_end + (high_end - low_end) * np.linspace(role["low"], role["high"], count + 2)[1:-1]
        ]
    if role["quantity"] == "command" and role["neutral"] == np.inf:  # a limit: felt just below the largest command
        largest = high / role["high"]
        nearest = GRID.limit_nearest * largest
        return (
            [float(v) for v in largest - np.geomspace(nearest, largest - low, count)] if largest - low > nearest else []
        )
    if role["logarithmic"] or role["neutral"] == 0.0:
        if role["neutral"] != 0.0 or not role["logarithmic"]:
            low = max(low, GRID.smallest_share * high)
        return [float(v) for v in np.geomspace(low, high, count)] if low < high else []
    values = np.linspace(low, high, count + 2)[1:-1]
    return [float(v) for v in values]


def candidates(evidence: Seen, law: Effect, periods: Sequence[float] = ()) -> Iterator[Candidate]:
    """The grid of an effect that is no wave; `periods` (m): beside those of the known cogging, for what has one."""
    roles = law.ROLES
    lists = list_fields(law)
    shapes = shape_grid(evidence, law)
    low, high = place(evidence)
    # A list of places: nodes along the travel.
    fixed: dict[str, Any] = {
        field: [float(v) for v in np.linspace(low, high, GRID.nodes)]
        for field in lists
        if roles[field]["role"] == "shape"
    }
    listed = [field for field in lists if roles[field]["role"] == "amplitude"]
    length = GRID.nodes
    knots, wave = kind_of(law, SplineKnots), kind_of(law, Wave)
    if listed and knots is not None:  # amplitudes on knots: few of them, over the travel
        length = GRID.nodes - 1
        fixed |= {knots.pitch: (high - low) / (length - 2), knots.order: 3, knots.origin: low}
        if wave is not None:
            # A wave with hardly a turn in the travel has no amplitude that changes along it.
            shapes[wave.shape] = [
                *known_periods(evidence.model),
                *(p for p in periods if GRID.turns_to_change * p < high - low),
            ]
    elif listed and not fixed:  # amplitudes at places of the user's own choice: nothing to look for
        return
    amplitudes, units = amplitude_columns(evidence, law, length)
    ends, window = kind_of(law, Travel), kind_of(law, Window)
    if ends is not None:
        travel = evidence.model.axis.travel
        fixed[ends.ends] = list(travel) if np.isfinite(travel).all() else [low, high]
    for values in itertools.product(*shapes.values()):
        shape = dict(zip(shapes, values, strict=True))
        if window is not None and shape[window.start] >= shape[window.stop]:
            continue
        yield Candidate(law, {**fixed, **shape}, amplitudes, units)


def list_fields(law: Effect) -> list[str]:
    """Fields of an effect that are lists."""
    return [field for field in law.ROLES if isinstance(getattr(law, field), list)]


def shape_grid(evidence: Seen, law: Effect) -> dict[str, list[Any]]:
    """Values that are tried of each shape of an effect that is a number."""
    roles, lists = law.ROLES, list_fields(law)
    numbers = [field for field, role in roles.items() if role["role"] == "shape" and field not in lists]
    alone = [field for field in numbers if roles[field]["quantity"] not in ("one", "relative", "exponent")]
    count = GRID.values_of_shape[min(len(alone), len(GRID.values_of_shape) - 1)]
    return {field: shape_values(evidence, law, field, count) for field in numbers}


def amplitude_columns(
    evidence: Seen, law: Effect, length: int
) -> tuple[tuple[tuple[str, int | None], ...], tuple[float, ...]]:
    """Amplitudes of an effect, those in lists `length` times, and the unit of each (see Candidate)."""
    sizes, lists = quantities(evidence), list_fields(law)
    amplitudes: list[tuple[str, int | None]] = []
    units: list[float] = []
    for field, role in law.ROLES.items():
        if role["role"] != "amplitude":
            continue
        indexes: list[int | None] = list(range(length)) if field in lists else [None]
        amplitudes += [(field, index) for index in indexes]
        units += [GRID.unit_share * sizes[role["quantity"]] * min(1.0, abs(role["high"]))] * len(indexes)
    return tuple(amplitudes), tuple(units)


def known_periods(model: Model) -> list[float]:
    """Periods (m) of the cogging that the model has."""
    if model.cogging is None:
        return []
    return [float(2.0 * np.pi / w) for w in model.cogging.basis.wavenumbers]


def turn_periods(model: Model) -> list[float]:
    """Period (rad) of a force that comes once a turn of a rotary axis: that is no cogging, but an unbalanced mass."""
    return [TURN] if is_rotary(model) else []
