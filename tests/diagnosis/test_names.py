"""Names, and how far they are doubted."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from cogging import EFFECTS
from cogging.diagnosis.naming.names import fully_named, named
from cogging.diagnosis.search.search import search
from cogging.effects.effect import VOCABULARY
from tests.fixtures.moving_axis import machine, record


@pytest.mark.parametrize(("terms", "expected"), [(3, ["encoder_periodic_error"]), (2, [])])
def test_a_wave_beside_as_many_terms_as_a_name_may_have_is_doubtful(terms, expected):
    names = [*["encoder_periodic_error"] * terms, "disturbance_tone", "cable_spring"]
    added = [SimpleNamespace(finding=SimpleNamespace(name=name)) for name in names]
    found = SimpleNamespace(added=added, vocabulary=VOCABULARY)
    assert fully_named(found, terms) == expected
    assert fully_named(found, terms + 1) == []  # no wave
    assert fully_named(found, 0) == []


def test_a_name_is_doubted_where_more_was_refused_than_added():
    told = search([record(machine([EFFECTS["cable_spring"](stiffness=1.5)]), 33)], machine())
    plain, finding = named(told, 0, []), told.added[0].finding
    largest = max(added.finding.test.statistic for added in told.added)
    for factor, doubted in ((1.1, True), (0.9, False)):
        test = replace(finding.test, statistic=factor * largest)
        refused = replace(finding, test=test, log_p_value=-60.0)
        again = named(replace(told, unused=[refused]), 0, [])
        assert again.confidence == pytest.approx(plain.confidence * (0.75 if doubted else 1.0), abs=0.002)
    faint = replace(finding, test=replace(finding.test, statistic=1.1 * largest), log_p_value=-20.0)
    assert named(replace(told, unused=[faint]), 0, []).confidence == plain.confidence
