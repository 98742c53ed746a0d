"""A residual shape: the force of any shape in one coordinate that the residual asks for. Only held here, not sought."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from cogging.arrays import FloatArray

if TYPE_CHECKING:
    from cogging.diagnosis.evidence.score_test import ScoreTest

JUMPS, FRICTION_INTERVALS = "jumps of the reading over time", "friction in intervals of time"
MOMENTS = (JUMPS, FRICTION_INTERVALS)  # coordinates whose places are moments


@dataclass(frozen=True)
class Shape:
    """A force of any shape in one coordinate, as far as the residual asks for one.

    Attributes:
        coordinate: name of what the force depends on.
        unit: unit of the coordinate.
        test: score test of its columns.
        places: values of the coordinate at which the force is told, (m,).
        force: force that the model lacks there, V, (p,); for `position` first forward, then backward.
        deviation: 1-sigma of each force, (p,).
        log_p_value: ln of the probability that noise alone shows as much in any of the coordinates.
        share: share of the whitened residual's power below 60 Hz that it explains.
    """

    coordinate: str
    unit: str
    test: ScoreTest
    places: FloatArray
    force: FloatArray
    deviation: FloatArray
    log_p_value: float
    share: float

    @property
    def score(self) -> float:
        """2 ln likelihood less what the free parameters cost."""
        return self.test.statistic - 2.0 * self.test.freedom
