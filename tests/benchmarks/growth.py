"""How the time and memory of runs grow: with harmonics, control points, effects, length of the run, runs, threads.

    python -m tests.benchmarks.growth [--repeats 5] [--figure docs/figures/growth.svg]

One thing is made larger at a time on one machine, a PID loop at 5 kHz. Time is that of the processor, the least of some
repeats, by which the table and the figure say what each takes against the smallest of its kind; memory is the most that
a process of its own held above what it held before, with indexes kept and with whole logs.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import cogging
from cogging import _core
from cogging_command import run_command
from tests.benchmarks.memory import peak_megabytes

RATE, PITCH = 5000.0, 0.05
MOTION = cogging.Sine(cogging.SineParameters(center=0.25, amplitude=0.1))
EFFECTS = [
    ("constant_force", {"force": 0.02}),
    ("cable_spring", {"stiffness": 0.1, "center": 0.2}),
    ("viscous_asymmetry", {"difference": 0.02}),
    ("coulomb_asymmetry", {"difference": 0.01}),
    ("quadratic_drag", {"coefficient": 0.05}),
    ("force_constant_ripple", {"period": 0.03, "sine": 0.01, "cosine": 0.0}),
    ("encoder_scale_error", {"scale": 1e-4}),
    ("command_delay", {"delay": 1e-4}),
]
#: What is made larger, and how far.
GROWN = {
    "harmonics": [1, 2, 4, 8, 16, 32],
    "control points": [1, 4, 16, 64, 256, 1024],
    "effects": [0, 1, 2, 4, 8],
    "seconds of a run": [1, 2, 4, 8, 16, 32],
    "runs": [8, 16, 32, 64, 128, 256],
    "threads": [1, 2, 4],
}
#: Of what the time is a processor's, and of what a watch's.
BY_WATCH = ("threads",)


def case(what, size):
    """Arguments and options of the batch in which one thing has a size and all others their usual one."""
    sizes = {"harmonics": 3, "control points": 13, "effects": 0, "seconds of a run": 1, "runs": 16, "threads": 1}
    sizes[what] = size
    points = int(sizes["control points"])
    order = min(points, 3)
    harmonics = list(range(1, int(sizes["harmonics"]) + 1))
    amplitudes = 0.05 / np.sqrt(len(harmonics)) * np.ones((2, len(harmonics), points))
    basis = cogging.SplineHarmonics(pitch=PITCH, harmonics=harmonics, order=order, control_points=points)
    effects = [cogging.EFFECTS[name](**fields) for name, fields in EFFECTS[: int(sizes["effects"])]]
    axis = cogging.AxisParameters(mass=0.12, viscous=0.17, coulomb=0.15, coulomb_width=0.01)
    plant = cogging.Plant(axis, cogging=cogging.CoggingModel(basis, *amplitudes), effects=effects)
    controller = cogging.Pid(cogging.PidParameters(sample_rate=RATE, kp=9600.0, ki=1e5, kd=48.0, mass=0.12))
    count = 128 if what == "threads" else int(sizes["runs"])
    options = {"duration": float(sizes["seconds of a run"]), "threads": int(sizes["threads"])}
    return ([plant] * count, [controller] * count, MOTION), options


def seconds_of(what, size, repeats):
    """The least time of some repeats, s."""
    arguments, options = case(what, size)
    clock = time.perf_counter if what in BY_WATCH else time.process_time
    found = []
    for _ in range(repeats):
        begin = clock()
        batch = cogging.closed_loop_batch(*arguments, **options)
        found.append(clock() - begin)
        assert not batch.failures
    return min(found)


def megabytes_of(what, size, logs):
    """What a process of its own holds at most beyond what it held before the runs, MB."""
    call = [sys.executable, "-m", "tests.benchmarks.growth", "--memory", what, str(size), "logs" if logs else ""]
    root = Path(__file__).resolve().parents[2]
    return json.loads(subprocess.run(call, cwd=root, stdout=subprocess.PIPE, text=True, check=True).stdout)


def memory(what, size, logs):
    """Prints it."""
    warm, options = case("runs", 8)
    cogging.closed_loop_batch(*warm, **options)
    arguments, options = case(what, float(size))
    before = peak_megabytes()
    kept = cogging.closed_loop_batch(*arguments, **options, logs=bool(logs))
    assert not kept.failures
    print(json.dumps(peak_megabytes() - before))


def measured(repeats, with_memory=True):
    """Sizes, seconds and MB of each thing that grows."""
    found = {}
    for what, sizes in GROWN.items():
        seconds = [seconds_of(what, size, repeats) for size in sizes]
        found[what] = {"sizes": sizes, "seconds": seconds}
        for kept, logs in (("indexes", False), ("logs", True)):
            found[what][kept] = [megabytes_of(what, size, logs) if with_memory else np.nan for size in sizes]
    return found


def draw(found, path):
    """The figure: time against size, each relative to its smallest."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context({"svg.hashsalt": "growth", "font.size": 9}):
        figure = Figure(figsize=(9.0, 4.8), layout="constrained")
        for place, (what, one) in zip(figure.subplots(2, 3).flat, found.items(), strict=True):
            sizes, relative = np.array(one["sizes"], dtype=float), np.array(one["seconds"]) / one["seconds"][0]
            place.plot(sizes, relative, "o-", color="#1f5a8a")
            if sizes[0] > 0 and what not in ("control points", "threads"):
                place.plot(sizes, sizes / sizes[0], ":", color="0.5", label="in proportion")
                place.legend(frameon=False)
                place.set_xscale("log", base=2)
                place.set_yscale("log", base=2)
            elif what == "control points":
                place.set_xscale("log", base=4)
            place.set_ylim(bottom=0.0 if place.get_yscale() == "linear" else None)
            place.set_xlabel(what)
            place.set_ylabel("time / smallest")
        figure.savefig(path, metadata={"Date": None})


def main(repeats, figure):
    """Prints the table."""
    found = measured(repeats)
    print(f"one PID loop at 5 kHz, {_core.instruction_set()}, {os.cpu_count()} cores; least of {repeats}")
    print(f"{'':20}{'size':>8}{'ms':>10}{'/ first':>9}{'MB, indexes':>13}{'MB, logs':>10}")
    for what, one in found.items():
        for size, seconds, indexes, logs in zip(*one.values(), strict=True):
            times = f"{1e3 * seconds:10.2f}{seconds / one['seconds'][0]:9.2f}"
            print(f"{what:20}{size:8}{times}{indexes:13.1f}{logs:10.1f}")
    if figure:
        draw(found, figure)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--figure")
    parser.add_argument("--memory", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.memory:
        memory(*options.memory)
    else:
        sys.exit(run_command(lambda: main(options.repeats, options.figure)))
