"""The tracking error that each controller would reach on a reference, with an interval, before the machine moves."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging._core import Reference
from cogging.arrays import FloatArray
from cogging.calls import takes
from cogging.design.controller_choice import chosen_controllers
from cogging.design.drawn_machines import DrawnMachine, drawn_samples
from cogging.design.predicted_error import INDEXES, ControllerPrediction, ErrorPrediction, PredictedIndex
from cogging.model.controller import AnyController
from cogging.model.intervals import Interval, Intervals
from cogging.model.model import Model, is_number
from cogging.resources import on_one_blas_thread
from cogging.simulation.arguments import MODEL, REFERENCE
from cogging.simulation.reductions import INDEXES as OF_A_RUN
from cogging.simulation.reductions import kept_of_runs
from cogging.simulation.reference import read_reference, reference_from

COVERAGE = 0.95
ROWS_MOST = 8e6  # of two columns that are held at a time: 128 MB


@takes(model=MODEL, reference=REFERENCE)
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
    its own width where the interval is not symmetric), redrawn while a value is not valid, or jointly normal where a
    covariance is given. Each has the model's effects, encoder and noise, the noise with a seed of its own. All
    controllers run on the same machines. A pure function: the same arguments give the same numbers, whatever the
    threads; more samples keep those of fewer.

    What the model lacks is not predicted: an effect that the machine has and the model has not.

    Args:
        model: a Model, or the path of a model file.
        reference: a motion, the fields of a reference file, or the path of one.
        controllers: by name, those of the core or of one's own (see Controller); or which of `own` (the model's) and
            pid, cascade, arc, dcarc, output_feedback_arc, observer_based, designed from the bounds; None: all of these
            that can be.
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
    machines = drawn_samples(intervals, samples, int(seed), covariance)
    chosen, left_out = chosen_controllers(model, motion, duration, controllers, bandwidth, default)
    found = _errors(machines, list(chosen.values()), motion, window, int(threads) or os.cpu_count() or 1)
    predictions = []
    for name, values in zip(chosen, found, strict=True):
        indexes = {index: _index(values[:, i]) for i, index in enumerate(INDEXES)}
        predictions.append(ControllerPrediction(name, diverged=float(np.isinf(values[:, 0]).mean()), **indexes))
    coverage = min(COVERAGE, (samples - 1) / (samples + 1))
    notes = (*intervals.notes, *left_out)
    told = (tuple(predictions), window, int(samples), int(seed), coverage, notes)
    return ErrorPrediction(*told, machines=_drawn(machines), units=model.units)


def _errors(
    machines: Sequence[DrawnMachine],
    controllers: Sequence[AnyController],
    motion: Reference,
    window: Interval,
    threads: int,
) -> FloatArray:
    """The indexes of each controller on each machine, (controllers, machines, 3), m; infinite where a run diverged."""
    plants = [machine.model.plant() for machine in machines]
    # What the whole run has beyond the window is read off columns, so few runs at a time as their rows allow.
    whole = window[0] <= 0.0
    jobs = [(controller, place) for controller in controllers for place in range(len(plants))]
    rows = window[1] * max(map(_rate, controllers)) + 1.0
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
        except ValueError as error:  # what is refused is so on every machine
            raise ValueError(re.sub(r"^run \d+: ", "", str(error))) from None
        largest, rms = (kept.values[:, OF_A_RUN.index(name)] for name in ("error_max", "error_rms"))
        if not whole:
            columns = zip(kept.columns["position"], kept.columns["reference"], strict=True)
            all_rows = [np.abs(position - wanted).max(initial=0.0) for position, wanted in columns]
        values = np.stack([rms, largest, largest if whole else all_rows], axis=1)
        values[[failure.run for failure in kept.failures]] = np.inf
        found[first : first + size] = values
    return found.reshape(len(controllers), len(plants), len(INDEXES))


def _rate(controller: AnyController) -> float:
    """Its sample rate, Hz; what is no controller, the run itself refuses."""
    rate = getattr(controller, "sample_rate", 0.0)
    return float(rate) if is_number(rate) else 0.0


def _drawn(machines: Sequence[DrawnMachine]) -> dict[str, Any]:
    """What was drawn of the machines, by path, and the seeds of their noise."""
    drawn: dict[str, Any] = {path: np.array([one.values[path] for one in machines]) for path in machines[0].values}
    return {**drawn, "seed": np.array([one.seed for one in machines])}


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
    period, last = motion.period, min(end, motion.end)
    if not np.isfinite(period):
        return 0.0, end
    return (last - period if last >= 1.999 * period else 0.0), end


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
