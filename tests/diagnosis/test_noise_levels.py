"""The local noise level of the rows of a force balance."""

import numpy as np
import pytest

import cogging
from cogging.diagnosis.balance.differenced_balance import DifferencedBalance
from cogging.diagnosis.balance.evidence import Evidence
from tests.fixtures.pid_axis import FAST, run


@pytest.mark.parametrize("factor", [1.0, 3.0])
def test_rows_within_a_noisy_second_have_its_level(factor):
    fine = FAST.replace(encoder=cogging.EncoderParameters(resolution=1e-9))
    log, rng = run(model=fine, seed=3), np.random.default_rng(8)
    noisy = (log.time > 1.5) & (log.time < 2.5)
    noise = 0.06 * rng.standard_normal(len(log.time)) * np.where(noisy, factor, 1.0)
    balance = DifferencedBalance(cogging.Log(log.time, log.position, log.command + noise, log.reference), quantum=1e-9)
    evidence = Evidence([balance], fine, fine).prepare(2, listen=True)
    time = balance.time[:: balance.every][evidence.counted[0]]
    inside, outside = (time > 1.7) & (time < 2.3), (time < 1.3) | (time > 2.7)
    level = evidence.levels[0]
    assert np.median(level[inside]) / np.median(level[outside]) == pytest.approx(factor, rel=0.2)
