"""Batches that keep no rows: indexes and reductions equal to those of the logs, and failures as rows."""

import math

import numpy as np
import pytest

import cogging
from cogging.simulation.reductions import INDEXES

AXIS = cogging.AxisParameters(mass=0.12, viscous=0.2, coulomb=0.15, coulomb_width=1e-3, travel=[-1.0, 1.0])


def machine(rng):
    """A machine, its controller and its seed, drawn."""
    axis = AXIS.replace(mass=rng.uniform(0.08, 0.2), coulomb=rng.uniform(0.0, 0.4))
    tone = cogging.EFFECTS["disturbance_tone"](frequency=rng.uniform(5.0, 20.0), sine=rng.uniform(0.1, 0.5))
    encoder = cogging.EncoderParameters(resolution=0.5e-6, noise=1e-7)
    plant = cogging.Plant(axis, effects=[tone], encoder=encoder, noise=cogging.NoiseParameters(force=0.02))
    gains = cogging.PidParameters(kp=rng.uniform(3e3, 1e4), ki=1e4, kd=48.0, sample_rate=float(rng.integers(800, 2500)))
    return plant, cogging.Pid(gains), int(rng.integers(2**40))


def move(rng):
    return cogging.Sine(cogging.SineParameters(amplitude=rng.uniform(0.005, 0.02), frequency=rng.uniform(1.0, 3.0)))


def amplitude(values, phase):
    """Of the best offset + sine + cosine, by numpy's least squares."""
    basis = np.stack([np.ones_like(phase), np.sin(2 * np.pi * phase), np.cos(2 * np.pi * phase)], axis=1)
    return math.hypot(*np.linalg.lstsq(basis, values, rcond=None)[0][1:])


@pytest.mark.parametrize("seed", range(2))
def test_kept_numbers_are_those_of_the_logs(seed):
    rng = np.random.default_rng(seed)
    plants, controllers, seeds = zip(*(machine(rng) for _ in range(4)), strict=True)
    motion, start, stop = move(rng), rng.uniform(0.0, 0.2), rng.uniform(0.5, 1.2)
    share, frequency, period = rng.uniform(0.05, 0.95), rng.uniform(3.0, 30.0), rng.uniform(0.003, 0.01)
    asked = ["command_max", "true_error_rms", "error_final", f"error_quantile({share!r})", "command_quantile(1)"]
    asked += [f"error_tone({frequency!r})", f"command_wave({period!r})"]
    options = {"seeds": seeds, "duration": 1.0, "start": start, "stop": stop, "final_window": 0.1}
    few = {"columns": ["command", "time"], "every": 7}
    batch = cogging.closed_loop_batch(plants, controllers, motion, reductions=asked, **few, **options)
    whole = cogging.closed_loop_batch(plants, controllers, motion, logs=True, **options)
    for run, log in enumerate(whole):
        rows = (log.time >= start) & (log.time < stop)
        said = cogging.performance(log.time, log.error, log.command, start=start, stop=stop, final_window=0.1)
        assert [batch.indexes[name][run] for name in INDEXES] == [getattr(said, name) for name in INDEXES]
        error, command, time = log.error[rows], log.command[rows], log.time[rows]
        true_error = (log.true_position - log.reference)[rows]
        expected = [abs(command).max(), np.sqrt(np.mean(true_error**2)), error[-1], np.quantile(abs(error), share)]
        expected += [abs(command).max(), amplitude(error, frequency * time)]
        expected += [amplitude(command, log.position[rows] / period)]
        np.testing.assert_allclose([batch.indexes[name][run] for name in asked], expected, rtol=1e-7)
        for name in few["columns"]:
            np.testing.assert_array_equal(batch.columns[name][run], getattr(log, name)[::7])


def test_quantiles_of_a_long_run_are_within_their_tolerance():
    plant, _, seed = machine(np.random.default_rng(5))
    pid = cogging.Pid(cogging.PidParameters(kp=5e3, kd=40.0, sample_rate=5000.0))
    shares = [0.0, 0.03, 0.5, 0.9, 0.999, 1.0]
    asked = [f"error_quantile({share})" for share in shares]
    run = {"seeds": [seed], "duration": 14.0}
    batch = cogging.closed_loop_batch([plant], [pid], move(np.random.default_rng(1)), reductions=asked, **run)
    log = cogging.closed_loop(plant, pid, move(np.random.default_rng(1)), seed=seed, duration=14.0)
    assert len(log) > 65536
    got = np.array([batch.indexes[name][0] for name in asked])
    exact = np.quantile(abs(log.error), shares)
    assert exact[0] == got[0] == 0.0 or abs(got[0] / exact[0] - 1) < 7e-4
    np.testing.assert_allclose(got[1:], exact[1:], rtol=7e-4)
    assert (got != exact).any()  # it is the histogram that is held to it


def test_logs_and_slices_of_a_batch_with_a_diverged_run():
    plants = [cogging.Plant(AXIS)] * 4
    pids = [cogging.Pid(cogging.PidParameters(kp=kp, kd=40.0)) for kp in (5e3, 5e3, 1e9, 5e3)]
    run = {"duration": 0.5}
    batch = cogging.closed_loop_batch(plants, pids, move(np.random.default_rng(0)), threads=2, logs=True, **run)
    with pytest.raises(cogging.DivergedError, match=r"^the run diverged at") as alone:
        cogging.closed_loop(plants[2], pids[2], move(np.random.default_rng(0)), **run)
    assert [(failure.run, failure.reason) for failure in batch.failures] == [(2, str(alone.value))]
    assert f"at {batch.failures[0].time:g} s" in str(alone.value)
    with pytest.raises(cogging.DivergedError, match=r"^run 2: the run diverged at"):
        _ = batch.logs
    assert [failure.run for failure in batch[1:][:2].failures] == [1]
    np.testing.assert_array_equal(batch[1:][0].position, batch[3].position)  # noise of the seed 0 in all
    with pytest.raises(ValueError, match=r"^logs: must be recorded to be read"):
        _ = cogging.closed_loop_batch(plants, pids, move(np.random.default_rng(0)), **run)[0]
    assert cogging.closed_loop_batch([], [], move(np.random.default_rng(0)), logs=True).logs == ()
