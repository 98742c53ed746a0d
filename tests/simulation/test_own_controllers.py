"""Controllers in Python or compiled where one of the core is expected, and the one line for what is wrong with them."""

import copy
import ctypes
import functools
import gc
import re
import threading
import traceback
from types import SimpleNamespace

import numpy as np
import pytest

import cogging
from tests.fixtures import pid_axis
from tests.fixtures.log_columns import columns_of

RATE = 5000.0
MODEL = pid_axis.MODEL.replace(controller=None, controller_type=None, uncertainty={})
MODEL = MODEL.replace(encoder=MODEL.encoder.replace(noise=2e-7))
PLANT = MODEL.plant()
MOVE = cogging.PointToPoint(
    cogging.PointToPointParameters(start=0.05, distance=0.2, velocity=0.5, acceleration=10.0, jerk=1000.0)
)


class Proportional:
    """The least that a controller is."""

    sample_rate = RATE

    def __init__(self, gain=9600.0):
        self.gain = gain

    def command(self, reference, reading):
        return self.gain * (reference.position - reading)


class OwnPid:
    """Pid line by line, for readings that are numbers."""

    def __init__(self, parameters):
        self.q = parameters
        self.sample_rate, self.command_limit = parameters.sample_rate, parameters.command_limit
        self.reset()

    def reset(self):
        self.total = self.step = self.computed = 0.0
        self.last = None

    def command(self, reference, reading):
        q, (x, v, a), last = self.q, reference, self.last
        measured = 0.0 if last is None else (reading - last[1]) * q.sample_rate
        velocity = measured if q.feedforward_velocity == "measured" else v
        forward = q.mass * a + q.viscous * velocity
        forward += q.coulomb * cogging._core.smooth_sign(velocity, q.coulomb_width)
        error = reading - x
        self.step = error * (1.0 / q.sample_rate)
        rate = (0.0 if last is None else error - last[0]) / (1.0 / q.sample_rate)
        self.total += self.step
        self.computed = forward - q.kp * error - q.ki * self.total - q.kd * rate
        self.last = error, reading
        return self.computed

    def update(self, applied):
        if (self.computed - applied) * self.step < 0.0:
            self.total -= self.step


GAINS, STATE = [9000.0, 40.0, 0.999, 0.12], [0.0, 0.5]  # of the leaky law


def leaky_law(state, parameters, reference, reading):
    """A law that numba compiles and Python runs: leaky integral of the error, with its own feedforward."""
    error = reading - reference[0]
    state[0] = parameters[2] * state[0] + error
    return parameters[3] * reference[2] - parameters[0] * error - parameters[1] * state[0] - 0.01 * state[1]


def leaky_update(state, parameters, applied):
    """The last command that acted."""
    state[1] = applied + 0.0 * parameters[0]


class Leaky:
    """The law above as an object."""

    sample_rate, command_limit = RATE, 2.5

    def __init__(self):
        self.reset()

    def reset(self):
        self.estimates = list(STATE)

    def command(self, reference, reading):
        return leaky_law(self.estimates, GAINS, reference, reading)

    def update(self, applied):
        leaky_update(self.estimates, GAINS, applied)


class Failing(Proportional):
    """Raises what is an exception, or returns what is none, from one row on."""

    def __init__(self, row, outcome):
        super().__init__()
        self.row, self.outcome, self.calls = row, outcome, 0

    def command(self, reference, reading):
        self.calls += 1
        if self.calls <= self.row:
            return super().command(reference, reading)
        if isinstance(self.outcome, BaseException):
            raise self.outcome
        return self.outcome


class Uncopied(Proportional):
    """Refuses to be copied."""

    def __deepcopy__(self, memo):
        raise copy.Error("one of a kind")


def loop(controller, **options):
    return cogging.closed_loop(PLANT, controller, MOVE, **options)


def kind_of(value):
    """Return the id of a case: without the address of an object, the same in every process."""
    return type(value).__name__


def same(log, other):
    np.testing.assert_equal(columns_of(log), columns_of(other))


@pytest.mark.parametrize(("velocity", "width", "limit"), [("reference", 1e-3, 0.0), ("measured", 0.0, 0.4)])
def test_a_pid_in_python_gives_the_bits_of_the_core(velocity, width, limit):
    gains = {"kp": 9000.0, "ki": 8e4, "kd": 40.0, "mass": 0.11, "viscous": 0.2, "coulomb": 0.1, "coulomb_width": width}
    parameters = cogging.PidParameters(sample_rate=RATE, **gains, feedforward_velocity=velocity, command_limit=limit)
    same(loop(OwnPid(parameters), seed=3), loop(cogging.Pid(parameters), seed=3))
    lost = cogging.PidParameters(sample_rate=RATE, ki=1e5)  # an integral alone
    with pytest.raises(cogging.DivergedError) as expected:
        loop(cogging.Pid(lost))
    with pytest.raises(cogging.DivergedError, match=f"^{re.escape(str(expected.value))}$"):
        loop(OwnPid(lost))


@functools.cache
def functions():
    import numba

    kinds = cogging.CompiledController
    return numba.cfunc(kinds.COMMAND)(leaky_law), numba.cfunc(kinds.UPDATE)(leaky_update)


def compiled(**changes):
    command, update = functions()
    arguments = {"sample_rate": RATE, "state": STATE, "parameters": GAINS, "command_limit": 2.5} | changes
    return cogging.CompiledController(command, update=update, **arguments)


def test_a_compiled_law_gives_the_bits_of_the_same_in_python():
    """Also its state, one row a sample; the controller alone keeps the functions alive."""
    mine = compiled()
    functions.cache_clear()
    gc.collect()
    same(loop(mine, seed=2, record_estimates=True), loop(Leaky(), seed=2, record_estimates=True))


def test_a_batch_and_a_replay_give_what_single_runs_give():
    pid = cogging.Pid(cogging.PidParameters(kp=9600.0, kd=48.0))
    each = [compiled(), Leaky(), pid, Proportional(), compiled(state=[0.1, 0.0]), OwnPid(pid.parameters)]
    logs = cogging.closed_loop_batch([PLANT] * 6, each, MOVE, seeds=list(range(6)), threads=3, logs=True)
    for seed, (log, controller) in enumerate(zip(logs, each, strict=True)):
        same(log, loop(controller, seed=seed))
        names = ("time", "position", "reference", "reference_velocity", "reference_acceleration")
        replayed = cogging.replay_controller(controller, **{name: getattr(log, name) for name in names})
        np.testing.assert_array_equal(replayed, log.command)


def test_the_object_is_not_changed_and_reset_before_each_run():
    mine = OwnPid(cogging.PidParameters(kp=9600.0, ki=1e5))
    first = loop(mine)
    assert mine.last is None
    for _ in range(100):
        mine.command(cogging.ReferencePoint(0.1, 0.0, 0.0), 0.2)
    learned = dict(vars(mine))
    same(loop(mine), first)
    assert vars(mine) == learned


def test_what_cannot_be_copied_is_refused():
    mine = Proportional()
    mine.lock = threading.Lock()
    for controller, why in ((mine, r"TypeError.*lock"), (Uncopied(), r"Error\('one of a kind'\)")):
        name = type(controller).__name__
        with pytest.raises(TypeError, match=rf"^controller: .*copy\.deepcopy.*got {name}, .*{why}"):
            loop(controller)


def test_a_model_with_another_controller_and_what_the_log_says(tmp_path):
    model = MODEL.replace(controller=cogging.PidParameters(kp=1.0), controller_type="pid")
    log = cogging.simulate(model, MOVE, controller=Leaky(), seed=5)
    same(log, loop(Leaky(), seed=5))
    log.write(tmp_path / "log.csv")
    metadata = cogging.read_log(tmp_path / "log.csv").metadata
    assert metadata["controller"] == "given"
    assert metadata["controller_class"] == "tests.simulation.test_own_controllers.Leaky"
    assert "controller" not in metadata["model"]


def test_a_prediction_accepts_one():
    pid = cogging.PidParameters(kp=9600.0, ki=1e5, kd=48.0)
    bounds = {"axis.mass": (0.11, 0.13), "axis.viscous": (0.1, 0.2), "axis.coulomb": (0.1, 0.2)}
    bounds["axis.coulomb_width"] = (1e-3, 1.2e-3)
    controllers = {"core": cogging.Pid(pid), "own": OwnPid(pid), "compiled": compiled()}
    predicted = cogging.predict_error(MODEL, MOVE, controllers, samples=2, default=bounds)
    np.testing.assert_array_equal(predicted["own"].rms.values, predicted["core"].rms.values)
    assert 0.0 < predicted["compiled"].rms.median < np.inf
    with pytest.raises(TypeError, match="controllers: must be names, or controllers by name, got OwnPid"):
        cogging.predict_error(MODEL, MOVE, OwnPid(pid))


NO_NUMBERS = [None, True, "1.0", -float("inf"), np.float32("nan"), 10**400, np.array([0.5])]
RAISED = [ZeroDivisionError("by zero"), cogging.DivergedError("mine"), StopIteration(), OSError(2, "a\nb")]


@pytest.mark.parametrize("outcome", [*NO_NUMBERS, *RAISED], ids=kind_of)
def test_a_command_that_fails_or_is_no_finite_number_is_reported_with_row_and_time(outcome):
    with pytest.raises(cogging.ControllerError) as raised:
        loop(Failing(217, outcome), duration=0.1)
    text, is_raised = str(raised.value), isinstance(outcome, Exception)
    what = f"raised {type(outcome).__name__}" if is_raised else "must give a finite number, got "
    assert text.startswith(f"controller: Failing: command {what}")
    assert text.endswith(f" in row 217 ({217 / RATE:g} s)")
    assert (raised.value.row, raised.value.time) == (217, 217 / RATE)
    assert "\n" not in text
    assert len(text) < 400
    if is_raised:
        assert type(raised.value.__cause__) is type(outcome)
        assert traceback.extract_tb(raised.value.__cause__.__traceback__)[-1].name == "command", "the line that raised"


def having(**members):
    return SimpleNamespace(**({"sample_rate": 1e3, "command": Proportional().command} | members))


class Growing(Leaky):
    def update(self, applied):
        self.estimates = [*self.estimates, applied]


@pytest.mark.parametrize(
    ("controller", "error", "message"),
    [
        (having(update=lambda applied: [][0]), cogging.ControllerError, r"update raised IndexError: .* in row 0"),
        (having(reset=lambda: {}["no"]), KeyError, "no"),
        (Growing(), cogging.ControllerError, "estimates must keep their number, 2, got 3 in row 1"),
    ],
)
def test_other_members_that_fail(controller, error, message):
    with pytest.raises(error, match=message):
        loop(controller, record_estimates=True)


@pytest.mark.parametrize(("error", "threads"), [(KeyboardInterrupt, 1), (SystemExit, 3)])
def test_what_is_no_exception_ends_the_run_and_the_batch(error, threads):
    controllers = [Failing(100, error())] + [cogging.Pid(cogging.PidParameters(kp=9600.0))] * 8
    with pytest.raises(error):
        loop(controllers[0])
    with pytest.raises(error):
        cogging.closed_loop_batch([PLANT] * 9, controllers, MOVE, steps_per_sample=100, threads=threads)


command = Proportional().command
NONE_AT_ALL = [None, "pid", MODEL, lambda reference, reading: 0.0]


def subclass_of(kind):
    mine = type("Mine", (kind,), {"command": lambda self, reference, reading: 0.0})
    return mine(kind.PARAMETERS()) if hasattr(kind, "PARAMETERS") else mine(GOOD, sample_rate=1e3)


def number(*arguments):
    return ctypes.CFUNCTYPE(*arguments)(lambda *values: 0.0)


POINTER = ctypes.POINTER(ctypes.c_double)
GOOD = number(ctypes.c_double, POINTER, POINTER, POINTER, ctypes.c_double)
RATES, LIMITS = [0.0, float("nan"), "1000", True], [-1.0, None]
REFUSED = [
    *((value, "must be a controller of cogging or an object with .*, got ") for value in NONE_AT_ALL),
    (Proportional, r"must be an object, got the class .*Proportional.*: call it"),
    (SimpleNamespace(command=command), r"SimpleNamespace\.sample_rate must be given, got nothing"),
    (SimpleNamespace(sample_rate=1e3), r"SimpleNamespace\.command must be given, got nothing"),
    *((having(sample_rate=rate), r"\.sample_rate must be finite and above 0 \(Hz\), got ") for rate in RATES),
    *((having(command_limit=limit), r"\.command_limit must be finite and at least 0") for limit in LIMITS),
    (having(command=1.0), r"\.command must be a method: command\(reference, reading\), got 1"),
    (having(command=lambda: 0.0), r"must take \(reference, reading\), got command\(\)"),
    (having(update=lambda: 0), r"\.update must take \(applied\), got update\(\)"),
    *(
        (subclass_of(kind), rf"must not be of a subclass of {kind.__name__}, .*, got .*Mine: give an object with sam")
        for kind in (*cogging.CONTROLLERS.values(), cogging.CompiledController)
    ),
]


@pytest.mark.parametrize(("controller", "message"), REFUSED, ids=kind_of)
def test_what_is_no_controller_is_refused_in_one_line(controller, message):
    time = np.linspace(0.0, 1.0, 5)
    runs = [
        lambda: loop(controller),
        lambda: cogging.closed_loop_batch([PLANT] * 2, [Proportional(), controller], MOVE),
        lambda: cogging.replay_controller(controller, time=time, reference=time, position=time),
    ]
    if controller is not None:  # simulate: the model's own
        runs.append(lambda: cogging.simulate(MODEL, MOVE, controller=controller))
    error = ValueError if "must be finite" in message else TypeError
    for run in runs:
        with pytest.raises(error, match=rf"^controller: [^\n]*{message}[^\n]*$"):
            run()


POINTERS = "command: must be a numba cfunc or a function pointer of ctypes, got "
NO_COMPILED = [
    ({"command": leaky_law}, TypeError, POINTERS + "<function"),
    ({"command": number(ctypes.c_double, ctypes.c_double)}, TypeError, r"command: must be double command\(double\*, "),
    ({"command": number(ctypes.c_float, POINTER, POINTER, POINTER, ctypes.c_double)}, TypeError, "restype.*float"),
    ({"sample_rate": 0.0}, ValueError, "sample_rate: must be finite and above 0, got 0"),
]


@pytest.mark.parametrize(("arguments", "error", "message"), NO_COMPILED, ids=kind_of)
def test_what_no_compiled_controller_can_be_of(arguments, error, message):
    with pytest.raises(error, match=message):
        cogging.CompiledController(**({"command": GOOD, "sample_rate": 1e3} | arguments))
