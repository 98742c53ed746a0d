"""What `diagnose` rests on: tails, the transpose of the observer's loop, tests that hold their level."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

import cogging
from cogging import EFFECTS
from cogging._core import Predictor
from cogging.diagnosis.candidates import waves
from cogging.diagnosis.candidates.scan import judged, profiled, scan
from cogging.diagnosis.candidates.signatures import Candidate, candidates, tables
from cogging.diagnosis.candidates.waves import is_wave
from cogging.diagnosis.evidence import evidence as evidence_module
from cogging.diagnosis.evidence.evidence import orthonormal
from cogging.diagnosis.evidence.log_p_value import log_survival
from cogging.diagnosis.evidence.noise_filter import spectrum
from cogging.diagnosis.evidence.null import fit_null, nuisances, starts_fit
from cogging.diagnosis.naming.verdict import BURST, BURSTS_TOGETHER, JUMP, VARIANCE, unlisted
from cogging.diagnosis.residual.bursts import bursts, variance_jumps
from cogging.diagnosis.residual.events import FRICTION_INTERVALS, JUMPS, events, with_events
from cogging.diagnosis.residual.location_words import shape_text
from cogging.diagnosis.residual.shapes import coordinates, shapes
from cogging.diagnosis.search.search import search
from cogging.identification.inverse_dynamics import fast_length
from tests.fixtures.moving_axis import machine, pushed, record


@pytest.mark.parametrize("freedom", [1, 2, 3, 7, 12, 24])
@pytest.mark.parametrize("statistic", [0.5, 10.0, 60.0, 600.0])
def test_log_survival_is_that_of_scipy(freedom, statistic):
    assert log_survival(statistic, freedom) == pytest.approx(stats.chi2.logsf(statistic, freedom), rel=1e-9, abs=1e-12)


def test_log_survival_far_out_is_finite_and_falls():
    assert -5100 < log_survival(1e4, 3) < log_survival(9e3, 3) < -4000


def test_transpose_of_propagate():
    log = record(machine(), 1)
    predictor = Predictor(log.time, log.position, log.command, bandwidth=40.0)
    along = predictor.predict(machine().plant())
    random = np.random.default_rng(0)
    force, error, weight = random.normal(size=(3, len(log)))
    force[-1] = 0.0  # no interval after the last row
    forward = predictor.propagate(along, 2.0, force[None, :], error[None, :] * 1e-3)[0]
    on_force, on_reading = predictor.propagate_transposed(along, 2.0, weight)
    assert weight @ forward == pytest.approx(on_force @ force + on_reading @ error * 1e-3, rel=1e-9)


def test_orthonormal_spans_and_is_orthonormal():
    rows = np.random.default_rng(1).normal(size=(4, 50))
    rows = np.vstack([rows, rows[0] + rows[1]])
    basis = orthonormal(rows)
    assert len(basis) == 4
    np.testing.assert_allclose(basis @ basis.T, np.eye(4), atol=1e-8)
    np.testing.assert_allclose((rows @ basis.T) @ basis, rows, atol=1e-6)


def test_spectrum_of_white_noise_is_one(quiet_evidence):
    source = quiet_evidence.sources[0]
    noise = np.random.default_rng(2).normal(size=len(source.log)) * (source.counts > 0)
    _, level = spectrum(noise, source)
    assert np.all((level > 0.4) & (level < 2.2))
    assert np.median(level) == pytest.approx(1.0, abs=0.2)


def test_score_test_of_random_columns_is_chi_square(quiet_evidence):
    random = np.random.default_rng(5)
    found = []
    for _ in range(200):
        test = quiet_evidence.test(random.normal(size=(2, len(quiet_evidence.residual))))
        found.append(test.statistic)
        assert test.freedom == 2
    assert stats.kstest(found, stats.chi2(2).cdf).pvalue > 1e-3


def test_amplitude_of_a_column_that_is_there(quiet_evidence):
    column = np.random.default_rng(6).normal(size=(1, len(quiet_evidence.residual)))
    free = quiet_evidence.project(column)[0]
    residual = quiet_evidence.residual + 0.5 * free
    moved = type(quiet_evidence)(**{**vars_of(quiet_evidence), "residual": residual})
    before, after = quiet_evidence.test(column).amplitudes[0], moved.test(column).amplitudes[0]
    assert after - before == pytest.approx(0.5, abs=1e-6)


def vars_of(evidence):
    return {name: getattr(evidence, name) for name in evidence.__dataclass_fields__}


def test_a_level_known_from_few_lines_bounds_what_a_column_is_worth(quiet_evidence):
    """All of a column's power in one narrow band: d ln(1 + T / d) there, and T where it is spread over all."""
    source = quiet_evidence.sources[0]
    ((parts, freedom),) = quiet_evidence.freedom
    assert freedom.sum() == pytest.approx(source.counts.sum() - len(quiet_evidence.basis), rel=0.01)
    n = len(source.log)
    frequency = np.fft.rfftfreq(fast_length(n), source.scales.sample_time)
    band = parts[6]
    middle = float(np.mean(frequency[band]))
    narrow = np.sin(2.0 * np.pi * middle * np.arange(n) * source.scales.sample_time)
    narrow *= np.sqrt(400.0 / np.sum(narrow**2))
    made = evidence_module.Test
    test = made(400.0, 1, np.ones(1), narrow, np.ones(1))
    expected = (freedom[6] - 1) * np.log1p(400.0 / quiet_evidence.overdispersion / (freedom[6] - 1))
    assert quiet_evidence.bounded(test) == pytest.approx(expected, rel=0.1)
    wide = np.random.default_rng(8).normal(size=n)
    wide *= np.sqrt(400.0 / np.sum(wide**2))
    assert (
        quiet_evidence.bounded(made(400.0, 1, np.ones(1), wide, np.ones(1)))
        > 0.9 * 400.0 / quiet_evidence.overdispersion
    )


def test_a_slow_effect_is_judged_against_the_noise_that_it_leaves():
    truth, nominal = machine([EFFECTS["cable_spring"](stiffness=1.5)]), machine()
    evidence = fit_null([record(truth, 11)], nominal)[1]
    found = scan(evidence, ["cable_spring"])
    (again,) = profiled(evidence, found)
    assert again.test.statistic > 1.5 * found[0].test.statistic  # seen: 2.7 times


def test_an_interval_is_found_at_its_edges():
    step = EFFECTS["disturbance_step"](force=0.06, start=3.217, stop=4.391)
    evidence = fit_null([record(machine([step]), 13)], machine())[1]
    (found,) = scan(evidence, ["disturbance_step"])
    true = Candidate("disturbance_step", {"start": 3.217, "stop": 4.391}, found.candidate.amplitudes, (1e-3,))
    (there,) = judged(evidence, [true], 1.0)
    assert found.test.statistic > 0.98 * there.test.statistic > 10.0


def by_coordinate(log):
    evidence = fit_null([log], machine())[1]
    return {shape.coordinate: shape for shape in with_events(evidence, shapes(evidence))}


def test_readings_that_jump_are_told_with_their_moment_and_size():
    log = record(machine(), 17)
    speed = np.gradient(log.position, log.time)
    row = int(np.argmax((np.abs(speed) > 0.1) & (log.time > 3.0)))
    position = log.position.copy()
    position[row:] += 6e-7
    evidence = fit_null([cogging.Log(log.time, position, log.command)], machine())[1]
    (jump,) = [shape for shape in events(evidence) if shape.coordinate == JUMPS]
    assert jump.log_p_value < JUMP
    largest = int(np.argmax(np.abs(jump.force)))
    assert jump.places[largest] == pytest.approx(log.time[row], abs=0.005)
    assert jump.force[largest] == pytest.approx(6e-7, abs=4.0 * jump.deviation[largest])
    assert f"+{1e6 * jump.force[largest]:.4g} um at" in shape_text(jump)


def test_a_blow_is_no_jump_of_the_reading():
    found = by_coordinate(pushed(lambda t, x, v: 0.8 * ((t > 3.0) & (t < 3.02)), 17))
    assert JUMPS not in found or found[JUMPS].log_p_value > JUMP


def test_friction_that_comes_and_goes_is_told_in_intervals():
    found = by_coordinate(pushed(lambda t, x, v: -0.15 * np.sign(v) * (np.mod(t, 1.7) < 0.3), 18))
    assert found[FRICTION_INTERVALS].log_p_value < -20.0
    assert np.median(found[FRICTION_INTERVALS].force[np.abs(found[FRICTION_INTERVALS].force) > 0.05]) < -0.05


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
    assert found[0] < VARIANCE  # seen: -1044
    assert found[1] > 0.5 * VARIANCE  # seen: -0.4


def test_bursts_of_force_are_louder_than_noise_of_any_tails():
    def rattle(t, x, v):
        noise = np.convolve(np.random.default_rng(8).normal(size=len(t)), np.ones(6) / np.sqrt(6), "same")
        noise -= np.convolve(noise, np.ones(60) / 60, "same")
        return 0.1 * noise * (np.mod(t, 2.0) < 0.3)

    def tails(t, x, v):
        return 0.04 * np.random.default_rng(9).standard_t(3.0, size=len(t))

    loud, even = (bursts(fit_null([pushed(force, 23)], machine())[1]) for force in (rattle, tails))
    assert loud < 0.5 * BURSTS_TOGETHER
    assert even > BURST
    told = unlisted(search([pushed(rattle, 23)], machine(), [pushed(rattle, 24)]), [], checked=True)
    assert told["shape"].startswith("bursts: ")
    assert told["confirmed"]
    assert unlisted(search([pushed(tails, 23)], machine(), [pushed(tails, 24)]), [], checked=True) is None


def test_an_error_of_the_map_is_retuning_where_no_effect_explains_more():
    """The amplitude changes along the travel. What is added to it everywhere is no size and no phase."""
    nominal = machine(force=0.004)
    basis = cogging.SplineHarmonics(pitch=0.03, harmonics=[1], order=3, origin=-0.2, control_points=18)
    places = np.linspace(0.0, 1.0, 18)
    sine, cosine = 0.4 + 0.3 * np.sin(5.0 * places), 0.2 + 0.1 * np.cos(4.0 * places)
    axis = nominal.axis.replace(travel=[-0.2, 0.2])
    mapped = nominal.replace(axis=axis, cogging=cogging.CoggingModel(basis, [sine], [cosine]))
    for wrong, free in ((sine + 0.2, True), (1.2 * sine, False), (sine, False)):
        truth = mapped.replace(cogging=cogging.CoggingModel(basis, [wrong], [1.0 * cosine]))
        found = search([record(truth, 31)], mapped)
        assert found.added == []
        assert ("cogging.sine[0][*]" in found.nominal.paths) == free
    scaled = mapped.replace(effects=(EFFECTS["encoder_scale_error"](scale=2e-3),))
    found = search([record(scaled, 31)], mapped)
    assert [one.finding.name for one in found.added] == ["encoder_scale_error"]
    assert found.estimate.values[list(found.estimate.paths).index("effects.encoder_scale_error.scale")] == (
        pytest.approx(2e-3, rel=0.1)
    )


def test_what_is_slow_and_large_is_measured_against_the_gap_itself():
    """Filters take it for noise: a force of time that anyone sees in the gap is then hardly seen in the evidence."""

    def drift(t, x, v):
        return 0.06 * np.sin(2.0 * np.pi * t / 3.0)

    evidence = fit_null([pushed(drift, 21)], machine())[1]
    (source,), (part,) = evidence.sources, evidence.parts
    _, _, columns, _ = coordinates(source, evidence.model)["time"]
    table = source.rows_of_forces(evidence.alongs[0], columns, evidence.model.axis.mass)
    _, share = evidence.unwhitened_fit([table])
    rows = source.counts > 0
    both = np.linalg.lstsq(np.vstack([part.columns, table])[:, rows].T, part.residual[rows], rcond=None)[0]
    alone = np.linalg.lstsq(part.columns[:, rows].T, part.residual[rows], rcond=None)[0]
    left = part.residual[rows] - both @ np.vstack([part.columns, table])[:, rows]
    tuned = part.residual[rows] - alone @ part.columns[:, rows]
    assert share == pytest.approx(1.0 - (left @ left) / (tuned @ tuned), abs=0.01)
    assert share > 0.2
    seen = [{shape.coordinate: shape for shape in shapes(evidence, plain=way)}["time"] for way in (True, False)]
    plain, usual = (shape.test.statistic for shape in seen)
    assert plain > 1.5 * usual
    again = shapes(evidence, plain=True, known=shapes(evidence))
    anew = shapes(evidence, plain=True)
    assert {one.coordinate: one.log_p_value for one in again} == {one.coordinate: one.log_p_value for one in anew}


def test_drag_over_the_pitch_is_its_own_coordinate():
    found = by_coordinate(pushed(lambda t, x, v: -1.5 * np.sin(2 * np.pi * x / 0.03) * v, 19))
    best = min(found.values(), key=lambda shape: shape.log_p_value)
    assert best.coordinate == "drag over the pitch"
    shape = -1.5 * np.sin(2 * np.pi * best.places / 0.03)
    assert best.force - best.force.mean() == pytest.approx(shape, abs=0.3)


def test_a_fast_tone_is_the_first_peak_however_few_bins_there_are(monkeypatch):
    """Bins longer than the rows would fold what is faster into lines that are not there."""
    truth = machine([EFFECTS["disturbance_tone"](frequency=103.0, sine=0.03)])
    evidence = fit_null([record(truth, 21)], machine())[1]
    monkeypatch.setattr(waves, "BINS", 256)
    (first, *_), _ = waves.peaks(evidence, "disturbance_tone")
    assert first.shape["frequency"] == pytest.approx(103.0, abs=0.2)


def test_every_effect_has_candidates_or_is_a_wave(quiet_evidence):
    for name, effect in EFFECTS.items():
        if is_wave(effect):
            continue
        found = list(candidates(quiet_evidence, name))
        if any(field.endswith("_nodes") and role["role"] == "setting" for field, role in effect.ROLES.items()):
            assert not found  # its places are the user's choice: it is added where it is asked for
            continue
        assert found, name
        made = tables(quiet_evidence, found[:2])
        for candidate, table in zip(found[:2], made, strict=True):
            assert table[0].shape == (max(1, len(candidate.amplitudes)), len(quiet_evidence.residual))
            assert np.isfinite(table[0]).all(), name
            assert name == candidate.effect([0.0] * len(candidate.amplitudes)).NAME


def test_nuisances_are_levels_and_known_amplitudes():
    assert set(nuisances(machine())) == {
        "axis.mass", "axis.viscous", "axis.coulomb", "axis.coulomb_width", "cogging.sine[0][0]", "cogging.cosine[0][0]",
    }  # fmt: skip


def test_rows_soon_after_a_start_count_only_where_they_fit():
    nominal = machine()
    (usual,) = fit_null([record(nominal, 3)], nominal)[1].sources
    assert usual.quick_starts
    soft = machine([EFFECTS["presliding_friction"](stiffness=1.5 / 1e-4)])  # gives way over a tenth of a millimetre
    (calm,) = fit_null([record(soft, 3)], nominal)[1].sources
    assert not calm.quick_starts
    assert not starts_fit(nominal, [calm], [calm])  # no row more


def test_friction_that_falls_with_time_is_a_drag_over_time():
    hidden = pushed(lambda t, x, v: 1.5 * v * np.exp(-t / 2.0), 4)  # as oil that warms up: less drag in the end
    left = shapes(fit_null([hidden], machine())[1])
    found = next(shape for shape in left if shape.coordinate == "drag over time")
    assert found.log_p_value < -15.0
    assert found.log_p_value <= left[0].log_p_value + 5.0


def test_a_wave_beside_a_known_period_is_looked_at_though_retuning_takes_most_of_it():
    hidden = EFFECTS["encoder_periodic_error"](period=0.0304, cosine=4e-6)
    evidence = fit_null([record(machine([hidden]), 5)], machine())[1]
    spectral = [one.shape["period"] for one in waves.peaks(evidence, "encoder_periodic_error")[0]]
    assert all(abs(period / hidden.period - 1.0) > 0.02 for period in spectral)
    near = waves.beside_known(evidence, "encoder_periodic_error")
    turns = evidence.scales.position / np.array([one.shape["period"] for one in near])
    assert len(near) == 5
    np.testing.assert_allclose(turns - evidence.scales.position / 0.03, [-0.7, -0.35, 0.0, 0.35, 0.7], atol=1e-9)
    assert waves.beside_known(evidence, "disturbance_tone") == []
    # A force there is the known cogging itself, changing along the travel.
    assert waves.beside_known(evidence, "cogging_harmonic") == []
    forces = [one.shape["period"] for one in waves.peaks(evidence, "cogging_harmonic")[0]]
    assert all(abs(1.0 / period - 1.0 / 0.03) * evidence.scales.position > 0.99 for period in forces)
    best = scan(evidence)[0]
    assert best.name == "encoder_periodic_error"
    assert best.candidate.shape["period"] == pytest.approx(hidden.period, rel=0.01)
    assert not best.faint
    # Of an encoder whose counts are a hundred times as large, rounding may have made it.
    coarse = replace(evidence, model=evidence.model.replace(encoder=cogging.EncoderParameters(resolution=1e-4)))
    (faint,) = judged(coarse, [best.candidate], 1.0)
    assert faint.faint


def test_tables_are_whitened_together_as_they_are_alone(quiet_evidence):
    random = np.random.default_rng(8)
    tables = [[random.normal(size=(count, len(quiet_evidence.residual)))] for count in (1, 5, 4, 1, 12, 2)]
    together = list(quiet_evidence.whitened_each(tables))
    assert [len(one) for one in together] == [1, 5, 4, 1, 12, 2]
    for one, table in zip(together, tables, strict=True):
        np.testing.assert_allclose(one, quiet_evidence.whitened(table), rtol=1e-9, atol=1e-12)


def test_an_error_of_the_reading_repeats_in_the_travel(quiet_evidence):
    found, _ = waves.peaks(quiet_evidence, "encoder_periodic_error")
    assert found
    assert all(1.5 * one.shape["period"] < 1.01 * quiet_evidence.scales.position for one in found)
    encoder = cogging.EncoderParameters(resolution=1e-4)
    coarse = replace(quiet_evidence, model=quiet_evidence.model.replace(encoder=encoder))
    assert all(one.shape["period"] > 0.99 * 32e-4 for one in waves.peaks(coarse, "encoder_periodic_error")[0])
