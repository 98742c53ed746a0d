"""The JSON Schema of input files, generated from the C++ parameter structs."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping
from typing import Any

from cogging import _core
from cogging._core import AxisParameters, EncoderParameters, NoiseParameters
from cogging.files import shipped_toml
from cogging.model.model import AXIS_FIELDS, CONTROLLERS, STEPS_MAX
from cogging.model.units import LABEL
from cogging.simulation.reference import REFERENCES
from cogging.simulation.varied import METHODS

ABOVE_ZERO = {"type": "number", "exclusiveMinimum": 0}
NUMBER = {"type": "number"}
NUMBERS = {"type": "array", "items": NUMBER}
WHOLE_NUMBERS = {"type": "array", "items": {"type": "integer"}}
SCALE = {"enum": ["linear", "log"]}

KEYS = shipped_toml("file_schema.toml")
LIMITS, LIMITS_NEEDED = KEYS["limits"], KEYS["required"]["limits"]
#: Quantities that a tuning may limit: their unit, whether the limit is an upper one, and their meaning.
TUNE_INDEXES = KEYS["tune_limits"]


def schema() -> dict[str, Any]:
    """The JSON Schema (2020-12) of model, reference, limits, sweep and tune files, which are TOML.

    `$defs` has `model`, `reference`, `limits`, `sweep` and `tune`. Every field has a `description`, a `unit` and, if it
    is finite, a default. Integers are allowed for numbers. Rules between fields are checked when a file is read.

    Returns:
        The schema as a JSON document.

    Example:
        >>> sorted(cogging.schema())
        ['$defs', '$schema', 'oneOf', 'title']
    """
    keys = copy.deepcopy(KEYS)
    axis = _section("M x'' = u - B x' - Fc S(x') - F_cogging(x) + effects", _fields(AxisParameters), ["mass"])
    axis["properties"]["uncertainty"] = _section(
        "relative 1-sigma of each, 0 = exact",
        {key: {"type": "number", "minimum": 0, "unit": "1"} for key in AXIS_FIELDS},
    )
    controllers = [_tagged("type", kind, made.__doc__, _fields(one)) for kind, (one, made) in CONTROLLERS.items()]
    effects = [_tagged("name", name, kind.LAW, _fields(kind)) for name, kind in _core.EFFECTS.items()]
    keys["simulation"]["steps_per_sample"]["maximum"] = STEPS_MAX
    for label in keys["units"].values():
        label["pattern"] = f"^({LABEL.pattern})$"
    bound = {"type": "array", "items": NUMBER, "minItems": 2, "maxItems": 2}
    model = _section(
        "an axis: model file",
        {
            "axis": axis,
            "cogging": _section("F_cogging(x), which opposes the command", keys["cogging"]),
            "effects": {"type": "array", "items": {"oneOf": effects}, "description": "[[effects]] tables"},
            "encoder": _section(EncoderParameters.__doc__ or "", _fields(EncoderParameters)),
            "noise": _section(NoiseParameters.__doc__ or "", _fields(NoiseParameters)),
            "controller": {"oneOf": controllers, "description": "absent: unknown"},
            "simulation": _section("how a run is integrated", keys["simulation"]),
            "units": _section("labels, carried to all output; numbers stay as they are", keys["units"]),
            "bounds": {
                "type": "object",
                "additionalProperties": bound,
                "description": "95 % intervals by parameter path, written by identify",
            },
        },
        ["axis"],
    )

    duration = {"type": "number", "minimum": 0, "unit": "s", "description": "of the run; 0 = the motion's own end"}
    motions = []
    for kind, (struct, made) in REFERENCES.items():
        entry = _tagged("type", kind, made.__doc__, _fields(struct) | {"duration": duration})
        if not math.isfinite(made(struct()).end):
            entry["required"].append("duration")
        motions.append(entry)
    samples = keys["sampled"] | {"duration": duration}
    motions.append(_tagged("type", "sampled", "a motion given by samples", samples))

    sweep, tune = keys["sweep"], keys["tune"]
    sweep["vary"], tune["vary"] = _vary(sweep["vary"]), _vary(tune["vary"])
    sweep["method"]["enum"] = list(METHODS)
    tune["against"]["enum"] = list(TUNE_INDEXES)
    ends = {**dict.fromkeys(("from", "to", "start"), NUMBER), "scale": SCALE}
    tune["gains"]["additionalProperties"] = _section("its ends", ends, ["from", "to"])
    present = _section("times what the present gains reach", {"present": ABOVE_ZERO}, ["present"])
    limits = {
        name: {"oneOf": [ABOVE_ZERO, present], "unit": one["unit"], "description": one["description"]}
        for name, one in TUNE_INDEXES.items()
    }
    tune["limits"] = _section(tune["limits"]["description"], limits)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "cogging: model, reference, limits, sweep and tune files (TOML; SI, V stands for the command unit)",
        "oneOf": [{"$ref": f"#/$defs/{name}"} for name in ("model", "reference", "limits", "sweep", "tune")],
        "$defs": {
            "model": model,
            "reference": {"oneOf": motions, "description": "a motion: reference file"},
            "limits": _section("what a machine may do: limits file", keys["limits"], keys["required"]["limits"]),
            "sweep": _section("many runs with other numbers: sweep file", sweep, keys["required"]["sweep"]),
            "tune": _section("gains for an uncertain machine: tune file", tune, keys["required"]["tune"]),
        },
    }


def _vary(stated: Mapping[str, Any]) -> dict[str, Any]:
    values = {"type": "array", "items": NUMBER, "minItems": 1}
    numbers = dict.fromkeys(("from", "to", "mean", "deviation"), NUMBER)
    points = {"type": "integer", "minimum": 2}
    table = _section("a distribution", {"values": values, **numbers, "points": points, "scale": SCALE})
    return {
        "description": stated["description"],
        "oneOf": [
            {"const": "bounds"},
            {"type": "object", "additionalProperties": {"oneOf": [values, table, {"const": "bounds"}]}},
        ],
    }


def _section(description: str, properties: Mapping[str, Any], required: list[str] | None = None) -> dict[str, Any]:
    return {
        "type": "object",
        "description": description.strip().partition("\n")[0],
        "properties": dict(properties),
        "required": required or [],
        "additionalProperties": False,
    }


def _tagged(tag: str, value: str, description: str, properties: Mapping[str, Any]) -> dict[str, Any]:
    return _section(description, {tag: {"const": value}, **properties}, [tag])


def _fields(struct: Any) -> dict[str, Any]:
    found = {}
    for (name, (unit, meaning)), value in zip(struct.FIELDS.items(), struct().to_dict().values(), strict=True):
        finite = all(math.isfinite(v) for v in (value if isinstance(value, list) else [value]) if isinstance(v, float))
        default = {"default": value} if finite else {}
        found[name] = {**_type_of(name, value), **default, "unit": unit or "", "description": meaning}
    return found


def _type_of(name: str, default: Any) -> dict[str, Any]:
    if isinstance(default, list):
        if default and isinstance(default[0], list):
            return {"type": "array", "items": NUMBERS}
        return WHOLE_NUMBERS if name.endswith("harmonics") else NUMBERS
    return {"type": {bool: "boolean", str: "string", int: "integer"}.get(type(default), "number")}
