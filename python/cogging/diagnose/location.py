"""Where a gap sits, on its own: by coordinate, by spatial period and by frequency, before anything is named."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from cogging._core import EFFECTS, DivergedError
from cogging.audit import check_against_model
from cogging.diagnose.evidence import Evidence, orthonormal
from cogging.diagnose.null import fit_null
from cogging.diagnose.rest import Shape, low_power, shapes
from cogging.diagnose.result import finite
from cogging.diagnose.scan import Finding, judged, sharpen
from cogging.diagnose.signatures import tables
from cogging.diagnose.waves import is_wave, peaks, refine
from cogging.logs import Log, read_log
from cogging.model import Model

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

SIGNIFICANT = -9.5  # ln of the chance from which a coordinate is told
STRONG = 3.0  # deviations from which a place counts
WAVES_MAX = 5
TURNS_MIN = 4.0  # over the travel or the log: slower waves are told by the coordinates
WAVE_MIN = 0.1  # of the strongest wave's share: weaker ones are its shadows


@dataclass(frozen=True)
class Wave:
    """A force that repeats itself, in place or in time.

    Attributes:
        coordinate: "spatial period" (m) or "frequency" (Hz).
        value: of the period, or frequency.
        unit: m or Hz.
        amplitude: V.
        log_chance: ln of the chance that noise alone shows as much at any period or frequency.
        share: of the gap's power below 60 Hz.
    """

    coordinate: str
    value: float
    unit: str
    amplitude: float
    log_chance: float
    share: float

    def text(self) -> str:
        """In words."""
        size = f"{self.amplitude:.3g} V, {_share(self.share)} of the gap"
        if self.coordinate == "frequency":
            return f"at {self.value:.4g} Hz: {size}"
        return f"every {length_text(self.value)} of position: {size}"


@dataclass(frozen=True)
class Location:
    """Where logs and a model disagree after the model was re-tuned.

    Attributes:
        shapes: force of any shape in each coordinate, the likeliest first.
        waves: what repeats itself, the strongest first.
        residual: rms of what the re-tuned model leaves in rows in motion, V.
        model: re-tuned.
        series: rows of the logs by name, for the figures: time, position, velocity, acceleration, command, gap, counts.
    """

    shapes: tuple[Shape, ...]
    waves: tuple[Wave, ...]
    residual: float
    model: Model
    series: dict[str, list[FloatArray]]

    @property
    def significant(self) -> tuple[Shape, ...]:
        """The coordinates in which noise alone would not show as much."""
        return tuple(shape for shape in self.shapes if shape.log_chance < SIGNIFICANT)

    def lines(self) -> list[str]:
        """Coordinates by the share of the gap that each explains, then periods and frequencies; in words."""
        ranked = sorted(self.significant, key=lambda shape: -shape.share)
        told = [f"{shape.coordinate} explains {_share(shape.share)} of the gap: {ranges(shape)}" for shape in ranked]
        return told + [wave.text() for wave in self.waves]

    def text(self) -> str:
        """For the screen."""
        lines = self.lines()
        if not lines:
            return f"gap {self.residual:.4g} V rms: no coordinate explains more of it than noise would"
        return "\n".join([f"gap {self.residual:.4g} V rms; shares overlap, since coordinates go together", *lines])

    def to_dict(self) -> dict[str, Any]:
        """Numbers for JSON; what is not finite is None."""
        told = {
            "residual": self.residual,
            "coordinates": [
                {
                    "coordinate": shape.coordinate,
                    "unit": shape.unit,
                    "share": shape.share,
                    "log_chance": shape.log_chance,
                    "where": ranges(shape),
                    "places": shape.places.tolist(),
                    "force": shape.force.tolist(),
                    "deviation": shape.deviation.tolist(),
                }
                for shape in self.shapes
            ],
            "waves": [vars(wave) for wave in self.waves],
        }
        return {name: finite(value) for name, value in told.items()}

    def plot(self) -> Figure:
        """The gap against position, speed, acceleration, command and time with 95 % bands, and its spectrum."""
        from cogging.diagnose.figures import coordinates_figure

        return coordinates_figure({"as re-tuned": self.series})


def locate_gap(
    logs: Log | str | os.PathLike[str] | Sequence[Log | str | os.PathLike[str]],
    model: Model | str | os.PathLike[str],
) -> Location:
    """Say where logs and a model disagree: in which coordinate, where in it, at which period or frequency.

    The model is re-tuned first, as far as its statement allows; what is left is tested against a force of any shape in
    each coordinate and against waves in place and in time. No effect is named.

    Raises:
        ValueError: a log or model that cannot be used.
        InputError: a file that cannot be read.
    """
    if not isinstance(model, Model):
        model = Model.read(model)
    if isinstance(logs, Log | str | os.PathLike):
        logs = [logs]
    read = [log if isinstance(log, Log) else read_log(log) for log in logs]
    if not read:
        raise ValueError("logs: must be at least 1, got 0")
    for i, log in enumerate(read):
        check_against_model(log, model, f"log {i + 1}")
    estimate, evidence = fit_null(read, model)
    return location_of(evidence, estimate.model)


def location_of(evidence: Evidence, model: Model, found: Sequence[Shape] | None = None) -> Location:
    """The location of what evidence of a re-tuned model leaves; `found`: its shapes, where they are known."""
    counts = np.concatenate([source.counts > 0 for source in evidence.sources])
    left = np.concatenate(evidence.residuals)[counts]
    return Location(
        tuple(shapes(evidence) if found is None else found),
        tuple(waves_of(evidence)),
        float(np.sqrt(np.mean(left**2))),
        model,
        series_of(evidence, evidence.residuals),
    )


def series_of(evidence: Evidence, gap: Sequence[FloatArray]) -> dict[str, list[FloatArray]]:
    """Rows of the logs by name, with a gap (V), one (n,) a log."""
    series: dict[str, list[FloatArray]] = {"gap": [np.asarray(row) for row in gap]}
    for source in evidence.sources:
        log, velocity = source.log, source.along.velocity
        few = max(1, round(0.02 / source.scales.sample_time))
        smooth = np.convolve(velocity, np.ones(few) / few, mode="same")
        for name, values in (
            ("time", log.time),
            ("position", log.position),
            ("command", log.command),
            ("velocity", velocity),
            ("acceleration", np.gradient(smooth, log.time)),
            ("counts", source.counts > 0),
        ):
            series.setdefault(name, []).append(np.asarray(values))
    return series


def waves_of(evidence: Evidence) -> list[Wave]:
    """Waves of force in place and in time, the strongest first, each seen beside those before it.

    The list of effects is asked which of them are a plain force of one period or of one frequency.
    """
    kinds = [name for name, effect in EFFECTS.items() if is_wave(effect) and set(effect.HOOKS) == {"force"}]
    found: list[Wave] = []
    power = low_power(evidence)
    for _ in range(WAVES_MAX):
        best: Finding | None = None
        for name in kinds:
            for finding in _waves(evidence, name):
                if best is None or finding.score > best.score:
                    best = finding
        if best is None or best.log_chance > SIGNIFICANT:
            break
        best = sharpen(evidence, best)
        field, value = next(iter(best.candidate.shape.items()))
        if found and best.test.statistic / power < WAVE_MIN * found[0].share:
            break
        spatial = EFFECTS[best.name].ROLES[field]["quantity"] == "distance"
        found.append(
            Wave(
                "spatial period" if spatial else "frequency",
                float(value),
                "m" if spatial else "Hz",
                float(np.hypot(*best.amplitudes)),
                best.log_chance,
                min(1.0, best.test.statistic / power),
            )
        )
        columns = evidence.project(evidence.whitened(tables(evidence, [best.candidate])[0]))
        evidence = replace(evidence, basis=np.vstack([evidence.basis, orthonormal(columns)]))
    return sorted(found, key=lambda wave: -wave.share)


def _waves(evidence: Evidence, name: str) -> list[Finding]:
    found, looked = peaks(evidence, name)
    spatial = next(r for r in EFFECTS[name].ROLES.values() if r["role"] == "shape")["quantity"] == "distance"
    scales = evidence.scales

    def turns(value: float) -> float:
        return scales.position / value if spatial else scales.time * value

    fast = [candidate for candidate in found if turns(next(iter(candidate.shape.values()))) >= TURNS_MIN]
    try:
        return judged(evidence, refine(evidence, fast[:2]), looked)
    except (DivergedError, ValueError):
        return []


# In words -------------------------------------------------------------------------------------------------------------


def ranges(shape: Shape) -> str:
    """In which ranges of a coordinate its force differs from zero, in words."""
    m = len(shape.places)
    sides = [("", shape.force, shape.deviation)]
    if len(shape.force) == 2 * m:
        sides = [
            ("forward", shape.force[:m], shape.deviation[:m]),
            ("backward", shape.force[m:], shape.deviation[m:]),
        ]
    if shape.coordinate == "velocity":
        return _about_rest(shape)
    told = []
    for side, force, deviation in sides:
        spans = [_span(shape, force, deviation, peak) for peak in _peaks(force, deviation)]
        if spans:
            told.append(((side + " ") if side else "") + ", ".join(spans))
    return "; ".join(told) or "spread over its whole range, strong nowhere"


def _peaks(force: FloatArray, deviation: FloatArray) -> list[int]:
    """The strongest place of each run of one sign, at most two runs, those of a tenth of the strongest and above."""
    strong = np.abs(force) > STRONG * np.where(deviation > 0.0, deviation, np.inf)
    runs, current = [], -1
    for i in range(len(force)):
        if not strong[i]:
            current = -1
        elif current < 0 or force[i] * force[current] < 0.0:
            runs.append(i)
            current = i
        elif abs(force[i]) > abs(force[runs[-1]]):
            runs[-1] = current = i
    runs.sort(key=lambda i: -abs(force[i]))
    return [i for i in runs[:2] if abs(force[i]) >= 0.1 * abs(force[runs[0]])]


def _span(shape: Shape, force: FloatArray, deviation: FloatArray, peak: int) -> str:
    strong = (np.abs(force) > STRONG * np.where(deviation > 0.0, deviation, np.inf)) & (force * force[peak] > 0.0)
    first = last = peak
    while first > 0 and strong[first - 1]:
        first -= 1
    while last + 1 < len(force) and strong[last + 1]:
        last += 1
    low, high = shape.places[first], shape.places[last]
    size = f"{force[peak]:+.2g} {'' if shape.coordinate.startswith(('friction', 'gain')) else 'V'}".strip()
    if first == 0 and last == len(force) - 1:
        return f"{size} at most, of one sign over the whole range"
    if first == last:
        return f"{size} about {quantity_text(shape.places[peak], shape.unit)}"
    return f"{size} from {quantity_text(low, shape.unit)} to {quantity_text(high, shape.unit)}"


def _about_rest(shape: Shape) -> str:
    """Velocities are told from rest: how far, and in which direction."""
    told = {}
    for label, side in (("forward", 1.0), ("backward", -1.0)):
        mine = side * shape.places >= 0.0
        force, deviation = shape.force[mine], shape.deviation[mine]
        speed = np.abs(shape.places[mine])
        strong = np.abs(force) > STRONG * np.where(deviation > 0.0, deviation, np.inf)
        if (strong & (speed > 0.0)).any() or (strong.any() and len(speed) == 1):
            peak = int(np.argmax(np.abs(force) * strong))
            order = np.argsort(speed)
            ranked = strong[order] & (force[order] * force[peak] > 0.0)
            place = int(np.flatnonzero(order == peak)[0])
            first = last = place
            while first > 0 and ranked[first - 1]:
                first -= 1
            while last + 1 < len(order) and ranked[last + 1]:
                last += 1
            told[label] = (speed[order][first], speed[order][last], force[peak], last == len(order) - 1)
    if not told:
        rest = np.abs(shape.force) > STRONG * np.where(shape.deviation > 0.0, shape.deviation, np.inf)
        return "at rest" if rest.any() else "spread over its whole range, strong nowhere"
    parts = []
    for label, (low, high, force, to_the_end) in told.items():
        if low <= np.min(np.abs(shape.places)[shape.places != 0.0]):
            reach = "at any speed" if to_the_end else f"within {quantity_text(high, 'm/s')} of rest"
        elif to_the_end and high > 1.1 * low:
            reach = f"above {quantity_text(low, 'm/s')}"
        elif high <= 1.1 * low:
            reach = f"about {quantity_text(high, 'm/s')}"
        else:
            reach = f"from {quantity_text(low, 'm/s')} to {quantity_text(high, 'm/s')}"
        parts.append((reach, label, force))
    if len(parts) == 2 and parts[0][0].split()[0] == parts[1][0].split()[0]:
        reach = max((part[0] for part in parts), key=len)
        return f"{reach}, both directions: {parts[0][2]:+.2g} V forward, {parts[1][2]:+.2g} V backward"
    return "; ".join(f"{reach}, {label}: {force:+.2g} V" for reach, label, force in parts)


def quantity_text(value: float, unit: str) -> str:
    """A number with its unit, in milli where that reads better."""
    if unit in ("m", "m/s") and 0.0 < abs(value) < 0.1:
        return f"{1e3 * value:.3g} m{unit}"
    return f"{value:.3g} {unit}"


def length_text(value: float) -> str:
    """A length in m, mm or um, four digits, since periods are known well."""
    if value < 1e-4:
        return f"{1e6 * value:.4g} um"
    return f"{1e3 * value:.4g} mm" if value < 0.1 else f"{value:.4g} m"


def _share(share: float) -> str:
    return f"{100.0 * share:.0f} %" if share >= 0.01 else "under 1 %"
