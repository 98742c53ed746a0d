"""Memory of a call, bytes a row: `python -m tests.attack.memory_peaks [TASK ROWS ...]`; Linux alone."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable

import numpy as np

import cogging
from tests.benchmarks.child import peak_megabytes

RATE = 5000.0  # Hz
DEFAULT = ("audit", "300000", "identify", "20000", "identify+13", "20000", "diagnose", "20000", "map", "100000")


def main() -> int:
    """Each task in a process of its own."""
    words = sys.argv[1:] or list(DEFAULT)
    if words[0] == "--one":
        print(measured(words[1], int(words[2])), flush=True)
        return 0
    for task, rows in zip(words[::2], words[1::2], strict=True):
        subprocess.run([sys.executable, "-m", "tests.attack.memory_peaks", "--one", task, rows], check=True)
    return 0


def model_of(points: int) -> cogging.Model:
    """A machine whose map has so many control points."""
    sine, cosine = (0.02 * np.random.default_rng(1).normal(size=(2, 3, points))).tolist()
    axis = {"mass": 0.12, "viscous": 0.166, "coulomb": 0.15, "coulomb_width": 1.11e-3}
    return cogging.Model.from_dict(
        {
            "axis": {**axis, "travel": [0.0, 0.51]},
            "cogging": {"pitch": 0.05, "harmonics": [1, 2, 3], "order": 3, "sine": sine, "cosine": cosine},
            "encoder": {"resolution": 0.5e-6},
            "noise": {"force": 0.01},
            "controller": {"type": "pid", "sample_rate": RATE, "kp": 9600.0, "ki": 1e5, "kd": 48.0, **axis},
        }
    )


def call_of(task: str, rows: int) -> Callable[[], object]:
    """The call to measure: a task of cogging.resources.ROW, `+13` for so many control points of the map, or `map`."""
    name, _, points = task.partition("+")
    if name == "map":
        there = np.linspace(0.0, 0.5, rows // 2)
        position = np.concatenate([there, there[::-1]])
        return lambda: cogging.fit_map(position, 0.05 * np.sin(2.0 * np.pi * position / 0.05), pitch=0.05)
    model = model_of(int(points or 1))
    true = model.replace(effects=[cogging.effects.CableSpring(stiffness=0.4)])
    motion = {"start": 0.05, "distance": 0.4, "velocity": 0.5, "acceleration": 8.0, "jerk": 400.0, "repeats": 10**6}
    move = cogging.PointToPoint(cogging.PointToPointParameters(**motion, dwell=0.1))
    log = cogging.Log.of(cogging.simulate(true, move, duration=rows / RATE, seed=1).columns())
    return lambda: getattr(cogging, name)(log, model)


def measured(task: str, rows: int) -> str:
    """The growth of this process' peak memory over a call."""
    call = call_of(task, rows)
    with open("/proc/self/clear_refs", "w") as file:
        file.write("5")  # the peak is from here on that of now
    before, began = peak_megabytes(), time.monotonic()
    call()
    grown, seconds = peak_megabytes() - before, time.monotonic() - began
    return f"{task}, {rows} rows: {grown:.0f} MB, {grown * 2**20 / rows:.0f} bytes a row ({seconds:.0f} s)"


if __name__ == "__main__":
    sys.exit(main())
