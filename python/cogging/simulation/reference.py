"""Reference files: the motion of the axis."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cogging import _core
from cogging._core import Reference, Sampled
from cogging.calls import PATHS, check_arguments
from cogging.files import LARGEST, FieldError, errors_of, read_toml, refuse_mistyped, refuse_unknown_keys
from cogging.logs.columns import read_columns
from cogging.model.model import is_number, parameters_from
from cogging.shown import not_one_of, quoted

TYPES = tuple(_core.REFERENCES)
#: Parameter struct and class of each motion by its name in reference files, except the sampled one.
REFERENCES: dict[str, tuple[Any, Any]] = {
    name: (motion.PARAMETERS, motion) for name, motion in _core.REFERENCES.items() if motion is not Sampled
}
#: Fields of a sampled motion: a file, or the samples.
SAMPLED_KEYS = ("file", "time", "reference", "reference_velocity", "reference_acceleration")


@check_arguments(path=PATHS)
def read_reference(path: str | os.PathLike[str]) -> tuple[Reference, float]:
    """Read a reference file (TOML).

    Args:
        path: of the file.

    Returns:
        The motion, and the duration stated in the file, s; 0 if none is.

    Raises:
        InputError: the file is invalid; names file, line, field, rule and value.

    Example:
        >>> with open("sine.toml", "w") as file:
        ...     _ = file.write('type = "sine"\\namplitude = 0.02\\nduration = 3.0')
        >>> cogging.read_reference("sine.toml")
        (Sine(center=0 m, amplitude=0.02 m, frequency=1 Hz), 3.0)
    """
    with errors_of(path):
        return reference_from(read_toml(path), Path(path).parent)


def files_of_reference(path: str | os.PathLike[str]) -> list[str | os.PathLike[str]]:
    """Return a reference file and the file of samples that it names, if any."""
    file = read_toml(path).get("file")
    return [path, Path(path).parent / file] if isinstance(file, str) else [path]


def reference_from(document: Mapping[str, Any], folder: Path | None = None) -> tuple[Reference, float]:
    """Return the motion and duration (s) from the fields of a reference file; `folder` holds the `file` of samples."""
    fields = dict(document)
    refuse_mistyped(fields, "type", "")
    kind = fields.pop("type", None)
    if kind not in TYPES:
        raise FieldError("", "type", not_one_of(kind, TYPES))
    duration = fields.pop("duration", 0.0)
    if not is_number(duration) or not 0 <= duration < 1e9:
        raise FieldError("", "duration", f"must be a number of seconds from 0 to 1e9, got {quoted(duration)}")
    if kind == "sampled":
        return _sampled(fields, folder or Path()), float(duration)
    struct, made = REFERENCES[kind]
    motion: Reference = made(parameters_from(struct, fields, ""))
    if not duration and not math.isfinite(motion.end):
        raise FieldError("", "duration", "must be given for a motion without an end, got none")
    return motion, float(duration)


def motion_of(reference: Reference | Mapping[str, Any] | str | os.PathLike[str]) -> tuple[Reference, float]:
    """Return the motion that a user gave in any form, and the duration that its file states, s; 0 if none is."""
    if isinstance(reference, Reference):
        return reference, 0.0
    return reference_from(reference) if isinstance(reference, Mapping) else read_reference(reference)


def reference_to_dict(reference: Reference) -> dict[str, Any]:
    """Return the fields of a reference file for a motion, those of a sampled one as arrays."""
    if isinstance(reference, Sampled):
        return {"type": "sampled", **reference.samples}
    for kind, (_, motion) in REFERENCES.items():
        if isinstance(reference, motion):
            return {"type": kind, **reference.parameters.to_dict()}
    raise TypeError(f"reference: must be one of {', '.join(TYPES)}, got {type(reference).__name__}")


def _sampled(fields: Mapping[str, Any], folder: Path) -> Reference:
    refuse_unknown_keys(fields, SAMPLED_KEYS, "")
    names, file, source = SAMPLED_KEYS[1:], fields.get("file"), ""
    table: Mapping[str, Any]
    if file is None and "time" in fields:
        table = {name: _column(name, values) for name, values in fields.items()}
        if "reference" not in table:
            raise FieldError("", "reference", "must be given with time, got nothing")
    elif not isinstance(file, str):
        raise FieldError("", "file", f"must name a CSV file, got {quoted(file)}")
    elif len(fields) > 1:
        raise FieldError("", "file", f"must be given without samples, got {', '.join(fields)}")
    else:
        table, source = read_columns(folder / file, names[:2], optional=names[2:]), f"{file}: "
    try:
        return Sampled(table["time"], table["reference"], *map(table.get, names[2:]))
    except ValueError as error:
        raise FieldError("", "file" if source else "time", f"{source}{error}") from None


def _column(name: str, values: Any) -> Any:
    if isinstance(values, np.ndarray):
        return values
    if not (isinstance(values, list) and all(is_number(value) and abs(value) <= LARGEST for value in values)):
        raise FieldError("", name, f"must be a list of numbers of at most {LARGEST:g} in size")
    return np.array(values, dtype=np.float64)
