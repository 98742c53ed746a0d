"""The blind test bed: independent of the core, right in its physics, honest in its ratios and its scores."""

import json
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import lti, step
from scipy.stats import norm

import cogging
from tests.blind import benchmark, shapes, truth
from tests.blind.cases import LAMBDAS, TOLERANCE, Specification, draw_case, with_hidden
from tests.blind.identifiable import Signal
from tests.blind.large import NAMES, SHARES, draw_large, in_units, power_ratio
from tests.blind.machines import NULL_FAMILIES, draw_machine
from tests.blind.motions import move, play, rest
from tests.blind.outside import OUTSIDE
from tests.blind.score import format_table, judge, table
from tests.blind.suite import draw_suite, plan_suite, write_case, write_log
from tests.blind.truth import Plan
from tests.blind.vocabulary import CHANGES, DRAWN, VOCABULARY

LOOP = {"rate": 1000.0, "mass": 0.8, "viscous": 0.4, "coulomb": 0.3, "width": 2e-3, "kp": 9e3, "kd": 90.0, "ki": 5e4}
FREE = {"kp": 0.0, "ki": 0.0, "kd": 0.0}


def plan_of(count=300, substeps=10, **scalars):
    time = np.arange(count) / LOOP["rate"]
    plan = Plan.empty(time, (0.0, 0.2), substeps)
    motion = play(0.05, [rest(0.02), move(0.03, 0.4, 8.0), move(-0.02, 0.3, 8.0)], time)
    plan.follow(motion)
    if "kp" not in scalars:
        plan.maps[truth.M_FORCE] += -0.2 * np.sin(2 * np.pi * plan.positions / 0.011)
    plan.set(**{"law": truth.TANH, "x_start": motion.position[0], **LOOP, **scalars})
    return plan


# independence


def test_the_truth_imports_nothing_of_the_core():
    knowing = {"benchmark.py", Path(__file__).name, "test_diagnose.py"}
    for path in Path(__file__).parent.glob("*.py"):
        assert path.name in knowing or not re.search(r"(from|import) (cogging|tests)", path.read_text()), path


def test_every_effect_of_the_vocabulary_is_in_the_bed():
    known = {*VOCABULARY, *CHANGES, *NAMES}
    assert set(cogging._core.EFFECTS) - known == {"empirical_force"}  # it names no cause: nothing looks for it
    assert known - set(cogging._core.EFFECTS) == set(CHANGES)
    assert not set(OUTSIDE) & known


# physics


def exact_loop(plan):
    """The same loop between the samples by scipy, without encoder rounding."""
    p, rows, t = plan, plan.rows, plan.instants
    x, v, total, before = p["x_start"], 0.0, 0.0, 0.0
    positions = []

    def slope(_, state, u):
        force = u - p["viscous"] * state[1] - p["coulomb"] * np.tanh(state[1] / p["width"])
        return [state[1], (force - 0.2 * np.sin(2 * np.pi * state[0] / 0.011)) / p["mass"]]

    for k in range(len(t)):
        positions.append(x)
        error = x - rows[k, 0]
        before = error if k == 0 else before
        total += error / p["rate"]
        u = -p["kp"] * error - p["ki"] * total - p["kd"] * (error - before) * p["rate"]
        before = error
        if k < len(t) - 1:
            end = solve_ivp(slope, (t[k], t[k + 1]), [x, v], args=(u,), rtol=1e-10, atol=1e-13)
            x, v = end.y[0, -1], end.y[1, -1]
    return np.array(positions)


def test_the_integrator_is_of_second_order_and_agrees_with_scipy():
    expected = exact_loop(plan_of(150))
    errors = [np.abs(plan_of(150, substeps=n).run().position - expected).max() for n in (5, 10, 20)]
    assert errors[1] < 2e-7
    assert min(errors[0] / errors[1], errors[1] / errors[2]) > 3.0


def test_an_axis_that_sticks_rests_exactly_until_the_force_exceeds_the_friction():
    plan = plan_of(**FREE, law=truth.STICK)
    plan.rows[:, truth.R_FORCE] = np.linspace(0.0, 0.6, 300)
    run = plan.run()
    moving = np.flatnonzero(run.velocity > 0.0)
    assert np.ptp(run.position[: moving[0]]) == 0.0
    assert plan.rows[moving[0] - 1, truth.R_FORCE] == pytest.approx(0.3, abs=0.003)
    plan.rows[150:, truth.R_FORCE] = 0.0
    assert plan.run().velocity[-1] == 0.0, "and stops in finite time"


def test_two_masses_ring_at_the_stated_frequency():
    plan = plan_of(1000, 20, **FREE, viscous=0.0, coulomb=0.0, coupling=truth.FLEXIBLE, load_ratio=0.3)
    plan.set(mode_frequency=30.0, mode_damping=1e-6)
    plan.rows[:5, truth.R_FORCE] = 1.0
    velocity = plan.run().velocity[10:]
    ringing = velocity - velocity.mean()
    crossings = np.flatnonzero((ringing[:-1] < 0) & (ringing[1:] >= 0))
    fraction = crossings - ringing[crossings] / (ringing[crossings + 1] - ringing[crossings])
    assert 1000 / np.diff(fraction).mean() == pytest.approx(30.0, rel=2e-3)


def force_of(**scalars):
    """Force on a free mass of one after each sample, of a command of one."""
    plan = Plan.empty(np.arange(400) / 1000.0, (-1.0, 1.0))
    plan.set(**{"rate": 1000.0, "mass": 1.0, "ff_mass": 1.0, "law": truth.TANH, **scalars})
    plan.rows[1:, truth.R_ACCELERATION] = 1.0  # the first sample rests: actuators start there
    return np.diff(plan.run().velocity)[1:] * 1000.0


def test_commands_come_late_lag_and_are_cut():
    np.testing.assert_allclose(force_of(delay=1e-3)[1:], force_of()[:-1], atol=1e-12)
    found = force_of(lag=0.008, lag_damping=0.45)
    expected = step(lti([1.0], [0.008**2, 2 * 0.45 * 0.008, 1.0]), T=np.arange(797) / 2000.0)[1][1::2]
    np.testing.assert_allclose(found, expected, atol=4e-3)  # in the middle of each sample
    one_sided, rounded = (float(truth.DEAD_ZONES.index(name)) for name in ("one_sided", "rounded"))
    for scalars, force in (
        ({"saturation_soft": 0.8, "saturation_knee": 3.0}, (1 + 0.8**-3) ** (-1 / 3)),
        ({"saturation_down": 0.5}, 1.0),
        ({"saturation_up": 0.5}, 0.5),
        ({"dead_zone": 0.2, "dead_zone_shape": one_sided}, 0.8),
        ({"dead_zone": 0.2, "dead_zone_shape": one_sided, "ff_mass": -1.0}, -1.0),
        ({"dead_zone": 0.8, "dead_zone_shape": rounded}, 1 - 0.8 * np.tanh(1.25)),
    ):
        assert force_of(**scalars)[-1] == pytest.approx(force)


def test_without_noise_and_effects_the_core_draws_the_same_log():
    """Only conventions are compared: signs, units, friction law, controller; both integrate on their own."""
    drawn = (draw_machine(np.random.default_rng(seed), law="arctangent") for seed in range(100))
    machine = next(m for m in drawn if "controller" in m.model and np.ptp(m.drift(np.linspace(*m.travel))) == 0.0)
    machine.jitter = 0.0
    time, motion = machine.draw_motion(np.random.default_rng(14))
    plan = machine.plan(np.random.default_rng(15), motion, time).silent()
    plan.set(x_start=motion.position[0])
    run, s = plan.run(), machine.scalars
    axis = {name: s[name] for name in ("mass", "viscous", "coulomb")} | {"coulomb_width": s["width"]}
    rows = {name: getattr(machine, name)[:, None].tolist() for name in ("sine", "cosine")}
    document = {"axis": axis | {"travel": list(machine.travel)}, "cogging": machine.model["cogging"] | rows}
    model = cogging.Model.from_dict(document | {"controller": machine.model["controller"]})
    reference = cogging.Sampled(time, motion.position, motion.velocity, motion.acceleration)
    log = cogging.simulate(model, reference, steps_per_sample=20, duration=float(time[-1]))
    count = min(len(log), len(time))
    assert count > 0.9 * len(time)
    np.testing.assert_allclose(log.command[:count], run.command[:count], atol=2e-4 * machine.peak)
    np.testing.assert_allclose(log.position[:count], run.reading[:count], atol=1e-6)


# shapes and machines

S = np.linspace(0.0, 1.0, 401)
#: Where each kind of shape is looked at, and what is true of its values.
SHAPES = {
    "any_wave": (2 * np.pi * S, lambda v: np.argmax(np.abs(np.fft.rfft(v[:-1]))) == 1),
    "any_profile": (1.2 * S - 0.1, lambda v: np.isfinite(v).all()),
    "any_decay": (8.0 * S, lambda v: np.diff(v).max() <= 1e-12 and v[0] == 1.0 > 10 * v[-1]),
    "any_rise": (S, lambda v: np.diff(v).min() >= -1e-12 and v[0] == 0.0),
    "any_spring": (S, lambda v: np.diff(v).min() > 0.0),
    "any_pulse": (1.4 * S - 0.2, lambda v: not v[(1.4 * S < 0.2 - 1e-9) | (1.4 * S > 1.2 + 1e-9)].any()),
}


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_are_of_their_kind_with_a_size_of_one_and_no_two_alike(name):
    places, is_right = SHAPES[name]
    many = [np.asarray(getattr(shapes, name)(np.random.default_rng(seed))(places), dtype=float) for seed in range(60)]
    assert all(map(is_right, many))
    inside = (places >= 0.0) & (places <= places[-1] - 0.1) if name == "any_profile" else slice(None)
    assert all(0.5 < np.abs(values[inside]).max() < 1.1 for values in many)
    apart = [np.abs(one - other).max() for i, one in enumerate(many) for other in many[:i]]
    assert np.mean(np.array(apart) > 0.02) > 0.9


def test_machines_have_laws_and_noises_of_many_kinds_and_those_of_a_family_its_trait():
    machines = [draw_machine(np.random.default_rng(seed)) for seed in range(60)]
    assert {one.law for one in machines} == set(truth.LAWS)
    assert "mixture" in {one.colour for one in machines}
    rng = np.random.default_rng(3)
    assert draw_machine(rng, "sticking").law == "stick"
    assert draw_machine(rng, "jitter").jitter > 0
    assert "controller" not in draw_machine(rng, "no_controller").model
    loud = draw_machine(rng, "loud_noise")
    assert loud.model["noise"]["force"] == pytest.approx(loud.noise / 3, rel=0.06)


# cases


def test_the_stated_ratio_counts_noise_as_one_a_sample_and_what_is_re_tuned_as_nothing():
    case = draw_case([7], Specification("effect", ("quadratic_drag",), 100.0))
    signal = Signal(case.base, case.machine)
    found = signal.ratio(signal.difference(case.main))
    assert found == pytest.approx(case.key["effects"][0]["ratio"], rel=1e-9)
    assert found == pytest.approx(100.0, rel=TOLERANCE)
    noise = signal.whiten(case.base.run().command - case.base.silent().run().command)
    assert signal.ratio(noise) == pytest.approx(len(noise), rel=0.02)
    assert np.abs(noise[1:] @ noise[:-1]) < 0.02 * len(noise), "white"
    for name, factor in (("mass", 0.99), ("viscous", 1.03), ("coulomb", 0.97)):
        plan = case.base.copy()
        plan.set(**{name: factor * plan[name]})
        assert signal.difference(plan) @ signal.difference(plan) > 100.0 * signal.ratio(signal.difference(plan))
    twice = with_hidden(case.base, [(effect, 2.0 * amplitude) for effect, amplitude in case.hidden])
    assert signal.ratio(signal.difference(twice)) == pytest.approx(4.0 * found, rel=0.05)


def test_an_effect_bears_the_name_of_its_cause_whatever_the_shape():
    machine = draw_machine(np.random.default_rng(1))
    _, motion = machine.draw_motion(np.random.default_rng(2))
    for name, draw in {**VOCABULARY, **OUTSIDE}.items():
        drawn = [draw(np.random.default_rng(seed), machine, motion) for seed in range(12)]
        assert {one.name for one in drawn} == {name}
        assert all(0.0 < one.low <= one.start <= one.high for one in drawn), name
    drawn = [VOCABULARY["end_effect"](np.random.default_rng(seed), machine, motion) for seed in range(12)]
    assert {one.shape for one in drawn} == {"usual", DRAWN}
    assert all(bool(one.parameters(one.start)) == (one.shape == "usual") for one in drawn)


def test_files_keep_the_contract(tmp_path):
    case = draw_case([11], Specification("null", family="jitter"))
    write_case(case, tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["confirm.csv", "log.csv", "model.toml"]
    model = cogging.Model.read(tmp_path / "model.toml")
    assert model.axis.mass == pytest.approx(case.machine.scalars["mass"], rel=0.15)
    x = np.linspace(*case.machine.travel, 500)[1:-1]
    waves = [case.machine.cogging(x, i, cosine=c) for i in range(len(case.machine.periods)) for c in (False, True)]
    stated = model.cogging.force(x)
    left = stated - np.transpose(waves) @ np.linalg.lstsq(np.transpose(waves), stated, rcond=None)[0]
    assert left.std() < 3e-3 * stated.std(), "amplitudes and phases are wrong, the drift along the travel is not"
    for name in ("log", "confirm"):
        log = cogging.read_log(tmp_path / f"{name}.csv")
        assert 8.0 * case.machine.rate - 1 <= len(log) <= 15.0 * case.machine.rate
        counts = log.position / model.encoder.resolution
        np.testing.assert_allclose(counts, np.rint(counts), atol=1e-4)
        names = ("time", "position", "reference", "reference_velocity", "reference_acceleration")
        columns = {name: getattr(log, name)[:500] for name in names}
        command = cogging.replay_controller(model.make_controller(), **columns)
        np.testing.assert_allclose(command, log.command[:500], atol=1e-6 * case.machine.peak)


def test_a_suite_is_the_same_again_and_its_names_tell_nothing(tmp_path):
    specifications = plan_suite(5, 1, kinds=["effect"], effects=["disturbance_tone"], ratios=[300.0])
    keys = [draw_suite(5, tmp_path / name / "cases", tmp_path / name / "key", specifications) for name in "ab"]
    assert json.dumps(keys[0]) == json.dumps(keys[1])
    for path in (tmp_path / "a" / "cases").rglob("*.*"):
        text = path.read_bytes()
        assert text == (tmp_path / "b" / path.relative_to(tmp_path / "a")).read_bytes()
        assert path.stem in ("log", "confirm", "model")
        assert not any(effect.encode() in text for effect in (*VOCABULARY, *OUTSIDE))


def test_a_plan_covers_families_effects_and_ratios_evenly():
    specifications = plan_suite(1, 400)
    assert len(specifications) == 400
    nulls = [one.family for one in specifications if one.kind == "null"]
    assert {nulls.count(f) for f in NULL_FAMILIES} <= {len(nulls) // len(NULL_FAMILIES) + i for i in (0, 1)}
    effects = [one for one in specifications if one.kind == "effect"]
    assert {one.names[0] for one in effects} == {*VOCABULARY, *CHANGES}
    assert {one.ratio for one in effects} == set(LAMBDAS)
    assert not any(one.ratio < 25 for one in effects if one.names[0] in CHANGES)
    assert any(one.kind == "triple" and len(set(one.names)) == 3 for one in specifications)


# in the large


def test_effects_in_the_large_make_the_stated_share_and_a_misread_log_is_written_times_a_factor(tmp_path):
    large = draw_large([1, 0, 0], Specification("large", ("cogging_harmonic",)))
    sizes = {effect["name"]: effect["size"] for effect in large.key["effects"]}
    assert SHARES[0] <= large.key["share"] <= SHARES[1]
    assert power_ratio(large.main, large.base) == pytest.approx(large.key["share"], rel=1e-9)
    assert min(sizes.values()) >= 0.15 * max(sizes.values())
    assert max(sizes, key=sizes.get) in large.key["largest"]
    assert power_ratio(large.base, large.base) < 1e-3, "without them nothing is missing"
    json.dumps(large.key, allow_nan=False)
    write_case(large, tmp_path)
    assert (cogging.Model.read(tmp_path / "model.toml").controller is not None) == large.key["stated_controller"]
    factors = {"command": -3.0, "time": 1e3}
    for name, given in (("right", {}), ("misread", factors)):
        write_log(tmp_path / name, large.machine, large.main, large.main_run, given)
    right, misread = (np.genfromtxt(tmp_path / name, delimiter=",", names=True) for name in ("right", "misread"))
    np.testing.assert_allclose(right["command"], large.main_run.command, rtol=1e-9)
    for name in right.dtype.names:
        np.testing.assert_allclose(misread[name], factors.get(name, 1.0) * right[name], rtol=1e-9)


def test_a_log_in_other_units_is_that_of_the_model_in_these_units():
    """The core simulates the model as drawn and in other units: the same log times the units."""
    machine = draw_machine(np.random.default_rng(1), law="arctangent")
    model = {**machine.model, "axis": {k: v for k, v in machine.model["axis"].items() if k != "uncertainty"}}
    units = u, x, t = 0.02, 7.0, 3.0
    time, motion = machine.draw_motion(np.random.default_rng(2))
    logs = []
    for document, (x_, t_) in ((model, (1.0, 1.0)), (in_units(model, units, turns=True), (x, t))):
        document = {key: value for key, value in document.items() if key != "noise"}
        rows = (x_ * motion.position, x_ / t_ * motion.velocity, x_ / t_**2 * motion.acceleration)
        reference = cogging.Sampled(t_ * time, *rows)
        logs.append(cogging.simulate(cogging.Model.from_dict(document), reference, duration=0.5 * t_))
    np.testing.assert_allclose(u * logs[0].command, logs[1].command, atol=1e-6 * u * machine.peak)
    np.testing.assert_allclose(x * logs[0].position, logs[1].position, rtol=1e-9)


# scores


def key_of(kind, *names, ratio=100.0, outside=False, tolerated=(), parameters=None, family="plain"):
    common = {"ratio": ratio, "in_vocabulary": not outside, "tolerated": list(tolerated), "shape": "usual"}
    effects = [{"name": name, **common, "parameters": parameters or {}} for name in names]
    confirm = {"confirm_floor": 1.0, "confirm_rest": 0.6, "confirm_effect": 0.6, "confirm_closable": 0.36}
    return {"kind": kind, "family": family, "ratio": ratio, "effects": effects, "stated_controller": True, **confirm}


def answer(verdict, *entries, gap=None, parameters=None):
    effects = [
        {"name": name, "confidence": confidence, "alternatives": list(others), "parameters": parameters or {}}
        for name, confidence, *others in entries
    ]
    return {"verdict": verdict, "effects": effects, "gap": gap or {}}


def test_answers_in_the_large_are_judged():
    key = key_of("large", "gravity", "backlash") | {"largest": ["gravity"], "misreading": None}
    misread = key | {"misreading": {"kind": "sign", "columns": ["command"], "factor": -1.0}}
    grows = {"given": 1.0, "before": 1.2, "after": 1.0}
    right = judge(key, answer("named", ("gravity", 0.95), ("backlash", 0.95), gap=grows))
    assert (right.largest, right.found, right.said, right.grows) == (True, 2, None, True)
    second = judge(key, answer("named", ("backlash", 0.95), ("drag", 0.95), gap={"before": 1.0, "after": 1.005}))
    assert (second.largest, second.found, second.wrong, second.grows) == (False, 1, ("drag",), False)
    for result, said in (
        (answer("data_mismatch") | {"mismatch": {"kind": "sign", "column": "position"}}, "kind"),
        (answer("data_mismatch") | {"mismatch": {"kind": "scale", "column": "time"}}, "verdict"),
        (answer("unlisted"), ""),
        ({"error": "InputError: command: give --scale; its sign is reversed"}, "kind"),
        ({"error": "ZeroDivisionError: float division by zero"}, ""),
    ):
        assert judge(misread, result).said == said
    lines = [line.split() for line in format_table(table([right, second])).splitlines()]
    (first,) = (line for line in lines if line[:3] == ["right", "first", "name,"])
    assert first[6:9] == ["50.0", "%", "(1/2;"]


def test_hand_made_results_get_their_hand_computed_rates():
    spring, step, drag = "cable_spring", "disturbance_step", "quadratic_drag"
    stiffness = {"stiffness": {"value": 2.0, "unit": "V/m", "deviation": 0.1}}
    found = {"stiffness": {"value": 2.15, "unit": "V/m", "ci95": [1.9, 2.4]}}
    gap = {"floor": 1.0, "confirm_before": np.sqrt(1.36), "confirm_after": 1.0}
    worse = {"confirm_before": 1.0, "confirm_after": 1.02}
    known = key_of("effect", spring, ratio=300.0, parameters=stiffness)
    soft = key_of("outside", "soft_saturation", outside=True, tolerated=["command_saturation"])
    slip, pair = key_of("outside", "encoder_slip", outside=True), key_of("pair", spring, step, ratio=300.0)
    answers = [
        (key_of("null"), answer("no_gap")),
        (key_of("null"), answer("insufficient_excitation")),
        (key_of("null", family="jitter"), answer("named", (step, 0.95), gap=worse)),
        (key_of("null", family="jitter"), {"error": "ValueError: no"}),
        (known, answer("named", (spring, 0.95), gap=gap, parameters=found)),
        (key_of("effect", spring), answer("ambiguous", ("end_effect", 0.6, spring))),
        (key_of("effect", spring), answer("named", (drag, 0.92))),
        (key_of("effect", spring), answer("no_gap")),
        (soft, answer("named", ("command_saturation", 0.95))),
        (slip, answer("unlisted")),
        (slip, answer("unlisted", (drag, 0.97))),
        (pair, answer("named", (step, 0.95), (spring, 0.91))),
        (pair, answer("named", (step, 0.95))),
    ]
    figures = table([judge(*one) for one in answers])
    rates = {
        ("errors",): (1, 13),
        ("false_alarm",): (2, 4),
        ("false_alarm_by_family", "jitter"): (2, 2),
        ("false_alarm_by_family", "plain"): (0, 2),
        ("detected", "100"): (2, 3),
        ("named", "100"): (1, 3),
        ("named", "300"): (1, 1),
        ("exact", "100"): (0, 3),
        ("confident_wrong", "100"): (1, 3),
        ("confident_wrong_all",): (1, 4),
        ("outside_unlisted", "100"): (2, 3),
        ("outside_confident_wrong_all",): (1, 3),
        ("pairs_right",): (1, 2),
        ("made_worse",): (1, 2),
        ("coverage",): (1, 1),
        # 0.95: null's step, spring, saturation, both pairs' steps; 0.92 drag; 0.91 spring
        ("calibration", "0.9 to 0.97", "right"): (5, 7),
    }
    for path, expected in rates.items():
        rate = figures
        for name in path:
            rate = rate[name]
        assert (rate.hits, rate.count) == expected, path
    values = {"mean_names": 1.5, "mean_names_apart": 1.0, "gap_closed_median": 1.0}
    assert {name: figures[name] for name in values} == pytest.approx(values)
    assert figures["error_to_bound_robust"] == pytest.approx(1.5 / norm.ppf(0.75), rel=1e-4)
    confused = figures["confusion"]
    assert confused["cable_spring"] == {"cable_spring": 1, "end_effect?": 1, "quadratic_drag": 1, "no_gap": 1}
    nulls = {"no_gap": 1, "insufficient_excitation": 1, "disturbance_step": 1, "error": 1}
    assert confused["nothing"] == nulls
    json.dumps(benchmark.plain(figures), allow_nan=False)


# the command


def test_the_command_draws_runs_scores_and_prints(tmp_path, capsys, monkeypatch):
    result = SimpleNamespace(to_dict=lambda: answer("named", ("constant_force", 0.95)))
    monkeypatch.setattr(cogging, "diagnose", lambda *files, **options: result)
    arguments = ["--seed", "9", "--cases", "1", "--jobs", "1", "--out", str(tmp_path)]
    assert benchmark.main([*arguments, "--kinds", "null"]) == 0
    first = capsys.readouterr().out
    assert "false alarm" in first
    assert json.loads((tmp_path / "table_diagnose.json").read_text())["cases"] == 1
    assert benchmark.main([*arguments, "--rescore"]) == 0
    assert capsys.readouterr().out == first


def test_a_report_refuses_the_seeds_of_the_tuning(capsys):
    with pytest.raises(SystemExit) as end:
        benchmark.parse(["--seed", str(benchmark.tuning_seeds()[0]), "--out", "x", "--report"])
    assert end.value.code == 2
    assert "tuning" in capsys.readouterr().err
