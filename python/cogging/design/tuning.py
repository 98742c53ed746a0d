"""Tune the gains of a controller for an uncertain machine: the smallest rms error within limits."""

from __future__ import annotations

import importlib
import inspect
import io
import json
import math
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from cogging._core import Reference
from cogging.arrays import FloatArray
from cogging.calls import Kind, check_arguments, did_you_mean
from cogging.design.linear_plant import modulus_margin
from cogging.design.loop_margins import GAIN_MOST, Loops, Machine, Push, machines_of, push_of, variations_of
from cogging.file_schema import TUNE, TUNE_INDEXES, TUNE_NEEDED
from cogging.files import FieldError, InputError, read_text, read_toml, refuse_unknown_keys
from cogging.model.controller import AnyController
from cogging.model.model import Model, is_number
from cogging.model.units import Units
from cogging.outputs import AnyPath, target_of, write_bytes, write_text
from cogging.plot.canvas import grid_to_write, plot_method
from cogging.plot.results import WHOLE_TUNING, whole_tuning
from cogging.progress import Progress, steps
from cogging.resources import on_one_blas_thread
from cogging.shown import quoted
from cogging.simulation.arguments import MODEL, REFERENCE
from cogging.simulation.digests import digest_of
from cogging.simulation.reductions import kept_of_runs, names_of
from cogging.simulation.reference import read_reference, reference_from, reference_to_dict
from cogging.simulation.sweep import files_of_job, require_keys, run_job
from cogging.simulation.varied import BOUNDS, Setup, make_controller, numbers_of, with_numbers
from cogging.tables import frame_of
from cogging.values import ByValue

#: The gains tuned by default: those of these fields that are not zero.
USUAL: dict[str, tuple[str, ...]] = {
    "pid": ("kp", "ki", "kd"),
    "cascade": ("kp", "kv"),
    "speed": ("kp",),
    "arc": ("error_gain", "feedback_gain", "disturbance_adaptation", "cogging_adaptation"),
    "dcarc": ("error_gain", "feedback_gain", "disturbance_adaptation", "cogging_adaptation"),
    "output_feedback_arc": ("gain_1", "gain_2", "adaptation[0]", "adaptation[1]", "adaptation[2]"),
    "observer_based": ("position_gain", "velocity_gain"),
}
DECADE = 10.0  # factor of the default range above and below the present value
KEYS = ("from", "to", "scale", "start")
PREFIX = "controller."

INDEXES = TUNE_INDEXES  # unit, and whether a limit is the largest allowed value, by name
MARGINS = ("delay_margin", "gain_margin", "modulus_margin")
ROWS = ("error_rms", *INDEXES)
CHATTER = "command_chatter"  # traded against the rms error by default
ALL_END = "all runs complete"
RULE = "a rule of the controller"
BEYOND = 1e3  # largest relative excess of a limit
WORST = 1e9  # replaces an infinite objective, of trials that break a limit anyway
MOST = 1_000_000
WRITTEN_EVERY = 0.5  # s: the work that a kill may cost
FRONT = ("error_rms", "command_max", "command_chatter")  # columns of the trade-off
FRONT_MOST = 8  # points of the trade-off whose margins are measured
AT_END = 0.01  # of a range, or of its logarithm: closer to its end a gain counts as at the end
SHOWN: dict[str, tuple[float, str]] = {  # factor and unit for the screen
    "error_rms": (1e6, "um"),
    "error_max": (1e6, "um"),
    "command_max": (1.0, "V"),
    "command_rms": (1.0, "V"),
    "command_chatter": (1.0, "1"),
    "delay_margin": (1e3, "ms"),
    "gain_margin": (1.0, "1"),
    "modulus_margin": (1.0, "1"),
}
CONTROLLER = Kind((Callable, type(None)), "a function that makes a controller of gains")  # type: ignore[arg-type]
TABLE = Kind((Mapping, type(None)), "a table of gains by path")


# The gains ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Gain:
    """One number that is tuned.

    Attributes:
        path: `controller.kp` of a model, or the name of an argument of a user's function.
        low, high: ends of its range.
        logarithmic: whether it is searched on a logarithmic scale.
        present: its present value, within the range or not.
        whole: whether it is a whole number.
    """

    path: str
    low: float
    high: float
    logarithmic: bool
    present: float
    whole: bool = False


@dataclass(frozen=True)
class Tuned:
    """The gains that are tuned.

    Attributes:
        gains: with their ranges.
        make: makes the controller from values of the gains.
        model: the model with these values in its controller; None for a user's own controller.
    """

    gains: tuple[Gain, ...]
    make: Callable[[Mapping[str, float]], AnyController]
    model: Callable[[Mapping[str, float]], Model | None]

    @property
    def present(self) -> dict[str, float]:
        """The present values by path."""
        return {gain.path: gain.present for gain in self.gains}


def tuned_of_model(model: Model, motion: Reference, ranges: Mapping[str, Any] | None) -> Tuned:
    """The gains of the model's controller; ranges: tables by path, None for the usual ones.

    Raises:
        ValueError: the model has no controller, or a path is no number of it.
        FieldError: a range breaks a rule.
    """
    make_controller(model)
    setup = Setup(model, motion)
    numbers = {path: value for path, value in numbers_of(setup).items() if path.startswith(PREFIX)}
    if ranges is None:
        paths = [f"{PREFIX}{name}" for name in USUAL.get(model.controller_type or "", ())]
        values = {path: float(numbers.get(path) or 0.0) for path in paths}
        ranges = {p: {"from": v / DECADE, "to": v * DECADE, "scale": "log"} for p, v in values.items() if v > 0.0}
    for path in ranges:
        if path not in numbers:
            raise FieldError("gains", path, f"is no number of the controller; {did_you_mean(path, numbers)}")

    def with_gains(values: Mapping[str, float]) -> Model:
        return with_numbers(setup, values).model

    fields = model.controller.to_dict() if model.controller is not None else {}
    gains = tuple(_gain(path, ranges[path], numbers[path], fields) for path in ranges)
    return Tuned(gains, lambda values: with_gains(values).make_controller(), with_gains)


def tuned_of_function(make: Callable[..., AnyController], ranges: Mapping[str, Any] | None) -> Tuned:
    """The gains of a user's own controller, which a function makes from them by keyword.

    Raises:
        FieldError: the function has no such argument, or a range breaks a rule.
    """
    parameters = inspect.signature(make).parameters
    open_ended = any(one.kind is one.VAR_KEYWORD for one in parameters.values())
    gains = []
    for path, how in (ranges or {}).items():
        if path not in parameters and not open_ended:
            raise FieldError("gains", path, f"is no argument of the controller; {did_you_mean(path, parameters)}")
        value = parameters[path].default if path in parameters else None
        gains.append(_gain(path, how, value if is_number(value) else None, {}))
    return Tuned(tuple(gains), lambda values: make(**values), lambda values: None)


def _gain(path: str, given: Any, present: float | None, fields: Mapping[str, Any]) -> Gain:
    """Check one entry of the table of gains."""

    def refuse(rule: str) -> FieldError:
        return FieldError("gains", path, rule)

    if not isinstance(given, Mapping):
        raise refuse(f"must be a table with from and to, got {quoted(given)}")
    refuse_unknown_keys(given, KEYS, f"gains.{path}")
    for key in ("from", "to"):
        if key not in given:
            raise refuse(f"{key}: must be given, got nothing")
    for key, value in given.items():
        if key != "scale" and not (is_number(value) and math.isfinite(value)):
            raise refuse(f"{key}: must be a number, got {quoted(value)}")
    low, high = float(given["from"]), float(given["to"])
    if not low < high:
        raise refuse(f"from: must be below to = {high:g}, got {low:g}")
    scale = given.get("scale", "log" if low > 0.0 else "linear")
    if scale not in ("log", "linear"):
        raise refuse(f"scale: must be linear or log, got {quoted(scale)}")
    if scale == "log" and low <= 0.0:
        raise refuse(f"from: must be above 0 on a logarithmic scale, got {low:g}")
    middle = math.sqrt(low * high) if scale == "log" else 0.5 * (low + high)
    start = float(given["start"]) if "start" in given else middle if present is None else float(present)
    name, _, place = path.removeprefix(PREFIX).partition("[")
    entry = fields.get(name)
    if place and isinstance(entry, list):
        entry = entry[int(place.rstrip("]"))]
    whole = isinstance(entry, int) and not isinstance(entry, bool)
    if whole and (low != int(low) or high != int(high)):
        raise refuse(f"from, to: must be whole numbers, got {low:g} and {high:g}")
    return Gain(path, low, high, scale == "log", start, whole)


# What gains reach -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Reached:
    """What gains reach on a set of machines.

    Attributes:
        error_rms: m, the quantile over the machines; infinite where a run did not complete.
        error_max: m, the largest of all machines, as are the command's indexes.
        command_max, command_rms: V.
        command_chatter: of the command (see Performance).
        failed: number of machines on which the run did not complete.
        delay_margin: s, the smallest over the machines, as the other margins; None: not measured.
        gain_margin: factor.
        modulus_margin: None also for a controller without a linear part.
    """

    error_rms: float
    error_max: float
    command_max: float
    command_rms: float
    command_chatter: float
    failed: int = 0
    delay_margin: float | None = None
    gain_margin: float | None = None
    modulus_margin: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """The numbers by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}


class Judge:
    """Runs controllers on a fixed set of machines.

    Args:
        machines: the same for all gains.
        tuned: makes the controllers.
        duration: s; 0: the motion's own end.
        start, stop: s, of the rows that the indexes use.
        quantile: of the rms error over the machines.
        threads: 0: all cores.
    """

    def __init__(
        self,
        machines: Sequence[Machine],
        tuned: Tuned,
        duration: float,
        start: float,
        stop: float,
        quantile: float,
        threads: int,
    ) -> None:
        self.machines, self._tuned, self._duration = list(machines), tuned, duration
        self._window, self._quantile, self._threads = (start, stop, 2.0), quantile, threads

    def run(self, gains: Mapping[str, float]) -> Reached:
        """What gains reach, without margins.

        Raises:
            ValueError: the gains break a rule of the controller, or no run can start.
        """
        kept = kept_of_runs(
            [machine.setup.model.plant() for machine in self.machines],
            [self._tuned.make(gains)] * len(self.machines),
            [machine.setup.reference for machine in self.machines],
            durations=[self._duration],
            seeds=[machine.seed for machine in self.machines],
            steps_per_sample=[self.machines[0].setup.model.steps_per_sample],
            threads=self._threads,
            window=self._window,
            reductions=("command_max",),
            keeps_refused=True,
        )
        if len(kept.failures) == len(self.machines) and all(math.isnan(one.time) for one in kept.failures):
            raise ValueError(kept.failures[0].reason)
        names = names_of(("command_max",))
        values = dict(zip(names, np.where(np.isnan(kept.values), np.inf, kept.values).T, strict=True))
        largest = {name: float(values[name].max()) for name in INDEXES if name in values}
        error = upper_quantile(values["error_rms"], self._quantile) if not kept.failures else math.inf
        return Reached(error, failed=len(kept.failures), **largest)

    def loops(self, gains: Mapping[str, float], push: Push) -> Loops:
        """The loops of these gains, on which a push measures margins."""
        return Loops(self.machines, self._tuned.make(gains), push, threads=self._threads)

    def modulus_margin(self, gains: Mapping[str, float]) -> float | None:
        """The smallest over the machines; None without a linear part."""
        model = self._tuned.model(gains)
        if model is None:
            return None
        found = [modulus_margin(machine.setup.model.replace(controller=model.controller)) for machine in self.machines]
        return min((margin for margin in found if margin is not None), default=None)

    def with_margins(
        self, gains: Mapping[str, float], reached: Reached, push: Push, names: Sequence[str] = MARGINS
    ) -> Reached:
        """The same with margins; those that this controller does not have stay None."""
        measured: dict[str, Any] = {}
        loops = None if reached.failed else self.loops(gains, push)
        for name in names:
            if name == "modulus_margin":
                margin = self.modulus_margin(gains)
                measured[name] = margin if margin is None or not reached.failed else 0.0
            elif loops is None:
                measured[name] = 0.0
            else:
                measured[name] = loops.delay_margin() if name == "delay_margin" else loops.gain_margin()
        return replace(reached, **measured)


def upper_quantile(values: FloatArray, share: float) -> float:
    """The value of rank ceil(share (n + 1)) of n values, which one more exceeds with probability at most 1 - share."""
    ordered = np.sort(values)
    return float(ordered[min(len(ordered), math.ceil(share * (len(ordered) + 1) - 1e-9)) - 1])


# Limits ---------------------------------------------------------------------------------------------------------------


def checked_limits(given: Mapping[str, Any]) -> dict[str, float | Mapping[str, float]]:
    """Check limits as given: a number each, or `{"present": factor}`.

    Raises:
        FieldError: an unknown limit, or a value that breaks a rule.
    """
    if not isinstance(given, Mapping):
        raise FieldError("", "limits", f"must be a table of limits by name, got {quoted(given)}")
    refuse_unknown_keys(given, INDEXES, "limits")
    for name, value in given.items():
        number = value
        if isinstance(value, Mapping):
            refuse_unknown_keys(value, ("present",), f"limits.{name}")
            number = value.get("present")
        if not is_number(number) or not math.isfinite(number) or number <= 0:
            rule = 'must be a number above 0, or {"present": a number} times the present value'
            raise FieldError("limits", name, f"{rule}, got {quoted(value)}")
    if is_number(given.get("gain_margin")) and not 1.0 < given["gain_margin"] <= GAIN_MOST:
        raise FieldError("limits", "gain_margin", f"must be above 1, at most {GAIN_MOST:g}, got {given['gain_margin']}")
    if is_number(given.get("modulus_margin")) and given["modulus_margin"] >= 1.0:
        raise FieldError("limits", "modulus_margin", f"must be below 1, got {given['modulus_margin']}")
    return dict(given)


def limits_as_numbers(given: Mapping[str, Any], present: Reached) -> dict[str, float]:
    """The limits as numbers.

    Raises:
        FieldError: a limit refers to a present value that does not exist.
    """
    limits = {}
    for name, value in given.items():
        now = getattr(present, name)
        if name == "modulus_margin" and now is None:
            raise FieldError("limits", name, "needs a controller with a linear part, which this one does not have")
        if isinstance(value, Mapping):
            if now is None or not math.isfinite(now) or now <= 0:
                raise FieldError("limits", name, f"must be a number: the present gains reach none, got {now}")
            value = value["present"] * now
        limits[name] = float(value)
    return limits


def limit_text(name: str, limit: float, units: Units, reached: float | None = None) -> str:
    """A limit in words, optionally with the value reached."""
    unit, is_upper = INDEXES[name][:2]
    label = "" if unit == "1" else f" {units.of(unit)}"
    rule = f"{name}: {'at most' if is_upper else 'at least'} {limit:.4g}{label}"
    return rule if reached is None else f"{rule}, reached {reached:.4g}{label}"


def excesses(
    limits: Mapping[str, float], gains: Mapping[str, float], reached: Reached, judge: Judge, push: Push
) -> dict[str, float]:
    """Relative excess of each limit; 0 or less where it is kept.

    The excess of a delay or gain margin is the share of machines on which the loop fails with that delay or gain.
    """

    def excess(name: str, value: float | None) -> float:
        if value is None or not math.isfinite(value):
            return BEYOND
        ratio = value / limits[name] - 1.0 if INDEXES[name][1] else 1.0 - value / limits[name]
        return min(ratio, BEYOND)

    found = {ALL_END: reached.failed / len(judge.machines)}
    loops = None
    for name, limit in limits.items():
        if name not in MARGINS or getattr(reached, name) is not None:
            found[name] = excess(name, getattr(reached, name))
        elif reached.failed:
            found[name] = 1.0
        elif name == "modulus_margin":
            found[name] = excess(name, judge.modulus_margin(gains))
        else:
            loops = loops or judge.loops(gains, push)
            found[name] = loops.share_lost(**{"delay" if name == "delay_margin" else "gain": limit})
    return found


# Trials ---------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Trial:
    """One set of gains, what it reached on the machines tuned with, and the relative excess of each limit."""

    gains: Mapping[str, float]
    reached: Reached
    excess: Mapping[str, float]

    @property
    def kept(self) -> bool:
        """Whether all limits are kept."""
        return all(value <= 0.0 for value in self.excess.values())


def optuna() -> Any:
    """The library that proposes gains.

    Raises:
        ImportError: it is not installed; names the extra.
    """
    try:
        return importlib.import_module("optuna")
    except ImportError as error:
        raise ImportError("optuna is needed for this and is not there: pip install 'cogging[tune]'") from error


def run_trials(
    gains: Sequence[Gain],
    count: int,
    seed: int,
    against: str | None,
    judged: Callable[[Mapping[str, float]], Trial],
    kept: KeptTrials | None,
) -> Iterator[Trial]:
    """Let Optuna's TPE sampler with constraints propose gains, and judge them one by one; the present ones first.

    The same arguments give the same trials. Trials read from `kept` are not run again; the sampler receives them like
    any other, and continues as it would have.
    """
    library = optuna()

    @contextmanager
    def quiet() -> Iterator[None]:
        before = library.logging.get_verbosity()
        library.logging.set_verbosity(library.logging.ERROR)
        try:
            yield
        finally:
            library.logging.set_verbosity(before)

    with quiet():
        sampler = library.samplers.TPESampler(seed=seed)
        other = [] if against is None else ["minimize" if INDEXES[against][1] else "maximize"]
        study = library.create_study(sampler=sampler, directions=["minimize", *other])
        if all(gain.low <= gain.present <= gain.high for gain in gains):
            study.enqueue_trial({g.path: int(g.present) if g.whole else g.present for g in gains})
        space = {}
        for gain in gains:
            if gain.whole:
                own = library.distributions.IntDistribution(int(gain.low), int(gain.high), log=gain.logarithmic)
            else:
                own = library.distributions.FloatDistribution(gain.low, gain.high, log=gain.logarithmic)
            space[gain.path] = own
    for number in range(count):
        with quiet():
            proposed = study.ask(space)
        values = {gain.path: float(proposed.params[gain.path]) for gain in gains}
        trial = kept.read(number, values) if kept is not None else None
        if trial is None:
            trial = judged(values)
            if kept is not None:
                kept.keep(trial)
        with quiet():
            for name, value in trial.excess.items():
                proposed.set_constraint(name, value)
            objectives = [trial.reached.error_rms]
            if against is not None:
                objectives.append(getattr(trial.reached, against))
            study.tell(proposed, [value if math.isfinite(value) else WORST for value in objectives])
        yield trial


class KeptTrials:
    """Stores finished trials beside the output, so that an interrupted tuning can continue.

    Raises:
        InputError: the file holds the trials of another tuning, or cannot be used.
    """

    def __init__(self, out: str | os.PathLike[str], digest: str) -> None:
        target = target_of(out)
        self._path = target.with_name(f"{target.name}.trials")
        self._called = f"{os.fspath(out)}.trials"
        self._digest = digest
        self._trials: list[Trial] = []
        self._written = time.monotonic()
        if not self._path.exists():
            return
        try:
            document = json.loads(self._path.read_text(encoding="utf-8"))
            digest = document["digest"]
            trials = [Trial(gains, Reached(**reached), excess) for gains, reached, excess in document["trials"]]
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise InputError(f"{self._called}: cannot be used: {error}") from None
        if digest != self._digest:
            raise InputError(
                f"{self._called}: holds trials of another tuning, or of another version: "
                "remove it, or write to another file"
            )
        self._trials = trials

    def read(self, number: int, values: Mapping[str, float]) -> Trial | None:
        """The stored trial of this number, or None; trials after a different one are dropped."""
        if number < len(self._trials) and self._trials[number].gains == values:
            return self._trials[number]
        del self._trials[number:]
        return None

    def keep(self, trial: Trial) -> None:
        """Store one more trial; written every half second.

        Raises:
            InputError: it cannot be written, for example on a full disk.
        """
        self._trials.append(trial)
        if time.monotonic() - self._written > WRITTEN_EVERY:
            self.write()

    def write(self) -> None:
        """Write the trials.

        Raises:
            InputError: they cannot be written.
        """
        entries = [[dict(t.gains), t.reached.to_dict(), dict(t.excess)] for t in self._trials]
        try:
            write_text(self._path, json.dumps({"digest": self._digest, "trials": entries}) + "\n")
        except InputError as error:
            raise InputError(f"{error}; {self.stands}") from None
        self._written = time.monotonic()

    def remove(self) -> None:
        """Delete the file."""
        with suppress(OSError):
            self._path.unlink(missing_ok=True)

    @property
    def stands(self) -> str:
        """Where the finished trials are, after an interruption."""
        return f"finished trials are in {self._called}, the same call continues from there"


def best_of(trials: Sequence[Trial]) -> Trial | None:
    """The trial with the smallest rms error of those that keep all limits, or None."""
    return min((trial for trial in trials if trial.kept), key=lambda trial: trial.reached.error_rms, default=None)


def front_of(trials: Sequence[Trial], against: str) -> list[int]:
    """Trials that keep all limits and that none beats in both rms error and an index, by falling error."""
    sign = 1.0 if INDEXES[against][1] else -1.0
    costs = {
        place: (trial.reached.error_rms, sign * getattr(trial.reached, against))
        for place, trial in enumerate(trials)
        if trial.kept
    }
    front: list[int] = []
    least = math.inf
    for place in sorted(costs, key=lambda place: costs[place]):
        if costs[place][1] < least:
            front.append(place)
            least = costs[place][1]
    return front[::-1]


# The result -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Setting:
    """Gains and what they reach.

    Attributes:
        gains: by path.
        drawn: on the machines tuned with.
        held_out: on machines held out.
    """

    gains: Mapping[str, float]
    drawn: Reached
    held_out: Reached


@dataclass(frozen=True, eq=False, repr=False)
class Tuning(ByValue):
    """Tuned gains for an uncertain machine, with the present ones.

    Attributes:
        present: the present gains.
        tuned: the best gains that keep all limits on every machine tuned with (the present ones, if none is better);
            None if no trial keeps them.
        improved: whether they differ from the present ones.
        model: the model with the tuned gains; None if there are none, or for a user's own controller.
        trials: arrays by name, one entry a trial: the gains by path, the indexes, `kept` (all limits).
        front: the trade-off: arrays by name, one entry a point: `trial`, rms error, the index it is traded against,
            the gains, command_chatter and delay_margin; no trial is better than a point in both.
        against: the index of the trade-off.
        limits: in words.
        machines, held_out: how many.
        quantile: of rms error over machines.
        seed: of machines, noise and trials.
        notes: limits that no trial keeps, gains at the end of their range, and the like.
        units: labels of the model's units.

    Example:
        >>> few = {"trials": 2, "machines": 2, "held_out": 2, "duration": 0.2}
        >>> tuning = cogging.tune(model, move, {"controller.kp": {"from": 5e3, "to": 2e4}}, **few)
        >>> len(tuning.trials["kept"]), tuning.present.gains
        (2, {'controller.kp': 9600.0})
    """

    present: Setting
    tuned: Setting | None
    improved: bool
    model: Model | None
    trials: Mapping[str, Any]
    front: Mapping[str, Any]
    against: str
    limits: tuple[str, ...]
    machines: int
    held_out: int
    quantile: float
    seed: int
    notes: tuple[str, ...] = ()
    units: Units = field(default_factory=Units)

    def _brief(self) -> str:
        before, unit = 1e6 * self.present.drawn.error_rms, self.units.of("um")
        if self.tuned is None:
            return f"no gains keep the limits, present {before:.3g} {unit} rms"
        return f"{before:.3g} to {1e6 * self.tuned.drawn.error_rms:.3g} {unit} rms over {self.machines} machines"

    def text(self) -> str:
        """The result for the screen."""
        trials, kept = len(self.trials["kept"]), int(np.sum(self.trials["kept"]))
        lines = [
            f"{trials} trials on {self.machines} drawn machines, {kept} within the limits; checked on "
            f"{self.held_out} machines held out (rms: {100 * self.quantile:g} % quantile; others: the worst machine)"
        ]
        lines += [f"    limit {limit}" for limit in self.limits]
        after = self.tuned
        width = max(len(path) for path in (*self.present.gains, *ROWS)) + 6
        lines.append(f"    {'gain':<{width}}{'present':>12}" + f"{'tuned':>12}" * (after is not None))
        for path, value in self.present.gains.items():
            lines.append(f"    {path:<{width}}{value:>12.5g}" + (f"{after.gains[path]:>12.5g}" if after else ""))
        settings = [self.present, *([after] if after is not None else [])]
        names = ["present", "tuned"][: len(settings)]
        titles = [f"{name}{kind}" for kind in ("", ", held out") for name in names]
        lines.append(f"    {'':<{width}}" + "".join(f"{title:>19}" for title in titles))
        for row in ROWS:
            cells = [getattr(setting.drawn, row) for setting in settings]
            cells += [getattr(setting.held_out, row) for setting in settings]
            factor, unit = SHOWN[row]
            name = row if unit == "1" else f"{row}, {self.units.of(unit)}"
            if any(cell is not None for cell in cells):
                shown = ["-" if cell is None else f"{factor * cell:.4g}" for cell in cells]
                lines.append(f"    {name:<{width}}" + "".join(f"{cell:>19}" for cell in shown))
        if after is not None and self.improved:
            lines.append(f"    tuned against present: {', '.join(_changes(self.present.drawn, after.drawn))}")
        return "\n".join([*lines, *(f"  note: {note}" for note in self.notes)])

    def to_frame(self, what: str = "trials") -> Any:
        """The trials or the front as a pandas DataFrame, with units in `attrs["units"]`.

        Args:
            what: `trials` or `front`.

        Raises:
            ValueError: `what` is neither.
            ImportError: pandas is not there; names the extra that brings it.
        """
        if what not in ("trials", "front"):
            raise ValueError(f"what: must be trials or front, got {what!r}")
        units = {"error_rms": "m", "error_max": "m", "command_max": "V", "command_rms": "V", "delay_margin": "s"}
        labels = {name: self.units.of(unit) for name, unit in units.items()}
        return frame_of(self.trials if what == "trials" else self.front, labels)

    def to_dict(self) -> dict[str, Any]:
        """What `cogging tune --json` writes; null stands for infinite and for not measured."""

        def of(setting: Setting | None) -> Any:
            if setting is None:
                return None
            return {
                "gains": dict(setting.gains),
                "drawn": setting.drawn.to_dict(),
                "held_out": setting.held_out.to_dict(),
            }

        return {
            "present": of(self.present),
            "tuned": of(self.tuned),
            "improved": self.improved,
            "against": self.against,
            "front": dict(self.front),
            "trials": dict(self.trials),
            "limits": list(self.limits),
            "machines": self.machines,
            "held_out": self.held_out,
            "quantile": self.quantile,
            "seed": self.seed,
            "notes": list(self.notes),
        }

    plot = plot_method(
        whole_tuning,
        "Draw the trade-off: rms error over its index with all trials, and its points over the delay margin.",
        "two axes",
    )

    def write_figure(self, path: str | os.PathLike[str]) -> None:
        """Write the trade-off as PNG.

        Raises:
            InputError: the file cannot be written.
        """
        picture = io.BytesIO()
        self.plot(ax=grid_to_write(1, 2, WHOLE_TUNING)).savefig(picture, format="png", dpi=120)
        write_bytes(path, picture.getvalue())


def _changes(before: Reached, after: Reached) -> list[str]:
    """Relative change of each index."""
    changes = []
    for name in ("error_rms", "command_chatter", *MARGINS):
        one, other = getattr(before, name), getattr(after, name)
        if one is not None and other is not None and np.isfinite([one, other]).all() and one > 0.0:
            changes.append(f"{name} {100 * (other / one - 1):+.0f} %")
    return changes or ["the present gains do not run"]


@check_arguments(model=MODEL, reference=REFERENCE, gains=TABLE, controller=CONTROLLER)
@on_one_blas_thread(scipy=True)
def tune(
    model: Model | str | os.PathLike[str],
    reference: Reference | Mapping[str, Any] | str | os.PathLike[str],
    gains: Mapping[str, Any] | None = None,
    *,
    controller: Callable[..., AnyController] | None = None,
    limits: Mapping[str, Any] | None = None,
    vary: Mapping[str, Any] | str = BOUNDS,
    machines: int = 32,
    held_out: int = 32,
    quantile: float = 0.9,
    trials: int = 100,
    against: str | None = None,
    seed: int = 0,
    duration: float = 0.0,
    start: float = -np.inf,
    stop: float = np.inf,
    out: str | os.PathLike[str] | None = None,
    threads: int = 0,
    progress: Progress = False,
) -> Tuning:
    """Find the gains with the smallest rms error for a machine that is known within intervals.

    Minimises the quantile of the rms error over drawn machines, the same machines and noise in every trial, subject to
    limits on every machine. Optuna's TPE sampler proposes the gains with the excess of each limit as a constraint; the
    present gains come first. The result is evaluated on machines held out.

    Delay and gain margins are measured by a force pulse on each machine, so they exist for any controller: the largest
    delay of the command, and the largest factor on it, with which every machine recovers (docs/tune.md). For a
    controller with a linear part, `modulus_margin` is the smallest |1 + L|.

    With `out`, finished trials are stored beside it (`OUT.trials`) until all are done: after an interruption or a crash
    the same call continues. On an interruption the best gains so far are written to `out`.

    Args:
        model: a Model, or the path of a model file; its controller is tuned.
        reference: a motion, the fields of a reference file, or the path of one.
        gains: by path (`controller.kp`) a table with `from` and `to`, optional `scale` ("log" where both ends are above
            0, or "linear") and `start`, the present value; None: the usual gains of the controller, each from a tenth
            to ten times its present value.
        controller: for a user's own controller: a function that makes it from the gains by keyword; its defaults are
            the present values.
        limits: by name a number, or `{"present": 1.1}` for 1.1 times what the present gains reach; at most of
            error_max, command_max, command_rms, command_chatter, at least of delay_margin, gain_margin, modulus_margin.
        vary: how machines differ, as for `sweep`; "bounds": all parameters with [bounds] or an uncertainty.
        machines: number of machines to tune with.
        held_out: number of further machines for the evaluation.
        quantile: of rms error over the machines, above 0 and at most 1.
        trials: how many.
        against: a second objective, by the name of a limit; the trials then spread along the trade-off of both.
        seed: of machines, noise and trials.
        duration: s; 0 = that of the reference file, or the motion's own end.
        start, stop: s; error and command are evaluated over the rows with start <= time < stop.
        out: the model file to write; None: none.
        threads: 0 = all cores. The result does not depend on it.
        progress: see cogging.progress.

    Returns:
        The present and the tuned gains, what both reach, and the trade-off.

    Raises:
        ValueError: an argument breaks its rule, a path is unknown, or the present gains cannot run.
        InputError: a file cannot be used or written; finished trials are kept.
        ImportError: Optuna is not installed; names the extra.

    Example:
        >>> gains = {"controller.kp": {"from": 5e3, "to": 2e4}, "controller.kd": {"from": 20.0, "to": 100.0}}
        >>> few = {"trials": 8, "machines": 2, "held_out": 2, "duration": 0.3}
        >>> tuning = cogging.tune(model, move, gains, limits={"delay_margin": 1e-3}, **few)
        >>> tuning.tuned.drawn.error_rms < tuning.present.drawn.error_rms, tuning.tuned.drawn.delay_margin >= 1e-3
        (True, True)
    """
    optuna()
    _require_numbers({"machines": machines, "held_out": held_out, "trials": trials}, seed, quantile, against)
    model = model if isinstance(model, Model) else Model.read(model)
    own = 0.0
    if isinstance(reference, Reference):
        motion = reference
    else:
        motion, own = reference_from(reference) if isinstance(reference, Mapping) else read_reference(reference)
    setup, duration = Setup(model, motion), duration or own
    tuned = tuned_of_model(model, motion, gains) if controller is None else tuned_of_function(controller, gains)
    if not tuned.gains:
        raise FieldError("", "gains", "must name at least one, got none")
    given = checked_limits(limits or {})
    variations, notes = variations_of(setup, vary)
    judge, fresh = (
        Judge(machines_of(setup, variations, count, seed, stream), tuned, duration, start, stop, quantile, threads)
        for stream, count in enumerate((machines, held_out))
    )
    task = _Task(tuned, given, judge, fresh, motion, duration, against, notes, model.units)
    kept = None
    if out is not None and controller is None:
        described = {
            "reference": reference_to_dict(motion),
            "gains": [list(vars(gain).values()) for gain in tuned.gains],
            "vary": dict(vary) if isinstance(vary, Mapping) else vary,
            "limits": given,
            "run": [duration, start, stop, quantile, machines, seed, against],
        }
        digest = digest_of(model, described)
        kept = None if digest is None else KeptTrials(out, digest)
    found: list[Trial] = []
    try:
        with steps(progress, "tune", trials) as step:
            best = math.inf
            for number, trial in enumerate(run_trials(tuned.gains, trials, seed, against, task.judged, kept), 1):
                found.append(trial)
                best = min(best, trial.reached.error_rms) if trial.kept else best
                step(f"trial {number}" + (f", best {1e6 * best:.4g} {model.units.of('um')}" if best < math.inf else ""))
        result = task.result(found, quantile, seed, progress)
    except BaseException:  # also an interruption: keep the trials, and write the best so far
        if kept is not None:
            kept.write()
        nearest = best_of([task.present, *found])
        better = tuned.model(nearest.gains) if nearest is not None and nearest is not task.present else None
        if out is not None and better is not None:
            better.write(out)
        raise
    if out is not None and result.model is not None:
        result.model.write(out)
    if kept is not None:
        kept.remove()
    return result


def _require_numbers(counts: Mapping[str, int], seed: int, quantile: float, against: str | None) -> None:
    for name, value in {**counts, "seed": seed}.items():
        least = int(name != "seed")
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= MOST:
            raise FieldError("", name, f"must be a whole number from {least} to {MOST}, got {value!r}")
    if not isinstance(quantile, int | float) or not 0.0 < quantile <= 1.0:
        raise FieldError("", "quantile", f"must be above 0, at most 1, got {quantile!r}")
    if against is not None and against not in INDEXES:
        raise FieldError("", "against", f"is none: {quoted(against)}; {did_you_mean(str(against), INDEXES)}")


class _Task:
    """The machines and limits of one tuning, and the present gains evaluated on them."""

    def __init__(
        self,
        tuned: Tuned,
        limits: Mapping[str, Any],
        judge: Judge,
        fresh: Judge,
        motion: Reference,
        duration: float,
        against: str | None,
        notes: Sequence[str],
        units: Units,
    ) -> None:
        self.tuned, self.judge, self.fresh, self.against = tuned, judge, fresh, against
        self.notes, self.units = list(notes), units
        reached = judge.run(tuned.present)
        command = reached.command_max if math.isfinite(reached.command_max) else 0.0
        # A loop that fails has no command of its own: that of 1 m/s^2 is used.
        command = command or judge.machines[0].setup.model.axis.mass
        self.push = push_of(motion, tuned.make(tuned.present).sample_rate, duration, command)
        reached = judge.with_margins(tuned.present, reached, self.push)
        self.limits = limits_as_numbers(limits, reached)
        self.present = Trial(tuned.present, reached, self._excesses(tuned.present, reached))

    def _excesses(self, gains: Mapping[str, float], reached: Reached) -> dict[str, float]:
        return excesses(self.limits, gains, reached, self.judge, self.push)

    def judged(self, values: Mapping[str, float]) -> Trial:
        """Evaluate the gains of a trial."""
        if values == self.present.gains:
            return self.present
        try:
            reached = self.judge.run(values)
        except ValueError:  # these gains together break a rule of the controller
            margins = dict.fromkeys(MARGINS, 0.0) if self.against in MARGINS else {}
            nothing = dict.fromkeys(("error_rms", "error_max", "command_max", "command_rms", CHATTER), math.inf)
            worst = Reached(**nothing, failed=len(self.judge.machines), **margins)
            return Trial(values, worst, {ALL_END: 1.0, **dict.fromkeys(self.limits, 1.0), RULE: 1.0})
        if self.against in MARGINS:
            reached = self.judge.with_margins(values, reached, self.push, (self.against,))
        return Trial(values, reached, self._excesses(values, reached))

    def result(self, found: list[Trial], quantile: float, seed: int, progress: Progress) -> Tuning:
        """Evaluate the best gains on machines held out, with all margins."""
        best, against = best_of([self.present, *found]), self.against or CHATTER
        places = front_of(found, against)
        if len(places) > FRONT_MOST:
            places = [places[i] for i in np.unique(np.linspace(0, len(places) - 1, FRONT_MOST).round().astype(int))]

        def setting(trial: Trial) -> Setting:
            drawn = self.judge.with_margins(trial.gains, trial.reached, self.push)
            fresh = self.fresh.with_margins(trial.gains, self.fresh.run(trial.gains), self.push)
            return Setting(dict(trial.gains), drawn, fresh)

        with steps(progress, "tune: margins", len(places) + 2) as step:
            present = setting(self.present)
            step("of the present gains")
            tuned = present if best is self.present else None if best is None else setting(best)
            step("of the tuned gains")
            margins = []
            for place in places:
                margins.append(self.judge.loops(found[place].gains, self.push).delay_margin())
                step(f"of trial {place}")
        paths = self.tuned.present
        table: dict[str, Any] = {path: np.array([trial.gains[path] for trial in found]) for path in paths}
        for name in ROWS:
            numbers = [getattr(trial.reached, name) for trial in found]
            if all(number is not None for number in numbers):
                table[name] = np.array(numbers, dtype=float)
        table["kept"] = np.array([trial.kept for trial in found], dtype=bool)
        front = {name: table[name][places] for name in dict.fromkeys((*FRONT, *paths, against))}
        front |= {"trial": np.array(places, dtype=int), "delay_margin": np.array(margins, dtype=float)}
        notes = self._failure_notes(found) if best is None else self._notes(best)
        return Tuning(
            present=present,
            tuned=tuned,
            improved=best is not None and best.gains != self.present.gains,
            model=None if best is None else self.tuned.model(best.gains),
            trials=table,
            front=front,
            against=against,
            limits=tuple(limit_text(name, limit, self.units) for name, limit in self.limits.items()),
            machines=len(self.judge.machines),
            held_out=len(self.fresh.machines),
            quantile=quantile,
            seed=seed,
            notes=(*self.notes, *notes),
            units=self.units,
        )

    def _failure_notes(self, found: list[Trial]) -> list[str]:
        """Which limit failed most and by how much, and the trial that breaks the limits least."""
        counts = {
            name: sum(trial.excess.get(name, 0.0) > 0.0 for trial in found) for name in (*self.limits, ALL_END, RULE)
        }
        name = max(counts, key=lambda one: counts[one])
        least = min((trial.excess[name] for trial in found if name in trial.excess), default=0.0)
        by = f"at best by {100 * least:.3g} %" if least > 0.0 else "but not in all of them at once"
        most = f"the one that failed most is {name}: in {counts[name]} of {len(found)} trials, {by}"
        trials = [self.present, *found]
        nearest = min(trials, key=lambda trial: sum(max(value, 0.0) for value in trial.excess.values()))
        gains = ", ".join(f"{path} = {value:.4g}" for path, value in nearest.gains.items())
        if RULE in nearest.excess:
            return [f"no trial keeps all limits; {most}", f"nearest is {gains}: they break a rule of the controller"]
        reached = self.judge.with_margins(nearest.gains, nearest.reached, self.push)
        broken = [
            limit_text(name, limit, self.units, getattr(reached, name))
            for name, limit in self.limits.items()
            if nearest.excess[name] > 0.0
        ]
        if reached.failed:
            broken.append(f"{reached.failed} of {len(self.judge.machines)} machines do not complete their run")
        return [f"no trial keeps all limits; {most}", f"nearest is {gains}: {'; '.join(broken)}"]

    def _notes(self, best: Trial) -> list[str]:
        notes = []
        if best.gains == self.present.gains:
            notes.append("the present gains are the best that were tried")
        elif not self.present.kept:
            broken = [name for name, value in self.present.excess.items() if value > 0.0]
            notes.append(f"the present gains break a limit: {', '.join(broken)}")
        for gain in self.tuned.gains:
            low, high, at = gain.low, gain.high, best.gains[gain.path]
            if gain.logarithmic:
                low, high, at = math.log(low), math.log(high), math.log(max(at, low))
            share = (at - low) / (high - low)
            end = "lower" if 0.0 <= share < AT_END else "upper" if 1.0 - AT_END < share <= 1.0 else ""
            if end:
                notes.append(f"{gain.path}: the best is at the {end} end of its range, a wider one may do better")
        return notes


# Tune files -----------------------------------------------------------------------------------------------------------


def read_tune(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Read a tune file: the arguments of `tune`, with paths relative to the working directory.

    Raises:
        InputError: the file cannot be used; names file, line, field, rule and value.
    """
    document = read_toml(path)
    try:
        require_keys(document, TUNE, TUNE_NEEDED)
    except FieldError as error:
        raise error.in_file(path, read_text(path)) from None
    folder = Path(path).parent
    return {**document, **{key: folder / document[key] for key in ("model", "reference")}}


def files_of_tune(arguments: Mapping[str, Any], path: str | os.PathLike[str]) -> list[AnyPath]:
    """The files that a tuning reads: the tune file, its model, its reference and the files this names."""
    return files_of_job(arguments, path)


def run_tune(path: str | os.PathLike[str], arguments: Mapping[str, Any], **options: Any) -> Tuning:
    """Run `tune` with what read_tune returns.

    Raises:
        InputError: an error found by the tuning; names the file, and the line if the value stands in it.
    """
    return run_job(path, tune, arguments, options)
