"""Time of a control step: the core beside a loop written by hand in C++ and one compiled by numba.

The C3 loop of the X axis of Lu et al. 2008 (five harmonics in the plant, three in the controller, B-splines of order
3, one Runge-Kutta step a sample), over the whole run: reference, control, simulation and the columns of the log.
"hand-written" uses the core's own sine and arctangent, so that it does the same arithmetic; "hand-written, libm" and
"numba" those of the mathematics library.

    python tests/benchmarks/lu2008_loop.py [--repeats 15]
"""

import argparse
import ctypes
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections import namedtuple
from pathlib import Path

import numpy as np

import cogging
from cogging import _core
from cogging_command import run_command

COLUMNS = (
    "time",
    "reference",
    "reference_velocity",
    "reference_acceleration",
    "position",
    "command",
    "true_position",
    "true_velocity",
)
PLANT_HARMONICS, CONTROLLER_HARMONICS = [1, 2, 3, 6, 12], [1, 2, 3]
SPLINE = {"order": 3, "origin": 0.0, "control_points": 13}

# The paper's experiments on X; jerk, dwell, coulomb_width and repeats are not reported there. In the order of `Setup`
# in hand_written.cpp.
SETUP = {
    "mass": 0.12,
    "viscous": 0.166,
    "coulomb": 0.15,
    "coulomb_width": 1.0 / 900.0,
    "pitch": 0.05,
    "resolution": 0.5e-6,
    "start": 0.05,
    "distance": 0.4,
    "velocity": 0.5,
    "acceleration": 10.0,
    "jerk": 1000.0,
    "dwell": 0.1,
    "repeats": 20.0,
    "sample_rate": 5000.0,
    "error_gain": 200.0,
    "feedback_gain": 48.0,
    "mass_adaptation": 1.0,
    "viscous_adaptation": 10.0,
    "coulomb_adaptation": 10.0,
    "disturbance_adaptation": 1000.0,
    "cogging_adaptation": 100.0,
    "mass_min": 0.1,
    "mass_max": 0.2,
    "viscous_min": 0.15,
    "viscous_max": 0.35,
    "coulomb_min": 0.1,
    "coulomb_max": 0.3,
    "disturbance_min": -0.5,
    "disturbance_max": 0.5,
    "cogging_min": -0.1,
    "cogging_max": 0.1,
}
Setup = namedtuple("Setup", SETUP)


def core_arguments(setup, coefficients):
    """Plant, controller and reference of the core for `setup`."""
    axis = {name: setup[name] for name in ("mass", "viscous", "coulomb", "coulomb_width")}
    basis = cogging.SplineHarmonics(pitch=setup["pitch"], harmonics=PLANT_HARMONICS, **SPLINE)
    plant = cogging.Plant(
        cogging.AxisParameters(**axis, travel=[0.0, 0.51]),
        cogging=cogging.CoggingModel(basis, coefficients[:, 0::2].T, coefficients[:, 1::2].T),
        encoder=cogging.EncoderParameters(resolution=setup["resolution"]),
    )
    estimates = ("mass", "viscous", "coulomb", "disturbance", "cogging")
    controller = cogging.Dcarc(
        cogging.AdaptiveRobustParameters(
            **axis,
            **{name: setup[name] for name in ("sample_rate", "error_gain", "feedback_gain")},
            **{f"{name}_bounds": [setup[f"{name}_min"], setup[f"{name}_max"]] for name in estimates},
            **{f"{name}_adaptation": setup[f"{name}_adaptation"] for name in estimates},
            **{f"cogging_{name}": value for name, value in SPLINE.items()},
            cogging_pitch=setup["pitch"],
            cogging_harmonics=CONTROLLER_HARMONICS,
        )
    )
    motion = {name: setup[name] for name in ("start", "distance", "velocity", "acceleration", "jerk", "dwell")}
    reference = cogging.PointToPoint(cogging.PointToPointParameters(**motion, repeats=int(setup["repeats"])))
    return plant, controller, reference


def random_coefficients(seed=0):
    """A map of the size of the paper's Fig. 5: one row a control point, in it sine and cosine of each harmonic."""
    numbers = np.random.default_rng(seed)
    size = np.repeat([0.04, 0.03, 0.02, 0.01, 0.01], 2)
    return size * (numbers.standard_normal(10) + 0.3 * numbers.standard_normal((SPLINE["control_points"], 10)))


def compiler():
    """The C++ compiler, or None."""
    return shutil.which(os.environ.get("CXX", "c++")) or shutil.which("g++") or shutil.which("clang++")


def compile_hand_written(*definitions):
    """The function of hand_written.cpp with the core's optimisation flags: columns from (setup, coefficients, rows)."""
    source = Path(__file__).with_name("hand_written.cpp")
    flags = ["-std=c++20", "-O3", "-DNDEBUG", "-ffp-contract=off", "-fPIC", "-shared"]
    flags += [f"-I{source.parents[2] / 'cpp'}", *(f"-D{name}" for name in definitions)]
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "hand_written.so"
        subprocess.run([compiler(), *flags, str(source), "-o", str(library)], check=True)
        function = ctypes.CDLL(str(library)).lu2008_loop
    pointer = np.ctypeslib.ndpointer(dtype=np.float64, flags="C_CONTIGUOUS")
    function.argtypes = [ctypes.c_void_p, pointer, ctypes.c_int, *[pointer] * len(COLUMNS)]
    function.restype = None

    def run(setup, coefficients, rows):
        columns = [np.empty(rows) for _ in COLUMNS]
        values = np.array(list(setup.values()))
        function(values.ctypes.data, coefficients, rows, *columns)
        return dict(zip(COLUMNS, columns, strict=True))

    return run


def compile_numba():
    """The same function from numba_loop.py; ImportError without numba."""
    from numba_loop import lu2008_loop

    def run(setup, coefficients, rows):
        columns = [np.empty(rows) for _ in COLUMNS]
        lu2008_loop(Setup(**setup), coefficients, *columns)
        return dict(zip(COLUMNS, columns, strict=True))

    return run


def largest_difference(log, other):
    """Over the run: of the true positions and of the commands, m and V."""
    return [float(np.max(np.abs(log[name] - other[name]))) for name in ("true_position", "command")]


def measure(runs, repeats):
    """Median seconds of each function, called in turns."""
    seconds = {name: [] for name in runs}
    for _ in range(repeats):
        for name, run in runs.items():
            start = time.perf_counter()
            run()
            seconds[name].append(time.perf_counter() - start)
    return {name: statistics.median(values) for name, values in seconds.items()}


def timed(repeats, setup=SETUP):
    """Samples of a run, and median seconds of a run by each; after a look at whether they do the same."""
    coefficients = random_coefficients()
    plant, controller, reference = core_arguments(setup, coefficients)
    core = _core.closed_loop(plant, controller, reference)
    rows = len(core["time"])
    hand_written, with_library = compile_hand_written(), compile_hand_written("LIBRARY_FUNCTIONS")
    runs = {
        "core": lambda: _core.closed_loop(plant, controller, reference),
        "hand-written": lambda: hand_written(setup, coefficients, rows),
        "hand-written, libm": lambda: with_library(setup, coefficients, rows),
    }
    try:
        numba = compile_numba()
        runs["numba"] = lambda: numba(setup, coefficients, rows)
    except ImportError:
        print("numba is not installed: its row is left out")
    for name, run in runs.items():  # also compiles and warms up
        position, command = largest_difference(core, run())
        assert position <= setup["resolution"], f"{name} is off the core by {position:.1e} m"  # a count of the encoder
        print(f"{name} less core: {position:.1e} m, {command:.1e} V at most")
    batch = 4
    runs["batch, 2 threads"] = lambda: cogging.closed_loop_batch(
        [plant] * batch, [controller] * batch, reference, threads=2, logs=True
    )

    seconds = measure(runs, repeats)
    seconds["batch, 2 threads"] /= batch
    return rows, seconds


def main(repeats):
    """Prints the table."""
    rows, seconds = timed(repeats)
    print(f"\nC3, X axis: {rows} samples, median of {repeats} repeats in turns")
    print(f"{'':24}{'ns/step':>8}{'/ hand-written':>16}{'/ core':>8}")
    for name, value in seconds.items():
        ratios = value / seconds["hand-written"], value / seconds["core"]
        print(f"{name:24}{1e9 * value / rows:8.1f}{ratios[0]:16.2f}{ratios[1]:8.2f}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=15)
    sys.exit(run_command(lambda: main(parser.parse_args().repeats)))
