"""The tracking error that each controller would reach on a reference, with an interval, before the machine moves."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging._core import (
    Arc,
    Cascade,
    Dcarc,
    DivergedError,
    FilteredSine,
    ObserverBased,
    OutputFeedbackArc,
    Pid,
    PointToPoint,
    Reference,
    Sine,
    closed_loop,
    performance,
)
from cogging.arrays import FloatArray
from cogging.calls import takes
from cogging.design.bounds import Bounds
from cogging.design.drawn_machines import drawn_machines
from cogging.design.observer import design_observer
from cogging.model.intervals import Interval, Intervals
from cogging.model.model import Controller, Model
from cogging.simulation.arguments import MODEL, REFERENCE
from cogging.simulation.reference import read_reference, reference_from
from cogging.threads import on_threads
from cogging.values import ByValue

#: The controllers that are designed from the bounds of a model.
DESIGNED = ("pid", "cascade", "arc", "dcarc", "output_feedback_arc", "observer_based")
#: Name of the model's own controller in a prediction.
OWN = "own"
#: Indexes of a prediction: over the window, and the largest of the whole run.
INDEXES = ("rms", "max", "max_whole")
COVERAGE = 0.95
VELOCITY_RATIO = 0.25  # smallest over largest reference speed at which an observer cancels (cogging.papers.comparison)


@dataclass(frozen=True)
class PredictedIndex:
    """One index of the error over the drawn machines.

    Attributes:
        median: m; infinite where more than half the runs diverged.
        interval: m, between which the index of one more machine lies (see ErrorPrediction.coverage).
        values: m, (samples,), one a machine, in the order drawn; infinite where the run diverged.
    """

    median: float
    interval: Interval
    values: FloatArray = field(repr=False)


@dataclass(frozen=True)
class ControllerPrediction:
    """What a controller would reach.

    Attributes:
        name: of the controller.
        rms, max: of encoder reading minus reference, m, over the window.
        max_whole: largest over the whole run, m.
        diverged: share of the machines on which the run diverged.
    """

    name: str
    rms: PredictedIndex
    max: PredictedIndex
    max_whole: PredictedIndex
    diverged: float


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

    Example:
        >>> prediction = cogging.predict_error(model, move, ["own"], samples=4)
        >>> prediction["own"].diverged
        0.0
    """

    controllers: tuple[ControllerPrediction, ...]
    window: Interval
    samples: int
    seed: int
    coverage: float
    notes: tuple[str, ...] = ()

    def _brief(self) -> str:
        told = [f"{one.name} {1e6 * one.rms.median:.3g} um rms" for one in self.controllers]
        return f"{', '.join(told)}; {self.samples} machines"

    def __getitem__(self, name: str) -> ControllerPrediction:
        """The prediction of a controller.

        Raises:
            KeyError: no such controller.
        """
        for controller in self.controllers:
            if controller.name == name:
                return controller
        raise KeyError(name)

    def text(self) -> str:
        """The table for the screen, um."""
        width = max(10, *(len(controller.name) for controller in self.controllers))
        titles = ("rms", "max", "max of the whole run")
        lines = [
            f"Predicted tracking error, um: median and {100 * self.coverage:.0f} % interval over {self.samples} "
            f"machines; rms and max from {self.window[0]:g} to {self.window[1]:g} s",
            f"    {'controller':<{width}}" + "".join(f"{title:>30}" for title in titles) + f"{'diverged':>10}",
        ]
        for controller in self.controllers:
            cells = [_cell(getattr(controller, index)) for index in INDEXES]
            lines.append(f"    {controller.name:<{width}}" + "".join(cells) + f"{controller.diverged:>10.0%}")
        return "\n".join([*lines, *(f"  note: {note}" for note in self.notes)])

    def to_dict(self) -> dict[str, Any]:
        """What `cogging predict --json` writes; null stands for infinite, of runs that diverged."""
        controllers = []
        for controller in self.controllers:
            entry: dict[str, Any] = {"controller": controller.name, "diverged": controller.diverged}
            for name in INDEXES:
                index: PredictedIndex = getattr(controller, name)
                numbers = [_finite(value) for value in (index.median, *index.interval)]
                entry[name] = {"unit": "m", "median": numbers[0], "interval": numbers[1:]}
            controllers.append(entry)
        return {
            "controllers": controllers,
            "window": list(self.window),
            "samples": self.samples,
            "seed": self.seed,
            "coverage": self.coverage,
            "notes": list(self.notes),
        }


@takes(model=MODEL, reference=REFERENCE)
def predict_error(
    model: Model | str | os.PathLike[str],
    reference: Reference | Mapping[str, Any] | str | os.PathLike[str],
    controllers: Mapping[str, Controller] | Sequence[str] | None = None,
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
    its own width where the interval is not symmetric), redrawn while a value is not valid, or jointly normal where a
    covariance is given. Each has the model's effects, encoder and noise, the noise with a seed of its own. All
    controllers run on the same machines. A pure function: the same arguments give the same numbers, whatever the
    threads; more samples keep those of fewer.

    What the model lacks is not predicted: an effect that the machine has and the model has not.

    Args:
        model: a Model, or the path of a model file.
        reference: a motion, the fields of a reference file, or the path of one.
        controllers: by name; or which of `own` (the model's) and pid, cascade, arc, dcarc, output_feedback_arc,
            observer_based, designed from the bounds; None: all of these that can be.
        samples: machines to draw, at least 2; 39 or more for intervals of 95 %.
        seed: of machines and noise.
        duration: s; 0 = that of the reference file, or the motion's own end.
        threads: 0 = all cores.
        bandwidth: of the designed controllers, 1/s (see Bounds).
        default: 95 % intervals for parameters without a finite one (see Bounds.of).
        covariance: paths (p) and covariance (p, p) of parameters that are drawn jointly.

    Returns:
        Median and interval of rms and largest error by controller; print it to read them.

    Raises:
        ValueError: an argument breaks its rule, an interval is infinite without a default, a named controller cannot
            be designed, none is left, the reference leaves the travel or has no end.
        InputError: a file cannot be used.

    Example:
        >>> prediction = cogging.predict_error(model, move, ["own"], samples=4)
        >>> print(f"{1e6 * prediction['own'].rms.median:.0f} um rms over {prediction.samples} machines")
        12 um rms over 4 machines
    """
    for name, value, least in (("samples", samples, 2), ("seed", seed, 0), ("threads", threads, 0)):
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
            raise ValueError(f"{name}: must be a whole number of at least {least}, got {value!r}")
    if not isinstance(model, Model):
        model = Model.read(model)
    motion, duration = _motion(reference, duration)
    window = _window(motion, duration)
    intervals = Intervals(model, default, beside=("disturbance",))
    machines = drawn_machines(intervals, samples, int(seed), covariance)
    chosen, left_out = _controllers(model, motion, duration, controllers, bandwidth, default)
    plants = [machine.plant() for machine, _ in machines]

    def run(job: tuple[Controller, int]) -> tuple[float, float, float]:
        controller, place = job
        try:
            log = closed_loop(plants[place], controller, motion, duration=duration, seed=machines[place][1])
        except DivergedError:
            return (np.inf,) * 3
        error = log["position"] - log["reference"]
        last = performance(log["time"], error, log["command"], start=window[0])
        return last.error_rms, last.error_max, float(np.abs(error).max())

    jobs = [(controller, place) for controller in chosen.values() for place in range(samples)]
    found = np.array(on_threads(run, jobs, int(threads) or os.cpu_count()))
    found = found.reshape(len(chosen), samples, len(INDEXES))
    predictions = []
    for name, values in zip(chosen, found, strict=True):
        indexes = {index: _index(values[:, i]) for i, index in enumerate(INDEXES)}
        predictions.append(ControllerPrediction(name, diverged=float(np.isinf(values[:, 0]).mean()), **indexes))
    coverage = min(COVERAGE, (samples - 1) / (samples + 1))
    return ErrorPrediction(tuple(predictions), window, int(samples), int(seed), coverage, (*intervals.notes, *left_out))


def _motion(reference: Any, duration: float) -> tuple[Reference, float]:
    if isinstance(reference, Mapping):
        motion, own = reference_from(reference)
    elif isinstance(reference, Reference):
        motion, own = reference, 0.0
    else:
        motion, own = read_reference(reference)
    if not (np.isfinite(duration) and duration >= 0.0):
        raise ValueError(f"duration: must be finite and at least 0, got {duration!r}")
    end = float(duration) or own or motion.end
    if not np.isfinite(end):
        raise ValueError("duration: must be given for a motion without an end, got none")
    return motion, end


def _window(motion: Reference, end: float) -> Interval:
    """The last period of a motion of two or more, else the whole run, s."""
    if isinstance(motion, PointToPoint):
        period, last = motion.period, min(end, motion.end)
    elif isinstance(motion, Sine | FilteredSine):
        period, last = 1.0 / motion.parameters.frequency, end
    else:
        return 0.0, end
    return (last - period if last >= 1.999 * period else 0.0), end


def _controllers(
    model: Model,
    motion: Reference,
    duration: float,
    controllers: Mapping[str, Controller] | Sequence[str] | None,
    bandwidth: float | None,
    default: Mapping[str, Interval] | None,
) -> tuple[dict[str, Controller], list[str]]:
    """The controllers to run, and which were left out and why."""
    if isinstance(controllers, Mapping):
        if not controllers:
            raise ValueError("controllers: must be at least one, got none")
        return dict(controllers), []
    named = controllers is not None
    wanted = list(controllers) if controllers is not None else [OWN, *DESIGNED]
    if isinstance(controllers, str) or not wanted or len(set(wanted)) != len(wanted):
        raise ValueError(f"controllers: must be a list of different names, got {controllers!r}")
    for name in wanted:
        if name not in (OWN, *DESIGNED):
            raise ValueError(f"controllers: each must be one of {', '.join((OWN, *DESIGNED))}, got {name!r}")
    velocity = float(np.abs(motion.sample(np.linspace(0.0, duration, 4001))[1]).max())
    chosen: dict[str, Controller] = {}
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
            chosen[name] = _designed(name, bounds, velocity, bandwidth)
        except (ValueError, ImportError) as error:
            if named:
                raise ValueError(f"{name}: {error}") from None
            notes.append(f"{name} left out: {error}")
            if bounds is None and name != OWN:
                notes[-1] = f"controllers from the bounds left out: {error}"
                break
    if not chosen:
        raise ValueError("; ".join(notes))
    return chosen, notes


def _designed(name: str, bounds: Bounds, velocity: float, bandwidth: float | None) -> Controller:
    if name == "pid":
        return Pid(bounds.pid(bandwidth=bandwidth))
    if name == "cascade":
        return Cascade(bounds.cascade(bandwidth=bandwidth))
    if name == "arc":
        return Arc(bounds.adaptive_robust(bandwidth=bandwidth))
    if name == "dcarc":
        return Dcarc(bounds.adaptive_robust(bandwidth=bandwidth))
    if name == "output_feedback_arc":
        return OutputFeedbackArc(bounds.output_feedback(bandwidth=bandwidth))
    problem = bounds.observer_problem(VELOCITY_RATIO * velocity, velocity, bandwidth=bandwidth)
    return ObserverBased(bounds.observer_based(problem, design_observer(problem)))


def _index(values: FloatArray) -> PredictedIndex:
    tail = 0.5 * (1.0 - COVERAGE)
    return PredictedIndex(_quantile(values, 0.5), (_quantile(values, tail), _quantile(values, 1.0 - tail)), values)


def _quantile(values: FloatArray, share: float) -> float:
    """The value below which one more of the same kind lies with this chance, i.e. order statistic share (n + 1).

    That of the sample itself (numpy's default) is too narrow: 40 values would hold 90 % where 95 % are asked.
    """
    ordered = np.sort(values)
    place = min(max(share * (len(ordered) + 1) - 1.0, 0.0), len(ordered) - 1.0)
    below = int(place)
    weight = place - below
    if weight < 1e-9:
        return float(ordered[below])
    return float((1.0 - weight) * ordered[below] + weight * ordered[below + 1])


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _cell(index: PredictedIndex) -> str:
    low, high = (f"{1e6 * end:.3g}" for end in index.interval)
    return f"{f'{1e6 * index.median:.3g} [{low}, {high}]':>30}"
