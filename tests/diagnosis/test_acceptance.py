"""Whether an effect pays on other motion."""

import numpy as np
import pytest

from cogging import EFFECTS
from cogging.diagnosis.discrepancy import discrepancies, follows
from cogging.diagnosis.evidence.null import nuisances
from cogging.diagnosis.search.acceptance import that_pays, with_nuisances_of
from cogging.estimation.replay import place_of_reading
from tests.fixtures.moving_axis import machine, record


def test_an_effect_pays_with_levels_tuned_or_as_they_were():
    spring, wrong = EFFECTS["cable_spring"](stiffness=1.5), EFFECTS["cable_spring"](stiffness=-1.5)
    logs, confirm = [record(machine([spring]), 11)], [record(machine([spring]), 12)]
    good, nominal = machine([spring]), machine()
    bent = good.replace(axis=good.axis.replace(viscous=12.0))
    assert that_pays(logs, confirm, nominal, good, bent)[0] is good
    assert that_pays(logs, confirm, nominal, bent, good)[0] is good
    neither, reason = that_pays(logs, confirm, nominal, bent, machine([wrong]))
    assert neither is None
    assert reason.startswith("the gap on the other motion grows from")


def test_what_an_effect_must_pay_is_measured_by_the_replayed_loop_where_it_follows():
    logs, confirm = [record(machine(), 11)], [record(machine(), 12)]
    wrong = machine().replace(axis=machine().axis.replace(coulomb=4.5))
    for model, expected in ((machine(), True), (wrong, False)):
        assert follows(discrepancies(logs, [model], replay=True)[0], logs, model) is expected
    slight = machine([EFFECTS["cable_spring"](stiffness=0.03)])
    assert that_pays(logs, confirm, machine(), slight, wrong, replay=True)[0] is slight
    before, after = discrepancies(confirm, [machine(), slight], replay=True)
    assert before.rms < after.rms < 1.01 * before.rms
    assert that_pays(logs, confirm, machine(), wrong, wrong, replay=True)[0] is None


def test_levels_of_an_earlier_model_leave_what_was_added():
    before = machine().replace(axis=machine().axis.replace(viscous=4.0, mass=2.1))
    kept = with_nuisances_of(before, machine([EFFECTS["cable_spring"](stiffness=1.5)]), nuisances(before))
    assert kept.axis == before.axis
    assert [effect.NAME for effect in kept.effects] == ["cable_spring"]


@pytest.mark.parametrize("scale", [-2e-3, 1e-3])
def test_an_encoder_that_errs_is_replayed_as_it_reads(scale):
    """The error of the replayed position is that of the reading: an effect in the reading may well move the axis."""
    wrong = EFFECTS["encoder_scale_error"](scale=scale)
    log = record(machine([wrong]), 13)
    bare, known = discrepancies([log], [machine(), machine([wrong])], replay=True)
    assert known.position < 1e-6
    assert known.position <= 1.1 * bare.position
    assert known.rms < bare.rms


@pytest.mark.parametrize("seed", range(5))
def test_a_replay_begins_where_the_encoder_reads_the_first_reading(seed):
    random = np.random.default_rng(seed)
    scale = EFFECTS["encoder_scale_error"](scale=random.uniform(-5e-3, 5e-3))
    wave = EFFECTS["encoder_periodic_error"](period=random.uniform(2e-3, 0.02), sine=2e-6, cosine=-1e-6)
    reading = random.uniform(-0.2, 0.3)
    place = place_of_reading(reading, [scale, EFFECTS["cable_spring"](stiffness=1.0), wave])
    errors = [float(np.ravel(one.reading_at(position=[place]))[0]) - place for one in (scale, wave)]
    assert place + sum(errors) == pytest.approx(reading, abs=1e-12)
    assert abs(place - reading) > 1e-7
    assert place_of_reading(reading, [EFFECTS["cable_spring"](stiffness=1.0)]) == reading
