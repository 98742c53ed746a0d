"""What a run of a batch is reduced to, by name, and the runs of a batch in the core."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from cogging import _core
from cogging.arrays import FloatArray
from cogging.calls import did_you_mean
from cogging.shown import quoted

#: The fields of Performance, which every run has.
INDEXES = (
    "error_max",
    "error_rms",
    "error_final_max",
    "command_rms",
    "command_change_rms",
    "command_chatter",
)
QUANTITIES = ("true_error", "error", "command")
PLAIN = ("max", "rms", "final")
NUMBERED = ("quantile", "tone", "wave")
NAMED = re.compile(rf"({'|'.join(QUANTITIES)})_(?:({'|'.join(PLAIN)})|({'|'.join(NUMBERED)})\(([^()]+)\))")
COLUMNS = (
    "time",
    "position",
    "command",
    "reference",
    "reference_velocity",
    "reference_acceleration",
    "true_position",
    "true_velocity",
)
#: Of what a table of runs holds under these names; every other reduction is in the unit of its quantity.
UNITS = {
    "time": "s",
    "reference_velocity": "m/s",
    "reference_acceleration": "m/s^2",
    "true_velocity": "m/s",
    "command_chatter": "1",
    "failed_at": "s",
}


class Failed(NamedTuple):
    """A run that did not come to its end.

    Attributes:
        run: its place in the batch.
        time: s, when; NaN where it did not begin.
        reason: in one line.
    """

    run: int
    time: float
    reason: str


class Kept(NamedTuple):
    """What the core keeps of runs: values (runs, indexes and reductions), failures, columns of each run."""

    values: FloatArray
    failures: tuple[Failed, ...]
    columns: dict[str, list[FloatArray]]
    in_lanes: tuple[bool, ...]


def reduction(name: str) -> tuple[str, str, float]:
    """Quantity, kind and number of a reduction by its name, such as `error_quantile(0.95)`."""
    found = NAMED.fullmatch(name)
    if found is None:
        known = [f"{quantity}_{kind}" for quantity in QUANTITIES for kind in PLAIN]
        known += [f"{quantity}_{kind}(number)" for quantity in QUANTITIES for kind in NUMBERED]
        raise ValueError(f"reductions: {quoted(name)} is none; {did_you_mean(name, known)}")
    quantity, plain, numbered, text = found.groups()
    try:
        number = float(text) if text else 0.0
    except ValueError:
        raise ValueError(f"reductions: {name}: must have a number in its brackets, got {quoted(text)}") from None
    if numbered == "quantile" and not 0.0 <= number <= 1.0:
        raise ValueError(f"reductions: {name}: quantile: must be from 0 to 1, got {number:g}")
    if numbered and numbered != "quantile" and not 0.0 < number < math.inf:
        what = "frequency" if numbered == "tone" else "period"
        raise ValueError(f"reductions: {name}: {what}: must be finite and above 0, got {number:g}")
    return quantity, plain or numbered, number


def unit_of(name: str) -> str:
    """The unit of an index, a reduction or a column; nothing where it has none, or is none of them."""
    if name in UNITS:
        return UNITS[name]
    if name in COLUMNS or name in INDEXES or NAMED.fullmatch(name):
        return "V" if name.startswith("command") else "m"
    return ""


def names_of(reductions: Iterable[str]) -> tuple[str, ...]:
    """The names of all that is kept of a run: the indexes, then what else was asked for."""
    names = (*INDEXES, *(name for name in reductions if name not in INDEXES))
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"reductions: must be asked for once each, got {name} twice")
    return names


def require_reductions(names: Sequence[str]) -> None:
    """Refuse names that are no reductions before anything runs."""
    for name in names_of(names)[len(INDEXES) :]:
        reduction(name)


def kept_of_runs(
    plants: Sequence[Any],
    controllers: Sequence[Any],
    references: Sequence[Any],
    *,
    durations: Sequence[float],
    seeds: Sequence[int],
    steps_per_sample: Sequence[int],
    threads: int = 0,
    window: tuple[float, float, float] = (-np.inf, np.inf, 2.0),
    reductions: Sequence[str] = (),
    columns: Sequence[str] = (),
    every: int = 1,
    keeps_refused: bool = False,
    **starts: Any,
) -> Kept:
    """Run in the core; the arguments as closed_loop_batch takes them, with one reference, duration and number of steps
    for all runs or one for each. With `keeps_refused`, a run that cannot begin is a failure among the others.
    `starts`: `initial_positions` (m, one for all, one for each or none), and of all runs `initial_velocity` and
    `added_command` (a list), as closed_loop takes them; `runs_in_all`, of how many as much will be kept."""
    further = names_of(reductions)[len(INDEXES) :]
    start, stop, final_window = window
    kept: dict[str, Any] = _core.closed_loop_records(
        plants,
        controllers,
        references,
        durations=durations,
        seeds=seeds,
        steps_per_sample=steps_per_sample,
        threads=threads,
        start=start,
        stop=stop,
        final_window=final_window,
        reductions=[reduction(name) for name in further],
        columns=list(columns),
        every=every,
        keeps_refused=keeps_refused,
        **starts,
    )
    failures = tuple(Failed(*failure) for failure in kept["failures"])
    by_column = dict(zip(columns, kept["columns"], strict=True))
    return Kept(kept["values"], failures, by_column, tuple(kept["in_lanes"]))
