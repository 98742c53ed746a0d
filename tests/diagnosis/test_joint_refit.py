"""A fit of all that was found together leaves no larger gap than the fit before it."""

import re

import pytest

import cogging
from tests.fixtures import iron_core

FAST_FIRST = (0.35, 0.2, 0.1, 0.05)


@pytest.mark.parametrize("known_map", [True, pytest.param(False, marks=pytest.mark.study)])
def test_no_effect_makes_the_gap_larger_by_its_refit(known_map):
    """A real ripple of the force constant, beside a cable and a bump; without the map of the cogging beside that."""
    logs = [iron_core.log(1, 10.0), iron_core.log(2, 10.0, FAST_FIRST)]
    result = cogging.diagnose(logs[0], iron_core.model(known_map=known_map), confirm=logs[1])
    added = [step for step in result.ledger if step.accepted]
    assert added
    for step in added:
        assert step.gap_after <= 1.01 * step.gap_before, (step.name, step.gap_before, step.gap_after)
    for step in result.ledger:
        if grown := re.match(r"the gap goes from (\S+) to (\S+)", step.reason):
            assert float(grown[2]) <= 1.01 * float(grown[1]), (step.name, step.reason)
