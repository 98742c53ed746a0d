"""Drafting a first model from a log as its owner has it."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from cogging.calls import PATH, Kind, takes
from cogging.files import InputError
from cogging.first_model.column_guess import ColumnGuesses
from cogging.first_model.columns import guess_columns
from cogging.first_model.model_draft import ModelDraft
from cogging.first_model.moves import motion_of_log
from cogging.first_model.pitch import strongest_wave
from cogging.first_model.sizes import sizes_of
from cogging.first_model.units import LIKELY, UNKNOWN
from cogging.log_check.audit import audit
from cogging.log_check.hints import hints
from cogging.log_check.recovery import recover_controller
from cogging.log_check.time_base import on_its_clock
from cogging.logs.log import Log, read_log, require_sizes, units_beside
from cogging.model.units import UNIT_KEYS, Units
from cogging.resources import on_one_blas_thread

FILE = Kind((Log, *PATH), "a Log or the path of a log file")
ROWS_OF_CONTROLLER = 50_000  # in which its gains are sought
FEWEST = 10  # rows


@takes(log=FILE)
@np.errstate(all="ignore")  # wild numbers lead to sizes that are not told
@on_one_blas_thread(scipy=True)
def draft_model(
    log: Log | str | os.PathLike[str],
    *,
    columns: Mapping[str, str] | None = None,
    scale: Mapping[str, float] | None = None,
    rows: slice | None = None,
) -> ModelDraft:
    """Look at a log as its owner has it, and draft a model and a reference of the axis that made it.

    Columns are known by their names in English or German, or by how their numbers behave; units by the header's words
    or by what axes do; mass and friction by least squares of the force balance; each guess is said with its reason,
    and so is what cannot be told. Nothing here is a fit: `identify` is, and starts from the drafted model.

    Args:
        log: a Log, or a file of any format that logs have (see read_log), with columns of any names.
        columns: names in the file that are known, by the names of a log: `{"position": "qm"}`.
        scale: factors that are known, by the names of a log.
        rows: the data rows to take, from 0.

    Returns:
        The draft; print its `text()`, and `write` it.

    Raises:
        InputError: the file cannot be read, or which column is the time, the position or the command cannot be told.
        ValueError: a log in memory of fewer than ten rows, or one whose numbers are of no machine.

    Example:
        >>> log.write("run.csv")
        >>> draft = cogging.draft_model("run.csv")
        >>> draft.write("first.toml", "motion.toml")
        ['first.toml', 'motion.toml']
        >>> cogging.Model.read("first.toml").axis.mass == draft.model.axis.mass
        True
    """
    if isinstance(log, Log):
        return _drafted("log", log, None, {}, rows)
    guesses = guess_columns(log, columns or {}, scale or {}, rows, units_beside(log))
    read = read_log(log, columns=guesses.columns, scale=guesses.scale, rows=rows)
    try:
        return _drafted(os.fspath(log), read, guesses, guesses.scale, rows)
    except ValueError as error:
        raise error if isinstance(error, InputError) else InputError(f"{log}: {error}") from None


def _drafted(
    source: str, log: Log, guesses: ColumnGuesses | None, scale: Mapping[str, float], rows: slice | None
) -> ModelDraft:
    """The draft of a log that was read."""
    if len(log) < FEWEST:
        raise ValueError(f"rows: must be at least {FEWEST} to draft a model from, got {len(log)}")
    require_sizes(log)
    units = log.units
    if guesses is not None:
        units = Units(**{name: guesses.used[name].unit.label for name in UNIT_KEYS})
    stamps, (log, clock) = log.time, on_its_clock(log)
    sizes = sizes_of(log, units)
    unsure = [*_guessed(guesses, UNKNOWN), *(guesses.notes if guesses is not None else ())]
    if sizes.reversed:
        log = Log.of({**log.columns(), "command": -log.command}, log.metadata)
        scale = {**scale, "command": -scale.get("command", 1.0)}
        unsure.append("which of command and position has the wrong sign: one of them has; the command is turned here")
    found = audit(replace(log, time=stamps))
    seen, quantum = (log.position, found.encoder_quantum) if log.reference is None else (log.reference, 0.0)
    motion = motion_of_log(log.time, seen, quantum, units)
    controller = recover_controller(_beginning(log))
    waves = (strongest_wave(*residual, found.command_rms) for residual in sizes.residuals)
    draft = ModelDraft(
        source=source,
        log=log,
        columns=guesses,
        audit=replace(found, units=units),
        motion=motion,
        seen_in="position" if log.reference is None else "reference",
        sizes=sizes,
        wave=next(filter(None, waves), None),
        controller=controller and controller._replace(units=units),
        units=units,
        scale=dict(scale),
        rows=rows,
        likely=(*_guessed(guesses, LIKELY), *([clock] if clock else ())),
        unsure=(),
    )
    unsure += [f"{name}: {size.told}" for name, size in sizes.sizes.items() if size.uncertainty is None]
    unsure += hints(found, draft.model)
    return replace(draft, unsure=tuple(unsure))


def _beginning(log: Log) -> Log:
    """As many rows as tell a controller's gains."""
    if len(log) <= ROWS_OF_CONTROLLER:
        return log
    return Log.of({name: column[:ROWS_OF_CONTROLLER] for name, column in log.columns().items()})


def _guessed(guesses: ColumnGuesses | None, sure: str) -> list[str]:
    """What was guessed of the columns and their units, as sure as that."""
    if guesses is None:
        return []
    said = [f"{g.name}: {g.unit.told}" for g in guesses.used.values() if g.unit.sure == sure]
    return said + [f"{g.name}: it is {g.label!r}, {g.told}" for g in guesses.used.values() if g.sure == sure]
