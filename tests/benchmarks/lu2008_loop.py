"""Time of a control step: the core beside loops written by hand in C++, for one run and for packs of runs.

The C3 loop of the X axis of Lu et al. 2008 (five harmonics in the plant, three in the controller, B-splines of order
3, one Runge-Kutta step a sample), over the whole run: reference, control, simulation and the columns of the log. The
packs are machines that differ in mass, friction and cogging. hand_written.cpp uses the core's own sine and arctangent
(or, "libm", those of the mathematics library), so that it does the same arithmetic.
"""

import ctypes
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

import cogging
from cogging import _core
from cogging.papers import comparison
from cogging.papers.lu2008 import gantry as lu2008
from tests.benchmarks.child import measure

WIDTHS = {"v2": 2, "v3": 4, "v4": 8, "neon": 2}  # doubles in a register
PLANT_HARMONICS, CONTROLLER_HARMONICS = [1, 2, 3, 6, 12], [1, 2, 3]
SPLINE = {"order": 3, "origin": 0.0, "control_points": 13}

#: The paper's experiment on X; the loop by hand takes the velocity's error as it is.
PLANT, MOTION = lu2008.plant(comparison.AXIS, None), lu2008.reference(comparison.AXIS, repeats=20).parameters
CONTROLLER = comparison.controllers()["dcarc C3"].parameters.replace(error_difference=False)


def values_by_hand(motion):
    """The numbers of `Setup` in hand_written.cpp, in their order."""
    axis, q, estimates = PLANT.axis, CONTROLLER, ("mass", "viscous", "coulomb", "disturbance", "cogging")
    values = [axis.mass, axis.viscous, axis.coulomb, axis.coulomb_width, q.cogging_pitch, PLANT.encoder.resolution]
    values += [motion.start, motion.distance, motion.velocity, motion.acceleration, motion.jerk, motion.dwell]
    values += [motion.repeats, q.sample_rate, q.error_gain, q.feedback_gain]
    values += [getattr(q, f"{name}_adaptation") for name in estimates]
    values += [bound for name in estimates for bound in getattr(q, f"{name}_bounds")]
    return np.array(values, dtype=float)


def core_arguments(coefficients, motion=MOTION, **axis):
    """Plant, controller and reference of the core, with other fields of the axis."""
    basis = cogging.SplineHarmonics(pitch=CONTROLLER.cogging_pitch, harmonics=PLANT_HARMONICS, **SPLINE)
    model = cogging.CoggingModel(basis, coefficients[:, 0::2].T, coefficients[:, 1::2].T)
    plant = cogging.Plant(PLANT.axis.replace(**axis), cogging=model, encoder=PLANT.encoder)
    return plant, cogging.Dcarc(CONTROLLER), cogging.PointToPoint(motion)


def random_coefficients(seed=0):
    """A map of the size of the paper's Fig. 5: one row a control point, in it sine and cosine of each harmonic."""
    numbers = np.random.default_rng(seed)
    size = np.repeat([0.04, 0.03, 0.02, 0.01, 0.01], 2)
    return size * (numbers.standard_normal(10) + 0.3 * numbers.standard_normal((SPLINE["control_points"], 10)))


def core_batch(motion, machines):
    """Plants, controllers and reference of a batch of machines."""
    plants = []
    for mass, viscous, coulomb, *coefficients in machines:
        table = np.reshape(coefficients, (SPLINE["control_points"], -1))
        plants.append(core_arguments(table, mass=mass, viscous=viscous, coulomb=coulomb)[0])
    _, controller, reference = core_arguments(random_coefficients(), motion)
    return plants, [controller] * len(plants), reference


def nominal_machine():
    """The machine as hand_written.cpp reads it: mass, frictions and the cogging's coefficients, (1, n)."""
    axis = [PLANT.axis.mass, PLANT.axis.viscous, PLANT.axis.coulomb]
    return np.hstack([axis, random_coefficients().ravel()])[None]


def drawn_machines(runs):
    """Machines that differ in mass, viscous and Coulomb friction and in their cogging, one a row."""
    rng = np.random.default_rng(3)
    lowest = [0.9, 0.92, 0.9]  # within the controller's bounds
    axis = nominal_machine()[0, :3] * rng.uniform(lowest, 1.1, (runs, 3))
    return np.hstack([axis, [random_coefficients(seed).ravel() for seed in range(runs)]])


def compiler():
    return shutil.which(os.environ.get("CXX", "c++")) or shutil.which("g++") or shutil.which("clang++")


def compile_hand_written(*definitions, instructions=""):
    """The loop of hand_written.cpp, in packs of an instruction set: columns (runs, rows) of motion, machines, rows."""
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

    def run(motion, machines, rows):
        names = ("position", "command", "true_position", "true_velocity")
        columns = {name: np.empty((len(machines), rows)) for name in names}
        values, reference = values_by_hand(motion), np.empty((4, rows))
        for first in range(0, len(machines), lanes):
            pack = slice(first, first + lanes)
            function(values, machines[pack], rows, reference, *(column[pack] for column in columns.values()))
        return columns

    return run


def check_agreement(name, logs, by_hand):
    """Print by how much loops by hand differ from the core's, and require that it is within a count of the encoder."""
    apart = max(np.max(np.abs(log.true_position - x)) for log, x in zip(logs, by_hand["true_position"], strict=True))
    assert apart <= PLANT.encoder.resolution, f"{name} is off the core by {apart:.1e} m"
    print(f"{name} less core: {apart:.1e} m at most")


def time_one_run(repeats, motion=MOTION):
    """Samples of a run, and its median seconds in the core and by hand; the loops are compared first."""
    machine, one = nominal_machine(), core_arguments(random_coefficients(), motion)
    log = cogging.closed_loop(*one)
    rows = len(log)
    ways = {"core": lambda: _core.closed_loop(*one)}
    for name, definitions in (("hand-written", ()), ("hand-written, libm", ("LIBRARY_FUNCTIONS",))):
        loop = compile_hand_written(*definitions)
        ways[name] = lambda loop=loop: loop(motion, machine, rows)
        check_agreement(name, [log], ways[name]())
    return rows, measure(ways, repeats)


def run_core(arguments, instructions, threads=1, logs=True):
    """A batch of the core under an instruction set, or "none"."""
    os.environ["COGGING_INSTRUCTIONS"] = instructions
    return cogging.closed_loop_batch(*arguments, threads=threads, logs=logs)


def time_packs(repeats, runs):
    """Rows of a run, and median seconds of all runs in packs of each instruction set; the loops are compared first."""
    motion, machines = MOTION.replace(repeats=1), drawn_machines(runs)
    arguments = core_batch(motion, machines)
    rows = len(cogging.closed_loop(arguments[0][0], arguments[1][0], arguments[2]))
    ways = {}
    for name in _core.instruction_sets():
        loop = compile_hand_written(instructions=name)
        ways[f"core, {name}"] = lambda name=name: run_core(arguments, name, logs=False)
        ways[f"core, {name}, logs"] = lambda name=name: run_core(arguments, name)
        ways[f"by hand, {name}"] = lambda loop=loop: loop(motion, machines, rows)
        core = run_core(arguments, name)
        print(f"{name}: {sum(core.in_lanes)} of {runs} runs in lanes")
        check_agreement(f"by hand, {name}", core, ways[f"by hand, {name}"]())
    widest = list(_core.instruction_sets() or ["none"])[-1]
    ways["core, alone"] = lambda: run_core(arguments, "none", logs=False)
    ways[f"core, {widest}, 2 threads"] = lambda: run_core(arguments, widest, threads=2, logs=False)
    return rows, measure(ways, repeats)
