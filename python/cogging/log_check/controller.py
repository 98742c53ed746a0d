"""Whether the controller that a model states is the one that made a log."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from cogging.arrays import FloatArray
from cogging.calls import takes
from cogging.log_check.command_comparison import Compared, compared, root_mean_square
from cogging.log_check.controller_gains import fit_gains, linear_regressors
from cogging.log_check.controller_samples import LONG
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.units import Units
from cogging.resources import on_one_blas_thread
from cogging.simulation.arguments import LOG, MODEL_ALONE
from cogging.values import ByValue

MISMATCH = 0.05  # of the rms command: beyond it the verdict is controller_mismatch (contract)
RATE_TOLERANCE = 0.02  # of the stated sample rate
FEWEST_ROWS = 20
ENOUGH = 0.25  # of the rows: so many before the first gap tell whether a controller that learns made the log
AT_REST = 1e-3  # of the top speed: slower is rest


@dataclass(frozen=True, eq=False, repr=False)
class ControllerCheck(ByValue):
    """A logged command beside the one that the stated controller gives for the logged references and readings.

    Attributes:
        type: of the controller, as in model files.
        reproduces: whether the difference stays within 5 % of the rms command; None where it cannot be told.
        command_rms: V, of the logged command about zero.
        difference_rms: V, logged minus recomputed; an unknown start of the integral is taken out.
        relative: difference_rms / command_rms.
        start: V, the integral term with which the log begins, 0 without an integral.
        best_shift: rows by which the logged command lags what fits best, -2 to 2; 0 unless it gains 5 %.
        best_shift_rms: V, the difference then.
        ratio: factor between the logged and the recomputed command, by least squares.
        stated: gains of the model; empty for a controller that is not linear in them.
        fitted: the same gains by least squares on the log.
        fitted_rms: V, what they leave.
        notes: why something could not be told, or what the figures suggest.
        unseen_readings: rows whose reading leaves and returns at once, and which the controller did not see.
        doubted_commands: rows whose command does so, and which the controller did not give.
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
        verdict = {True: "reproduces", False: "does not reproduce", None: "may or may not reproduce"}[self.reproduces]
        unit = self.units.command
        left = (
            ""
            if self.relative is None
            else f": {100 * self.relative:.3g} % of {self.command_rms:.4g} {unit} rms is left"
        )
        return f"{self.type} {verdict} the command{left}"


@takes(log=LOG, model=MODEL_ALONE)
@on_one_blas_thread(scipy=False)
def check_controller(log: Log, model: Model) -> ControllerCheck | None:
    """Compare a log with the controller of a model; None where the model states none.

    `pid` and `cascade` are recomputed as their equations say (Pid, Cascade), with Ts = 1/`sample_rate` even where the
    time jitters, and their gains are fitted by least squares on the same regressors; every other type is run on the
    logged references and readings (replay_controller). The first row, whose differences reach before the log, is
    left out, and so are rows at the stated command limit when gains are fitted.

    Samples without a row are put on the line between their neighbours where they are few on end, and rows whose command
    hangs on them are not compared; after a longer gap the integral is another constant. Single readings that the
    controller did not see, and commands that it did not give, are left out: where that alone explains them.

    Args:
        log: with a reference.
        model: that states the controller.

    Returns:
        How far the two commands agree; None where the model states no controller.

    Example:
        >>> other = model.replace(controller=model.controller.replace(kp=9000.0))
        >>> cogging.check_controller(log, other).reproduces
        True
    """
    if model.controller is None or model.controller_type is None:
        return None
    kind, command_rms = model.controller_type, float(np.sqrt(np.mean(log.command**2)))
    refusal = _why_not(log, model, command_rms)
    if refusal:
        return ControllerCheck(kind, None, command_rms, notes=(refusal,), units=model.units)
    found = compared(log, model, kind)
    if found.judged.sum() < FEWEST_ROWS:
        text = (
            f"{int(found.judged.sum())} rows between gaps are too few to check the controller, "
            f"which takes {FEWEST_ROWS}"
        )
        return ControllerCheck(kind, None, command_rms, notes=(text,), units=model.units)
    if found.doubted.any():
        command_rms = root_mean_square(found.samples.command[found.judged])
    return _judged(found, model, kind, command_rms)


def _judged(found: Compared, model: Model, kind: str, command_rms: float) -> ControllerCheck:
    """The verdict on a command that could be compared with the stated controller's."""
    relative, best = found.shifts[0] / command_rms, _best_shift(found.shifts, command_rms)
    logged, computed = found.samples.command[found.judged], found.computed[found.judged]
    power = float(np.sum(computed**2))
    ratio = float(np.sum(computed * logged) / power) if power > 0.0 else None
    notes = _suggestions(logged, computed, ratio, relative, best)
    reproduces: bool | None = relative <= MISMATCH
    if not reproduces and model.make_controller().estimates.size:
        reproduces, note = _with_estimates(found, command_rms)
        notes.append(note)
    stated: dict[str, float] = {}
    fitted: dict[str, float] = {}
    fitted_rms = None
    if kind in ("pid", "cascade"):
        regressors = linear_regressors(kind, model.controller, found.samples.motion, found.samples.position)
        stated, fitted, fitted_rms = fit_gains(found, model, regressors)
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


def _best_shift(shifts: Mapping[int, float], command_rms: float) -> int:
    """Rows by which the logged command lags what fits best; 0 unless that gains 5 % of more than nothing."""
    best = min(shifts, key=lambda shift: shifts[shift])
    return 0 if shifts[best] > 0.95 * shifts[0] or shifts[0] < 1e-9 * command_rms else best


def _with_estimates(found: Compared, command_rms: float) -> tuple[bool | None, str]:
    """Whether a controller that learns reproduces a log whose whole it does not, and why it may not."""
    samples = found.samples
    velocity = np.abs(samples.motion["reference_velocity"])
    if float(velocity[:3].max()) > AT_REST * float(velocity.max()):
        return None, "the log starts in mid-motion: what the controller had learned by then is not known"
    before = found.judged & (samples.segment == 0)
    if samples.segment[-1] == 0:
        return False, "the controller's estimates are taken to start as stated"
    told = "what the controller had learned after a gap is not known"
    if before.sum() < max(FEWEST_ROWS, ENOUGH * found.judged.sum()):
        return None, told
    left = root_mean_square(samples.command[before] - found.computed[before]) / command_rms
    return bool(left <= MISMATCH), f"{told}: until then the difference is {100 * left:.2g} %"


def _speed_alone(log: Log, kind: str | None) -> bool:
    """Whether a speed loop's log has the speed that was asked for, which is all that such a loop looks at."""
    return kind == "speed" and log.reference_velocity is not None


def _why_not(log: Log, model: Model, command_rms: float) -> str:
    if log.reference is None and not _speed_alone(log, model.controller_type):
        return "the log has no reference: the controller cannot be recomputed"
    if len(log) < FEWEST_ROWS:
        return f"{len(log)} rows are too few to check the controller, which takes {FEWEST_ROWS}"
    if command_rms == 0.0:
        return "the command is zero throughout: there is nothing to recompute"
    assert model.controller is not None
    steps = np.diff(log.time)
    step = float(np.median(steps))  # or, where some jitter, a mean of those that are one sample long
    own = steps[(steps > 0.5 * step) & (steps < LONG * step)]
    step = float(own.mean()) if own.size and np.ptp(steps) > RATE_TOLERANCE * step else step
    rate, stated = 1.0 / step, model.controller.sample_rate
    if abs(rate / stated - 1.0) > RATE_TOLERANCE:
        return f"the log has {rate:g} rows a second, the controller {stated:g} samples: the command cannot be told"
    return ""


def _suggestions(
    logged: FloatArray, computed: FloatArray, ratio: float | None, relative: float, shift: int
) -> list[str]:
    notes = []
    if ratio and abs(ratio - 1.0) > MISMATCH:
        left = root_mean_square(logged - ratio * computed)
        if left <= MISMATCH * root_mean_square(logged):
            notes.append(f"the command is {ratio:.4g} times the controller's: is its unit another (scale command)?")
    if relative > MISMATCH and shift:
        notes.append(f"the command fits better when moved by {shift} rows: is it logged with another timing?")
    return notes
