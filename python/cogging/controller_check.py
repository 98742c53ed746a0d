"""Whether the controller that a model states is the one that made a log."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging._core import Sampled, replay_controller
from cogging.files import LARGEST
from cogging.logs import Log
from cogging.model import CONTROLLERS, Model

FloatArray = npt.NDArray[np.float64]

MISMATCH = 0.05  # of the rms command: beyond it the verdict is controller_mismatch (contract)
SHIFTS = (-2, -1, 0, 1, 2)  # rows by which the command is moved
RATE_TOLERANCE = 0.02  # of the stated sample rate
FEWEST_ROWS = 20
AT_REST = 1e-3  # of the top speed: slower is rest


@dataclass(frozen=True)
class ControllerCheck:
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


def check_controller(log: Log, model: Model) -> ControllerCheck | None:
    """Compare a log with the controller of a model; None where the model states none.

    `pid` and `cascade` are recomputed as their equations say (Pid, Cascade), with Ts = 1/`sample_rate` even where the
    time jitters, and their gains are fitted by least squares on the same regressors; every other type is run on the
    logged references and readings (replay_controller). The first row, whose differences reach before the log, is
    left out, and so are rows at the stated command limit when gains are fitted.
    """
    if model.controller is None or model.controller_type is None:
        return None
    kind, command_rms = model.controller_type, float(np.sqrt(np.mean(log.command**2)))
    refusal = _why_not(log, model, command_rms)
    if refusal:
        return ControllerCheck(kind, None, command_rms, notes=(refusal,))
    motion = Sampled(log.time, _reference(log, kind), log.reference_velocity, log.reference_acceleration).samples
    stated: dict[str, float] = {}
    fitted: dict[str, float] = {}
    fitted_rms = None
    if kind in ("pid", "cascade"):
        regressors = linear_regressors(kind, model.controller, motion, log.position)
        stated, fitted, fitted_rms = _fit_gains(log, model, regressors)
    computed, integral = _recompute(log, model, motion, kind)
    start = float(np.median((log.command - computed)[1:])) if integral else 0.0
    limit = model.controller.command_limit
    computed = np.clip(computed + start, -limit, limit) if limit > 0.0 else computed + start
    shifts = {shift: _rms(_shifted(log.command, computed, shift)) for shift in SHIFTS}
    best = min(shifts, key=lambda shift: shifts[shift])
    if shifts[best] > 0.95 * shifts[0] or shifts[0] < 1e-9 * command_rms:
        best = 0
    power = float(np.sum(computed[1:] ** 2))
    ratio = float(np.sum(computed[1:] * log.command[1:]) / power) if power > 0.0 else None
    relative = shifts[0] / command_rms
    notes = _suggestions(log, computed, ratio, relative, best)
    reproduces: bool | None = relative <= MISMATCH
    if not reproduces and model.make_controller().estimates.size:
        moving = float(np.abs(motion["reference_velocity"][:3]).max()) > AT_REST * float(
            np.abs(motion["reference_velocity"]).max()
        )
        if moving:
            reproduces = None
            notes.append("the log starts in mid-motion: what the controller had learned by then is not known")
        else:
            notes.append("the controller's estimates are taken to start as stated")
    return ControllerCheck(
        type=kind,
        reproduces=reproduces,
        command_rms=command_rms,
        difference_rms=shifts[0],
        relative=relative,
        start=start,
        best_shift=best,
        best_shift_rms=shifts[best],
        ratio=ratio,
        stated=stated,
        fitted=fitted,
        fitted_rms=fitted_rms,
        notes=tuple(notes),
    )


def _speed_alone(log: Log, kind: str | None) -> bool:
    """Whether a speed loop's log has the speed that was asked for, which is all that such a loop looks at."""
    return kind == "speed" and log.reference_velocity is not None


def _reference(log: Log, kind: str) -> FloatArray:
    if log.reference is not None:
        return log.reference
    assert log.reference_velocity is not None
    velocity = log.reference_velocity
    moved = 0.5 * (velocity[1:] + velocity[:-1]) * np.diff(log.time)
    reference: FloatArray = log.position[0] + np.concatenate([[0.0], np.cumsum(moved)])
    return reference


def _why_not(log: Log, model: Model, command_rms: float) -> str:
    if log.reference is None and not _speed_alone(log, model.controller_type):
        return "the log has no reference: the controller cannot be recomputed"
    if len(log) < FEWEST_ROWS:
        return f"{len(log)} rows are too few to check the controller, which takes {FEWEST_ROWS}"
    if command_rms == 0.0:
        return "the command is zero throughout: there is nothing to recompute"
    assert model.controller is not None
    rate, stated = 1.0 / float(np.median(np.diff(log.time))), model.controller.sample_rate
    if abs(rate / stated - 1.0) > RATE_TOLERANCE:
        return f"the log has {rate:g} rows a second, the controller {stated:g} samples: the command cannot be told"
    return ""


def linear_regressors(
    kind: str, controller: Any, motion: Mapping[str, FloatArray], position: FloatArray
) -> dict[str, FloatArray]:
    """What the gains of a `pid` or `cascade` multiply, (n,) each, by the gain's name (contract, [controller]).

    Each is what the controller itself commands with this gain at 1 and the others at 0, without a limit. A `cascade`
    has kv and `kp kv`, in which it is linear.
    """
    make = CONTROLLERS[kind][1]
    gains = {"pid": ("kp", "ki", "kd"), "cascade": ("kp", "kv")}[kind] + ("mass", "viscous", "coulomb")
    bare = controller.replace(**dict.fromkeys(gains, 0.0), command_limit=0.0)

    def command(**gain: float) -> FloatArray:
        return replay_controller(make(bare.replace(**gain)), **motion, position=position)

    columns = {name: command(**{name: 1.0}) for name in gains if (kind, name) != ("cascade", "kp")}
    if kind == "cascade":
        # So small a kv that its own term vanishes beside that of the error; of powers of two the product is exactly 1.
        columns = {"kp kv": command(kp=2.0**60, kv=2.0**-60), **columns}
    return columns


def least_squares(columns: Mapping[str, FloatArray], target: FloatArray) -> tuple[dict[str, float], float]:
    """Coefficients of columns (n,) that fit a target, and the rms of what is left. Columns are scaled to unit rms."""
    names = list(columns)
    matrix = np.column_stack([columns[name] for name in names])
    size = np.sqrt(np.mean(matrix**2, axis=0))
    size[size == 0.0] = 1.0
    solution = np.linalg.lstsq(matrix / size, target, rcond=1e-12)[0]
    residual = target - (matrix / size) @ solution
    return dict(zip(names, (solution / size).tolist(), strict=True)), _rms(residual)


def _stated_gains(controller: Any, names: tuple[str, ...]) -> dict[str, float]:
    return {
        name: controller.kp * controller.kv if name == "kp kv" else float(getattr(controller, name)) for name in names
    }


def _fit_gains(
    log: Log, model: Model, regressors: Mapping[str, FloatArray]
) -> tuple[dict[str, float], dict[str, float], float]:
    """Stated gains, those that fit the log, and the rms that these leave; only gains that are stated above zero."""
    controller: Any = model.controller
    gains = _stated_gains(controller, ("kp", *regressors))
    columns = {name: column for name, column in regressors.items() if gains[name] != 0.0}
    if gains.get("ki", 0.0) > 0.0:
        columns["start"] = np.ones(len(log))
    rows = np.ones(len(log), dtype=bool)
    rows[0] = False
    if controller.command_limit > 0.0:
        rows &= np.abs(log.command) < controller.command_limit * (1.0 - 1e-6)
    if not columns or rows.sum() <= 2 * len(columns):
        return {}, {}, float("nan")
    fitted, rms = least_squares({name: column[rows] for name, column in columns.items()}, log.command[rows])
    fitted.pop("start", None)
    product = fitted.pop("kp kv", None)
    if product is not None:
        fitted = {"kp": product / fitted["kv"] if fitted.get("kv") else 0.0, **fitted}
    stated = {name: gains[name] for name in fitted}
    return stated, fitted, rms


def _recompute(log: Log, model: Model, motion: Mapping[str, FloatArray], kind: str) -> tuple[FloatArray, bool]:
    """The command as stated, and whether an unknown start of its integral may be added."""
    controller: Any = model.controller
    limited = controller.command_limit > 0.0 and np.abs(log.command).max() >= controller.command_limit * (1 - 1e-6)
    arguments = {**motion, "position": log.position}
    if kind in ("pid", "cascade") and not limited:
        unlimited = CONTROLLERS[kind][1](controller.replace(command_limit=0.0))
        return _bounded(replay_controller(unlimited, **arguments)), kind == "pid" and controller.ki > 0.0
    fresh = model.make_controller()
    own = _bounded(replay_controller(fresh, **arguments))
    if kind in ("pid", "cascade"):
        return own, False
    # What a controller with memory was told to have been applied is its own command or, after a disturbance of the
    # command or a start in mid-motion, what the log holds.
    told = _bounded(replay_controller(fresh, **arguments, applied=log.command))
    return min(own, told, key=lambda command: _rms((log.command - command)[1:])), False


def _bounded(command: FloatArray) -> FloatArray:
    """The command of a controller that may have run away: as far off as can be squared is far enough."""
    return np.clip(np.nan_to_num(command, nan=LARGEST), -LARGEST, LARGEST)


def _shifted(command: FloatArray, computed: FloatArray, shift: int) -> FloatArray:
    """Logged minus computed when the logged command is moved back by `shift` rows; rows 3 to n - 2 or, unmoved, all."""
    if shift == 0:
        return command[1:] - computed[1:]
    edge = max(SHIFTS)
    rows = np.arange(1 + edge, command.size - edge)
    return command[rows + shift] - computed[rows]


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _suggestions(log: Log, computed: FloatArray, ratio: float | None, relative: float, shift: int) -> list[str]:
    notes = []
    if ratio and abs(ratio - 1.0) > MISMATCH:
        left = _rms(log.command[1:] - ratio * computed[1:])
        if left <= MISMATCH * _rms(log.command):
            notes.append(f"the command is {ratio:.4g} times the controller's: is its unit another (scale command)?")
    if relative > MISMATCH and shift:
        notes.append(f"the command fits better when moved by {shift} rows: is it logged with another timing?")
    return notes
