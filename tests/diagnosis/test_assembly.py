"""The assembled result: its ledger, its gaps, what has changed."""

import pytest

import cogging
from cogging.diagnosis.search.search import search
from tests.fixtures.pid_axis import MODEL, run

effects = cogging.effects


def test_the_ledger_has_the_gap_of_each_step(found):
    accepted = [step for step in found.ledger if step.accepted]
    assert accepted[0].gap_before == found.gap.before
    assert accepted[-1].gap_after == found.gap.after
    assert accepted[0].confirm_before == found.gap.confirm_before
    assert accepted[-1].confirm_after == found.gap.confirm_after
    assert all(step.gap_before is None for step in found.ledger if not step.accepted)
    two = effects.DisturbanceTone(frequency=17.0, sine=0.03), effects.CoggingHarmonic(period=0.03, sine=0.03)
    result = cogging.diagnose(run(*two), MODEL)
    first, second = (step for step in result.ledger if step.accepted)
    assert result.gap.before == first.gap_before > first.gap_after == second.gap_before > second.gap_after
    waves = {wave.coordinate: wave.value for wave in result.location.waves}
    assert waves == {"spatial period": pytest.approx(0.03, rel=0.01), "frequency": pytest.approx(17.0, rel=0.01)}


def test_what_changed_is_measured_against_the_model_as_stated():
    heavy = MODEL.replace(axis=MODEL.axis.replace(mass=0.16))
    motion = cogging.Sampled(*(lambda log: (log.time, log.reference, None, None))(run(duration=3.0)))
    result = cogging.diagnose(cogging.simulate(heavy, motion, duration=3.0, seed=3), MODEL)
    (effect,) = result.effects
    assert effect.name == "mass_change"
    assert effect.parameters["change"].value == pytest.approx(1.0 / 3.0, abs=0.02)
    assert result.nominal.axis.mass == MODEL.axis.mass
    assert result.gap.after < 0.6 * result.gap.before


@pytest.mark.parametrize("confirm", [False, True])
@pytest.mark.parametrize(
    "effect",
    [
        effects.CableSpring(stiffness=0.6, center=0.25),
        effects.CoggingHarmonic(period=0.03, sine=0.05),
        effects.ViscousAsymmetry(difference=0.15),
        effects.DisturbanceTone(frequency=17.0, sine=0.05),
    ],
    ids=lambda effect: effect.NAME,
)
def test_what_was_seen_is_a_gap_though_adding_it_does_not_pay(effect, confirm, monkeypatch):
    """Refused all together, it is told as what no effect explains: the logs do differ from the model."""

    def refused_at_the_end(*arguments, **named):
        found = search(*arguments, **named)
        monkeypatch.setattr("cogging.diagnosis.search.gaps.Measured.objection", lambda measured: "it grows")
        return found

    monkeypatch.setattr("cogging.diagnosis.diagnose.search", refused_at_the_end)
    result = cogging.diagnose(run(effect), MODEL, confirm=[run(effect, seed=5)] if confirm else [])
    assert result.effects == ()
    assert [step.reason for step in result.ledger if step.name == effect.NAME] == ["it grows"]
    assert result.verdict == "unlisted"
    assert result.unlisted["coordinate"]
    assert result.gap.before > 2.0 * result.gap.floor
