"""What can be called in the core, and with what: read out of its stubs, which are written for this."""

from __future__ import annotations

import ast
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Parameter:
    """One argument: its name, the annotation, whether it has a default and goes by name only."""

    name: str
    annotation: str
    has_default: bool
    by_name: bool


@dataclass(frozen=True)
class Target:
    """What can be called: `owner` is the class, "" of a function; `name` is "__init__" of a constructor."""

    module: str
    owner: str
    name: str
    parameters: tuple[Parameter, ...]
    is_property: bool = False
    is_static: bool = False

    def __str__(self) -> str:
        return ".".join(part for part in (self.module, self.owner, self.name) if part)


def stubs() -> dict[str, str]:
    """The text of each stub by the name of its module, "" of the core itself."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "pybind11_stubgen", "cogging._core", "-o", folder]
        subprocess.run(command, check=True, capture_output=True)
        made = sorted(Path(folder, "cogging", "_core").glob("*.pyi"))
        return {"" if path.stem == "__init__" else path.stem: path.read_text() for path in made}


def targets() -> list[Target]:
    """Every function, constructor, method and property of the core, in the order of its stubs."""
    found: list[Target] = []
    for module, text in stubs().items():
        for node in ast.parse(text).body:
            if isinstance(node, ast.FunctionDef):
                found.append(_target(module, "", node))
            elif isinstance(node, ast.ClassDef):
                found += [
                    _target(module, node.name, inner) for inner in node.body if isinstance(inner, ast.FunctionDef)
                ]
    return found


def _target(module: str, owner: str, node: ast.FunctionDef) -> Target:
    marks = {ast.unparse(mark) for mark in node.decorator_list}
    arguments = node.args
    plain = [*arguments.posonlyargs, *arguments.args]
    optional = len(plain) - len(arguments.defaults)
    parameters = [Parameter(one.arg, _text(one), i >= optional, False) for i, one in enumerate(plain)]
    parameters += [
        Parameter(one.arg, _text(one), default is not None, True)
        for one, default in zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True)
    ]
    static = "staticmethod" in marks
    if owner and not static:
        parameters = parameters[1:]  # self
    return Target(module, owner, node.name, tuple(parameters), "property" in marks, static)


def _text(argument: ast.arg) -> str:
    return ast.unparse(argument.annotation) if argument.annotation is not None else ""
