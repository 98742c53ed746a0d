"""Digest of a sweep or a tuning: model, arguments, and custom laws with all that they refer to."""

from __future__ import annotations

import builtins
import copyreg
import ctypes
import dis
import hashlib
import importlib.metadata
import json
import os
import pickle
import sys
from collections import ChainMap
from collections.abc import Mapping
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

from cogging.effects.custom import COMPILED, Custom
from cogging.model.model import Model

STANDARD = Path(os.__file__).parent
PUBLISHED = ("cogging", "numpy", "scipy", "numba")  # beside the standard library: their versions identify the content
WRAPPERS = ("functools._lru_cache_wrapper", "numba.core.registry.CPUDispatcher", "numba.core.ccallback.CFunc")
PLAIN = (type(None), type(...), bool, int, float, complex, str, bytes)
OF_CODE = (
    *("co_code", "co_consts", "co_names", "co_varnames", "co_freevars", "co_cellvars", "co_flags"),
    *("co_argcount", "co_posonlyargcount", "co_kwonlyargcount", "co_exceptiontable"),
)
GLOBAL = ("LOAD_GLOBAL", "LOAD_NAME", "IMPORT_NAME")


def digest_of(model: Model, asked: Mapping[str, Any]) -> str | None:
    """Return a digest of all that determines the results of runs; None if a custom law cannot be described.

    Args:
        model: the model.
        asked: the other arguments, as JSON can hold them.
    """
    described = _Description()
    try:
        laws = [described.of(effect) for effect in model.effects if isinstance(effect, Custom)]
    except Exception:  # any error of a foreign object
        return None
    version = importlib.metadata.version("cogging")
    whole = {"version": version, "model": model.to_dict(), "laws": laws, **asked}
    return hashlib.sha256(json.dumps(whole, sort_keys=True, default=_as_json).encode()).hexdigest()


def _as_json(value: Any) -> Any:
    return os.fspath(value) if isinstance(value, Path) else value.tolist()


class _Description:
    """Describes functions and the values they hold by content, as JSON can hold it.

    A function is its code, defaults, closure, and the globals that it names; one of a library its name and version; a
    compiled one the digest of its file. Any other value is what pickle would store of it.
    """

    def __init__(self) -> None:
        self._met: dict[Any, tuple[int, Any]] = {}  # keeps the values alive, so that no id is used again

    def of(self, value: Any) -> Any:
        """Return the description of a value, or raise an exception if it has none."""
        kind = type(value)
        if kind in PLAIN:
            return [kind.__name__, repr(value)]
        if kind in (tuple, list):
            return [kind.__name__, *map(self.of, value)]
        if kind in (set, frozenset):
            return [kind.__name__, *sorted(json.dumps(self.of(one)) for one in value)]
        if kind is dict:
            return [kind.__name__, *([self.of(key), self.of(one)] for key, one in value.items())]
        if kind is CodeType:
            return [sys.version, *(self.of(getattr(value, name, None)) for name in OF_CODE)]
        return self._again(id(value), value) or self._object(value)

    def _again(self, key: Any, value: Any) -> list[Any]:
        """Return the number of a value that was met before; empty if it is new."""
        met = key in self._met
        number, _ = self._met.setdefault(key, (len(self._met), value))
        return ["again", number] if met else []

    def _object(self, value: Any) -> Any:
        if isinstance(value, COMPILED):
            (library,) = (one for one in (value._objects or {}).values() if isinstance(one, ctypes.CDLL))
            return [value.__name__, _content(library._name)]  # fails for a function made from an address
        if isinstance(value, ModuleType):
            return _version(value.__name__)
        if f"{type(value).__module__}.{type(value).__qualname__}" in WRAPPERS:  # they do what their function does
            options = getattr(getattr(value, "_compiler", None), "targetoptions", None)
            return [_version(type(value).__module__), self.of(options), self.of(value.__wrapped__)]
        if isinstance(value, FunctionType | type):
            name = value.__qualname__
        else:
            reduce: Any = copyreg.dispatch_table.get(type(value))
            name = value.__reduce_ex__(4) if reduce is None else reduce(value)
        if not isinstance(name, str):
            return ["made", *(self.of(list(part) if hasattr(part, "__next__") else part) for part in name)]
        try:
            return _reference(value, name)
        except LookupError:
            return self._function(value)

    def _function(self, function: FunctionType) -> Any:
        codes, called, named = [function.__code__], set(), set()
        for code in codes:
            codes += [one for one in code.co_consts if isinstance(one, CodeType)]
            named |= set(code.co_names)
            called |= {step.argval for step in dis.get_instructions(code) if step.opname in GLOBAL}
        held = [cell.cell_contents for cell in function.__closure__ or ()]
        parts = [function.__code__, function.__defaults__, function.__kwdefaults__, held, vars(function)]
        space = ChainMap(function.__globals__, sys.modules)
        if not called <= {*space, *dir(builtins)}:
            raise LookupError(f"must name what there is, got {called}")
        return [*map(self.of, parts), self._named(space, called, frozenset(named))]

    def _named(self, space: Mapping[str, Any], called: Any, named: frozenset[str]) -> list[Any]:
        """Describe globals by name; of a user's module, those of its attributes that the law names."""
        found = []
        for name in sorted(called & space.keys()):
            value = space[name]
            if isinstance(value, ModuleType) and not _is_published(value.__name__):
                found.append([name, self._again((id(value), named), value) or self._named(vars(value), named, named)])
            else:
                found.append([name, self.of(value)])
        return found


def _reference(value: Any, name: str) -> list[str]:
    """Describe what a library or a compiled module holds, by its name there; LookupError for other values."""
    module = sys.modules[getattr(value, "__module__", None) or pickle.whichmodule(value, name)]  # type: ignore[attr-defined]
    found: Any = module
    for part in name.split("."):
        found = getattr(found, part, None)
    if found is not value:
        raise LookupError(name)
    if _is_published(module.__name__):
        return [name, *_version(module.__name__)]
    file = str(getattr(module, "__file__", ""))
    if not file.endswith(tuple(EXTENSION_SUFFIXES)):
        raise LookupError(name)
    return [name, _content(file)]


def _is_published(module: str) -> bool:
    top = module.partition(".")[0]
    file = getattr(sys.modules[top], "__file__", None)
    own = top in sys.stdlib_module_names and (file is None or Path(file).is_relative_to(STANDARD))
    return own or top in PUBLISHED


def _version(module: str) -> list[str]:
    top = module.partition(".")[0]
    if not _is_published(module):
        raise TypeError(f"{module}: is no module with a version")
    return [module, getattr(sys.modules[top], "__version__", sys.version)]


def _content(path: str) -> str:
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()
