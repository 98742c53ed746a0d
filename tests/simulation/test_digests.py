"""The digest by which a sweep is recognised: custom laws with all that they refer to."""

import functools
import subprocess
import sys

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


def digest(force, **options):
    effect = Custom("drag", force=force, **{"parameters": {"k": 0.1}, **options})
    return digest_of(SMALL.replace(effects=[effect]), {"runs": 1})


def holding(default=1.0, keyword=1.0, inner=1.0, attribute=1.0):
    @functools.lru_cache
    def cached():
        return inner

    def law(velocity, k, default=default, *, keyword=keyword):
        return -k * default * keyword * cached() * law.attribute * velocity

    law.attribute = attribute
    return law


def by_spline(gain):
    spline = CubicSpline([-1.0, 0.0, 1.0, 2.0], [gain, 1.0, 1.0, 2.0])
    return lambda velocity, k: -k * spline(velocity) * velocity


def by_numba(gain):
    import numba

    return numba.cfunc("f8(f8, f8, f8, f8)")(lambda position, velocity, time, k: -k * gain * velocity)


WAYS = [by_spline, by_numba]
WAYS += [lambda value, way=way: holding(**{way: value}) for way in ("default", "keyword", "inner", "attribute")]


@pytest.mark.parametrize("make", WAYS)
def test_every_value_that_a_law_holds_is_in_its_digest(make):
    assert digest(make(1.0)) == digest(make(1.0))
    assert digest(make(2.0)) not in (digest(make(1.0)), None)


def test_other_code_changes_the_digest():
    laws = [
        lambda velocity, k: -k * velocity,
        lambda velocity, k: -40 * k * velocity,
        lambda velocity, k: k * -velocity,
        lambda velocity, k: -k * np.sin(velocity),
        lambda velocity, k: -k * np.tan(velocity),
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
    assert not {None, *before} & {digest(law) for law in laws}


SCRIPT = """
import numpy as np
from cogging.effects import Custom
from cogging.simulation.digests import digest_of
from tests.fixtures.sweeps import SMALL
names = {"a", "b", "c"}
def law(velocity, k):
    return -k * np.tanh(velocity) * (2.0 if "a" in {"a", "b", "c"} and "d" not in names else 3.0)
effect = Custom("drag", force=law, parameters={"k": 0.1})
print(digest_of(SMALL.replace(effects=[effect]), {"runs": 1}))
"""


def test_another_process_computes_the_same_digest(monkeypatch):
    digests = set()
    for seed in ("1", "2"):
        monkeypatch.setenv("PYTHONHASHSEED", seed)
        digests.add(subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, check=True).stdout)
    assert len(digests) == 1
    assert digests != {b"None\n"}


class OwnObject:
    gain = 1.0

    def __call__(self, velocity, k):
        return -k * self.gain * velocity


def test_a_law_that_cannot_be_described_has_no_digest():
    held = OwnObject()
    for law in (held, held.__call__, lambda velocity, k: -k * held.gain * velocity):
        assert digest(law) is None
