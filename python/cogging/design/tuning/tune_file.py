"""Tune files: which gains are tuned, of which model, along which reference, within which limits."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cogging.design.tuning.tune import tune
from cogging.design.tuning.tuning import Tuning
from cogging.file_schema import TUNE, TUNE_NEEDED
from cogging.files import FieldError, read_text, read_toml
from cogging.outputs import AnyPath
from cogging.simulation.sweep import files_of_job, require_keys, run_job


def read_tune(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The arguments of `tune` that a tune file gives, paths of other files as seen from here.

    Raises:
        InputError: the file cannot be used; names file, line, field, rule and value.
    """
    document = read_toml(path)
    try:
        require_keys(document, TUNE, TUNE_NEEDED)
    except FieldError as error:
        raise error.in_file(path, read_text(path)) from None
    folder = Path(path).parent
    return {**document, **{key: folder / document[key] for key in ("model", "reference")}}


def files_of_tune(arguments: Mapping[str, Any], path: str | os.PathLike[str]) -> list[AnyPath]:
    """All that a tuning reads: the tune file, its model, its reference and what that names."""
    return files_of_job(arguments, path)


def run_tune(path: str | os.PathLike[str], arguments: Mapping[str, Any], **options: Any) -> Tuning:
    """Run what read_tune has read.

    Raises:
        InputError: what only the tuning itself can find; names the file, and the line where it stands in it.
    """
    return run_job(path, tune, arguments, options)
