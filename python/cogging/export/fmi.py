"""The axis as a unit of FMI 3.0 for co-simulation, which other tools run without Python.

The unit contains a library built with this package, the same for every axis, and the numbers of the model in a text
that the library reads. So an export needs no compiler, and the plant is that of the core. Numbers are written as bits.
"""

from __future__ import annotations

import collections
import importlib.metadata
import io
import math
import platform
import struct
import sys
import uuid
import xml.etree.ElementTree as xml
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cogging.cpp_library import SOURCES, installed
from cogging.effects.custom import Custom
from cogging.export.cpp_header import licence, require_name
from cogging.export.forms import Exported, require_positive
from cogging.files import FieldError, InputError
from cogging.model.model import Model

LIBRARY = "cogging_axis"
SYSTEM = {"darwin": "darwin", "win32": "windows"}.get(sys.platform, "linux")
#: Suffix of a library by system, and architectures in FMI's words.
SUFFIXES = {"linux": ".so", "darwin": ".dylib", "windows": ".dll"}
MACHINES = {"amd64": "x86_64", "arm64": "aarch64"}
#: First value reference of the plant's parameters; co_simulation.cpp has those before.
FIRST_PARAMETER = 16
NAMESPACE = uuid.UUID("6a7d5c7e-5f0b-4d0a-9f0e-2f1c43b0a3d1")  # of the instantiation tokens, drawn once
#: FMI's exponents of known units; others are labels.
BASE_UNITS = {"s": {"s": 1}, "Hz": {"s": -1}}
for length in ("m", "rad"):
    BASE_UNITS |= {length: {length: 1}, f"{length}/s": {length: 1, "s": -1}, f"{length}/s^2": {length: 1, "s": -2}}
TEXT = """\
{name}: the axis as a unit of FMI 3.0 (co-simulation) for {system}, {size} kB.
takes:  plant, {effects}, encoder and noise, to the bit; input `command` ({V}), held over each step;
        outputs `reading`, `position`, `velocity`; parameters `seed`, `initial_position`, `initial_velocity` and
        {count} of the plant. Steps of any length; proposed {step:g} s, at which noise is drawn.
leaves: the controller, which its importer brings (a limit of the command is the controller's)."""


class Parameter(NamedTuple):
    """A number of the plant that the importer may change before initialisation."""

    name: str
    section: str  # in the resource: axis, encoder, noise, or the number of an effect
    field: str
    unit: str
    meaning: str
    value: float


def make(model: Model, *, name: str = "axis", sample_rate: float | None = None) -> Exported:
    """Return the unit of a model's axis, a zip archive; sample_rate: Hz, of the noise; None: the controller's."""
    require_name(name)
    if sample_rate is None and model.controller is None:
        raise FieldError("", "controller", "or an option sample_rate must be there to say how often noise is drawn")
    rate = float(model.controller.sample_rate) if sample_rate is None else sample_rate  # type: ignore[union-attr]
    require_positive("sample_rate", rate)
    for effect in model.effects:
        if isinstance(effect, Custom):
            raise FieldError("", "effects", f"must be of the core's list to run without Python, got {effect.NAME}")
    parameters = list(_parameters(model))
    numbers = _numbers(model, rate, parameters)
    token = f"{{{uuid.uuid5(NAMESPACE, numbers)}}}"
    library = find_library()
    files = {
        "modelDescription.xml": _description(model, name, token, rate, parameters),
        "resources/axis.txt": f"cogging_axis 2\ntoken {token}\n{numbers}".encode(),
        f"binaries/{platform_tuple()}/{name}{library.suffix}": library.read_bytes(),
        "documentation/licenses/license.txt": licence().encode(),
    }
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as made:
        for path, content in files.items():
            entry = zipfile.ZipInfo(path)  # without the time: the same files give the same bytes
            entry.external_attr = (0o755 if path.startswith("binaries") else 0o644) << 16
            made.writestr(entry, content, zipfile.ZIP_DEFLATED)
    content, effects = archive.getvalue(), f"{len(model.effects)} effect{'s' * (len(model.effects) != 1)}"
    sizes = {"size": round(len(content) / 1000), "count": len(parameters), "step": 1.0 / rate}
    said = TEXT.format(name=name, system=platform_tuple(), effects=effects, V=model.units.of("V"), **sizes)
    return Exported(content, said)


def find_library() -> Path:
    """Return the path of the library that was built with this package."""
    file = LIBRARY + SUFFIXES[SYSTEM]
    built = sorted((SOURCES.parent / "build").glob(f"*/cpp/fmi/{file}"), key=lambda path: path.stat().st_mtime)
    for path in (*(folder / file for folder in installed("share/fmi")), *reversed(built)):
        if path.is_file():
            return path
    advice = f"install the package (pip install .), or build the target {LIBRARY} below build"
    raise InputError(f"{SOURCES.parent}: must hold the library of a unit, got none: {advice}")


def platform_tuple() -> str:
    """Return this platform in FMI's words: x86_64-linux."""
    machine = platform.machine().lower()
    return f"{MACHINES.get(machine, machine)}-{SYSTEM}"


def _sections(model: Model) -> list[tuple[str, Any]]:
    return [("axis", model.axis), ("encoder", model.encoder), ("noise", model.noise)]


def _numbers(model: Model, rate: float, parameters: list[Parameter]) -> str:
    """Return the numbers of a model as cpp/fmi/resource.hpp reads them, one item a line."""
    lines = [
        _line("start sample_rate", rate),
        _line("start steps_per_sample", model.steps_per_sample),
        _line("start initial_position", _initial_position(model)),
        "parameter 6 start initial_position",
        "parameter 7 start initial_velocity",
    ]
    for section, fields in _sections(model):
        lines += [_line(f"{section} {field}", value) for field, value in fields.to_dict().items()]
    if model.cogging is not None:
        basis = model.cogging.basis
        spline = basis.spline
        terms: list[float] = [*basis.harmonics] or [*map(float, basis.periods)]  # the pitch of periods is 0
        knots: list[float] = [spline.order, spline.control_points, spline.origin, spline.pitch, basis.pitch]
        # One row a control point: sine and cosine of each term.
        amplitudes = np.stack([model.cogging.sine.T, model.cogging.cosine.T], axis=-1).ravel().tolist()
        lines += [_line("cogging", [*knots, *terms]), _line("cogging_coefficients", amplitudes)]
    for number, effect in enumerate(model.effects):
        lines.append(f"effect {effect.NAME}")
        lines += [_line(f"{number} {field}", value) for field, value in effect.to_dict().items()]
    for reference, parameter in enumerate(parameters, FIRST_PARAMETER):
        lines.append(f"parameter {reference} {parameter.section} {parameter.field}")
    return "\n".join(lines) + "\n"


def _initial_position(model: Model) -> float:
    """Return the default start: the middle of the travel."""
    low, high = model.axis.travel
    return 0.5 * (low + high) if math.isfinite(high - low) else 0.0


def _parameters(model: Model) -> Iterator[Parameter]:
    """Yield the finite scalars of the plant in the order of their value references."""
    seen = collections.Counter[str]()
    sections = [(name, name, fields) for name, fields in _sections(model)]
    for number, effect in enumerate(model.effects):
        seen[effect.NAME] += 1
        called = effect.NAME if seen[effect.NAME] == 1 else f"{effect.NAME}_{seen[effect.NAME]}"
        sections.append((called, str(number), effect))
    for called, section, fields in sections:
        for field, value in fields.to_dict().items():
            if isinstance(value, float) and math.isfinite(value):
                unit, meaning = fields.FIELDS[field][:2]
                yield Parameter(f"{called}.{field}", section, field, model.units.of(unit), meaning, value)


def _line(item: str, value: Any) -> str:
    """Return an item with its value, and as a comment in decimal."""
    values = value if isinstance(value, list) else [value]
    words = [struct.pack(">d", one).hex() if isinstance(one, float) else str(int(one)) for one in values]
    comment = f"  # {value!r}" if len(values) == 1 and isinstance(values[0], float) else ""
    return " ".join([item, *words]) + comment


def _description(model: Model, name: str, token: str, rate: float, parameters: list[Parameter]) -> bytes:
    """Return modelDescription.xml: capabilities and variables of the unit."""
    stated = {"fmiVersion": "3.0", "modelName": name, "instantiationToken": token}
    stated["description"] = "An axis with a cogging linear motor: command in, encoder reading and true motion out."
    stated["generationTool"] = f"cogging {importlib.metadata.version('cogging')}"
    root = xml.Element("fmiModelDescription", {**stated, "variableNamingConvention": "structured"})
    able = dict.fromkeys(("canHandleVariableCommunicationStepSize", "canGetAndSetFMUState"), "true")
    xml.SubElement(root, "CoSimulation", {"modelIdentifier": name, **able})
    variables = list(_variables(model, parameters))
    definitions = xml.SubElement(root, "UnitDefinitions")
    for unit in dict.fromkeys(attributes["unit"] for _, attributes in variables if "unit" in attributes):
        definition = xml.SubElement(definitions, "Unit", name=unit)
        if unit in BASE_UNITS:
            xml.SubElement(definition, "BaseUnit", {key: str(power) for key, power in BASE_UNITS[unit].items()})
    categories = xml.SubElement(root, "LogCategories")
    xml.SubElement(categories, "Category", name="logStatusError", description="What went wrong, when and where.")
    xml.SubElement(root, "DefaultExperiment", startTime="0", stepSize=repr(1.0 / rate))
    listed = xml.SubElement(root, "ModelVariables")
    for kind, attributes in variables:
        xml.SubElement(listed, kind, attributes)
    structure = xml.SubElement(root, "ModelStructure")
    outputs = [attributes["valueReference"] for _, attributes in variables if attributes["causality"] == "output"]
    # Outputs depend on the state alone: a command acts from the next step on.
    for kind, more in (("Output", {"dependencies": ""}), ("InitialUnknown", {})):
        for reference in outputs:
            xml.SubElement(structure, kind, {"valueReference": reference, **more})
    xml.indent(root)
    text: str = xml.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'.encode()


def _variables(model: Model, parameters: list[Parameter]) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield type and attributes of every variable; co_simulation.cpp has the first value references."""
    unit, position = model.units.of, repr(_initial_position(model))
    fixed = {"causality": "parameter", "variability": "fixed"}
    output = {"causality": "output", "variability": "continuous", "initial": "calculated"}
    listed: list[tuple[str, str, str, dict[str, str]]] = [
        ("time", "s", "", {"causality": "independent", "variability": "continuous"}),
        ("command", unit("V"), "Command of the drive, held over the step", {"causality": "input", "start": "0"}),
        ("reading", unit("m"), "Position as the encoder shows it", output),
        ("position", unit("m"), "True position of the motor", output),
        ("velocity", unit("m/s"), "True velocity of the motor", output),
        ("seed", "", "Of the noise", {**fixed, "start": "0"}),
        ("initial_position", unit("m"), "Where the axis starts", {**fixed, "start": position}),
        ("initial_velocity", unit("m/s"), "With which it starts", {**fixed, "start": "0"}),
    ]
    references = [*range(len(listed)), *range(FIRST_PARAMETER, FIRST_PARAMETER + len(parameters))]
    listed += [(one.name, one.unit, one.meaning, {**fixed, "start": repr(one.value)}) for one in parameters]
    for reference, (name, label, meaning, more) in zip(references, listed, strict=True):
        attributes = {"name": name, "valueReference": str(reference), **more}
        attributes |= {"description": meaning} if meaning else {}
        attributes |= {"unit": label} if label not in ("", "1") else {}
        yield "UInt64" if name == "seed" else "Float64", attributes
