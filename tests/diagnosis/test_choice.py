"""The choice among findings."""

import numpy as np
import pytest

from cogging.diagnosis.candidates.findings import Finding
from cogging.diagnosis.candidates.signatures import Candidate
from cogging.diagnosis.evidence.score_test import ScoreTest
from cogging.diagnosis.search.choice import choose, is_rounding, is_seen, needed, plainer, told_apart
from cogging.diagnosis.search.confirmation import Confirmation
from cogging.effects.effect import VOCABULARY


@pytest.mark.parametrize(
    ("alone", "noncentrality", "other_power", "told"),
    [
        (-10.0, None, 0.0, True),
        (-9.0, None, 0.0, False),
        (-4.0, 40.0, 1000.0, True),
        (-4.0, 12.0, 1000.0, False),  # both together, less than is asked of them
        (-4.0, 40.0, 1e4, False),  # nothing worth a name on the other motion
    ],
)
def test_both_motions_together_may_show_what_neither_shows_alone(alone, noncentrality, other_power, told):
    test = ScoreTest(12.0, 1, np.ones(1), np.ones(3), np.ones(1))
    finding = Finding(Candidate(VOCABULARY["cable_spring"], {}, (), ()), test, np.ones(1), 1.0, alone, 10.0)
    check = None if noncentrality is None else Confirmation(noncentrality, 1.0, noncentrality)
    assert is_seen(finding, check, 1000.0, other_power) is told


def test_what_rounding_explains_better_is_no_effect():
    def finding(name, score, explained, faint=False):
        test = ScoreTest(score, 2, np.ones(2), np.array(explained), np.ones(2))
        return Finding(
            Candidate(VOCABULARY[name], {"period": 0.01}, (), ()), test, np.ones(2), 1.0, -30.0, score, faint
        )

    force = finding("cogging_harmonic", 50.0, [1.0, 2.0, 0.0])
    stronger = finding("encoder_periodic_error", 60.0, [1.0, 1.9, 0.1], faint=True)
    weaker = finding("encoder_periodic_error", 40.0, [1.0, 1.9, 0.1], faint=True)
    unlike = finding("encoder_periodic_error", 60.0, [0.0, 0.1, 5.0], faint=True)
    assert told_apart([force, stronger]) == ([force], [stronger])
    assert is_rounding(force, [stronger])
    assert not is_rounding(force, [weaker, unlike])
    assert not is_rounding(force, [])


def test_few_amplitudes_that_explain_nearly_as_much_come_first():
    def finding(name, count, statistic):
        amplitudes = tuple(("sine", i) for i in range(count))
        candidate = Candidate(VOCABULARY[name], {}, amplitudes, (1.0,) * count)
        test = ScoreTest(statistic, count, np.ones(count), np.ones(5), np.ones(count))
        return Finding(candidate, test, np.ones(count), 1.0, -20.0, statistic)

    many, few = finding("cogging_modulation", 10, 100.0), finding("cable_spring", 1, 91.0)
    far = finding("constant_force", 1, 89.0)
    assert plainer([many, few]) is few
    assert plainer([many, far]) is many
    assert plainer([few, many]) is few


def test_where_other_motion_cannot_show_it_friction_must_stand_out_further():
    def finding(name, **shape):
        return Finding(Candidate(VOCABULARY[name], shape, (), ()), None, np.ones(1), 1.0, -30.0, 60.0)

    interval = {"start": 1.0, "stop": 2.0}
    assert needed(finding("stribeck_friction", velocity=0.01)) < needed(finding("command_saturation", limit=10.0))
    assert needed(finding("disturbance_step", **interval)) == needed(finding("coulomb_asymmetry"))
    assert needed(finding("cable_spring", center=0.0)) == needed(finding("command_saturation", limit=10.0))


def test_what_did_not_pay_stays_a_rival_of_what_comes_in_its_place():
    explained = np.array([1.0, 2.0, 0.5])

    def finding(name, score):
        test = ScoreTest(score + 4.0, 1, np.ones(1), explained, np.ones(1))
        return Finding(Candidate(VOCABULARY[name], {}, (), ()), test, np.ones(1), 1.0, -30.0, score)

    unpaid, found = finding("constant_force", 85.0), finding("viscous_asymmetry", 70.0)
    rivals, chosen, _ = choose([unpaid, found], found, None, None, set(), {}, {"constant_force"})
    assert chosen is found
    assert [rival.name for rival in rivals] == ["viscous_asymmetry", "constant_force"]
    _, chosen, _ = choose([unpaid, found], found, None, None, set(), {})
    assert chosen is unpaid
