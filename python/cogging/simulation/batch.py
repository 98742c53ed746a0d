"""Many runs in one call, reduced to indexes."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from cogging import _core, plot
from cogging._core import DivergedError, Plant, Reference
from cogging.arrays import FloatArray
from cogging.calls import check_arguments, described
from cogging.logs.log import Log
from cogging.model.controller import AnyController
from cogging.model.units import UNITS, Units
from cogging.progress import Progress, steps
from cogging.simulation.arguments import LIST, MOTION, NUMBER, PLANTS
from cogging.simulation.reductions import COLUMNS, Failed, Kept, kept_of_runs, names_of, unit_of
from cogging.simulation.runs_table import RunsTable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

REPORTS = 50  # progress reports of a batch
EACH = ("plants", "controllers", "seeds", "in_lanes")  # fields of a Batch with one entry a run


@dataclass(frozen=True, eq=False, repr=False)
class Batch(RunsTable, Sequence[Log]):
    """The runs of closed_loop_batch, in the order of their plants: indexes, and recorded columns or logs.

    With logs it is a sequence of them; the log of a failed run raises its DivergedError.

    Attributes:
        indexes: by name (those of Performance, then the reductions), arrays (runs,); NaN where a run failed.
        failures: runs that failed: number, time (s) and reason.
        columns: recorded columns by name, one array a run; empty for a failed run.
        plants: the machine of each run.
        controllers: the controller of each run, as given.
        seeds: of each run's noise.
        in_lanes: whether each run was computed in vector lanes with others.
        with_logs: whether the logs were recorded.
        units: labels of the plants' units.

    Example:
        >>> plant = cogging.Plant(cogging.AxisParameters(mass=0.12, viscous=0.2))
        >>> pid = cogging.Pid(cogging.PidParameters(kp=9600.0, kd=48.0))
        >>> move = cogging.Sine(cogging.SineParameters(amplitude=0.01, frequency=2.0))
        >>> batch = cogging.closed_loop_batch([plant, plant], [pid, pid], move, duration=0.1, seeds=[1, 2])
        >>> len(batch), batch.seeds, batch.indexes["error_max"].shape, batch.failures
        (2, (1, 2), (2,), ())
    """

    indexes: Mapping[str, FloatArray]
    failures: tuple[Failed, ...]
    columns: Mapping[str, tuple[FloatArray, ...]]
    plants: tuple[Plant, ...]
    controllers: tuple[AnyController, ...]
    seeds: tuple[int, ...]
    in_lanes: tuple[bool, ...]
    with_logs: bool = False
    units: Units = field(default_factory=Units)

    def _brief(self) -> str:
        failed = f", {len(self.failures)} failed" if self.failures else ""
        worst = float(np.nanmax(self.indexes["error_max"])) if len(self.failures) < len(self) else np.nan
        return f"{len(self)} runs{failed}, max |error| {worst:.3g} {self.units.position}"

    @property
    def logs(self) -> tuple[Log, ...]:
        """The log of each run.

        Raises:
            ValueError: the logs were not recorded.
            DivergedError: that of the first failed run.
        """
        return tuple(self)

    def plot(self, *, units: Any = None, ax: Any = None) -> Figure:
        """Plot the tracking errors of the completed runs over time, and return the figure (cogging.plot.error).

        Raises:
            ValueError: the logs were not recorded, or no run completed.
        """
        failed = {failure.run for failure in self.failures}
        logs = {f"run {run}": self[run] for run in range(len(self)) if run not in failed}
        return plot.error(logs, units=units or self.units, ax=ax).figure.figure

    def table(self) -> dict[str, Any]:
        """Return columns by name, one row a run: its number, the indexes, and time (s) and reason of a failure."""
        reasons = np.full(len(self), "", dtype=object)
        times = np.full(len(self), np.nan)
        for failure in self.failures:
            reasons[failure.run], times[failure.run] = failure.reason, failure.time
        return {"run": np.arange(len(self)), **self.indexes, "failed_at": times, "reason": reasons}

    def _rows(self) -> tuple[Mapping[str, Any], Mapping[str, str]]:
        return self.table(), {name: self.units.of(unit_of(name)) for name in (*self.indexes, *self.columns)}

    def _recorded(self) -> Mapping[str, Sequence[FloatArray]]:
        return self.columns

    def __len__(self) -> int:
        return len(self.plants)

    def __iter__(self) -> Iterator[Log]:
        return (self[run] for run in range(len(self)))

    @overload
    def __getitem__(self, which: int) -> Log: ...
    @overload
    def __getitem__(self, which: slice) -> Batch: ...
    def __getitem__(self, which: int | slice) -> Log | Batch:
        """Return the log of a run, or a batch of some runs."""
        if isinstance(which, slice):
            runs = range(len(self))[which]
            places = {run: place for place, run in enumerate(runs)}
            new: dict[str, Any] = {name: tuple(getattr(self, name)[run] for run in runs) for name in EACH}
            new["indexes"] = {name: values[list(runs)] for name, values in self.indexes.items()}
            new["columns"] = {name: tuple(each[run] for run in runs) for name, each in self.columns.items()}
            failed = [failure for failure in self.failures if failure.run in places]
            new["failures"] = tuple(failure._replace(run=places[failure.run]) for failure in failed)
            return replace(self, **new)
        if not self.with_logs:
            raise ValueError("logs: must be recorded to be read: closed_loop_batch(..., logs=True)")
        run = range(len(self))[which]
        for failure in self.failures:
            if failure.run == run:
                raise DivergedError(f"run {run}: {failure.reason}")
        return Log.of({name: each[run] for name, each in self.columns.items()})


@check_arguments(plants=PLANTS, controllers=LIST, reference=MOTION, duration=NUMBER, units=UNITS)
def closed_loop_batch(
    plants: Sequence[Plant],
    controllers: Sequence[AnyController],
    reference: Reference,
    *,
    duration: float = 0.0,
    seeds: Sequence[int] = (),
    steps_per_sample: int = 1,
    threads: int = 0,
    start: float = -np.inf,
    stop: float = np.inf,
    final_window: float = 2.0,
    reductions: Sequence[str] = (),
    columns: Sequence[str] = (),
    every: int = 1,
    logs: bool = False,
    units: Units | None = None,
    progress: Progress = False,
) -> Batch:
    """Simulate many plants under their controllers along one reference, and keep indexes of each run.

    Each run gives the indexes of `performance`, equal to those of its closed_loop and computed while it runs: memory
    grows with what is recorded, not with rows. A run that diverges is reported with its reason and time; the others
    complete.

    Further reductions, by name, of `error` (reading minus reference, m), `command` (V) and `true_error` (m):
    `error_max` and `error_rms` of its magnitude, `error_final` (the last value), `error_quantile(0.95)` of its
    magnitude, `error_tone(3.0)`, the amplitude at a frequency (Hz), and `command_wave(0.05)`, the amplitude at a period
    along the travel (m), both by least squares with an offset. Quantiles are exact up to 65,536 rows and within 0.07 %
    beyond, from a histogram.

    Similar runs share the lanes of the processor's vector unit (`in_lanes` of the result): fresh controllers of one
    type and rate with equal lists, bounds and limits, and machines with the same travel, knots of the cogging and kinds
    of effects, with smooth friction. Other runs are computed one by one. The environment variable COGGING_INSTRUCTIONS
    selects the instructions: v2, v3, v4 (x86-64 with SSE4.2, AVX2, AVX-512), neon, or none. No result depends on it.

    Args:
        plants: one for each run.
        controllers: one for each plant; they are copied. Those in Python run one at a time, while runs with controllers
            of the core and compiled ones run in parallel.
        reference: the motion of all runs.
        duration: s; 0 = the end of the reference.
        seeds: of force and encoder noise, one for each plant; empty: 0 for all.
        steps_per_sample: least number of integration steps between two samples.
        threads: number of threads; 0 = all cores. The result does not depend on it.
        start, stop: s; indexes and reductions use the rows with start <= time < stop.
        final_window: s, of error_final_max.
        reductions: further reductions by name.
        columns: columns of the log to record, by name, `every` so many rows from the first on.
        logs: record all columns and rows, so that the batch is a sequence of logs.
        units: unit labels of command and position in the result; V and m by default.
        progress: see cogging.progress.

    Returns:
        The runs in the order of the plants.

    Raises:
        ValueError: lists of different lengths, a reference that leaves the travel, an endless motion without a
            duration, an unknown reduction or column; COGGING_INSTRUCTIONS names what this machine lacks.
        TypeError: a controller is not a Controller, or cannot be copied; says what it lacks.
        ControllerError: a user's controller raised, or returned no finite number; says when and in which row.

    Example:
        >>> plants = [cogging.Plant(cogging.AxisParameters(mass=mass)) for mass in (0.1, 0.2)]
        >>> pids = [cogging.Pid(cogging.PidParameters(kp=9600.0, kd=48.0))] * 2
        >>> move = cogging.Sine(cogging.SineParameters(amplitude=0.01, frequency=2.0))
        >>> batch = cogging.closed_loop_batch(plants, pids, move, duration=0.5)
        >>> [f"{1e6 * largest:.0f} um" for largest in batch.indexes["error_max"]]
        ['181 um', '306 um']
    """
    for plant in plants:
        if not isinstance(plant, Plant):
            raise TypeError(f"closed_loop_batch: plants: must be a list, each a Plant, got {described(plant)}")
    columns, every = (COLUMNS, 1) if logs else (columns, every)
    options: dict[str, Any] = {"durations": [duration], "steps_per_sample": [steps_per_sample], "threads": threads}
    options |= {"window": (start, stop, final_window), "reductions": reductions, "columns": columns, "every": every}
    count = size = len(plants)
    parts: list[Kept] = []
    failures: list[Failed] = []
    if progress is not False and len(controllers) == count and len(seeds) in (0, count):  # the core refuses others
        lanes = _core.instruction_sets().get(_core.instruction_set(), 1)
        at_once = lanes * (threads or os.cpu_count() or 1)
        size = at_once * -(-max(1, count // REPORTS) // at_once)
        options["runs_in_all"] = count
    with steps(progress, "closed_loop_batch", -(-count // size) if size else 1) as step:
        for first in range(0, max(count, 1), size or 1):
            own = slice(first, first + size) if size < count else slice(None)
            kept = kept_of_runs(plants[own], controllers[own], [reference], seeds=seeds[own], **options)
            parts.append(kept)
            failures += [failure._replace(run=failure.run + first) for failure in kept.failures]
            step(f"{min(first + size, count)} of {count} runs")
    return Batch(
        dict(zip(names_of(reductions), np.concatenate([part.values for part in parts]).T, strict=True)),
        tuple(failures),
        {name: tuple(run for part in parts for run in part.columns[name]) for name in columns},
        tuple(plants),
        tuple(controllers),
        tuple(seeds) or (0,) * len(plants),
        tuple(flag for part in parts for flag in part.in_lanes),
        logs,
        units or Units(),
    )
