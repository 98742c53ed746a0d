"""Bursts of noise."""

import numpy as np

import cogging
from cogging.diagnosis.evidence.null import fit_null
from cogging.diagnosis.naming.verdict import unlisted
from cogging.diagnosis.residual.bursts import bursts, variance_jumps
from cogging.diagnosis.search.search import search
from cogging.diagnosis.thresholds import VERDICT
from tests.fixtures.moving_axis import machine, pushed, record


def test_a_burst_is_told_from_noise_that_goes_with_speed():
    log = record(machine(), 23)
    noise = np.random.default_rng(6).normal(size=len(log))
    speed = np.abs(np.gradient(log.reference, log.time))
    middle = log.time[np.argmax(speed)]
    burst = 3e-6 * noise * (np.abs(log.time - middle) < 0.25)
    with_speed = 3e-6 * noise * speed / speed.max()
    found = []
    for added in (burst, with_speed):
        read = cogging.Log(log.time, log.position + added, log.command)
        found.append(variance_jumps(fit_null([read], machine())[1]))
    assert found[0] < VERDICT.variance  # seen: -1044
    assert found[1] > 0.5 * VERDICT.variance  # seen: -0.4


def test_bursts_of_force_are_louder_than_noise_of_any_tails():
    def rattle(t, x, v):
        noise = np.convolve(np.random.default_rng(8).normal(size=len(t)), np.ones(6) / np.sqrt(6), "same")
        noise -= np.convolve(noise, np.ones(60) / 60, "same")
        return 0.1 * noise * (np.mod(t, 2.0) < 0.3)

    def tails(t, x, v):
        return 0.04 * np.random.default_rng(9).standard_t(3.0, size=len(t))

    loud, even = (bursts(fit_null([pushed(force, 23)], machine())[1]) for force in (rattle, tails))
    assert loud < 0.5 * VERDICT.bursts_together
    assert even > VERDICT.burst
    told = unlisted(search([pushed(rattle, 23)], machine(), [pushed(rattle, 24)]), [], checked=True)
    assert told["shape"].startswith("bursts: ")
    assert told["confirmed"]
    assert unlisted(search([pushed(tails, 23)], machine(), [pushed(tails, 24)]), [], checked=True) is None
