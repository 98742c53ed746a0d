"""The runs of a motor that cogs more than all else, read from files like the originals with drawn numbers."""

import numpy as np
import pytest

from cogging.datasets import odrive

CLONE = "analysis/cogging_torque"


def place(name, below):
    """Where a file stands: in a folder of the set's name, or as in a clone."""
    if name in odrive.SCANS:
        file = f"cogging_measure_{odrive.SCANS[name]}.npy"
        return f"odrive/{file}" if below == "named" else f"{CLONE}/{file}"
    group, run, number = name.rsplit("_", 2)
    return f"odrive/{name}.npy" if below == "named" else f"{CLONE}/{group}/{run}_{number}.npy"


def write(path, values):
    path.parent.mkdir(parents=True, exist_ok=True)
    np.save(path, values)


def polled(rng, rows=400):
    """Time, counts and the current that acts between the rows of a slow run that jumps from tooth to tooth."""
    time = np.cumsum(rng.uniform(1.5e-3, 6e-3, rows))
    counts = 8192 / (2 * np.pi) * (0.5 * time + 0.05 * np.sin(20 * time))
    return time, counts, rng.normal(0.3, 0.8, rows)


def smoothed(time, current, before=0.0):
    """What the drive reports at the rows of a current that is held between them: exactly, by its equation."""
    smooth = [before]
    for step, acting in zip(np.diff(time), current[:-1], strict=True):
        smooth.append(acting + (smooth[-1] - acting) * np.exp(-step / odrive.SMOOTHING))
    return np.array(smooth)


@pytest.mark.parametrize(("below", "seed"), [("named", 1), ("clone", 2)])
def test_the_acting_current_is_recovered_from_the_smoothed_one(tmp_path, seed, below):
    rng = np.random.default_rng(seed)
    name = str(rng.choice(odrive.FILES))
    time, counts, current = polled(rng)
    smooth = smoothed(time, current, rng.normal())
    write(tmp_path / place(name, below), np.array([time, counts, smooth]))
    log = odrive.read(name, tmp_path)
    np.testing.assert_array_equal(log.time, time[:-1])
    np.testing.assert_allclose(log.position, counts[:-1] * 2 * np.pi / 8192, rtol=1e-14)
    np.testing.assert_allclose(log.command, current[:-1], atol=1e-9)
    recorded = odrive.read(name, tmp_path, smoothed=True)
    np.testing.assert_array_equal(recorded.time, time)
    np.testing.assert_array_equal(recorded.command, smooth)


def test_a_way_back_is_left_out_until_the_motor_rests(tmp_path):
    rng = np.random.default_rng(0)
    time, counts, current = polled(rng, 800)
    back = int(rng.integers(60, 120))
    counts[:back] += np.linspace(8192 * rng.uniform(0.9, 1.0), 0.0, back)
    write(tmp_path / "slow2_nocomp_1.npy", np.array([time, counts, current]))
    log, whole = (odrive.read("slow2_nocomp_1", tmp_path, smoothed=True, rewind=rewind) for rewind in (False, True))
    assert len(whole.time) == 800
    assert time[back - 1] + 0.29 < log.time[0] < time[back - 1] + 0.32
    np.testing.assert_array_equal(log.command, whole.command[-len(log.time) :])
    assert log.time[-1] == whole.time[-1]


@pytest.mark.parametrize(("name", "below"), list(zip(odrive.SCANS, ["named", "named", "clone"], strict=True)))
def test_a_scan_holds_the_places_that_were_visited(tmp_path, name, below):
    rng = np.random.default_rng(len(name))
    first = 15 if name == "backward" else 0
    held = np.zeros(8192)
    held[first::16] = rng.normal(0.2, 0.5, 512)
    write(tmp_path / place(name, below), held)
    scan = odrive.scan(name, tmp_path)
    np.testing.assert_array_equal(scan.current, held[first::16])
    np.testing.assert_allclose(np.diff(scan.position), 2 * np.pi / 512)
    assert scan.position[0] == pytest.approx(first * 2 * np.pi / 8192)
