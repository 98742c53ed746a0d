"""Where a gap sits, on its own: by coordinate, by spatial period and by frequency, before anything is named.

A location is held and shown; `cogging.diagnosis.locate` computes it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from cogging import plot
from cogging.arrays import FloatArray
from cogging.diagnosis.places import Shape, length_text, ranges, shape_text, share_text
from cogging.model.model import Model
from cogging.model.units import Units
from cogging.outputs import finite
from cogging.values import ByValue

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TOLD = -9.5  # ln p: a coordinate or wave of less is told


@dataclass(frozen=True)
class Wave:
    """A force that repeats itself, in place or in time.

    Attributes:
        coordinate: "spatial period" or "frequency".
        value: period (m) or frequency (Hz).
        unit: m or Hz.
        amplitude: amplitude of the force, V.
        log_p_value: ln of the probability that noise alone shows as much at any period or frequency.
        share: of the gap's power.
    """

    coordinate: str
    value: float
    unit: str
    amplitude: float
    log_p_value: float
    share: float

    def to_dict(self) -> dict[str, Any]:
        """Numbers for JSON."""
        told = vars(self)
        return {"log_chance" if name == "log_p_value" else name: told[name] for name in told}

    def text(self, units: Units) -> str:
        """In words."""
        size = f"{self.amplitude:.3g} {units.command}, {share_text(self.share)} of the gap"
        if self.coordinate == "frequency":
            return f"at {self.value:.4g} Hz: {size}"
        return f"every {length_text(self.value, units)} of position: {size}"


@dataclass(frozen=True, eq=False, repr=False)
class Location(ByValue):
    """Where logs and a model disagree after the model was re-tuned.

    Attributes:
        shapes: residual shapes, one a coordinate, the likeliest first.
        waves: forces that repeat themselves, the strongest first.
        residual: rms of what the re-tuned model leaves in rows in motion, V.
        model: re-tuned model.
        series: rows of the logs by name, for the figures: time, position, velocity, acceleration, command, gap, mask.
    """

    shapes: tuple[Shape, ...]
    waves: tuple[Wave, ...]
    residual: float
    model: Model
    series: dict[str, list[FloatArray]]

    def _brief(self) -> str:
        first = max(self.significant, key=lambda shape: shape.share, default=None)
        told = "no coordinate stands out" if first is None else f"{100 * first.share:.0f} % by {first.coordinate}"
        return f"gap {self.residual:.4g} {self.model.units.command} rms, {told}"

    @property
    def significant(self) -> tuple[Shape, ...]:
        """The coordinates in which noise alone would not show as much."""
        return tuple(shape for shape in self.shapes if shape.log_p_value < TOLD)

    def lines(self) -> list[str]:
        """Coordinates, periods and frequencies in words, by the share of the gap that each explains."""
        units = self.model.units
        told = [(shape.share, shape_text(shape, units)) for shape in self.significant]
        told += [(wave.share, wave.text(units)) for wave in self.waves]
        return [line for _, line in sorted(told, key=lambda one: -one[0])]

    def text(self) -> str:
        """For the screen."""
        lines, gap = self.lines(), f"gap {self.residual:.4g} {self.model.units.command} rms"
        if not lines:
            return f"{gap}: no coordinate explains more of it than noise would"
        return "\n".join([f"{gap}; shares overlap, since coordinates go together", *lines])

    def to_dict(self) -> dict[str, Any]:
        """Numbers for JSON; what is not finite is None."""
        units = self.model.units
        told = {
            "residual": self.residual,
            "coordinates": [
                {
                    "coordinate": shape.coordinate,
                    "unit": units.of(shape.unit),
                    "share": shape.share,
                    "log_chance": shape.log_p_value,
                    "where": ranges(shape, units),
                    "places": shape.places.tolist(),
                    "force": shape.force.tolist(),
                    "deviation": shape.deviation.tolist(),
                }
                for shape in self.shapes
            ],
            "waves": [wave.to_dict() | {"unit": units.of(wave.unit)} for wave in self.waves],
        }
        return {name: finite(value) for name, value in told.items()}

    def plot(self, *, units: Any = None, ax: Any = None) -> Figure:
        """Draw the gap against position, speed, time and command, with 95 % bands (cogging.plot.residual).

        Args:
            units: labels of command and position (cogging.Units); None: those of the model.
            ax: four axes; None: a new figure.

        Returns:
            The figure.
        """
        return plot.residual(self, units=units, ax=ax).figure
