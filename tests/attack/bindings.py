"""Calls of the bindings: arguments of wrong shape, kind, layout and life, from several threads, drawn by a seed.

A case is sound when it returns, or raises one of ERRORS with words of ours. What counts as a fault: a crash (the
process is watched from outside), a hang, SystemError, an exception that shows the insides of a library, and a truth
value or a text of digits that was taken for a number.
"""

from __future__ import annotations

import copy
import functools
import gc
import pickle
import re
import threading
from typing import Any

import numpy as np

from cogging import _core
from tests.attack.binding_values import Pool, hostile, raw, sound
from tests.attack.core_signatures import Target, targets

ERRORS = (TypeError, ValueError, OverflowError, IndexError, KeyError, AttributeError, RuntimeError, StopIteration)
ERRORS = (*ERRORS, MemoryError, KeyboardInterrupt, NotImplementedError)
INSIDES = re.compile(r"std::|vector::|basic_string|bad_alloc|map::at|_M_|Eigen|assert")
NUMERIC = re.compile(r"\b(float|int|ArrayLike|NDArray)\b")
#: A thread that heeds a flag which is set does nothing more in the core: that is what heed() is for.
LEFT_OUT = "StopFlag.heed"


@functools.cache
def callables() -> list[Target]:
    """What is called."""
    return [target for target in targets() if str(target) != LEFT_OUT]


def run_case(seed: int) -> str | None:
    """Make one call; a sentence about what is wrong with how it ended, None where it ended as it should."""
    random = np.random.default_rng([2026, seed])
    pool = Pool()  # anew, so that a seed alone tells the case
    target = callables()[random.integers(len(callables()))]
    owner = _owner(target)
    subject = None if owner is None else _subject(owner, target, random, pool)
    positional, named = _arguments(target, random, pool)
    faults: list[str] = []

    def call() -> None:
        fault = _judge(target, subject, positional, named, random.random() < 0.2)
        if fault:
            faults.append(fault)

    if random.random() < 0.05:
        threads = [threading.Thread(target=call) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    else:
        call()
    worst = next((fault for fault in faults if not fault.startswith("~")), faults[0] if faults else None)
    return worst if worst is None or worst.startswith("~") else f"{target}: {worst}"


def _owner(target: Target) -> Any:
    module = getattr(_core, target.module) if target.module else _core
    return getattr(module, target.owner, None) if target.owner else None


def _subject(owner: Any, target: Target, random: np.random.Generator, pool: Pool) -> Any:
    """What a method is called of: a sound object, a copy, one never initialised, or one of another class."""
    if target.name == "__init__" or target.is_static:
        return owner
    chance = random.random()
    value = pool.get(target.owner)
    if chance < 0.1 or value is None:
        return raw(owner)
    if chance < 0.15:
        return pool[str(random.choice(list(pool)))]
    if chance < 0.4:
        try:
            return copy.deepcopy(value) if chance < 0.3 else pickle.loads(pickle.dumps(value))
        except ERRORS:
            return value
    return value


def _arguments(target: Target, random: np.random.Generator, pool: Pool) -> tuple[list[Any], dict[str, Any]]:
    positional: list[Any] = []
    named: dict[str, Any] = {}
    wrong = random.random() < 0.7
    for parameter in target.parameters:
        if not parameter.required and random.random() < 0.5:
            continue
        bad = wrong and random.random() < 0.5
        value = hostile(random, pool) if bad else sound(parameter.name, parameter.annotation, random, pool)
        if parameter.keyword_only or not parameter.required or named:
            named[parameter.name] = value
        else:
            positional.append(value)
    if random.random() < 0.03:
        positional = positional[:-1]
    if random.random() < 0.03:
        named["no_such_argument"] = 1
    return positional, named


def _judge(target: Target, subject: Any, positional: list[Any], named: dict[str, Any], alone: bool) -> str | None:
    try:
        if target.is_property:
            result = getattr(subject, target.name)
        elif not target.owner:
            module = getattr(_core, target.module) if target.module else _core
            result = getattr(module, target.name)(*positional, **named)
        elif target.name == "__init__":
            result = subject(*positional, **named)
        else:
            result = getattr(subject, target.name)(*positional, **named)
        taken = taken_for_number(target, positional, named)
        if alone:  # what comes back must live on when all that it was made of is gone
            del subject, positional, named
            gc.collect()
        _use(result)
        return taken
    except ERRORS as error:
        if INSIDES.search(str(error)):
            return f"{type(error).__name__} shows the insides of a library: {error}"
    except BaseException as error:
        return f"{type(error).__name__}: {error}"
    return None


def taken_for_number(target: Target, positional: list[Any], named: dict[str, Any]) -> str | None:
    """What a call took for a number that is none."""
    if target.name == "__setstate__":  # of a pickle, which is trusted
        return None
    given = {parameter.name: value for parameter, value in zip(target.parameters, positional, strict=False)} | named
    for parameter in target.parameters:
        numeric = NUMERIC.search(parameter.annotation)
        if numeric and "str" not in parameter.annotation and _no_number(given.get(parameter.name)):
            return f"{parameter.name} took {given[parameter.name]!r} for a number"[:200]
    return None


def _no_number(value: Any) -> bool:
    if isinstance(value, np.ndarray):
        return bool(value.size) and (value.dtype.kind in "bSU" or _no_number(value.tolist()))
    if isinstance(value, list | tuple):
        return any(map(_no_number, value))
    return isinstance(value, bool | np.bool_ | str | bytes)


def _use(result: Any) -> None:
    """Look at all that came back: every number is read, every member asked."""
    if isinstance(result, np.ndarray):
        np.asarray(result, dtype=object).sum() if result.dtype == object else result.tobytes()
    elif isinstance(result, dict):
        for value in result.values():
            _use(value)
    elif isinstance(result, list | tuple):
        for value in result[:50]:
            _use(value)
    elif type(result).__module__.startswith("cogging"):
        repr(result)
        for name in vars(type(result)):
            if isinstance(vars(type(result))[name], property):
                getattr(result, name)
