"""`diagnose`: its result, its command and report, and that it knows no effect by name."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from cogging.diagnosis.balance.differenced_balance import DifferencedBalance
from cogging.diagnosis.balance.evidence import Evidence
from cogging.diagnosis.patched_model import paths_without, with_intervals
from tests.fixtures.pid_axis import MODEL, PID, other, run

effects = cogging.effects
PACKAGE = Path(cogging.__file__).parent / "diagnosis"


# What is found --------------------------------------------------------------------------------------------------------


#: The others are hidden in the machines of tests/blind, and here in a longer study.
HIDDEN = [effects.CoulombAsymmetry(difference=0.04), effects.ForceConstantRipple(period=0.05, sine=0.2)]
STUDIED = [
    effects.CableSpring(stiffness=0.6, center=0.25),
    effects.CoggingHarmonic(period=0.03, sine=0.03),
    effects.DisturbanceTone(frequency=17.0, sine=0.03),
]


@pytest.mark.parametrize(
    "hidden",
    [*HIDDEN, *(pytest.param(effect, marks=pytest.mark.study) for effect in STUDIED)],
    ids=lambda effect: effect.NAME,
)
def test_a_strong_effect_is_named_up_to_its_look_alikes(hidden, tmp_path):
    log = run(hidden, seed=2)
    result = cogging.diagnose(log, MODEL, confirm=other(hidden))
    assert result.verdict in ("named", "ambiguous")
    assert any(hidden.NAME in (effect.name, *effect.alternatives) for effect in result.effects), str(result)
    assert str(result) == result.text()
    assert repr(result).startswith(f"Diagnosis({result.verdict}: {result.effects[0].name}")
    assert result.gap.after < result.gap.before
    assert result.gap.floor <= result.gap.after
    # The patched model is a model like any other.
    result.model.write(tmp_path / "patched.toml")
    patched = cogging.Model.read(tmp_path / "patched.toml")
    assert [e.NAME for e in patched.effects] == [e.NAME for e in result.model.effects]
    motion = cogging.Sampled(time=log.time, position=log.reference, velocity=np.gradient(log.reference, log.time))
    assert len(cogging.simulate(patched, motion, duration=0.2)) == 201


def test_the_asymmetry_is_named_and_confirmed(found):
    (effect,) = found.effects
    assert found.verdict == "named"
    assert effect.name == "viscous_asymmetry"
    low, high = effect.parameters["difference"].ci95
    assert low < 0.12 < high
    assert effect.confidence >= 0.9
    assert found.gap.confirm_after < found.gap.confirm_before
    assert found.model.intervals["effects.viscous_asymmetry.difference"] == pytest.approx((low, high), rel=1e-12)
    assert found.model.controller == MODEL.controller


# No effect is known by name -------------------------------------------------------------------------------------------


def test_every_effect_is_looked_for():
    candidates = (PACKAGE / "balance" / "candidates.py").read_text()
    assert {name for name in cogging.EFFECTS if f'"{name}"' not in candidates} == {"empirical_force"}  # names no cause


# What cannot be diagnosed ---------------------------------------------------------------------------------------------


def test_at_rest_there_is_nothing_to_see():
    time = np.arange(0.0, 3.0, 5e-4)
    quiet = cogging.Log(time=time, position=np.full(time.size, 0.1), command=np.zeros(time.size))
    result = cogging.diagnose(quiet, MODEL.replace(controller=None, controller_type=None))
    assert result.verdict == "insufficient_excitation"
    assert result.effects == ()
    assert "friction hides every force" in result.text()
    assert "too little of the motion" in result.html()
    with pytest.raises(ValueError, match="plot: needs a gap that was measured, got the verdict insufficient"):
        result.plot()


SLOW = cogging.Model(axis=cogging.AxisParameters(mass=0.1, viscous=0.05, coulomb=0.0, coulomb_width=0.05))


@pytest.mark.parametrize("rate", [20.0, 50.0, 100.0])
def test_a_slow_log_without_a_reference_is_answered(rate):
    t = np.arange(0.0, 30.0, 1.0 / rate)
    w, size = np.array([[4.0], [2.3], [0.7]]), np.array([[1.0], [0.5], [0.8]])
    x, v, a = ((size * f).sum(axis=0) for f in (np.sin(w * t), w * np.cos(w * t), -(w**2) * np.sin(w * t)))
    asked = 0.1 * a + 0.05 * v
    held = np.append(0.5 * (asked[1:] + asked[:-1]), asked[-1])  # over the step that follows
    command = held + 0.02 * np.random.default_rng(1).standard_normal(len(t))
    assert cogging.diagnose(cogging.Log(t, x, command), SLOW).verdict == "no_gap"


def test_rows_far_apart_tell_nothing():
    t = 0.4 * np.arange(500.0)
    log = cogging.Log(t, np.sin(0.3 * t), -0.009 * np.sin(0.3 * t) + 0.01 * np.cos(t))
    result = cogging.diagnose(log, SLOW)
    assert (result.verdict, result.effects) == ("insufficient_excitation", ())
    assert "give --scale time=0.001" in result.notes[-1]


def test_an_encoder_that_resolves_the_motion_in_pieces_tells_nothing():
    t = np.arange(0.0, 10.0, 2e-3)
    w, step = 2 * np.pi, 3e-3
    x = np.round(0.1 * np.sin(w * t) / step) * step
    command = -0.01 * w**2 * np.sin(w * t) + 0.01 * np.random.default_rng(0).standard_normal(len(t))
    result = cogging.diagnose(cogging.Log(t, x, command), SLOW)
    assert result.verdict == "insufficient_excitation"
    assert "the encoder resolves the motion" in result.notes[-1]


def test_two_found_effects_of_one_name_keep_their_places():
    """Two waves of unlike periods: each stands in the model with its own interval, and without either more is left."""
    hidden = [effects.CoggingHarmonic(period=0.03, sine=0.05), effects.CoggingHarmonic(period=0.07, cosine=0.04)]
    result = cogging.diagnose(run(*hidden, seed=3), MODEL, confirm=other(*hidden))
    waves = [e for e in result.model.effects if e.NAME == "cogging_harmonic" and np.hypot(e.sine, e.cosine) > 0.01]
    assert sorted(round(e.period, 3) for e in waves) == [0.03, 0.07]
    for path, (low, high) in result.model.intervals.items():
        if path.startswith("effects.cogging_harmonic"):
            assert low < high
    for step in result.ledger:
        assert not step.accepted or step.gap_after < step.gap_before


def test_intervals_stay_with_their_effects_where_one_between_them_is_left_out():
    sizes = {0.05: 0.02, 0.031: 0.03, 0.019: 0.04}  # V by period (m)
    waves = [effects.CoggingHarmonic(period=p, sine=s, cosine=0.0) for p, s in sizes.items()]
    spring = effects.CableSpring(stiffness=0.5, center=0.1)
    balance = DifferencedBalance(run(*waves, spring, seed=4), quantum=MODEL.encoder.resolution)
    evidence = Evidence([balance], MODEL, MODEL.replace(effects=(*waves, spring))).prepare(2, listen=True)
    whole = evidence.model
    first, gone, last = (f"effects.cogging_harmonic[{place}]" for place in range(3))
    names = paths_without(whole, {gone})
    assert names == {first: first, last: gone, "effects.cable_spring": "effects.cable_spring"}
    everything = with_intervals(whole, evidence, whole, {path: path for path in [first, gone, last, *names]})
    patched = whole.replace(effects=(whole.effects[0], *whole.effects[2:]))
    found = with_intervals(patched, evidence, whole, names)
    for new, old in ((first, first), (gone, last), ("effects.cable_spring", "effects.cable_spring")):
        for field in ("stiffness",) if "spring" in new else ("period", "sine", "cosine"):
            assert found.intervals[f"{new}.{field}"] == pytest.approx(everything.intervals[f"{old}.{field}"], rel=1e-12)
    assert found.intervals[f"{gone}.sine"][0] > 0.03


def test_a_wrong_controller_is_told(tmp_path):
    log = run(duration=3.0)
    result = cogging.diagnose(log, MODEL.replace(controller=PID.replace(mass=0.0, viscous=0.0)))
    assert result.verdict == "controller_mismatch"
    assert any("stated controller misses the logged command" in note for note in result.notes)
    result.report(tmp_path / "page.html")
    assert "The stated controller did not make this log" in (tmp_path / "page.html").read_text()


def test_a_short_log_is_refused():
    log = run(duration=0.2)
    with pytest.raises(ValueError, match=r"log 1: rows: must be at least 500 to be diagnosed, got 201"):
        cogging.diagnose(log, MODEL)
    for call in (cogging.diagnose, cogging.locate_gap):
        with pytest.raises(ValueError, match=r"logs: must be at least 1, got 0"):
            call([], MODEL)


# The result and the command -------------------------------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path, monkeypatch):
    MODEL.write(tmp_path / "model.toml")
    run(effects.DisturbanceTone(frequency=17.0, sine=0.03), duration=3.0).write(tmp_path / "log.csv")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_command_writes_result_report_and_model(folder, capsys):
    call = ["diagnose", "log.csv", "--model", "model.toml", "--rows", "0:2500", "--json", "out.json"]
    assert main([*call, "--report", "out.html", "--out", "patched.toml"]) == 0
    said = capsys.readouterr()
    assert "disturbance_tone" in said.out
    assert "out.json, out.html, patched.toml written" in said.out
    assert json.loads((folder / "out.json").read_text())["effects"][0]["name"] == "disturbance_tone"
    assert cogging.Model.read("patched.toml").effects[0].NAME == "disturbance_tone"
    page = (folder / "out.html").read_text()
    assert "disturbance tone" in page
    assert page.count("<svg") >= 2
    assert not re.findall(r"(?:src|href)=\"(?!data:|#)", page)  # nothing is loaded from elsewhere
