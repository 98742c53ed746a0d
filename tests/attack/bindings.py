"""Calls of the bindings with arguments of wrong shape, kind, layout and life, from several threads, drawn by a seed.

A call may return, or raise one of ERRORS with words of ours. Faults are a crash (processes are watched from outside), a
hang, any other exception, one that shows the insides of a library, and a truth value or text taken for a number.
"""

import copy
import functools
import gc
import pickle
import re
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from tests.attack.binding_values import Pool, hostile, raw, sound
from tests.attack.core_signatures import Target, targets

ERRORS = (TypeError, ValueError, OverflowError, IndexError, KeyError, AttributeError, RuntimeError, StopIteration)
ERRORS = (*ERRORS, MemoryError, KeyboardInterrupt, NotImplementedError)
INSIDES = re.compile(r"std::|vector::|basic_string|bad_alloc|map::at|_M_|Eigen|assert")
NUMERIC = re.compile(r"\b(float|int|ArrayLike|NDArray)\b")


@functools.cache
def callables() -> list[Target]:
    """What is called; heed() would bind this thread to a flag for good."""
    return [target for target in targets() if str(target) != "StopFlag.heed"]


def run_case(seed: int) -> str | None:
    """Make one call; what is wrong with how it ended, or None."""
    random = np.random.default_rng([2026, seed])
    pool = Pool()  # anew, so that a seed alone determines the case
    target = callables()[random.integers(len(callables()))]
    subject = subject_of(target, random, pool)
    positional, named = arguments_of(target, random, pool)
    alone, faults = random.random() < 0.2, []

    def call() -> None:
        faults.append(fault_of(target, subject, positional, named, alone))

    if random.random() < 0.05:
        with ThreadPoolExecutor(3) as threads:
            for _ in range(3):
                threads.submit(call)
    else:
        call()
    found = next(filter(None, faults), None)
    return found and f"{target}: {found}"


def subject_of(target: Target, random: np.random.Generator, pool: Pool) -> Any:
    """What a method is called of: a sound object, a copy, one never initialised, or one of another class."""
    if not target.owner or target.name == "__init__" or target.is_static:
        return target.place
    chance, value = random.random(), pool.get(target.owner)
    if chance < 0.1 or value is None:
        return raw(target.place)
    if chance < 0.15:
        return pool[str(random.choice(list(pool)))]
    if chance < 0.4:
        try:
            return copy.deepcopy(value) if chance < 0.3 else pickle.loads(pickle.dumps(value))
        except ERRORS:
            return value
    return value


def arguments_of(target: Target, random: np.random.Generator, pool: Pool) -> tuple[list[Any], dict[str, Any]]:
    """Arguments by position and by name, some of them hostile."""
    positional: list[Any] = []
    named: dict[str, Any] = {}
    wrong = 0.5 if random.random() < 0.7 else 0.0
    for parameter in target.parameters:
        if parameter.default is not parameter.empty and random.random() < 0.5:
            continue
        bad = random.random() < wrong
        value = hostile(random, pool) if bad else sound(parameter.name, parameter.annotation, random, pool)
        if parameter.kind is parameter.KEYWORD_ONLY or parameter.default is not parameter.empty or named:
            named[parameter.name] = value
        else:
            positional.append(value)
    if random.random() < 0.03:
        positional = positional[:-1]
    if random.random() < 0.03:
        named["no_such_argument"] = 1
    return positional, named


def fault_of(target: Target, subject: Any, positional: list[Any], named: dict[str, Any], alone: bool) -> str | None:
    """Make the call and use its result; what is wrong."""
    try:
        found = subject if target.name == "__init__" else getattr(subject, target.name)
        result = found if target.is_property else found(*positional, **named)
        taken = taken_for_number(target, positional, named)
        if alone:  # the result must live on when all that it was made of is gone
            del subject, positional, named, found
            gc.collect()
        use(result)
        return taken
    except ERRORS as error:
        return f"{type(error).__name__} shows the insides of a library: {error}" if INSIDES.search(str(error)) else None
    except BaseException as error:
        return f"{type(error).__name__}: {error}"


def taken_for_number(target: Target, positional: list[Any], named: dict[str, Any]) -> str | None:
    """An argument that a call took for a number and that is none; a pickle is trusted."""
    given = {parameter.name: value for parameter, value in zip(target.parameters, positional, strict=False)} | named
    for parameter in target.parameters if target.name != "__setstate__" else ():
        numeric = NUMERIC.search(parameter.annotation)
        if numeric and "str" not in parameter.annotation and is_no_number(given.get(parameter.name)):
            return f"{parameter.name} took {given[parameter.name]!r} for a number"[:200]
    return None


def is_no_number(value: Any) -> bool:
    """Whether a value is, or holds, a truth value or a text."""
    if isinstance(value, np.ndarray):
        return bool(value.size) and (value.dtype.kind in "bSU" or is_no_number(value.tolist()))
    if isinstance(value, list | tuple):
        return any(map(is_no_number, value))
    return isinstance(value, bool | np.bool_ | str | bytes)


def use(result: Any) -> None:
    """Read every number and member of a result."""
    if isinstance(result, np.ndarray):
        np.asarray(result, dtype=object).sum() if result.dtype == object else result.tobytes()
    elif isinstance(result, dict | list | tuple):
        for value in list(result.values() if isinstance(result, dict) else result)[:50]:
            use(value)
    elif type(result).__module__.startswith("cogging"):
        repr(result)
        for name, member in vars(type(result)).items():
            if isinstance(member, property):
                getattr(result, name)
