"""Tune the gains of a controller for an uncertain machine: the smallest rms error within limits."""

from __future__ import annotations

import copy
import importlib
import inspect
import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from cogging._core import Reference
from cogging.calls import Kind, check_arguments, did_you_mean
from cogging.design.linear_plant import modulus_margin
from cogging.design.loop_margins import GAIN_MOST, Loops, Machine, machines_of, push_of, variations_of
from cogging.file_schema import TUNE_INDEXES
from cogging.files import FieldError, refuse_unknown_keys
from cogging.model.controller import AnyController
from cogging.model.model import Model, is_number
from cogging.model.units import Units
from cogging.outputs import write_bytes
from cogging.plot.canvas import grid_to_write, plot_method, png
from cogging.plot.results import WHOLE_TUNING, whole_tuning
from cogging.progress import Progress, steps
from cogging.resources import on_one_blas_thread
from cogging.shown import quoted
from cogging.simulation import varied
from cogging.simulation.arguments import MODEL, REFERENCE
from cogging.simulation.kept_work import KeptWork
from cogging.simulation.reductions import kept_of_runs, names_of
from cogging.simulation.reference import motion_of, reference_to_dict
from cogging.simulation.varied import BOUNDS, Setup, make_controller, range_of, with_numbers
from cogging.tables import frame_of
from cogging.values import ByValue

MARGINS = ("delay_margin", "gain_margin", "modulus_margin")
ROWS = ("error_rms", *TUNE_INDEXES)
SCALED = {"error_rms": (1e6, "um"), "error_max": (1e6, "um"), "delay_margin": (1e3, "ms")}  # for the screen


@dataclass(frozen=True)
class Reached:
    """What gains reach on a set of machines; a margin is the smallest over them, None where it is not measured."""

    error_rms: float  # m, the quantile over the machines; infinite where a run did not complete
    error_max: float  # m, the largest of all machines, as are the command's indexes
    command_max: float  # V
    command_rms: float  # V
    command_chatter: float  # of the command (see Performance)
    failed: int = 0  # number of machines on which the run did not complete
    delay_margin: float | None = None  # s
    gain_margin: float | None = None  # factor
    modulus_margin: float | None = None  # None also for a controller without a linear part


@dataclass(frozen=True)
class Setting:
    """Gains and what they reach."""

    gains: Mapping[str, float]  # by path
    drawn: Reached  # on the machines tuned with
    held_out: Reached  # on machines held out


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
        settings = {"present": self.present} | ({} if self.tuned is None else {"tuned": self.tuned})
        width = max(len(path) for path in (*self.present.gains, *ROWS)) + 6
        lines.append(f"    {'gain':<{width}}" + "".join(f"{name:>12}" for name in settings))
        for path in self.present.gains:
            lines.append(f"    {path:<{width}}" + "".join(f"{one.gains[path]:>12.5g}" for one in settings.values()))
        columns = {name: setting.drawn for name, setting in settings.items()}
        columns |= {f"{name}, held out": setting.held_out for name, setting in settings.items()}
        lines.append(f"    {'':<{width}}" + "".join(f"{title:>19}" for title in columns))
        for row in ROWS:
            cells = [getattr(reached, row) for reached in columns.values()]
            factor, unit = SCALED.get(row) or (1.0, TUNE_INDEXES[row]["unit"])
            name = row if unit == "1" else f"{row}, {self.units.of(unit)}"
            if any(cell is not None for cell in cells):
                shown = ["-" if cell is None else f"{factor * cell:.4g}" for cell in cells]
                lines.append(f"    {name:<{width}}" + "".join(f"{cell:>19}" for cell in shown))
        if self.tuned is not None and self.improved:
            changes = []
            for name in ("error_rms", "command_chatter", *MARGINS):
                old, new = getattr(self.present.drawn, name), getattr(self.tuned.drawn, name)
                if old is not None and new is not None and np.isfinite([old, new]).all() and old > 0.0:
                    changes.append(f"{name} {100 * (new / old - 1):+.0f} %")
            lines.append(f"    tuned against present: {', '.join(changes or ['the present gains do not run'])}")
        return "\n".join([*lines, *(f"  note: {note}" for note in self.notes)])

    def to_frame(self, what: str = "trials") -> Any:
        """The `trials` or the `front` as a pandas DataFrame (extra `frames`), with units in `attrs["units"]`.

        Raises:
            ValueError: `what` is neither.
        """
        if what not in ("trials", "front"):
            raise ValueError(f"what: must be trials or front, got {what!r}")
        labels = {name: self.units.of(one["unit"]) for name, one in TUNE_INDEXES.items()}
        table = self.trials if what == "trials" else self.front
        return frame_of(table, labels | {"error_rms": self.units.position})

    def to_dict(self) -> dict[str, Any]:
        """What `cogging tune --json` writes; null stands for infinite and for not measured."""
        names = ("improved", "against", "front", "trials", "limits", "machines", "held_out", "quantile", "seed")
        settings = {"present": asdict(self.present), "tuned": None if self.tuned is None else asdict(self.tuned)}
        return settings | {name: getattr(self, name) for name in (*names, "notes")}

    plot = plot_method(whole_tuning, "Draw the trade-off, rms error over its index, and over the margin.", "two axes")

    def write_figure(self, path: str | os.PathLike[str]) -> None:
        """Write the trade-off as PNG.

        Raises:
            InputError: the file cannot be written.
        """
        write_bytes(path, png(self.plot(ax=grid_to_write(1, 2, WHOLE_TUNING))))


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

CHATTER = "command_chatter"  # traded against the rms error by default
ALL_END = "all runs complete"
RULE = "a rule of the controller"
BEYOND = 1e3  # largest relative excess of a limit
WORST = 1e9  # replaces an infinite objective, of trials that break a limit anyway
FRONT = ("error_rms", "command_max", "command_chatter")  # columns of the trade-off
FRONT_MOST = 8  # points of the trade-off whose margins are measured
AT_END = 0.01  # of a range, or of its logarithm: closer to its end a gain counts as at the end
CONTROLLER = Kind((Callable, type(None)), "a function that makes a controller of gains")  # type: ignore[arg-type]
TABLE = Kind((Mapping, type(None)), "a table of gains by path")


# The gains ------------------------------------------------------------------------------------------------------------


class Gain(NamedTuple):
    """One number that is tuned."""

    path: str  # `controller.kp` of a model, or the name of an argument of a user's function
    low: float  # low, high: ends of its range
    high: float
    logarithmic: bool  # whether it is searched on a logarithmic scale
    present: float  # its present value, within the range or not
    whole: bool  # whether it is a whole number


def gains_of(setup: Setup, make: Callable[..., AnyController] | None, ranges: Mapping[str, Any] | None) -> list[Gain]:
    """Return the gains of the model's controller, or of one that a user's function makes from them by keyword.

    `ranges`: tables by path; None for the usual gains of the model's controller.
    """
    known: dict[str, float | None]
    if make is None:
        fields, what, is_open = make_controller(setup.model).parameters.to_dict(), "number", False
        known = {path: one.value for path, one in varied.numbers_of(setup).items() if one and path.startswith(PREFIX)}
        if ranges is None:
            paths = [f"{PREFIX}{name}" for name in USUAL.get(setup.model.controller_type or "", ())]
            values = {path: float(known.get(path) or 0.0) for path in paths}
            ranges = {p: {"from": v / DECADE, "to": v * DECADE, "scale": "log"} for p, v in values.items() if v > 0.0}
    else:
        parameters = inspect.signature(make).parameters.values()
        fields, what, is_open = {}, "argument", any(one.kind is one.VAR_KEYWORD for one in parameters)
        known = {one.name: one.default if is_number(one.default) else None for one in parameters}
    gains = []
    for path, given in (ranges or {}).items():
        if path not in known and not is_open:
            raise FieldError("gains", path, f"is no {what} of the controller; {did_you_mean(path, known)}")
        name, _, place = path.removeprefix(PREFIX).partition("[")
        entry = fields.get(name)
        entry = entry[int(place.rstrip("]"))] if isinstance(entry, list) else entry
        gains.append(_gain(path, given, known.get(path), isinstance(entry, int)))
    return gains


def _gain(path: str, given: Any, present: float | None, whole: bool) -> Gain:
    """Return one gain from its checked entry in the table of gains."""
    if not isinstance(given, Mapping):
        raise FieldError("gains", path, f"must be a table with from and to, got {quoted(given)}")
    refuse_unknown_keys(given, KEYS, f"gains.{path}")
    for key in ("from", "to"):
        if key not in given:
            raise FieldError("gains", path, f"{key}: must be given, got nothing")
    for key, value in given.items():
        if key != "scale" and not (is_number(value) and math.isfinite(value)):
            raise FieldError("gains", path, f"{key}: must be a number, got {quoted(value)}")
    low, high, is_log = range_of("gains", path, given, "log" if given["from"] > 0 else "linear")
    if whole and (low % 1.0 or high % 1.0):
        raise FieldError("gains", path, f"from, to: must be whole numbers, got {low:g} and {high:g}")
    middle = math.sqrt(low * high) if is_log else 0.5 * (low + high)
    start = float(given["start"]) if "start" in given else middle if present is None else float(present)
    return Gain(path, low, high, is_log, start, whole)


# Limits ---------------------------------------------------------------------------------------------------------------


def checked_limits(given: Mapping[str, Any]) -> dict[str, float | Mapping[str, float]]:
    """Return the limits as given, checked: a number each, or `{"present": factor}`."""
    if not isinstance(given, Mapping):
        raise FieldError("", "limits", f"must be a table of limits by name, got {quoted(given)}")
    refuse_unknown_keys(given, TUNE_INDEXES, "limits")
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


def limit_text(name: str, limit: float, units: Units, reached: float | None = None) -> str:
    """Return a limit in words, optionally with the value reached."""
    unit, is_upper = TUNE_INDEXES[name]["unit"], TUNE_INDEXES[name]["at_most"]
    label = "" if unit == "1" else f" {units.of(unit)}"
    rule = f"{name}: {'at most' if is_upper else 'at least'} {limit:.4g}{label}"
    return rule if reached is None else f"{rule}, reached {reached:.4g}{label}"


# Trials ---------------------------------------------------------------------------------------------------------------


class Trial(NamedTuple):
    """One set of gains, what it reached on the machines tuned with, and the relative excess of each limit."""

    gains: Mapping[str, float]
    reached: Reached
    excess: Mapping[str, float]

    @property
    def kept(self) -> bool:
        """Whether all limits are kept."""
        return all(value <= 0.0 for value in self.excess.values())


@dataclass
class Judge:
    """Runs gains on drawn machines, and compares what they reach with limits."""

    machines: Sequence[Machine]
    make: Callable[[Mapping[str, float]], AnyController]  # the controller from values of the gains
    with_gains: Callable[[Mapping[str, float]], Model] | None  # the model with them; None for a user's own controller
    given_limits: Mapping[str, Any]
    against: str | None  # the second objective: a margin of this name is measured in each trial
    duration: float  # s, of a run
    window: tuple[float, float]  # s, of the indexes
    quantile: float
    threads: int

    def measure_present(self, present: Mapping[str, float]) -> None:
        """Run the present gains, which set the push that measures margins, and the limits relative to them."""
        reached, setup = self.run(present), self.machines[0].setup
        command = reached.command_max if math.isfinite(reached.command_max) else 0.0
        command = command or setup.model.axis.mass  # that of 1 m/s^2: a loop that fails has no command of its own
        self.push = push_of(setup.reference, self.make(present).sample_rate, self.duration, command)
        reached = self.with_margins(present, reached)
        self.limits: dict[str, float] = {}
        for name, value in self.given_limits.items():
            now = getattr(reached, name)
            if name == "modulus_margin" and now is None:
                raise FieldError("limits", name, "needs a controller with a linear part, which this one does not have")
            if isinstance(value, Mapping):
                if now is None or not math.isfinite(now) or now <= 0:
                    raise FieldError("limits", name, f"must be a number: the present gains reach none, got {now}")
                value = value["present"] * now
            self.limits[name] = float(value)
        self.present = Trial(present, reached, self._excesses(present, reached))

    def run(self, gains: Mapping[str, float]) -> Reached:
        """Return what gains reach, without margins; ValueError: they break a rule, or no run can start."""
        machines = self.machines
        kept = kept_of_runs(
            [machine.setup.model.plant() for machine in machines],
            [self.make(gains)] * len(machines),
            [machine.setup.reference for machine in machines],
            durations=[self.duration],
            seeds=[machine.seed for machine in machines],
            steps_per_sample=[machines[0].setup.model.steps_per_sample],
            threads=self.threads,
            window=(*self.window, 2.0),
            reductions=("command_max",),
            keeps_refused=True,
        )
        if len(kept.failures) == len(machines) and all(math.isnan(one.time) for one in kept.failures):
            raise ValueError(kept.failures[0].reason)
        columns = np.where(np.isnan(kept.values), np.inf, kept.values).T
        values = dict(zip(names_of(("command_max",)), columns, strict=True))
        largest = {name: float(values[name].max()) for name in TUNE_INDEXES if name in values}
        # Of rank ceil(q (n + 1)): one more machine exceeds it with probability at most 1 - q.
        rank = min(len(machines), math.ceil(self.quantile * (len(machines) + 1) - 1e-9))
        error = float(np.sort(values["error_rms"])[rank - 1]) if not kept.failures else math.inf
        return Reached(error, failed=len(kept.failures), **largest)

    def loops(self, gains: Mapping[str, float]) -> Loops:
        """Return the loops of these gains, on which a push measures margins."""
        return Loops(self.machines, self.make(gains), self.push, threads=self.threads)

    def with_margins(self, gains: Mapping[str, float], reached: Reached, names: Sequence[str] = MARGINS) -> Reached:
        """Return the same with margins; those that this controller does not have stay None."""
        found: dict[str, Any] = dict.fromkeys(names, 0.0)
        if "modulus_margin" in names:
            margin = self._modulus_margin(gains)
            found["modulus_margin"] = margin if margin is None or not reached.failed else 0.0
        pushed = [name for name in names if name != "modulus_margin"]
        if pushed and not reached.failed:
            loops = self.loops(gains)
            found |= {name: getattr(loops, name)() for name in pushed}
        return replace(reached, **found)

    def _modulus_margin(self, gains: Mapping[str, float]) -> float | None:
        """Return the smallest over the machines; None without a linear part."""
        if self.with_gains is None:
            return None
        controller = self.with_gains(gains).controller
        found = [modulus_margin(machine.setup.model.replace(controller=controller)) for machine in self.machines]
        return min((margin for margin in found if margin is not None), default=None)

    def _excesses(self, gains: Mapping[str, float], reached: Reached) -> dict[str, float]:
        """Relative excess of each limit; of a delay or gain margin the share of machines that fail with it."""
        found = {ALL_END: reached.failed / len(self.machines)}
        loops = None
        for name, limit in self.limits.items():
            value = getattr(reached, name)
            if value is None and name == "modulus_margin" and not reached.failed:
                value = self._modulus_margin(gains)
            if value is not None and math.isfinite(value):
                found[name] = min(value / limit - 1.0 if TUNE_INDEXES[name]["at_most"] else 1.0 - value / limit, BEYOND)
            elif value is None and reached.failed:
                found[name] = 1.0
            elif value is None and name in ("delay_margin", "gain_margin"):
                loops = loops or self.loops(gains)
                found[name] = loops.share_lost(**{name.removesuffix("_margin"): limit})
            else:
                found[name] = BEYOND
        return found

    def trial(self, gains: Mapping[str, float]) -> Trial:
        """Return the trial of these gains."""
        if gains == self.present.gains:
            return self.present
        try:
            reached = self.run(gains)
        except ValueError:  # these gains together break a rule of the controller
            margins = [0.0] * 3 if self.against in MARGINS else [None] * 3
            worst = Reached(math.inf, math.inf, math.inf, math.inf, math.inf, len(self.machines), *margins)
            return Trial(gains, worst, {ALL_END: 1.0, **dict.fromkeys(self.limits, 1.0), RULE: 1.0})
        if self.against in MARGINS:
            reached = self.with_margins(gains, reached, names=(self.against,))
        return Trial(gains, reached, self._excesses(gains, reached))

    def setting(self, trial: Trial, held_out: Sequence[Machine]) -> Setting:
        """Return the gains of a trial with all margins, on the machines tuned with and on those held out."""
        drawn, fresh = self.with_margins(trial.gains, trial.reached), copy.copy(self)
        fresh.machines = held_out
        return Setting(dict(trial.gains), drawn, fresh.with_margins(trial.gains, fresh.run(trial.gains)))


def optuna() -> Any:
    """Return the library that proposes gains; ImportError names the extra."""
    try:
        return importlib.import_module("optuna")
    except ImportError as error:
        raise ImportError("optuna is needed for this and is not there: pip install 'cogging[tune]'") from error


def run_trials(gains: Sequence[Gain], count: int, seed: int, judge: Judge, kept: KeptWork) -> Iterator[Trial]:
    """Let Optuna's TPE sampler with constraints propose gains, and judge them one by one; the present ones first.

    The same arguments give the same trials. Trials in `kept` are not run again; the sampler receives them like any
    other, and continues as it would have.
    """
    library, against = optuna(), judge.against
    other = [] if against is None else ["minimize" if TUNE_INDEXES[against]["at_most"] else "maximize"]
    study = library.create_study(sampler=library.samplers.TPESampler(seed=seed), directions=["minimize", *other])
    if all(gain.low <= gain.present <= gain.high for gain in gains):
        study.enqueue_trial({g.path: int(g.present) if g.whole else g.present for g in gains})
    of, space = library.distributions, {}
    for gain in gains:
        make, number = (of.IntDistribution, int) if gain.whole else (of.FloatDistribution, float)
        space[gain.path] = make(number(gain.low), number(gain.high), log=gain.logarithmic)
    known = {tuple(done.items()): Trial(done, Reached(**reached), excess) for done, reached, excess in kept.parts}
    for _ in range(count):
        proposed = study.ask(space)
        values = {gain.path: float(proposed.params[gain.path]) for gain in gains}
        trial = known.get(tuple(values.items()))
        if trial is None:
            trial = judge.trial(values)
            kept.add([dict(trial.gains), vars(trial.reached), dict(trial.excess)])
        objectives = [trial.reached.error_rms, *([] if against is None else [getattr(trial.reached, against)])]
        for name, value in trial.excess.items():
            proposed.set_constraint(name, value)
        study.tell(proposed, [value if math.isfinite(value) else WORST for value in objectives])
        yield trial


def best_of(trials: Sequence[Trial]) -> Trial | None:
    """Return the trial with the smallest rms error of those that keep all limits, or None."""
    return min((trial for trial in trials if trial.kept), key=lambda trial: trial.reached.error_rms, default=None)


def front_of(trials: Sequence[Trial], against: str) -> list[int]:
    """Return the places of the kept trials that none beats in both rms error and an index, by falling error."""
    sign = 1.0 if TUNE_INDEXES[against]["at_most"] else -1.0
    kept = [(t.reached.error_rms, sign * getattr(t.reached, against), n) for n, t in enumerate(trials) if t.kept]
    front: list[int] = []
    least = math.inf
    for _, cost, place in sorted(kept):
        if cost < least:
            front.append(place)
            least = cost
    return front[::-1]


# The tuning -----------------------------------------------------------------------------------------------------------


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

    Delay and gain margins are measured by a force pulse on each machine, so they exist for any controller
    (docs/tune.md). With `out`, finished trials are stored beside it (`OUT.kept`) until all are done: after an
    interruption the same call continues, and the best gains so far are in `out`.

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
    library = optuna()
    counts = {"machines": machines, "held_out": held_out, "trials": trials}
    varied.require_numbers(counts, seed, duration, (start, stop, 1.0), threads)
    if not is_number(quantile) or not 0.0 < quantile <= 1.0:
        raise FieldError("", "quantile", f"must be above 0, at most 1, got {quantile!r}")
    if against is not None and against not in TUNE_INDEXES:
        raise FieldError("", "against", f"is none: {quoted(against)}; {did_you_mean(str(against), TUNE_INDEXES)}")
    model = model if isinstance(model, Model) else Model.read(model)
    motion, own = motion_of(reference)
    setup, duration = Setup(model, motion), duration or own
    ranges = gains_of(setup, controller, gains)
    if not ranges:
        raise FieldError("", "gains", "must name at least one, got none")
    given = checked_limits(limits or {})
    variations, notes = variations_of(setup, vary)
    drawn, fresh = (machines_of(setup, variations, n, seed, stream) for stream, n in enumerate((machines, held_out)))

    def with_gains(values: Mapping[str, float]) -> Model:
        return with_numbers(setup, values).model

    def make(values: Mapping[str, float]) -> AnyController:
        return with_gains(values).make_controller() if controller is None else controller(**values)

    present = {gain.path: gain.present for gain in ranges}
    of_model = with_gains if controller is None else None
    judge = Judge(drawn, make, of_model, given, against, duration, (start, stop), quantile, threads)
    judge.measure_present(present)
    described = {
        "reference": reference_to_dict(motion),
        "gains": [list(gain) for gain in ranges],
        "vary": dict(vary) if isinstance(vary, Mapping) else vary,
        "limits": given,
        "run": [duration, start, stop, quantile, machines, seed, against],
    }
    kept = KeptWork(out if controller is None else None, model, described)
    found, traded = list[Trial](), against or CHATTER
    verbosity = library.logging.get_verbosity()
    library.logging.set_verbosity(library.logging.ERROR)
    try:
        with steps(progress, "tune", trials) as step, kept.named_in_errors():
            for trial in run_trials(ranges, trials, seed, judge, kept):
                found.append(trial)
                leader = best_of(found)
                shown = "" if leader is None else f", best {1e6 * leader.reached.error_rms:.4g} {model.units.of('um')}"
                step(f"trial {len(found)}{shown}")
        best, front = best_of([judge.present, *found]), front_of(found, traded)
        if len(front) > FRONT_MOST:
            front = [front[i] for i in np.unique(np.linspace(0, len(front) - 1, FRONT_MOST).round().astype(int))]
        with steps(progress, "tune: margins", len(front) + 2) as step:
            before = judge.setting(judge.present, fresh)
            step("of the present gains")
            after = before if best is judge.present else None if best is None else judge.setting(best, fresh)
            step("of the tuned gains")
            margins = []
            for place in front:
                margins.append(judge.loops(found[place].gains).delay_margin())
                step(f"of trial {place}")
    except BaseException:  # also an interruption: write the best so far
        nearest = best_of([judge.present, *found])
        if out is not None and of_model is not None and nearest is not None and nearest is not judge.present:
            of_model(nearest.gains).write(out)
        raise
    finally:
        library.logging.set_verbosity(verbosity)
    tuned_model = None if best is None or of_model is None else of_model(best.gains)
    table, trade_off = _tables(found, front, margins, traded)
    result = Tuning(
        present=before,
        tuned=after,
        improved=best is not None and best.gains != present,
        model=tuned_model,
        trials=table,
        front=trade_off,
        against=traded,
        limits=tuple(limit_text(name, limit, model.units) for name, limit in judge.limits.items()),
        machines=machines,
        held_out=held_out,
        quantile=quantile,
        seed=seed,
        notes=(*notes, *(_failure_notes(judge, found, model.units) if best is None else _notes(judge, best, ranges))),
        units=model.units,
    )
    if out is not None and tuned_model is not None:
        tuned_model.write(out)
    kept.remove()
    return result


def _tables(
    found: Sequence[Trial], front: Sequence[int], margins: Sequence[float], against: str
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the tables of the trials and of the trade-off."""
    paths = list(found[0].gains)
    table: dict[str, Any] = {path: np.array([trial.gains[path] for trial in found]) for path in paths}
    for name in ROWS:
        numbers = [getattr(trial.reached, name) for trial in found]
        if all(number is not None for number in numbers):
            table[name] = np.array(numbers, dtype=float)
    table["kept"] = np.array([trial.kept for trial in found], dtype=bool)
    trade_off = {name: table[name][list(front)] for name in dict.fromkeys((*FRONT, *paths, against))}
    trade_off |= {"trial": np.array(front, dtype=int), "delay_margin": np.array(margins, dtype=float)}
    return table, trade_off


def _failure_notes(judge: Judge, found: Sequence[Trial], units: Units) -> list[str]:
    """Return which limit failed most and by how much, and the trial that breaks the limits least."""
    counts = {name: sum(t.excess.get(name, 0.0) > 0.0 for t in found) for name in (*judge.limits, ALL_END, RULE)}
    name = max(counts, key=lambda one: counts[one])
    least = min((trial.excess[name] for trial in found if name in trial.excess), default=0.0)
    by = f"at best by {100 * least:.3g} %" if least > 0.0 else "but not in all of them at once"
    often = f"in {counts[name]} of {len(found)} trials, {by}"
    most = f"no trial keeps all limits; the one that failed most is {name}: {often}"
    nearest = min([judge.present, *found], key=lambda trial: sum(max(value, 0.0) for value in trial.excess.values()))
    gains = ", ".join(f"{path} = {value:.4g}" for path, value in nearest.gains.items())
    if RULE in nearest.excess:
        return [most, f"nearest is {gains}: they break a rule of the controller"]
    reached = judge.with_margins(nearest.gains, nearest.reached)
    limits = [(name, limit) for name, limit in judge.limits.items() if nearest.excess[name] > 0.0]
    broken = [limit_text(name, limit, units, getattr(reached, name)) for name, limit in limits]
    if reached.failed:
        broken.append(f"{reached.failed} of {len(judge.machines)} machines do not complete their run")
    return [most, f"nearest is {gains}: {'; '.join(broken)}"]


def _notes(judge: Judge, best: Trial, gains: Sequence[Gain]) -> list[str]:
    """Return remarks on the best trial: limits that the present gains break, gains at the end of their range."""
    notes = []
    if best.gains == judge.present.gains:
        notes.append("the present gains are the best that were tried")
    elif not judge.present.kept:
        broken = [name for name, value in judge.present.excess.items() if value > 0.0]
        notes.append(f"the present gains break a limit: {', '.join(broken)}")
    for gain in gains:
        law: Callable[[float], float] = math.log if gain.logarithmic else float
        low, high, at = law(gain.low), law(gain.high), law(max(best.gains[gain.path], gain.low))
        share = (at - low) / (high - low)
        end = "lower" if share < AT_END else "upper" if 1.0 - AT_END < share <= 1.0 else ""
        if end and best.gains[gain.path] >= gain.low:
            notes.append(f"{gain.path}: the best is at the {end} end of its range, a wider one may do better")
    return notes
