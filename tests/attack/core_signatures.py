"""Every call into the core and its arguments, as its docstrings state them."""

import inspect
import re
from typing import Any, NamedTuple

from cogging import _core
from cogging.calls import signature

LINE = re.compile(r"^(?:\d+\. )?(\w+\(.*\) -> .*)$", re.MULTILINE)  # of each overload


class Target(NamedTuple):
    """A call: `place` is the class, of a function its module; `name` is "__init__" of a constructor."""

    place: Any
    owner: str
    name: str
    parameters: tuple[inspect.Parameter, ...]
    is_property: bool = False
    is_static: bool = False

    def __str__(self) -> str:
        return f"{self.owner}.{self.name}".lstrip(".")


def targets() -> list[Target]:
    """Every function, constructor, method and property of the core; of an overloaded one each form."""
    found: list[Target] = []
    for module in (_core, _core.effects):
        for name, value in vars(module).items():
            if not inspect.isclass(value):
                found += [Target(module, "", name, parameters) for parameters in forms(value)]
            elif not issubclass(value, BaseException):
                for word, member in vars(value).items():
                    if isinstance(member, property):
                        found.append(Target(value, name, word, (), is_property=True))
                        continue
                    static = isinstance(member, staticmethod)
                    for parameters in forms(getattr(value, word, None)):
                        found.append(Target(value, name, word, parameters[0 if static else 1 :], is_static=static))
    return found


def forms(function: Any) -> list[tuple[inspect.Parameter, ...]]:
    """Parameters of each overload of a function."""
    lines = LINE.findall(function.__doc__ or "") if callable(function) else []
    return [tuple(signature(line)[1].values()) for line in lines if "*args" not in line]
