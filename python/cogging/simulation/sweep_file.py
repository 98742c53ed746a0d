"""Sweep files: which runs are made, of which model, along which reference."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from cogging.files import FieldError, read_text, read_toml
from cogging.outputs import AnyPath
from cogging.shown import nearest, quoted
from cogging.simulation.job_file import files_of_job, require_keys, run_job
from cogging.simulation.reductions import names_of, reduction
from cogging.simulation.sweep import SweepRuns, sweep
from cogging.simulation.sweep_points import BOUNDS, METHODS, require_numbers
from cogging.simulation.sweep_points import KEYS as VARIATION

#: The keys of a sweep file: type and meaning.
KEYS: dict[str, tuple[type, str]] = {
    "model": (str, "model file, beside the sweep file"),
    "reference": (str, "reference file, beside the sweep file"),
    "method": (str, "grid (all combinations), random, latin_hypercube or sobol; default grid"),
    "runs": (int, "how many, but for a grid; default 1000"),
    "seed": (int, "of draws and noise: run i has the noise of seed + i; default 0"),
    "duration": (float, "s; default that of the reference"),
    "start": (float, "s; indexes look at the rows from then on"),
    "stop": (float, "s; indexes look at the rows before"),
    "final_window": (float, "s, of error_final_max; default 2"),
    "reductions": (list, "beside the indexes, such as error_quantile(0.95), command_max, error_tone(3.0)"),
    "vary": (dict, 'how each number is varied, by path; or "bounds": all that the model has [bounds] for'),
}
NEEDED = ("model", "reference", "vary")


def read_sweep(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The arguments of `sweep` that a sweep file gives, paths of other files as seen from here.

    Raises:
        InputError: the file cannot be used; names file, line, field, rule and value.
    """
    document = read_toml(path)
    try:
        _require(document)
        _require_files(document, Path(path).parent)
        vary = document["vary"] if document["vary"] == BOUNDS else _by_path(document["vary"])
    except FieldError as error:
        raise error.in_file(path, read_text(path)) from None
    files = {key: Path(path).parent / document[key] for key in ("model", "reference")}
    return {**document, **files, "vary": vary}


def files_of_sweep(arguments: Mapping[str, Any], path: str | os.PathLike[str]) -> list[AnyPath]:
    """All that a sweep reads: the sweep file, its model, its reference and what that names."""
    return files_of_job(arguments, path)


def run_sweep(path: str | os.PathLike[str], arguments: Mapping[str, Any], **options: Any) -> SweepRuns:
    """Run what read_sweep has read.

    Raises:
        InputError: what only the sweep itself can find; names the file, and the line where it stands in it.
    """
    return run_job(path, sweep, arguments, options)


def _require(document: Mapping[str, Any]) -> None:
    """Refuse a document that is no sweep.

    Raises:
        FieldError: names field, rule and value.
    """
    require_keys(document, KEYS, NEEDED)
    if document.get("method", "grid") not in METHODS:
        got = f"{quoted(document['method'])}{nearest(str(document['method']), METHODS)}"
        raise FieldError("", "method", f"must be one of {', '.join(METHODS)}, got {got}")
    window = (document.get("start", -math.inf), document.get("stop", math.inf), document.get("final_window", 2.0))
    require_numbers(document.get("seed", 0), document.get("runs", 1), document.get("duration", 0.0), window)
    for name in document.get("reductions", ()):
        if not isinstance(name, str):
            raise FieldError("", "reductions", f"must be names, got {quoted(name)}")
        try:
            reduction(name)
            names_of(document["reductions"])
        except ValueError as error:
            raise FieldError("", "reductions", str(error).removeprefix("reductions: ")) from None


def _require_files(document: Mapping[str, Any], folder: Path) -> None:
    """Refuse names that no file has.

    Raises:
        FieldError: names the first.
    """
    for key in ("model", "reference"):
        if not (folder / document[key]).exists() or not document[key]:
            raise FieldError("", key, f"must be a file beside the sweep file, got {quoted(document[key])}")


def _by_path(vary: Mapping[str, Any]) -> dict[str, Any]:
    """Variations by path.

    Raises:
        FieldError: one path has two.
    """
    found: dict[str, Any] = {}
    for path, told in _flat(vary):
        if path in found:
            raise FieldError("vary", path, f"must be given once, got {quoted(found[path])} and {quoted(told)}")
        found[path] = told
    return found


def _flat(vary: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Variations by path, also where TOML has made sections of paths without quotes (`axis.mass = [0.1, 0.2]`)."""
    for name, told in vary.items():
        if isinstance(told, Mapping) and told and not set(told) & set(VARIATION):
            yield from _flat(told, f"{before}{name}.")
        else:
            yield f"{before}{name}", told
