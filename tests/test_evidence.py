"""What `diagnose` rests on: tails, the transpose of the observer's loop, tests that hold their level."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

import cogging
from cogging import EFFECTS, Model
from cogging._core import Predictor
from cogging.diagnose import evidence as evidence_module
from cogging.diagnose import waves
from cogging.diagnose.bursts import bursts, variance_jumps
from cogging.diagnose.chances import log_survival
from cogging.diagnose.events import JUMPS, SPELLS, events, with_events
from cogging.diagnose.evidence import orthonormal
from cogging.diagnose.level_changes import changes, look_alikes
from cogging.diagnose.location_words import shape_text
from cogging.diagnose.naming import named
from cogging.diagnose.noise_filter import spectrum
from cogging.diagnose.null import fit_null, nuisances, starts_fit
from cogging.diagnose.patched import with_intervals
from cogging.diagnose.refit import conditional_paths
from cogging.diagnose.rest import coordinates, shapes
from cogging.diagnose.scan import Finding, judged, profiled, scan
from cogging.diagnose.search import choose, needed, plainer, search, that_pays, with_levels_of
from cogging.diagnose.signatures import Candidate, candidates, tables
from cogging.diagnose.twins import twins
from cogging.diagnose.verdict import BURST, BURSTS_TOGETHER, JUMP, VARIANCE, standing, unlisted
from cogging.diagnose.waves import is_wave
from cogging.estimation import Estimate
from cogging.inverse_dynamics import fast_length

RATE = 1000.0


def machine(effects=(), force=0.02):
    kp, ki, kd = cogging.pid_gains([-80.0] * 3, 2.0)
    return Model(
        axis=cogging.AxisParameters(mass=2.0, viscous=3.0, coulomb=1.5, coulomb_width=2e-3),
        cogging=cogging.CoggingModel(cogging.SplineHarmonics(pitch=0.03, harmonics=[1]), [[0.4]], [[0.2]]),
        effects=tuple(effects),
        encoder=cogging.EncoderParameters(resolution=1e-7),
        noise=cogging.NoiseParameters(force=force, bandwidth=40.0),
        controller=cogging.PidParameters(sample_rate=RATE, kp=kp, ki=ki, kd=kd),
        controller_type="pid",
        uncertainty={"mass": 0.03, "viscous": 0.2, "coulomb": 0.2},
    )


def motion(seed):
    random = np.random.default_rng(seed)
    time = np.arange(int(8.0 * RATE) + 1) / RATE
    position, at, now = np.zeros(len(time)), 0.0, 0.1
    while now < 7.9:
        goal, top = random.uniform(-0.15, 0.15), float(np.exp(random.uniform(np.log(0.02), np.log(0.4))))
        goal = at + float(np.clip(goal - at, -top, top))
        length = 1.9 * abs(goal - at) / top + 0.05
        s = np.clip((time - now) / length, 0.0, 1.0)
        position += (goal - at) * s**3 * (10 - 15 * s + 6 * s * s)
        at, now = goal, now + length + 0.02
    return cogging.Sampled(time, position, None, None)


def record(model, seed):
    return cogging.simulate(model, motion(seed), seed=seed, duration=8.0, steps_per_sample=4)


def pushed(force, seed):
    """A log in which `force` (V) of reference position and velocity acts beside the command, and nobody knows of it."""
    model, reference = machine(), motion(seed)
    log = record(model, seed)
    added = force(log.time, log.reference, np.gradient(log.reference, log.time))
    columns = cogging.closed_loop(
        model.plant(),
        model.make_controller(),
        reference,
        seed=seed,
        duration=8.0,
        steps_per_sample=4,
        added_command=added,
    )
    return cogging.Log(columns["time"], columns["position"], columns["command"] - added)


@pytest.fixture(scope="module")
def quiet_evidence():
    nominal = machine()
    return fit_null([record(nominal, 3)], nominal)[1]


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
    expected = (freedom[6] - 1) * np.log1p(400.0 / quiet_evidence.excess / (freedom[6] - 1))
    assert quiet_evidence.bounded(test) == pytest.approx(expected, rel=0.1)
    wide = np.random.default_rng(8).normal(size=n)
    wide *= np.sqrt(400.0 / np.sum(wide**2))
    assert quiet_evidence.bounded(made(400.0, 1, np.ones(1), wide, np.ones(1))) > 0.9 * 400.0 / quiet_evidence.excess


def test_a_slow_effect_is_judged_against_the_noise_that_it_leaves():
    truth, nominal = machine([EFFECTS["cable_spring"](stiffness=1.5)]), machine()
    evidence = fit_null([record(truth, 11)], nominal)[1]
    found = scan(evidence, ["cable_spring"])
    (again,) = profiled(evidence, found)
    assert again.test.statistic > 1.5 * found[0].test.statistic  # seen: 2.7 times


def test_a_spell_is_found_at_its_edges():
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
    assert jump.log_chance < JUMP
    largest = int(np.argmax(np.abs(jump.force)))
    assert jump.places[largest] == pytest.approx(log.time[row], abs=0.005)
    assert jump.force[largest] == pytest.approx(6e-7, abs=4.0 * jump.deviation[largest])
    assert f"+{1e6 * jump.force[largest]:.4g} um at" in shape_text(jump)


def test_a_blow_is_no_jump_of_the_reading():
    found = by_coordinate(pushed(lambda t, x, v: 0.8 * ((t > 3.0) & (t < 3.02)), 17))
    assert JUMPS not in found or found[JUMPS].log_chance > JUMP


def test_friction_that_comes_and_goes_is_told_in_spells():
    found = by_coordinate(pushed(lambda t, x, v: -0.15 * np.sign(v) * (np.mod(t, 1.7) < 0.3), 18))
    assert found[SPELLS].log_chance < -20.0
    assert np.median(found[SPELLS].force[np.abs(found[SPELLS].force) > 0.05]) < -0.05


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
    _, share = evidence.of_the_gap([table])
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
    assert {one.coordinate: one.log_chance for one in again} == {one.coordinate: one.log_chance for one in anew}


def test_drag_over_the_pitch_is_its_own_coordinate():
    found = by_coordinate(pushed(lambda t, x, v: -1.5 * np.sin(2 * np.pi * x / 0.03) * v, 19))
    best = min(found.values(), key=lambda shape: shape.log_chance)
    assert best.coordinate == "drag over the pitch"
    shape = -1.5 * np.sin(2 * np.pi * best.places / 0.03)
    assert best.force - best.force.mean() == pytest.approx(shape, abs=0.3)


@pytest.mark.parametrize(
    ("coordinate", "mine", "its", "checked", "told"),
    [
        ("position", -13.0, -6.0, True, True),
        ("position", -9.0, -18.0, True, True),
        ("position", -7.0, -18.0, True, None),
        ("position", -7.0, -9.0, True, None),
        ("drag over time", -10.0, -24.0, True, True),
        ("drag over time", -13.0, -6.0, True, True),
        ("position", -4.0, -90.0, True, None),
        ("position", -13.0, 0.0, True, None),
        ("position", -13.0, 0.0, False, False),
        ("time", -101.0, 0.0, True, False),
        ("time", -99.0, 0.0, True, None),
        (JUMPS, -19.0, 0.0, True, False),
        (JUMPS, -17.0, -4.0, True, None),
        (JUMPS, -8.0, -6.0, True, True),
        (SPELLS, -19.0, -9.0, True, None),
        (SPELLS, -25.0, -14.0, True, None),
        (SPELLS, -45.0, -20.0, True, True),
        (SPELLS, -101.0, 0.0, False, True),
    ],
)
def test_what_is_left_stands_by_both_motions(coordinate, mine, its, checked, told, quiet_evidence):
    shape = replace(shapes(quiet_evidence)[0], coordinate=coordinate, log_chance=mine)
    assert standing(shape, replace(shape, log_chance=its), checked) is told


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


def test_nothing_is_found_where_nothing_is_hidden(quiet_evidence):
    assert all(finding.log_chance > -9.5 for finding in scan(quiet_evidence))
    assert all(shape.log_chance > -12.0 for shape in shapes(quiet_evidence))


def test_a_scan_on_many_threads_finds_what_one_finds(quiet_evidence, monkeypatch):
    names = ["cable_spring", "command_delay", "flexible_mode", "force_constant_ripple", "coulomb_asymmetry"]
    found = []
    for threads in (1, 4):
        monkeypatch.setattr("os.cpu_count", lambda threads=threads: threads)
        quiet_evidence.memory.clear()
        found.append([(f.candidate, f.score, list(f.amplitudes)) for f in scan(quiet_evidence, names)])
    assert len(found[0]) > 1
    assert found[0] == found[1]


@pytest.mark.parametrize(
    ("effect", "others"),
    [
        (EFFECTS["cable_spring"](stiffness=1.5), set()),
        (EFFECTS["cogging_harmonic"](period=0.0113, sine=0.12, cosine=-0.05), set()),
        (EFFECTS["viscous_asymmetry"](difference=1.2), set()),
        (EFFECTS["disturbance_tone"](frequency=7.3, sine=0.05, cosine=0.05), set()),
        (EFFECTS["force_constant_ripple"](period=0.021, sine=0.03, cosine=0.0), set()),
        (EFFECTS["quadratic_drag"](coefficient=4.0), {"stribeck_friction"}),
        pytest.param(
            EFFECTS["command_delay"](delay=1.5e-3),
            {"actuator_lag"},
            marks=pytest.mark.xfail(
                strict=True,
                reason="a logged command carries the noise that the loop fed back, and so do columns made of it: a "
                "delay above a sample comes out too small here, and other motion refutes it",
            ),
        ),
    ],
    ids=lambda value: getattr(value, "NAME", ""),
)
def test_a_hidden_effect_is_found_first(effect, others):
    truth, nominal = machine([effect]), machine()
    found = search([record(truth, 11)], nominal, [record(truth, 12)])
    assert found.added
    assert found.added[0].finding.name in {effect.NAME} | others


@pytest.mark.parametrize(
    ("effect", "field"),
    [
        (EFFECTS["cable_spring"](stiffness=1.5, center=0.03), "center"),
        (EFFECTS["force_constant_drift"](change=0.2, time_constant=1.7), "time_constant"),
    ],
    ids=lambda value: getattr(value, "NAME", value),
)
def test_centres_and_time_constants_are_fitted_and_leave_nothing_to_add(effect, field):
    found = search([record(machine([effect]), 11)], machine(), [record(machine([effect]), 12)])
    assert [added.finding.name for added in found.added] == [effect.NAME]
    (place,) = [i for i, path in enumerate(found.estimate.paths) if path.endswith(f"{effect.NAME}.{field}")]
    error = found.estimate.values[place] - getattr(effect, field)
    assert abs(error) < 2.0 * found.estimate.half_width[place]
    assert np.isfinite(found.estimate.half_width[place])


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


def test_levels_of_an_earlier_model_leave_what_was_added():
    before = machine().replace(axis=machine().axis.replace(viscous=4.0, mass=2.1))
    kept = with_levels_of(before, machine([EFFECTS["cable_spring"](stiffness=1.5)]), nuisances(before))
    assert kept.axis == before.axis
    assert [effect.NAME for effect in kept.effects] == ["cable_spring"]


def test_what_hangs_on_an_assumed_contact_has_no_interval():
    model = machine([EFFECTS["backlash"](gap=1e-5, mass_ratio=0.2), EFFECTS["cable_spring"](stiffness=1.5)])
    paths = ("effects.backlash.gap", "effects.backlash.mass_ratio", "effects.cable_spring.stiffness")
    values = np.array([1e-5, 0.2, 1.5])
    assert conditional_paths(model) == set(paths[:2])
    estimate = Estimate(paths, values, np.diag((0.01 * values) ** 2), np.full(3, 1e6), model, (), (), 1)
    intervals = with_intervals(model, estimate).intervals
    assert intervals[paths[0]] == intervals[paths[1]] == (-np.inf, np.inf)
    assert intervals[paths[2]] == pytest.approx((1.5 * (1 - 0.0196), 1.5 * (1 + 0.0196)), rel=1e-4)


def test_few_amplitudes_that_explain_nearly_as_much_come_first():
    def finding(name, count, statistic):
        amplitudes = tuple(("sine", i) for i in range(count))
        candidate = Candidate(name, {}, amplitudes, (1.0,) * count)
        test = evidence_module.Test(statistic, count, np.ones(count), np.ones(5), np.ones(count))
        return Finding(candidate, test, np.ones(count), 1.0, -20.0, statistic)

    many, few, far = finding("cogging_modulation", 10, 100.0), finding("cable_spring", 1, 91.0), finding("x", 1, 89.0)
    assert plainer([many, few]) is few
    assert plainer([many, far]) is many
    assert plainer([few, many]) is few


def test_a_level_below_nothing_is_no_change():
    truth = machine().replace(axis=machine().axis.replace(viscous=9.0))
    found = search([record(truth, 11)], machine())
    (change,) = [one for one in changes(found, machine()) if one[0] == "viscous"]
    assert change[1] == pytest.approx(2.0, abs=0.2)
    lower = replace(found, estimate=replace(found.estimate, values=found.estimate.values - 1e3))
    assert changes(lower, machine()) == []


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


def test_a_loose_load_is_named_whatever_its_contact():
    """In the log the contact is four times as stiff, and rebounds: gap and mass must not hang on that."""
    hidden = EFFECTS["backlash"](gap=3e-5, mass_ratio=0.06, contact_frequency=1500.0, contact_damping_ratio=0.6)
    result = cogging.diagnose(record(machine([hidden]), 1), machine(), confirm=record(machine([hidden]), 2))
    found = next(effect for effect in result.effects if effect.name == "backlash")
    assert found.alternatives == ()
    assert found.parameters["gap"].value == pytest.approx(hidden.gap, rel=0.2)
    assert found.parameters["mass_ratio"].value == pytest.approx(hidden.mass_ratio, rel=0.2)


def test_where_other_motion_cannot_show_it_friction_must_stand_out_further():
    def finding(name, **shape):
        return Finding(Candidate(name, shape, (), ()), None, np.ones(1), 1.0, -30.0, 60.0)

    spell = {"start": 1.0, "stop": 2.0}
    assert needed(finding("stribeck_friction", velocity=0.01)) < needed(finding("command_saturation", limit=10.0))
    assert needed(finding("disturbance_step", **spell)) == needed(finding("coulomb_asymmetry"))
    assert needed(finding("cable_spring", center=0.0)) == needed(finding("command_saturation", limit=10.0))


def test_friction_that_falls_with_time_is_a_drag_over_time():
    hidden = pushed(lambda t, x, v: 1.5 * v * np.exp(-t / 2.0), 4)  # as oil that warms up: less drag in the end
    left = shapes(fit_null([hidden], machine())[1])
    found = next(shape for shape in left if shape.coordinate == "drag over time")
    assert found.log_chance < -15.0
    assert found.log_chance <= left[0].log_chance + 5.0


def test_a_force_with_the_square_of_the_command_is_no_ripple():
    """As reluctance makes it: on one log nearly a ripple of some other period, and no effect of the vocabulary."""
    nominal, reference = machine(), motion(23)
    log = record(nominal, 23)
    added = -0.5 * (log.command / np.abs(log.command).max()) ** 2 * np.sin(2.0 * np.pi * log.position / 0.02 + 0.4)
    columns = cogging.closed_loop(
        nominal.plant(), nominal.make_controller(), reference, seed=23, duration=8.0, steps_per_sample=4,
        added_command=added,
    )  # fmt: skip
    logged = cogging.Log(columns["time"], columns["position"], columns["command"] - added)
    evidence = fit_null([logged], nominal)[1]
    best = max(scan(evidence, ["force_constant_ripple", "cogging_harmonic"]), key=lambda one: one.score)
    found = {shape.coordinate.split(" every ")[0]: shape for shape in twins(evidence, best)}
    square = found.pop("square of the command")
    assert square.coordinate.endswith(" mm")
    assert float(square.coordinate.split()[-2]) == pytest.approx(20.0, rel=0.15)  # few places see a large command
    assert square.score > best.score + 6.0
    assert all(square.test.statistic > other.test.statistic for other in found.values())
    assert np.ptp(square.force) == pytest.approx(2.0 * 0.5, rel=0.3)
    spring = max(scan(evidence, ["cable_spring"]), key=lambda one: one.score)
    assert twins(evidence, spring) == []


def test_a_true_ripple_has_no_better_twin():
    hidden = machine([EFFECTS["force_constant_ripple"](period=0.02, sine=0.05)])
    evidence = fit_null([record(hidden, 24)], machine())[1]
    (ripple,) = profiled(evidence, scan(evidence, ["force_constant_ripple"]))
    assert ripple.candidate.shape["period"] == pytest.approx(0.02, rel=0.01)
    assert all(twin.score < ripple.score for twin in twins(evidence, ripple))


def test_what_did_not_pay_stays_a_rival_of_what_comes_in_its_place():
    explained = np.array([1.0, 2.0, 0.5])

    def finding(name, score):
        test = evidence_module.Test(score + 4.0, 1, np.ones(1), explained, np.ones(1))
        return Finding(Candidate(name, {}, (), ()), test, np.ones(1), 1.0, -30.0, score)

    unpaid, found = finding("constant_force", 85.0), finding("viscous_asymmetry", 70.0)
    rivals, chosen, _ = choose([unpaid, found], found, None, None, set(), {}, {"constant_force"})
    assert chosen is found
    assert [rival.name for rival in rivals] == ["viscous_asymmetry", "constant_force"]
    _, chosen, _ = choose([unpaid, found], found, None, None, set(), {})
    assert chosen is unpaid


@pytest.mark.parametrize(("force", "expected"), [(0.02, ()), (0.3, ("quadratic_drag",))])
def test_a_change_that_noise_does_not_tell_from_drag_has_it_as_an_alternative(force, expected):
    nominal, noisy = machine(), machine(force=force)
    log = record(noisy.replace(axis=noisy.axis.replace(viscous=6.0)), 32)
    told = search([log], nominal)
    assert [change[0] for change in changes(told, nominal) if abs(change[3]) > 4.0] == ["viscous"]
    assert look_alikes(told, nominal, "viscous") == expected
    assert look_alikes(told, nominal, "mass") == ()


def test_a_name_is_doubted_where_more_was_refused_than_added():
    told = search([record(machine([EFFECTS["cable_spring"](stiffness=1.5)]), 33)], machine())
    plain, finding = named(told, 0, []), told.added[0].finding
    largest = max(added.finding.test.statistic for added in told.added)
    for factor, doubted in ((1.1, True), (0.9, False)):
        test = replace(finding.test, statistic=factor * largest)
        refused = replace(finding, test=test, log_chance=-60.0)
        again = named(replace(told, unused=[refused]), 0, [])
        assert again.confidence == pytest.approx(plain.confidence * (0.75 if doubted else 1.0), abs=0.002)
    faint = replace(finding, test=replace(finding.test, statistic=1.1 * largest), log_chance=-20.0)
    assert named(replace(told, unused=[faint]), 0, []).confidence == plain.confidence


def test_an_error_of_the_reading_repeats_in_the_travel(quiet_evidence):
    found, _ = waves.peaks(quiet_evidence, "encoder_periodic_error")
    assert found
    assert all(1.5 * one.shape["period"] < 1.01 * quiet_evidence.scales.position for one in found)
    encoder = cogging.EncoderParameters(resolution=1e-4)
    coarse = replace(quiet_evidence, model=quiet_evidence.model.replace(encoder=encoder))
    assert all(one.shape["period"] > 0.99 * 32e-4 for one in waves.peaks(coarse, "encoder_periodic_error")[0])
