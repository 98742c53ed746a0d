"""A mistyped name is answered with the nearest right one, wherever a user types one: in files, options and calls."""

import copy

import pytest

import cogging
from cogging.cli.main import main
from cogging.datasets import emps, laas, odrive
from cogging.outputs import to_toml
from tests.fixtures.pid_axis import MODEL, run

SINE = {"type": "sine", "amplitude": 0.02, "duration": 1.0}
LIMITS = {"velocity": 0.3, "acceleration": 5.0, "duration": 3.0}
DOCUMENT = MODEL.to_dict()
LOG = run(duration=1.0)


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
    "a motion": (lambda: cogging.simulate(MODEL, {**SINE, "type": "sines"}), "sine"),
    "a motion's field": (lambda: cogging.simulate(MODEL, {**SINE, "amplitud": 1.0}), "amplitude"),
    "a parameter": (lambda: cogging.AxisParameters(mas=1.0), "mass"),
    "a changed parameter": (lambda: MODEL.axis.replace(mass=1.0, viscuos=1.0), "viscous"),
    "an attribute of a model": (lambda: MODEL.replace(encoders=1), "encoder"),
    "a column of a log": (lambda: cogging.Log(time=[0, 1], positon=[0, 1], command=[0, 1]), "position"),
    "a free parameter": (lambda: cogging.identify(LOG, MODEL, free=["axis.viscos"]), "axis.viscous"),
    "the end of its path": (lambda: cogging.identify(LOG, MODEL, free=["viscous"]), "axis.viscous"),
    "an argument": (lambda: cogging.diagnose(LOG, MODEL, comfirm=[LOG]), "confirm"),
    "an argument of a plain function": (lambda: cogging.pid_gains([-1.0] * 3, mas=1.0), "mass"),
    "a paper": (lambda: cogging.reproduce("lu208"), "lu2008"),
    "a varied path": (lambda: cogging.sweep(MODEL, SINE, {"axis.mas": [1.0, 2.0]}), "axis.mass"),
    "a limit of a motion": (lambda: cogging.MotionLimits(velocty=1.0), "velocity"),
    "a limit of tuning": (lambda: cogging.tune(MODEL, SINE, limits={"comand_max": 1.0}), "command_max"),
    "a predicted controller": (lambda: cogging.predict_error(MODEL, SINE, controllers=["cascad"]), "cascade"),
    "a goal": (lambda: cogging.plan_experiment(MODEL, limits=cogging.MotionLimits(**LIMITS), goal="detct"), "detect"),
    "a log of a set": (lambda: emps.read("DATA_EMP"), "DATA_EMPS"),
    "a log of another": (lambda: laas.read("stoped_data"), "stopped_data"),
    "a scan": (lambda: odrive.scan("forwards"), "forward"),
    "a quantity": (lambda: cogging.effects.Parameter(1.0, quantity="forc"), "force"),
    "a fitted parameter": (lambda: cogging.identify(LOG, MODEL, free=["axis.mass"])["axis.mas"], "axis.mass"),
}


@pytest.mark.parametrize("name", CALLS)
def test_in_python(name):
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
        "sine.toml": SINE,
        "key.toml": renamed("axis", "coulomb", "columb"),
        "reference.toml": {**SINE, "frequncy": 1.0},
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
def test_on_the_command_line(words, meant, folder, capsys):
    before = sorted(folder.iterdir())
    assert main(words.split()) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert f"did you mean {meant}?" in said or f"(did you mean '{meant}'?)" in said, said
    assert sorted(folder.iterdir()) == before


def test_where_nothing_is_near_nothing_is_guessed():
    with pytest.raises(ValueError, match=r"got 'banana'$"):
        cogging.reproduce("banana")
    with pytest.raises(ValueError, match=r"axis\.coulomb_width$"):
        cogging.identify(LOG, MODEL, free=["banana"])
