"""Compare a logged command with the command of the stated controller."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cogging._core import replay_controller
from cogging.arrays import FloatArray, Mask, least_squares
from cogging.calls import check_arguments
from cogging.files import LARGEST
from cogging.log_check.controller_samples import FILLED, LONG, Samples, cubic_weights
from cogging.logs.log import Log
from cogging.logs.spikes import FEW, HIGH, between, off_neighbours, spikes
from cogging.model.model import CONTROLLERS, Model
from cogging.model.units import Units
from cogging.resources import on_one_blas_thread
from cogging.simulation.arguments import LOG, MODEL_ALONE
from cogging.values import ByValue

Columns = dict[str, FloatArray]  # regressors by the name of their gain, (n,) each
SHIFTS = (-2, -1, 0, 1, 2)  # rows by which the command is shifted
ROUGH = 1e-3  # of the rms command: smaller differences are not examined
EXPLAINS = 0.7  # of the difference: spikes are left out if less than this remains without them


@dataclass(frozen=True)
class Compared:
    """A log and the command of the stated controller for it, one entry a sample."""

    samples: Samples  # of the log
    computed: FloatArray  # V, with the initial integral
    start: FloatArray  # V, that integral, constant between gaps
    judged: Mask  # samples that are compared
    doubted: Mask  # samples whose command is a spike that the controller did not give
    unseen: Mask  # rows of the log, (n,), whose reading is a spike that the controller did not see
    shifts: Mapping[int, float]  # rms difference by the shift of the command, V


def compared(log: Log, model: Model) -> Compared:
    """Compare a log with its controller, without spikes where these explain the difference."""
    reference = log.reference
    if reference is None:
        assert log.reference_velocity is not None
        moved = 0.5 * (log.reference_velocity[1:] + log.reference_velocity[:-1]) * np.diff(log.time)
        reference = log.position[0] + np.concatenate([[0.0], np.cumsum(moved)])
    found = _compared_with(log, model, reference, np.zeros(len(log), dtype=bool), cleaned=False)
    if not found.judged.any() or found.shifts[0] <= ROUGH * root_mean_square(log.command):
        return found
    readings, commands = spikes(log.position - reference), spikes(log.command)
    for unseen, cleaned in ((readings, False), (readings, True), (np.zeros(len(log), dtype=bool), True)):
        if (unseen.any() or cleaned) and (commands.any() or not cleaned):
            other = _compared_with(log, model, reference, unseen, cleaned)
            if other.judged.any() and other.shifts[0] < EXPLAINS * found.shifts[0]:
                found = other
    return found


def _compared_with(log: Log, model: Model, reference: FloatArray, unseen: Mask, cleaned: bool) -> Compared:
    controller: Any = model.controller
    samples = Samples.of(log, reference, controller.sample_rate, unseen)
    lags: tuple[int, ...] = (0, 1)  # samples ago, of the readings that a command depends on
    if model.controller_type == "speed":
        whole = int(controller.delay * controller.sample_rate + 1e-9)
        lags = (0, whole, whole + 1, whole + 2)
    judged, applied, limit = samples.judged(lags), samples.command, controller.command_limit
    if cleaned:
        applied = between(applied, samples.time, spikes(applied))
    computed, integral, limited = _recompute(samples, applied, judged, model)
    start = np.zeros(len(computed))
    if integral:
        free = judged & (np.abs(samples.command) < limit * (1.0 - 1e-6)) if limited else judged
        start = samples.medians(samples.command - computed, free)
        if limited:
            start[samples.segment == 0] = 0.0
    computed = np.clip(computed + start, -limit, limit) if limit > 0.0 else computed + start
    doubted = doubted_commands(samples.command, computed, judged)

    def by_shift(doubted: Mask) -> dict[int, float]:
        """Rms of logged minus computed with the logged command moved back by each shift."""
        command, segment, edge, found = samples.command, samples.segment, max(SHIFTS), dict[int, float]()
        for shift in SHIFTS:
            at = np.arange(1 + edge, command.size - edge) if shift else np.flatnonzero(~doubted)
            known = samples.known[at + shift] & ~doubted[at + shift] & (segment[at] == segment[at + shift])
            at = at[judged[at] & (known | (shift == 0))]
            found[shift] = root_mean_square(command[at + shift] - computed[at])
        return found

    shifts = by_shift(doubted)
    if doubted.any() and min(shifts.values()) < 0.5 * shifts[0]:  # the timing is wrong instead
        doubted = np.zeros(len(computed), dtype=bool)
        shifts = by_shift(doubted)
    return Compared(samples, computed, start, judged & ~doubted, doubted, unseen, shifts)


def doubted_commands(command: FloatArray, computed: FloatArray, rows: Mask) -> Mask:
    """Spikes of the command that the computed command does not have; none if they are many."""
    if not rows.any():
        return rows
    left = command - computed
    left = np.abs(left - np.median(left[rows]))
    usual = max(float(np.median(left[rows])) * 1.4826, 0.1 * ROUGH * root_mean_square(command[rows]))
    found = rows & (left > HIGH * usual)
    found &= (np.abs(off_neighbours(command)) > 0.3 * left) & (np.abs(off_neighbours(computed)) < 0.2 * left)
    return found if found.sum() <= FEW * rows.sum() else np.zeros(len(rows), dtype=bool)


def _recompute(samples: Samples, applied: FloatArray, judged: Mask, model: Model) -> tuple[FloatArray, bool, bool]:
    """The stated controller's command, whether its integral may start elsewhere, and whether it reaches its limit."""
    controller: Any = model.controller
    kind, limit = model.controller_type, controller.command_limit
    limited = limit > 0.0 and np.abs(samples.command).max() >= limit * (1 - 1e-6)
    arguments = {**samples.motion, "position": samples.position}
    integral = kind == "pid" and controller.ki > 0.0
    if kind in ("pid", "cascade") and not limited:
        unlimited = CONTROLLERS[kind][1](controller.replace(command_limit=0.0))
        return _bounded(replay_controller(unlimited, **arguments)), integral, False
    fresh = model.make_controller()
    own = _bounded(replay_controller(fresh, **arguments))
    if kind in ("pid", "cascade"):
        return own, integral and bool(samples.segment[-1]), True
    # A controller with memory was updated with its own command or, after a disturbance of the command or a start in
    # mid-motion, with the logged one.
    logged = _bounded(replay_controller(fresh, **arguments, applied=applied))
    return min(own, logged, key=lambda command: root_mean_square((samples.command - command)[judged])), False, limited


def _bounded(command: FloatArray) -> FloatArray:
    """The command of a controller that may have diverged, clipped so that it can be squared."""
    return np.clip(np.nan_to_num(command, nan=LARGEST), -LARGEST, LARGEST)


def root_mean_square(values: FloatArray) -> float:
    """The rms of values (n,); infinite where there are none."""
    return float(np.sqrt(np.mean(values**2))) if values.size else float("inf")


def linear_regressors(kind: str, controller: Any, samples: Samples) -> Columns:
    """The regressors of the gains of a `pid` or `cascade`, (n,) each, by the gain's name: its command at a gain of 1.

    A `cascade` has kv and `kp kv`, in which it is linear.
    """
    make = CONTROLLERS[kind][1]
    gains = {"pid": ("kp", "ki", "kd"), "cascade": ("kp", "kv")}[kind] + ("mass", "viscous", "coulomb")
    bare = controller.replace(**dict.fromkeys(gains, 0.0), command_limit=0.0)

    def command(**gain: float) -> FloatArray:
        return np.asarray(replay_controller(make(bare.replace(**gain)), **samples.motion, position=samples.position))

    columns = {name: command(**{name: 1.0}) for name in gains if (kind, name) != ("cascade", "kp")}
    if kind == "cascade":
        # kv is so small that its own term vanishes; the product of these powers of two is exactly 1.
        columns = {"kp kv": command(kp=2.0**60, kv=2.0**-60), **columns}
    return columns


def fit_columns(columns: Columns, target: FloatArray) -> tuple[dict[str, float], float]:
    """Coefficients of columns (n,) that fit a target, and the rms of what is left."""
    table = np.stack(list(columns.values()))
    solution = least_squares(table, target, rcond=1e-12)
    return dict(zip(columns, solution.tolist(), strict=True)), root_mean_square(target - solution @ table)


def fit_samples(samples: Samples, columns: Columns, rows: Mask, integral: bool) -> tuple[dict[str, float], float, Mask]:
    """Coefficients of columns (m,) that fit the commands of some rows, the rms of what is left, and rows that counted.

    With an `integral` the rows after each gap have their own constant. Spikes that the fit does not have are left out.
    """
    target = samples.command
    if integral and samples.segment[-1]:
        target = samples.without_means(target, rows)
        columns = {name: samples.without_means(column, rows) for name, column in columns.items()}
    elif integral:
        columns = {**columns, "start": np.ones(len(target))}
    for _ in range(2):
        fitted, rms = fit_columns({name: column[rows] for name, column in columns.items()}, target[rows])
        made = np.asarray(sum(fitted[name] * column for name, column in columns.items()))
        doubted = doubted_commands(target, made, rows)
        if not doubted.any():
            break
        rows = rows & ~doubted
    fitted.pop("start", None)
    return fitted, rms, rows


def fit_gains(found: Compared, model: Model, kind: str) -> tuple[dict[str, float], dict[str, float], float | None]:
    """Stated gains, those that fit the log, and the rms that these leave; only gains that are stated above zero."""
    controller: Any = model.controller
    samples, rows = found.samples, found.judged
    regressors = linear_regressors(kind, controller, samples)
    gains = {name: float(getattr(controller, name)) for name in ("kp", *regressors) if name != "kp kv"}
    if "kp kv" in regressors:
        gains["kp kv"] = controller.kp * controller.kv
    columns = {name: column for name, column in regressors.items() if gains[name] != 0.0}
    if controller.command_limit > 0.0:
        rows = rows & (np.abs(samples.command) < controller.command_limit * (1.0 - 1e-6))
    if not columns or rows.sum() <= 2 * len(columns):
        return {}, {}, float("nan")
    fitted, rms, _ = fit_samples(samples, columns, rows, gains.get("ki", 0.0) > 0.0)
    product = fitted.pop("kp kv", None)
    if product is not None:
        fitted = {"kp": product / fitted["kv"] if fitted.get("kv") else 0.0, **fitted}
    return {name: gains[name] for name in fitted}, fitted, rms


MISMATCH = 0.05  # of the rms command: beyond it the verdict is controller_mismatch (contract)
RATE_TOLERANCE = 0.02  # of the stated sample rate
FEWEST_ROWS = 20
ENOUGH = 0.25  # of the rows, before the first gap, needed to check an adaptive controller
AT_REST = 1e-3  # of the top speed: slower is rest
VERDICTS = {True: "reproduces", False: "does not reproduce", None: "may or may not reproduce"}


@dataclass(frozen=True, eq=False, repr=False)
class ControllerCheck(ByValue):
    """Comparison of a logged command with the stated controller's for the logged references and readings.

    Attributes:
        type: of the controller, as in model files.
        reproduces: whether the difference is within 5 % of the rms command; None: unknown.
        command_rms: V, of the logged command about zero.
        difference_rms: V, logged minus recomputed, without an unknown initial integral.
        relative: difference_rms / command_rms.
        start: V, the integral term with which the log begins, 0 without an integral.
        best_shift: shift in rows, -2 to 2, at which the logged command fits best; 0 unless it gains 5 %.
        best_shift_rms: V, the difference at that shift.
        ratio: factor between the logged and the recomputed command, by least squares.
        stated: gains of the model; empty for a controller that is not linear in them.
        fitted: the same gains by least squares on the log.
        fitted_rms: V, the residual with them.
        notes: why something is unknown, or what the figures suggest.
        unseen_readings: rows with a spike of the reading that the controller did not see.
        doubted_commands: rows with a spike of the command that the controller did not give.
        units: labels of the model's units.
    """

    type: str
    reproduces: bool | None
    command_rms: float
    difference_rms: float | None = None
    relative: float | None = None
    start: float = 0.0
    best_shift: int = 0
    best_shift_rms: float | None = None
    ratio: float | None = None
    stated: Mapping[str, float] = field(default_factory=dict)
    fitted: Mapping[str, float] = field(default_factory=dict)
    fitted_rms: float | None = None
    notes: tuple[str, ...] = ()
    unseen_readings: tuple[int, ...] = ()
    doubted_commands: tuple[int, ...] = ()
    units: Units = field(default_factory=Units)

    def _brief(self) -> str:
        if self.relative is None:
            return f"{self.type} {VERDICTS[self.reproduces]} the command"
        left = f"{100 * self.relative:.3g} % of {self.command_rms:.4g} {self.units.command} rms is left"
        return f"{self.type} {VERDICTS[self.reproduces]} the command: {left}"


@check_arguments(log=LOG, model=MODEL_ALONE)
@on_one_blas_thread(scipy=False)
def check_controller(log: Log, model: Model) -> ControllerCheck | None:
    """Compare a log with the controller of a model; None where the model states none.

    `pid` and `cascade` are recomputed as their equations say (Pid, Cascade), with Ts = 1/`sample_rate` even where the
    time jitters, and their gains are fitted by least squares; every other type is run on the logged references and
    readings (replay_controller). A few missing samples are interpolated, and rows whose command depends on them are not
    compared; after a longer gap the integral is another constant. Spikes are left out if they explain the difference.

    Args:
        log: with a reference.
        model: with the controller.

    Returns:
        How far the two commands agree; None if the model states no controller.

    Example:
        >>> other = model.replace(controller=model.controller.replace(kp=9000.0))
        >>> cogging.check_controller(log, other).reproduces
        True
    """
    if model.controller is None or model.controller_type is None:
        return None
    kind, command_rms = model.controller_type, float(np.sqrt(np.mean(log.command**2)))
    refusal = _why_not(log, model, command_rms)
    found = None if refusal else compared(log, model)
    if found is not None and (rows := int(found.judged.sum())) < FEWEST_ROWS:
        refusal = f"{rows} rows between gaps are too few to check the controller, which needs {FEWEST_ROWS}"
    if found is None or refusal:
        return ControllerCheck(kind, None, command_rms, notes=(refusal,), units=model.units)
    if found.doubted.any():
        command_rms = root_mean_square(found.samples.command[found.judged])
    return _judged(found, model, kind, command_rms)


def _judged(found: Compared, model: Model, kind: str, command_rms: float) -> ControllerCheck:
    """The result of a comparison."""
    relative, best = found.shifts[0] / command_rms, min(found.shifts, key=lambda shift: found.shifts[shift])
    if found.shifts[best] > 0.95 * found.shifts[0] or found.shifts[0] < 1e-9 * command_rms:
        best = 0
    logged, computed = found.samples.command[found.judged], found.computed[found.judged]
    power = float(np.sum(computed**2))
    ratio = float(np.sum(computed * logged) / power) if power > 0.0 else None
    notes = []
    if ratio and abs(ratio - 1.0) > MISMATCH:
        doubt = "is the command in another unit (--scale command)?"
        if root_mean_square(logged - ratio * computed) <= MISMATCH * root_mean_square(logged):
            notes.append(f"the command is {ratio:.4g} times the controller's: {doubt}")
    if relative > MISMATCH and best:
        notes.append(f"the command fits better when moved by {best} rows: is it logged at another time?")
    reproduces: bool | None = relative <= MISMATCH
    if not reproduces and model.make_controller().estimates.size:
        reproduces, note = _with_estimates(found, command_rms)
        notes.append(note)
    stated, fitted, fitted_rms = fit_gains(found, model, kind) if kind in ("pid", "cascade") else ({}, {}, None)
    return ControllerCheck(
        type=kind,
        reproduces=reproduces,
        command_rms=command_rms,
        difference_rms=found.shifts[0],
        relative=relative,
        start=float(found.start[0]),
        best_shift=best,
        best_shift_rms=found.shifts[best],
        ratio=ratio,
        stated=stated,
        fitted=fitted,
        fitted_rms=fitted_rms,
        notes=tuple(notes),
        unseen_readings=tuple(np.flatnonzero(found.unseen).tolist()),
        doubted_commands=tuple(found.samples.row[found.doubted].tolist()),
        units=model.units,
    )


def _with_estimates(found: Compared, command_rms: float) -> tuple[bool | None, str]:
    """Whether an adaptive controller reproduces the part of a log with known estimates, and the reason if not."""
    samples = found.samples
    velocity = np.abs(samples.motion["reference_velocity"])
    if float(velocity[:3].max()) > AT_REST * float(velocity.max()):
        return None, "the log starts in mid-motion: the controller's estimates at its start are unknown"
    before = found.judged & (samples.segment == 0)
    if samples.segment[-1] == 0:
        return False, "the controller's estimates are assumed to start as stated"
    unknown = "the controller's estimates after a gap are unknown"
    if before.sum() < max(FEWEST_ROWS, ENOUGH * found.judged.sum()):
        return None, unknown
    left = root_mean_square(samples.command[before] - found.computed[before]) / command_rms
    return bool(left <= MISMATCH), f"{unknown}: until then the difference is {100 * left:.2g} %"


def _why_not(log: Log, model: Model, command_rms: float) -> str:
    if log.reference is None and (model.controller_type != "speed" or log.reference_velocity is None):
        return "the log has no reference: the controller cannot be recomputed"
    if len(log) < FEWEST_ROWS:
        return f"{len(log)} rows are too few to check the controller, which needs {FEWEST_ROWS}"
    if command_rms == 0.0:
        return "the command is zero throughout: there is nothing to recompute"
    assert model.controller is not None
    steps = np.diff(log.time)
    step = float(np.median(steps))  # or, where some jitter, a mean of those that are one sample long
    own = steps[(steps > 0.5 * step) & (steps < LONG * step)]
    step = float(own.mean()) if own.size and np.ptp(steps) > RATE_TOLERANCE * step else step
    rates = f"{1.0 / step:g} rows a second, the controller {model.controller.sample_rate:g} samples"
    is_other = abs(1.0 / step / model.controller.sample_rate - 1.0) > RATE_TOLERANCE
    return f"the log has {rates}: the command cannot be recomputed" if is_other else ""


def with_missing_rows(log: Log, model: Model) -> tuple[Log, str]:
    """The log with rows for missing samples between two rows, and a remark, if the model's controller made the log.

    Readings are interpolated by cubics and commands computed: a command held over the gap would look like an effect.
    """
    check = check_controller(log, model)
    if check is None or not check.reproduces or model.controller is None:
        return log, ""
    found = compared(log, model)
    samples = found.samples
    added = np.concatenate([[False], np.diff(samples.row) == 0])
    if not added.any():
        return log, ""
    position, at = log.position[samples.row], samples.time[added]
    position[added] = np.interp(at, log.time, log.position)
    if len(log) > 3:  # on the cubic through the two rows on either side; on a line beside a long gap
        rows = np.clip(np.searchsorted(log.time, at) - 1, 1, len(log) - 3) + np.arange(-1, 3)[:, None]
        offsets = log.time[rows] - at
        cubic = np.sum(cubic_weights(offsets) * log.position[rows], axis=0)
        near = offsets[3] - offsets[0] < (2 * FILLED + 3) * float(np.median(np.diff(log.time)))
        position[added] = np.where(near, cubic, position[added])
    command = np.where(added, found.computed, log.command[samples.row])
    whole = {**samples.motion, "time": samples.time, "position": position, "command": command}
    how = f"readings filled by interpolation, commands as the {check.type} gives them"
    return Log.of(whole, log.metadata), f"{int(added.sum())} samples lack a row: {how}"
