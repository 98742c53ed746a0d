"""What fit_map is asked for, and which of it a scan can answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cogging._core import SplineHarmonics
from cogging.mapping.scan import Scan

MOST_COEFFICIENTS = 4000  # of one fit: its normal matrix is dense
SLIVER = 0.05  # of a pitch: a shorter rest of the travel gets no span of its own


@dataclass(frozen=True)
class MapRequest:
    """What fit_map was asked for; a wrong value is refused."""

    pitch: float
    harmonics: Sequence[int] | None
    order: int | None
    origin: float | None
    highest_harmonic: int
    false_alarm: float

    def __post_init__(self) -> None:
        _require(_is_number(self.pitch) and self.pitch > 0.0, "pitch", "must be finite and above 0", self.pitch)
        within = _is_number(self.false_alarm) and 0.0 < self.false_alarm < 1.0
        _require(within, "false_alarm", "must lie between 0 and 1", self.false_alarm)
        _require(
            _is_whole(self.highest_harmonic, 1),
            "highest_harmonic",
            "must be a whole number from 1",
            self.highest_harmonic,
        )
        if self.harmonics is not None:
            given = list(self.harmonics) if isinstance(self.harmonics, Sequence | np.ndarray) else [None]
            whole = all(_is_whole(harmonic, 1) for harmonic in given)
            _require(whole, "harmonics", "must be a list of whole numbers from 1", self.harmonics)
            object.__setattr__(self, "harmonics", given)
            SplineHarmonics(pitch=self.pitch, harmonics=self.harmonics)  # has rules of its own
        if self.order is not None:
            rule = "must be a whole number from 1 to 16, or 0 for a periodic map"
            _require(_is_whole(self.order, 0, 16), "order", rule, self.order)
        if self.origin is not None:
            _require(_is_number(self.origin), "origin", "must be a finite number", self.origin)

    @property
    def highest(self) -> int:
        """The last harmonic that is looked for."""
        return max(self.highest_harmonic, *(self.harmonics or (1,)))

    def first_knot(self, scan: Scan) -> float:
        """m."""
        return float(scan.position.min()) if self.origin is None else self.origin

    def control_points(self, scan: Scan, order: int) -> int:
        """How many an order needs over the travel of a scan; 1 of a periodic map."""
        spans = np.ceil((scan.position.max() - self.first_knot(scan)) / self.pitch - SLIVER)
        return max(1, int(spans)) + order - 1 if order else 1

    def check_against(self, scan: Scan) -> None:
        """Refuse what the scan does not tell.

        Raises:
            ValueError: names the field, the rule and the value.
        """
        highest = max(self.harmonics or (1,))
        rule = f"must be at most {scan.resolvable} with points this far apart"
        _require(highest <= scan.resolvable, "harmonics", rule, highest)
        end, unit = float(scan.position.max()), scan.units.position
        _require(
            self.first_knot(scan) < end,
            "origin",
            f"must lie below the scan's highest position {end:g} {unit}",
            self.origin,
        )
        if self.harmonics is not None and self.order is not None:
            self.check_size(scan, len(self.harmonics), self.order)

    def check_size(self, scan: Scan, terms: int, order: int) -> None:
        """Refuse more coefficients than the scan has points for.

        Raises:
            ValueError: names the field, the rule and the value.
        """
        size = 2 * terms * self.control_points(scan, order)
        limit = min(MOST_COEFFICIENTS, scan.position.size - 4)
        rule = f"must need at most {limit} coefficients ({scan.position.size} points)"
        origin = f"{self.first_knot(scan):g} {scan.units.position}"
        _require(size <= limit, "order", rule, f"{size} for order {order} from origin {origin}")


def _is_number(value: object) -> bool:
    return isinstance(value, int | float | np.number) and not isinstance(value, bool) and bool(np.isfinite(value))


def _is_whole(value: object, lowest: int, highest: int = 10_000) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool) and bool(lowest <= value <= highest)


def _require(holds: bool, name: str, rule: str, value: object) -> None:
    if not holds:
        raise ValueError(f"{name}: {rule}, got {value}")
