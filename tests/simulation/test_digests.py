"""What a sweep is known by when it goes on: laws of the user's own with all that they name and hold."""

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

import cogging
from cogging.effects import Custom
from cogging.simulation import sweep as sweeps
from cogging.simulation.digests import digest_of
from tests.fixtures.sweeps import FEW, MANY, MOVE, SMALL, same

GAIN, TABLE = 1.0, {"gain": 1.0}
SLOPES = np.array([1.0, 2.0])


def named(velocity):
    return GAIN * velocity


def drag(force, **options):
    parameters = options.pop("parameters", {"k": 0.1})
    return SMALL.replace(effects=[Custom("drag", force=force, parameters=parameters, **options)])


def digest(force, **options):
    return digest_of(drag(force, **options), {"runs": 1})


def closed_over(gain):
    return lambda velocity, k: -k * gain * velocity


def by_default(gain):
    def law(velocity, k, gain=gain):
        return -k * gain * velocity

    return law


def by_keyword(gain):
    def law(velocity, *, k, gain=gain):
        return -k * gain * velocity

    return law


def by_inner_function(gain):
    def inner(velocity):
        return gain * velocity

    return lambda velocity, k: -k * inner(velocity)


def by_cache(gain):
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


def by_module(gain):
    """A module of the user's own that law and module name in turn."""
    module = types.ModuleType("own_laws_of_a_test")
    code = f"import {module.__name__}\ngain = {gain}\ndef force(v):\n    return {module.__name__}.gain * v\n"
    sys.modules[module.__name__] = module
    exec(code, vars(module))
    space = {module.__name__: module}
    exec(f"law = lambda velocity, k: -k * {module.__name__}.force(velocity)", space)
    return space["law"]


def by_import(gain):
    by_module(gain)

    def law(velocity, k):
        import own_laws_of_a_test

        return -k * own_laws_of_a_test.force(velocity)

    return law


HOLDING = [
    *(closed_over, by_default, by_keyword, by_inner_function, by_cache, by_attribute, by_wrapper, by_partial),
    *(by_spline, by_numba, by_module, by_import),
]


@pytest.mark.parametrize("make", HOLDING)
def test_what_a_law_holds_is_of_the_law(make):
    one = digest(make(2.0))
    assert one is not None
    assert digest(make(2.0)) == one
    assert digest(make(3.0)) != one


def test_the_code_of_a_law_is_of_the_law():
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


def test_a_global_that_a_law_names_is_of_the_law(monkeypatch):
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


def test_a_compiled_law_is_its_file(tmp_path):
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
from tests.simulation.test_digests import drag
names = {"a", "b", "c"}
def law(velocity, k):
    return -k * np.tanh(velocity) * (2.0 if "a" in {"a", "b", "c"} and "d" not in names else 3.0)
print(digest_of(drag(law), {"runs": 1}))
"""


def test_another_process_knows_the_law_again():
    told = set()
    for seed in ("1", "2"):
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        )
        told.add(done.stdout)
    assert len(told) == 1
    assert told != {"None\n"}


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


UNKNOWN = {
    "object": lambda: OwnObject(1.0),
    "method": lambda: OwnObject(1.0).__call__,
    "holds an object": lambda: holding(OwnObject(1.0)),
    "address": of_an_address,
}


@pytest.mark.parametrize("make", UNKNOWN.values(), ids=UNKNOWN)
def test_a_law_of_which_nothing_can_be_said_is_none(make):
    assert digest(make()) is None


# Sweeps and tunings that go on ----------------------------------------------------------------------------------------


class Ended(Exception):
    pass


def ended(model, out, monkeypatch):
    """A sweep that was ended at its middle."""
    plain = sweeps.run_piece

    def run_piece(piece):
        if piece.first >= 160:
            raise Ended
        return plain(piece)

    with monkeypatch.context() as patch:
        patch.setattr(sweeps, "run_piece", run_piece)
        with pytest.raises(Ended):
            cogging.sweep(model, MOVE, MANY, out=out, **FEW)


def test_a_sweep_does_not_go_on_with_another_law(tmp_path, monkeypatch):
    """Before, half of the rows were those of the first law, without a word."""
    out = tmp_path / "runs.csv"
    ended(drag(lambda velocity, k: -k * velocity), out, monkeypatch)
    with pytest.raises(cogging.InputError, match=r"runs\.csv\.pieces: holds pieces of another sweep"):
        cogging.sweep(drag(lambda velocity, k: -40 * k * velocity), MOVE, MANY, out=out, **FEW)
    made, plain = [], sweeps.run_piece
    monkeypatch.setattr(sweeps, "run_piece", lambda piece: made.append(piece.first) or plain(piece))
    again = drag(lambda velocity, k: -k * velocity)
    same(cogging.sweep(again, MOVE, MANY, out=out, **FEW), cogging.sweep(again, MOVE, MANY, **FEW))
    assert made[:20] == list(range(160, 320, 8)), "finished runs are not made again"


def test_a_sweep_of_a_law_that_is_unknown_begins_anew(tmp_path, monkeypatch):
    out, model = tmp_path / "runs.csv", drag(OwnObject(1.0))
    ended(model, out, monkeypatch)
    assert list(tmp_path.iterdir()) == []
    other = drag(OwnObject(40.0))
    same(cogging.sweep(other, MOVE, MANY, out=out, **FEW), cogging.sweep(other, MOVE, MANY, **FEW))
    assert [path.name for path in tmp_path.iterdir()] == ["runs.csv"]
    with pytest.raises(cogging.InputError, match=r"^.*cannot be written: No such file or directory$"):
        cogging.sweep(model, MOVE, MANY, out=tmp_path / "none" / "runs.csv", **FEW)


def test_a_tuning_does_not_go_on_with_another_law(tmp_path):
    options = {"trials": 4, "machines": 1, "held_out": 1, "duration": 0.1, "out": tmp_path / "tuned.toml"}
    gains = {"controller.kp": {"from": 5e3, "to": 2e4}}

    def ends(step):
        if step.startswith("trial 2"):
            raise Ended

    with pytest.raises(Ended):
        cogging.tune(drag(lambda velocity, k: -k * velocity), MOVE, gains, progress=ends, **options)
    assert (tmp_path / "tuned.toml.trials").exists()
    with pytest.raises(cogging.InputError, match=r"tuned\.toml\.trials: holds trials of another tuning"):
        cogging.tune(drag(lambda velocity, k: -40 * k * velocity), MOVE, gains, **options)
