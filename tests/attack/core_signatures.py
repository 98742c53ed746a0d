"""Every call into the core and its arguments, as its docstrings state them."""

from __future__ import annotations

import inspect
import re
from typing import Any, NamedTuple

from cogging import _core
from cogging.calls import Parameter, signature

LINE = re.compile(r"^(?:\d+\. )?(\w+\(.*\) -> .*)$", re.MULTILINE)  # of each overload


class Target(NamedTuple):
    """A call: `owner` is the class, "" of a function; `name` is "__init__" of a constructor."""

    module: str
    owner: str
    name: str
    parameters: tuple[Parameter, ...]
    is_property: bool = False
    is_static: bool = False

    def __str__(self) -> str:
        return ".".join(part for part in (self.module, self.owner, self.name) if part)


def targets() -> list[Target]:
    """Every function, constructor, method and property of the core; of an overloaded one each form."""
    found: list[Target] = []
    for module, place in (("", _core), ("effects", _core.effects)):
        for name, value in vars(place).items():
            if not inspect.isclass(value):
                found += [Target(module, "", name, parameters) for parameters in _forms(value)]
            elif not issubclass(value, BaseException):
                found += _members(module, value)
    return found


def _members(module: str, kind: type) -> list[Target]:
    found = []
    for name, member in vars(kind).items():
        static = isinstance(member, staticmethod)
        if isinstance(member, property):
            found.append(Target(module, kind.__name__, name, (), is_property=True))
        else:
            for parameters in _forms(getattr(kind, name, None)):
                found.append(Target(module, kind.__name__, name, parameters[0 if static else 1 :], is_static=static))
    return found


def _forms(function: Any) -> list[tuple[Parameter, ...]]:
    lines = LINE.findall(function.__doc__ or "") if callable(function) else []
    return [signature(line)[1] for line in lines if "*args" not in line]
