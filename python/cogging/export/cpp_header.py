"""A controller with its gains as one C++ header that needs nothing but a C++20 compiler.

The header contains the headers of the core that the controller needs, each once, after those it includes. A step
computes the same bits as the library. Everything is in its own namespace, so that several such headers, or one and
the library, do not conflict.
"""

from __future__ import annotations

import importlib.metadata
import json
import math
import re
import string
import textwrap
from pathlib import Path
from typing import Any

from cogging.cpp_library import SOURCES, get_include
from cogging.export.forms import Exported
from cogging.files import FieldError, InputError
from cogging.model.model import CONTROLLERS, Model
from cogging.shown import quoted

WIDTH = 120
OWN_INCLUDE = re.compile(r'^#include "(cogging/[^"]+)"\n', re.MULTILINE)
LIBRARY_INCLUDE = re.compile(r"^#include <([^>]+)>\n", re.MULTILINE)
DEFINED = re.compile(r"^#define (COGGING_\w+)", re.MULTILINE)
#: In require.hpp: without exceptions, the program defines what happens to invalid parameters.
REFUSED = "[[noreturn]] void refused(const std::string& line);"
NEVER_REFUSED = """\
[[noreturn]] inline void refused(const std::string&) {
  std::abort();  // does not happen: these gains were checked when the header was made
}"""

#: The header, with `$` before each of what `make` fills in.
HEADER = string.Template(Path(__file__).with_name("controller.hpp.in").read_text(encoding="utf-8"))
COMMAND = """\
  /// The command (${V}) of a sample, not cut at command_limit; `reading` is the encoder's (${m}).
  double command(const Reference& reference, double reading) noexcept { return running_.command(reference, reading); }
"""
COMMAND_AHEAD = """\
  /// The command (${V}) of a sample, not cut at command_limit; `ahead` is the reference `preview` seconds later, and
  /// `reading` the encoder's (${m}).
  double command(const Reference& reference, const Reference& ahead, double reading) noexcept {
    return running_.command(reference, ahead, reading);
  }
"""
TEXT = """\
{type} at {rate:g} Hz as {name}::Controller, {lines} lines.
takes:  all gains and limits, to the bit; commands are those of the library where the compiler joins no a * b + c
        (GCC and Clang: -ffp-contract=off; GCC also: -fno-tree-slp-vectorize).
leaves: axis, cogging and effects, which are the machine's; what was learned in a run: it begins as the model says.
To use: #include it, then {name}::Controller controller; its comment shows the two calls of a sample."""


def make(model: Model, *, name: str = "axis") -> Exported:
    """Return the header of a model's controller in a namespace, and a summary of what it contains."""
    if model.controller is None or model.controller_type is None:
        raise FieldError("", "controller", "must be there to be exported, got a model without one")
    require_name(name)
    units, parameters, law = model.units, model.controller, CONTROLLERS[model.controller_type][1]
    folder = Path(get_include())
    headers = OWN_INCLUDE.findall((folder / "cogging/control/list.hpp").read_text(encoding="utf-8"))
    defines = re.compile(rf"^(class|using) {law.__name__}\b", re.MULTILINE)
    header = next((one for one in headers if defines.search((folder / one).read_text(encoding="utf-8"))), None)
    if header is None:
        raise InputError(f"{folder}: must hold a header with {law.__name__}, got none in cogging/control/list.hpp")
    library, standard = inlined(header)
    library = library.replace(REFUSED, NEVER_REFUSED)
    macros = sorted(set(DEFINED.findall(library)))
    library = re.sub(r"\bCOGGING_", f"{name.upper()}_COGGING_", library)
    preview = getattr(law(parameters), "preview", None)
    ahead = preview is not None
    shown = {"V": units.of("V"), "m": units.of("m")}
    comment = "\n\n".join((law.__doc__ or "").split("\n\n")[:2]).strip()
    assignments = []
    for field, value in parameters.to_dict().items():
        unit, meaning = type(parameters).FIELDS[field]
        label = f"{units.of(unit)}: " if unit not in ("", "1") else ""
        statement = f"    q.{field} = {literal(value)};"
        broken = textwrap.wrap(statement, WIDTH, subsequent_indent="        ", break_long_words=False)
        assignments += [f"    // {label}{meaning}", *(broken if len(statement) > WIDTH else [statement])]
    needed = sorted({*standard, "algorithm", "cstdlib", "limits", "span"})
    text = HEADER.substitute(
        **shown,
        type=model.controller_type,
        version=importlib.metadata.version("cogging"),
        licence="\n".join(f"// {line}".rstrip() for line in licence().strip().splitlines()),
        includes="\n".join(f"#include <{one}>" for one in needed),
        name=name,
        library=library,
        comment="\n".join(f"/// {line}".rstrip() for line in comment.splitlines()),
        call="reference, ahead, reading" if ahead else "reference, reading",
        sample_rate=literal(parameters.sample_rate),
        command_limit=literal(parameters.command_limit),
        preview=f"  static constexpr double preview = {preview!r};  // s, how far ahead `ahead` is\n" if ahead else "",
        command=string.Template(COMMAND_AHEAD if ahead else COMMAND).substitute(shown).rstrip("\n"),
        law=law.__name__,
        assignments="\n".join(assignments),
        undefined="\n".join(f"#undef {name.upper()}_{macro}" for macro in macros),
    )
    said = TEXT.format(type=model.controller_type, rate=parameters.sample_rate, name=name, lines=text.count("\n"))
    return Exported(text.encode(), said)


def require_name(name: str) -> None:
    """Raise ValueError for a name that is no identifier of C; words of the language are left to its compiler."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,62}", name) or "__" in name:
        rule = "must be a name in C++: a letter, then letters, digits and single _, at most 63"
        raise ValueError(f"name: {rule}, got {quoted(name)}")


def inlined(first: str) -> tuple[str, list[str]]:
    """Return a header of the core with all that it includes, and the standard headers that they need."""
    folder, seen, parts, standard = Path(get_include()), set[str](), [], set[str]()

    def add(path: str) -> None:
        if path in seen:
            return
        seen.add(path)
        text = (folder / path).read_text(encoding="utf-8")
        for needed in OWN_INCLUDE.findall(text):
            add(needed)
        standard.update(LIBRARY_INCLUDE.findall(text))
        own = LIBRARY_INCLUDE.sub("", OWN_INCLUDE.sub("", text.replace("#pragma once\n", "")))
        own = re.sub(r"\n{3,}", "\n\n", own).strip()
        parts.append(f"// {path} {'-' * (WIDTH - len(path) - 4)}\n\n{own}\n")

    add(first)
    return "\n".join(parts), sorted(standard)


def licence() -> str:
    """Return the licence of the core."""
    beside = SOURCES.parent / "LICENSE"
    installed = importlib.metadata.distribution("cogging").read_text("licenses/LICENSE")
    if installed:
        return installed
    if beside.is_file():
        return beside.read_text(encoding="utf-8")
    raise InputError(f"{beside}: must hold the licence that an export passes on, got a package without it")


def literal(value: Any) -> str:
    """Return a C++ literal that reads back as the same value."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, list | tuple):
        return "{" + ", ".join(map(literal, value)) + "}"
    if isinstance(value, float) and not math.isfinite(value):
        return ("-" if value < 0 else "") + "std::numeric_limits<double>::infinity()"
    return repr(value)
