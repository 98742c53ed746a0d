"""What the drawn calls of `python -m tests.attack bindings` found, and what no longer happens."""

import copy
import itertools
import pickle

import numpy as np
import pytest

import cogging
from cogging.estimation.force_balance import ForceBalance
from cogging.estimation.innovations import Innovations
from tests.attack import watched
from tests.attack.binding_values import Pool
from tests.attack.bindings import run_case
from tests.fixtures import command_files
from tests.fixtures.covering import covering

POOL = Pool()
UNPICKLED = {"CompiledController", "Predictor", "Prediction", "StopFlag"}


def test_pickles_of_every_protocol():
    """Protocols 0 and 1 made a bare object of the bindings' library, which ended the process."""
    for (name, value), protocol in itertools.product(POOL.items(), range(pickle.HIGHEST_PROTOCOL + 1)):
        if name in UNPICKLED:
            with pytest.raises(TypeError, match="cannot pickle"):
                pickle.dumps(value, protocol)
        else:
            again = pickle.loads(pickle.dumps(value, protocol))
            assert type(again) is type(value)
            assert again == value
            assert copy.deepcopy(value) == value


NO_NUMBERS = {
    "True in a list": [True, 2.0],
    "False in an inner list": [[1.0], [False]],
    "truth values": np.array([True, False]),
    "texts of digits": np.array(["1", "2"]),
    "digits in a list": ["1.5", "2"],
    "an object": np.array([1.0, True], dtype=object),
    "bytes": [b"1", b"2"],
}
TAKES_NUMBERS = {
    "array of the core": lambda values: cogging.performance([0.0, 1.0], values, [0.0, 1.0]),
    "list of the core": lambda values: cogging.SplineHarmonics(pitch=0.05, harmonics=[1], periods=values),
    "method of the core": lambda values: POOL["CableSpring"].force_at(position=values),
    "field": lambda values: cogging.ObserverBasedParameters(periods=values),
    "log": lambda values: cogging.Log(time=[0.0, 1.0], position=values, command=[0.0, 1.0]),
    "scan": lambda values: cogging.fit_map(values, [0.0, 1.0], pitch=0.05),
    "added command": lambda values: cogging.closed_loop(
        POOL["Plant"], POOL["Pid"], POOL["Sampled"], duration=1e-3, added_command=values
    ),
}


@pytest.mark.parametrize(("where", "what"), covering(TAKES_NUMBERS, NO_NUMBERS, rounds=2))
def test_truth_values_and_texts_within_arrays_are_no_numbers(where, what):
    with pytest.raises(
        (TypeError, ValueError), match=r"must be .*numbers?, got (True$|a list: |.* among them|bool|<U1|\|S1)"
    ):
        TAKES_NUMBERS[where](NO_NUMBERS[what])


CONTROLLERS = sorted(name for name, value in POOL.items() if hasattr(value, "command"))


def steps(name, value):
    """Every place of a controller's step that holds a number, with this one in it."""
    controller, point = copy.copy(POOL[name]), [0.01, 0.0, 0.0]
    ahead = {"ahead": point} if hasattr(controller, "preview") else {}
    yield lambda: controller.command(reference=point, reading=value, **ahead)
    for place in range(3):
        given = [*point[:place], value, *point[place + 1 :]]
        yield lambda given=given: controller.command(reference=given, reading=0.0, **ahead)
    if ahead:
        yield lambda: controller.command(reference=point, ahead=[value, 0.0, 0.0], reading=0.0)
    elif name != "CompiledController":
        for field in ("reference", "reference_velocity", "reference_acceleration"):
            yield lambda field=field: controller.command(**({"reference": 0.0, "reading": 0.0} | {field: value}))
    yield lambda: controller.update(value)


@pytest.mark.parametrize("value", [True, np.True_, np.array(True), "1", b"1", np.array("1"), None, 1j])
def test_what_is_no_number_is_none_in_a_controllers_step(value):
    for step in (step for name in CONTROLLERS for step in steps(name, value)):
        with pytest.raises(
            TypeError, match=r"must be given real numbers, got |incompatible function arguments"
        ) as caught:
            step()
        assert isinstance(value, np.ndarray) or "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", [float, np.float32, np.int16, np.uint8, int])
def test_numbers_of_any_kind_are_numbers(kind):
    values = [kind(1), kind(2)]
    for made in (values, np.array(values), np.array(values, dtype=object)):
        assert cogging.performance([0.0, 1.0], made, [0.0, 1.0]).error_max == 2.0
        assert cogging.Log(time=[0.0, 1.0], position=made, command=[0.0, 1.0]).position[1] == 2.0
    assert cogging.AxisParameters(mass=kind(2)).mass == 2.0
    for name in CONTROLLERS:
        assert [step() for step in steps(name, kind(0))] == [step() for step in steps(name, 0.0)]


def test_truth_values_are_no_counts():
    model, reference = command_files.model(), command_files.REFERENCE
    for field, call in (
        ("seed", lambda **count: cogging.simulate(model, reference, **count)),
        ("seed", lambda **count: cogging.predict_error(model, reference, samples=2, **count)),
        ("threads", lambda **count: cogging.sweep(model, reference, {"axis.mass": [0.1]}, duration=0.01, **count)),
    ):
        call(**{field: np.int64(1)})
        with pytest.raises((TypeError, ValueError), match=rf"{field}: must be a whole number.*, got True"):
            call(**{field: True})


@pytest.mark.parametrize("in_lanes", [False, True])
@pytest.mark.parametrize("where", ["command_delay.delay", "controller.delay"])
def test_a_delay_as_long_as_the_run_is_refused(where, in_lanes):
    """0.1 s of 1000 Hz; a delay of one sample less is a run, whose command acts in its last sample alone."""
    move = cogging.Sine(cogging.SineParameters(center=0.1, amplitude=0.01, frequency=2.0))

    def run(delay):
        of_machine, of_controller = (delay, 0.0) if where.startswith("command") else (0.0, delay)
        axis = cogging.AxisParameters(mass=0.1, coulomb_width=1e-3)
        plant = cogging.Plant(axis, effects=[cogging.effects.CommandDelay(delay=of_machine)])
        controller = cogging.Speed(cogging.SpeedParameters(kp=1.0, delay=of_controller))
        if not in_lanes:
            return cogging.closed_loop(plant, controller, move, duration=0.1)
        return cogging.closed_loop_batch([plant] * 8, [controller] * 8, move, duration=0.1, threads=1, logs=True)[7]

    moved = run(0.099).true_position
    assert (moved[:100] == moved[0]).all()
    for delay in (0.1, 5.0):
        with pytest.raises(ValueError, match=rf"{where}: must be shorter than the run of 0.1 s, got {delay:g}$"):
            run(delay)


def test_a_time_below_zero_counts_from_its_first_row():
    model = command_files.model()
    log = cogging.Log.of(cogging.simulate(model, command_files.REFERENCE, seed=1).columns())
    later = cogging.Log.of({**log.columns(), "time": log.time - 5.0})
    assert "time begins at -5 s: times of effects count from the first row" in cogging.audit(later).text()
    assert "time begins" not in cogging.audit(log).text()
    pushed = model.replace(effects=[cogging.effects.DisturbanceStep(force=0.2, start=0.1, stop=0.2)])
    for residual in (
        lambda one, of: Innovations(one, of).predictor.predict(of.plant()).position,
        lambda one, of: ForceBalance(one, cutoff=40.0).of([of])[0],
    ):
        first, shifted, without = residual(log, pushed), residual(later, pushed), residual(log, model)
        size = np.abs(first - without).max()
        assert size > 0.0
        assert np.abs(shifted - first).max() < 1e-6 * size


def test_drawn_calls_end_as_they_should():
    """A few of those that the attack makes, in this process; the whole of it watches its processes from outside."""
    assert {seed: found for seed in range(30) if (found := run_case(seed))} == {}


def test_the_attack_itself_sees_what_it_is_to_see(tmp_path, monkeypatch):
    """A crash, a hang cut short, a traceback and nonsense are each counted; what ends well is not."""
    (tmp_path / "cases.py").write_text(
        "import os, time\n"
        "def run_case(seed):\n"
        "    if seed == 3: os.abort()\n"
        "    if seed == 5: time.sleep(1000)\n"
        "    if seed == 7: raise RuntimeError('inside')\n"
        "    return 'nonsense accepted' if seed == 9 else None\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(watched, "HANG", 0.5)
    tally = watched.attack("cases", range(10))
    assert (tally.cases, tally.crashes, tally.hangs, sorted(tally.faults)) == (10, [3], [5], [7, 9])
