"""Predict the tracking error of each controller on a reference, with an interval."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cogging import plot
from cogging._core import Arc, Cascade, Dcarc, ObserverBased, OutputFeedbackArc, Pid, Reference
from cogging.arrays import FloatArray, real_array
from cogging.calls import check_arguments, entry_named
from cogging.design.bounds import Bounds
from cogging.design.observer import design_observer
from cogging.model.controller import AnyController
from cogging.model.intervals import SIGMAS_95, Interval, Intervals
from cogging.model.model import Model, is_number
from cogging.model.parameters import with_values
from cogging.model.units import Units
from cogging.outputs import finite
from cogging.resources import on_one_blas_thread, require_machines
from cogging.shown import not_one_of
from cogging.simulation.arguments import MODEL, REFERENCE
from cogging.simulation.reductions import INDEXES as OF_A_RUN
from cogging.simulation.reductions import kept_of_runs
from cogging.simulation.reference import motion_of
from cogging.simulation.varied import require_numbers
from cogging.tables import frame_of
from cogging.values import ByValue

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DRAWS_MAX = 1000  # of one machine, until its values are valid
Covariance = tuple[Sequence[str], npt.ArrayLike]  # paths (p) and matrix (p, p)


class DrawnMachine(NamedTuple):
    """A machine, the seed of its noise, and the parameters that were drawn, by path."""

    model: Model
    seed: int
    values: dict[str, float]


def drawn_machines(
    intervals: Intervals, samples: int, seed: int, covariance: Covariance | None = None
) -> tuple[list[DrawnMachine], list[str]]:
    """Draw machines from the intervals of a model, and return them with the parameters that are held, in words.

    Each parameter is normal around the model's value, those of `covariance`, paths (p) and matrix (p, p), jointly; an
    invalid machine is drawn again. ValueError: an invalid covariance or interval, or hardly a valid machine.
    """
    model = intervals.model
    joint, root = covariance_root(covariance or ((), np.empty((0, 0))), intervals.paths)
    spread, held = {}, []
    for path in (path for path in intervals.paths if path not in joint):
        try:
            interval = intervals.of(path)
        except ValueError as error:
            if np.isfinite(model.intervals.get(path, (0.0, 0.0))).all():
                raise
            held.append(f"{path} held at {intervals.value(path):g}: the interval of the error is unbounded. {error}")
            continue
        if interval is not None and interval[0] < interval[1]:
            spread[path] = interval
    require_machines("samples", samples, len(joint) + len(spread))
    machines = []
    for place in range(samples):
        numbers = np.random.default_rng([seed, place])
        noise_seed = int(numbers.integers(2**63))
        for _ in range(DRAWS_MAX):
            normals = numbers.standard_normal(len(joint) + len(spread))
            values = dict(zip(joint, root @ normals[: len(joint)], strict=True))
            values = {path: intervals.value(path) + float(change) for path, change in values.items()}
            for (path, (low, high)), normal in zip(spread.items(), normals[len(joint) :].tolist(), strict=True):
                value = intervals.value(path)  # the median; a normal shape on either side
                values[path] = value + normal * (high - value if normal > 0 else value - low) / SIGMAS_95
            try:
                machines.append(DrawnMachine(with_values(model, values), noise_seed, values))
                break
            except ValueError as error:
                reason = error
        else:
            raise ValueError(f"bounds: {DRAWS_MAX} draws gave no valid machine; the last: {reason}")
    return machines, held


def covariance_root(covariance: Covariance, paths: tuple[str, ...]) -> tuple[list[str], FloatArray]:
    """The paths and a matrix R with R R^T the covariance; ValueError where paths or matrix are invalid."""
    names, matrix = list(covariance[0]), real_array("covariance", covariance[1])
    for name in names:
        if name not in paths:
            raise ValueError(f"covariance: {name!r} must be a parameter of the model")
    if len(set(names)) != len(names):
        raise ValueError("covariance: each path must be given once")
    if matrix.shape != (len(names), len(names)) or not np.isfinite(matrix).all():
        raise ValueError(f"covariance: must be finite, ({len(names)}, {len(names)}), got {matrix.shape}")
    # Variances of different units stand side by side: judged as correlations.
    scale = np.sqrt(np.where(np.diag(matrix) > 0, np.diag(matrix), 1.0))
    correlation = matrix / np.outer(scale, scale)
    if np.abs(correlation - correlation.T).max(initial=0.0) > 1e-6:
        raise ValueError("covariance: must be symmetric")
    values, vectors = np.linalg.eigh((correlation + correlation.T) / 2)
    if values.min(initial=0.0) < -1e-6 * len(names):
        raise ValueError(f"covariance: must have no negative eigenvalue, got {values.min():.3g} of the correlation")
    return names, np.asarray(scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)))


def _designed_observer(bounds: Bounds, velocity: float, bandwidth: float | None) -> ObserverBased:
    problem = bounds.observer_problem(VELOCITY_RATIO * velocity, velocity, bandwidth=bandwidth)
    return ObserverBased(bounds.observer_based(problem, design_observer(problem)))


#: How each controller is designed from bounds, for a motion of a largest velocity (m/s), with a bandwidth.
DESIGNED: dict[str, Callable[[Bounds, float, float | None], AnyController]] = {
    "pid": lambda bounds, _, w: Pid(bounds.pid(bandwidth=w)),
    "cascade": lambda bounds, _, w: Cascade(bounds.cascade(bandwidth=w)),
    "arc": lambda bounds, _, w: Arc(bounds.adaptive_robust(bandwidth=w)),
    "dcarc": lambda bounds, _, w: Dcarc(bounds.adaptive_robust(bandwidth=w)),
    "output_feedback_arc": lambda bounds, _, w: OutputFeedbackArc(bounds.output_feedback(bandwidth=w)),
    "observer_based": _designed_observer,
}
#: Name of the model's own controller in a prediction.
OWN = "own"
VELOCITY_RATIO = 0.25  # smallest over largest reference speed at which an observer cancels (cogging.papers.comparison)


def chosen_controllers(
    model: Model,
    motion: Reference,
    duration: float,
    controllers: Mapping[str, AnyController] | Sequence[str] | None,
    bandwidth: float | None,
    default: Mapping[str, Interval] | None,
) -> tuple[dict[str, AnyController], list[str]]:
    """The controllers to run on a motion, and why others are left out; ValueError: invalid names, or none is left."""
    if isinstance(controllers, Mapping):
        if not controllers:
            raise ValueError("controllers: must be at least one, got none")
        return dict(controllers), []
    if controllers is not None and not isinstance(controllers, Iterable):
        raise TypeError(f"controllers: must be names, or controllers by name, got {type(controllers).__name__}")
    known = (OWN, *DESIGNED)
    wanted = list(known if controllers is None else controllers)
    if isinstance(controllers, str) or not wanted or len(set(wanted)) != len(wanted):
        raise ValueError(f"controllers: must be a list of different names, got {controllers!r}")
    if wrong := [name for name in wanted if name not in known]:
        raise ValueError(f"controllers: each {not_one_of(wrong[0], known)}")
    velocity = float(np.abs(motion.sample(np.linspace(0.0, duration, 4001))[1]).max())
    chosen: dict[str, AnyController] = {}
    notes: list[str] = []
    bounds: Bounds | None = None
    for name in wanted:
        try:
            if name == OWN:
                chosen[name] = model.make_controller()
                continue
            if bounds is None:
                bounds = Bounds.of(model, default=default, velocity_max=velocity or 1.0)
                notes += bounds.notes
            chosen[name] = DESIGNED[name](bounds, velocity, bandwidth)
        except (ValueError, ImportError) as error:
            if controllers is not None:
                raise ValueError(f"{name}: {error}") from None
            if bounds is None and name != OWN:
                notes.append(f"controllers from the bounds left out: {error}")
                break
            notes.append(f"{name} left out: {error}")
    if not chosen:
        raise ValueError("; ".join(notes))
    return chosen, notes


#: Indexes of a prediction: over the window, and the largest of the whole run.
INDEXES = ("rms", "max", "max_whole")
COVERAGE = 0.95


@dataclass(frozen=True)
class PredictedIndex:
    """One index of the error over the drawn machines."""

    median: float  # m; infinite where more than half the runs diverged
    interval: Interval  # m, between which the index of one more machine lies (see ErrorPrediction.coverage)
    values: FloatArray = field(repr=False)  # m, (samples,), in the order drawn; infinite where the run diverged

    @classmethod
    def of(cls, values: FloatArray) -> PredictedIndex:
        """Order statistics share (n + 1): with this probability a further value lies below (numpy's are too narrow)."""
        shares = np.array([0.5, 0.5 * (1.0 - COVERAGE), 0.5 * (1.0 + COVERAGE)])
        places = np.round(shares * (len(values) + 1) - 1.0, 9)  # whole ones exact: the value beyond may be infinite
        median, low, high = np.interp(places, np.arange(len(values)), np.sort(values)).tolist()
        return cls(median, (low, high), values)


@dataclass(frozen=True)
class ControllerPrediction:
    """The predicted error of a controller."""

    name: str  # of the controller
    rms: PredictedIndex  # rms, max: of encoder reading minus reference, m, over the window
    max: PredictedIndex
    max_whole: PredictedIndex  # largest over the whole run, m
    diverged: float  # share of the machines on which the run diverged


@dataclass(frozen=True, eq=False, repr=False)
class ErrorPrediction(ByValue):
    """The predicted tracking error of each controller.

    Attributes:
        controllers: one entry a controller.
        window: of `rms` and `max`, s: the last period of a periodic motion of two or more, else the whole run.
        samples, seed: of the drawn machines.
        coverage: chance that the index of one more machine drawn likewise lies in its interval: 0.95, or
            (samples - 1) / (samples + 1) where fewer than 39 samples cannot tell so far out.
        notes: which parameters had no interval, which controllers were left out and why.
        machines: what was drawn, by path, and `seed` of the noise: arrays (samples,) in the order drawn, as the
            `values` of each index.
        units: labels of the model's units.
    """

    controllers: tuple[ControllerPrediction, ...]
    window: Interval
    samples: int
    seed: int
    coverage: float
    notes: tuple[str, ...] = ()
    machines: Mapping[str, npt.NDArray[Any]] = field(default_factory=dict)
    units: Units = field(default_factory=Units)

    def _brief(self) -> str:
        errors = [f"{one.name} {1e6 * one.rms.median:.3g} {self.units.of('um')} rms" for one in self.controllers]
        return f"{', '.join(errors)}; {self.samples} machines"

    def __getitem__(self, name: str) -> ControllerPrediction:
        """The prediction of a controller; KeyError: no such controller."""
        return entry_named(name, {controller.name: controller for controller in self.controllers}, "controller")

    def plot(self, index: str = "rms", *, units: Any = None, ax: Any = None) -> Figure:
        """Draw the error that each controller would reach (cogging.plot.prediction).

        Args:
            index: `rms`, `max` or `max_whole`.
            units: labels of command and position (cogging.Units).
            ax: axes; None: a new figure.

        Returns:
            The figure.
        """
        return plot.prediction(self, index, units=units, ax=ax).figure.figure

    def table(self) -> dict[str, Any]:
        """One row a controller and machine: its names and places, what was drawn, and the indexes (m).

        Returns:
            Arrays by name: `controller`, `machine`, the paths, `seed`, `rms`, `max`, `max_whole`.
        """
        count = len(self.controllers)
        drawn = {path: np.tile(values, count) for path, values in self.machines.items()}
        found = {name: np.concatenate([getattr(one, name).values for one in self.controllers]) for name in INDEXES}
        names = np.repeat(np.array([one.name for one in self.controllers], dtype=object), self.samples)
        return {"controller": names, "machine": np.tile(np.arange(self.samples), count), **drawn, **found}

    def to_frame(self) -> Any:
        """The table as a pandas DataFrame (extra `frames`), with the units of the indexes in `attrs["units"]`."""
        return frame_of(self.table(), dict.fromkeys(INDEXES, self.units.of("m")))

    to_pandas = to_frame

    def text(self) -> str:
        """The table for the screen, um."""
        width = max(10, *(len(controller.name) for controller in self.controllers))
        titles, unit = ("rms", "max", "max of the whole run"), self.units.of("um")
        lines = [
            f"Predicted tracking error, {unit}: median and {100 * self.coverage:.0f} % interval over {self.samples} "
            f"machines; rms and max from {self.window[0]:g} to {self.window[1]:g} s",
            f"    {'controller':<{width}}" + "".join(f"{title:>30}" for title in titles) + f"{'diverged':>10}",
        ]
        for one in self.controllers:
            numbers = [1e6 * np.array([index.median, *index.interval]) for index in (one.rms, one.max, one.max_whole)]
            cells = "".join(f"{'{:.3g} [{:.3g}, {:.3g}]'.format(*three):>30}" for three in numbers)
            lines.append(f"    {one.name:<{width}}{cells}{one.diverged:>10.0%}")
        return "\n".join([*lines, *(f"  note: {note}" for note in self.notes)])

    def to_dict(self) -> dict[str, Any]:
        """What `cogging predict --json` writes; null stands for infinite, of runs that diverged."""
        unit, controllers = self.units.of("m"), []
        for one in self.controllers:
            indexes = {name: getattr(one, name) for name in INDEXES}
            entries = {n: {"unit": unit, "median": i.median, "interval": i.interval} for n, i in indexes.items()}
            controllers.append({"controller": one.name, "diverged": one.diverged, **entries})
        names = ("window", "samples", "seed", "coverage", "notes")
        document: dict[str, Any] = finite({"controllers": controllers, **{n: getattr(self, n) for n in names}})
        return document


ROWS_MOST = 8e6  # of two columns that are held at a time: 128 MB


@check_arguments(model=MODEL, reference=REFERENCE)
@on_one_blas_thread(scipy=True)
def predict_error(
    model: Model | str | os.PathLike[str],
    reference: Reference | Mapping[str, Any] | str | os.PathLike[str],
    controllers: Mapping[str, AnyController] | Sequence[str] | None = None,
    *,
    samples: int = 40,
    seed: int = 0,
    duration: float = 0.0,
    threads: int = 0,
    bandwidth: float | None = None,
    default: Mapping[str, Interval] | None = None,
    covariance: tuple[Sequence[str], npt.ArrayLike] | None = None,
) -> ErrorPrediction:
    """Predict rms and largest tracking error of controllers on a reference, for the machine that a model describes.

    Machines are drawn from the model's 95 % intervals: each parameter normal around the model's value (each side with
    its own width), or jointly normal where a covariance is given. All controllers run on the same machines. The same
    arguments give the same numbers, whatever the threads. Effects that the model lacks are not predicted.

    Args:
        model: a Model, or the path of a model file.
        reference: a motion, the fields of a reference file, or the path of one.
        controllers: by name, of the core or user-defined (see Controller); or names among `own` (the model's) and pid,
            cascade, arc, dcarc, output_feedback_arc, observer_based, designed from the bounds; None: all that can be
            designed.
        samples: machines to draw, at least 2; 39 or more for intervals of 95 %.
        seed: of machines and noise.
        duration: s; 0 = that of the reference file, or the motion's own end.
        threads: 0 = all cores.
        bandwidth: of the designed controllers, 1/s (see Bounds).
        default: 95 % intervals for parameters without a finite one (see Bounds.of); without a default, a parameter
            with an infinite interval keeps its value, and a note says that the interval of the error is unbounded.
        covariance: paths (p) and covariance (p, p) of parameters that are drawn jointly.

    Returns:
        Median and interval of rms and largest error by controller.

    Raises:
        ValueError: an argument breaks its rule, a named controller cannot be designed, none is left, the reference
            leaves the travel or has no end.
        InputError: a file cannot be used.

    Example:
        >>> prediction = cogging.predict_error(model, move, ["own"], samples=4)
        >>> print(f"{1e6 * prediction['own'].rms.median:.0f} um rms over {prediction.samples} machines")
        12 um rms over 4 machines
    """
    require_numbers({"samples": samples}, seed, duration, threads=threads)
    if samples < 2:
        raise ValueError("samples: must be at least 2 for an interval, got 1")
    if not isinstance(model, Model):
        model = Model.read(model)
    motion, own = motion_of(reference)
    duration = float(duration) or own or motion.end
    if not np.isfinite(duration):
        raise ValueError("duration: must be given for a motion without an end, got none")
    period, last = motion.period, min(duration, motion.end)
    window = (last - period if np.isfinite(period) and last >= 1.999 * period else 0.0, duration)
    intervals = Intervals(model, default, beside=("disturbance",))
    machines, held = drawn_machines(intervals, samples, int(seed), covariance)
    chosen, left_out = chosen_controllers(model, motion, duration, controllers, bandwidth, default)
    found = _errors(machines, list(chosen.values()), motion, window, int(threads) or os.cpu_count() or 1)
    predictions = []
    for name, values in zip(chosen, found, strict=True):
        indexes = {index: PredictedIndex.of(column) for index, column in zip(INDEXES, values.T, strict=True)}
        predictions.append(ControllerPrediction(name, diverged=float(np.isinf(values[:, 0]).mean()), **indexes))
    drawn = {path: np.array([one.values[path] for one in machines]) for path in machines[0].values}
    return ErrorPrediction(
        controllers=tuple(predictions),
        window=window,
        samples=int(samples),
        seed=int(seed),
        coverage=min(COVERAGE, (samples - 1) / (samples + 1)),
        notes=(*held, *intervals.notes, *left_out),
        machines={**drawn, "seed": np.array([one.seed for one in machines])},
        units=model.units,
    )


def _errors(
    machines: list[DrawnMachine], controllers: list[AnyController], motion: Reference, window: Interval, threads: int
) -> FloatArray:
    """The indexes of each controller on each machine, (controllers, machines, 3), m; infinite where a run diverged."""
    plants = [machine.model.plant() for machine in machines]
    # The error outside the window is computed from columns, with as many runs at a time as memory allows.
    whole = window[0] <= 0.0
    jobs = [(controller, place) for controller in controllers for place in range(len(plants))]
    rates = [getattr(controller, "sample_rate", 0.0) for controller in controllers]  # an invalid one the run refuses
    rows = window[1] * max(float(rate) if is_number(rate) else 0.0 for rate in rates) + 1.0
    size = len(jobs) if whole else max(threads, int(ROWS_MOST / rows))
    found = np.full((len(jobs), len(INDEXES)), np.inf)
    for first in range(0, len(jobs), size):
        part = jobs[first : first + size]
        try:
            kept = kept_of_runs(
                [plants[place] for _, place in part],
                [controller for controller, _ in part],
                [motion],
                durations=[window[1]],
                seeds=[machines[place].seed for _, place in part],
                steps_per_sample=[1],
                threads=threads,
                window=(window[0], np.inf, 2.0),
                columns=() if whole else ("position", "reference"),
            )
        except ValueError as error:  # refused on every machine alike
            raise ValueError(re.sub(r"^run \d+: ", "", str(error))) from None
        largest, rms = (kept.values[:, OF_A_RUN.index(name)] for name in ("error_max", "error_rms"))
        if not whole:
            columns = zip(kept.columns["position"], kept.columns["reference"], strict=True)
            all_rows = [np.abs(position - wanted).max(initial=0.0) for position, wanted in columns]
        values = np.stack([rms, largest, largest if whole else all_rows], axis=1)
        values[[failure.run for failure in kept.failures]] = np.inf
        found[first : first + size] = values
    return found.reshape(len(controllers), len(plants), len(INDEXES))
