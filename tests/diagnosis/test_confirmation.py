"""What other motion says to an effect."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

import cogging
from cogging.diagnosis.evidence.null import fit_null
from cogging.diagnosis.search.confirmation import Confirmation, retuned
from tests.fixtures.moving_axis import machine, record


def test_what_other_motion_shows_is_a_chance_of_its_own():
    seen = Confirmation(noncentrality=40.0, ratio=0.9, gain=30.0)
    assert seen.log_p_value == pytest.approx(np.log(stats.norm.sf(0.9 * np.sqrt(40.0))))
    assert replace(seen, turn=1.0).log_p_value == pytest.approx(np.log(stats.chi2(2).sf(0.81 * 40.0)))
    assert replace(seen, ratio=0.1, gain=-10.0).log_p_value == 0.0  # refuted
    assert replace(seen, noncentrality=5.0).log_p_value == 0.0  # cannot show it


def test_a_wave_may_turn_where_the_zeros_of_position_differ():
    log, other = record(machine(), 11), record(machine(), 12)
    moved = cogging.Log(other.time, other.position + 0.01, other.command)
    fitted, _ = fit_null([log], machine())
    assert not retuned([other], fitted.model, machine(), fitted.paths).turns
    assert retuned([moved], fitted.model, machine(), fitted.paths).turns
    bare = machine().replace(cogging=None)
    fitted, _ = fit_null([log], bare)
    assert retuned([other], fitted.model, bare, fitted.paths).turns
