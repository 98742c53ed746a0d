"""What other motion says to an effect."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

import cogging
from cogging.diagnosis.evidence.null import fit_null
from cogging.diagnosis.search.confirmation import Confirmation, as_there, retuned
from tests.fixtures.moving_axis import machine, record
from tests.fixtures.pid_axis import MODEL, other, run


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


@pytest.mark.parametrize("seed", range(4))
def test_a_turned_wave_is_a_shifted_one(seed):
    random = np.random.default_rng(seed)
    period, turn = random.uniform(0.005, 0.05), random.uniform(-np.pi, np.pi)
    wave = cogging.effects.CoggingHarmonic(period=period, sine=random.normal(), cosine=random.normal())
    spring = cogging.effects.CableSpring(stiffness=1.0)
    there = as_there(machine([spring, wave, spring]), [0.0, turn])  # of the last two; what is no wave stays
    assert there.effects[1].sine == pytest.approx(wave.sine)
    there = as_there(machine([spring, wave, spring]), [turn, turn]).effects[1]
    phase, places = 2.0 * np.pi / period, np.linspace(-0.1, 0.1, 7)
    force = there.sine * np.sin(phase * places) + there.cosine * np.cos(phase * places)
    at = places + turn / phase
    assert force == pytest.approx(wave.sine * np.sin(phase * at) + wave.cosine * np.cos(phase * at), abs=1e-9)


def test_a_wave_of_another_zero_pays_on_other_motion_and_no_step_makes_its_gap_grow():
    """An encoder that counts from where it was switched on: the same harmonic lies elsewhere in the second log."""
    hidden = cogging.effects.CoggingHarmonic(period=0.0217, sine=0.05, cosine=0.03)
    bare = MODEL.replace(cogging=None)
    log = other(hidden)
    moved = cogging.Log(log.time, log.position + 0.0072, log.command, log.reference + 0.0072)
    result = cogging.diagnose(run(hidden), bare, confirm=moved)
    found = next(effect for effect in result.effects if effect.name == "cogging_harmonic")
    assert any(abs(term["period"].value - 0.0217) < 1e-4 for term in (found.parameters, *found.further))
    steps = [step for step in result.ledger if step.accepted]
    assert all(step.confirm_after <= 1.01 * step.confirm_before for step in steps)
    turned = next(step for step in steps if step.name == "cogging_harmonic")
    assert turned.confirm_after < 0.97 * turned.confirm_before
    note = next(note for note in result.notes if "turned" in note)
    degrees = float(re.search(r"cogging_harmonic at 0.0217\d* by (-?\d+) degrees", note).group(1))
    assert degrees == pytest.approx(-360.0 * 0.0072 / 0.0217, abs=20.0)  # what lies later is turned back
