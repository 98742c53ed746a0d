"""Files that ask for many runs, of a sweep or a tuning: what they have in common."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from cogging.files import FieldError, InputError, read_text, refuse_unknown_keys
from cogging.model.model import is_number
from cogging.outputs import AnyPath
from cogging.shown import quoted
from cogging.simulation.reference import files_of_reference
from cogging.simulation.sweep_points import BOUNDS

WORDS = {str: "a text", int: "a whole number", float: "a number", list: "a list of names", dict: "a section"}

Result = TypeVar("Result")


def require_keys(document: Mapping[str, Any], keys: Mapping[str, tuple[type, str]], needed: tuple[str, ...]) -> None:
    """Refuse a document with another key, without one that is needed, or with one of another type.

    Args:
        document: of the file.
        keys: type and meaning of each.
        needed: those that must be given.

    Raises:
        FieldError: names field, rule and value.
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
    """Call `work` with what the file gives and with further options.

    Raises:
        InputError: what only the work itself can find; names the file, and the line where it stands in it.
    """
    try:
        return work(**{**arguments, **options})
    except InputError:
        raise
    except FieldError as error:
        raise error.in_file(path, read_text(path)) from None
    except ValueError as error:
        raise InputError(f"{path}: {error}") from None
