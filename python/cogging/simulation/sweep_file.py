"""Sweep files: which runs are made, of which model, along which reference; and what they share with tune files."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from cogging.files import FieldError, InputError, read_text, read_toml, refuse_unknown_keys
from cogging.model.model import is_number
from cogging.outputs import AnyPath
from cogging.shown import nearest, quoted
from cogging.simulation.reductions import names_of, reduction
from cogging.simulation.reference import files_of_reference
from cogging.simulation.sweep import SweepRuns, sweep
from cogging.simulation.varied import BOUNDS, METHODS, require_numbers
from cogging.simulation.varied import KEYS as VARIATION

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
    """The arguments of `sweep` that a sweep file gives, paths of other files as seen from here."""
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
    """Run what read_sweep has read."""
    return run_job(path, sweep, arguments, options)


def _require(document: Mapping[str, Any]) -> None:
    """Refuse a document that is no sweep."""
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
    """Refuse names that no file has."""
    for key in ("model", "reference"):
        if not (folder / document[key]).exists() or not document[key]:
            raise FieldError("", key, f"must be a file beside the sweep file, got {quoted(document[key])}")


def _by_path(vary: Mapping[str, Any]) -> dict[str, Any]:
    """Variations by path."""
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


WORDS = {str: "a text", int: "a whole number", float: "a number", list: "a list of names", dict: "a section"}

Result = TypeVar("Result")


def require_keys(document: Mapping[str, Any], keys: Mapping[str, tuple[type, str]], needed: tuple[str, ...]) -> None:
    """Refuse a document with another key, without one that is needed, or with one of another type.

    Args:
        document: of the file.
        keys: type and meaning of each.
        needed: those that must be given.
    """
    refuse_unknown_keys(document, keys, "")
    for key in needed:
        if key not in document:
            raise FieldError("", key, "must be given, got nothing")
    for key, value in document.items():
        kind = keys[key][0]
        fits = is_number(value) if kind in (int, float) else isinstance(value, kind)
        if (kind is int and not isinstance(value, int)) or not (fits or (key == "vary" and value == BOUNDS)):
            what = f'{WORDS[kind]} or "{BOUNDS}"' if key == "vary" else WORDS[kind]
            raise FieldError("", key, f"must be {what}, got {quoted(value)}")


def files_of_job(arguments: Mapping[str, Any], path: str | os.PathLike[str]) -> list[AnyPath]:
    """All that it reads: the file, its model, its reference and what that names."""
    return [path, arguments["model"], *files_of_reference(arguments["reference"])]


def run_job(
    path: str | os.PathLike[str], work: Callable[..., Result], arguments: Mapping[str, Any], options: Mapping[str, Any]
) -> Result:
    """Call `work` with what the file gives and with further options."""
    try:
        return work(**{**arguments, **options})
    except InputError:
        raise
    except FieldError as error:
        raise error.in_file(path, read_text(path)) from None
    except ValueError as error:
        raise InputError(f"{path}: {error}") from None
