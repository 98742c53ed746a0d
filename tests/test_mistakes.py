"""Mistakes: another type, a mistyped name in a file, an option or a call. One line says what was meant."""

import copy
import inspect
import random
import string
from unittest import mock

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from cogging.datasets import emps, laas, odrive
from cogging.outputs import to_toml
from cogging.shown import nearest, nearest_name
from tests.fixtures.examples import LOG, MODEL, MOVE, PLANT

CLASSES = sorted(name for name in cogging.__all__ if inspect.isclass(getattr(cogging, name)))
SINE = cogging.Sine(cogging.SineParameters())
MISTAKES = {
    "a plant for a model": (lambda: cogging.simulate(PLANT), r"simulate: model: .* got a Plant: closed_loop\(plant"),
    "a document": (lambda: cogging.simulate(MODEL.to_dict(), MOVE), r"simulate: model: .* Model\.from_dict makes"),
    "no such file": (lambda: cogging.simulate(MODEL, "ref"), r"ref: cannot be read: No such file"),
    "a motion's parameters": (
        lambda: cogging.simulate(MODEL, cogging.SineParameters()),
        r"simulate: reference: must be .* got a SineParameters: Sine\(parameters\) is the motion",
    ),
    "swapped": (lambda: cogging.diagnose(MODEL, LOG), r"diagnose: logs: .* a Model: the log comes before"),
    "no model": (lambda: cogging.identify(LOG), r"identify\(\) missing 1 required positional argument: 'model'"),
    "an array for a log": (
        lambda: cogging.identify(np.zeros((9, 3)), MODEL),
        r"identify: logs: .* got an array of shape \(9, 3\): Log\(time=\.\.\., position",
    ),
    "a dict for a log": (lambda: cogging.audit(LOG.columns()), r"audit: log: must be a Log, got a dict: Log\.of"),
    "a list with another": (lambda: cogging.identify([LOG, 3], MODEL), r"identify: logs: .*, got 3"),
    "a file for a log": (lambda: cogging.audit("a.csv"), r"audit: log: must be a Log, got 'a\.csv': read_log reads"),
    "a type of the core": (lambda: cogging.PidParameters(kp="1"), r"PidParameters: kp: must be a number, got '1'"),
    "by position": (lambda: cogging.PidParameters(1.0), r"PidParameters: must be given its arguments by keyword"),
    "nothing": (lambda: cogging.Pid(), r"Pid: parameters: must be given, got nothing"),
    "gains for a controller": (lambda: cogging.Pid(9600.0), r"Pid: parameters: must be a PidParameters, got 9600\.0"),
    "the class itself": (lambda: cogging.Pid(cogging.PidParameters), r"got the class PidParameters itself"),
    "a dict for an effect": (
        lambda: cogging.Plant(MODEL.axis, effects=[{"name": "cable_spring"}]),
        r"Plant: effects: must be a list, each an effect, got a list",
    ),
    "a dict for an axis": (lambda: cogging.Plant({"mass": 1}), r"Plant: axis: must be an AxisParameters, got a dict"),
    "two numbers": (
        lambda: cogging.AdaptiveRobustParameters(mass_bounds=[1.0]),
        r"AdaptiveRobustParameters: mass_bounds: must be 2 numbers, got a list: \[1\.0\]",
    ),
    "a fraction for a count": (
        lambda: cogging.SplineHarmonics(pitch=0.05, harmonics=[1.5]),
        r"SplineHarmonics: harmonics: must be a list of whole numbers, got a list: \[1\.5\]",
    ),
    "another basis": (
        lambda: cogging.CoggingModel(MODEL.axis, [[1.0]], [[1.0]]),
        r"CoggingModel: basis: must be a SplineHarmonics, got an AxisParameters",
    ),
    "a model for a plant": (
        lambda: cogging.closed_loop(MODEL, MODEL.make_controller(), SINE),
        r"closed_loop: plant: must be a Plant, got a Model: simulate\(model, reference\) runs one",
    ),
    "one controller for a batch": (
        lambda: cogging.closed_loop_batch([PLANT], MODEL.make_controller(), SINE),
        r"closed_loop_batch: controllers: must be a list, got a Pid",
    ),
    "something else in a batch": (
        lambda: cogging.closed_loop_batch([MODEL], [MODEL.make_controller()], SINE),
        r"closed_loop_batch: plants: must be a list, each a Plant, got a Model",
    ),
    "a time in words": (
        lambda: cogging.closed_loop_batch([PLANT], [MODEL.make_controller()], SINE, duration="1 s"),
        r"closed_loop_batch: duration: must be a number, got '1 s'",
    ),
    "gains of two controllers": (
        lambda: cogging.closed_loop(PLANT, cogging.AdaptiveRobustParameters(), SINE),
        r"controller: must be Arc or Dcarc with these parameters, got AdaptiveRobustParameters alone",
    ),
    "gains of two types": (
        lambda: cogging.Model(MODEL.axis, controller=cogging.AdaptiveRobustParameters()),
        r"controller_type: must be arc or dcarc with AdaptiveRobustParameters, got None",
    ),
    "gains of another type": (
        lambda: MODEL.replace(controller=cogging.SpeedParameters(), controller_type="pid"),
        r"controller_type: must be speed with SpeedParameters, got 'pid'",
    ),
    "a controller for its gains": (
        lambda: cogging.Model(MODEL.axis, controller=MODEL.make_controller()),
        r"controller: must be the parameters of one of .* got Pid: give its \.parameters",
    ),
    "a row of a log": (lambda: LOG[3], r"Log: rows: must be a slice such as log\[100:200\], .* got 3"),
    "a shown progress": (lambda: cogging.identify(LOG, MODEL, progress="yes"), r"progress: must be True, False or a"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_told_in_one_line(name):
    call, message = MISTAKES[name]
    with pytest.raises((TypeError, ValueError), match=message) as caught:
        call()
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize("name", sorted(name for name in CLASSES if hasattr(getattr(cogging, name), "FIELDS")))
def test_every_mistyped_field_is_told_with_the_one_meant(name):
    kind = getattr(cogging, name)
    for field in kind.FIELDS:
        if len(field) < 4:
            continue
        typed = field[:2] + field[3:]
        if typed in kind.FIELDS:
            continue
        with pytest.raises(TypeError, match=rf"^{name}: {typed}: is not an argument; did you mean \w+\?$"):
            kind(**{typed: 1.0})


# Mistyped names -------------------------------------------------------------------------------------------------------

SINE_MOTION = {"type": "sine", "amplitude": 0.02, "duration": 1.0}
LIMITS = {"velocity": 0.3, "acceleration": 5.0, "duration": 3.0}
DOCUMENT = MODEL.to_dict()


def renamed(section, key, wrong):
    document = copy.deepcopy(DOCUMENT)
    document[section][wrong] = document[section].pop(key)
    return document


def effect(**fields):
    return {**DOCUMENT, "effects": [fields]}


#: What is typed in Python, and the name that is meant.
CALLS = {
    "a section": (lambda: cogging.Model.from_dict({**DOCUMENT, "encodr": {}}), "encoder"),
    "a needed key": (lambda: cogging.Model.from_dict(renamed("axis", "mass", "masss")), "mass"),
    "a key of the controller": (lambda: cogging.Model.from_dict(renamed("controller", "kp", "kpp")), "kp"),
    "a key that is needed": (lambda: cogging.Model.from_dict(renamed("controller", "type", "typ")), "type"),
    "a type of controller": (
        lambda: cogging.Model.from_dict({**DOCUMENT, "controller": {"type": "cascde", "sample_rate": 1e3}}),
        "cascade",
    ),
    "an effect": (lambda: cogging.Model.from_dict(effect(name="cabel_spring")), "cable_spring"),
    "an effect's field": (lambda: cogging.Model.from_dict(effect(name="cable_spring", stifness=1.0)), "stiffness"),
    "a unit": (lambda: cogging.Model.from_dict({**DOCUMENT, "units": {"comand": "A"}}), "command"),
    "an uncertainty": (
        lambda: cogging.Model.from_dict({**DOCUMENT, "axis": {**DOCUMENT["axis"], "uncertainty": {"viscos": 0.1}}}),
        "viscous",
    ),
    "the name of an effect": (lambda: cogging.Model.from_dict(effect(nam="cable_spring", stiffness=1.0)), "name"),
    "the type of a motion": (lambda: cogging.simulate(MODEL, {"typ": "sine", "duration": 1.0}), "type"),
    "a motion": (lambda: cogging.simulate(MODEL, {**SINE_MOTION, "type": "sines"}), "sine"),
    "a motion's field": (lambda: cogging.simulate(MODEL, {**SINE_MOTION, "amplitud": 1.0}), "amplitude"),
    "a parameter": (lambda: cogging.AxisParameters(mas=1.0), "mass"),
    "a changed parameter": (lambda: MODEL.axis.replace(mass=1.0, viscuos=1.0), "viscous"),
    "an attribute of a model": (lambda: MODEL.replace(encoders=1), "encoder"),
    "a column of a log": (lambda: cogging.Log(time=[0, 1], positon=[0, 1], command=[0, 1]), "position"),
    "a free parameter": (lambda: cogging.identify(LOG, MODEL, free=["axis.viscos"]), "axis.viscous"),
    "the end of its path": (lambda: cogging.identify(LOG, MODEL, free=["viscous"]), "axis.viscous"),
    "a keyword": (lambda: cogging.simulate(MODEL, MOVE, sed=1), "seed"),
    "a field of a class": (lambda: cogging.Model(axis=MODEL.axis, efects=[]), "effects"),
    "an argument": (lambda: cogging.diagnose(LOG, MODEL, comfirm=[LOG]), "confirm"),
    "an argument of a plain function": (lambda: cogging.pid_gains([-1.0] * 3, mas=1.0), "mass"),
    "a paper": (lambda: cogging.reproduce("lu208"), "lu2008"),
    "a varied path": (lambda: cogging.sweep(MODEL, SINE_MOTION, {"axis.mas": [1.0, 2.0]}), "axis.mass"),
    "a limit of a motion": (lambda: cogging.MotionLimits(velocty=1.0), "velocity"),
    "a limit of tuning": (lambda: cogging.tune(MODEL, SINE_MOTION, limits={"comand_max": 1.0}), "command_max"),
    "a predicted controller": (lambda: cogging.predict_error(MODEL, SINE_MOTION, controllers=["cascad"]), "cascade"),
    "a goal": (lambda: cogging.plan_experiment(MODEL, limits=cogging.MotionLimits(**LIMITS), goal="detct"), "detect"),
    "a log of a set": (lambda: emps.read("DATA_EMP"), "DATA_EMPS"),
    "a log of another": (lambda: laas.read("stoped_data"), "stopped_data"),
    "a scan": (lambda: odrive.scan("forwards"), "forward"),
    "a quantity": (lambda: cogging.effects.Parameter(1.0, quantity="forc"), "force"),
    "a fitted parameter": (lambda: cogging.identify(LOG, MODEL, free=["axis.mass"])["axis.mas"], "axis.mass"),
}


@pytest.mark.parametrize("name", CALLS)
def test_a_mistyped_name_in_python(name):
    call, meant = CALLS[name]
    with pytest.raises((ValueError, TypeError, KeyError)) as refused:
        call()
    said = str(refused.value)
    assert "\n" not in said
    assert f"did you mean {meant}?" in said or f"(did you mean '{meant}'?)" in said, said


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    LOG.write("log.csv")
    MODEL.write("model.toml")
    files = {
        "sine.toml": SINE_MOTION,
        "key.toml": renamed("axis", "coulomb", "columb"),
        "reference.toml": {**SINE_MOTION, "frequncy": 1.0},
        "limits.toml": {**LIMITS, "acceleraton": 1.0},
        "sweep.toml": {"model": "model.toml", "reference": "sine.toml", "vari": {"axis.mass": [1.0, 2.0]}},
        "tune.toml": {"model": "model.toml", "reference": "sine.toml", "limits": {"comand_max": 1.0}},
    }
    for name, document in files.items():
        (tmp_path / name).write_text(to_toml(document))
    return tmp_path


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        ("audit log.csv --model key.toml", "coulomb"),
        ("audit log.csv --columns positon=x", "position"),
        ("audit log.csv --scale comand=2", "command"),
        ("audit log.csv --zero positon=2", "position"),
        ("audit log.csv --columns position=postion", "position"),
        ("audit log.csv --scale log.cvs:command=2", "log.csv"),
        ("init log.csv --out x.toml --reference y.toml --columns position=postion", "position"),
        ("identify log.csv --model model.toml --free axis.mas", "axis.mass"),
        ("simulate model.toml --reference reference.toml --out x.csv", "frequency"),
        ("experiment --model model.toml --limits limits.toml --out x.toml", "acceleration"),
        ("sweep sweep.toml --out x.parquet", "vary"),
        ("tune tune.toml --out x.toml", "command_max"),
    ],
)
def test_a_mistyped_name_on_the_command_line(words, meant, folder, capsys):
    before = sorted(folder.iterdir())
    assert main(words.split()) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert f"did you mean {meant}?" in said or f"(did you mean '{meant}'?)" in said, said
    assert sorted(folder.iterdir()) == before


def test_where_nothing_is_near_nothing_is_guessed():
    with pytest.raises(ValueError, match=r"got 'banana'$"):
        cogging.reproduce("banana")
    with pytest.raises(ValueError, match=r"banana") as refused:
        cogging.identify(LOG, MODEL, free=["banana"])
    assert "did you mean" not in str(refused.value)


# The nearest name -----------------------------------------------------------------------------------------------------

WORDS = sorted({field for effect in cogging.EFFECTS.values() for field in (effect.NAME, *effect.FIELDS)})
WORDS = [name for name in WORDS if len(name) > 5]
PATHS = ["axis.mass", "axis.viscous", "axis.coulomb", "axis.coulomb_width", "cogging.sine[0][1]", "encoder.resolution"]
OPTIONS = ["--columns", "--scale", "--rows", "--zero", "--model", "--out", "--json", "--confirm"]


def slip(name, draw):
    """A name with one letter left out, doubled, beside its place, or replaced; or capitals, or hyphens."""
    at = draw.randrange(1, len(name) - 1)
    start, letter, rest = name[:at], name[at], name[at + 1 :]
    changed = [rest, letter + letter + rest, rest[:1] + letter + rest[1:], draw.choice(string.ascii_lowercase) + rest]
    return draw.choice([*(start + end for end in changed), name.upper(), name.replace("_", "-")])


@pytest.mark.parametrize("names", [WORDS, PATHS, OPTIONS], ids=["fields", "paths", "options"])
def test_a_slip_is_understood(names):
    draw = random.Random(19)
    right = [nearest_name(slip(name, draw), names) == name for name in names for _ in range(10)]
    assert sum(right) > 0.97 * len(right)


@pytest.mark.parametrize("word", ["banana", "x", "", "qm", "temperature", "zzz", "\x1b[31m", "1e-3", "torque", "Zeit"])
def test_another_word_is_not_guessed_at(word):
    assert nearest(word, WORDS) == nearest(word, PATHS) == nearest(word, OPTIONS) == ""


def test_the_end_of_a_message():
    assert nearest("mas", ["mass", "viscous"]) == " (did you mean 'mass'?)"
    assert nearest("mass", PATHS) == " (did you mean 'axis.mass'?)"
    assert nearest("pos", ["position", "command"]) == " (did you mean 'position'?)"  # the beginning of one alone
    assert nearest("ref", ["reference", "reference_velocity"]) == ""
    assert nearest("mass", []) == ""


def test_names_without_end_are_not_compared():
    """A header of many columns and a name of a megabyte: found by the attack, which waited for a minute."""
    many = [*(f"column_{number}" for number in range(16_384)), "x" * 100_000]
    with mock.patch("difflib.SequenceMatcher.find_longest_match", side_effect=AssertionError("compared")):
        assert nearest_name("x" * 100_000, many) is None
    assert nearest_name("x" * 200, ["x" * 199, "time"]) == "x" * 199
    assert nearest_name("colunm_777", many) == "column_777"
