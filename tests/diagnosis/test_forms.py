"""Other laws of the same cause: each holds the plainest one, and acts on nothing else."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lti, step

from cogging.diagnosis.candidates.forms import form_of, lagged
from cogging.diagnosis.candidates.scan import scan
from cogging.diagnosis.evidence.score_test import orthonormal
from cogging.diagnosis.search import form_rivals
from cogging.effects.effect import VOCABULARY

EFFECTS = {
    "end_effect": {"force": 0.3, "decay_length": 0.02},
    "disturbance_step": {"force": 0.2, "start": 2.0, "stop": 4.0},
    "position_dependent_friction": {"nodes": [-0.1, 0.0, 0.1], "levels": [0.2, -0.1, 0.3]},
    "stribeck_friction": {"static_excess": 0.4, "velocity": 0.008, "exponent": 1.0},
    "force_constant_drift": {"change": 0.1, "time_constant": 2.0},
    "quadratic_drag": {"coefficient": 2.0},
    "cable_spring": {"stiffness": 1.0, "center": 0.0},
    "local_force": {"force": 0.2, "center": 0.0, "width": 0.02},
    "command_saturation": {"limit": 5.0},
    "command_dead_zone": {"width": 0.1},
    "cogging_harmonic": {"period": 0.0113, "sine": 0.1, "cosine": 0.0},
    "disturbance_tone": {"frequency": 7.0, "sine": 0.1, "cosine": 0.0},
    "encoder_periodic_error": {"period": 0.013, "sine": 1e-5, "cosine": 0.0},
    "force_constant_ripple": {"period": 0.021, "sine": 0.02, "cosine": 0.0},
    "actuator_lag": {"time_constant": 2e-3},
}
HELD = ("end_effect", "local_force", "disturbance_step", "position_dependent_friction", "stribeck_friction")
HELD += ("force_constant_drift",)


def law_of(effect, source, along):
    """What an effect does in each interval, V."""
    at = {"position": along.middle_position, "velocity": along.middle_velocity}
    time = source.log.time - source.log.time[0]
    if "force" in effect.HOOKS:
        return np.asarray(effect.force_at(time=time, **at))
    if "friction_level" in effect.HOOKS:
        return np.asarray(effect.friction_level_at(time=time, **at)) * np.sign(along.middle_velocity)
    return np.asarray(effect.gain_at(position=along.middle_position, time=time)) * source.log.command


@pytest.mark.parametrize("name", EFFECTS)
def test_a_form_is_told_by_place_and_column(name, quiet_evidence):
    form = form_of(VOCABULARY[name].replace(**EFFECTS[name]), quiet_evidence)
    (table,) = form.tables(quiet_evidence)
    assert table.shape == (len(form.places), len(quiet_evidence.sources[0].log))
    assert np.isfinite(table).all()
    assert quiet_evidence.test(quiet_evidence.whitened([table])).statistic < 60.0


@pytest.mark.parametrize("name", HELD)
def test_the_plainest_law_lies_within_its_form(name, quiet_evidence):
    effect = VOCABULARY[name].replace(**EFFECTS[name])
    if name == "end_effect":
        position = quiet_evidence.sources[0].log.position
        effect = effect.replace(travel=[float(position.min()), float(position.max())])
    source, along = quiet_evidence.sources[0], quiet_evidence.alongs[0]
    columns = form_of(effect, quiet_evidence).columns(source, along)
    rows = source.mask > 0
    basis = orthonormal(columns[:, rows])
    law = law_of(effect, source, along)[rows]
    left = law - (basis @ law) @ basis
    assert left @ left < 0.06 * (law @ law)


@pytest.mark.parametrize("name", ["end_effect", "local_force", "disturbance_step", "cable_spring"])
def test_a_curve_is_the_force_of_its_columns(name, quiet_evidence):
    effect = VOCABULARY[name].replace(**EFFECTS[name])
    form = form_of(effect, quiet_evidence)
    source, along = quiet_evidence.sources[0], quiet_evidence.alongs[0]
    size = np.random.default_rng(4).standard_normal(len(form.places))
    curve = form.patch(size)
    values = along.middle_position if curve["coordinate"] == "position" else source.log.time - source.log.time[0]
    expected = size @ form.columns(source, along)
    found = np.interp(values, curve["places"], curve["force"])
    np.testing.assert_allclose(found, expected, atol=0.05 * np.abs(expected).max())


def test_what_acts_by_a_state_or_has_one_law_has_no_form(quiet_evidence):
    for name in ("backlash", "flexible_mode", "presliding_friction", "constant_force", "command_delay"):
        assert form_of(VOCABULARY[name], quiet_evidence) is None


@pytest.mark.parametrize("damping", [0.5, 0.8, 1.2])
def test_a_lag_of_second_order_is_that_of_scipy(damping):
    time = 1e-3 * np.arange(60)
    command = np.where(time > 0.5e-3, 1.0, 0.0)
    total = 8e-3
    denominator = [(total / (2.0 * damping)) ** 2, total, 1.0]
    _, exact = step(lti([1.0], denominator), T=0.5e-3 * np.arange(117))
    np.testing.assert_allclose(lagged(command, denominator, 1e-3)[1:59], exact[1::2], atol=1e-2)


def test_nothing_in_the_scan_is_left_without_a_decision(quiet_evidence):
    """Every effect that a scan finds either has a form or is one of those that have none."""
    without = {"backlash", "flexible_mode", "presliding_friction", "constant_force", "command_delay"}
    without |= {"coulomb_asymmetry", "viscous_asymmetry", "encoder_scale_error", "gravity"}
    laws = [law for name, law in VOCABULARY.items() if name != "empirical_force"]
    for finding in scan(quiet_evidence, laws):
        assert (form_of(finding.effect(), quiet_evidence) is None) == (finding.name in without)


@pytest.mark.parametrize("first", ["cogging_harmonic", "end_effect", "cable_spring", "quadratic_drag"])
def test_a_free_law_of_the_chosen_one_is_no_word_against_its_rivals(first, quiet_evidence, monkeypatch):
    def freed(finding, evidence, confirm):
        return replace(finding, score=finding.score + 40.0) if finding.name == first else None

    monkeypatch.setattr(form_rivals, "freed", freed)
    scanned = scan(quiet_evidence, [law for name, law in VOCABULARY.items() if name != "empirical_force"])
    findings = list({one.name: one for one in scanned}.values())
    chosen = replace(next(one for one in findings if one.name == first), score=50.0)
    rivals = [chosen, *(replace(one, score=49.0 - i) for i, one in enumerate(f for f in findings if f.name != first))]
    found = form_rivals.with_forms(rivals, findings, quiet_evidence, None)
    assert found[0].name == first
    assert found[0].score == 90.0
    after = {one.name: one.score for one in found}
    for rival in rivals[1:]:
        assert found[0].score - after[rival.name] == pytest.approx(50.0 - rival.score)
