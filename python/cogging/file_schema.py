"""The JSON Schema of input files, generated from the C++ parameter structs."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping
from typing import Any

from cogging import _core
from cogging._core import AxisParameters, EncoderParameters, NoiseParameters
from cogging.files import shipped_toml
from cogging.model.model import CONTROLLERS, STEPS_MAX, UNCERTAINTY_KEYS
from cogging.model.units import LABEL
from cogging.simulation.reference import REFERENCES
from cogging.simulation.varied import METHODS

ABOVE_ZERO = {"type": "number", "exclusiveMinimum": 0}
NUMBER = {"type": "number"}
NUMBERS = {"type": "array", "items": NUMBER}
WHOLE_NUMBERS = {"type": "array", "items": {"type": "integer"}}

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
        {key: {"type": "number", "minimum": 0, "unit": "1"} for key in UNCERTAINTY_KEYS},
    )
    controllers = [
        _tagged("type", kind, made.__doc__ or "", _fields(struct)) for kind, (struct, made) in CONTROLLERS.items()
    ]
    effects = [_tagged("name", name, kind.LAW, _fields(kind)) for name, kind in _core.EFFECTS.items()]
    words = "least number of integration steps between two samples; a run uses more where its accuracy needs them"
    steps = {"type": "integer", "minimum": 1, "maximum": STEPS_MAX, "default": 1, "unit": "1", "description": words}
    label = {"type": "string", "pattern": f"^({LABEL})$"}
    described = {
        "command": ("V", "of the command, as A, N or Nm; wherever V stands here"),
        "position": ("m", "of the position, as rad; wherever m stands here"),
    }
    units = {key: {**label, "default": one, "unit": "", "description": text} for key, (one, text) in described.items()}
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
            "simulation": _section("how a run is integrated", {"steps_per_sample": steps}),
            "units": _section("labels, carried to all output; numbers stay as they are", units),
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
        entry = _tagged("type", kind, made.__doc__ or "", _fields(struct) | {"duration": duration})
        if not math.isfinite(made(struct()).end):
            entry["required"].append("duration")
        motions.append(entry)
    samples = keys["sampled"] | {"duration": duration}
    motions.append(_tagged("type", "sampled", "a motion given by samples", samples))

    sweep = keys["sweep"] | {"vary": _vary(keys["sweep"]["vary"])}
    sweep["method"]["enum"] = list(METHODS)

    sections = {name: keys["tune"].pop(name) for name in ("gains", "limits", "vary")}
    tune = keys["tune"]
    tune["against"]["enum"] = list(TUNE_INDEXES)
    scale = {"scale": {"enum": ["linear", "log"]}}
    ends = _section("its ends", {**dict.fromkeys(("from", "to", "start"), NUMBER), **scale}, ["from", "to"])
    present = _section("times what the present gains reach", {"present": ABOVE_ZERO}, ["present"])
    limits = {
        name: {"oneOf": [ABOVE_ZERO, present], "unit": one["unit"], "description": one["description"]}
        for name, one in TUNE_INDEXES.items()
    }
    tune |= {
        "gains": {"type": "object", "additionalProperties": ends, "description": sections["gains"]["description"]},
        "limits": _section(sections["limits"]["description"], limits),
        "vary": _vary(sections["vary"]),
    }
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
    number = dict.fromkeys(("from", "to", "mean", "deviation"), NUMBER)
    points = {"points": {"type": "integer", "minimum": 2}, "scale": {"enum": ["linear", "log"]}}
    values = {"type": "array", "items": NUMBER, "minItems": 1}
    table = _section("a distribution", {"values": values, **number, **points})
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
    defaults = struct().to_dict()
    for name, (unit, meaning) in struct.FIELDS.items():
        value = defaults[name]
        finite = all(math.isfinite(v) for v in (value if isinstance(value, list) else [value]) if isinstance(v, float))
        default = {"default": value} if finite else {}
        found[name] = {**_type_of(name, value), **default, "unit": unit or "", "description": meaning}
    return found


def _type_of(name: str, default: Any) -> dict[str, Any]:
    if isinstance(default, bool):
        return {"type": "boolean"}
    if isinstance(default, str):
        return {"type": "string"}
    if isinstance(default, list):
        if default and isinstance(default[0], list):
            return {"type": "array", "items": NUMBERS}
        return WHOLE_NUMBERS if name.endswith("harmonics") else NUMBERS
    return {"type": "integer"} if isinstance(default, int) else NUMBER
