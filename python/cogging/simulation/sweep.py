"""Many runs of one model, each with other numbers."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cogging import plot
from cogging._core import Reference
from cogging.arrays import FloatArray
from cogging.calls import Kind, takes
from cogging.files import InputError
from cogging.model.model import Model
from cogging.outputs import target_of
from cogging.progress import Progress, steps
from cogging.simulation.arguments import MODEL, REFERENCE
from cogging.simulation.digests import digest_of
from cogging.simulation.frames import is_parquet, to_frame, to_pandas, to_xarray, write_frame
from cogging.simulation.reductions import Kept, kept_of_runs, names_of, require_reductions
from cogging.simulation.reference import read_reference, reference_from, reference_to_dict
from cogging.simulation.sweep_executor import run_elsewhere
from cogging.simulation.sweep_pieces import Pieces, Table, joined, missing
from cogging.simulation.sweep_points import BOUNDS, points_of, require_numbers, variation_of
from cogging.simulation.varied import SEED, Setup, make_controller, refuse_unknown_paths, units_of, with_numbers
from cogging.tables import library
from cogging.values import ByValue

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PIECES = 100  # of a sweep, or more, where it has so many runs
PIECE_MOST = 256  # runs of one, or what fills all threads once
LANES = 8  # runs that a thread may make at a time
EXECUTOR = Kind((Executor, type(None)), "a concurrent.futures.Executor")


@dataclass(frozen=True, eq=False, repr=False)
class SweepRuns(ByValue):
    """The runs of a sweep, one row each.

    Attributes:
        table: arrays by name: `run`, the varied numbers by path, `seed` of the noise, the indexes (those of
            Performance, then the reductions; NaN where a run failed), `failed_at` (s) and `reason` where one failed.
        varied: the paths of the varied numbers.
        units: of the varied numbers by path; of the indexes by name where the model has labels of its own.

    Example:
        >>> runs = cogging.sweep(model, move, {"axis.mass": [0.11, 0.12, 0.13]})
        >>> len(runs), runs.varied, runs.failed
        (3, ('axis.mass',), 0)
    """

    table: Mapping[str, Any]
    varied: tuple[str, ...]
    units: Mapping[str, str]

    def _brief(self) -> str:
        failed = self.failed
        told = f", {failed} failed" if failed else ""
        error = self.table["error_rms"]
        middle = float(np.nanmedian(error)) if failed < len(self) else np.nan
        median = f"median rms error {middle:.3g} {self.units.get('error_rms', 'm')}"
        return f"{len(self)} runs over {', '.join(self.varied)}{told}, {median}"

    def __len__(self) -> int:
        return len(self.table["run"])

    @property
    def failed(self) -> int:
        """How many runs did not come to their end."""
        return int(np.count_nonzero(self.table["reason"] != ""))

    def plot(
        self, index: str = "error_rms", against: str | None = None, *, units: Any = None, ax: Any = None
    ) -> Figure:
        """Draw an index over what was varied (cogging.plot.sweep).

        Args:
            index: of the table; against: path of a varied number, None: the first.
            units: labels of command and position (cogging.Units).
            ax: axes; None: a new figure.

        Returns:
            The figure.
        """
        return plot.sweep(self, index, against, units=units, ax=ax).figure.figure

    def to_pandas(self) -> Any:
        """The table as a pandas DataFrame with `run` as its index.

        Raises:
            ImportError: pandas is not there; names the extra that brings it.
        """
        return to_pandas(self.table).set_index("run")

    def to_frame(self) -> Any:
        """The same as `to_pandas`, with the units of the columns in `attrs["units"]`.

        Raises:
            ImportError: pandas is not there; names the extra that brings it.
        """
        return to_frame(self.table, self.units).set_index("run")

    def to_xarray(self) -> Any:
        """The table as an xarray Dataset over `run`, each variable with its `units`.

        Raises:
            ImportError: xarray is not there; names the extra that brings it.
        """
        return to_xarray(self.table, {}, self.units)

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the table as CSV, or as Parquet where the name ends so, with `units` of its columns.

        Raises:
            InputError: the file cannot be written.
            ImportError: pyarrow is not there for Parquet; names the extra that brings it.
        """
        write_frame(path, self.table, self.units)


class Piece(NamedTuple):
    """One task of a sweep: some of its runs, with all they need. It can be pickled."""

    setup: Setup
    paths: tuple[str, ...]
    points: FloatArray
    first: int
    seed: int
    duration: float
    threads: int
    window: tuple[float, float, float]
    reductions: tuple[str, ...]


@takes(model=MODEL, reference=REFERENCE, executor=EXECUTOR)
def sweep(
    model: Model | str | os.PathLike[str],
    reference: Reference | Mapping[str, Any] | str | os.PathLike[str],
    vary: Mapping[str, Any] | str,
    *,
    method: str = "grid",
    runs: int = 1000,
    seed: int = 0,
    duration: float = 0.0,
    start: float = -np.inf,
    stop: float = np.inf,
    final_window: float = 2.0,
    reductions: Sequence[str] = (),
    out: str | os.PathLike[str] | None = None,
    executor: Executor | None = None,
    threads: int = 0,
    progress: Progress = False,
) -> SweepRuns:
    """Run a model many times along a reference, with other numbers each time, and keep indexes of each run.

    `vary` gives by path how a number is varied: a list of values; `{"from": a, "to": b}` evenly between, with
    `"points": n` on a grid and `"scale": "log"` evenly in the logarithm; `{"mean": m, "deviation": s}` normal; or
    "bounds", normal with 95 % in the model's own interval. In place of the mapping, "bounds" varies all that the model
    has finite [bounds] for. Paths are those of `parameters_of(model, together=True)`, and `controller.kp`,
    `encoder.noise`, `noise.force`, `reference.velocity`, `seed`.

    Run i has noise of its own, with the seed `seed` + i, unless `seed` is varied. A run that diverges, or whose numbers
    break a rule, is a row with its reason; the others stand. The same arguments give the same table, whatever the
    executor.

    With `out`, finished pieces stand in a folder beside it (`OUT.pieces`) until the whole is written: after an
    interruption, a crash or a full disk the same call goes on where it was. A custom effect counts as the same if its
    law and everything that it refers to are unchanged; a law that cannot be compared keeps no pieces (docs/sweep.md).

    Args:
        model: a Model, or the path of a model file.
        reference: a motion, the fields of a reference file, or the path of one.
        vary: how each number is varied, by path.
        method: "grid" (all combinations), "random", "latin_hypercube" or "sobol".
        runs: how many, but for a grid.
        seed: of draws and noise.
        duration: s; 0 = that of the reference file, or the motion's own end.
        start, stop: s; the indexes look at the rows with start <= time < stop.
        final_window: s, of error_final_max.
        reductions: beside the indexes, by name (see closed_loop_batch).
        out: the file to write, CSV or Parquet by its name; None: none.
        executor: whose workers run the pieces: any concurrent.futures.Executor, Dask's and Ray's among them; None: the
            threads of this process.
        threads: of this process, or of each worker; 0 = all cores, one in a worker.
        progress: see cogging.progress.

    Returns:
        The runs.

    Raises:
        ValueError: a path that the run has not (with the nearest), a variation, method or reduction that is none, or
            no run could begin.
        InputError: a file cannot be used or written, or the executor has died; finished runs stand.
        ImportError: pyarrow is not there for Parquet; names the extra that brings it.

    Example:
        >>> drawn = {"axis.mass": {"mean": 0.12, "deviation": 0.005}, "controller.kp": [9000.0, 9600.0]}
        >>> runs = cogging.sweep(model, move, drawn, method="latin_hypercube", runs=8)
        >>> len(runs), runs.failed
        (8, 0)
    """
    require_numbers(seed, runs, duration, (start, stop, final_window), threads)
    model, motion, own_duration = _setup(model, reference)
    paths, points = _points(Setup(model, motion), vary, method, runs, seed)
    require_reductions(reductions)
    if out is not None and is_parquet(out):
        library("pyarrow")
    common = Piece(
        setup=Setup(model, motion),
        paths=paths,
        points=points[:0],
        first=0,
        seed=int(seed),
        duration=float(duration) or own_duration,
        threads=int(threads) or int(executor is not None),
        window=(start, stop, final_window),
        reductions=tuple(reductions),
    )
    return _runs(common, points, out, executor, progress)


def _runs(common: Piece, points: FloatArray, out: Any, executor: Executor | None, progress: Progress) -> SweepRuns:
    """Run all points piece by piece, and write what they gave where it is asked for."""
    digest = None
    if out is not None:
        target_of(out)
        digest = digest_of(common.setup.model, _asked(common, points))
    with nullcontext() if digest is None else Pieces(out, digest) as kept:
        try:
            table = _table(common, points, kept, executor, progress)
        except BaseException:
            if kept is not None:
                kept.remove_empty()
            raise
        found = SweepRuns(table, common.paths, units_of(common.setup, common.paths, table))
        if _none_began(found):
            if kept is not None:
                kept.remove()
            raise ValueError(f"no run could begin: {found.table['reason'][0]}")
        if out is not None:
            try:
                found.write(out)
            except InputError as error:
                raise InputError(f"{error}; {kept.stands}" if kept is not None else str(error)) from None
        if kept is not None:
            kept.remove()
        return found


def _points(setup: Setup, vary: Any, method: str, runs: int, seed: int) -> tuple[tuple[str, ...], FloatArray]:
    """The paths that are varied, and the values of each run."""
    intervals = setup.model.intervals
    if vary == BOUNDS:
        vary = {path: BOUNDS for path, ends in intervals.items() if np.isfinite(ends).all()}
    if not isinstance(vary, Mapping) or not vary:
        raise ValueError(f'vary: must give at least one number, or be "bounds" of a model that has some, got {vary!r}')
    refuse_unknown_paths(setup, vary)
    variations = [variation_of(path, told, setup.model) for path, told in vary.items()]
    return tuple(vary), points_of(variations, method, runs, seed)


def run_piece(piece: Piece) -> Table:
    """The rows of the runs of a piece; in whatever process it is."""
    reasons = [""] * len(piece.points)
    times = np.full(len(piece.points), np.nan)
    runs: list[tuple[int, Setup]] = []
    for place, values in enumerate(piece.points):
        try:
            setup = with_numbers(piece.setup, dict(zip(piece.paths, map(float, values), strict=True)))
            make_controller(setup.model)
            runs.append((place, setup))
        except ValueError as error:
            reasons[place] = str(error)
    names = names_of(piece.reductions)
    indexes = np.full((len(piece.points), len(names)), np.nan)
    if runs:
        kept = _kept(piece, runs)
        indexes[[place for place, _ in runs]] = kept.values
        for failure in kept.failures:
            place = runs[failure.run][0]
            reasons[place], times[place] = failure.reason, failure.time
    varied = {path: piece.points[:, i] for i, path in enumerate(piece.paths) if path != SEED}
    return {
        "run": np.arange(piece.first, piece.first + len(piece.points)),
        **varied,
        "seed": np.array(_seeds(piece), dtype=np.int64),
        **dict(zip(names, indexes.T, strict=True)),
        "failed_at": times,
        "reason": np.array(reasons, dtype=str),
    }


def _kept(piece: Piece, runs: list[tuple[int, Setup]]) -> Kept:
    """What the core keeps of those runs of a piece whose numbers break no rule."""
    seeds = _seeds(piece)
    one_motion = not any(path.startswith("reference.") for path in piece.paths)
    return kept_of_runs(
        [setup.model.plant() for _, setup in runs],
        [make_controller(setup.model) for _, setup in runs],
        [piece.setup.reference] if one_motion else [setup.reference for _, setup in runs],
        durations=[piece.duration],
        seeds=[seeds[place] for place, _ in runs],
        steps_per_sample=[piece.setup.model.steps_per_sample],
        threads=piece.threads,
        window=piece.window,
        reductions=piece.reductions,
        keeps_refused=True,
    )


def _seeds(piece: Piece) -> list[int]:
    if SEED in piece.paths:
        return [int(value) for value in piece.points[:, piece.paths.index(SEED)]]
    return [piece.seed + piece.first + place for place in range(len(piece.points))]


def _table(
    common: Piece, points: FloatArray, kept: Pieces | None, executor: Executor | None, progress: Progress
) -> Table:
    """The rows of all points in order, those that are kept already among them."""
    tables = [] if kept is None else kept.tables(len(points))
    done, size = sum(len(table["run"]) for table in tables), piece_size(len(points), common.threads)
    pieces = [
        common._replace(points=points[runs.start : runs.stop], first=runs.start)
        for runs in missing(tables, len(points), size)
    ]
    with steps(progress, "sweep", len(pieces)) as step:
        for table in _made(pieces, executor, lambda: "" if kept is None else kept.stands):
            tables.append(table)
            if kept is not None:
                kept.keep(table)
            done += len(table["run"])
            step(f"{done} of {len(points)} runs")
    return joined(tables)


def piece_size(runs: int, threads: int) -> int:
    """How many runs a piece has: what fills the lanes of all threads, and more where there are many."""
    least = LANES * (threads or os.cpu_count() or 1)
    return least * math.ceil(min(max(1, PIECE_MOST // least), runs / PIECES / least))


def _made(pieces: list[Piece], executor: Executor | None, stands: Callable[[], str]) -> Iterator[Table]:
    return map(run_piece, pieces) if executor is None else run_elsewhere(run_piece, pieces, executor, stands)


def _none_began(found: SweepRuns) -> bool:
    """Whether no run could even begin: then what is wrong is no single run."""
    return found.failed == len(found) and bool(np.isnan(found.table["failed_at"]).all())


def _asked(common: Piece, points: FloatArray) -> dict[str, Any]:
    return {
        "reference": reference_to_dict(common.setup.reference),
        "paths": list(common.paths),
        "points": points,
        "seed": common.seed,
        "duration": common.duration,
        "window": list(common.window),
        "reductions": list(common.reductions),
    }


def _setup(model: Any, reference: Any) -> tuple[Model, Reference, float]:
    """Model, motion and the duration that the reference file says, each read where it is a path."""
    path, model = model, model if isinstance(model, Model) else Model.read(model)
    try:
        make_controller(model)
    except ValueError as error:
        raise (error if model is path else InputError(f"{path}: {error}")) from None
    if isinstance(reference, Reference):
        return model, reference, 0.0
    return model, *(reference_from(reference) if isinstance(reference, Mapping) else read_reference(reference))
