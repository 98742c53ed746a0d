"""The digest by which a sweep is recognised: custom laws with all that they refer to."""

import ctypes
import functools
import os
import shutil
import subprocess
import sys
import types
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from cogging.effects import Custom
from cogging.simulation.digests import digest_of
from tests.fixtures.sweeps import SMALL

GAIN, TABLE = 1.0, {"gain": 1.0}
SLOPES = np.array([1.0, 2.0])


def named(velocity):
    return GAIN * velocity


def drag(force, **options):
    parameters = options.pop("parameters", {"k": 0.1})
    return SMALL.replace(effects=[Custom("drag", force=force, parameters=parameters, **options)])


def digest(force, **options):
    return digest_of(drag(force, **options), {"runs": 1})


def by_default(gain):
    def law(velocity, k, gain=gain):
        return -k * gain * velocity

    return law


def by_keyword(gain):
    def law(velocity, *, k, gain=gain):
        return -k * gain * velocity

    return law


def by_inner_function(gain):
    @functools.lru_cache
    def cached():
        return gain

    return lambda velocity, k: -k * cached() * velocity


def by_attribute(gain):
    def law(velocity, k):
        return -k * law.gain * velocity

    law.gain = gain
    return law


def by_wrapper(gain):
    @functools.wraps(np.mean)  # whose name and module it then has
    def law(velocity, k):
        return -k * gain * velocity

    del law.__wrapped__
    return law


def by_partial(gain):
    plain = functools.partial(lambda velocity, k, gain: -k * gain * velocity, gain=gain)
    return functools.update_wrapper(plain, lambda velocity, k: 0.0)


def by_spline(gain):
    spline = CubicSpline([-1.0, 0.0, 1.0, 2.0], [gain, 1.0, 1.0, 2.0])
    return lambda velocity, k: -k * spline(velocity) * velocity


def by_numba(gain):
    import numba

    return numba.cfunc("f8(f8, f8, f8, f8)")(lambda position, velocity, time, k: -k * gain * velocity)


def by_imported_module(gain):
    """A module of the user that law and module name in turn."""
    module = types.ModuleType("own_laws_of_a_test")
    code = f"import {module.__name__}\ngain = {gain}\ndef force(v):\n    return {module.__name__}.gain * v\n"
    sys.modules[module.__name__] = module
    exec(code, vars(module))

    def law(velocity, k):
        import own_laws_of_a_test

        return -k * own_laws_of_a_test.force(velocity)

    return law


HOLDING = [by_default, by_keyword, by_inner_function, by_attribute, by_wrapper, by_partial, by_spline, by_numba]


@pytest.mark.parametrize("make", [*HOLDING, by_imported_module])
def test_a_held_value_changes_the_digest(make):
    one = digest(make(2.0))
    assert one is not None
    assert digest(make(2.0)) == one
    assert digest(make(3.0)) != one


def test_other_code_changes_the_digest():
    laws = [
        lambda velocity, k: -k * velocity,
        lambda velocity, k: -40 * k * velocity,
        lambda velocity, k: k * -velocity,
        lambda velocity, k: -k * np.sin(velocity),
        lambda velocity, k: -k * np.tan(velocity),
        lambda velocity, k: -k * abs(velocity),
        lambda position, k: -k * position,
        lambda velocity, k: -k * (lambda: 1.0)() * velocity,
        lambda velocity, k: -k * (lambda: 2.0)() * velocity,
    ]
    assert len({digest(law) for law in laws} - {None}) == len(laws)
    assert digest(laws[0], length_scale=1e-3) != digest(laws[0])
    assert digest(laws[0], parameters={"k": 0.2}) != digest(laws[0])


def test_a_named_global_changes_the_digest(monkeypatch):
    laws = [
        lambda velocity, k: -k * named(velocity),
        lambda velocity, k: -k * TABLE["gain"] * velocity,
        lambda velocity, k: -k * SLOPES[1] * velocity,
    ]
    before = [digest(law) for law in laws]
    monkeypatch.setitem(globals(), "GAIN", 2.0)
    monkeypatch.setitem(TABLE, "gain", 2.0)
    monkeypatch.setitem(globals(), "SLOPES", np.array([1.0, 3.0]))
    after = [digest(law) for law in laws]
    assert not {None, *before} & set(after)


def test_a_compiled_law_is_described_by_its_file(tmp_path):
    compiler = shutil.which(os.environ.get("CC", "cc"))
    assert compiler, "the package was built with one"

    def law(gain):
        (tmp_path / "law.c").write_text(f"double f(double x, double v, double t, double k) {{return -k * {gain} * v;}}")
        library = tmp_path / f"law{gain}.so"
        subprocess.run([compiler, "-shared", "-fPIC", "-o", library, tmp_path / "law.c"], check=True)
        library.rename(tmp_path / "law.so")
        shutil.copy(tmp_path / "law.so", library)  # else the loader gives what it has loaded from there before
        function = ctypes.CDLL(str(library)).f
        function.argtypes, function.restype = [ctypes.c_double] * 4, ctypes.c_double
        return function

    one = digest(law(2))
    assert one is not None
    assert digest(law(2)) == one
    assert digest(law(3)) != one


SCRIPT = """
import numpy as np
from cogging.simulation.digests import digest_of
from cogging.effects import Custom
from tests.fixtures.sweeps import SMALL
names = {"a", "b", "c"}
def law(velocity, k):
    return -k * np.tanh(velocity) * (2.0 if "a" in {"a", "b", "c"} and "d" not in names else 3.0)
effect = Custom("drag", force=law, parameters={"k": 0.1})
print(digest_of(SMALL.replace(effects=[effect]), {"runs": 1}))
"""


def test_another_process_computes_the_same_digest():
    digests = set()
    for seed in ("1", "2"):
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        )
        digests.add(done.stdout)
    assert len(digests) == 1
    assert digests != {"None\n"}


@dataclass
class OwnObject:
    gain: float

    def __call__(self, velocity, k):
        return -k * self.gain * velocity


def of_an_address():
    kind = ctypes.CFUNCTYPE(*[ctypes.c_double] * 5)
    return kind(ctypes.cast(ctypes.CDLL(None).cos, ctypes.c_void_p).value)


def holding(one):
    return lambda velocity, k: -k * one.gain * velocity


UNDESCRIBED = {
    "object": lambda: OwnObject(1.0),
    "method": lambda: OwnObject(1.0).__call__,
    "holds an object": lambda: holding(OwnObject(1.0)),
    "address": of_an_address,
}


@pytest.mark.parametrize("make", UNDESCRIBED.values(), ids=UNDESCRIBED)
def test_a_law_that_cannot_be_described_has_no_digest(make):
    assert digest(make()) is None
