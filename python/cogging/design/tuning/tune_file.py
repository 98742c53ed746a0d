"""Tune files: which gains are tuned, of which model, along which reference, within which limits."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cogging.design.tuning.machines import BOUNDS
from cogging.design.tuning.tune import tune
from cogging.design.tuning.tuning import Tuning
from cogging.file_schema import TUNE, TUNE_NEEDED
from cogging.files import FieldError, InputError, read_text, read_toml, refuse_unknown_keys
from cogging.model.model import is_number
from cogging.outputs import AnyPath
from cogging.shown import quoted
from cogging.simulation.reference import files_of_reference

WORDS = {str: "a text", int: "a whole number", float: "a number", dict: "a section"}


def read_tune(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The arguments of `tune` that a tune file gives, paths of other files as seen from here.

    Raises:
        InputError: the file cannot be used; names file, line, field, rule and value.
    """
    document = read_toml(path)
    try:
        _require(document)
    except FieldError as error:
        raise error.in_file(path, read_text(path)) from None
    folder = Path(path).parent
    return {**document, **{key: folder / document[key] for key in ("model", "reference")}}


def files_of_tune(arguments: Mapping[str, Any], path: str | os.PathLike[str]) -> list[AnyPath]:
    """All that a tuning reads: the tune file, its model, its reference and what that names."""
    return [path, arguments["model"], *files_of_reference(arguments["reference"])]


def run_tune(path: str | os.PathLike[str], arguments: Mapping[str, Any], **options: Any) -> Tuning:
    """Run what read_tune has read.

    Raises:
        InputError: what only the tuning itself can find; names the file, and the line where it stands in it.
    """
    try:
        return tune(**{**arguments, **options})
    except InputError:
        raise
    except FieldError as error:
        raise error.in_file(path, read_text(path)) from None
    except ValueError as error:
        raise InputError(f"{path}: {error}") from None


def _require(document: Mapping[str, Any]) -> None:
    """Refuse a document that is no tuning.

    Raises:
        FieldError: names field, rule and value.
    """
    refuse_unknown_keys(document, TUNE, "")
    for key in TUNE_NEEDED:
        if key not in document:
            raise FieldError("", key, "must be given, got nothing")
    for key, value in document.items():
        kind = TUNE[key][0]
        fits = is_number(value) if kind in (int, float) else isinstance(value, kind)
        if (kind is int and not isinstance(value, int)) or not (fits or (key == "vary" and value == BOUNDS)):
            raise FieldError("", key, f"must be {WORDS[kind]}, got {quoted(value)}")
