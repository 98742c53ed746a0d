"""Each library gives the core's answer, so the benchmark compares like with like."""

import pytest

from tests.benchmarks import child, peers


@pytest.mark.parametrize("name", [name for name in peers.installed() if name != "cogging"])
def test_a_library_gives_the_same_answer(name):
    off = child.call(peers.differences, [name], 4, 121)  # JAX has threads that a later fork would not like
    assert off[name] < 1e-9
