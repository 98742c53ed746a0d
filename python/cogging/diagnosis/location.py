"""Location of a gap by coordinate, spatial period and frequency, as `cogging.diagnosis.locate` computes it."""

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

SIGNIFICANT = -9.5  # largest ln p of a coordinate or wave that is reported


@dataclass(frozen=True)
class Wave:
    """A periodic force in position or time.

    Attributes:
        coordinate: "spatial period" or "frequency".
        value: period (m) or frequency (Hz).
        unit: m or Hz.
        amplitude: amplitude of the force, V.
        log_p_value: ln of the probability that noise alone shows such a wave at any period or frequency.
        share: share of the gap's power.
    """

    coordinate: str
    value: float
    unit: str
    amplitude: float
    log_p_value: float
    share: float

    def to_dict(self) -> dict[str, Any]:
        """Return the entry of the JSON result."""
        return {"log_chance" if name == "log_p_value" else name: value for name, value in vars(self).items()}

    def text(self, units: Units) -> str:
        """Return the wave in words."""
        size = f"{self.amplitude:.3g} {units.command}, {share_text(self.share)} of the gap"
        if self.coordinate == "frequency":
            return f"at {self.value:.4g} Hz: {size}"
        return f"every {length_text(self.value, units)} of position: {size}"


@dataclass(frozen=True, eq=False, repr=False)
class Location(ByValue):
    """Location of the gap between logs and a re-tuned model.

    Attributes:
        shapes: unexplained force along each coordinate, the most significant first.
        waves: periodic forces, the strongest first.
        residual: rms of the unexplained force over rows in motion, V.
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
        where = "no coordinate is significant" if first is None else f"{100 * first.share:.0f} % by {first.coordinate}"
        return f"gap {self.residual:.4g} {self.model.units.command} rms, {where}"

    @property
    def significant(self) -> tuple[Shape, ...]:
        """Coordinates along which the unexplained force exceeds noise."""
        return tuple(shape for shape in self.shapes if shape.log_p_value < SIGNIFICANT)

    def lines(self) -> list[str]:
        """Return coordinates, periods and frequencies in words, in the order of their share of the gap."""
        units = self.model.units
        lines = [(shape.share, shape_text(shape, units)) for shape in self.significant]
        lines += [(wave.share, wave.text(units)) for wave in self.waves]
        return [line for _, line in sorted(lines, key=lambda one: -one[0])]

    def text(self) -> str:
        """Return the location for the screen."""
        lines, gap = self.lines(), f"gap {self.residual:.4g} {self.model.units.command} rms"
        if not lines:
            return f"{gap}: no coordinate explains more of it than noise would"
        return "\n".join([f"{gap}; shares overlap, because coordinates are correlated", *lines])

    def to_dict(self) -> dict[str, Any]:
        """Return numbers for JSON; None stands for values that are not finite."""
        units = self.model.units
        entries = {
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
        return {name: finite(value) for name, value in entries.items()}

    def plot(self, *, units: Any = None, ax: Any = None) -> Figure:
        """Draw the gap against position, speed, time and command, with 95 % bands (cogging.plot.residual).

        Args:
            units: labels of command and position (cogging.Units); by default those of the model.
            ax: four axes; by default a new figure.

        Returns:
            The figure.
        """
        return plot.residual(self, units=units, ax=ax).figure
