"""Memory of a call, bytes a row, and its time: `python -m studies.memory_peaks [TASK ROWS ...]`; Linux alone.

Each task runs in a process of its own. `read_log 20000000` makes a CSV of 1 GB in a temporary folder and reads it.
`diagnose+0` has nothing to find, `diagnose+2` two effects and a confirm log of as many rows.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import cogging
from tests.benchmarks import child

RATE = 5000.0  # Hz
DEFAULT = ("audit", "300000", "identify", "20000", "identify+13", "20000", "diagnose", "20000", "map", "100000")


def call_of(task: str, rows: int) -> Callable[[], object]:
    """The call to measure: a task of cogging.resources.ROW, `identify+13` for 13 control points of the map, or another."""
    name, _, count = task.partition("+")
    if name == "read_log":
        phase, folder = np.arange(rows) * 5e-5, tempfile.TemporaryDirectory()
        path = Path(folder.name) / "log.csv"
        columns = {"position": 0.25 + 0.2 * np.sin(phase), "command": np.cos(phase), "reference": 0.2 * np.sin(phase)}
        cogging.Log(time=phase, **{key: np.round(column, 9) for key, column in columns.items()}).write(path)
        return lambda: (folder, cogging.read_log(path))
    if name == "map":
        there = np.linspace(0.0, 0.5, rows // 2)
        position = np.concatenate([there, there[::-1]])
        return lambda: cogging.fit_map(position, 0.05 * np.sin(2.0 * np.pi * position / 0.05), pitch=0.05)
    points, hidden = (1, int(count or 1)) if name == "diagnose" else (int(count or 1), 1)
    sine, cosine = (0.02 * np.random.default_rng(1).normal(size=(2, 3, points))).tolist()
    axis = {"mass": 0.12, "viscous": 0.166, "coulomb": 0.15, "coulomb_width": 1.11e-3}
    model = cogging.Model.from_dict(
        {
            "axis": {**axis, "travel": [0.0, 0.51]},
            "cogging": {"pitch": 0.05, "harmonics": [1, 2, 3], "order": 3, "sine": sine, "cosine": cosine},
            "encoder": {"resolution": 0.5e-6},
            "noise": {"force": 0.01},
            "controller": {"type": "pid", "sample_rate": RATE, "kp": 9600.0, "ki": 1e5, "kd": 48.0, **axis},
        }
    )
    effects = [cogging.effects.CableSpring(stiffness=40.0), cogging.effects.CoulombAsymmetry(difference=0.05)]
    true = model.replace(effects=effects[:hidden])

    def log(speed: float) -> cogging.Log:
        motion = {"start": 0.05, "distance": 0.4, "velocity": speed, "acceleration": 8.0, "jerk": 400.0, "dwell": 0.1}
        move = cogging.PointToPoint(cogging.PointToPointParameters(**motion, repeats=10**6))
        return cogging.Log.of(cogging.simulate(true, move, duration=rows / RATE, seed=1).columns())

    given, options = log(0.5), {"confirm": log(0.3)} if hidden == 2 else {}
    return lambda: getattr(cogging, name)(given, model, **options)


def measured(task: str, rows: int) -> tuple[float, float]:
    """Growth of this process' peak memory over a call, MB, and its seconds."""
    call = call_of(task, rows)
    Path("/proc/self/clear_refs").write_text("5")  # the peak is from here on that of now
    before, begin = child.peak_megabytes(), time.monotonic()
    call()
    return child.peak_megabytes() - before, time.monotonic() - begin


if __name__ == "__main__":
    words = sys.argv[1:] or DEFAULT
    for task, rows in zip(words[::2], map(int, words[1::2]), strict=True):
        grown, seconds = child.call(measured, task, rows)
        print(
            f"{task}, {rows} rows: {grown:.0f} MB, {grown * 2**20 / rows:.0f} bytes a row ({seconds:.0f} s)", flush=True
        )
