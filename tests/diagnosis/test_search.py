"""What `diagnose` adds, refuses and says: search, choice, names and verdict."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

import cogging
from cogging import EFFECTS
from cogging.diagnosis.candidates.scan import Finding, profiled, scan
from cogging.diagnosis.candidates.signatures import Candidate
from cogging.diagnosis.discrepancy import discrepancies, follows
from cogging.diagnosis.evidence import evidence as evidence_module
from cogging.diagnosis.evidence.null import fit_null, nuisances
from cogging.diagnosis.naming.level_changes import changes, look_alikes
from cogging.diagnosis.naming.names import fully_named, named
from cogging.diagnosis.naming.verdict import standing, unlisted
from cogging.diagnosis.patched import with_intervals
from cogging.diagnosis.residual.events import FRICTION_INTERVALS, JUMPS
from cogging.diagnosis.residual.modulated_look_alikes import modulated_look_alikes
from cogging.diagnosis.residual.shapes import shapes
from cogging.diagnosis.search.confirmation import Confirmation, retuned
from cogging.diagnosis.search.refit import conditional_paths
from cogging.diagnosis.search.search import (
    choose,
    is_rounding,
    is_seen,
    needed,
    plainer,
    search,
    that_pays,
    told_apart,
    with_levels_of,
)
from cogging.estimation.gauss_newton import Estimate
from tests.fixtures.moving_axis import machine, motion, record


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
        (FRICTION_INTERVALS, -19.0, -9.0, True, None),
        (FRICTION_INTERVALS, -25.0, -14.0, True, None),
        (FRICTION_INTERVALS, -45.0, -20.0, True, True),
        (FRICTION_INTERVALS, -101.0, 0.0, False, True),
    ],
)
def test_what_is_left_stands_by_both_motions(coordinate, mine, its, checked, told, quiet_evidence):
    shape = replace(shapes(quiet_evidence)[0], coordinate=coordinate, log_p_value=mine)
    assert standing(shape, replace(shape, log_p_value=its), checked) is told


def test_nothing_is_found_where_nothing_is_hidden(quiet_evidence):
    assert all(finding.log_p_value > -9.5 for finding in scan(quiet_evidence))
    assert all(shape.log_p_value > -12.0 for shape in shapes(quiet_evidence))


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
        # A logged command carries the noise that the loop fed back, and so do columns made of it: a delay above a
        # sample comes out too small, and on some logs (not on this one) other motion refutes it for that.
        (EFFECTS["command_delay"](delay=1.5e-3), {"actuator_lag"}),
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


def test_what_other_motion_shows_is_a_chance_of_its_own():
    seen = Confirmation(noncentrality=40.0, ratio=0.9, gain=30.0)
    assert seen.log_p_value == pytest.approx(np.log(stats.norm.sf(0.9 * np.sqrt(40.0))))
    assert replace(seen, turn=1.0).log_p_value == pytest.approx(np.log(stats.chi2(2).sf(0.81 * 40.0)))
    assert replace(seen, ratio=0.1, gain=-10.0).log_p_value == 0.0  # refuted
    assert replace(seen, noncentrality=5.0).log_p_value == 0.0  # cannot show it


@pytest.mark.parametrize(
    ("alone", "noncentrality", "other_power", "told"),
    [
        (-10.0, None, 0.0, True),
        (-9.0, None, 0.0, False),
        (-4.0, 40.0, 1000.0, True),
        (-4.0, 12.0, 1000.0, False),  # both together, less than is asked of them
        (-4.0, 40.0, 1e4, False),  # nothing worth a name on the other motion
    ],
)
def test_both_motions_together_may_show_what_neither_shows_alone(alone, noncentrality, other_power, told):
    test = evidence_module.Test(12.0, 1, np.ones(1), np.ones(3), np.ones(1))
    finding = Finding(Candidate("cable_spring", {}, (), ()), test, np.ones(1), 1.0, alone, 10.0)
    check = None if noncentrality is None else Confirmation(noncentrality, 1.0, noncentrality)
    assert is_seen(finding, check, 1000.0, other_power) is told


def test_a_wave_may_turn_where_the_zeros_of_position_differ():
    log, other = record(machine(), 11), record(machine(), 12)
    moved = cogging.Log(other.time, other.position + 0.01, other.command)
    fitted, _ = fit_null([log], machine())
    assert not retuned([other], fitted.model, machine(), fitted.paths).turns
    assert retuned([moved], fitted.model, machine(), fitted.paths).turns
    bare = machine().replace(cogging=None)
    fitted, _ = fit_null([log], bare)
    assert retuned([other], fitted.model, bare, fitted.paths).turns


def test_where_an_encoder_is_coarse_what_is_left_must_stand_out_twice_as_far():
    told = search([record(machine(), 34)], machine())
    source, part = told.evidence.sources[0], told.evidence.parts[0]
    power = np.mean((part.residual[source.counts > 0] / source.scale) ** 2)
    assert told.evidence.rounding == pytest.approx(1e-14 / 12.0 / power, rel=1e-9)

    def seen_with(resolution):
        encoder = cogging.EncoderParameters(resolution=resolution)
        return replace(told.evidence, model=told.evidence.model.replace(encoder=encoder))

    fine, coarse = seen_with(1e-9), seen_with(1e-5)
    assert fine.rounding < 1e-4
    assert coarse.rounding == 1.0
    shape = replace(shapes(told.evidence)[0], coordinate="position", log_p_value=-20.0)
    for evidence, log_p_value, expected in ((fine, -20.0, True), (coarse, -20.0, False), (coarse, -30.0, True)):
        left = replace(told, evidence=evidence, residual_shapes=[replace(shape, log_p_value=log_p_value)])
        assert (unlisted(left, [], checked=False) is not None) is expected


def test_what_rounding_explains_better_is_no_effect():
    def finding(name, score, explained, faint=False):
        test = evidence_module.Test(score, 2, np.ones(2), np.array(explained), np.ones(2))
        return Finding(Candidate(name, {"period": 0.01}, (), ()), test, np.ones(2), 1.0, -30.0, score, faint)

    force = finding("cogging_harmonic", 50.0, [1.0, 2.0, 0.0])
    stronger = finding("encoder_periodic_error", 60.0, [1.0, 1.9, 0.1], faint=True)
    weaker = finding("encoder_periodic_error", 40.0, [1.0, 1.9, 0.1], faint=True)
    unlike = finding("encoder_periodic_error", 60.0, [0.0, 0.1, 5.0], faint=True)
    assert told_apart([force, stronger]) == ([force], [stronger])
    assert is_rounding(force, [stronger])
    assert not is_rounding(force, [weaker, unlike])
    assert not is_rounding(force, [])


@pytest.mark.parametrize(("terms", "expected"), [(3, ["encoder_periodic_error"]), (2, [])])
def test_a_wave_beside_as_many_terms_as_a_name_may_have_is_doubtful(terms, expected):
    names = [*["encoder_periodic_error"] * terms, "disturbance_tone", "cable_spring"]
    found = SimpleNamespace(added=[SimpleNamespace(finding=SimpleNamespace(name=name)) for name in names])
    assert fully_named(found, terms) == expected
    assert fully_named(found, terms + 1) == []  # no wave
    assert fully_named(found, 0) == []


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

    interval = {"start": 1.0, "stop": 2.0}
    assert needed(finding("stribeck_friction", velocity=0.01)) < needed(finding("command_saturation", limit=10.0))
    assert needed(finding("disturbance_step", **interval)) == needed(finding("coulomb_asymmetry"))
    assert needed(finding("cable_spring", center=0.0)) == needed(finding("command_saturation", limit=10.0))


def test_a_force_with_the_square_of_the_command_is_no_ripple():
    """As reluctance makes it: on one log nearly a ripple of some other period, and no effect of the vocabulary."""
    nominal, reference = machine(), motion(23)
    log = record(nominal, 23)
    added = -0.5 * (log.command / np.abs(log.command).max()) ** 2 * np.sin(2.0 * np.pi * log.position / 0.02 + 0.4)
    columns = cogging.closed_loop(
        nominal.plant(), nominal.make_controller(), reference, seed=23, duration=8.0, steps_per_sample=4,
        added_command=added,
    )  # fmt: skip
    logged = cogging.Log(columns.time, columns.position, columns.command - added)
    evidence = fit_null([logged], nominal)[1]
    best = max(scan(evidence, ["force_constant_ripple", "cogging_harmonic"]), key=lambda one: one.score)
    found = {shape.coordinate.split(" every ")[0]: shape for shape in modulated_look_alikes(evidence, best)}
    square = found.pop("square of the command")
    assert square.coordinate.endswith(" mm")
    assert float(square.coordinate.split()[-2]) == pytest.approx(20.0, rel=0.15)  # few places see a large command
    assert square.score > best.score + 6.0
    assert all(square.test.statistic > other.test.statistic for other in found.values())
    assert np.ptp(square.force) == pytest.approx(2.0 * 0.5, rel=0.3)
    spring = max(scan(evidence, ["cable_spring"]), key=lambda one: one.score)
    assert modulated_look_alikes(evidence, spring) == []


def test_a_true_ripple_has_no_better_look_alike():
    hidden = machine([EFFECTS["force_constant_ripple"](period=0.02, sine=0.05)])
    evidence = fit_null([record(hidden, 24)], machine())[1]
    (ripple,) = profiled(evidence, scan(evidence, ["force_constant_ripple"]))
    assert ripple.candidate.shape["period"] == pytest.approx(0.02, rel=0.01)
    assert all(look_alike.score < ripple.score for look_alike in modulated_look_alikes(evidence, ripple))


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
        refused = replace(finding, test=test, log_p_value=-60.0)
        again = named(replace(told, unused=[refused]), 0, [])
        assert again.confidence == pytest.approx(plain.confidence * (0.75 if doubted else 1.0), abs=0.002)
    faint = replace(finding, test=replace(finding.test, statistic=1.1 * largest), log_p_value=-20.0)
    assert named(replace(told, unused=[faint]), 0, []).confidence == plain.confidence
