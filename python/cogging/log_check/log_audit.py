"""Facts about a log before a model is fitted to it: time base, encoder, motion, command, controller."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cogging.arrays import FloatArray
from cogging.calls import check_arguments
from cogging.files import InputError, errors_of
from cogging.log_check.controller_check import VERDICTS, ControllerCheck, check_controller
from cogging.log_check.encoder_readings import encoder_quantum, find_outliers
from cogging.logs.log import READ_WITH, Log, require_sizes
from cogging.model.model import Model
from cogging.model.units import Units
from cogging.resources import on_one_blas_thread, require_rows
from cogging.simulation.arguments import LOG, MODEL_ALONE, MODEL_OR_NONE
from cogging.values import ByValue

JITTER = 0.01  # of the median step
GAP = 1.5  # median steps
SHOWN = 10  # gaps and outliers listed
SMOOTHING = 0.02  # s, over which speeds are estimated
REST = 1e-3  # of the top speed
PLATEAU = 3  # consecutive rows at the extreme command that count as saturation


@dataclass(frozen=True, eq=False, repr=False)
class Audit(ByValue):
    """Facts about a log.

    Attributes:
        rows: number of rows.
        duration: s, from the first row to the last.
        rate: Hz, of the median step.
        jitter_share: share of the steps that are off the median by more than 1 %.
        jitter_rms: s, rms of step minus median, gaps left out.
        gaps: number of steps above 1.5 medians.
        gap_longest: s; 0 without gaps.
        gap_times: s, when the first ten of them begin.
        repeated_times: rows whose time does not increase: always 0, since a Log refuses them.
        encoder_quantum: m, step of the readings; 0 if there is none.
        travel: m, lowest and highest reading without outliers.
        speed: m/s, lowest and highest, smoothed over 20 ms.
        acceleration: m/s^2, likewise.
        share_at_rest: share of the rows slower than a thousandth of the top speed or one quantum in 20 ms.
        command: V, lowest and highest.
        command_rms: V.
        saturation_share: share of the rows on a plateau of three or more rows at the lowest or highest command.
        outliers: number of single readings that deviate by more than 5 times the changes around them.
        outlier_rows: the first ten of them, from 0.
        read_with: properties of the log's file that affect its numbers: decimal commas.
        controller: comparison with the stated controller; None without a model or a stated controller.
        units: labels of the units, of the model or, without one, of the log.
        begins_at: s, time of the first row.
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
        line = f"{self.rows} rows, {self.duration:.6g} s at {self.rate:.6g} Hz, {self.gaps} gaps"
        return line if self.controller is None else f"{line}, {self.controller!r}"

    def to_dict(self) -> dict[str, Any]:
        """All fields for JSON; `units` if the model has its own labels."""
        document = dataclasses.asdict(self)
        for part in (document, document["controller"] or {}):
            part.pop("units", None)
        return document if self.units == Units() else document | {"units": self.units.to_dict()}

    def text(self) -> str:
        """The facts in a few lines."""
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
            lines.append(f"time begins at {self.begins_at:.6g} s: times of effects count from the first row")
        lines += [f"read with {', '.join(self.read_with)}"] * bool(self.read_with)
        return "\n".join([*lines, *(() if self.controller is None else _controller_lines(self.controller))])


def _controller_lines(check: ControllerCheck) -> list[str]:
    lines, unit = [], check.units.command
    if check.difference_rms is not None and check.relative is not None:
        size = f"{check.difference_rms:.3g} {unit} rms, {100 * check.relative:.3g} % of it"
        lines.append(f"the stated {check.type} {VERDICTS[check.reproduces]} the command: difference {size}")
    if check.best_shift:
        lines.append(f"moved by {check.best_shift} rows: {check.best_shift_rms:.3g} {unit} rms")
    if check.fitted and check.fitted_rms is not None:
        both = [(name, value, check.stated[name]) for name, value in check.fitted.items()]
        gains = ", ".join(f"{name} {fitted:.5g} ({stated:.5g} stated)" for name, fitted, stated in both)
        lines.append(f"gains that fit: {gains}; difference {check.fitted_rms:.3g} {unit} rms")
    return lines + [f"note: {note}" for note in check.notes]


@check_arguments(log=LOG, model=MODEL_OR_NONE)
@on_one_blas_thread(scipy=False)
def audit(log: Log, model: Model | None = None) -> Audit:
    """Summarise a log, and compare it with the controller that a model states (see check_controller).

    Speeds are slopes of position over 20 ms and accelerations slopes of those, so that quantisation and jitter are not
    amplified; gaps are omitted.

    Args:
        log: at least two rows.
        model: its controller is compared with the log; None: no comparison.

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
    time, position = (np.delete(column, outliers) for column in (log.time, log.position))
    quantum = encoder_quantum(position)
    half = max(2, min(round(0.5 * SMOOTHING / step), (time.size - 1) // 8)) if step > 0.0 else 2
    speed, middle = _slope(time, position, half, step)
    acceleration, _ = _slope(middle, speed, half, step)
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


def _slope(time: FloatArray, values: FloatArray, half: int, step: float) -> tuple[FloatArray, FloatArray]:
    """Slopes over 2 half + 1 rows and their times: the linear fit over rows of values over that of time."""
    if time.size < 2 * half + 1:
        return np.empty(0), np.empty(0)
    weights = np.arange(half, -half - 1, -1, dtype=np.float64)  # np.convolve turns it round
    run = np.convolve(time - time[0], weights, mode="valid")
    rise = np.convolve(values - values[0], weights, mode="valid")
    whole = time[2 * half :] - time[: time.size - 2 * half] < (2 * half + 1) * GAP * step
    return (rise / run)[whole], time[half : time.size - half][whole]


def _plateau_share(command: FloatArray) -> float:
    low, high = _range(command)
    rows = 0
    for level in (low, high) if high > low else ():
        at_level = np.abs(command - level) <= 1e-6 * (high - low)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], at_level, [False]]).astype(np.int8)))
        lengths = edges[1::2] - edges[::2]
        rows += int(lengths[lengths >= PLATEAU].sum())
    return rows / command.size


def _range(values: FloatArray) -> tuple[float, float]:
    return (float(values.min()), float(values.max())) if values.size else (0.0, 0.0)


SATURATED = 0.02  # of the rows, at the limit of the command
AT_REST = 0.5  # of the rows
MISSING = 0.005  # share of the time in gaps ...
PLACES = 5  # ... if there are at least so many: fewer are pauses, not lost samples
JITTER_SHARE, JITTER_RMS = 0.05, 0.02  # share of uneven steps, and their rms relative to the step
SLOW = 0.1  # s from row to row: friction and cogging act between such rows
QUANTUM = 1.5  # largest ratio of the step of the readings to the stated resolution


def hints(found: Audit, model: Model) -> list[str]:
    """Remarks on saturation, rest, lost samples, slow or uneven rows and a coarse encoder, where they matter."""
    of, step, stated = model.units.of, 1.0 / found.rate, model.encoder.resolution
    top = max(abs(value) for value in found.command)
    enough = found.duration > 0.0 and found.gaps >= PLACES
    missing = 1.0 - (found.rows - 1) / found.rate / found.duration if enough else 0.0
    jitter = f"{found.jitter_rms:.2g} s rms ({100 * found.jitter_rms / step:.2g} % of a step)"
    said = {
        f"the command stands at its limit ({top:.4g} {of('V')}) in {100 * found.saturation_share:.2g} % of the rows: "
        "the controller's demand beyond it is unknown": found.saturation_share > SATURATED,
        f"{100 * found.share_at_rest:.0f} % of the rows are at rest, where friction hides every force, and do not "
        "count": found.share_at_rest > AT_REST,
        f"rows are missing in {found.gaps} places, {100 * missing:.2g} % of the time, at most "
        f"{found.gap_longest:.3g} s in a row: the motion in between is unknown": missing > MISSING,
        f"rows are {step:.3g} s apart, and friction and cogging act between them: give --scale time=0.001 "
        "if the time is in ms": step > SLOW,
        f"rows are uneven by {jitter}: shorter delays and lags are not identifiable": found.jitter_share > JITTER_SHARE
        and found.jitter_rms > JITTER_RMS * step,
        f"readings step by {found.encoder_quantum:.4g} {of('m')}, the model's encoder by {stated:.4g} {of('m')}": (
            found.encoder_quantum > QUANTUM * stated > 0.0
        ),
    }
    return [hint for hint, matters in said.items() if matters]


ANGLES = {math.pi / 180.0: "degrees", 2.0 * math.pi: "turns"}
TIME_UNITS = {1e-3: "ms", 1e-6: "us"}


@check_arguments(log=LOG, model=MODEL_ALONE)
def check_against_model(log: Log, model: Model, name: str = "log") -> None:
    """Refuse a log whose units cannot be those of the model.

    The readings must fit into the model's travel and span about as much as the reference, and the time step must not
    differ from the controller's by a factor of a thousand.

    Args:
        log: the log.
        model: gives travel and sample rate.
        name: of the log's file, for the error.

    Raises:
        InputError: names the column, the figures and the scale to state.

    Example:
        >>> in_mm = cogging.Log(log.time, 1e3 * log.position, log.command)
        >>> cogging.check_against_model(in_mm, model)
        Traceback (most recent call last):
            ...
        cogging.files.InputError: log: position: spans ... but the model's travel is 0.51 m: give ...
    """
    with errors_of(name):
        require_sizes(log)
    low, high = _range(np.delete(log.position, find_outliers(log.position)))
    span, (start, end), unit, others = high - low, model.axis.travel, model.units.position, position_units(model.units)
    length = end - start
    if math.isfinite(length) and span > 1.5 * length:
        factor = next((f for f in others if span * f <= 1.02 * length), None)
        rule = f"spans {span:.4g} {unit} but the model's travel is {length:.4g} {unit}"
        raise InputError(f"{name}: position: {rule}: give {_advice('position', factor, others)}")
    if math.isfinite(length) and (low > end + length or high < start - length):
        rule = f"lies in [{low:.4g}, {high:.4g}] {unit}, far outside the model's travel [{start:.4g}, {end:.4g}] {unit}"
        raise InputError(f"{name}: position: {rule}")
    sizes = {"position": span, "reference": 0.0 if log.reference is None else float(np.ptp(log.reference))}
    wide, narrow = sorted(sizes, key=lambda column: -sizes[column])
    ratio = sizes[wide] / sizes[narrow] if sizes[narrow] > 0.0 else 0.0
    for factor in others if ratio > 30.0 else ():
        if 0.7 < ratio * factor < 1.4:
            rule = f"spans {sizes[wide]:.4g} {unit} but the {narrow} {sizes[narrow]:.4g} {unit}"
            raise InputError(f"{name}: {wide}: {rule}: give {_advice(wide, factor, others)}")
    if model.controller is not None:
        step, rate = float(np.median(np.diff(log.time))), model.controller.sample_rate
        for factor in TIME_UNITS:
            if abs(step * factor * rate - 1.0) < 0.02:
                rule = f"has rows {step:.4g} s apart but the model's controller samples at {rate:g} Hz"
                raise InputError(f"{name}: time: {rule}: give {_advice('time', factor, TIME_UNITS)}")


def position_units(units: Units) -> dict[float, str]:
    """Other units of a position, by the factor to the model's unit, the likelier first."""
    small = {1e-3: units.of("mm"), 1e-6: units.of("um")}
    return ANGLES | small if units.position == "rad" else small | {1e-2: "cm", 0.0254: "inches"}


def _advice(column: str, factor: float | None, units: dict[float, str]) -> str:
    if factor is None:
        return f"--scale {column}=FACTOR"
    return f"--scale {column}={factor:g} if it is in {units[factor]}"
