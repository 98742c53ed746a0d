"""The blind test bed: independent of the core, right in its physics, honest in its ratios and its scores."""

import ast
import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import lfilter
from scipy.stats import binomtest

import cogging
from tests.blind import benchmark, truth
from tests.blind.cases import LAMBDAS, TOLERANCE, Specification, draw_case
from tests.blind.large import NAMES, SHARES, draw_large, in_units, power_ratio
from tests.blind.machines import NULL_FAMILIES, draw_machine
from tests.blind.motions import move, play, rest, sine
from tests.blind.outside import OUTSIDE
from tests.blind.report import format_table
from tests.blind.score import Rate, judge, table
from tests.blind.suite import draw_suite, plan_suite, write_case, write_log
from tests.blind.truth import Plan
from tests.blind.vocabulary import CHANGES, VOCABULARY

ROOT = Path(__file__).resolve().parents[2]
#: What makes the truth; runners.py may know the package, it only runs it.
TRUTH = (
    "truth",
    "motions",
    "noises",
    "shapes",
    "machines",
    "hidden",
    "vocabulary",
    "outside",
    "identifiable",
    "cases",
    "large",
)
LOOP = {"rate": 1000.0, "mass": 0.8, "viscous": 0.4, "coulomb": 0.3, "width": 2e-3, "kp": 9e3, "kd": 90.0, "ki": 5e4}


def plan_of(count=300, substeps=10, **scalars):
    time = np.arange(count) / LOOP["rate"]
    plan = Plan.empty(time, (0.0, 0.2), substeps)
    motion = play(0.05, [rest(0.02), move(0.03, 0.4, 8.0), move(-0.02, 0.3, 8.0)], time)
    plan.rows[:, 0], plan.rows[:, 1], plan.rows[:, 2] = motion.position, motion.velocity, motion.acceleration
    plan.maps[truth.M_FORCE] += -0.2 * np.sin(2 * np.pi * plan.positions / 0.011)
    plan["law"], plan["x_start"] = truth.TANH, motion.position[0]
    for name, value in {**LOOP, **scalars}.items():
        plan[name] = value
    return plan


# independence


@pytest.mark.parametrize("name", [*TRUTH, "suite", "score", "report"])
def test_the_truth_imports_nothing_of_the_core(name):
    tree = ast.parse((ROOT / "tests" / "blind" / f"{name}.py").read_text())
    modules = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            modules |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            modules.add("." if node.level else node.module.split(".")[0])
    standard = {"__future__", "collections", "concurrent", "dataclasses", "itertools", "json", "math", "pathlib", "sys"}
    others = {"numba", "numpy", "scipy", "tomli", "tomllib", "tomli_w", "typing"}
    assert modules <= {".", *standard, *others}


def test_drawing_a_suite_never_loads_the_package():
    code = "import sys; import tests.blind.suite; sys.exit('cogging' in {m.split('.')[0] for m in sys.modules})"
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=False).returncode == 0


def test_every_effect_of_the_vocabulary_is_in_the_bed():
    known = {*VOCABULARY, *CHANGES, *NAMES}
    assert len(known) == 28
    assert set(cogging._core.EFFECTS) - known == {"empirical_force"}  # it names no cause: nothing looks for it
    assert len(OUTSIDE) >= 12
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
    expected = exact_loop(plan_of())
    errors = [np.abs(plan_of(substeps=n).run().position - expected).max() for n in (5, 10, 20)]
    assert errors[1] < 2e-7
    assert errors[0] / errors[1] > 3.0
    assert errors[1] / errors[2] > 3.0


def test_an_axis_that_sticks_rests_exactly_until_the_force_exceeds_the_friction():
    plan = plan_of(kp=0.0, ki=0.0, kd=0.0)
    plan["law"] = truth.STICK
    plan.maps[:] = 0.0
    plan.rows[:, truth.R_FORCE] = np.linspace(0.0, 0.6, 300)
    run = plan.run()
    moving = np.flatnonzero(run.velocity > 0.0)
    assert np.ptp(run.position[: moving[0]]) == 0.0
    assert plan.rows[moving[0] - 1, truth.R_FORCE] == pytest.approx(0.3, abs=0.003)
    end = plan.copy()
    end.rows[150:, truth.R_FORCE] = 0.0
    assert end.run().velocity[-1] == 0.0, "and stops in finite time"


def test_two_masses_ring_at_the_stated_frequency():
    plan = plan_of(1000, 20, kp=0.0, ki=0.0, kd=0.0, viscous=0.0, coulomb=0.0, coupling=truth.FLEXIBLE, load_ratio=0.3)
    plan.maps[:] = 0.0
    plan["mode_frequency"], plan["mode_damping"] = 30.0, 1e-6
    plan.rows[:5, truth.R_FORCE] = 1.0
    velocity = plan.run().velocity[10:]
    ringing = velocity - velocity.mean()
    crossings = np.flatnonzero((ringing[:-1] < 0) & (ringing[1:] >= 0))
    fraction = crossings - ringing[crossings] / (ringing[crossings + 1] - ringing[crossings])
    assert 1000 / np.diff(fraction).mean() == pytest.approx(30.0, rel=2e-3)


def test_a_delay_of_one_sample_is_a_command_one_sample_late():
    late = plan_of(kp=0.0, ki=0.0, kd=0.0, ff_mass=0.8, delay=1e-3).run()
    shifted = plan_of(kp=0.0, ki=0.0, kd=0.0, ff_mass=0.8)
    shifted.rows[1:, 2] = shifted.rows[:-1, 2].copy()
    np.testing.assert_allclose(late.position, shifted.run().position, atol=1e-12)


@pytest.mark.parametrize("segment", [move(0.05, 0.3, 4.0), move(-0.001, 0.3, 4.0), sine(0.004, 5.0, 6)])
def test_references_are_their_own_derivatives(segment):
    time = np.arange(0.0, segment[0] + 0.1, 1e-5)
    motion = play(0.1, [rest(0.05), segment], time)
    assert np.abs(np.gradient(motion.position, time) - motion.velocity).max() < 1e-4
    assert np.abs(np.gradient(motion.velocity, time) - motion.acceleration)[2:-2].max() < 0.05
    assert motion.position[-1] == pytest.approx(0.1 + segment[2])


def test_without_noise_and_effects_the_core_draws_the_same_log():
    """Only conventions are compared: signs, units, friction law, controller; both integrate on their own."""
    machine = draw_machine(np.random.default_rng(13), law="arctangent")
    machine.stated_controller, machine.jitter = True, 0.0
    time, motion = machine.draw_motion(np.random.default_rng(14))
    plan = machine.plan(np.random.default_rng(15), motion, time).silent()
    plan["x_start"], plan["limit"] = motion.position[0], 0.0
    run = plan.run()
    s = machine.scalars
    axis = {name: s[name] for name in ("mass", "viscous", "coulomb")} | {"coulomb_width": s["width"]}
    control = {"type": "pid", "sample_rate": s["rate"], "mass": s["ff_mass"], "viscous": s["ff_viscous"]}
    control |= (
        {"kp": s["kp"], "ki": s["ki"], "kd": s["kd"]}
        if "kd" in s
        else {"type": "cascade", "kp": s["kp"], "kv": s["kv"]}
    )
    control |= {"coulomb": s["ff_coulomb"], "coulomb_width": s["ff_width"]}
    rows = [amplitude[:, None].tolist() for amplitude in (machine.sine, machine.cosine)]
    machine_cogging = {"pitch": machine.pitch, "harmonics": machine.harmonics, "sine": rows[0], "cosine": rows[1]}
    assert np.ptp(machine.drift(time)) == 0.0, "this seed's cogging does not drift"
    document = {"axis": {**axis, "travel": list(machine.travel)}, "cogging": machine_cogging, "controller": control}
    reference = cogging.Sampled(time, motion.position, motion.velocity, motion.acceleration)
    log = cogging.simulate(cogging.Model.from_dict(document), reference, steps_per_sample=20, duration=float(time[-1]))
    count = min(len(log), len(time))
    assert count > 0.9 * len(time)
    np.testing.assert_allclose(log.command[:count], run.command[:count], atol=2e-4 * machine.peak)
    np.testing.assert_allclose(log.position[:count], run.reading[:count], atol=1e-6)


# cases


def test_the_stated_ratio_is_hit_when_computed_again():
    case = draw_case([7], Specification("effect", ("quadratic_drag",), 100.0))
    assert abs(case.key["effects"][0]["ratio"] / 100.0 - 1) < TOLERANCE
    noise = (case.base.run().command - case.base.silent().run().command)[400:]
    order = 40  # by least squares instead of Yule and Walker; as many as a resonance at 4 kHz needs
    lagged = np.column_stack([noise[order - i - 1 : -i - 1] for i in range(order)])
    taps = np.concatenate([[1.0], -np.linalg.lstsq(lagged, noise[order:], rcond=None)[0]])
    sigma = lfilter(taps, 1.0, noise)[order:].std()
    start = case.base.smooth().run().command

    def white(plan):
        return lfilter(taps, 1.0, plan.smooth().run().command - start)[int(0.06 * case.machine.rate) :] / sigma

    columns = []
    for change in [{"mass": 0.99}, {"viscous": 0.97}, {"coulomb": 0.97}, {"x_start": None}, {"v_start": None}]:
        plan = case.base.copy()
        for name, factor in change.items():
            plan[name] = plan[name] * factor if factor else plan[name] + 1e-5
        columns.append(white(plan))
    for factor in (0.7, 1.0, 1.6):
        plan = case.base.copy()
        plan["law"], plan["width"] = truth.ARCTANGENT, factor * case.machine.model["axis"]["coulomb_width"]
        columns.append(white(plan))
    for index, period in enumerate(case.machine.periods):
        for wave in (np.sin, np.cos):
            plan = case.base.copy()
            drift = case.machine.drift(plan.positions)
            plan.maps[0] += 0.02 * case.machine.peak * drift * wave(2 * np.pi * plan.positions / period) / (1 + index)
            columns.append(white(plan))
    matrix = np.column_stack([c / np.linalg.norm(c) for c in columns])
    effect = white(case.main)
    rest_ = effect - matrix @ np.linalg.lstsq(matrix, effect, rcond=1e-7)[0]
    assert rest_ @ rest_ == pytest.approx(100.0, rel=0.2)


@pytest.mark.parametrize("family", ["no_controller", "jitter"])
def test_files_keep_the_contract(tmp_path, family):
    case = draw_case([11], Specification("null", family=family))
    write_case(case, tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["confirm.csv", "log.csv", "model.toml"]
    model = cogging.Model.read(tmp_path / "model.toml")
    assert (model.controller is None) == (not case.key["stated_controller"])
    assert model.axis.mass == pytest.approx(case.machine.scalars["mass"], rel=0.15)
    x = np.linspace(*case.machine.travel, 500)[1:-1]
    waves = [case.machine.cogging(x, i, cosine=c) for i in range(len(case.machine.periods)) for c in (False, True)]
    stated = model.cogging.force(x)
    rest_ = stated - np.transpose(waves) @ np.linalg.lstsq(np.transpose(waves), stated, rcond=None)[0]
    assert rest_.std() < 3e-3 * stated.std(), "amplitudes and phases are wrong, the drift along the travel is not"
    for name in ("log", "confirm"):
        log = cogging.read_log(tmp_path / f"{name}.csv")
        assert 8.0 * case.machine.rate - 1 <= len(log) <= 15.0 * case.machine.rate
        counts = log.position / model.encoder.resolution
        np.testing.assert_allclose(counts, np.rint(counts), atol=1e-4)
        if model.controller is None:
            continue
        controller = model.make_controller()
        columns = (log.reference, log.reference_velocity, log.reference_acceleration, log.position)
        for k, (x_r, v_r, a_r, y) in enumerate(zip(*(c[:500] for c in columns), strict=True)):
            command = controller.command(reference=x_r, reference_velocity=v_r, reference_acceleration=a_r, reading=y)
            controller.update(command)
            assert command == pytest.approx(log.command[k], abs=1e-6 * case.machine.peak)


def test_a_suite_is_the_same_again_and_its_names_tell_nothing(tmp_path):
    specifications = plan_suite(5, 2, kinds=["null", "effect"], effects=["constant_force", "disturbance_tone"])
    keys = [draw_suite(5, tmp_path / name / "cases", tmp_path / name / "key", specifications) for name in "ab"]
    assert json.dumps(keys[0]) == json.dumps(keys[1])
    for name in keys[0]["cases"]:
        for file in ("log.csv", "confirm.csv", "model.toml"):
            texts = [(tmp_path / side / "cases" / name / file).read_bytes() for side in "ab"]
            assert texts[0] == texts[1]
            assert not any(effect.encode() in texts[0] for effect in (*VOCABULARY, *OUTSIDE))
    assert not list((tmp_path / "a" / "cases").rglob("*key*"))


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


def test_machines_of_a_family_bear_its_trait():
    rng = np.random.default_rng(3)
    assert {draw_machine(rng, "sticking").law for _ in range(5)} == {"stick"}
    assert all(draw_machine(rng, "jitter").jitter > 0 for _ in range(5))
    assert not any("controller" in draw_machine(rng, "no_controller").model for _ in range(5))
    loud = draw_machine(rng, "loud_noise")
    assert loud.model["noise"]["force"] == pytest.approx(loud.noise_rms / 3, rel=0.06)


# in the large


@pytest.fixture(scope="module")
def large():
    return draw_large([1, 0, 0], Specification("large", ("cogging_harmonic",)))


def test_effects_in_the_large_make_the_stated_share_of_the_command(large):
    sizes = {effect["name"]: effect["size"] for effect in large.key["effects"]}
    assert SHARES[0] <= large.key["share"] <= SHARES[1]
    assert power_ratio(large.main, large.base) == pytest.approx(large.key["share"], rel=1e-9)
    assert min(sizes.values()) >= 0.15 * max(sizes.values())
    assert max(sizes, key=sizes.get) in large.key["largest"]
    assert power_ratio(large.base, large.base) < 1e-3, "without them nothing is missing"


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


def test_a_misread_log_is_that_of_the_machine_times_a_factor(large, tmp_path):
    write_case(large, tmp_path / "case")
    model, log = cogging.Model.read(tmp_path / "case" / "model.toml"), cogging.read_log(tmp_path / "case" / "log.csv")
    assert (model.controller is not None) == large.key["stated_controller"]
    np.testing.assert_allclose(log.command, large.factors["command"] * large.main_run.command, rtol=1e-9)
    json.dumps(large.key, allow_nan=False)
    factors = {"command": -3.0, "time": 1e3}
    for name, given in (("right", {}), ("misread", factors)):
        write_log(tmp_path / name, large.machine, large.main, large.main_run, given)
    right, misread = (np.genfromtxt(tmp_path / name, delimiter=",", names=True) for name in ("right", "misread"))
    for name in right.dtype.names:
        np.testing.assert_allclose(misread[name], factors.get(name, 1.0) * right[name], rtol=1e-9)


def test_answers_in_the_large_are_judged():
    key = key_of("large", "gravity", "backlash") | {"largest": ["gravity"], "misreading": None}
    misread = key | {"misreading": {"kind": "sign", "columns": ["command"], "factor": -1.0}}
    grows = {"given": 1.0, "before": 1.2, "after": 1.0}
    right = judge("0", key, answer("named", ("gravity", 0.95), ("backlash", 0.95), gap=grows))
    assert (right.largest, right.found, right.said, right.grows) == (True, 2, None, True)
    second = judge("1", key, answer("named", ("backlash", 0.95), ("drag", 0.95), gap={"before": 1.0, "after": 1.005}))
    assert (second.largest, second.found, second.wrong, second.grows) == (False, 1, ("drag",), False)
    said = [({"kind": "sign", "column": "position"}, "kind"), ({"kind": "scale", "column": "time"}, "verdict")]
    for mismatch, what in said:
        assert judge("2", misread, answer("data_mismatch") | {"mismatch": mismatch}).said == what
    silent = judge("3", misread, answer("unlisted"))
    assert silent.said == ""
    lines = [line.split() for line in format_table(table([right, second, silent])).splitlines()]
    (first,) = (line for line in lines if line[:3] == ["right", "first", "name,"])
    assert first[6:9] == ["50.0", "%", "(1/2;"]
    assert judge("4", misread, {"error": "InputError: command: give --scale; its sign is reversed"}).said == "kind"
    assert judge("5", misread, {"error": "ZeroDivisionError: float division by zero"}).said == ""


# scores


@pytest.mark.parametrize(("hits", "count"), [(0, 10), (1, 7), (19, 20), (20, 20), (57, 180)])
def test_wilson_bounds_are_scipys(hits, count):
    expected = binomtest(hits, count).proportion_ci(0.95, method="wilson")
    assert Rate(hits, count).bounds == pytest.approx((expected.low, expected.high))


def key_of(kind, *names, ratio=100.0, outside=False, tolerated=(), parameters=None, family="plain"):
    effects = [
        {"name": n, "ratio": ratio, "in_vocabulary": not outside, "tolerated": list(tolerated), "shape": "usual",
         "parameters": parameters or {}} for n in names
    ]  # fmt: skip
    return {"kind": kind, "family": family, "ratio": ratio, "effects": effects, "stated_controller": True,
            "confirm_floor": 1.0, "confirm_rest": 0.6, "confirm_effect": 0.6, "confirm_closable": 0.36}  # fmt: skip


def answer(verdict, *entries, gap=None, parameters=None):
    effects = [
        {
            "name": name,
            "confidence": confidence,
            "alternatives": list(others),
            "parameters": parameters or {},
            "statistic": 75.0,
        }
        for name, confidence, *others in entries
    ]
    return {"verdict": verdict, "effects": effects, "gap": gap or {}}


def test_hand_made_results_get_their_hand_computed_rates():
    spring, step, drag = "cable_spring", "disturbance_step", "quadratic_drag"
    stiffness = {"stiffness": {"value": 2.0, "unit": "V/m", "deviation": 0.1}}
    found = {"stiffness": {"value": 2.15, "unit": "V/m", "ci95": [1.9, 2.4]}}
    gap = {"floor": 1.0, "confirm_before": np.sqrt(1.36), "confirm_after": 1.0}
    worse = {"confirm_before": 1.0, "confirm_after": 1.02}
    outcomes = [
        judge("0", key_of("null"), answer("no_gap")),
        judge("1", key_of("null"), answer("insufficient_excitation")),
        judge("2", key_of("null", family="jitter"), answer("named", (step, 0.95), gap=worse)),
        judge("3", key_of("null", family="jitter"), {"error": "ValueError: no"}),
        judge("4", key_of("effect", spring, ratio=300.0, parameters=stiffness),
              answer("named", (spring, 0.95), gap=gap, parameters=found)),
        judge("5", key_of("effect", spring), answer("ambiguous", ("end_effect", 0.6, spring))),
        judge("6", key_of("effect", spring), answer("named", (drag, 0.92))),
        judge("7", key_of("effect", spring), answer("no_gap")),
        judge("8", key_of("outside", "soft_saturation", outside=True, tolerated=["command_saturation"]),
              answer("named", ("command_saturation", 0.95))),
        judge("9", key_of("outside", "encoder_slip", outside=True), answer("unlisted")),
        judge("10", key_of("outside", "encoder_slip", outside=True), answer("unlisted", (drag, 0.97))),
        judge("11", key_of("pair", spring, step, ratio=300.0), answer("named", (step, 0.95), (spring, 0.91))),
        judge("12", key_of("pair", spring, step, ratio=300.0), answer("named", (step, 0.95))),
    ]  # fmt: skip
    figures = table(outcomes)

    def rate(name, key=None):
        found_rate = figures[name] if key is None else figures[name][key]
        return found_rate.hits, found_rate.count

    assert rate("errors") == (1, 13)
    assert rate("false_alarm") == (2, 4)
    assert rate("false_alarm_by_family", "jitter") == (2, 2)
    assert rate("false_alarm_by_family", "plain") == (0, 2)
    assert rate("detected", "100") == (2, 3)
    assert rate("named", "100") == (1, 3)
    assert rate("named", "300") == (1, 1)
    assert rate("exact", "100") == (0, 3)
    assert rate("confident_wrong", "100") == (1, 3)
    assert rate("confident_wrong_all") == (1, 4)
    assert figures["mean_names"] == pytest.approx(1.5)
    assert figures["mean_names_apart"] == pytest.approx(1.0)
    assert rate("outside_unlisted", "100") == (2, 3)
    assert rate("outside_confident_wrong_all") == (1, 3)
    assert rate("pairs_right") == (1, 2)
    assert rate("made_worse") == (1, 2)
    assert figures["gap_closed_median"] == pytest.approx(1.0)
    assert rate("coverage") == (1, 1)
    assert figures["error_to_bound"] == pytest.approx(1.5)
    # 0.95: null's step, spring, saturation, both pairs' steps; 0.92 drag; 0.91 spring
    assert (figures["calibration"]["0.9 to 0.97"]["right"].hits, figures["calibration"]["0.9 to 0.97"]["right"].count) \
        == (5, 7)  # fmt: skip
    assert figures["confusion"]["cable_spring"] == {
        "cable_spring": 1,
        "end_effect?": 1,
        "quadratic_drag": 1,
        "no_gap": 1,
    }
    assert figures["confusion"]["nothing"] == {
        "no_gap": 1,
        "insufficient_excitation": 1,
        "disturbance_step": 1,
        "error": 1,
    }
    json.dumps(benchmark.plain(figures), allow_nan=False)


# the command


def test_the_command_draws_runs_scores_and_prints(tmp_path, capsys, monkeypatch):
    result = SimpleNamespace(to_dict=lambda: answer("named", ("constant_force", 0.95)))
    monkeypatch.setattr(cogging, "diagnose", lambda *files, **options: result)
    arguments = ["--seed", "9", "--cases", "2", "--jobs", "1", "--out", str(tmp_path)]
    chosen = ["--kinds", "null,effect", "--effects", "constant_force", "--lambdas", "100", "--family", "plain"]
    assert benchmark.main(arguments + chosen) == 0
    first = capsys.readouterr().out
    assert "false alarm" in first
    assert json.loads((tmp_path / "table_diagnose.json").read_text())["cases"] == 2
    assert benchmark.main([*arguments, "--rescore"]) == 0
    assert capsys.readouterr().out == first


def test_a_report_refuses_the_seeds_of_the_tuning(capsys):
    with pytest.raises(SystemExit) as end:
        benchmark.parse(["--seed", str(benchmark.tuning_seeds()[0]), "--out", "x", "--report"])
    assert end.value.code == 2
    assert "tuning" in capsys.readouterr().err
