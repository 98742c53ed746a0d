"""Fit the parameters of a model to measured logs."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from cogging.calls import check_arguments
from cogging.identification.identification_result import Identification
from cogging.identification.logged_run import LoggedRun
from cogging.identification.misreading import misreading
from cogging.identification.parameter_fit import ParameterFit
from cogging.log_check.log_audit import hints
from cogging.logs.log import Log, read_log, require_sizes
from cogging.logs.pauses import running_time
from cogging.logs.repeated_rows import counted_once
from cogging.model.model import Model
from cogging.model.parameters import parameters_of, role_of
from cogging.model.units import Units
from cogging.progress import Progress
from cogging.resources import on_one_blas_thread, require_rows
from cogging.shown import nearest
from cogging.simulation.arguments import LOGS, MODEL

FEWEST_ROWS = 200
CUTOFFS = (80.0, 40.0, 20.0, 10.0)  # Hz; the first at which reading noise does not dominate is used


@check_arguments(logs=LOGS, model=MODEL)
@np.errstate(all="ignore")  # extreme values are refused where they are used
@on_one_blas_thread(scipy=True)
def identify(
    logs: Log | str | os.PathLike[str] | Sequence[Log | str | os.PathLike[str]],
    model: Model | str | os.PathLike[str],
    *,
    free: Sequence[str] | None = None,
    cutoff: float | None = None,
    rest: float | None = None,
    added_commands: Sequence[npt.ArrayLike | None] | None = None,
    names: Sequence[str] | None = None,
    progress: Progress = False,
) -> Identification:
    """Fit the parameters of a model to one or several logs together. Rows that several of them share count once.

    Two estimators are used. Inverse dynamics with instruments from a simulated run is reported: it is robust against
    model errors. The whitened output error of the closed-loop replay (else of the one-step prediction) is the check; it
    is reported instead where a second mass, a friction state or a free parameter is outside the force balance.

    A parameter that the logs do not determine (1-sigma above a fifth of its size with all others free) keeps its prior
    and gets an infinite interval; the intervals of the others allow for it. Where unmodelled forces exceed 5 % of the
    command, or the residual four times the noise, or the two estimators contradict each other, a parameter keeps its
    prior unless all answers exclude it, and its interval covers those of both estimators, those beside unmodelled
    forces, and those with the residual as coloured noise. `cogging diagnose` is the next step.

    Jittering time stamps are replaced by an even clock if the readings are smoother on it.

    Args:
        logs: one or several, or their files.
        model: the prior, or its file.
        free: paths of the parameters to fit (`parameters_of` lists them). None: all but settings, places of nodes,
            those that are not finite, those with an uncertainty of 0, and `axis.coulomb_width` where it is 0.
        cutoff: of the inverse dynamics' filter, Hz; None: the highest of 80, 40, 20 and 10 Hz at which encoder noise
            does not dominate the residual.
        rest: rows slower than this do not count, m/s; None: 2 % of the largest speed.
        added_commands: for each log, what was added to its controller's command, V, (n,), or None.
        names: of the logs, for the text.
        progress: True shows a bar; a function receives the name of each stage.

    Returns:
        The fitted model, its parameters with intervals, and which parameters the logs do not determine.

    Raises:
        InputError: a file that cannot be used, a log whose units cannot be those of the model.
        ValueError: an unknown free parameter, no logs, a log that is too short or at rest, an invalid cut-off or rest.

    Example:
        >>> prior = model.replace(axis=model.axis.replace(mass=0.1))
        >>> found = cogging.identify(log, prior, free=["axis.mass", "axis.viscous"])
        >>> print(f"{found['axis.mass'].value:.3f} V/(m/s^2), determined: {found['axis.mass'].determined}")
        0.120 V/(m/s^2), determined: True
    """
    if not isinstance(model, Model):
        model = Model.read(model)
    given = [logs] if isinstance(logs, Log | str | os.PathLike) else list(logs)
    if not given:
        raise ValueError("logs: must be at least 1, got 0")
    called = list(names or [f"log {i + 1}" if isinstance(g, Log) else os.fspath(g) for i, g in enumerate(given)])
    added: list[npt.ArrayLike | None] = list(added_commands or [None] * len(given))
    for field, entries in (("names", called), ("added_commands", added)):
        if len(entries) != len(given):
            raise ValueError(f"{field}: must be one for each of {len(given)} logs, got {len(entries)}")
    paths = _paths(model, free)
    read = [log if isinstance(log, Log) else read_log(log) for log in given]
    require_rows("identify", read, len(paths))
    for name, log in zip(called, read, strict=True):
        _require_motion(name, log, model.units)
    rate = 1.0 / max(float(np.median(np.diff(log.time))) for log in read)
    for name, log, entry in zip(called, read, added, strict=True):
        if entry is not None and np.shape(entry) != (len(log),):
            raise ValueError(f"added_commands: {name}: must have shape ({len(log)},), got {np.shape(entry)}")
    read, kept, notes = counted_once(read, called, FEWEST_ROWS)
    added = [e if e is None else np.asarray(e)[rows] for e, rows in zip(added, kept, strict=True) if rows.any()]
    called = [name for name, rows in zip(called, kept, strict=True) if rows.any()]
    if cutoff is not None and not 0.0 < cutoff <= 0.2 * rate:
        raise ValueError(f"cutoff: must be above 0 and at most a fifth of {rate:g} rows a second, got {cutoff:g}")
    cutoffs = [cutoff] if cutoff is not None else [c for c in CUTOFFS if c <= 0.1 * rate] or [0.1 * rate]
    if rest is not None and not 0.0 <= rest < np.inf:
        raise ValueError(f"rest: must be at least 0, got {rest:g}")
    misread = misreading(read, model, called)
    notes = notes if misread is None else (*notes, misread.text)
    runs = [LoggedRun.of(*entry) for entry in zip(read, [model] * len(read), called, added, strict=True)]
    notes = (*notes, *(run.repairs for run in runs if run.repairs))
    notes = (*notes, *(f"{run.name}: {hint}" for run in runs for hint in hints(run.audit, model)))
    return replace(ParameterFit(model, runs, paths, cutoffs, rest).run(progress), notes=notes)


def _paths(model: Model, free: Sequence[str] | None) -> list[str]:
    """Return the paths of the free parameters, checked."""
    known = parameters_of(model)
    exact = {f"axis.{name}" for name, sigma in model.uncertainty.items() if sigma == 0.0}
    exact |= {"axis.coulomb_width"} if model.axis.coulomb_width == 0.0 else set()
    if free is None:
        roles = {path: role_of(model, path) for path in known}
        nodes = {path for path, role in roles.items() if role == "shape" and path.endswith("]")}  # a choice
        left_out = exact | nodes | {path for path, role in roles.items() if role == "setting"}
        free = [path for path, one in known.items() if path not in left_out and np.isfinite(one.value)]
    for path in free:
        if path not in known:
            raise ValueError(f"free: {path}: must be one of {', '.join(known)}{nearest(path, known)}")
        if role_of(model, path) == "setting":
            raise ValueError(f"free: {path}: must be a parameter that a fit may move, got a setting")
        if not np.isfinite(known[path].value):
            raise ValueError(f"free: {path}: must start from a finite value, got {known[path].value:g}")
        if path == "axis.coulomb_width" and known[path].value == 0.0:
            raise ValueError(f"free: {path}: must start above 0 to be fitted, got 0, which is another friction law")
    if not free:
        raise ValueError("free: must name at least one parameter, got none")
    return list(dict.fromkeys(free))


def _require_motion(name: str, log: Log, units: Units) -> None:
    if len(log) < FEWEST_ROWS:
        raise ValueError(f"{name}: rows: must be at least {FEWEST_ROWS} to fit a model, got {len(log)}")
    if log.position.max() == log.position.min():
        raise ValueError(f"{name}: position: must move, got {log.position[0]:g} {units.position} in every row")
    if not np.any(log.command):
        raise ValueError(f"{name}: command: must act on an axis that moves, got 0 {units.command} in every row")
    try:
        require_sizes(log)
        running_time(log.time)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None
