"""The family in the large: apart from the core, right in its physics, as large as it says, honest in what it tells."""

import ast
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import cogging
from tests.blind.large import score
from tests.blind.large.__main__ import main
from tests.blind.large.cases import SHARES, draw_case, gap, power_ratio
from tests.blind.large.effects import EFFECTS, SMOOTH_LAWS, TURNING
from tests.blind.large.machines import DEVIATIONS, FACTOR, STATEMENTS, draw_machine
from tests.blind.large.misreadings import KINDS, draw_misreading
from tests.blind.large.runner import Answer, answers
from tests.blind.vocabulary import CHANGES, VOCABULARY

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "tests" / "blind" / "large"
SEED = 1
#: Cases of that seed with effects that are functions of place, speed and time, by the laws of the contract.
STATIC = {"cable_spring", "coulomb_asymmetry", "cogging_harmonic", "constant_force", "disturbance_step"}
STATIC |= {"disturbance_tone", "end_effect", "force_constant_ripple", "mass_change", "position_dependent_friction"}
STATIC |= {"quadratic_drag", "stribeck_friction", "viscous_asymmetry", "gravity"}


@pytest.fixture(scope="module")
def cases():
    return [draw_case(SEED, index) for index in (1, 14, 5, 6, 8, 17, 19)]


# apart from the core


@pytest.mark.parametrize("name", ["motions", "machines", "effects", "misreadings", "cases"])
def test_what_draws_the_truth_imports_nothing_of_the_core(name):
    modules = set()
    for node in ast.walk(ast.parse((FOLDER / f"{name}.py").read_text())):
        if isinstance(node, ast.Import):
            modules |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            modules.add("." if node.level else node.module.split(".")[0])
    assert modules <= {".", "__future__", "collections", "dataclasses", "typing", "numpy"}


def test_drawing_a_case_never_loads_the_package():
    code = "import sys; from tests.blind.large.cases import draw_case; draw_case(1, 1)"
    code += "; sys.exit('cogging' in {m.split('.')[0] for m in sys.modules})"
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=False).returncode == 0


def test_the_effects_bear_names_of_the_vocabulary():
    assert set(EFFECTS) <= {*VOCABULARY, *CHANGES, *TURNING}
    assert len(EFFECTS) >= 21


# as drawn


def test_the_same_seed_draws_the_same_case(cases):
    again = draw_case(SEED, 14)
    for log, other in ((cases[1].log, again.log), (cases[1].confirm, again.confirm)):
        assert list(log) == list(other)
        for name, column in log.items():
            np.testing.assert_array_equal(column, other[name])
    assert again.model == cases[1].model
    assert again.truth.parameters == cases[1].truth.parameters


def test_the_effects_make_the_stated_share_and_stand_in_the_order_of_their_size(cases):
    for case in cases:
        told = case.truth
        assert len(told.names) == len(told.sizes) == len(told.parameters)
        if not told.names:
            assert told.misreading is not None
            continue
        assert SHARES[0] <= told.share <= SHARES[1]
        assert power_ratio(case.plan, told.machine) == pytest.approx(told.share, rel=1e-9)
        assert list(told.sizes) == sorted(told.sizes, reverse=True)
        assert min(told.sizes) >= 0.15 * max(told.sizes)


def test_without_the_effects_nothing_is_missing(cases):
    for case in cases:
        assert power_ratio(case.base, case.truth.machine) < 1e-3


def friction_sign(machine, v):
    """What stands for the sign of the velocity."""
    width = machine.scalars["width"]
    laws = {"tanh": np.tanh(v / width), "algebraic": v / np.hypot(v, width)}
    laws["arctangent"] = 2 / np.pi * np.arctan(v / width)
    return laws.get(machine.law, np.sign(v))


def force(name, p, machine, x, v, u, t):
    """What an effect pushes with, by the law of the contract: p are the stated parameters of the case."""
    low, high = machine.travel
    sine, cosine = p.get("sine", 0.0), p.get("cosine", 0.0)
    sign = friction_sign(machine, v)
    if name == "cogging_harmonic":
        waves = [2 * np.pi * x / p[key] for key in p if key.startswith("period")]
        terms = [p[f"sine {i}"] * np.sin(w) + p[f"cosine {i}"] * np.cos(w) for i, w in enumerate(waves, start=1)]
        return -np.sum(terms, axis=0)
    if name == "position_dependent_friction":
        nodes = [p[key] for key in p if key.startswith("node")]
        levels = [p[key] for key in p if key.startswith("level")]
        return -np.interp(x, nodes, levels) * sign
    laws = {
        "constant_force": lambda: np.full_like(x, p["force"]),
        "cable_spring": lambda: -p["stiffness"] * (x - p["center"]),
        "end_effect": lambda: (
            p["force"] * (np.exp((x - high) / p["decay_length"]) - np.exp((low - x) / p["decay_length"]))
        ),
        "local_force": lambda: p["force"] * np.exp(-(((x - p["center"]) / p["width"]) ** 2)),
        "gravity": lambda: -p["moment"] * np.sin(x - p["angle"]),
        "coulomb_asymmetry": lambda: -p["difference"] / 2 * np.abs(sign),
        "viscous_asymmetry": lambda: -p["difference"] / 2 * np.abs(v),
        "stribeck_friction": lambda: -p["static_excess"] * np.exp(-(np.abs(v / p["velocity"]) ** p["exponent"])) * sign,
        "quadratic_drag": lambda: -p["coefficient"] * v * np.abs(v),
        "force_constant_ripple": lambda: (
            u * (sine * np.sin(2 * np.pi * x / p["period"]) + cosine * np.cos(2 * np.pi * x / p["period"]))
        ),
        "disturbance_tone": lambda: (
            sine * np.sin(2 * np.pi * p["frequency"] * t) + cosine * np.cos(2 * np.pi * p["frequency"] * t)
        ),
        "disturbance_step": lambda: p["force"] * ((t >= p["start"]) & (t < p["stop"])),
    }
    return laws[name]()


def test_the_gap_is_what_the_laws_of_the_contract_push_with(cases):
    """Force needed less force known, from the simulated states, against the laws at the stated parameters."""
    tried = 0
    for case in cases:
        told, plan = case.truth, case.plan.silent()
        if told.machine.law == "stick" or not told.names or not set(told.names) <= STATIC - {"mass_change"}:
            continue
        tried += 1
        run = plan.run()
        x, v = 0.5 * (run.position[1:] + run.position[:-1]), 0.5 * (run.velocity[1:] + run.velocity[:-1])
        t, u = 0.5 * (plan.instants[1:] + plan.instants[:-1]), run.command[:-1]
        command, missing, moving = gap(plan, told.machine)
        fast = np.abs(v) > 0.1 * np.abs(v).max()
        pushed = sum(
            force(name, {key: value for key, (value, _) in p.items()}, told.machine, x, v, u, t)
            for name, p in zip(told.names, told.parameters, strict=True)
        )
        rest = (missing + pushed)[moving & fast]
        assert len(rest) > 200
        assert np.sqrt(np.mean(rest**2)) < 0.03 * np.sqrt(np.mean(command[moving & fast] ** 2))
        assert np.sqrt(np.mean(missing[moving & fast] ** 2)) > 0.3 * np.sqrt(np.mean(command[moving & fast] ** 2))
    assert tried >= 3


def test_a_drawn_case_follows_the_equation_of_motion_by_scipy(cases):
    """From the state at a sample, the command held, to that some samples on: by another integrator, from the laws."""
    tried = 0
    for case in cases:
        told, plan = case.truth, case.plan.silent()
        if told.machine.law not in SMOOTH_LAWS or not told.names or not set(told.names) <= STATIC:
            continue
        run = plan.run()
        stated = [{key: value for key, (value, _) in p.items()} for p in told.parameters]
        mass = told.machine.scalars["mass"]
        if "mass_change" in told.names:
            change = stated[told.names.index("mass_change")]["change"]
            mass = case.model["axis"]["mass"] * (1 + change)

        def slope(t, state, u, case=case, mass=mass, stated=stated):
            machine, (x, v) = case.truth.machine, np.array(state)[:, None]
            push = u - machine.scalars["viscous"] * v - machine.scalars["coulomb"] * friction_sign(machine, v)
            push = push + machine.known_force(x)
            for name, p in zip(case.truth.names, stated, strict=True):
                if name != "mass_change":
                    push = push + force(name, p, machine, x, v, u, np.array([t]))
            return [v[0], push[0] / mass]

        fast = np.flatnonzero(np.abs(run.velocity) > 0.3 * np.abs(run.velocity).max())
        for start in fast[:: len(fast) // 4 + 1]:
            stop = min(start + 15, len(run.position) - 1)
            state = [run.position[start], run.velocity[start]]
            for k in range(start, stop):
                end = solve_ivp(slope, plan.instants[k : k + 2], state, args=(run.command[k],), rtol=1e-9, atol=1e-12)
                state = end.y[:, -1]
            way = np.abs(run.position[stop] - run.position[start])
            assert abs(state[0] - run.position[stop]) < 2e-3 * way
            assert abs(state[1] - run.velocity[stop]) < 2e-3 * np.abs(run.velocity).max()
        tried += 1
    assert tried >= 3


def test_the_model_is_as_wrong_as_it_says():
    rng = np.random.default_rng(4)
    wrong = {statement: [] for statement in STATEMENTS}
    for _ in range(400):
        machine = draw_machine(rng, statement=str(rng.choice(STATEMENTS)))
        axis = machine.model["axis"]
        for name in ("mass", "viscous", "coulomb"):
            ratio = machine.scalars[name] / axis[name]
            wrong[machine.statement].append(ratio)
            assert 0.999 / FACTOR < ratio < 1.001 * FACTOR
            if machine.statement == "unstated":
                assert "uncertainty" not in axis
            else:
                low, high = DEVIATIONS[machine.statement]
                assert low <= axis["uncertainty"][name] <= high
                assert abs(ratio - 1) <= 1.8 * axis["uncertainty"][name] + 1e-3
    assert set(wrong["exact"]) == {1.0}
    assert np.ptp(np.log(wrong["unstated"])) > 1.9 * np.log(FACTOR)
    assert np.std(wrong["loose"]) > 3 * np.std(wrong["tight"]) > 0.0


def test_machines_are_of_all_sizes():
    rng = np.random.default_rng(5)
    machines = [draw_machine(rng, statement="loose") for _ in range(300)]
    mass = [machine.scalars["mass"] for machine in machines]
    length = [machine.room.length for machine in machines]
    assert min(mass) < 2e-3 < 50 < max(mass)
    assert min(length) < 0.04 < 20 < max(length)
    assert {200.0, 5000.0} <= {machine.rate for machine in machines}
    assert 0.4 < np.mean([machine.controller_stated for machine in machines]) < 0.6
    assert 0.5 < np.mean([machine.reference_columns for machine in machines]) < 0.8
    assert 0.05 < np.mean([machine.scalars["resolution"] == 0 for machine in machines]) < 0.3
    for machine in machines:
        assert ("controller" in machine.model) == machine.controller_stated
        assert ("cogging" in machine.model) == bool(machine.known)


# misread


@pytest.mark.parametrize("kind", KINDS)
def test_a_misreading_changes_what_it_says_and_nothing_else(kind):
    rng = np.random.default_rng(len(kind))
    log = {name: rng.normal(size=20) for name in ("time", "position", "command", "reference", "reference_velocity")}
    subject, what = kind.split()
    seen = set()
    for _ in range(20):
        reading = draw_misreading(rng, draw_machine(rng, statement="loose"), kind)
        assert (reading.kind, reading.columns[0]) == (what, subject)
        assert (reading.factor == -1.0) == (what == "sign")
        assert what == "sign" or abs(np.log(reading.factor)) > np.log(6)
        misread = reading.apply(log)
        changed = {name for name in log if not np.array_equal(log[name], misread[name])}
        assert changed == set(reading.columns) & set(log)
        for name in changed:
            np.testing.assert_allclose(misread[name] / log[name], reading.factor)
        seen.add(reading.columns)
    assert len(seen) == (2 if subject == "position" else 1)


def test_the_logs_of_a_misread_case_are_those_of_the_machine_times_a_factor(cases):
    case = cases[0]
    reading = case.truth.misreading
    assert reading is not None
    assert reading.columns == ("command",)
    np.testing.assert_array_equal(case.log["command"], reading.factor * case.plan.run().command)


# told


def answer(cases, number, **told):
    return Answer(number, cases[number], 1.0, **{"verdict": "named", **told})


def effect(name, confidence=0.95, alternatives=()):
    return {"name": name, "alternatives": list(alternatives), "confidence": confidence, "parameters": {}}


def test_a_right_first_name_a_wrong_one_and_an_alternative(cases):
    case = cases[1]
    (name,) = case.truth.names
    right = score.judge(answer(cases, 1, effects=[effect(name)]))
    assert (right.first, right.wrong, right.found, right.hidden) == (True, (), 1, 1)
    wrong = score.judge(answer(cases, 1, effects=[effect("backlash"), effect(name)]))
    assert (wrong.first, wrong.wrong, wrong.found) == (False, ("backlash",), 1)
    unsure = score.judge(answer(cases, 1, effects=[effect("backlash", 0.5, [name])]))
    assert (unsure.first, unsure.wrong, unsure.found) == (True, (), 1)
    assert not score.judge(answer(cases, 1, verdict="no_gap")).first
    assert score.judge(answer(cases, 1, verdict="data_mismatch")).accused


def test_the_second_effect_does_not_stand_first(cases):
    number, case = next((i, c) for i, c in enumerate(cases) if len(c.truth.names) == 2)
    larger, smaller = case.truth.names
    assert score.judge(answer(cases, number, effects=[effect(larger), effect(smaller)])).first
    first = score.judge(answer(cases, number, effects=[effect(smaller)])).first
    assert first == (case.truth.sizes[1] > score.AS_LARGE * case.truth.sizes[0])


def test_gaps_that_grow():
    assert score.growing({"before": 1.0, "after": 1.005}) == ()
    assert score.growing({"before": 1.0, "after": 1.02}) == ("after > before",)
    assert score.growing({"given": 1.0, "before": 1.2, "after": 1.1}) == ("before > given", "after > given")
    assert score.growing({"confirm_before": 1.0, "confirm_after": 2.0}) == ("confirm_after > confirm_before",)


def test_a_misreading_is_said_with_its_kind_or_without_or_not(cases):
    def said(mismatch, verdict="data_mismatch"):
        return score.judge(answer(cases, 0, verdict=verdict, mismatch=mismatch)).said

    assert said({"kind": "sign", "column": "command"}) == "kind"
    assert said("sign of the position") == "kind"
    assert said({"kind": "scale", "column": "time"}) == "verdict"
    assert said(None, "unlisted") == ""
    refused = answer(cases, 0, verdict="error", error="InputError: command: give --scale; its sign is reversed")
    assert score.judge(refused).said == "kind"
    refused.error = "ZeroDivisionError: float division by zero"
    assert score.judge(refused).said == ""


def test_the_table_counts(cases):
    told = [answer(cases, 1, effects=[effect(cases[1].truth.names[0])]), answer(cases, 0, verdict="no answer")]
    table = score.figures([*told, Answer(9, None, 0.0, "not drawn", error="no machine")])
    assert "right first name, up to alternatives             1 of   1   100 %" in table
    assert "misreadings said                                 0 of   1     0 %" in table
    assert "no answer                                        1 of   2    50 %" in table
    assert all(score.line(one).strip() for one in told)


@pytest.mark.parametrize(("what", "verdict"), [("sleeps", "no answer"), ("fails", "error"), ("answers", "no_gap")])
def test_each_case_has_its_time_and_its_process(monkeypatch, what, verdict):
    def diagnose(*_, **__):
        if what == "sleeps":
            time.sleep(60)
        if what == "fails":
            raise ValueError("no such machine")
        gap = type("Gap", (), {"before": 2.0, "after": 1.0, "given": None})()
        return type("Result", (), {"verdict": "no_gap", "effects": (), "gap": gap})()

    monkeypatch.setattr(cogging, "diagnose", diagnose)
    (one,) = answers(SEED, [1], jobs=1, limit=0.5 if what == "sleeps" else 60.0)
    assert one.verdict == verdict
    assert one.seconds < 30
    assert one.gap == ({"before": 2.0, "after": 1.0} if what == "answers" else {})
    assert ("no such machine" in one.error) == (what == "fails")


def test_the_command_tells_every_case_and_the_figures(monkeypatch, capsys):
    def diagnose(*_, **__):
        gap = type("Gap", (), {"given": 3.0, "before": 2.0, "after": 2.5})()
        return type("Result", (), {"verdict": "no_gap", "effects": (), "gap": gap})()

    monkeypatch.setattr(cogging, "diagnose", diagnose)
    assert main(["--seed", str(SEED), "--only", "14", "1", "--jobs", "2"]) == 0
    told = capsys.readouterr().out
    assert "end_effect" in told
    assert "command x -1" in told
    assert told.count("GROWS after > before") == 2
    assert f"== in the large, seed {SEED}, 2 cases" in told
    assert "a gap grows                                      2 of   2   100 %" in told
