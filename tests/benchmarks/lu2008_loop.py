"""Time of a control step: the core beside loops written by hand in C++, for one run and for packs of runs.

The C3 loop of the X axis of Lu et al. 2008 (five harmonics in the plant, three in the controller, B-splines of order
3, one Runge-Kutta step a sample), over the whole run: reference, control, simulation and the columns of the log. The
packs are machines that differ in mass, friction and cogging. hand_written.cpp uses the core's own sine and arctangent
(or, "libm", those of the mathematics library), so that it does the same arithmetic.
"""

import ctypes
import os
import shutil
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

import cogging
from cogging import _core

WIDTHS = {"v2": 2, "v3": 4, "v4": 8, "neon": 2}  # doubles in a register
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


def core_batch(setup, machines):
    """Plants, controllers and reference of a batch of machines."""
    plants = []
    for mass, viscous, coulomb, *coefficients in machines:
        one = setup | {"mass": mass, "viscous": viscous, "coulomb": coulomb}
        plants.append(core_arguments(one, np.reshape(coefficients, (SPLINE["control_points"], -1)))[0])
    _, controller, reference = core_arguments(setup, random_coefficients())
    return plants, [controller] * len(plants), reference


def nominal_machine(setup):
    """The machine of the setup as hand_written.cpp reads it: mass, frictions and the cogging's coefficients, (1, n)."""
    axis = [setup[name] for name in ("mass", "viscous", "coulomb")]
    return np.hstack([axis, random_coefficients().ravel()])[None]


def drawn_machines(runs, setup):
    """Machines that differ in mass, viscous and Coulomb friction and in their cogging, one a row."""
    rng = np.random.default_rng(3)
    lowest = [0.9, 0.92, 0.9]  # within the controller's bounds
    axis = nominal_machine(setup)[0, :3] * rng.uniform(lowest, 1.1, (runs, 3))
    return np.hstack([axis, [random_coefficients(seed).ravel() for seed in range(runs)]])


def compiler():
    """The C++ compiler, or None."""
    return shutil.which(os.environ.get("CXX", "c++")) or shutil.which("g++") or shutil.which("clang++")


def compile_hand_written(*definitions, instructions=""):
    """The loop of hand_written.cpp, in packs of an instruction set: columns (runs, rows) of (setup, machines, rows)."""
    source, lanes = Path(__file__).with_name("hand_written.cpp"), WIDTHS.get(instructions, 1)
    flags = ["-std=c++20", "-O3", "-DNDEBUG", "-ffp-contract=off", "-fPIC", "-shared", "-Wno-psabi"]
    flags += [f"-I{source.parents[2] / 'cpp'}", *(f"-D{name}" for name in definitions)]
    flags += [f"-DLANES={lanes}"] if instructions else []
    flags += [f"-march=x86-64-{instructions}"] if instructions.startswith("v") else []
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "hand_written.so"
        subprocess.run([compiler(), *flags, str(source), "-o", str(library)], check=True)
        function = ctypes.CDLL(str(library)).lu2008_loop
    pointer = np.ctypeslib.ndpointer(dtype=np.float64, flags="C_CONTIGUOUS")
    function.argtypes = [pointer, pointer, ctypes.c_int, *[pointer] * 5]
    function.restype = None

    def run(setup, machines, rows):
        names = ("position", "command", "true_position", "true_velocity")
        columns = {name: np.empty((len(machines), rows)) for name in names}
        values, reference = np.array(list(setup.values())), np.empty((4, rows))
        for first in range(0, len(machines), lanes):
            pack = slice(first, first + lanes)
            function(values, machines[pack], rows, reference, *(column[pack] for column in columns.values()))
        return columns

    return run


def measure(runs, repeats):
    """Median seconds of each function, called in turns."""
    seconds = {name: [] for name in runs}
    for _ in range(repeats):
        for name, run in runs.items():
            start = time.perf_counter()
            run()
            seconds[name].append(time.perf_counter() - start)
    return {name: statistics.median(values) for name, values in seconds.items()}


def check_agreement(name, logs, by_hand, resolution):
    """Print by how much loops by hand differ from the core's, and require that it is within a count of the encoder."""
    apart = max(np.max(np.abs(log.true_position - x)) for log, x in zip(logs, by_hand["true_position"], strict=True))
    assert apart <= resolution, f"{name} is off the core by {apart:.1e} m"
    print(f"{name} less core: {apart:.1e} m at most")


def time_one_run(repeats, setup=SETUP):
    """Samples of a run, and its median seconds in the core and by hand; the loops are compared first."""
    machine, one = nominal_machine(setup), core_arguments(setup, random_coefficients())
    log = cogging.closed_loop(*one)
    rows = len(log)
    ways = {"core": lambda: _core.closed_loop(*one)}
    for name, definitions in (("hand-written", ()), ("hand-written, libm", ("LIBRARY_FUNCTIONS",))):
        loop = compile_hand_written(*definitions)
        ways[name] = lambda loop=loop: loop(setup, machine, rows)
        check_agreement(name, [log], ways[name](), setup["resolution"])
    return rows, measure(ways, repeats)


def run_core(arguments, instructions, threads=1, logs=True):
    """A batch of the core under an instruction set, or "none"."""
    os.environ["COGGING_INSTRUCTIONS"] = instructions
    return cogging.closed_loop_batch(*arguments, threads=threads, logs=logs)


def time_packs(repeats, runs):
    """Rows of a run, and median seconds of all runs in packs of each instruction set; the loops are compared first."""
    setup = SETUP | {"repeats": 1.0}
    machines = drawn_machines(runs, setup)
    arguments = core_batch(setup, machines)
    rows = len(cogging.closed_loop(arguments[0][0], arguments[1][0], arguments[2]))
    ways = {}
    for name in _core.instruction_sets():
        loop = compile_hand_written(instructions=name)
        ways[f"core, {name}"] = lambda name=name: run_core(arguments, name, logs=False)
        ways[f"core, {name}, logs"] = lambda name=name: run_core(arguments, name)
        ways[f"by hand, {name}"] = lambda loop=loop: loop(setup, machines, rows)
        core = run_core(arguments, name)
        print(f"{name}: {sum(core.in_lanes)} of {runs} runs in lanes")
        check_agreement(f"by hand, {name}", core, ways[f"by hand, {name}"](), setup["resolution"])
    widest = list(_core.instruction_sets() or ["none"])[-1]
    ways["core, alone"] = lambda: run_core(arguments, "none", logs=False)
    ways[f"core, {widest}, 2 threads"] = lambda: run_core(arguments, widest, threads=2, logs=False)
    return rows, measure(ways, repeats)
