"""The same bits in another process, whatever surrounds it: `python -m tests.attack.same_bits`, in short."""

import platform

import pytest

from tests.attack.same_bits import CORE_ALONE, OLD_LIBRARY, THREADS, Condition, answer, difference, write_inputs

#: Other surroundings, all at once.
SURROUNDINGS = {"PYTHONHASHSEED": "4711", "LC_ALL": "C", "TZ": "Pacific/Auckland", **dict.fromkeys(THREADS, "2")}
#: What an older processor of the same kind would choose: one run at a time, the oldest kernels, nothing fused.
OLDER = {"COGGING_INSTRUCTIONS": "none"}
if platform.machine().lower() in ("x86_64", "amd64"):
    OLDER |= {"OPENBLAS_CORETYPE": "Nehalem", "GLIBC_TUNABLES": OLD_LIBRARY}


@pytest.mark.parametrize("name", ["simulate", "identify"])
def test_other_surroundings_give_the_same_bits(name, tmp_path):
    write_inputs(tmp_path / "inputs")
    other = Condition("other surroundings", SURROUNDINGS | (OLDER if name in CORE_ALONE else {}), folder="dé, other")
    usual = answer(name, Condition("usual"), tmp_path / "inputs", tmp_path)
    assert difference(usual, answer(name, other, tmp_path / "inputs", tmp_path)) == 0.0
