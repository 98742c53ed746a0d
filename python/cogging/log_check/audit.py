"""What a log is like before anything is concluded from it: time base, encoder, motion, command, controller."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.calls import takes
from cogging.log_check.controller import ControllerCheck, check_controller
from cogging.log_check.encoder_quantum import encoder_quantum
from cogging.log_check.outliers import find_outliers
from cogging.logs.log import READ_WITH, Log, require_sizes
from cogging.model.model import Model
from cogging.model.units import Units
from cogging.resources import on_one_blas_thread, require_rows
from cogging.simulation.arguments import LOG, MODEL_OR_NONE
from cogging.values import ByValue

JITTER = 0.01  # of the median step
GAP = 1.5  # median steps
SHOWN = 10  # places that are kept of gaps and outliers
SMOOTHING = 0.02  # s, over which a speed is taken
REST = 1e-3  # of the top speed
PLATEAU = 3  # rows in a row at the extreme command that make a saturation


@dataclass(frozen=True, eq=False, repr=False)
class Audit(ByValue):
    """Facts about a log.

    Attributes:
        rows: how many.
        duration: s, from the first row to the last.
        rate: Hz, of the median step.
        jitter_share: share of the steps that are off the median by more than 1 %.
        jitter_rms: s, rms of step minus median, gaps left out.
        gaps: number of steps above 1.5 medians.
        gap_longest: s; 0 without gaps.
        gap_times: s, when the first ten of them begin.
        repeated_times: rows whose time does not rise: always 0, since a Log refuses them.
        encoder_quantum: m, of which nearly all readings differ by multiples; 0 if there is none.
        travel: m, lowest and highest reading without outliers.
        speed: m/s, lowest and highest, smoothed over 20 ms.
        acceleration: m/s^2, likewise.
        share_at_rest: share of the rows slower than a thousandth of the top speed or one quantum in 20 ms.
        command: V, lowest and highest.
        command_rms: V.
        saturation_share: share of the rows on a plateau of three or more rows at the lowest or highest command.
        outliers: number of single readings that leave and return by more than 5 times what happens around them.
        outlier_rows: the first ten of them, from 0.
        read_with: what was found of the log's file that bears on its numbers: decimal commas.
        controller: the stated controller beside the log; None where the model states none or no model is given.
        units: labels of the units, of the model or, without one, of the log.
        begins_at: s, the time of the first row; where it is negative the text says that time counts from that row.

    Example:
        >>> print(cogging.audit(log))
        13201 rows, 2.64 s at 5000 Hz; ...
    """

    rows: int
    duration: float
    rate: float
    jitter_share: float
    jitter_rms: float
    gaps: int
    gap_longest: float
    gap_times: tuple[float, ...]
    repeated_times: int
    encoder_quantum: float
    travel: tuple[float, float]
    speed: tuple[float, float]
    acceleration: tuple[float, float]
    share_at_rest: float
    command: tuple[float, float]
    command_rms: float
    saturation_share: float
    outliers: int
    outlier_rows: tuple[int, ...]
    read_with: tuple[str, ...] = ()
    controller: ControllerCheck | None = None
    units: Units = field(default_factory=Units)
    begins_at: float = 0.0

    def _brief(self) -> str:
        told = f"{self.rows} rows, {self.duration:.6g} s at {self.rate:.6g} Hz, {self.gaps} gaps"
        if self.controller is None:
            return told
        return f"{told}, {self.controller!r}"

    def to_dict(self) -> dict[str, Any]:
        """All of it as JSON can hold it; `units` where the model has labels of its own."""
        told = dataclasses.asdict(self)
        for part in (told, told["controller"] or {}):
            part.pop("units", None)
        return told if self.units == Units() else told | {"units": self.units.to_dict()}

    def text(self) -> str:
        """A few lines for a reader."""
        of = self.units.of
        low, high = self.travel
        lines = [
            f"{self.rows} rows, {self.duration:.6g} s at {self.rate:.6g} Hz; "
            f"{100 * self.jitter_share:.2g} % of the steps off by more than 1 %, rms {self.jitter_rms:.2g} s",
            f"{self.gaps} gaps"
            + (f", the longest {self.gap_longest:.3g} s, first at {self.gap_times[0]:.6g} s" if self.gaps else ""),
            f"position {low:.6g} to {high:.6g} {of('m')}, quantum {self.encoder_quantum:.4g} {of('m')}, "
            f"{self.outliers} outliers" + (f", first in row {self.outlier_rows[0]}" if self.outliers else ""),
            f"speed {self.speed[0]:.4g} to {self.speed[1]:.4g} {of('m/s')}, acceleration {self.acceleration[0]:.4g} to "
            f"{self.acceleration[1]:.4g} {of('m/s^2')}, {100 * self.share_at_rest:.3g} % at rest",
            f"command {self.command[0]:.4g} to {self.command[1]:.4g} {of('V')}, rms {self.command_rms:.4g} {of('V')}, "
            f"{100 * self.saturation_share:.3g} % saturated",
        ]
        if self.begins_at < 0.0:
            lines.append(f"time begins at {self.begins_at:.6g} s: what acts over time counts from the first row")
        lines += [f"read with {', '.join(self.read_with)}"] * bool(self.read_with)
        return "\n".join(lines + _controller_lines(self.controller, self.units.command))


def _controller_lines(check: ControllerCheck | None, unit: str) -> list[str]:
    if check is None:
        return []
    lines = []
    if check.difference_rms is not None and check.relative is not None:
        verdict = {True: "reproduces", False: "does not reproduce", None: "may or may not reproduce"}[check.reproduces]
        lines.append(
            f"the stated {check.type} {verdict} the command: difference {check.difference_rms:.3g} {unit} rms, "
            f"{100 * check.relative:.3g} % of it"
        )
    if check.best_shift:
        lines.append(f"moved by {check.best_shift} rows: {check.best_shift_rms:.3g} {unit} rms")
    if check.fitted and check.fitted_rms is not None:
        both = [(name, value, check.stated[name]) for name, value in check.fitted.items()]
        gains = ", ".join(f"{name} {fitted:.5g} ({stated:.5g} stated)" for name, fitted, stated in both)
        lines.append(f"gains that fit: {gains}; difference {check.fitted_rms:.3g} {unit} rms")
    return lines + [f"note: {note}" for note in check.notes]


@takes(log=LOG, model=MODEL_OR_NONE)
@on_one_blas_thread(scipy=False)
def audit(log: Log, model: Model | None = None) -> Audit:
    """Look at a log, and at the controller that a model states (see check_controller).

    Speeds are slopes of position over time across 20 ms, accelerations slopes of those, so that neither the encoder's
    quantum nor jitter is differentiated row by row; gaps are left out.

    Args:
        log: at least two rows.
        model: whose controller is compared with the log; None: nothing is compared.

    Returns:
        The facts; print it to read them.

    Raises:
        ValueError: fewer than two rows.

    Example:
        >>> found = cogging.audit(log, model)
        >>> print(f"{found.rate:.0f} Hz, {found.gaps} gaps: {found.controller.reproduces}")
        5000 Hz, 0 gaps: True
    """
    if len(log) < 2:
        raise ValueError(f"log: must have at least 2 rows, got {len(log)}")
    require_sizes(log)
    require_rows("audit", [log])
    steps = np.diff(log.time)
    step = float(np.median(steps))
    is_gap = steps > GAP * step
    regular = steps[~is_gap]
    outliers = find_outliers(log.position)
    position = np.delete(log.position, outliers)
    time = np.delete(log.time, outliers)
    quantum = encoder_quantum(position)
    speed, acceleration = _motion(time, position, step)
    still = max(REST * float(np.abs(speed).max(initial=0.0)), quantum / SMOOTHING)
    return Audit(
        rows=len(log),
        duration=float(log.time[-1] - log.time[0]),
        rate=1.0 / step if step > 0.0 else math.inf,
        jitter_share=float(np.mean(np.abs(steps - step) > JITTER * step)),
        jitter_rms=float(np.sqrt(np.mean((regular - step) ** 2))) if regular.size else 0.0,
        gaps=int(is_gap.sum()),
        gap_longest=float(steps[is_gap].max(initial=0.0)),
        gap_times=tuple(log.time[:-1][is_gap][:SHOWN].tolist()),
        repeated_times=int((steps <= 0.0).sum()),
        encoder_quantum=quantum,
        travel=_range(position),
        speed=_range(speed),
        acceleration=_range(acceleration),
        share_at_rest=float(np.mean(np.abs(speed) <= still)) if speed.size else 0.0,
        command=_range(log.command),
        command_rms=float(np.sqrt(np.mean(log.command**2))),
        saturation_share=_plateau_share(log.command),
        outliers=outliers.size,
        outlier_rows=tuple(outliers[:SHOWN].tolist()),
        read_with=tuple(log.metadata.get(READ_WITH, ())),
        controller=check_controller(log, model) if model is not None else None,
        units=log.units if model is None else model.units,
        begins_at=float(log.time[0]),
    )


def _motion(time: FloatArray, position: FloatArray, step: float) -> tuple[FloatArray, FloatArray]:
    """Speed and acceleration, smoothed; empty where the log is too short."""
    half = max(2, min(round(0.5 * SMOOTHING / step), (time.size - 1) // 8)) if step > 0.0 else 2
    speed, middle = _slope(time, position, half, step)
    acceleration, _ = _slope(middle, speed, half, step)
    return speed, acceleration


def _slope(time: FloatArray, values: FloatArray, half: int, step: float) -> tuple[FloatArray, FloatArray]:
    """Slopes over 2 half + 1 rows and their times: the linear fit over rows of values over that of time."""
    if time.size < 2 * half + 1:
        return np.empty(0), np.empty(0)
    weights = np.arange(half, -half - 1, -1, dtype=np.float64)  # np.convolve turns it round
    run = np.convolve(time - time[0], weights, mode="valid")
    rise = np.convolve(values - values[0], weights, mode="valid")
    whole = time[2 * half :] - time[: time.size - 2 * half] < (2 * half + 1) * GAP * step
    middle = time[half : time.size - half]
    return (rise / run)[whole], middle[whole]


def _plateau_share(command: FloatArray) -> float:
    low, high = _range(command)
    if high <= low or command.size < PLATEAU:
        return 0.0
    share = 0
    for level in (low, high):
        at_level = np.abs(command - level) <= 1e-6 * (high - low)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], at_level, [False]]).astype(np.int8)))
        lengths = edges[1::2] - edges[::2]
        share += int(lengths[lengths >= PLATEAU].sum())
    return share / command.size


def _range(values: FloatArray) -> tuple[float, float]:
    return (float(values.min()), float(values.max())) if values.size else (0.0, 0.0)
