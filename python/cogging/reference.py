"""Reference files: what the axis is asked to do."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cogging._core import (
    FilteredSine,
    FilteredSineParameters,
    PointToPoint,
    PointToPointParameters,
    Reference,
    Sampled,
    Sine,
    SineParameters,
)
from cogging.files import FieldError, read_text, read_toml, refuse_unknown_keys
from cogging.logs import read_columns
from cogging.model import parameters_from

#: Motions by the name that a reference file gives them: parameter struct and class.
REFERENCES: dict[str, tuple[Any, Any]] = {
    "point_to_point": (PointToPointParameters, PointToPoint),
    "sine": (SineParameters, Sine),
    "filtered_sine": (FilteredSineParameters, FilteredSine),
}
TYPES = (*REFERENCES, "sampled")


def read_reference(path: str | os.PathLike[str]) -> tuple[Reference, float]:
    """Read a reference file (TOML): the motion and its `duration` (s; 0 = the motion's own end).

    Raises:
        InputError: the file cannot be used; names file, line, field, rule and value.
    """
    document = read_toml(path)
    try:
        return reference_from(document, Path(path).parent)
    except FieldError as error:
        raise error.in_file(path, read_text(path)) from None


def reference_from(document: Mapping[str, Any], folder: Path | None = None) -> tuple[Reference, float]:
    """Make a motion from the fields of a reference file; `file` of a sampled one is sought in `folder`.

    Raises:
        FieldError: a ValueError that names field, rule and value.
    """
    fields = dict(document)
    kind = fields.pop("type", None)
    if kind not in TYPES:
        raise FieldError("", "type", f"must be one of {', '.join(TYPES)}, got {kind!r}")
    duration = fields.pop("duration", 0.0)
    if isinstance(duration, bool) or not isinstance(duration, int | float) or not 0 <= duration < 1e9:
        raise FieldError("", "duration", f"must be a number of seconds above 0, got {duration!r}")
    if kind == "sampled":
        return _sampled(fields, folder or Path()), float(duration)
    struct, motion = REFERENCES[kind]
    if kind != "point_to_point" and not duration:
        raise FieldError("", "duration", "must be given for a motion without an end, got none")
    return motion(parameters_from(struct, fields, "")), float(duration)


def _sampled(fields: Mapping[str, Any], folder: Path) -> Reference:
    refuse_unknown_keys(fields, ("file",), "")
    file = fields.get("file")
    if not isinstance(file, str):
        raise FieldError("", "file", f"must name a CSV file, got {file!r}")
    table = read_columns(
        folder / file, ("time", "reference"), optional=("reference_velocity", "reference_acceleration")
    )
    try:
        return Sampled(
            table["time"],
            table["reference"],
            table.get("reference_velocity"),
            table.get("reference_acceleration"),
        )
    except ValueError as error:
        raise FieldError("", "file", f"{file}: {error}") from None
