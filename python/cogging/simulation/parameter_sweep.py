"""Sweeps: many runs of one model, each with other numbers.

Runs are computed in pieces, by threads of this process or by the workers of an executor. Finished pieces are kept in a
file beside the output until the whole table is written, so that an interrupted sweep continues where it was.
"""

from __future__ import annotations

import importlib.metadata
import itertools
import math
import os
import re
import uuid
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cogging import plot
from cogging._core import Reference, StopFlag
from cogging.arrays import FloatArray
from cogging.calls import Kind, check_arguments
from cogging.files import FieldError, InputError, errors_of, read_toml, refuse_unknown_keys, shipped_toml
from cogging.model.model import Model, is_number
from cogging.outputs import AnyPath, target_of
from cogging.progress import Progress, steps
from cogging.shown import quoted
from cogging.simulation import varied
from cogging.simulation.arguments import MODEL, REFERENCE
from cogging.simulation.kept_work import KeptWork
from cogging.simulation.reductions import INDEXES, kept_of_runs, names_of, reduction, unit_of
from cogging.simulation.reference import files_of_reference, motion_of, reference_to_dict
from cogging.simulation.runs_table import RunsTable, is_parquet
from cogging.simulation.varied import BOUNDS, SEED, VARIATION_KEYS, Setup, make_controller, with_numbers
from cogging.tables import library

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Table = dict[str, Any]
PIECES = 100  # pieces of a sweep, or more
PIECE_MOST = 256  # runs of a piece, or as many as fill all threads once
LANES = 8  # runs that one thread may compute at once
GROUPS = 10  # of equally many runs, by which an influence is measured
SHOWN_REASONS = 3  # of failed runs, in a summary
EXECUTOR = Kind((Executor, type(None)), "a concurrent.futures.Executor")


@dataclass(frozen=True, eq=False, repr=False)
class SweepRuns(RunsTable):
    """The runs of a sweep, one row each.

    Attributes:
        table: arrays by name: `run`, the varied numbers by path, `seed` of the noise, the indexes (those of
            Performance, then the reductions; NaN for a failed run), `failed_at` (s) and `reason` of a failure.
        varied: the paths of the varied numbers.
        units: of the varied numbers by path; of the indexes by name if the model has labels of its own.

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
        error = self.table["error_rms"]
        middle = float(np.nanmedian(error)) if failed < len(self) else np.nan
        median = f"median rms error {middle:.3g} {self.units.get('error_rms', 'm')}"
        return f"{len(self)} runs over {', '.join(self.varied)}{f', {failed} failed' if failed else ''}, {median}"

    def __len__(self) -> int:
        return len(self.table["run"])

    def _rows(self) -> tuple[Mapping[str, Any], Mapping[str, str]]:
        return self.table, self.units

    @property
    def failed(self) -> int:
        """Number of failed runs."""
        return int(np.count_nonzero(self.table["reason"] != ""))

    def influence(self, index: str = "error_rms") -> dict[str, float]:
        """Return by path how much of the spread of an index each varied number explains alone, the largest first.

        The share is the adjusted correlation ratio of the ranks of the index, so that a few large values do not decide:
        the variance between groups of runs with (nearly) the same number over the variance of all completed runs. It is
        0 for a number that explains no more than chance would.
        """
        values = np.asarray(self.table[index], dtype=np.float64)
        good = np.isfinite(values)
        ranks = np.unique(values[good], return_inverse=True)[1].astype(np.float64)
        shares = {path: _explained(np.asarray(self.table[path])[good], ranks) for path in self.varied}
        return dict(sorted(shares.items(), key=lambda item: -item[1]))

    def text(self) -> str:
        """Return the summary for the screen: runs, failures, the spread of each index, and what matters most."""
        ran = f"{len(self)} runs over {', '.join(self.varied)}, {self.failed} failed"
        lines = [ran, f"  {'':<24}{'median':>12}   central 90 %"]
        for name in INDEXES:
            values = self.table[name][np.isfinite(self.table[name])]
            low, middle, high = np.quantile(values, (0.05, 0.5, 0.95)) if values.size else (np.nan,) * 3
            unit = (self.units.get(name) or unit_of(name)).removeprefix("1")
            lines.append(f"  {name:<24}{middle:>12.4g}   {low:.4g} to {high:.4g} {unit}".rstrip())
        shares = ", ".join(f"{path} {100.0 * share:.0f} %" for path, share in self.influence().items())
        lines.append(f"  share of the spread of error_rms that each input explains alone: {shares}")
        alike: dict[str, list[str]] = {}  # reasons that differ in numbers
        for reason in filter(None, map(str, self.table["reason"])):
            alike.setdefault(re.sub(r"\d[\d.e+-]*", "", reason), []).append(reason)
        for reasons in sorted(alike.values(), key=len, reverse=True)[:SHOWN_REASONS]:
            lines.append(f"  {len(reasons)} failed: {reasons[0]}")
        return "\n".join(lines)

    def plot(
        self, index: str = "error_rms", against: str | None = None, *, units: Any = None, ax: Any = None
    ) -> Figure:
        """Plot an index over a varied number and return the figure (arguments as of cogging.plot.sweep)."""
        return plot.sweep(self, index, against, units=units, ax=ax).figure.figure


def _explained(number: FloatArray, ranks: FloatArray) -> float:
    """Return the adjusted correlation ratio of ranks on a number, in groups of its values or of equally many runs."""
    values, groups = np.unique(number, return_inverse=True)
    if len(values) > GROUPS:
        groups = np.argsort(np.argsort(number, kind="stable")) * GROUPS // len(number)
    sizes = np.bincount(groups)
    rest, total = len(ranks) - len(sizes), float(np.sum((ranks - np.mean(ranks)) ** 2)) if len(ranks) else 0.0
    if rest < 1 or total == 0.0:
        return 0.0
    within = float(np.sum((ranks - (np.bincount(groups, ranks) / sizes)[groups]) ** 2))
    return max(0.0, 1.0 - (within / rest) / (total / (len(ranks) - 1)))


class Piece(NamedTuple):
    """Consecutive runs of a sweep with all that they need. It can be pickled."""

    setup: Setup
    paths: tuple[str, ...]
    points: FloatArray
    first: int
    seed: int
    duration: float
    threads: int
    window: tuple[float, float, float]
    reductions: tuple[str, ...]


@check_arguments(model=MODEL, reference=REFERENCE, executor=EXECUTOR)
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
    """Simulate a model many times along a reference with other numbers, and keep indexes of each run.

    `vary` gives by path how a number varies: a list of values; `{"from": a, "to": b}` uniform, with `"points": n` on a
    grid and `"scale": "log"` uniform in the logarithm; `{"mean": m, "deviation": s}` normal; or "bounds", normal with
    95 % in the model's interval. "bounds" instead of the mapping varies all numbers with finite [bounds] in the model.
    Paths are those of `parameters_of(model, together=True)`, and `controller.kp`, `encoder.noise`, `noise.force`,
    `reference.velocity`, `seed`.

    Run i has noise with the seed `seed` + i, unless `seed` is varied. A run that diverges, or whose numbers break a
    rule, is a row with its reason; the others complete. The same arguments give the same table, whatever the executor.

    With `out`, finished pieces are stored in a file beside it (`OUT.kept`) until the whole is written: after an
    interruption, a crash or a full disk the same call continues where it was. A model with a custom effect, whose law
    cannot be compared, stores no pieces.

    Args:
        model: a Model, or the path of a model file.
        reference: a motion, the fields of a reference file, or the path of one.
        vary: how each number varies, by path.
        method: "grid" (all combinations), "random", "latin_hypercube" or "sobol".
        runs: number of runs, except of a grid.
        seed: of draws and noise.
        duration: s; 0 = that of the reference file, or the end of the motion.
        start, stop: s; the indexes use the rows with start <= time < stop.
        final_window: s, of error_final_max.
        reductions: further indexes by name (see closed_loop_batch).
        out: file to write, CSV or Parquet by its name; None: none.
        executor: runs the pieces on its workers: any concurrent.futures.Executor, such as Dask's and Ray's; None:
            threads of this process.
        threads: of this process, or of each worker; 0 = all cores, one in a worker.
        progress: see cogging.progress.

    Returns:
        The runs.

    Raises:
        ValueError: an unknown path (with the nearest), variation, method or reduction, or no run could begin.
        InputError: a file cannot be used or written, or the executor failed; finished runs are kept.
        ImportError: pyarrow is not installed for Parquet; names the extra.

    Example:
        >>> drawn = {"axis.mass": {"mean": 0.12, "deviation": 0.005}, "controller.kp": [9000.0, 9600.0]}
        >>> runs = cogging.sweep(model, move, drawn, method="latin_hypercube", runs=8)
        >>> len(runs), runs.failed
        (8, 0)
    """
    varied.require_numbers({"runs": runs}, seed, duration, (start, stop, final_window), threads)
    path, model = model, model if isinstance(model, Model) else Model.read(model)
    try:
        make_controller(model)
    except ValueError as error:
        raise (error if model is path else InputError(f"{path}: {error}")) from None
    motion, own_duration = motion_of(reference)
    setup = Setup(model, motion)
    if vary == BOUNDS:
        vary = {path: BOUNDS for path, ends in setup.model.intervals.items() if np.isfinite(ends).all()}
    if not isinstance(vary, Mapping) or not vary:
        raise ValueError(f'vary: must give at least one number, or be "bounds" of a model that has some, got {vary!r}')
    varied.refuse_unknown_paths(setup, vary)
    variations = [varied.variation_of(path, stated, setup.model) for path, stated in vary.items()]
    points = varied.points_of(variations, method, runs, seed)
    for name in names_of(reductions)[len(INDEXES) :]:
        reduction(name)
    common = Piece(
        setup=setup,
        paths=tuple(vary),
        points=points[:0],
        first=0,
        seed=int(seed),
        duration=float(duration) or own_duration,
        threads=int(threads) or int(executor is not None),
        window=(start, stop, final_window),
        reductions=tuple(reductions),
    )
    if out is not None:
        if is_parquet(out):
            library("pyarrow")
        target_of(out)
    asked: dict[str, Any] = {"reference": reference_to_dict(setup.reference), "paths": list(vary), "points": points}
    asked |= {"seed": common.seed, "duration": common.duration, "window": list(common.window)}
    kept = KeptWork(out, setup.model, {**asked, "reductions": list(common.reductions)})
    with kept.named_in_errors():
        found = _table(common, points, kept, executor=executor, progress=progress)
        if found.failed == len(found) and np.isnan(found.table["failed_at"]).all():
            kept.remove()
            raise ValueError(f"no run could begin: {found.table['reason'][0]}")
        if out is not None:
            found.write(out)
    kept.remove()
    return found


def _table(
    common: Piece, points: FloatArray, kept: KeptWork, *, executor: Executor | None, progress: Progress
) -> SweepRuns:
    """Return the runs of all points in order; pieces that are kept already are not computed again."""
    tables: list[Table] = []
    done = np.zeros(len(points), dtype=bool)
    for part in kept.parts:
        if not done[part["run"]].any():  # two calls at once may have kept one piece twice
            done[part["run"]] = True
            tables.append({name: np.array(values) for name, values in part.items()})
    least = LANES * (common.threads or os.cpu_count() or 1)  # runs that fill the lanes of all threads
    size = least * math.ceil(min(max(1, PIECE_MOST // least), len(points) / PIECES / least))
    places = np.flatnonzero(~done)
    gaps = np.split(places, np.flatnonzero(np.diff(places) > 1) + 1) if len(places) else []
    missing = [gap[first : first + size] for gap in gaps for first in range(0, len(gap), size)]
    pieces = [common._replace(points=points[runs], first=int(runs[0])) for runs in missing]
    with steps(progress, "sweep", len(pieces)) as step:
        new = map(run_piece, pieces) if executor is None else run_elsewhere(pieces, executor)
        count = int(done.sum())
        for table in new:
            tables.append(table)
            kept.add({name: values.tolist() for name, values in table.items()})
            count += len(table["run"])
            step(f"{count} of {len(points)} runs")
    tables.sort(key=lambda table: int(table["run"][0]))
    whole = {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}
    return SweepRuns(whole, common.paths, varied.units_of(common.setup, common.paths, whole))


def run_piece(piece: Piece) -> Table:
    """Return the rows of the runs of a piece; workers call it in their own processes."""
    count = len(piece.points)
    reasons, times, names = [""] * count, np.full(count, np.nan), names_of(piece.reductions)
    if SEED in piece.paths:
        seeds = [int(value) for value in piece.points[:, piece.paths.index(SEED)]]
    else:
        seeds = [piece.seed + piece.first + place for place in range(count)]
    runs: list[tuple[int, Setup]] = []
    for place, values in enumerate(piece.points):
        try:
            setup = with_numbers(piece.setup, dict(zip(piece.paths, map(float, values), strict=True)))
            make_controller(setup.model)
            runs.append((place, setup))
        except ValueError as error:
            reasons[place] = str(error)
    indexes = np.full((count, len(names)), np.nan)
    if runs:
        one_motion = not any(path.startswith("reference.") for path in piece.paths)
        kept = kept_of_runs(
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
        indexes[[place for place, _ in runs]] = kept.values
        for failure in kept.failures:
            place = runs[failure.run][0]
            reasons[place], times[place] = failure.reason, failure.time
    numbers = {path: piece.points[:, i] for i, path in enumerate(piece.paths) if path != SEED}
    return {
        "run": np.arange(piece.first, piece.first + count),
        **numbers,
        "seed": np.array(seeds, dtype=np.int64),
        **dict(zip(names, indexes.T, strict=True)),
        "failed_at": times,
        "reason": np.array(reasons, dtype=str),
    }


# Executors ------------------------------------------------------------------------------------------------------------

WAITING_MOST = 1024  # pieces submitted ahead: as many workers are kept busy
LOOK_EVERY = 2.0  # s, after which a signal is seen where waiting blocks it


def run_in_worker(piece: Piece, version: str, call: str) -> Table:
    """Return the rows of a piece in a worker, which must have the same version; `call` differs for every call."""
    own = importlib.metadata.version("cogging")
    if own != version:
        raise RuntimeError(f"must have version {version} of the package, has {own}")
    return run_piece(piece)


def run_elsewhere(pieces: Iterable[Piece], executor: Executor) -> Iterator[Table]:
    """Yield the rows of pieces as the workers of an executor finish them."""
    stop, version = StopFlag(), importlib.metadata.version("cogging")

    def run_until_stopped(piece: Piece) -> Table:
        stop.heed()
        return run_piece(piece)

    def submit(piece: Piece) -> Future[Table]:
        if isinstance(executor, ThreadPoolExecutor):  # only threads of this process can see the flag
            return executor.submit(run_until_stopped, piece)
        call = uuid.uuid4().hex  # Dask answers a repeated call with its earlier result, errors too
        return executor.submit(run_in_worker, piece, version, call)

    left, waiting = iter(pieces), set[Future[Table]]()
    try:
        while waiting := waiting | set(map(submit, itertools.islice(left, WAITING_MOST - len(waiting)))):
            done, waiting = wait(waiting, LOOK_EVERY, return_when=FIRST_COMPLETED)
            for future in sorted(done, key=lambda one: one.cancelled() or one.exception() is not None):
                yield future.result()
    except (InputError, MemoryError):
        raise
    except Exception as error:
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        raise InputError(f"executor: {type(executor).__name__} could not run a piece: {reason}") from error
    finally:
        stop.set()
        for future in waiting:
            future.cancel()


# Sweep files, and what they share with tune files ---------------------------------------------------------------------

#: Types of the keys of these files (file_schema.toml), and what they are called.
TYPES: dict[str, tuple[type, str]] = {
    "string": (str, "a text"),
    "integer": (int, "a whole number"),
    "number": (float, "a number"),
    "array": (list, "a list of names"),
    "object": (dict, "a section"),
}


def read_job(path: AnyPath, what: str) -> dict[str, Any]:
    """Return what a sweep or tune file (`what`) holds, with the paths of its model and reference relative to it.

    InputError: an unknown key, a missing one that is required, one of another type, or no such file.
    """
    document, folder = read_toml(path), Path(path).parent
    known = shipped_toml("file_schema.toml")
    keys: Mapping[str, Any] = known[what]
    with errors_of(path):
        refuse_unknown_keys(document, keys, "")
        for key in known["required"][what]:
            if key not in document:
                raise FieldError("", key, "must be given, got nothing")
        for key, value in document.items():
            kind, called = TYPES[keys[key]["type"]]
            fits = is_number(value) if kind in (int, float) else isinstance(value, kind)
            if (kind is int and not isinstance(value, int)) or not (fits or (key == "vary" and value == BOUNDS)):
                words = f'{called} or "{BOUNDS}"' if key == "vary" else called
                raise FieldError("", key, f"must be {words}, got {quoted(value)}")
        for key in ("model", "reference"):
            if not (folder / document[key]).is_file():
                raise FieldError("", key, f"must be a file beside the {what} file, got {quoted(document[key])}")
    return {**document, **{key: folder / document[key] for key in ("model", "reference")}}


def read_sweep(path: AnyPath) -> dict[str, Any]:
    """Return the arguments of `sweep` from a sweep file; paths of other files are relative to it."""
    asked = read_job(path, "sweep")
    if asked["vary"] == BOUNDS:
        return asked
    vary: dict[str, Any] = {}
    with errors_of(path):
        for number, stated in _by_path(asked["vary"]):
            if number in vary:
                got = f"{quoted(vary[number])} and {quoted(stated)}"
                raise FieldError("vary", number, f"must be given once, got {got}")
            vary[number] = stated
    return {**asked, "vary": vary}


def _by_path(vary: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Yield variations by path, also of sections that TOML makes of unquoted paths (`axis.mass = [0.1, 0.2]`)."""
    for name, stated in vary.items():
        if isinstance(stated, Mapping) and stated and not set(stated) & set(VARIATION_KEYS):
            yield from _by_path(stated, f"{before}{name}.")
        else:
            yield f"{before}{name}", stated


def files_of_job(arguments: Mapping[str, Any], path: AnyPath) -> list[AnyPath]:
    """Return all files that a sweep or tune file reads: itself, its model, its reference and the samples of that."""
    return [path, arguments["model"], *files_of_reference(arguments["reference"])]
