"""Arguments for the core: sound ones by annotation and name, and ones that no careful caller would give."""

from __future__ import annotations

import ctypes
import inspect
import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np

from cogging import _core
from tests.fixtures import examples

Random = np.random.Generator
#: Sizes stay below this, so that what is asked for fits into memory: what does not is another test.
MOST = 300
KIND = re.compile(r"\b(?:effects\.)?([A-Z]\w+)\b")
FLOATS = (0.0, -0.0, 1.0, -1.0, 0.5, 1e-3, 1e3, 1e-300, 5e-324, 1e300, 1.7e308, math.inf, -math.inf, math.nan, 2.0**63)
INTEGERS = (0, 1, -1, 2, 3, 7, 64, 255, 2**15, 2**31 - 1, 2**31, -(2**31) - 1, 2**32, 2**63 - 1, 2**63, 2**64, 10**30)
TEXTS = ("", "position", "error_rms", "x" * 5000, "\0", "é\u202e", "%s%n", "nan", "1", "reference", "measured", "euler")
MIXED = ([[1.0, 2.0], [3.0]], [True, 2.0], [1, False], ["1.5", "2"], [[1.0, True]], (np.True_, 1.0))

DTYPES = ("<f8", ">f8", "<f4", "<i8", "<u1", "?", "<c16", "O", "U3", "<f2")


class Hostile:
    """An object whose every conversion fails in its own way."""

    def __init__(self, error: type[Exception] = ValueError) -> None:
        self.error = error

    def _fail(self, *_: Any, **__: Any) -> Any:
        raise self.error("no such value")

    __float__ = __index__ = __int__ = __len__ = __iter__ = __getitem__ = __call__ = __array__ = __bool__ = _fail


class Odd(float):
    """A float that is another each time."""

    def __float__(self) -> float:
        return float(np.random.default_rng().normal())


PLAIN = (None, True, False, {}, 1j, range(7), ctypes.c_double(1.0), lambda *_: math.nan, Odd(1.0))


def array(random: Random) -> Any:
    """An array of any shape, kind and layout."""
    shape = tuple(int(size) for size in random.choice([0, 1, 2, 3, 4, 7, 50, MOST], random.choice([0, 1, 1, 1, 2, 3])))
    values = np.asarray(random.normal(size=shape[: 1 if math.prod(shape) > 20_000 else None]))
    values = np.asarray(values * 10.0 ** random.integers(-6, 6))
    if random.random() < 0.3:
        values[random.random(values.shape) < 0.2] = random.choice([np.nan, np.inf, -np.inf, 1e308])
    if random.random() < 0.3:
        with np.errstate(all="ignore"):
            values = values.astype(str(random.choice(DTYPES)))
    layout = random.integers(0, 6)
    if layout == 0 and values.ndim:
        return values[::-1]
    if layout == 1 and values.ndim:
        return np.repeat(values, 2, axis=0)[::2]
    if layout == 2:
        return values.T
    if layout == 3 and values.size:
        return np.broadcast_to(values.ravel()[:1], (7,))
    values.flags.writeable = layout != 4
    return values


def hostile(random: Random, pool: Pool) -> Any:
    """Anything but what is asked for, and now and then that."""

    def one(values: Any) -> Any:
        return values[random.integers(len(values))]

    def pooled() -> Any:
        return pool[one(list(pool))]

    choices: list[Callable[[], Any]] = [
        lambda: one(PLAIN),
        lambda: one(FLOATS),
        lambda: one(INTEGERS),
        lambda: one(TEXTS),
        lambda: one(TEXTS).encode("utf-8", "surrogatepass"),
        *[lambda: array(random)] * 3,
        lambda: [one(FLOATS) for _ in range(random.integers(0, 9))],
        lambda: one(MIXED),
        lambda: np.array(one([[True, False], ["1", "2"], [1, "2"], [b"1"]])),
        lambda: np.array(one([[1.0, True], ["1.5", 2], [1, 2.0]]), dtype=object),
        lambda: Hostile(one([ValueError, TypeError, KeyboardInterrupt, RuntimeError, StopIteration])),
        lambda: (value for value in (1.0, 2.0)),
        lambda: memoryview(np.arange(float(random.integers(1, 9)))),
        pooled,
        lambda: [pooled()] * int(random.integers(0, 4)),
        lambda: raw(type(pooled())),
        lambda: type(pooled()),
    ]
    return one(choices)()


def raw(kind: type) -> Any:
    """An object whose __init__ never ran, where there may be one."""
    try:
        return kind.__new__(kind)
    except TypeError:
        return None


def sound(name: str, annotation: str, random: Random, pool: Pool) -> Any:
    """What an argument of this name and annotation may be."""
    for known in KIND.findall(annotation):
        if known in pool:
            return [pool[known]] * int(random.integers(0, 3)) if "Sequence[" in annotation else pool[known]
    if name in ("controller", "controllers"):
        one = pool[str(random.choice(["Pid", "Cascade", "Arc", "ObserverBased", "CompiledController"]))]
        return [one] * int(random.integers(1, 3)) if name.endswith("s") else one
    if "ndarray" in annotation.lower() or "ArrayLike" in annotation:
        if name in ("time",):
            return np.cumsum(random.uniform(1e-4, 2e-4, 50))
        return random.normal(size=50) * 1e-3
    if "Sequence[" in annotation:
        return (random.normal(size=int(random.integers(0, 5))) * 0.1).tolist()
    if "bytes" in annotation:
        return b"1.0,2.0\n"
    if annotation == "str":
        return "own"
    if annotation == "bool":
        return bool(random.integers(2))
    if annotation == "int":
        return int(random.integers(0, 5))
    return float(10.0 ** random.uniform(-3, 1))


class Pool(examples.Examples):
    """One sound object of each class of the core by its name, made anew when it is first asked for."""

    def __init__(self) -> None:
        super().__init__(MAKERS)


TIME = np.linspace(0.0, 0.1, 50)
#: Every class of the core by its name, but for exceptions.
CLASSES = {
    name: kind
    for module in (_core, _core.effects)
    for name, kind in vars(module).items()
    if inspect.isclass(kind) and not issubclass(kind, Exception)
}
MAKERS: dict[str, Callable[[], Any]] = {
    **{name: kind for name, kind in CLASSES.items() if hasattr(kind, "FIELDS")},
    **{name: make for name, make in examples.MAKERS.items() if name in CLASSES},
    "Predictor": lambda: _core.Predictor(TIME, 0.1 * TIME, TIME),
    "Prediction": lambda: MAKERS["Predictor"]().predict(examples.PLANT),
    "StopFlag": _core.StopFlag,
    "Reference": examples.MAKERS["Sine"],
}
