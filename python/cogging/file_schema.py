"""The JSON Schema of input files, generated from the C++ parameter structs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from cogging import _core
from cogging._core import AxisParameters, EncoderParameters, NoiseParameters
from cogging.model.model import CONTROLLERS, STEPS_MAX, UNCERTAINTY_KEYS
from cogging.model.units import LABEL
from cogging.simulation.parameter_sweep import KEYS as SWEEP
from cogging.simulation.parameter_sweep import NEEDED as SWEEP_NEEDED
from cogging.simulation.reference import REFERENCES
from cogging.simulation.varied import METHODS

NUMBER = {"type": "number"}
NUMBERS = {"type": "array", "items": NUMBER}
WHOLE_NUMBERS = {"type": "array", "items": {"type": "integer"}}

#: The keys of [cogging], which no single struct holds: type, unit and meaning.
COGGING: dict[str, tuple[dict[str, Any], str, str]] = {
    "pitch": (NUMBER, "m", "magnet pitch; the distance of the B-spline's knots"),
    "harmonics": (WHOLE_NUMBERS, "1", "terms sin and cos of 2 pi i x / pitch; in place of periods"),
    "periods": (NUMBERS, "m", "terms sin and cos of 2 pi x / period; in place of harmonics"),
    "order": ({"type": "integer"}, "1", "B-spline order of the amplitudes; 1 = piecewise constant, default 3"),
    "origin": (NUMBER, "m", "first knot of the first full span, default 0"),
    "sine": ({"type": "array", "items": NUMBERS}, "V", "one row a term, one column a control point"),
    "cosine": ({"type": "array", "items": NUMBERS}, "V", "one row a term, one column a control point"),
}
SIMULATION: dict[str, tuple[dict[str, Any], str, str]] = {
    "steps_per_sample": (
        {"type": "integer", "minimum": 1, "maximum": STEPS_MAX, "default": 1},
        "1",
        "least number of integration steps between two samples; a run uses more where its accuracy needs them",
    ),
}
UNIT = {"type": "string", "pattern": f"^({LABEL})$"}
UNITS: dict[str, tuple[dict[str, Any], str, str]] = {
    "command": ({**UNIT, "default": "V"}, "", "of the command, as A, N or Nm; wherever V stands here"),
    "position": ({**UNIT, "default": "m"}, "", "of the position, as rad; wherever m stands here"),
}
SAMPLED: dict[str, tuple[dict[str, Any], str, str]] = {
    "file": ({"type": "string"}, "", "log file with time and reference, beside the reference file"),
    "time": (NUMBERS, "s", "of the samples, in place of file"),
    "reference": (NUMBERS, "m", "samples of the position"),
    "reference_velocity": (NUMBERS, "m/s", "samples; differentiated when left out"),
    "reference_acceleration": (NUMBERS, "m/s^2", "samples; differentiated when left out"),
}

ABOVE_ZERO = {"type": "number", "exclusiveMinimum": 0}
LIMITS: dict[str, tuple[dict[str, Any], str, str]] = {
    "travel": (
        {**NUMBERS, "minItems": 2, "maxItems": 2},
        "m",
        "lower and upper end of where the axis may be; default: the model's travel",
    ),
    "velocity": (ABOVE_ZERO, "m/s", "largest speed"),
    "acceleration": (ABOVE_ZERO, "m/s^2", "largest acceleration"),
    "jerk": (ABOVE_ZERO, "m/s^3", "largest jerk of the reference; default: the acceleration takes 10 ms to its limit"),
    "duration": ({"type": "number", "minimum": 2, "maximum": 600}, "s", "of the whole motion"),
    "command": (ABOVE_ZERO, "V", "largest command; default: the controller's command_limit"),
}
SWEEP_TYPES: dict[type, dict[str, Any]] = {
    str: {"type": "string"},
    int: {"type": "integer", "minimum": 0},
    float: NUMBER,
    list: {"type": "array", "items": {"type": "string"}},
}
LIMITS_NEEDED = ("velocity", "acceleration", "duration")
#: The keys of a tune file: type and meaning.
TUNE: dict[str, tuple[type, str]] = {
    "model": (str, "model file, beside the tune file; its controller is tuned"),
    "reference": (str, "reference file, beside the tune file"),
    "gains": (dict, "the ends of each gain by path; absent: the usual ones, from a tenth to ten times the present"),
    "limits": (dict, "what must be kept on every machine: a number, or {present = 1.1} times what the present reach"),
    "vary": (dict, 'how machines differ, by path, as in a sweep file; default "bounds"'),
    "machines": (int, "to tune with; default 32"),
    "held_out": (int, "further machines, to judge what was found; default 32"),
    "quantile": (float, "of rms error over machines; default 0.9"),
    "trials": (int, "how many; default 100"),
    "against": (str, "a second objective, by the name of a limit"),
    "seed": (int, "of machines, noise and trials; default 0"),
    "duration": (float, "s; default that of the reference"),
    "start": (float, "s; error and command are judged from then on"),
    "stop": (float, "s; error and command are judged before"),
}
TUNE_NEEDED = ("model", "reference")
#: Quantities that a tuning may limit: unit, whether the limit is an upper one, meaning.
TUNE_INDEXES: dict[str, tuple[str, bool, str]] = {
    "error_max": ("m", True, "largest error"),
    "command_max": ("V", True, "largest command"),
    "command_rms": ("V", True, "rms command"),
    "command_chatter": ("1", True, "of the command, as Performance has it: its change a sample over its rms"),
    "delay_margin": ("s", False, "further delay of the command at which every machine stays stable"),
    "gain_margin": ("1", False, "factor on the command at which every machine stays stable"),
    "modulus_margin": ("1", False, "smallest |1 + L| of the linear loop"),
}


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
    axis = _section("M x'' = u - B x' - Fc S(x') - F_cogging(x) + effects", _fields(AxisParameters), ["mass"])
    axis["properties"]["uncertainty"] = _section(
        "relative 1-sigma of each, 0 = exact",
        {key: {"type": "number", "minimum": 0, "unit": "1"} for key in UNCERTAINTY_KEYS},
    )
    controllers = [
        _tagged("type", kind, made.__doc__ or "", _fields(struct)) for kind, (struct, made) in CONTROLLERS.items()
    ]
    effects = [_tagged("name", name, kind.LAW, _fields(kind)) for name, kind in _core.EFFECTS.items()]
    bound = {"type": "array", "items": NUMBER, "minItems": 2, "maxItems": 2}
    model = _section(
        "an axis: model file",
        {
            "axis": axis,
            "cogging": _section("F_cogging(x), which opposes the command", _described(COGGING)),
            "effects": {"type": "array", "items": {"oneOf": effects}, "description": "[[effects]] tables"},
            "encoder": _section(EncoderParameters.__doc__ or "", _fields(EncoderParameters)),
            "noise": _section(NoiseParameters.__doc__ or "", _fields(NoiseParameters)),
            "controller": {"oneOf": controllers, "description": "absent: unknown"},
            "simulation": _section("how a run is integrated", _described(SIMULATION)),
            "units": _section("labels, carried to all output; numbers stay as they are", _described(UNITS)),
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
    motions.append(
        _tagged("type", "sampled", "a motion given by samples", _described(SAMPLED) | {"duration": duration})
    )

    sweep = _job(SWEEP) | {"vary": _vary(SWEEP["vary"][1])}
    sweep["method"]["enum"] = list(METHODS)

    tune = _job(TUNE)
    tune["against"]["enum"] = list(TUNE_INDEXES)
    scale = {"scale": {"enum": ["linear", "log"]}}
    ends = _section("its ends", {**dict.fromkeys(("from", "to", "start"), NUMBER), **scale}, ["from", "to"])
    present = _section("times what the present gains reach", {"present": ABOVE_ZERO}, ["present"])
    limits = {
        name: {"oneOf": [ABOVE_ZERO, present], "unit": unit, "description": meaning}
        for name, (unit, _, meaning) in TUNE_INDEXES.items()
    }
    tune |= {
        "gains": {"type": "object", "additionalProperties": ends, "description": TUNE["gains"][1]},
        "limits": _section(TUNE["limits"][1], limits),
        "vary": _vary(TUNE["vary"][1]),
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "cogging: model, reference, limits, sweep and tune files (TOML; SI, V stands for the command unit)",
        "oneOf": [{"$ref": f"#/$defs/{name}"} for name in ("model", "reference", "limits", "sweep", "tune")],
        "$defs": {
            "model": model,
            "reference": {"oneOf": motions, "description": "a motion: reference file"},
            "limits": _section("what a machine may do: limits file", _described(LIMITS), list(LIMITS_NEEDED)),
            "sweep": _section("many runs with other numbers: sweep file", sweep, list(SWEEP_NEEDED)),
            "tune": _section("gains for an uncertain machine: tune file", tune, list(TUNE_NEEDED)),
        },
    }


def _job(keys: Mapping[str, tuple[type, str]]) -> dict[str, Any]:
    return {key: {**SWEEP_TYPES[kind], "description": text} for key, (kind, text) in keys.items() if kind is not dict}


def _vary(meaning: str) -> dict[str, Any]:
    number = dict.fromkeys(("from", "to", "mean", "deviation"), NUMBER)
    points = {"points": {"type": "integer", "minimum": 2}, "scale": {"enum": ["linear", "log"]}}
    values = {"type": "array", "items": NUMBER, "minItems": 1}
    table = _section("a distribution", {"values": values, **number, **points})
    return {
        "description": meaning,
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


def _described(fields: Mapping[str, tuple[dict[str, Any], str, str]]) -> dict[str, Any]:
    return {name: {**kind, "unit": unit, "description": meaning} for name, (kind, unit, meaning) in fields.items()}


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
