"""Mistakes: another type, a mistyped name. One line says what was meant; of commands: cli/test_refused_calls.py."""

import argparse
import copy
import inspect
import sys

import numpy as np
import pytest

import cogging
from cogging.cli import completion
from cogging.datasets import emps, laas, odrive
from cogging.shown import nearest_name
from tests.fixtures.examples import EXAMPLES, LOG, MODEL, MOVE, PLANT

SINE = cogging.Sine(cogging.SineParameters())
#: Calls that take one thing for another, and what the one line says of it.
MISTAKES = {
    "a plant for a model": (lambda: cogging.simulate(PLANT), r"simulate: model: .* got a Plant: closed_loop\(plant"),
    "a document": (lambda: cogging.simulate(MODEL.to_dict(), MOVE), r"simulate: model: .* Model\.from_dict makes"),
    "no such file": (lambda: cogging.simulate(MODEL, "ref"), r"ref: cannot be read: No such file"),
    "a struct": (lambda: cogging.simulate(MODEL, cogging.SineParameters()), r"reference: .*Sine\(parameters\) is the"),
    "swapped": (lambda: cogging.diagnose(MODEL, LOG), r"diagnose: logs: .* a Model: the log comes before"),
    "no model": (lambda: cogging.identify(LOG), r"identify\(\) missing 1 required positional argument: 'model'"),
    "an array": (lambda: cogging.identify(np.zeros((9, 3)), MODEL), r"logs: .* shape \(9, 3\): Log\(time=\.\.\., posi"),
    "a list with another": (lambda: cogging.identify([LOG, 3], MODEL), r"identify: logs: .*, got 3"),
    "a list with nothing in it": (lambda: cogging.identify([LOG, None], MODEL), r"identify: logs: .*, got None"),
    "a file for a log": (lambda: cogging.audit("a.csv"), r"audit: log: must be a Log, got 'a\.csv': read_log reads"),
    "a text for a number": (lambda: cogging.PidParameters(kp="1"), r"PidParameters: kp: must be a number, got '1'"),
    "by position": (lambda: cogging.PidParameters(1.0), r"PidParameters: must be given its arguments by keyword"),
    "nothing": (lambda: cogging.Pid(), r"Pid: parameters: must be given, got nothing"),
    "gains for a controller": (lambda: cogging.Pid(9600.0), r"Pid: parameters: must be a PidParameters, got 9600\.0"),
    "the class itself": (lambda: cogging.Pid(cogging.PidParameters), r"got the class PidParameters itself"),
    "a dict": (lambda: cogging.Plant(MODEL.axis, effects=[{}]), r"effects: must be a list, each an effect"),
    "a share": (lambda: cogging.SplineHarmonics(harmonics=[1.5]), r"harmonics: must be a list of whole numbers, got"),
    "a model for a plant": (
        lambda: cogging.closed_loop(MODEL, MODEL.make_controller(), SINE),
        r"closed_loop: plant: must be a Plant, got a Model: simulate\(model, reference\) runs one",
    ),
    "one for a batch": (
        lambda: cogging.closed_loop_batch([PLANT], MODEL.make_controller(), SINE),
        r"closed_loop_batch: controllers: must be a list, got a Pid",
    ),
    "gains of two controllers": (
        lambda: cogging.closed_loop(PLANT, cogging.AdaptiveRobustParameters(), SINE),
        r"controller: must be Arc or Dcarc with these parameters, got AdaptiveRobustParameters alone",
    ),
    "gains of another type": (
        lambda: MODEL.replace(controller=cogging.SpeedParameters(), controller_type="pid"),
        r"controller_type: must be speed with SpeedParameters, got 'pid'",
    ),
    "a row of a log": (lambda: LOG[3], r"Log: rows: must be a slice such as log\[100:200\], .* got 3"),
    "a shown progress": (lambda: cogging.identify(LOG, MODEL, progress="yes"), r"progress: must be True, False or a"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_one_line(name):
    call, message = MISTAKES[name]
    with pytest.raises((TypeError, ValueError), match=message) as caught:
        call()
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300


#: What needs a library, and the extra that brings it.
EXTRAS = {
    "pandas": ("frames", lambda: [EXAMPLES[name].to_frame() for name in ("Log", "SweepRuns", "Batch", "Diagnosis")]),
    "xarray": ("frames", lambda: EXAMPLES["SweepRuns"].to_xarray()),
    "pyarrow": ("parquet", lambda: EXAMPLES["SweepRuns"].write("runs.parquet")),
    "optuna": ("tune", lambda: cogging.tune(MODEL, MOVE, {"controller.kp": {"from": 500, "to": 5000}})),
    "control": ("control", lambda: MODEL.to_control()),
    "cvxpy": ("design", lambda: cogging.design_observer(EXAMPLES["ObserverProblem"])),
    "shtab": ("completion", lambda: completion.run(argparse.Namespace())),
}


@pytest.mark.parametrize("name", EXTRAS)
def test_a_missing_library_is_named_with_its_extra(name, tmp_path, monkeypatch):
    extra, call = EXTRAS[name]
    monkeypatch.chdir(tmp_path)
    for module in (name, f"{name}.parquet"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ImportError, match=rf"^{name} is [^\n]*: pip install 'cogging\[{extra}\]'$"):
        call()
    assert list(tmp_path.iterdir()) == []


# Mistyped names -------------------------------------------------------------------------------------------------------

DOCUMENT = MODEL.to_dict()
SINE_MOTION = {"type": "sine", "amplitude": 0.02, "duration": 1.0}
LIMITS = {"velocity": 0.3, "acceleration": 5.0, "duration": 3.0}


def mistyped(name):
    """The name without its third letter."""
    return name[:2] + name[3:]


def assert_meant(call, meant):
    with pytest.raises((ValueError, TypeError, KeyError)) as refused:
        call()
    text = str(refused.value)
    assert "\n" not in text
    assert f"did you mean {meant}?" in text or f"(did you mean '{meant}'?)" in text, text


def test_a_mistyped_argument_of_any_class_or_function():
    called = [getattr(cogging, name) for name in cogging.__all__ if callable(getattr(cogging, name))]
    called = [one for one in called if inspect.isfunction(one)] + [one for one in called if hasattr(one, "FIELDS")]
    assert len(called) > 40
    for one in called:
        parameters = inspect.signature(one).parameters.values()
        needed = [None for parameter in parameters if parameter.kind != parameter.KEYWORD_ONLY]
        for name in getattr(one, "FIELDS", [parameter.name for parameter in parameters][len(needed) :]):
            if len(name) > 3 and mistyped(name) not in inspect.signature(one).parameters:
                given = () if hasattr(one, "FIELDS") else needed
                assert_meant(lambda one=one, given=given, name=name: one(*given, **{mistyped(name): 1.0}), name)


def test_a_mistyped_key_of_a_model():
    for section in ("axis", "cogging", "encoder", "noise", "controller"):
        without = {name: fields for name, fields in DOCUMENT.items() if name != section}
        if section != "axis":
            misnamed = without | {mistyped(section): {}}
            assert_meant(lambda misnamed=misnamed: cogging.Model.from_dict(misnamed), section)
        for key in (key for key in DOCUMENT[section] if len(key) > 3 and key != "uncertainty"):
            fields = {name: value for name, value in DOCUMENT[section].items() if name != key}
            misnamed = without | {section: fields | {mistyped(key): DOCUMENT[section][key]}}
            assert_meant(lambda misnamed=misnamed: cogging.Model.from_dict(copy.deepcopy(misnamed)), key)


#: What is typed in Python, and the name that is meant.
CALLS = {
    "cascade": lambda: cogging.Model.from_dict({**DOCUMENT, "controller": {"type": "cascde", "sample_rate": 1e3}}),
    "cable_spring": lambda: cogging.Model.from_dict({**DOCUMENT, "effects": [{"name": "cabel_spring"}]}),
    "command": lambda: cogging.Model.from_dict({**DOCUMENT, "units": {"comand": "A"}}),
    "sine": lambda: cogging.simulate(MODEL, {**SINE_MOTION, "type": "sines"}),
    "coulomb": lambda: MODEL.axis.replace(mass=1.0, coulom=1.0),
    "encoder": lambda: MODEL.replace(encoders=1),
    "position": lambda: cogging.Log(time=[0, 1], positon=[0, 1], command=[0, 1]),
    "lu2008": lambda: cogging.reproduce("lu208"),
    "command_max": lambda: cogging.tune(MODEL, SINE_MOTION, limits={"comand_max": 1.0}),
    "cascade of predict": lambda: cogging.predict_error(MODEL, SINE_MOTION, controllers=["cascad"]),
    "detect": lambda: cogging.plan_experiment(MODEL, limits=cogging.MotionLimits(**LIMITS), goal="detct"),
    "DATA_EMPS": lambda: emps.read("DATA_EMP"),
    "stopped_data": lambda: laas.read("stoped_data"),
    "forward": lambda: odrive.scan("forwards"),
    "force": lambda: cogging.effects.Parameter(1.0, quantity="forc"),
}


@pytest.mark.parametrize("meant", CALLS)
def test_a_mistyped_name_in_python(meant):
    assert_meant(CALLS[meant], meant.partition(" ")[0])


def test_another_word_is_not_guessed_at():
    fields = {field for effect in cogging.EFFECTS.values() for field in (effect.NAME, *effect.FIELDS)}
    for word in ("banana", "x", "", "qm", "temperature", "zzz", "\x1b[31m", "1e-3", "Zeit"):
        assert nearest_name(word, sorted(fields)) is None
