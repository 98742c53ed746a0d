"""`diagnose`: its result, its command and report, and that it knows no effect by name."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from cogging.diagnosis.candidates import scan, signatures, waves
from cogging.diagnosis.naming.masking import masking_notes
from cogging.diagnosis.report.figures import binned, coordinates_figure, spectrum
from cogging.diagnosis.residual.location_words import length_text, ranges
from cogging.diagnosis.residual.shapes import Shape
from cogging.diagnosis.search import search
from cogging.diagnosis.search.empirical import NoTerm, with_term
from cogging.diagnosis.search.search import search as search_logs

effects = cogging.effects
PACKAGE = Path(cogging.__file__).parent / "diagnosis"
PID = cogging.PidParameters(
    sample_rate=2000.0, kp=9600.0, ki=1e5, kd=48.0, mass=0.12, viscous=0.166, coulomb=0.15, coulomb_width=1.11e-3
)
MODEL = cogging.Model(
    axis=cogging.AxisParameters(mass=0.12, viscous=0.166, coulomb=0.15, coulomb_width=1.11e-3, travel=[0.0, 0.51]),
    encoder=cogging.EncoderParameters(resolution=0.5e-6),
    noise=cogging.NoiseParameters(force=0.01, bandwidth=50.0),
    controller=PID,
    controller_type="pid",
    uncertainty={"mass": 0.03, "viscous": 0.2, "coulomb": 0.2},
)


def run(*present, seed=1, duration=4.0, start=0.08, distance=0.32, velocity=0.25, acceleration=3.0):
    """A closed-loop run of the model with these effects."""
    motion = cogging.PointToPoint(
        cogging.PointToPointParameters(
            start=start,
            distance=distance,
            velocity=velocity,
            acceleration=acceleration,
            jerk=300.0,
            dwell=0.1,
            repeats=4,
        )
    )
    return cogging.simulate(MODEL.replace(effects=present), motion, duration=duration, seed=seed)


def other(*present):
    """The same machine on other motion."""
    return run(*present, seed=2, duration=3.0, start=0.15, distance=0.2, velocity=0.4, acceleration=6.0)


@pytest.fixture(scope="module")
def found():
    """An asymmetry of friction, named with a confirm log."""
    hidden = effects.ViscousAsymmetry(difference=0.12)
    return cogging.diagnose(run(hidden), MODEL, confirm=other(hidden))


# What is found --------------------------------------------------------------------------------------------------------


HIDDEN = [
    effects.CoulombAsymmetry(difference=0.04),
    effects.CableSpring(stiffness=0.6, center=0.25),
    effects.CoggingHarmonic(period=0.03, sine=0.03),
    effects.DisturbanceTone(frequency=17.0, sine=0.03),
    effects.ForceConstantRipple(period=0.05, sine=0.2),
]


@pytest.mark.parametrize("hidden", HIDDEN, ids=lambda effect: effect.NAME)
def test_a_strong_effect_is_named_up_to_its_look_alikes(hidden, tmp_path):
    log = run(hidden, seed=2)
    result = cogging.diagnose(log, MODEL)
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
    motion = cogging.Sampled(
        time=log.time,
        position=log.reference,
        velocity=np.gradient(log.reference, log.time),
    )
    assert len(cogging.simulate(patched, motion, duration=0.2)) == 401


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


def test_nothing_is_missing_where_nothing_is():
    result = cogging.diagnose(run(), MODEL)
    assert result.verdict == "no_gap"
    assert result.effects == ()
    assert result.unlisted is None


def test_the_same_twice():
    hidden = effects.DisturbanceTone(frequency=17.0, sine=0.03)
    log = run(hidden, duration=3.0)
    first, second = (cogging.diagnose(log, MODEL).to_dict() for _ in range(2))
    assert json.dumps(first) == json.dumps(second)


def test_masking_is_told():
    def with_effects(*present):
        return MODEL.replace(effects=present)

    before = with_effects(effects.ConstantForce(force=3.0))
    added = effects.ViscousAsymmetry(difference=-75.0)
    assert masking_notes(before, with_effects(effects.ConstantForce(force=2.0), added)) == []
    assert masking_notes(before, before) == []
    (note,) = masking_notes(before, with_effects(effects.ConstantForce(force=-0.1), added))
    assert note.startswith("constant_force of the given model nearly vanishes (3 to -0.1 V) once viscous_asymmetry")


# No effect is known by name -------------------------------------------------------------------------------------------


def test_no_effect_is_named_in_the_source():
    """A new file in the list of effects is diagnosed at once: nothing here would have to know it."""
    hooks = {hook for effect in cogging.EFFECTS.values() for hook in effect.HOOKS}  # one hook bears an effect's name
    known = re.compile(r"\b(" + "|".join(set(cogging.EFFECTS) - hooks) + r")\b")
    classes = re.compile(r"\b(" + "|".join(e.__name__ for e in cogging.EFFECTS.values()) + r")\b")
    sources = [*PACKAGE.rglob("*.py"), *PACKAGE.rglob("*.j2")]
    assert len(sources) > 10
    for path in sources:
        for pattern in (known, classes):
            assert not pattern.findall(path.read_text()), path.name


def test_an_effect_under_a_new_name_is_found(monkeypatch):
    """The law of an effect under a name that nobody has heard of, in place of the old name, goes the whole way."""

    class Rubber(effects.CableSpring):
        NAME = "rubber_band"

        def replace(self, **changes):
            return Rubber(**{**self.to_dict(), **changes})

    listed = {name: effect for name, effect in cogging.EFFECTS.items() if name != "cable_spring"}
    listed["rubber_band"] = Rubber
    for module in {scan, search, signatures, waves, *_modules()}:
        if hasattr(module, "EFFECTS"):
            monkeypatch.setattr(module, "EFFECTS", listed)
    result = cogging.diagnose(run(effects.CableSpring(stiffness=0.6, center=0.25)), MODEL)
    named = {name for effect in result.effects for name in (effect.name, *effect.alternatives)}
    assert "rubber_band" in named
    assert "cable_spring" not in named
    assert "rubber band" in result.html() or "rubber_band" in result.html()


def _modules():
    import importlib

    folder = PACKAGE.parents[1]
    paths = [path.relative_to(folder).with_suffix("") for path in PACKAGE.rglob("*.py")]
    return {importlib.import_module(".".join(path.parts)) for path in paths if path.stem != "__init__"}


# What cannot be diagnosed ---------------------------------------------------------------------------------------------


def test_at_rest_there_is_nothing_to_see():
    time = np.arange(0.0, 3.0, 5e-4)
    quiet = cogging.Log(time=time, position=np.full(time.size, 0.1), command=np.zeros(time.size))
    result = cogging.diagnose(quiet, MODEL.replace(controller=None, controller_type=None))
    assert result.verdict == "insufficient_excitation"
    assert result.effects == ()
    assert "friction hides every force" in result.text()
    page = result.html()
    assert "move too little" in page
    with pytest.raises(ValueError, match="plot: needs a gap that was measured, got the verdict insufficient"):
        result.plot()


def test_a_wrong_controller_is_told(tmp_path):
    log = run(duration=3.0)
    wrong = MODEL.replace(controller=PID.replace(mass=0.0, viscous=0.0))
    result = cogging.diagnose(log, wrong)
    assert result.verdict == "controller_mismatch"
    assert any("stated controller misses the logged command" in note for note in result.notes)
    result.report(tmp_path / "page.html")
    assert "The stated controller did not make this log" in (tmp_path / "page.html").read_text()


def test_a_short_log_is_refused():
    log = run(duration=0.2)
    with pytest.raises(ValueError, match=r"log 1: rows: must be at least 500 to be diagnosed, got 401"):
        cogging.diagnose(log, MODEL)
    with pytest.raises(ValueError, match=r"logs: must be at least 1, got 0"):
        cogging.diagnose([], MODEL)
    with pytest.raises(ValueError, match=r"logs: must be at least 1, got 0"):
        cogging.locate_gap([], MODEL)


# The result and the command -------------------------------------------------------------------------------------------


def test_the_json_is_as_the_contract_says(found):
    told = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert set(told) >= {"verdict", "effects", "unlisted", "gap", "separating_experiment"}
    assert told["verdict"] == "named"
    (effect,) = told["effects"]
    assert set(effect) >= {"name", "alternatives", "confidence", "parameters", "where"}
    assert effect["alternatives"] == []
    assert 0.0 <= effect["confidence"] <= 1.0
    assert set(effect["parameters"]["difference"]) == {"value", "unit", "ci95"}
    assert effect["parameters"]["difference"]["unit"] == "V/(m/s)"
    assert set(effect["where"]) == {"coordinate", "range"}
    assert len(effect["where"]["range"]) == 2
    gap = told["gap"]
    assert set(gap) >= {"unit", "floor", "before", "after", "confirm_before", "confirm_after"}
    assert all(isinstance(gap[key], float) for key in ("floor", "before", "after", "confirm_before", "confirm_after"))
    assert told["unlisted"] is None
    assert told["separating_experiment"] is None


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


def test_placebo_terms_do_not_help(found):
    assert found.placebo
    assert not {p.name for p in found.placebo} & {e.name for e in found.effects}
    assert all(p.confirm_gain < 4.0 for p in found.placebo)  # a frozen term of no effect: -T on average
    assert "Placebo terms" in found.html()


def test_what_changed_is_measured_against_the_model_as_stated():
    heavy = MODEL.replace(axis=MODEL.axis.replace(mass=0.16))
    motion = cogging.Sampled(*(lambda log: (log.time, log.reference, None, None))(run(duration=3.0)))
    result = cogging.diagnose(cogging.simulate(heavy, motion, duration=3.0, seed=3), MODEL)
    (effect,) = result.effects
    assert effect.name == "mass_change"
    assert effect.parameters["change"].value == pytest.approx(1.0 / 3.0, abs=0.02)
    assert result.nominal.axis.mass == MODEL.axis.mass
    assert result.gap.after < 0.6 * result.gap.before


def test_what_is_not_finite_is_null():
    result = cogging.diagnose(run(duration=3.0), MODEL)
    gap = result.gap.__class__("V", math.nan, math.inf, 0.0, None, None, "not measured")
    spoilt = cogging.Diagnosis(
        "no_gap", (), {"share": np.float64("nan"), "places": np.ones(2)}, gap, None, MODEL, MODEL
    )
    told = spoilt.to_dict()
    assert told["gap"]["floor"] is None
    assert told["gap"]["before"] is None
    assert told["unlisted"] == {"share": None, "places": [1.0, 1.0]}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    MODEL.write(tmp_path / "model.toml")
    run(effects.DisturbanceTone(frequency=17.0, sine=0.03), duration=3.0).write(tmp_path / "log.csv")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_command_writes_result_report_and_model(folder, capsys):
    call = ["diagnose", "log.csv", "--model", "model.toml", "--rows", "0:5000", "--json", "out.json"]
    assert main([*call, "--report", "out.html", "--out", "patched.toml"]) == 0
    said = capsys.readouterr()
    assert "disturbance_tone" in said.out
    assert "out.json, out.html, patched.toml written" in said.out
    told = json.loads((folder / "out.json").read_text())
    assert told["effects"][0]["name"] == "disturbance_tone"
    assert cogging.Model.read("patched.toml").effects[0].NAME == "disturbance_tone"
    page = (folder / "out.html").read_text()
    assert "disturbance tone" in page
    assert page.count("data:image/png;base64,") >= 2
    assert not re.findall(r"(?:src|href)=\"(?!data:|#)", page)  # nothing is loaded from elsewhere


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["log.csv", "--model", "model.toml", "--confirm", "gone.csv"], "gone.csv: cannot be read"),
        (["log.csv", "--model", "gone.toml"], "gone.toml: cannot be read"),
        (
            ["log.csv", "--model", "model.toml", "--rows", "0:100"],
            "rows: must be at least 500 to be diagnosed, got 100",
        ),
        (["log.csv", "--model", "model.toml", "--report", "out.json"], "must be different files"),
    ],
    ids=["confirm", "model", "rows", "twice"],
)
def test_a_bad_call_is_one_line_and_writes_nothing(arguments, message, folder, capsys):
    before = sorted(folder.iterdir())
    assert main(["diagnose", *arguments, "--json", "out.json"]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert message in said
    assert sorted(folder.iterdir()) == before


def test_a_report_without_its_library_says_what_to_install(found, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "jinja2", None)
    with pytest.raises(ValueError, match=r"a report needs jinja2: pip install 'cogging\[report\]'"):
        found.html()


def test_the_report_says_what_why_and_what_next(found):
    page = found.html(title="log <1>")
    assert "log &lt;1&gt;" in page
    for words in (
        "viscous asymmetry",
        "standard deviations out of the noise",
        "Check on other motion",
        "Before and after",
        "Everything that was tried in earnest",
        "effects.viscous_asymmetry.difference",
        "How to read this page",
    ):
        assert words in page, words
    assert len(found.plot().axes) == 6


# Where ----------------------------------------------------------------------------------------------------------------


def test_the_gap_is_located_without_a_name():
    located = cogging.locate_gap(run(effects.CoggingHarmonic(period=0.03, sine=0.03)), MODEL)
    (wave, *_) = located.waves
    assert wave.coordinate == "spatial period"
    assert wave.value == pytest.approx(0.03, rel=1e-2)
    assert wave.amplitude == pytest.approx(0.03, rel=0.1)
    assert "every 30" in located.text()
    json.dumps(located.to_dict(), allow_nan=False)
    located = cogging.locate_gap(run(effects.DisturbanceTone(frequency=17.0, sine=0.03)), MODEL)
    assert located.waves[0].coordinate == "frequency"
    assert "at 17" in located.text()
    assert len(located.plot().axes) == 6


def test_ranges_in_words():
    def shape(coordinate, unit, places, force):
        force = np.array(force)
        return Shape(coordinate, unit, None, np.array(places), force, np.full(force.size, 0.01), -50.0, 0.4)

    slow = shape("velocity", "m/s", [-0.2, -0.004, 0.0, 0.004, 0.2], [0.0, -0.5, 0.2, 0.5, 0.0])
    assert ranges(slow) == "within 4 mm/s of rest, both directions: +0.5 V forward, -0.5 V backward"
    fast = shape("velocity", "m/s", [-0.2, -0.01, 0.0, 0.01, 0.1, 0.2], [0.0, 0.0, 0.0, 0.0, 0.1, 0.3])
    assert ranges(fast) == "above 0.1 m/s, forward: +0.3 V"
    ends = shape("position", "m", [0.0, 0.1, 0.2], [0.3, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert ranges(ends) == "forward +0.3 V about 0 m"
    flat = shape("time", "s", [0.0, 1.0, 2.0], [0.0, 0.0, 0.0])
    assert ranges(flat) == "spread over its whole range, strong nowhere"
    assert [length_text(v) for v in (20e-6, 2.5e-3, 0.3)] == ["20 um", "2.5 mm", "0.3 m"]


def test_bands_hold_the_truth_and_the_spectrum_its_scale():
    rng = np.random.default_rng(0)
    inside = []
    for _ in range(200):
        block = np.repeat(np.arange(60), 50)
        gap = 0.3 + np.repeat(rng.normal(0.0, 1.0, 60), 50) + rng.normal(0.0, 0.1, 3000)
        _, mean, half = binned(rng.uniform(0.0, 1.0, 3000), gap, block.astype(float), np.linspace(0.0, 1.0, 5))
        inside.append(np.abs(mean - 0.3) < half)
    assert 0.9 < np.mean(inside) < 0.98  # rows of a block say the same; bands of single rows would hold 25 %
    frequency, density = spectrum(np.arange(20000) / 1000.0, rng.normal(0.0, 2.0, 20000))
    assert frequency[-1] == pytest.approx(500.0, rel=1e-2)
    assert np.sqrt(np.mean(density**2)) == pytest.approx(2.0 / np.sqrt(500.0), rel=0.05)


def test_a_profile_without_a_direction_says_so():
    time = np.arange(2000) / 1000.0
    series = {name: [np.linspace(0.0, 1.0, 2000)] for name in ("gap", "position", "acceleration", "command")}
    series |= {"time": [time], "velocity": [np.ones(2000)], "mask": [np.ones(2000, bool)]}
    figure = coordinates_figure({"one way": series})
    assert [text.get_text() for text in figure.axes[1].texts] == ["no such motion"]


def test_what_no_effect_explains_is_added_where_it_is_asked_for(tmp_path):
    """A magnetic strip under a part of the travel, say: a force that no law of the vocabulary has."""
    places = np.linspace(0.0, 0.51, 103)
    bump = 0.08 * np.exp(-(((places - 0.26) / 0.06) ** 2))
    hidden = effects.EmpiricalForce(position_nodes=list(places), position_forces=list(bump))
    logs, confirm = [run(hidden), run(hidden, velocity=0.1, seed=5)], other(hidden)
    result = cogging.diagnose(logs, MODEL, confirm=confirm, empirical=True)
    assert result.verdict == "unlisted"
    assert result.unlisted["coordinate"] == "position"
    told = result.unlisted["added"]
    assert told["name"] == "empirical_force"
    assert told["gap_after"] < 0.8 * told["gap_before"]
    assert told["confirm_after"] < 0.9 * told["confirm_before"]
    assert "empirical and names no cause" in result.text()
    assert "empirical and names no cause" in result.html()
    within = np.linspace(0.1, 0.38, 57)
    found = sum(effect.force_at(position=within) for effect in result.model.effects if hasattr(effect, "force_at"))
    assert np.corrcoef(found, np.interp(within, places, bump))[0, 1] > 0.95
    path = tmp_path / "patched.toml"
    result.model.write(path)
    again = cogging.Model.read(path)
    assert again.effects == result.model.effects
    assert len(run(*again.effects, duration=0.5)) > 500
    plain = cogging.diagnose(logs, MODEL, confirm=confirm)
    assert "added" not in plain.unlisted
    assert "empirical_force" not in [effect.NAME for effect in plain.model.effects]


def test_a_term_that_has_no_function_or_does_not_pay_is_not_added():
    log, confirm = run(effects.ConstantForce(force=0.02)), other(effects.ConstantForce(force=-0.02))
    found = search_logs([log], MODEL)
    with pytest.raises(NoTerm, match="no empirical term is a function of command: it is described, not added"):
        with_term(found, {"coordinate": "command", "places": [0.0, 1.0], "force": [0.0, 1.0]}, MODEL, [log], [])
    with pytest.raises(NoTerm, match="stands for bursts: they are described, not added"):
        with_term(found, {"coordinate": "time", "shape": "bursts"}, MODEL, [log], [])
    rest = {"coordinate": "time", "places": [0.0, 4.0], "force": [0.02, 0.02]}
    assert with_term(found, rest, MODEL, [log], [])[1]["gap_after"] < 0.01
    with pytest.raises(NoTerm, match="an empirical term does not pay: the gap grows"):
        with_term(found, rest, MODEL, [log], [confirm])
