"""What else runs such loops gives the core's answer; times are for the command."""

import pytest

from tests.benchmarks import peers


@pytest.mark.parametrize("name", [name for name in peers.installed() if name != "cogging"])
def test_a_peer_gives_the_same_answer(name):
    off = peers.in_a_process("--compare", 4, 121, name)  # JAX has threads that a later fork would not like
    assert off[name] < 1e-9
