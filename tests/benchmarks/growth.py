"""How time and memory of runs grow, and what many runs of one machine cost.

`grown`: one thing at a time is made larger on one machine, a PID loop at 5 kHz: harmonics, control points, effects,
length of the run, runs, threads. Time is that of the processor, the least of some repeats; memory is the peak of a
process of its own above what it held before, with indexes kept and with whole logs. `many`: the C3 loop of Lu et al.'s
X axis with the mass drawn, one thread, by closed_loop_batch and by sweep, each in a process of its own.
"""

import time

import numpy as np

import cogging
from tests.benchmarks import child
from tests.benchmarks.lu2008_loop import core_arguments, random_coefficients

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
    points, harmonics = sizes["control points"], list(range(1, sizes["harmonics"] + 1))
    amplitudes = 0.05 / np.sqrt(len(harmonics)) * np.ones((2, len(harmonics), points))
    basis = cogging.SplineHarmonics(pitch=PITCH, harmonics=harmonics, order=min(points, 3), control_points=points)
    effects = [cogging.EFFECTS[name](**fields) for name, fields in EFFECTS[: sizes["effects"]]]
    axis = cogging.AxisParameters(mass=0.12, viscous=0.17, coulomb=0.15, coulomb_width=0.01)
    plant = cogging.Plant(axis, cogging=cogging.CoggingModel(basis, *amplitudes), effects=effects)
    controller = cogging.Pid(cogging.PidParameters(sample_rate=RATE, kp=9600.0, ki=1e5, kd=48.0, mass=0.12))
    count = 128 if what == "threads" else sizes["runs"]
    options = {"duration": float(sizes["seconds of a run"]), "threads": sizes["threads"]}
    return ([plant] * count, [controller] * count, MOTION), options


def seconds_of(what, size, repeats):
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
    """Peak memory of this process beyond what it held before the runs, MB."""
    warm, options = case("runs", 8)
    cogging.closed_loop_batch(*warm, **options)
    arguments, options = case(what, size)
    before = child.peak_megabytes()
    kept = cogging.closed_loop_batch(*arguments, **options, logs=logs)
    assert not kept.failures
    return child.peak_megabytes() - before


def grown(repeats, with_memory=False):
    """Sizes and seconds of each thing that grows; MB with indexes and with logs too, if asked."""
    found = {}
    for what, sizes in GROWN.items():
        found[what] = {"sizes": sizes, "seconds": [seconds_of(what, size, repeats) for size in sizes]}
        for kept, logs in (("indexes", False), ("logs", True)) if with_memory else ():
            found[what][kept] = [child.call(megabytes_of, what, size, logs) for size in sizes]
    return found


def many(kind, runs, rows):
    """Seconds of the processor and peak MB of this process for so many runs by "batch" or "sweep"."""
    plant, controller, motion = core_arguments(random_coefficients())
    parts = {"axis": plant.axis, "cogging": plant.cogging, "encoder": plant.encoder}
    model = cogging.Model(**parts, controller=controller.parameters, controller_type="dcarc")
    duration, begin = (rows - 1) / model.controller.sample_rate, time.process_time()
    if kind == "sweep":
        varied = {"axis.mass": {"mean": 0.12, "deviation": 0.004}}
        found = cogging.sweep(model, motion, varied, method="random", runs=runs, duration=duration, threads=1)
        assert found.failed == 0
    else:
        masses = np.random.default_rng(0).normal(0.12, 0.004, runs)
        plants = [model.replace(axis=model.axis.replace(mass=mass)).plant() for mass in masses]
        controllers = [model.make_controller() for _ in plants]
        found = cogging.closed_loop_batch(plants, controllers, motion, duration=duration, threads=1)
        assert not found.failures
    assert len(found) == runs
    return {"seconds": time.process_time() - begin, "peak": child.peak_megabytes()}


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
