"""Mistakes of a Python user: a mistyped keyword, another type, an unknown key. One line says what was meant."""

import inspect

import numpy as np
import pytest

import cogging
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
    "a keyword": (
        lambda: cogging.simulate(MODEL, MOVE, sed=1),
        r"simulate: sed: is not an argument.* did you mean seed",
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
    "a field of a class": (
        lambda: cogging.Model(axis=MODEL.axis, efects=[]),
        r"Model: efects: is not an argument; did you mean effects\?",
    ),
    "a field of the core": (lambda: cogging.PidParameters(kpp=1), r"PidParameters: kpp: is not .* did you mean kp\?"),
    "a type of the core": (lambda: cogging.PidParameters(kp="1"), r"PidParameters: kp: must be a number, got '1'"),
    "by position": (lambda: cogging.PidParameters(1.0), r"PidParameters: must be given its arguments by keyword"),
    "nothing": (lambda: cogging.Pid(), r"Pid: parameters: must be given, got nothing"),
    "gains for a controller": (lambda: cogging.Pid(9600.0), r"Pid: parameters: must be a PidParameters, got 9600\.0"),
    "the class itself": (lambda: cogging.Pid(cogging.PidParameters), r"got the class PidParameters itself"),
    "an effect's field": (
        lambda: cogging.effects.CableSpring(stifness=1.0),
        r"CableSpring: stifness: is not an argument; did you mean stiffness\?",
    ),
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
