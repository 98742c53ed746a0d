"""Findings: each judged against the noise that it leaves."""

from cogging import EFFECTS
from cogging.diagnosis.candidates.findings import profiled
from cogging.diagnosis.candidates.scan import scan
from cogging.diagnosis.evidence.null import fit_null
from cogging.effects.effect import VOCABULARY
from tests.fixtures.moving_axis import machine, record


def test_a_slow_effect_is_judged_against_the_noise_that_it_leaves():
    truth, nominal = machine([EFFECTS["cable_spring"](stiffness=1.5)]), machine()
    evidence = fit_null([record(truth, 11)], nominal)[1]
    found = scan(evidence, [VOCABULARY["cable_spring"]])
    (again,) = profiled(evidence, found)
    assert again.test.statistic > 1.5 * found[0].test.statistic  # seen: 2.7 times
