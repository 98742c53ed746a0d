"""Indexes and reductions of runs by name, and batches of runs in the core."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from cogging import _core
from cogging.arrays import FloatArray
from cogging.calls import did_you_mean
from cogging.files import FieldError
from cogging.logs.log import COLUMN_UNITS, OPTIONAL, REQUIRED, TRUE
from cogging.shown import quoted

#: Fields of Performance, computed for every run.
INDEXES = ("error_max", "error_rms", "error_final_max", "command_rms", "command_change_rms", "command_chatter")
QUANTITIES = ("true_error", "error", "command")
PLAIN = ("max", "rms", "final")
NUMBERED = ("quantile", "tone", "wave")
NAMED = re.compile(rf"({'|'.join(QUANTITIES)})_(?:({'|'.join(PLAIN)})|({'|'.join(NUMBERED)})\(([^()]+)\))")
COLUMNS = (*REQUIRED, *OPTIONAL, *TRUE)
#: Units by name; every other reduction has the unit of its quantity.
UNITS = {**COLUMN_UNITS, "command_chatter": "1", "failed_at": "s"}


class Failed(NamedTuple):
    """A run that failed."""

    run: int  # its number in the batch
    time: float  # s, when it failed; NaN if it did not start
    reason: str  # in one line


class Kept(NamedTuple):
    """Results of runs in the core: values (runs, indexes and reductions), failures, columns of each run."""

    values: FloatArray
    failures: tuple[Failed, ...]
    columns: dict[str, list[FloatArray]]
    in_lanes: tuple[bool, ...]


def reduction(name: str) -> tuple[str, str, float]:
    """Return quantity, kind and number of a reduction such as `error_quantile(0.95)`."""
    found = NAMED.fullmatch(name) if isinstance(name, str) else None
    if found is None:
        known = [f"{quantity}_{kind}" for quantity in QUANTITIES for kind in PLAIN]
        known += [f"{quantity}_{kind}(number)" for quantity in QUANTITIES for kind in NUMBERED]
        raise FieldError("", "reductions", f"{quoted(name)} is unknown; {did_you_mean(name, known)}")
    quantity, plain, numbered, text = found.groups()
    try:
        number = float(text) if text else 0.0
    except ValueError:
        problem = f"{name}: must have a number in its brackets, got {quoted(text)}"
        raise FieldError("", "reductions", problem) from None
    if numbered == "quantile" and not 0.0 <= number <= 1.0:
        raise FieldError("", "reductions", f"{name}: quantile: must be from 0 to 1, got {number:g}")
    if numbered and numbered != "quantile" and not 0.0 < number < math.inf:
        what = "frequency" if numbered == "tone" else "period"
        raise FieldError("", "reductions", f"{name}: {what}: must be finite and above 0, got {number:g}")
    return quantity, plain or numbered, number


def unit_of(name: str) -> str:
    """Return the unit of an index, a reduction or a column; empty for other names and for texts."""
    if name in UNITS:
        return UNITS[name]
    if name in INDEXES or NAMED.fullmatch(name):
        return "V" if name.startswith("command") else "m"
    return ""


def names_of(reductions: Iterable[str]) -> tuple[str, ...]:
    """Return the names of all values of a run: the indexes, then the further reductions, each once."""
    names = (*INDEXES, *(name for name in reductions if name not in INDEXES))
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise FieldError("", "reductions", f"must be listed once each, got {twice} twice")
    return names


def kept_of_runs(
    plants: Sequence[Any],
    controllers: Sequence[Any],
    references: Sequence[Any],
    *,
    window: tuple[float, float, float] = (-np.inf, np.inf, 2.0),
    reductions: Sequence[str] = (),
    columns: Sequence[str] = (),
    **options: Any,
) -> Kept:
    """Return the results of runs in the core; arguments as of closed_loop_batch.

    `references` and the options `durations`, `steps_per_sample`, `initial_positions` have one entry for each run or one
    for all; `keeps_refused` reports a run that cannot start as a failure; memory must suffice for `runs_in_all` runs.
    """
    start, stop, final_window = window
    kept: dict[str, Any] = _core.closed_loop_records(
        plants,
        controllers,
        references,
        start=start,
        stop=stop,
        final_window=final_window,
        reductions=[reduction(name) for name in names_of(reductions)[len(INDEXES) :]],
        columns=list(columns),
        **{"threads": 0, "every": 1, "keeps_refused": False, **options},
    )
    failures = tuple(Failed(*failure) for failure in kept["failures"])
    by_column = dict(zip(columns, kept["columns"], strict=True))
    return Kept(kept["values"], failures, by_column, tuple(kept["in_lanes"]))
