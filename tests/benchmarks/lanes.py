"""Time of a step of many machines side by side: the core's batch beside packs of lanes written by hand.

The C3 loop of lu2008_loop.py for machines that differ in mass, friction and cogging, under each instruction set of this
machine, on one core; then the same batch on two threads. The core keeps the indexes of each run, its default, and
beside that whole logs of eight columns; the packs by hand write four columns.

    python tests/benchmarks/lanes.py [--repeats 15] [--runs 64]
"""

import argparse
import ctypes
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import lu2008_loop
import numpy as np

import cogging
from cogging import _core
from cogging_command import run_command

WIDTHS = {"v2": 2, "v3": 4, "v4": 8, "neon": 2}  # doubles in a register


def compile_by_hand(instructions, lanes):
    """The function of hand_written_lanes.cpp for packs of so many machines: columns (runs, rows) of machines."""
    source = Path(__file__).with_name("hand_written_lanes.cpp")
    flags = ["-std=c++20", "-O3", "-DNDEBUG", "-ffp-contract=off", "-fPIC", "-shared", "-Wno-psabi"]
    flags += [f"-I{source.parents[2] / 'cpp'}", f"-DLANES={lanes}"]
    if instructions.startswith("v"):
        flags.append(f"-march=x86-64-{instructions}")
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "hand_written_lanes.so"
        subprocess.run([lu2008_loop.compiler(), *flags, str(source), "-o", str(library)], check=True)
        function = ctypes.CDLL(str(library)).lu2008_lanes
    pointer = np.ctypeslib.ndpointer(dtype=np.float64, flags="C_CONTIGUOUS")
    function.argtypes = [ctypes.c_void_p, pointer, ctypes.c_int, *[pointer] * 5]
    function.restype = None

    def run(setup, machines, rows):
        names = ("position", "command", "true_position", "true_velocity")
        columns = {name: np.empty((len(machines), rows)) for name in names}
        values, reference = np.array(list(setup.values())), np.empty((3, rows))
        for first in range(0, len(machines), lanes):
            pack = slice(first, first + lanes)
            function(
                values.ctypes.data, machines[pack], rows, reference, *(column[pack] for column in columns.values())
            )
        return columns

    return run


def drawn_machines(runs, setup=lu2008_loop.SETUP):
    """Mass, viscous and Coulomb friction and the cogging's coefficients, a row a machine."""
    rng = np.random.default_rng(3)
    lowest = [0.9, 0.92, 0.9]  # within the controller's bounds
    axis = np.array([setup[name] for name in ("mass", "viscous", "coulomb")]) * rng.uniform(lowest, 1.1, (runs, 3))
    return np.hstack([axis, [lu2008_loop.random_coefficients(seed).ravel() for seed in range(runs)]])


def core_arguments(setup, machines):
    """Plants, controllers and reference of the batch."""
    plants = []
    for mass, viscous, coulomb, *coefficients in machines:
        one = setup | {"mass": mass, "viscous": viscous, "coulomb": coulomb}
        rows = np.reshape(coefficients, (lu2008_loop.SPLINE["control_points"], -1))
        plants.append(lu2008_loop.core_arguments(one, rows)[0])
    _, controller, reference = lu2008_loop.core_arguments(setup, lu2008_loop.random_coefficients())
    return plants, [controller] * len(plants), reference


def run_core(arguments, instructions, threads=1, logs=True):
    os.environ["COGGING_INSTRUCTIONS"] = instructions
    return cogging.closed_loop_batch(*arguments, threads=threads, logs=logs)


def timed(repeats, runs):
    """Rows of a run, and median seconds of all runs by each way; after a look at whether they do the same."""
    setup = lu2008_loop.SETUP | {"repeats": 1.0}
    machines = drawn_machines(runs, setup)
    arguments = core_arguments(setup, machines)
    rows = len(run_core([part[:1] if isinstance(part, list) else part for part in arguments], "none")[0])
    ways = {}
    for name in _core.instruction_sets():
        by_hand = compile_by_hand(name, WIDTHS[name])
        core = run_core(arguments, name)
        ways[f"core, {name}"] = lambda name=name: run_core(arguments, name, logs=False)
        ways[f"core, {name}, logs"] = lambda name=name: run_core(arguments, name)
        ways[f"by hand, {name}"] = lambda by_hand=by_hand: by_hand(setup, machines, rows)
        logs, places = core, ways[f"by hand, {name}"]()["true_position"]
        apart = max(np.max(np.abs(log.true_position - x)) for log, x in zip(logs, places, strict=True))
        assert apart <= setup["resolution"], f"{name} is off the packs by hand by {apart:.1e} m"  # a count
        print(f"{name}: {sum(core.in_lanes)} of {runs} runs in lanes; by hand less core {apart:.1e} m at most")
    widest = list(_core.instruction_sets() or ["none"])[-1]
    ways["core, alone"] = lambda: run_core(arguments, "none", logs=False)
    ways[f"core, {widest}, 2 threads"] = lambda: run_core(arguments, widest, threads=2, logs=False)
    return rows, lu2008_loop.measure(ways, repeats)


def by_hand_of(name, seconds):
    """Of the packs by hand with the same instructions; None where there are none."""
    kind, instructions, *_ = name.split(", ")
    return seconds.get(f"by hand, {instructions}") if kind == "core" else None


def main(repeats, runs):
    """Prints the table."""
    rows, seconds = timed(repeats, runs)
    widest = list(_core.instruction_sets() or ["none"])[-1]
    print(f"\nC3, X axis: {runs} runs of {rows} rows, median of {repeats} repeats in turns, {os.cpu_count()} cores")
    for name, value in seconds.items():
        hand = by_hand_of(name, seconds)
        ratio = f"{value / hand:8.2f} of by hand" if hand and "threads" not in name else ""
        print(f"{name:24}{1e9 * value / rows / runs:8.1f} ns/step{ratio}")
    print(f"two threads: {seconds[f'core, {widest}'] / seconds[f'core, {widest}, 2 threads']:.2f} times as fast")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=15)
    parser.add_argument("--runs", type=int, default=64)
    options = parser.parse_args()
    sys.exit(run_command(lambda: main(options.repeats, options.runs)))
