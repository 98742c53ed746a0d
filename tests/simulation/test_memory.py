"""What does not fit into memory is refused before it is allocated, and what is just below is computed."""

import os
import subprocess
import sys

import numpy as np
import pytest

import cogging
from tests.fixtures import command_files

ROOM = 150_000_000  # bytes that the process below may still take, of which 0.8 are granted
LINE = "must fit into memory: "

CODE = """
import resource, sys
import numpy as np
import cogging
from cogging import _core

plant = cogging.Plant(cogging.AxisParameters(mass=0.12, viscous=0.2))
pid = cogging.Pid(cogging.PidParameters(sample_rate=1e6, kp=9600.0, kd=48.0))
slow = cogging.Dcarc(cogging.AdaptiveRobustParameters(cogging_harmonics=[1, 2, 3], cogging_control_points=40))
move = cogging.Sine(cogging.SineParameters(amplitude=0.01, frequency=2.0))

def kilobytes(word):
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith(word))

def refused(call):
    peak = kilobytes("VmHWM")
    try:
        call()
    except ValueError as error:
        assert kilobytes("VmHWM") - peak < 20_000, "it was allocated"
        print(error)
        return
    raise AssertionError("it was computed")

run = lambda samples, **more: cogging.closed_loop(plant, pid, move, duration=1e-6 * samples, **more)
batch = lambda runs, samples, **more: cogging.closed_loop_batch(
    [plant] * runs, [pid] * runs, move, duration=1e-6 * samples, threads=1, **more)
run(100), batch(2, 100)
resource.setrlimit(resource.RLIMIT_AS, (1024 * kilobytes("VmSize") + ROOM, resource.RLIM_INFINITY))
refused(lambda: run(1_900_000))
refused(lambda: run(300_000_000))
refused(lambda: cogging.closed_loop(plant, slow, move, duration=60_000 / 5000.0, record_estimates=True))
refused(lambda: batch(30, 100_000, logs=True))
refused(lambda: batch(30, 100_000, logs=True, progress=lambda step: None))
refused(lambda: batch(30, 100_000, columns=["time", "position", "command", "reference", "true_position"]))
print(batch(30, 10_000, logs=True)[29].time.size, batch(30, 100_000).columns)
print(len(run(1_000_000)))
""".replace("ROOM", str(ROOM))


@pytest.mark.skipif(sys.platform != "linux", reason="addresses are counted on Linux alone")
def test_what_does_not_fit_is_refused():
    """120 MB are granted: 1.87 million samples of 8 columns, or 30 runs of 62,000. A batch may keep no rows."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    first, second, estimates, at_once, in_parts, of_some, rows, made = done.stdout.splitlines()
    assert first.startswith(f"duration: {LINE}1900001 samples of 8 columns take 122 MB and 1")
    assert first.endswith(" are free, got 1.9")
    assert second.startswith(f"duration: {LINE}300000001 samples of 8 columns take 19.2 GB and ")
    assert f"60001 samples of {8 + 4 + 2 * 3 * 40} columns take " in estimates
    assert at_once.startswith(f"duration: {LINE}30 runs of 100001 rows of 8 columns take 192 MB and ")
    assert in_parts.startswith(at_once.partition(" take ")[0])
    assert of_some.startswith(f"duration: {LINE}30 runs of 100001 rows of 5 columns take 120 MB and ")
    assert (rows, made) == ("10001 {}", "1000001")


def test_results_of_calls_are_counted():
    model = command_files.model()
    with pytest.raises(ValueError, match=f"^samples: {LINE}100000000 machines take"):
        cogging.predict_error(model, command_files.REFERENCE, samples=10**8)
    few = {"axis.mass": {"from": 0.11, "to": 0.13}}
    assert len(cogging.sweep(model, command_files.REFERENCE, few, method="random", runs=2, duration=0.01)) == 2
    position = np.linspace(0.0, 1.0, 400_001)
    with pytest.raises(ValueError, match=rf"^position: {LINE}400001 points by 10000[0-9] lines"):
        cogging.fit_map(position, position, pitch=1e-5)
