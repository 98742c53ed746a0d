"""Whether an effect enters the model: by the gaps of both logs, and by its interval."""

import numpy as np
import pytest

from cogging import EFFECTS
from cogging.diagnosis.candidates.movable import effect_parameters
from cogging.diagnosis.discrepancy import Discrepancy, discrepancies, follows
from cogging.diagnosis.evidence.null import nuisances
from cogging.diagnosis.search.acceptance import excludes_none
from cogging.diagnosis.search.gaps import Measured, Yardstick
from cogging.effects.effect import VOCABULARY
from cogging.estimation.gauss_newton import Estimate
from cogging.estimation.replay import place_of_reading
from cogging.model.parameters import parameters_of
from tests.fixtures.moving_axis import machine, record


def yardstick(logs, confirm, **named):
    return Yardstick(logs, confirm, machine(), machine(), nuisances(machine()), **named)


def test_an_effect_enters_where_it_shrinks_the_gap_on_both_logs():
    """On other motion nuisances are tuned again: a level that the effect bent there is no growth."""
    spring, wrong = EFFECTS["cable_spring"](stiffness=1.5), EFFECTS["cable_spring"](stiffness=-1.5)
    measure = yardstick([record(machine([spring]), 11)], [record(machine([spring]), 12)]).measure
    bent = machine([spring]).replace(axis=machine().axis.replace(viscous=12.0))
    good = measure([machine(), machine([spring])], [0.0])
    assert good.objection() == ""
    assert good.given[1].rms < good.given[0].rms
    assert measure([machine(), bent], [0.0]).confirm[1].rms == pytest.approx(good.confirm[1].rms, rel=1e-3)
    assert measure([machine(), machine([wrong])], [0.0]).objection().startswith("the gap goes from")
    other = yardstick([record(machine([spring]), 11)], [record(machine([wrong]), 12)]).measure
    assert other([machine(), machine([spring])], [0.0]).objection().startswith("the gap on the other motion goes")


def test_a_gap_grows_by_chance_but_never_by_much():
    """A burst in one block makes chance large; what it allows stays a hundredth of the gap."""
    quiet = np.random.default_rng(3).standard_normal(4000)
    burst = quiet + 5.0 * (np.arange(4000) < 200)
    rows = np.ones(4000, dtype=bool)

    def seen(row):
        return Discrepancy(float(np.sqrt(np.mean(row**2))), "innovations of an observer", (row,), (rows,), None)

    assert Measured([seen(quiet), seen(burst)], None).objection()
    assert Measured([seen(burst), seen(quiet)], None).objection() == ""
    assert Measured([seen(quiet), seen(np.roll(quiet, 7))], None).objection() == ""
    assert Measured([seen(quiet), seen(0.99 * quiet)], None).objection(least=0.15)


def test_what_an_effect_must_pay_is_measured_by_the_replayed_loop_where_it_follows():
    logs, confirm = [record(machine(), 11)], [record(machine(), 12)]
    wrong = machine().replace(axis=machine().axis.replace(coulomb=4.5))
    for model, expected in ((machine(), True), (wrong, False)):
        assert follows(discrepancies(logs, [model], replay=True)[0], logs, model) is expected
        measured = yardstick(logs, confirm, replay=True).measure([machine(), model])
        assert (measured.given[0].position is not None) is expected
        assert measured.confirm[0].signal == measured.given[0].signal


@pytest.mark.parametrize(("size", "told"), [(0.3, True), (0.05, False)])
def test_an_effect_is_told_from_none_by_its_interval(size, told):
    """Also where the amplitudes are several: a sine and a cosine together."""
    for effect in (
        EFFECTS["constant_force"](force=size),
        EFFECTS["cogging_harmonic"](period=0.03, sine=size, cosine=0),
    ):
        model = machine([effect])
        paths = tuple(path for path in effect_parameters(model) if not path.endswith("period"))
        values = np.array([parameters_of(model)[path].value for path in paths])
        spread = 0.1**2 * np.eye(len(paths))
        estimate = Estimate(paths, values, spread, np.full(len(paths), 30.0), model, (), (), 1)
        assert excludes_none(estimate, VOCABULARY[effect.NAME]) is told


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
