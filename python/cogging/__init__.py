"""Cogging of permanent-magnet linear motors: simulate, control and identify the axis.

A name is imported when it is first used; `__init__.pyi` lists all names and their modules.
"""

import ast
import importlib.util
import sys

from cogging._core import controllers as _controllers
from cogging._core import references as _references
from cogging._core.controllers import *  # noqa: F403  (only the core lists them)
from cogging._core.references import *  # noqa: F403
from cogging.values import as_values

with open(f"{__file__}i", encoding="utf-8") as _file:
    _STUB = ast.parse(_file.read())
_HOMES = {
    alias.name: str(node.module) for node in _STUB.body if isinstance(node, ast.ImportFrom) for alias in node.names
}
__all__ = [
    *next(ast.literal_eval(node.value) for node in _STUB.body if isinstance(node, ast.Assign)),
    *_controllers.__all__,
    *_references.__all__,
]
as_values()


def __getattr__(name: str) -> object:
    """Return a public name, a module of the package or its version, imported now."""
    home = _HOMES.get(name, "cogging")
    if home != "cogging":
        value = getattr(importlib.import_module(home), name)
    elif name == "__version__":
        value = importlib.import_module("importlib.metadata").version("cogging")
    elif not name.startswith("__") and importlib.util.find_spec(f"cogging.{name}"):
        value = importlib.import_module(f"cogging.{name}")
    else:
        raise AttributeError(f"module 'cogging' has no attribute {name!r}", name=name, obj=sys.modules[__name__])
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the public names."""
    return sorted(__all__)
