"""The same bits in another process, whatever surrounds it: `python -m tests.attack.same_bits`, in short."""

import platform

import pytest

from tests.fixtures.same_bits import CALLS, Condition, answer, difference, written

#: Other surroundings, all at once.
SURROUNDINGS = {"PYTHONHASHSEED": "4711", "LC_ALL": "C", "TZ": "Pacific/Auckland"}
SURROUNDINGS |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "2")
#: What an older processor of the same kind would choose: one run at a time, the oldest kernels, nothing fused.
OLDER = {"COGGING_INSTRUCTIONS": "none"}
if platform.machine().lower() in ("x86_64", "amd64"):
    OLDER |= {"OPENBLAS_CORETYPE": "Nehalem", "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F"}


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("same") / "inputs"
    written(folder)
    return folder


@pytest.mark.parametrize("name", ["simulate", "identify"])
def test_other_surroundings_give_the_same_bits(name, inputs, tmp_path):
    other = Condition("other surroundings", SURROUNDINGS | (OLDER if CALLS[name].core else {}), folder="dé, other")
    usual = answer(name, Condition("usual"), inputs, tmp_path)
    assert difference(usual, answer(name, other, inputs, tmp_path)) == 0.0
