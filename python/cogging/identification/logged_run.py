"""A measured log with the closed-loop replay that should reproduce it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cogging._core import DivergedError, friction_slope_max
from cogging.arrays import FloatArray, real_array
from cogging.estimation.force_balance import ForceBalance, Simulator
from cogging.estimation.replay import Replay
from cogging.log_check.controller_check import MISMATCH, ControllerCheck, check_controller
from cogging.log_check.controller_samples import on_its_clock
from cogging.log_check.log_audit import Audit, audit, check_against_model
from cogging.logs.log import Log
from cogging.logs.spikes import repaired, spikes
from cogging.model.model import Model

ROUGH = 1e-3  # of the rms command: a stated controller further off is replaced by its fitted gains ...
FOLLOWED = 0.05  # of the reference's standard deviation: a closer reference serves as the noise-free motion
LIGHTEST = 0.02  # of the stated mass: below it the loop with the logged gains is far from stable
STEEPEST = 20.0  # time constants of friction near rest in a sample: steeper friction moves the axis alike
SPARSE = 1.5  # controller samples per row, from which commands between the rows are missing
GAIN = 0.8  # ... if these leave less than this share of the difference


class LoggedReplay(Replay):
    """A replay with the gains fitted to the log and its initial integral."""

    def __init__(self, log: Log, model: Model, *, added_command: FloatArray | None) -> None:
        super().__init__(log, model, added_command=added_command)
        self.controller, self.mass = model.controller, model.axis.mass
        self.sample_time = float(log.time[-1] - log.time[0]) / (len(log) - 1)

    def as_run(self, model: Model) -> Model:
        """The model with the controller of the log; DivergedError: too small a mass for a stable loop."""
        axis = model.axis
        if axis.mass < (least := LIGHTEST * self.mass):
            raise DivergedError(f"axis.mass: must be at least {least:g} to be replayed, got {axis.mass:g}")
        if axis.coulomb_width > 0.0:
            # A fit of an incomplete model may end at a vanishing width, which would need 1e5 steps a sample.
            rate = friction_slope_max(1.0) * axis.coulomb / axis.mass  # m/s^2: over the width, 1/s
            axis = axis.replace(coulomb_width=max(axis.coulomb_width, rate * self.sample_time / STEEPEST))
        return super().as_run(model.replace(axis=axis, controller=self.controller))

    def log_of(self, model: Model) -> Log:
        """The simulated log of a model, at the times of the measured one; DivergedError: the replay diverged."""
        run = self.run(model)
        if not (np.isfinite(run["position"]).all() and np.isfinite(run["command"]).all()):
            raise DivergedError("the replay diverged")
        return Log(time=self.log.time, position=run["position"], command=run["command"])


@dataclass(frozen=True)
class LoggedRun:
    """One log as a fit uses it."""

    name: str  # of the log
    log: Log  # measured
    audit: Audit  # of it
    replay: LoggedReplay | None  # on its reference; None if controller or reference are unknown or do not fit
    line: str  # remark on the stated controller, or ""
    repairs: str = ""  # remark on corrected time stamps and spikes
    sparse: str = ""  # remark on too few rows for the controller, or ""
    hold: float | None = None  # s, of each command where the controller gave several a row; None: from row to row

    @classmethod
    def of(cls, log: Log, model: Model, name: str, added_command: npt.ArrayLike | None = None) -> LoggedRun:
        """Audit a log and check the controller that made it; InputError: units that cannot be those of the model.

        `added_command`: what was added to the controller's command, V, (n,).
        """
        added = None if added_command is None else real_array("added_command", added_command)
        check_against_model(log, model, name)
        own = log if added is None else Log.of({**log.columns(), "command": log.command - added})
        found = audit(own, model)
        log, clock = on_its_clock(log)
        if clock:  # the audit is of the time stamps, the controller check of the clock
            found = replace(found, controller=check_controller(replace(own, time=log.time), model))
        usable, line = _usable(model, found.controller)
        commands = np.zeros(len(log), dtype=bool)
        if usable is not None and found.controller is not None:
            commands[list(found.controller.doubted_commands)] = True
        log, said = repaired(log, spikes(log.position), commands)
        hold, sparse, step = None, "", float(np.median(np.diff(log.time)))
        if model.controller is not None and step * model.controller.sample_rate >= SPARSE:
            hold, many = 1.0 / model.controller.sample_rate, step * model.controller.sample_rate
            sparse = f"a row every {step:.3g} s, and {many:.3g} commands of the controller in each"
            sparse = f"{sparse}: between rows the command is taken to be straight"
            between = np.append(0.5 * (log.command[:-1] + log.command[1:]), log.command[-1])
            log = Log.of({**log.columns(), "command": between})
        replay = None
        if usable is not None and found.controller is not None:
            start = found.controller.start
            if start != 0.0:  # an initial integral is a constant command
                added = start + (np.zeros(len(log)) if added is None else added)
            try:
                replay = LoggedReplay(log, usable, added_command=added)
            except ValueError as error:
                line = line or f"the loop is not replayed: {error}"
        line, sparse = (one and f"{name}: {one}" for one in (line, sparse))
        repairs = "; ".join(f"{name}: {one}" for one in (clock, said) if one)
        return cls(name, log, found, replay, line, repairs, sparse, hold)

    def simulator(self) -> Simulator:
        """The simulator for instruments: the replay, else the reference if the axis followed it, else None."""
        if self.replay is not None:
            return self.replay.log_of
        reference = self.log.reference
        if reference is None or np.std(self.log.position - reference) > FOLLOWED * np.std(reference):
            return None
        noise_free = Log(time=self.log.time, position=reference, command=self.log.command)
        return lambda model: noise_free

    def balance(self, cutoff: float, rest: float | None, *, every_second: bool = False) -> ForceBalance:
        """The force balance of the log, or of every second row, each with the mean of the two commands in between."""
        log, hold, simulate = self.log, self.hold, self.simulator()
        if not every_second:
            return ForceBalance(log, cutoff=cutoff, hold=hold, rest=rest, run=simulate)

        def half(log: Log) -> Log:
            first, second = log.command[::2], np.append(log.command[1::2], log.command[-1:])
            columns = {name: column[::2] for name, column in log.columns().items()}
            return Log.of({**columns, "command": 0.5 * (first + second[: len(first)])})

        hold = hold or float(np.median(np.diff(log.time)))
        fewer = simulate and (lambda model: half(simulate(model)))
        return ForceBalance(half(log), cutoff=cutoff, hold=hold, rest=rest, run=fewer)

    def relative_errors(self, model: Model) -> dict[str, float]:
        """Relative error of the replay in position, velocity and command (norms); empty without a replay.

        Both velocities are differences of positions low-pass filtered at 400 Hz at most. DivergedError: it diverged.
        """
        if self.replay is None:
            return {}
        run = self.replay.log_of(model)
        cutoff = min(80.0, 0.1 / float(np.median(np.diff(self.log.time))))
        velocities = [ForceBalance(log, cutoff=cutoff).motion.middle_velocity for log in (self.log, run)]
        pairs = {"position": (self.log.position, run.position), "velocity": velocities}
        pairs["command"] = (self.log.command, run.command)
        return {name: float(np.linalg.norm(a - b) / np.linalg.norm(a)) for name, (a, b) in pairs.items()}


def _usable(model: Model, check: ControllerCheck | None) -> tuple[Model | None, str]:
    """The model with the gains that made the log, or None, and a remark on them."""
    if check is None or model.controller is None:
        return None, ""
    if check.relative is None or check.difference_rms is None:
        return None, "; ".join(check.notes)
    said = f"the stated {check.type} gives the command to {100 * check.relative:.2g} %"
    fitted_rms = np.inf if check.fitted_rms is None else check.fitted_rms
    fits = fitted_rms < GAIN * check.difference_rms and fitted_rms <= MISMATCH * check.command_rms
    if check.relative > ROUGH and fits:
        pairs = [f"{name} {value:.5g} (stated {check.stated[name]:.5g})" for name, value in check.fitted.items()]
        try:
            usable = model.replace(controller=model.controller.replace(**check.fitted))
        except ValueError as error:
            return None, f"{said}, and the gains that fit are none: {error}"
        log = f"{100 * fitted_rms / check.command_rms:.2g} %: {', '.join(pairs)}"
        return usable, f"{said}; its replay has the gains that fit the log to {log}"
    if check.reproduces is not True:
        return None, f"{said}: it did not make this log, which is fitted by position and command alone"
    return model, said if check.relative > ROUGH else ""
