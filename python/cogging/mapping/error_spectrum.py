"""The spatial spectrum of a tracking error: which periods a controller should cancel."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cogging import plot
from cogging.arrays import FloatArray
from cogging.calls import check_arguments
from cogging.logs.log import Log
from cogging.model.units import Units
from cogging.plot.canvas import plot_method
from cogging.resources import on_one_blas_thread
from cogging.simulation.arguments import LOG
from cogging.tables import frame_of
from cogging.values import ByValue

OVERSAMPLING = 8  # frequencies per resolution of the travel
THRESHOLD = 8.0  # times the noise level (median of the remaining amplitudes): a stronger line is proposed
POINTS_PER_PERIOD = 8.0  # of the shortest period, used at most
CONSTANT = 0.98  # of the top speed: counts as constant speed


@dataclass(frozen=True, eq=False, repr=False)
class TrackingSpectrum(ByValue):
    """Amplitudes of a tracking error against spatial period, on the parts of constant speed.

    Attributes:
        frequency: 1/m, (n,); amplitude: m, (n,), of the strokes' mean power.
        noise: m, the median amplitude without the proposed lines.
        resolution: 1/m, one over the travel at constant speed: closer lines are not resolved.
        periods: m, proposed for cancellation, strongest first; period_amplitudes: m.
        units: labels of the log's units.
    """

    frequency: FloatArray
    amplitude: FloatArray
    noise: float
    resolution: float
    periods: tuple[float, ...]
    period_amplitudes: tuple[float, ...]
    units: Units = field(default_factory=Units)

    plot = plot_method(plot.spectrum, "Draw amplitude over spatial frequency, and the proposed periods.", "axes")

    def to_frame(self) -> Any:
        """Frequencies and amplitudes as a pandas DataFrame (extra `frames`), with units in `attrs["units"]`."""
        units = {"frequency": self.units.of("1/m"), "amplitude": self.units.position}
        return frame_of({"frequency": self.frequency, "amplitude": self.amplitude}, units)

    def _brief(self) -> str:
        milli, micro = self.units.of("mm"), self.units.of("um")
        pairs = zip(self.periods, self.period_amplitudes, strict=True)
        lines = [f"{1e3 * period:.4g} {milli} {1e6 * amplitude:.3g} {micro}" for period, amplitude in pairs]
        return f"{', '.join(lines) or 'no line'}; noise {1e6 * self.noise:.3g} {micro}"


@check_arguments(log=LOG)
@on_one_blas_thread(scipy=True)
def tracking_spectrum(
    log: Log, *, shortest_period: float = 2e-3, most: int = 8, share: float = 0.15
) -> TrackingSpectrum:
    """Find the spatial periods in the tracking error of a log.

    On every stretch of constant speed the error is fitted by a constant and a sine and cosine of each frequency against
    position (least squares). The powers of the stretches are averaged, since the phase differs with direction. The
    strongest line is removed from every stretch, and the rest searched again.

    Args:
        log: with a reference.
        shortest_period: m, the shortest one searched.
        most: at most so many periods are proposed.
        share: of the strongest line's amplitude that a further one must have, beside standing above the noise.

    Returns:
        The spectrum, and the periods that it proposes to cancel, strongest first.

    Raises:
        ValueError: no reference, or no stretch of constant speed three shortest periods long.

    Example:
        >>> spectrum = cogging.tracking_spectrum(log)
        >>> [f"{1e3 * period:.0f} mm" for period in spectrum.periods]
        ['49 mm', '25 mm']
    """
    from scipy.optimize import minimize_scalar

    stretches = _stretches(log, shortest_period)
    travel = max((float(np.ptp(x)) for x, _ in stretches), default=0.0)
    if travel < 3 * shortest_period:
        rule, unit = "must hold a stretch of constant speed of", log.units.position
        raise ValueError(f"log: {rule} {3 * shortest_period:g} {unit} or more, got {travel:g} {unit}")
    stretches = [(x, e) for x, e in stretches if np.ptp(x) > 0.5 * travel]
    step, rest = 1.0 / (OVERSAMPLING * travel), [e for _, e in stretches]
    frequency = np.arange(1.0 / travel, 1.0 / shortest_period, step)
    angles = [2 * np.pi * np.outer(frequency, x - x.mean()) for x, _ in stretches]
    bases = [(np.sin(angle), np.cos(angle)) for angle in angles]
    first = amplitude = _amplitude(bases, rest)
    found: list[tuple[float, float]] = []
    while len(found) < most:
        peak = int(np.argmax(amplitude))
        strongest = found[0][1] if found else 0.0
        if amplitude[peak] < max(THRESHOLD * float(np.median(amplitude)), share * strongest):
            break

        def left(line: float, rest: list[FloatArray] = rest) -> float:
            return sum(float(np.sum(_without(x, e, [line]) ** 2)) for (x, _), e in zip(stretches, rest, strict=True))

        ends = float(frequency[peak]) - step, float(frequency[peak]) + step
        line = float(minimize_scalar(left, bounds=ends, method="bounded", options={"xatol": 1e-6 * step}).x)
        found.append((1.0 / line, float(amplitude[peak])))
        # All lines together, anew: those found first were shifted by those still hidden.
        rest = [_without(x, e, [1.0 / period for period, _ in found]) for x, e in stretches]
        amplitude = _amplitude(bases, rest)
    return TrackingSpectrum(
        frequency=frequency,
        amplitude=first,
        noise=float(np.median(amplitude)),
        resolution=1.0 / travel,
        periods=tuple(period for period, _ in found),
        period_amplitudes=tuple(size for _, size in found),
        units=log.units,
    )


def _stretches(log: Log, shortest_period: float) -> list[tuple[FloatArray, FloatArray]]:
    """Position and error of each stretch of constant speed, thinned to what the shortest period needs."""
    if log.reference is None:
        raise ValueError("reference: must be in the log to know the error, got none")
    velocity = np.gradient(log.reference, log.time) if log.reference_velocity is None else log.reference_velocity
    sign = np.where(np.abs(velocity) >= CONSTANT * np.abs(velocity).max(), np.sign(velocity), 0.0)
    parts = []
    for rows in np.split(np.arange(len(log)), np.flatnonzero(np.diff(sign)) + 1):
        if sign[rows[0]] == 0.0 or rows.size < 32:
            continue
        rows = rows[rows.size // 20 :]  # the transient after the ramp
        needed = POINTS_PER_PERIOD * float(np.ptp(log.position[rows])) / shortest_period
        rows = rows[:: max(1, int(rows.size / needed))]
        parts.append((log.position[rows], log.error[rows]))
    return parts


def _amplitude(bases: list[tuple[FloatArray, FloatArray]], errors: list[FloatArray]) -> FloatArray:
    powers = []
    for (sine, cosine), error in zip(bases, errors, strict=True):
        window = np.hanning(error.size)
        weighted = window * (error - np.average(error, weights=window)) * 2.0 / window.sum()
        powers.append((sine @ weighted) ** 2 + (cosine @ weighted) ** 2)
    return np.asarray(np.sqrt(np.mean(powers, axis=0)))


def _without(x: FloatArray, error: FloatArray, lines: list[float]) -> FloatArray:
    angle = 2 * np.pi * np.outer(x - x.mean(), lines)
    design = np.column_stack([np.ones_like(x), x - x.mean(), np.sin(angle), np.cos(angle)])
    return np.asarray(error - design @ np.linalg.lstsq(design, error, rcond=None)[0])
