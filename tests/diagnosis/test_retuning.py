"""Candidates that are not linear at the model without them, and forces that re-tuning absorbs."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import cogging
from cogging.diagnosis.balance.candidates import Search, is_monotone, search_once, wave_scan
from cogging.diagnosis.balance.decision import contender, search
from cogging.diagnosis.balance.differenced_balance import DifferencedBalance
from cogging.diagnosis.balance.evidence import Evidence
from cogging.diagnosis.diagnosis import _objections
from cogging.diagnosis.named_effects import named
from cogging.diagnosis.patched_model import Term, terms_of
from tests.fixtures import moving_axis, pid_axis
from tests.fixtures.pid_axis import FAST, other, run

PITCH = 0.012  # m
WAVE = cogging.CoggingModel(cogging.SplineHarmonics(periods=[PITCH]), sine=[[0.2]], cosine=[[0.0]])
MODEL = pid_axis.MODEL.replace(cogging=WAVE)
MACHINE = moving_axis.machine()
#: The same stated wrongly, within its uncertainty but for the width of friction.
STATED = MACHINE.replace(axis=MACHINE.axis.replace(mass=2.02, coulomb=1.6, coulomb_width=3e-3))


def balance(*effects, model=MODEL):
    return DifferencedBalance(run(*effects, model=model), model.axis.coulomb_width, model.encoder.resolution)


def unguided(log):
    """The log without its reference."""
    return cogging.Log(log.time, log.position, log.command)


def searched(true, seed, stated):
    """What two logs of a machine show, whose motions and noise belong to a seed."""
    return search(*([moving_axis.record(true, 10 * seed + k)] for k in (1, 2)), stated)


@pytest.mark.parametrize("scale", [0.004, *(pytest.param(scale, marks=pytest.mark.study) for scale in (-0.002, 0.001))])
def test_a_scale_error_that_turns_the_known_cogging_is_not_taken_for_a_modulation(scale):
    """It turns the cogging by up to 0.8 rad: the model without it has the mean phase and too little cogging."""
    hidden = cogging.EFFECTS["encoder_scale_error"](scale=scale)
    outcome = search([run(hidden, model=MODEL)], [other(hidden, model=MODEL)], MODEL)
    first = outcome.accepted[0]
    assert first.found.name == "encoder_scale_error"
    assert first.share > 0.8
    assert outcome.both.model.effects[0].scale == pytest.approx(scale, abs=2e-4)


def test_retuning_finds_phase_and_gain_of_cogging_from_afar():
    turned = cogging.CoggingModel(WAVE.basis, sine=[[0.25 * np.cos(1.2)]], cosine=[[0.25 * np.sin(1.2)]])
    evidence = Evidence([balance()], MODEL, MODEL.replace(cogging=turned)).prepare(3, listen=True)
    found = evidence.model.cogging
    assert np.array([found.sine, found.cosine]).ravel() == pytest.approx([0.2, 0.0], abs=4e-3)


def test_an_error_of_the_reading_scales_noise_and_motion_alike():
    """Else one of two models of the same force is likelier, by the noise alone."""
    b = balance()
    bare = MODEL.replace(cogging=None)
    wrong = bare.replace(effects=(cogging.EFFECTS["encoder_scale_error"](scale=0.01),))
    lighter = bare.replace(axis=bare.axis.replace(mass=0.99 * bare.axis.mass))
    inertia = b.residual(wrong) - b.residual(lighter)
    friction = 0.01 * bare.axis.viscous * np.abs(b.velocity).max()
    assert np.std(b.residual(bare)) > 10 * friction
    assert np.abs(inertia[b.keep > 0]).max() < 2 * friction


def test_a_change_in_time_or_along_the_travel_has_no_constant_part():
    """Constant friction is Coulomb or viscous friction, which re-tuning absorbs whatever its law."""
    b = balance()
    evidence = Evidence([b], MODEL, MODEL).prepare(1, listen=True)
    shapes = {f.name: f for f in search_once(evidence, {})}
    for name, part in (("~friction in time", np.sign(b.velocity)), ("~viscous along travel", b.velocity)):
        [columns] = shapes[name].columns(evidence)
        fast = (b.keep > 0) & (np.abs(b.velocity) > 0.05)
        basis = columns[:, fast] / part[fast]
        left = np.ones(fast.sum()) - basis.T @ np.linalg.lstsq(basis.T, np.ones(fast.sum()))[0]
        assert np.std(left) > 0.02 or abs(left.mean()) > 0.02
        assert contender(evidence, shapes[name], 1).score < 10.0


@pytest.mark.parametrize("periods", [2.7, 8.0])
def test_a_modulated_wave_has_more_periods_than_its_envelope_has_turns(periods):
    """With fewer it is a force of any smooth shape."""
    knots = {"pitch": 0.11, "order": 4, "origin": 0.08}
    wave = {"period": 0.32 / periods, "sine": [0.06, -0.06, 0.06, -0.06, 0.06, -0.06], "cosine": [0.0] * 6}
    model = FAST.replace(cogging=WAVE)
    b = balance(cogging.EFFECTS["cogging_modulation"](**wave, **knots), model=model)
    found = search_once(Evidence([b], model, model).prepare(1, listen=True), {})
    assert any(f.name == "cogging_modulation" and f.T > 50.0 for f in found) is (periods > 5)


@pytest.mark.parametrize("seed", [1, 11])
def test_a_mode_is_fitted_with_intervals_that_hold_it(seed):
    """Its ringing is in the command too, for as long as it lasts."""
    true = {"frequency": 40.0, "damping_ratio": 0.05, "mass_ratio": 0.1}
    mode = cogging.EFFECTS["flexible_mode"](**true)
    found = cogging.diagnose(run(mode, model=FAST, seed=seed), FAST, confirm=other(mode, model=FAST))
    assert found.verdict == "named"
    assert [effect.name for effect in found.effects] == ["flexible_mode"]
    for name, value in true.items():
        low, high = found.effects[0].parameters[name].ci95
        assert low < value < high
        assert high - low < (0.03 if name == "frequency" else 0.7) * value
    assert found.gap.confirm_after < 0.95 * found.gap.confirm_before
    assert found.model.effects[0].NAME == "flexible_mode"


@pytest.mark.parametrize("length", [2e-5, 1e-4])
def test_presliding_is_seen_in_the_rows_near_rest(length):
    """Most of its motion is slower than the noise of the speed; the readings show it, the speed does not."""
    presliding = cogging.effects.PreslidingFriction(stiffness=pid_axis.MODEL.axis.coulomb / length)
    [one] = search([run(presliding, duration=8.0)], [other(presliding)], pid_axis.MODEL).accepted
    assert one.found.name == "presliding_friction"
    assert one.share > 0.9
    [law] = one.found.laws(one.found.amplitudes)
    assert 0.5 < law.stiffness / presliding.stiffness < 2.0


@pytest.mark.parametrize("width", [0.0, 1.11e-3])
def test_friction_that_sticks_is_no_presliding(width):
    model = pid_axis.MODEL.replace(axis=pid_axis.MODEL.axis.replace(coulomb_width=width))
    logs = run(model=model, duration=8.0), other(model=model)
    assert not search(logs[:1], logs[1:], pid_axis.MODEL).accepted


@pytest.mark.parametrize("seed", range(3))
def test_a_constant_force_that_makes_most_of_the_command_is_one(seed):
    """Each candidate has residual forces of its own, which must not decide between one and two parameters."""
    outcome = searched(moving_axis.machine([cogging.EFFECTS["constant_force"](force=6.0)]), seed, STATED)
    assert outcome.nominal.largely
    first = outcome.accepted[0].found
    assert first.name == "constant_force"
    assert first.amplitudes == pytest.approx([6.0], rel=0.02)


def test_where_a_model_lacks_most_a_name_is_less_certain_beside_others_and_if_it_takes_little():
    """Of drawn logs, half of the names that take less than a tenth of the gap are wrong: docs/evidence.md."""
    outcome = searched(moving_axis.machine([cogging.EFFECTS["constant_force"](force=6.0)]), 1, STATED)
    final, terms = terms_of(outcome, STATED)
    assert outcome.nominal.largely
    own = replace(terms[0].accepted, share=1.0)
    each = [replace(terms[0], accepted=replace(own, found=replace(own.found, name=name))) for name in "abb"]
    lists = (([0.02], {}), ([0.9, 0.02], {}), ([0.9, 0.08, 0.08], {}), ([0.9, 0.5], {1: "why"}))
    told = [named(each[: len(k)], final, outcome.evidence, k, out) for k, out in lists]
    found = [one.confidence / own.found.likeness for effects in told for one in effects]
    assert found == pytest.approx([0.92, 0.89, 0.5, 0.89, 0.89, 0.92, 0.5 / own.found.likeness])


@pytest.mark.parametrize(("size", "seed"), [(2.0, 2), (20.0, 3), (20.0, 4)])
def test_a_snag_with_an_edge_is_a_local_force(size, seed):
    """No bell is like it, and the rows in which it makes all of a large command are no outliers."""
    places = np.linspace(-0.16, 0.16, 641)
    force = np.where(places > 0.02, -size * np.exp((0.02 - places) / 0.01), 0.0)
    true = moving_axis.machine([cogging.effects.EmpiricalForce(position_nodes=places, position_forces=force)])
    assert searched(true, seed, STATED).accepted[0].found.name == "local_force"


@pytest.mark.parametrize(("way", "said"), [(1, "forwards"), (-1, "backwards")])
def test_counts_lost_at_one_place_are_found_there(way, said):
    """Three quantisation steps at each passage in one direction are too few to be found one by one."""

    def lossy(log):
        beyond = way * (log.true_position - 0.2) > 0.0
        lost = 1.5e-6 * np.cumsum(np.diff(beyond.astype(int), prepend=int(beyond[0])) > 0)
        return cogging.Log(log.time, log.position - way * lost, log.command, log.reference)

    [one] = search([lossy(run(duration=8.0))], [lossy(other())], pid_axis.MODEL).accepted
    assert (one.found.name, one.found.label) == ("~jump of the reading along travel", f"0.2 m {said}")


@pytest.mark.parametrize("effects", [(), (cogging.EFFECTS["command_delay"](delay=1e-3),)])
def test_without_a_reference_noise_of_the_readings_in_the_command_is_no_delay(effects):
    """The quantiser's steps return in the command, in the same row: columns of the command correlated with them."""
    model = pid_axis.MODEL.replace(controller=None, controller_type=None)
    logs = [unguided(log) for log in (run(*effects, duration=8.0), other(*effects))]
    found = search(logs[:1], logs[1:], model).accepted
    assert [one.found.name for one in found] == [e.NAME for e in effects]


@pytest.mark.parametrize(
    ("model", "changed", "kd", "seed"),
    [
        (pid_axis.MODEL, {"force": 0.06, "resolution": 5e-9, "coulomb": 0.15}, 48.0, 1),  # was a delay
        (FAST, {"force": 0.03, "resolution": 5e-9, "coulomb": 0.05}, 48.0, 1),  # was an unlisted force of the command
        (FAST, {"force": 0.03, "resolution": 5e-9, "coulomb": 0.05, "bandwidth": 100.0}, 30.0, 3),  # was Stribeck
    ],
)
def test_without_a_reference_noise_that_moves_the_axis_is_no_effect(model, changed, kd, seed):
    """It pushes an axis at rest, and the loop answers it: speed and command are correlated with it."""
    parts = {"axis": ["coulomb"], "controller": ["coulomb"], "encoder": ["resolution"], "noise": ["force", "bandwidth"]}
    for part, names in parts.items():
        own = {name: changed[name] for name in names if name in changed} | ({"kd": kd} if part == "controller" else {})
        model = model.replace(**{part: getattr(model, part).replace(**own)})
    logs = [unguided(log) for log in (run(model=model, seed=seed, duration=6.0, dwell=0.3), other(model=model))]
    b = DifferencedBalance(logs[0], model.axis.coulomb_width, model.encoder.resolution)
    b.listen(b.residual(model), model.axis)
    assert b.crossover == pytest.approx(kd / model.axis.mass / (2 * np.pi), rel=0.3)
    known = model.replace(controller=None, controller_type=None)
    assert cogging.diagnose(logs[0], known, confirm=logs[1]).verdict == "no_gap"


@pytest.mark.parametrize(("delay", "seed"), [(0.5e-3, 1), (1e-3, 2), (1.7e-3, 2), (2.3e-3, 1), (2.3e-3, 2)])
def test_the_interval_of_a_delay_holds_it_without_a_reference(delay, seed):
    """The command answers noise too, and a column of that answer made it a fifth of a sample longer, z 2.5 to 5.5."""
    true = moving_axis.machine([cogging.EFFECTS["command_delay"](delay=delay)])
    logs = [unguided(moving_axis.record(true, 10 * seed + k)) for k in (0, 1)]
    found = cogging.diagnose(logs[0], STATED.replace(controller=None, controller_type=None), confirm=logs[1])
    first = found.effects[0]
    assert "command_delay" in {first.name, *first.alternatives}
    value = first.parameters["delay" if first.name == "command_delay" else "time_constant"]
    low, high = value.ci95
    assert low < delay < high < low + 0.25 / moving_axis.RATE
    assert value.value == pytest.approx(delay, abs=0.025 / moving_axis.RATE)  # seen: 0.021


@pytest.mark.parametrize(
    ("name", "fields", "seed"),
    [
        ("force_constant_ripple", {"period": 0.045, "sine": 0.56, "cosine": 0.23}, 5),
        ("actuator_lag", {"time_constant": 6e-3}, 6),
        ("command_dead_zone", {"width": 6.0}, 8),
    ],
)
def test_what_changes_most_of_the_command_is_named_without_a_reference(name, fields, seed):
    """Columns of the command without its fast part showed four other effects, a delay with a mode, and nothing."""
    true = moving_axis.machine([cogging.EFFECTS[name](**fields)])
    logs = [unguided(moving_axis.record(true, 10 * seed + k)) for k in (1, 2)]
    outcome = search(logs[:1], logs[1:], STATED)
    assert [(one.found.name, one.share > 0.9) for one in outcome.accepted] == [(name, True)]
    [law] = (e for e in outcome.both.model.effects if name == e.NAME)
    assert {field: getattr(law, field) for field in fields} == pytest.approx(fields, rel=0.01)  # seen: 7.8e-3


def test_a_constant_force_may_be_an_asymmetry_of_steep_friction():
    """Nothing tells them apart while the axis moves: only friction that is not steep dips at reversals."""
    force, difference = (
        cogging.EFFECTS["constant_force"](force=-1.5),
        cogging.EFFECTS["coulomb_asymmetry"](difference=3.0),
    )
    first = searched(MACHINE.replace(effects=[force]), 4, STATED).accepted[0]
    assert first.found.name == "constant_force"
    assert dict(first.alternatives)["coulomb_asymmetry"] > 0.2
    assert searched(MACHINE.replace(effects=[difference]), 4, STATED).accepted[0].found.name == "coulomb_asymmetry"


def test_effects_stand_in_the_order_of_their_forces():
    """Without one of two effects that act on the same command, the gap may grow beyond what both leave."""
    hidden = [cogging.EFFECTS["command_dead_zone"](width=1.0), cogging.EFFECTS["cable_spring"](stiffness=60.0)]
    true = moving_axis.machine(hidden)
    found = cogging.diagnose(moving_axis.record(true, 31), STATED, confirm=moving_axis.record(true, 32))
    assert [e.name for e in found.effects] == ["cable_spring", "command_dead_zone"]
    shares = [e.share for e in found.effects]
    assert sum(shares) == pytest.approx(1.0 - (found.gap.after / found.gap.before) ** 2)
    assert shares[1] < 0.3 * shares[0]


@pytest.mark.parametrize(
    "seed", [0, 3, 9, *(pytest.param(seed, marks=pytest.mark.study) for seed in (1, 4, 6, 7, 8, 10, 11))]
)
def test_two_effects_that_cancel_at_one_speed_are_found_together(seed):
    """On strokes of one speed a log, neither alone explains both logs, but other effects explain a part."""
    random = np.random.default_rng(seed)
    speeds = np.exp(random.uniform(np.log(0.05), np.log(0.4), 2))
    between = float(np.sqrt(np.prod(speeds)) * np.exp(0.2 * random.normal()))
    force = float(np.exp(random.uniform(np.log(0.1), np.log(2.0))) * random.choice([-1, 1]))
    true = {"constant_force": {"force": force}, "viscous_asymmetry": {"difference": 2.0 * force / between}}
    machine = moving_axis.machine([cogging.EFFECTS[name](**fields) for name, fields in true.items()])
    logs = [moving_axis.record(machine, 10 * seed + k, moving_axis.strokes(v)) for k, v in enumerate(speeds, 1)]
    accepted = search(logs[:1], logs[1:], STATED).accepted
    names = [{one.found.name, *(name for name, _ in one.alternatives)} for one in accepted]
    assert len(names) == 2
    assert all(any(name in one for one in names) for name in true)


@pytest.mark.parametrize("seed", [2, 4])
def test_a_force_of_any_shape_makes_way_for_the_effects_that_it_stood_in_for(seed):
    """At first it explains more than either of two large effects; the build before kept it beside them."""
    laws = {
        "cable_spring": {"stiffness": 40.0, "center": 0.05},
        "disturbance_step": {"force": 6.0, "start": 2.0, "stop": 5.0},
    }
    found = searched(moving_axis.machine([cogging.EFFECTS[one](**of) for one, of in laws.items()]), seed, STATED)
    own = found.evidence.model.effects
    assert sorted(e.NAME for e in own) == sorted(one.found.name for one in found.accepted) == sorted(laws)
    for effect in own:
        assert effect.to_dict() | laws[effect.NAME] == pytest.approx(effect.to_dict(), rel=2e-3)  # seen: 1.1e-3


@pytest.mark.parametrize(("change", "seed"), [(-0.8, 0), (-0.8, 1), (1.5, 0), (1.5, 3)])
def test_a_force_constant_that_changes_by_most_of_itself_is_a_drift(change, seed):
    """The command that the motion needs is then not linear in the change."""
    law = cogging.EFFECTS["force_constant_drift"](change=change, time_constant=3.0)
    outcome = searched(moving_axis.machine([law]), seed, STATED)
    first = outcome.accepted[0]
    assert first.found.name == "force_constant_drift"
    assert first.share > 0.9
    found = next(e for e in outcome.evidence.model.effects if e.NAME == "force_constant_drift")
    assert [found.change, found.time_constant] == pytest.approx([change, 3.0], rel=0.04)  # seen: 2.8 %


@pytest.mark.parametrize(("strength", "seed"), [(1.0, 1), (1.0, 6), (1.0, 9), (3.0, 4), (3.0, 6)])
def test_the_ends_of_the_travel_have_forces_and_decay_lengths_of_their_own(strength, seed):
    """Given motions reach 5 to 10 cm from them; along some others they are a spring of any shape (seed 0)."""
    law = cogging.EFFECTS["end_effect"]
    low = law(force=4.0 * strength, decay_length=0.03, travel=[-0.15, 9.0])
    high = law(force=9.0 * strength, decay_length=0.05, travel=[-9.0, 0.15])
    outcome = searched(moving_axis.machine([low, high]), seed, STATED)
    assert [one.found.name for one in outcome.accepted] == ["end_effect"]
    for found, end, force, length in zip(
        outcome.evidence.model.effects, (-0.15, 0.15), (4.0 * strength, 9.0 * strength), (0.03, 0.05), strict=True
    ):
        at_end = found.force * np.exp(min(abs(end - one) for one in found.travel) / found.decay_length)
        assert [at_end, found.decay_length] == pytest.approx([force, length], rel=0.06)  # seen: 5 %


@pytest.mark.parametrize(("width", "seed"), [(8.0, 4), (20.0, 1), (20.0, 3), (20.0, 6)])
def test_a_dead_zone_may_take_most_of_the_command(width, seed):
    """It is known by the command that passes it, some 2 V rms."""
    true = moving_axis.machine([cogging.EFFECTS["command_dead_zone"](width=width)])
    logs = [moving_axis.record(true, 10 * seed + k) for k in (0, 1)]
    found = cogging.diagnose(logs[0], STATED, confirm=logs[1])
    assert [e.name for e in found.effects] == ["command_dead_zone"]
    value = found.effects[0].parameters["width"]
    assert value.value == pytest.approx(width, rel=2e-3)  # seen: 1.7e-3
    low, high = value.ci95
    assert abs(width - 0.5 * (low + high)) < 0.6 * (high - low) < 2e-3 * width  # two of four are 1.1 half widths off


@pytest.mark.parametrize(
    "seed", [0, 5, 7, *(pytest.param(seed, marks=pytest.mark.study) for seed in (2, 3, 4, 6, 20, 21, 22, 23))]
)
@pytest.mark.parametrize("closed", [True, False])
def test_a_dead_zone_is_named_on_strokes_of_one_speed(seed, closed):
    """Mass and friction, re-tuned by ten of their stated deviations, explain most of it there."""
    random = np.random.default_rng(seed)
    width, speeds = np.exp(random.uniform(*np.log([3.0, 12.0]))), np.exp(random.uniform(*np.log([0.1, 0.5]), 2))
    true = moving_axis.machine([cogging.EFFECTS["command_dead_zone"](width=width)])
    logs = [moving_axis.record(true, 10 * seed + k, moving_axis.strokes(v, 0.24)) for k, v in enumerate(speeds, 1)]
    stated = STATED if closed else STATED.replace(controller=None, controller_type=None)
    if not closed:
        logs = [cogging.Log(log.time, log.position, log.command) for log in logs]
    found = cogging.diagnose(logs[0], stated, confirm=logs[1])
    assert found.verdict == "named"
    assert [e.name for e in found.effects] == ["command_dead_zone"]
    assert found.effects[0].parameters["width"].value == pytest.approx(width, rel=3e-3)
    assert found.gap.after < 0.1 * found.gap.before


@pytest.mark.parametrize("share", [0.7, 0.95])
def test_retuning_finds_the_width_of_a_dead_zone_from_afar(share):
    """Where it ends, the command differs much from the part of it that the reference explains."""
    true = moving_axis.machine([cogging.EFFECTS["command_dead_zone"](width=8.0)])
    logs = [moving_axis.record(true, seed) for seed in (40, 41)]
    start = STATED.replace(effects=[cogging.EFFECTS["command_dead_zone"](width=8.0 * share)])
    balances = [DifferencedBalance(log, STATED.axis.coulomb_width) for log in logs]
    found = Evidence(balances, STATED, start).prepare(3, listen=True, orthogonal=True).model
    assert found.effects[0].width == pytest.approx(8.0, rel=1.2e-3)  # seen: 0.9e-3
    assert found.axis.mass == pytest.approx(2.0, rel=3e-3)  # seen: 2.0e-3


def with_a_play(machine, gap, share, log):
    """The play that two logs show beside its machine, the interval of its share, and how many effects they show."""
    true = machine.replace(effects=[cogging.EFFECTS["backlash"](gap=gap, mass_ratio=share)])
    outcome = search([log(true, 0)], [log(true, 1)], machine)
    assert outcome.accepted[0].found.name == "backlash"
    model, terms = terms_of(outcome, machine)
    return terms[0].effect, model.intervals["effects.backlash.mass_ratio"], len(terms)


def test_a_play_shows_by_its_impacts():
    """Each lasts for two rows, which a fit without it takes for outliers."""
    kp, ki, kd = cogging.pid_gains([-250.0] * 3, 2.0)
    stiff = MACHINE.replace(controller=cogging.PidParameters(sample_rate=2000.0, kp=kp, ki=ki, kd=kd))

    def log(true, k):
        return cogging.simulate(true, moving_axis.motion(30 + k, 2000.0), seed=30 + k, duration=8.0, steps_per_sample=2)

    found, (low, high), count = with_a_play(stiff, 5e-3, 0.15, log)
    assert count == 1
    assert found.gap == pytest.approx(5e-3, rel=4e-3)  # seen: 3.4e-3
    assert found.mass_ratio == pytest.approx(0.15, rel=0.05)  # seen: 4.5 %
    assert abs(0.15 - 0.5 * (low + high)) < 0.8 * (high - low) < 0.008  # 1.52 half widths


@pytest.mark.parametrize(("gap", "share", "seed"), [(5e-2, 0.2, 6), (1e-2, 0.4, 8), (1e-2, 0.1, 1)])
def test_a_play_shows_while_the_load_is_apart(gap, share, seed):
    """Then the motor has only its own mass; the impacts come some rows earlier or later than columns say."""
    easy = MACHINE.replace(axis=MACHINE.axis.replace(coulomb=0.3, viscous=1.0))
    time = np.arange(4001) / moving_axis.RATE

    def log(true, k):
        fast = cogging.Sampled(time, 4.0 * moving_axis.motion(10 * seed + k).sample(time)[0], None, None)
        return cogging.simulate(true, fast, seed=10 * seed + k, duration=8.0, steps_per_sample=4)

    found, (low, high), count = with_a_play(easy, gap, share, log)
    assert count == 1
    assert found.gap == pytest.approx(gap, rel=0.04)  # seen: 3.7 %
    assert found.mass_ratio == pytest.approx(share, rel=0.025)  # seen: 2.0 %
    assert low < share < high


def test_a_cable_of_any_shape_is_a_spring():
    """Its force never turns back along the travel; that of the noise of a fit may by a twentieth."""
    assert is_monotone(np.array([0.0, 1.0, 1.1, 1.1, 3.0, 3.0, 4.0, 4.2]))
    assert is_monotone(-np.array([0.0, 1.0, 0.95, 1.1, 3.0, 3.0, 4.0, 4.2]))
    assert not is_monotone(np.array([0.0, 1.0, 2.0, 1.0, 3.0, 3.0, 4.0, 3.0]))
    places, levels = [-0.2, -0.1, -0.05, 0.05, 0.12, 0.2], [4.0, 3.6, 3.0, -1.0, -2.2, -2.6]
    force = cogging.EFFECTS["empirical_force"](position_nodes=places, position_forces=levels)
    (only,) = searched(moving_axis.machine([force]), 4, STATED).accepted
    assert only.found.name == "cable_spring"
    assert only.share > 0.9


@pytest.mark.parametrize(
    "seed", [5, 9, *(pytest.param(seed, marks=pytest.mark.study) for seed in (0, 1, 2, 6, 7, 8, 10, 11))]
)
def test_a_small_spring_of_a_drawn_shape_is_one_effect(seed):
    """The ends of the travel and local forces explain much of it, too; seeds 3 and 4 have a second name."""
    random = np.random.default_rng(seed)
    levels = np.concatenate([[0.0], np.cumsum(random.uniform(0.1, 1.0, 5))])
    size = np.exp(random.uniform(*np.log([0.1, 1.0]))) * random.choice([-1.0, 1.0])
    forces = size * (levels / levels[-1] - random.uniform())
    places = np.linspace(-0.16, 0.16, 6).tolist()
    force = cogging.EFFECTS["empirical_force"](position_nodes=places, position_forces=forces.tolist())
    accepted = searched(moving_axis.machine([force]), seed, STATED).accepted
    assert [one.found.name for one in accepted] == ["cable_spring"]


@pytest.mark.parametrize(
    ("bell", "name", "fields", "speeds"),
    [
        ((-6.0, -0.0097, 0.0229), "disturbance_step", {"force": 6.0, "start": 2.606, "stop": 5.806}, (0.32, 0.14)),
        ((-10.0, 0.0769, 0.0156), "viscous_asymmetry", {"difference": 23.3}, (0.19, 0.14)),
    ],
)
def test_a_wide_local_force_beside_another_effect_leaves_no_third(bell, name, fields, speeds):
    """Its law is found at its width; the pulse of a window would leave a wave that is not there."""
    law = cogging.EFFECTS["local_force"](**dict(zip(("force", "center", "width"), bell, strict=True)))
    true = moving_axis.machine([law, cogging.EFFECTS[name](**fields)])
    logs = [moving_axis.record(true, k, moving_axis.strokes(speed, 0.24)) for k, speed in enumerate(speeds, 1)]
    found = cogging.diagnose(logs[0], STATED, confirm=logs[1])
    assert {e.name for e in found.effects} == {"local_force", name}
    values = next(e for e in found.effects if e.name == "local_force").parameters
    assert values["width"].value == pytest.approx(law.width, rel=2e-3)  # seen: 4e-4
    assert values["center"].value == pytest.approx(law.center, abs=1e-5)  # seen: 3e-6


def test_no_candidate_has_amplitudes_that_its_law_excludes():
    """A refined shape may have another sign than that which it was refined from: here a load of negative mass."""
    mode = cogging.EFFECTS["flexible_mode"](frequency=17.1, damping_ratio=0.018, mass_ratio=0.15)
    log = moving_axis.record(moving_axis.machine([mode]), 1371, moving_axis.strokes(0.292, 0.24))
    evidence = Evidence([DifferencedBalance(log, 3e-3, 1e-7)], STATED, STATED).prepare(2, listen=True)
    found = search_once(evidence, {})
    assert any(f.accept for f in found)
    assert all(f.accepts(f.amplitudes) for f in found)


def test_the_mass_stays_within_a_tenth_and_ten_times_the_stated_one():
    """Beside a wrong law it would fall to zero: with that, and no friction, a wide dead zone explains any motion."""
    log = moving_axis.record(moving_axis.machine(), 1)
    evidence = Evidence([DifferencedBalance(log, 3e-3, 1e-7)], STATED, STATED).prepare(1)
    stated = STATED.axis.mass
    for step, bound in ((-stated, 0.1 * stated), (20.0 * stated, 10.0 * stated)):
        model = evidence.moved(evidence.moved(STATED, {"axis.mass": step}), {"axis.mass": step})
        assert model.axis.mass == pytest.approx(bound)


@pytest.mark.parametrize(("factor", "refused"), [(0.1, True), (0.11, False), (9.0, False), (10.0, True)])
def test_a_change_of_the_mass_to_the_bound_of_the_search_is_refused(factor, refused):
    """It is where the search ended, not what the logs show."""
    term = Term(SimpleNamespace(found=SimpleNamespace(name="mass_change")), None, "axis.mass", 1.0)
    whole = STATED.replace(axis=STATED.axis.replace(mass=factor * STATED.axis.mass))
    reasons = _objections([term], whole, SimpleNamespace(given=[]), STATED)[1]
    assert list(reasons.values()) == [f"the mass would be {factor:.3g} of its stated value"] * refused


@pytest.mark.parametrize("seed", [1, 2])
def test_a_dead_zone_is_no_name_for_all_that_the_command_balances(seed):
    """The motion needs most of its force at commands within such a zone, where no force acts."""
    wave = cogging.EFFECTS["cogging_harmonic"](period=0.055, sine=4.0, cosine=2.0)
    hidden = [cogging.EFFECTS["viscous_asymmetry"](difference=40.0), wave]
    accepted = searched(moving_axis.machine(hidden), seed, STATED).accepted
    assert sorted(one.found.name for one in accepted) == ["cogging_harmonic", "viscous_asymmetry"]


@pytest.mark.parametrize("seed", [1, 3, 4])
def test_a_payload_beside_a_spring_of_larger_force_is_a_change_of_mass(seed):
    """Its score is limited by how well the mass is stated, that of the spring is not."""
    true = moving_axis.machine([cogging.EFFECTS["cable_spring"](stiffness=100.0, center=0.02)])
    outcome = searched(true.replace(axis=true.axis.replace(mass=5.0)), seed, STATED)
    assert sorted(one.found.name for one in outcome.accepted) == ["cable_spring", "mass_change"]
    assert outcome.evidence.model.axis.mass == pytest.approx(5.0, rel=1e-3)  # seen: 6.4e-4


def test_a_motion_so_fast_that_every_wave_would_alias_is_searched_for_none():
    log = moving_axis.record(MACHINE, 1)
    evidence = Evidence([DifferencedBalance(log, MACHINE.axis.coulomb_width)], MACHINE, MACHINE).prepare(2, listen=True)
    search_of = Search(evidence)
    assert wave_scan(search_of, [np.ones(len(evidence.balances[0].time))])[0]
    search_of.top = 1e3 * search_of.length / evidence.balances[0].step
    assert wave_scan(search_of, [np.ones(len(evidence.balances[0].time))]) == ([], 1)


def limited(limit, largest):
    """What is found where the command is limited, and its largest value is as given."""
    true = moving_axis.machine([cogging.EFFECTS["command_saturation"](limit=limit)])
    logs = [moving_axis.record(true, seed) for seed in (41, 42)]
    assert np.abs(logs[0].command).max() == pytest.approx(largest, rel=2e-3)
    return cogging.diagnose(logs[0], STATED.replace(controller=None, controller_type=None), confirm=logs[1])


def test_a_limit_is_named_far_below_the_largest_command():
    (only,) = limited(3.6, 22.5).effects
    assert only.name == "command_saturation"
    limit = only.parameters["limit"]
    assert limit.value == pytest.approx(3.6, rel=2e-3)  # seen: 0.1 %
    assert limit.ci95[0] < 3.6 < limit.ci95[1]


def test_beside_a_controller_that_has_wound_up_no_limit_is_named():
    """Where the command is a hundred times the limit, any limit and any dead zone explain most of it alike."""
    found = limited(3.4, 447.0)
    assert (found.verdict, found.effects) == ("unlisted", ())


@pytest.mark.parametrize(
    ("name", "fields"),
    [
        ("command_dead_zone", {"width": 8.0}),
        ("disturbance_tone", {"frequency": 3.0, "sine": 6.0}),
        ("force_constant_drift", {"change": -0.8, "time_constant": 3.0}),
    ],
)
def test_rows_hold_no_negative_information_where_an_effect_makes_most_of_the_command(name, fields):
    """Few of them are independent, so the priors weigh much more than the rows."""
    stated = moving_axis.machine()
    log = moving_axis.record(moving_axis.machine([cogging.EFFECTS[name](**fields)]), 1)
    evidence = Evidence([DifferencedBalance(log, stated.axis.coulomb_width)], stated, stated).prepare(2, listen=True)
    assert evidence.largely
    scale = np.sqrt(np.diag(evidence.information))
    assert np.linalg.eigvalsh(evidence.information_of_rows / np.outer(scale, scale)).min() > -1e-9


@pytest.mark.parametrize("seed", range(2))
def test_a_payload_is_a_change_of_mass_though_the_model_was_re_tuned_to_it(seed):
    """Its force is that of the difference from the stated mass, beside larger effects."""
    laws = {"constant_force": {"force": 6.0}, "viscous_asymmetry": {"difference": 10.0}}
    true = moving_axis.machine([cogging.EFFECTS[name](**fields) for name, fields in laws.items()])
    true = true.replace(axis=true.axis.replace(mass=3.2))
    outcome = searched(true, seed, MACHINE)
    assert {one.found.name for one in outcome.accepted} == {*laws, "mass_change"}
    assert outcome.evidence.model.axis.mass == pytest.approx(3.2, rel=2e-3)


@pytest.mark.parametrize("seed", range(3))
def test_a_payload_on_a_mass_that_was_stated_exactly_is_a_change_of_mass(seed):
    stated = MACHINE.replace(uncertainty={**MACHINE.uncertainty, "mass": 0.0})
    outcome = searched(MACHINE.replace(axis=MACHINE.axis.replace(mass=3.2)), seed, stated)
    assert [one.found.name for one in outcome.accepted] == ["mass_change"]
    assert outcome.evidence.model.axis.mass == pytest.approx(3.2, rel=2e-3)


def test_what_is_stated_exactly_stays_and_a_friction_that_is_absent_stays_absent():
    stated = pid_axis.MODEL.replace(uncertainty=dict.fromkeys(("mass", "viscous", "coulomb", "coulomb_width"), 0.0))
    b = balance(model=pid_axis.MODEL)
    assert Evidence([b], stated, stated).prepare(2, listen=True).model.axis == stated.axis
    bare = stated.replace(axis=stated.axis.replace(coulomb=0.0))
    evidence = Evidence([b], bare, bare).prepare(1)
    assert evidence.model.axis == bare.axis
    assert "axis.coulomb" not in evidence.paths
