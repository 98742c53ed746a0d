"""Many runs in one call, and what is kept of them."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
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
from cogging.simulation.frames import to_frame, to_pandas, to_xarray, write_frame
from cogging.simulation.reductions import COLUMNS, Failed, Kept, kept_of_runs, names_of, unit_of
from cogging.values import ByValue

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TOLD = 50  # times that progress is told of


@dataclass(frozen=True, eq=False, repr=False)
class Batch(ByValue, Sequence[Log]):
    """The runs of closed_loop_batch, in the order of their plants: numbers of each, and what else was asked for.

    Where the logs were asked for it is a sequence of them; the log of a run that failed raises its DivergedError.

    Attributes:
        indexes: by name (those of Performance, then the reductions), arrays (runs,); NaN where a run failed.
        failures: the runs that did not come to their end: which, when (s) and why.
        columns: those asked for by name, one array a run; empty where the run failed.
        plants: the machine of each run.
        controllers: the controller of each run, as it was given.
        seeds: of each run's noise.
        in_lanes: of each run, whether it went through the processor side by side with others of its course.
        with_logs: whether the logs were asked for.
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
            ValueError: they were not asked for.
            DivergedError: of the first run that failed.
        """
        return tuple(self)

    def plot(self, *, units: Any = None, ax: Any = None) -> Figure:
        """Draw the tracking errors of the runs that came to their end over time (cogging.plot.error).

        Args:
            units: labels of command and position (cogging.Units).
            ax: axes; None: a new figure.

        Returns:
            The figure.

        Raises:
            ValueError: the logs were not asked for, or no run came to its end.
        """
        failed = {failure.run for failure in self.failures}
        logs = {f"run {run}": self[run] for run in range(len(self)) if run not in failed}
        return plot.error(logs, units=units or self.units, ax=ax).figure.figure

    def table(self) -> dict[str, Any]:
        """One row a run: its place, the indexes, and when (s) and why it failed where it did.

        Returns:
            Arrays by name.
        """
        reasons = np.full(len(self), "", dtype=object)
        times = np.full(len(self), np.nan)
        for failure in self.failures:
            reasons[failure.run], times[failure.run] = failure.reason, failure.time
        return {"run": np.arange(len(self)), **self.indexes, "failed_at": times, "reason": reasons}

    def to_pandas(self) -> Any:
        """The table as a pandas DataFrame with `run` as its index.

        Raises:
            ImportError: pandas is not there; names the extra that brings it.
        """
        return to_pandas(self.table()).set_index("run")

    def to_frame(self) -> Any:
        """The same as `to_pandas`, with the units of the columns in `attrs["units"]`.

        Raises:
            ImportError: pandas is not there; names the extra that brings it.
        """
        return to_frame(self.table(), self._units()).set_index("run")

    def to_xarray(self) -> Any:
        """The table and the columns as an xarray Dataset over `run` and `row`; NaN beyond the end of a shorter run.

        Raises:
            ImportError: xarray is not there; names the extra that brings it.
        """
        return to_xarray(self.table(), self.columns, self._units())

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the table as CSV, or as Parquet where the name ends so.

        Raises:
            InputError: the file cannot be written.
            ImportError: pyarrow is not there for Parquet; names the extra that brings it.
        """
        write_frame(path, self.table(), self._units())

    def _units(self) -> dict[str, str]:
        return {name: self.units.of(unit_of(name)) for name in (*self.indexes, *self.columns)}

    def __len__(self) -> int:
        return len(self.plants)

    def __iter__(self) -> Iterator[Log]:
        return (self[run] for run in range(len(self)))

    @overload
    def __getitem__(self, which: int) -> Log: ...
    @overload
    def __getitem__(self, which: slice) -> Batch: ...
    def __getitem__(self, which: int | slice) -> Log | Batch:
        """The log of a run, or a batch of some of them."""
        if isinstance(which, slice):
            return self._some(range(len(self))[which])
        if not self.with_logs:
            raise ValueError("logs: must be asked for to be kept: closed_loop_batch(..., logs=True)")
        run = range(len(self))[which]
        for failure in self.failures:
            if failure.run == run:
                raise DivergedError(f"run {run}: {failure.reason}")
        return Log.of({name: runs[run] for name, runs in self.columns.items()})

    def _some(self, runs: range) -> Batch:
        places = {run: place for place, run in enumerate(runs)}
        return Batch(
            {name: values[list(runs)] for name, values in self.indexes.items()},
            tuple(failure._replace(run=places[failure.run]) for failure in self.failures if failure.run in places),
            {name: tuple(each[run] for run in runs) for name, each in self.columns.items()},
            tuple(self.plants[run] for run in runs),
            tuple(self.controllers[run] for run in runs),
            tuple(self.seeds[run] for run in runs),
            tuple(self.in_lanes[run] for run in runs),
            self.with_logs,
            self.units,
        )


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
    """Run many plants under their controllers along one reference: what closed_loop would give for each, reduced.

    Of each run the indexes of `performance` are kept, computed on the way: memory grows with what is asked for, not
    with rows. A run that diverges is a row with its reason and time; the others stand.

    Further reductions, by name, of the quantities `error` (reading minus reference, m), `command` (V) and `true_error`
    (m): `error_max` and `error_rms` of its size, `error_final` (the last value), `error_quantile(0.95)` of its size,
    `error_tone(3.0)` the amplitude at a frequency (Hz) and `command_wave(0.05)` the amplitude at a period along the
    travel (m), both by least squares beside an offset. Quantiles are exact up to 65,536 rows, and within 0.07 % beyond,
    from a histogram.

    Runs of one course go side by side through the lanes of the processor's vectors; `in_lanes` of the result says which
    did. They have controllers of one type and rate, as they were made, whose settings without a lane of their own
    (lists, bounds, limits) are equal, and machines with the same travel, knots of the cogging and kinds of effects,
    whose friction is smooth. Others run alone: machines that stick or have a state of their own, effects and
    controllers of one's own. The environment variable COGGING_INSTRUCTIONS chooses the instructions: v2, v3, v4 (x86-64
    with SSE4.2, AVX2, AVX-512), neon, or none. No result depends on it.

    Args:
        plants: one a run.
        controllers: one for each plant; they are copied, not changed. Those of Python run one at a time, beside those
            of the core and compiled ones.
        reference: the motion of all runs.
        duration: s; 0 = the reference's own end.
        seeds: of force and encoder noise, one for each plant; none: 0 for all.
        steps_per_sample: the fewest integration steps between two samples.
        threads: that share the runs; 0 = all cores. The result does not depend on it.
        start, stop: s; indexes and reductions look at the rows with start <= time < stop.
        final_window: s, of error_final_max.
        reductions: beside the indexes, by name.
        columns: of the log, by name, to keep as well.
        every: keep each so many rows of them, from the first on.
        logs: keep all columns and rows, so that the batch is a sequence of logs.
        units: unit labels of command and position in the result; V and m by default.
        progress: see cogging.progress.

    Returns:
        The runs in the order of the plants.

    Raises:
        ValueError: lists of different lengths, a reference that leaves the travel, no duration for a motion without
            an end, a reduction or a column that is none; COGGING_INSTRUCTIONS names what this machine lacks.
        TypeError: a controller is none, or cannot be copied; says what it lacks.
        ControllerError: a controller of one's own raised, or gave no finite number; says when and in which row.

    Example:
        >>> plants = [cogging.Plant(cogging.AxisParameters(mass=mass)) for mass in (0.1, 0.2)]
        >>> pids = [cogging.Pid(cogging.PidParameters(kp=9600.0, kd=48.0))] * 2
        >>> move = cogging.Sine(cogging.SineParameters(amplitude=0.01, frequency=2.0))
        >>> batch = cogging.closed_loop_batch(plants, pids, move, duration=0.5)
        >>> [f"{1e6 * largest:.0f} um" for largest in batch.indexes["error_max"]]
        ['181 um', '306 um']
    """
    _require_plants(plants)
    columns, every = (COLUMNS, 1) if logs else (columns, every)
    options: dict[str, Any] = {"durations": [duration], "steps_per_sample": [steps_per_sample], "threads": threads}
    options |= {"window": (start, stop, final_window), "reductions": reductions, "columns": columns, "every": every}
    kept = _in_parts(plants, controllers, reference, seeds, options, progress)
    return Batch(
        dict(zip(names_of(reductions), kept.values.T, strict=True)),
        kept.failures,
        {name: tuple(runs) for name, runs in kept.columns.items()},
        tuple(plants),
        tuple(controllers),
        tuple(seeds) or (0,) * len(plants),
        kept.in_lanes,
        logs,
        units or Units(),
    )


def _require_plants(plants: Sequence[Plant]) -> None:
    for plant in plants:
        if not isinstance(plant, Plant):
            raise TypeError(f"closed_loop_batch: plants: must be a list, each a Plant, got {described(plant)}")


def _in_parts(
    plants: Sequence[Plant],
    controllers: Sequence[AnyController],
    reference: Reference,
    seeds: Sequence[int],
    options: Mapping[str, Any],
    progress: Progress,
) -> Kept:
    """The runs, part by part where progress is to be told between them."""
    # Where lists differ in length, the core says so.
    if progress is False or len(controllers) != len(plants) or (seeds and len(seeds) != len(plants)) or not plants:
        return kept_of_runs(plants, controllers, [reference], seeds=seeds, **options)
    lanes = _core.instruction_sets().get(_core.instruction_set(), 1)
    at_once = lanes * (options["threads"] or os.cpu_count() or 1)
    size = at_once * -(-max(1, len(plants) // TOLD) // at_once)
    options = {**options, "runs_in_all": len(plants)}
    parts = [range(first, min(first + size, len(plants))) for first in range(0, len(plants), size)]
    values: list[FloatArray] = []
    failures: list[Failed] = []
    columns: dict[str, list[FloatArray]] = {name: [] for name in options["columns"]}
    in_lanes: list[bool] = []
    with steps(progress, "closed_loop_batch", len(parts)) as step:
        for part in parts:
            own = slice(part.start, part.stop)
            kept = kept_of_runs(plants[own], controllers[own], [reference], seeds=seeds[own], **options)
            values.append(kept.values)
            failures += [failure._replace(run=failure.run + part.start) for failure in kept.failures]
            for name, runs in kept.columns.items():
                columns[name] += runs
            in_lanes += kept.in_lanes
            step(f"{part.stop} of {len(plants)} runs")
    return Kept(np.concatenate(values), tuple(failures), columns, tuple(in_lanes))
