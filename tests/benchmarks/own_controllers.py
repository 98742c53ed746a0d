"""What a controller of one's own costs a sample, in Python and compiled, beside one of the core.

The cost of the loop's call is the time of a run with the object, less that of the same run with a controller of the
core that gives the same commands, less the object's own two calls made by a loop in Python. All are measured in turns,
by the processor time of the thread; medians.
"""

import time

import numpy as np

import cogging
from tests.benchmarks import child

RATE, DURATION = 5000.0, 4.0
PLANT = cogging.Plant(cogging.AxisParameters(mass=0.12, viscous=0.166, coulomb=0.15, coulomb_width=0.1))
MOTION = cogging.Sine(cogging.SineParameters(center=0.25, amplitude=0.1))
GAIN = 960.0


class Proportional:
    """As little as a controller can do, with an update."""

    sample_rate = RATE

    def command(self, reference, reading):
        return -GAIN * (reading - reference.position)

    def update(self, applied):
        pass


def law(state, parameters, reference, reading):
    return -parameters[0] * (reading - reference[0])


def compiled():
    """The same law compiled; None without numba."""
    try:
        import numba
    except ImportError:
        return None
    function = numba.cfunc(cogging.CompiledController.COMMAND)(law)
    return cogging.CompiledController(function, sample_rate=RATE, parameters=[GAIN])


def own_calls(log):
    """The object's own two calls a row, made by Python, and the same loop without them."""
    columns = (log.reference, log.reference_velocity, log.reference_acceleration)
    points = [cogging.ReferencePoint(*point) for point in zip(*(c.tolist() for c in columns), strict=True)]
    readings, commands, mine = log.position.tolist(), log.command.tolist(), Proportional()

    def with_calls():
        for point, reading, applied in zip(points, readings, commands, strict=True):
            mine.command(point, reading)
            mine.update(applied)

    def without():
        for _ in zip(points, readings, commands, strict=True):
            pass

    return with_calls, without


def measure(repeats):
    """Nanoseconds a row of each, by name; the commands are compared first."""

    def run(controller):
        return cogging.closed_loop(PLANT, controller, MOTION, duration=DURATION)

    core = cogging.Pid(cogging.PidParameters(sample_rate=RATE, kp=GAIN))
    log = run(core)
    with_calls, without = own_calls(log)
    mine, fast = Proportional(), compiled()
    runs = {"core": lambda: run(core), "Python": lambda: run(mine), "own calls": with_calls, "their loop": without}
    if fast is not None:
        runs["compiled"] = lambda: run(fast)
    for name in ("Python", "compiled"):
        assert name not in runs or np.array_equal(runs[name]().command, log.command), name
    return {name: 1e9 * value / len(log) for name, value in child.measure(runs, repeats, time.thread_time).items()}
