"""Many runs of one model, each with other numbers.

Runs are made in pieces, by threads of this process or by the workers of an executor. Finished pieces stand in a folder
beside the output until the whole is written, so that a sweep that was ended goes on where it was."""

from __future__ import annotations

import contextlib
import hashlib
import importlib.metadata
import io
import math
import os
import pickle
import re
import sys
import time
import uuid
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from cogging import plot
from cogging._core import Reference, StopFlag
from cogging.arrays import FloatArray
from cogging.calls import Kind, check_arguments
from cogging.files import InputError, require_file
from cogging.model.model import Model
from cogging.outputs import PART_FILE, target_of, write_bytes
from cogging.progress import Progress, steps
from cogging.shown import quoted
from cogging.simulation.arguments import MODEL, REFERENCE
from cogging.simulation.digests import digest_of
from cogging.simulation.frames import is_parquet, to_frame, to_pandas, to_xarray, write_frame
from cogging.simulation.reductions import Kept, kept_of_runs, names_of, require_reductions
from cogging.simulation.reference import read_reference, reference_from, reference_to_dict
from cogging.simulation.varied import (
    BOUNDS,
    SEED,
    Setup,
    make_controller,
    points_of,
    refuse_unknown_paths,
    require_numbers,
    units_of,
    variation_of,
    with_numbers,
)
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


if sys.platform != "win32":
    import fcntl

Table = dict[str, Any]
OTHERWISE = "remove it, or write to another file"
PIECE = re.compile(r"[0-9]{9}-[0-9a-f]{64}\.npz")  # the first run, and what `_name` makes of the content


class Pieces:
    """Keeps the tables of a sweep's pieces, so that a sweep that was ended goes on where it was.

    One process at a time has them: it holds a lock on `sweep.json`, which goes with the process. That file is the first
    in the folder and the first to go: without it, what else stands there is of a sweep that is done. A piece has in its
    name a checksum of the sweep and of all that it holds: what is not as it was written is made anew. What has another
    name is not the sweep's: a folder that holds any is refused, and none is ever removed.

    Attributes:
        folder: where they stand; it goes when the sweep is done.
    """

    def __init__(self, out: str | os.PathLike[str], digest: str) -> None:
        """Make the folder, or open the one that an earlier call of the same sweep left.

        Args:
            out: the output beside which it stands.
            digest: of all that decides what the runs give.
        """
        target = target_of(out)
        self.folder = target.with_name(f"{target.name}.pieces")
        self._called = f"{os.fspath(out)}.pieces"
        self._told = self.folder / "sweep.json"
        self._digest = digest.encode()
        try:
            self._lock = self._opened()
        except BlockingIOError:
            raise InputError(
                f"{self._called}: another process is making this sweep, or another to the same file"
            ) from None
        except OSError as error:
            raise InputError(f"{self._called}: cannot be used: {error.strerror}") from None
        try:
            self._begin()
        except BaseException:
            self._lock.close()
            raise

    def _opened(self) -> IO[bytes]:
        while True:
            if self.folder.is_symlink():
                raise InputError(f"{self._called}: must be a folder, got a link: {OTHERWISE}")
            self.folder.mkdir(exist_ok=True)
            if others := [path.name for path in self.folder.glob("*") if not self._is_own(path)]:
                what = f"must hold nothing but the pieces of a sweep, got {quoted(min(others))}"
                raise InputError(f"{self._called}: {what}: {OTHERWISE}")
            with contextlib.suppress(FileNotFoundError):  # the folder has gone meanwhile, with a sweep that was done
                flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
                descriptor = os.open(self._told, flags, 0o666)
                file = os.fdopen(descriptor, "r+b", buffering=0)
                try:
                    require_file(self._told)
                    if sys.platform != "win32":
                        fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # a forked worker has no part in it
                    if os.path.samestat(os.fstat(descriptor), os.lstat(self._told)):
                        return file
                except BaseException:
                    file.close()
                    raise
                file.close()

    def _begin(self) -> None:
        """Hold the sweep against that of the folder; a new one begins with none of what stands there."""
        wanted = b'{"digest": "' + self._digest + b'"}\n'
        try:
            if text := self._lock.read(len(wanted) + 1):
                if text != wanted:
                    what = "holds pieces of another sweep, or of another version"
                    raise InputError(f"{self._called}: {what}: {OTHERWISE}")
                return
            for path in self._finished():
                path.unlink()
            self._lock.write(wanted)
            os.fsync(self._lock.fileno())
        except OSError as error:
            self.remove()
            raise InputError(f"{self._called}: cannot be written: {error.strerror}") from None

    def __enter__(self) -> Pieces:
        return self

    def __exit__(self, *_: object) -> None:
        self._lock.close()

    def keep(self, table: Table) -> None:
        """Write a piece."""
        file = io.BytesIO()
        np.savez(file, **{name: _saved(values) for name, values in table.items()})  # type: ignore[arg-type]
        try:
            write_bytes(self.folder / self._name(table["run"][0], file.getvalue()), file.getvalue(), sync=False)
        except InputError as error:
            raise InputError("; ".join(filter(None, (str(error), self.stands)))) from None

    def tables(self, runs: int) -> list[Table]:
        """The pieces that were finished, of a sweep of so many runs; no two hold the same run. Broken ones go."""
        done, tables = np.zeros(runs, dtype=bool), []
        for path in self._finished():
            table = self._read(path)
            if table is None:
                with contextlib.suppress(OSError):
                    path.unlink()
            elif not done[table["run"]].any():
                done[table["run"]] = True
                tables.append(table)
        return tables

    def remove(self) -> None:
        """Take away what the sweep has written, and the folder with it."""
        own = [path for path in self.folder.glob("*") if self._is_own(path)]
        if sys.platform == "win32":  # which removes no file that is open
            self._lock.close()
        for path in (self._told, *own):
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)
        with contextlib.suppress(OSError):
            self.folder.rmdir()

    def remove_empty(self) -> None:
        """Take the folder away where it has no piece."""
        if not self._finished():
            self.remove()

    @property
    def stands(self) -> str:
        """What to tell of the finished runs where a sweep has ended before its time; nothing where none is."""
        if not self._finished():
            return ""
        return f"finished runs stand in {self._called}, the same call goes on from there"

    def _finished(self) -> list[Path]:
        return sorted(path for path in self.folder.glob("*") if PIECE.fullmatch(path.name))

    def _is_own(self, path: Path) -> bool:
        return bool(path == self._told or PIECE.fullmatch(path.name) or PART_FILE.fullmatch(path.name))

    def _name(self, first: int, content: bytes) -> str:
        return f"{first:09d}-{hashlib.sha256(self._digest + content).hexdigest()}.npz"

    def _read(self, path: Path) -> Table | None:
        """A piece, or None where it is not what the sweep wrote there."""
        try:
            require_file(path)
            content = path.read_bytes()
        except (OSError, InputError):
            return None
        if path.name != self._name(int(path.name[:9]), content):
            return None
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            return {name: file[name] for name in file.files}


def missing(tables: Iterable[Table], runs: int, size: int) -> list[range]:
    """Which of so many runs are in none of the tables, in parts of a size at most."""
    done = np.zeros(runs, dtype=bool)
    for table in tables:
        done[table["run"]] = True
    places = np.flatnonzero(~done)
    gaps = np.split(places, np.flatnonzero(np.diff(places) > 1) + 1) if len(places) else []
    ends = [(int(gap[0]), int(gap[-1]) + 1) for gap in gaps]
    return [range(first, min(first + size, end)) for begin, end in ends for first in range(begin, end, size)]


def joined(tables: list[Table]) -> Table:
    """The rows of all pieces, in the order of their runs."""
    tables = sorted(tables, key=lambda table: int(table["run"][0]))
    return {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}


def _saved(values: Any) -> np.ndarray[Any, Any]:
    array = np.asarray(values)
    return array.astype(str) if array.dtype == object else array


PieceOf = TypeVar("PieceOf")
Found = TypeVar("Found")
WAITING_MOST = 1024  # pieces that an executor is given ahead: as many workers are kept busy
LOOK_EVERY = 2.0  # s, between two looks at whether workers are left
GONE_MOST = 60.0  # s, that all workers may be gone, as those are that are started anew

#: What a worker runs, as text: one that lacks the package, or has another, cannot be sent a function of it, and must
#: answer with what it lacks. The task is unpickled by the package, and not before it is known to be the same.
WORKER = """
def run(version, task):
    import importlib, importlib.metadata, os, pickle, platform
    worker = f"{platform.node()}, process {os.getpid()}"
    try:
        importlib.import_module("cogging")
        own = importlib.metadata.version("cogging")
    except Exception as error:
        return "cannot import the package", f"{worker}: {type(error).__name__}: {error}"
    if own != version:
        return "has another version of the package", f"{worker}: {own}, where this is {version}"
    function, piece = pickle.loads(task)
    return "", function(piece)
"""
#: Runs it: of all that every worker has, `eval` alone takes a program and gives its value.
CALL = "(exec(program, space), space['run'](version, task))[1]"


def run_elsewhere(
    function: Callable[[PieceOf], Found], pieces: Sequence[PieceOf], executor: Executor, stands: Callable[[], str]
) -> Iterator[Found]:
    """What a function of the package gives for each piece, as an executor's workers finish them.

    Never more than a few pieces ahead are waiting there.

    Args:
        function: that can be pickled.
        pieces: its arguments.
        executor: whose workers run it.
        stands: gives what to tell of finished work where the executor does not do its own, or nothing.
    """
    stop = StopFlag()
    waiting: set[Future[Any]] = set()
    left = iter(pieces)
    seen = _Workers(executor)
    try:
        while True:
            for piece in left:
                waiting.add(_submitted(function, piece, executor, stop))
                if len(waiting) >= WAITING_MOST:
                    break
            if not waiting:
                return
            done = wait(waiting, LOOK_EVERY, return_when=FIRST_COMPLETED).done
            for future in sorted(done, key=_failed):  # those last
                waiting.remove(future)
                refused, found = future.result()
                if refused:
                    raise InputError(_told(executor, f"has a worker that {refused}: {found}", stands()))
                yield found
            if seen.gone(bool(done)):
                raise InputError(_told(executor, f"has had no worker left for {GONE_MOST:g} s", stands()))
    except (InputError, MemoryError):
        raise
    except Exception as error:
        raise InputError(_told(executor, _died(error), stands())) from error
    finally:
        stop.set()
        for future in waiting:
            future.cancel()


def _submitted(function: Callable[[Any], Any], piece: Any, executor: Executor, stop: StopFlag) -> Future[Any]:
    if isinstance(executor, ThreadPoolExecutor):  # only threads of this process can heed a flag
        return executor.submit(_run_and_heed, function, piece, stop)
    given = {
        "program": WORKER,
        "space": {},
        "version": importlib.metadata.version("cogging"),
        "task": pickle.dumps((function, piece)),
        "call": uuid.uuid4().hex,  # Dask answers a call that equals an earlier one with what that gave, errors too
    }
    return executor.submit(eval, CALL, given)


def _run_and_heed(function: Callable[[Any], Any], piece: Any, stop: StopFlag) -> tuple[str, Any]:
    stop.heed()
    return "", function(piece)


def _failed(future: Future[Any]) -> bool:
    return future.cancelled() or future.exception() is not None or bool(future.result()[0])


class _Workers:
    """Whether workers that were there are all gone: a task of Dask waits for a new one without an end."""

    def __init__(self, executor: Executor) -> None:
        self._client = getattr(executor, "_client", None)  # of Dask's; it has no public name there
        self._last = float("inf")  # when there was one; before the first, as in a queue, there is no end

    def gone(self, worked: bool) -> bool:
        """Whether there has been none for so long that there will be none; one that has just worked is there."""
        if self._client is None or not hasattr(self._client, "nthreads"):
            return False
        try:
            if worked or self._client.nthreads():
                self._last = time.monotonic()
        except Exception:  # what has happened to it, its futures tell
            return False
        return time.monotonic() - self._last > GONE_MOST


def _died(error: Exception) -> str:
    what = ": ".join(filter(None, (type(error).__name__, str(error))))
    if isinstance(error, CancelledError):
        return "has cancelled a piece, as one does that was closed or has lost its scheduler"
    if isinstance(error, ImportError):
        return f"has a worker that cannot import the package: {what}"
    return f"{'has died' if isinstance(error, BrokenExecutor) else 'could not run a piece'}: {what}"


def _told(executor: Executor, what: str, stands: str) -> str:
    """One line about an executor that did not do its work."""
    return f"executor: {type(executor).__name__} {' '.join(what.split())}" + (f"; {stands}" if stands else "")
