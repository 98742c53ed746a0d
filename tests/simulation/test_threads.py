"""Runs that Python starts on several threads at once, of objects that they share and of their own: the same bits."""

import copy
import pickle
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np
import pytest

import cogging

AXIS = cogging.AxisParameters(mass=0.12, viscous=0.166, coulomb=0.15, coulomb_width=1e-3, travel=[0.0, 0.51])
BASIS = cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2])
MAP = cogging.CoggingModel(BASIS, sine=[[0.08], [0.04]], cosine=[[0.0], [0.02]])
EFFECTS = [cogging.effects.CableSpring(stiffness=0.4), cogging.effects.ActuatorLag(time_constant=1e-3)]
THREADS = 4


def plant():
    parts = {"encoder": cogging.EncoderParameters(resolution=0.5e-6), "noise": cogging.NoiseParameters(force=0.01)}
    return cogging.Plant(AXIS, cogging=MAP, effects=EFFECTS, **parts)


def pid():
    return cogging.Pid(cogging.PidParameters(kp=9600.0, ki=1e5, kd=48.0, mass=0.12, viscous=0.166))


def sine():
    return cogging.Sine(cogging.SineParameters(center=0.25, amplitude=0.1, frequency=2.0))


def at_once(work):
    """What `work(i)` gives for i = 0 ... THREADS - 1, all begun at one moment."""
    ready = Barrier(THREADS)

    def begin(i):
        ready.wait()
        return work(i)

    with ThreadPoolExecutor(THREADS) as pool:
        return list(pool.map(begin, range(THREADS)))


def columns(log):
    return np.array([log.time, log.position, log.command, log.true_position])


@pytest.mark.parametrize("shared", [True, False])
def test_runs_on_threads_are_the_runs_of_one(shared):
    """Each with a seed of its own, whether plant, controller and reference are one object or four."""
    given = [(plant(), pid(), sine()) for _ in range(THREADS)]
    alone = [columns(cogging.closed_loop(*given[0], duration=0.5, seed=i)) for i in range(THREADS)]
    assert not np.array_equal(alone[0], alone[1])  # the seeds tell them apart
    found = at_once(lambda i: columns(cogging.closed_loop(*given[0 if shared else i], duration=0.5, seed=i)))
    np.testing.assert_array_equal(found, alone)


def test_models_are_read_and_copied_by_threads_at_once():
    """Copies, pickles and values of one object, which Python makes under its lock or without one."""
    model = cogging.Model(axis=AXIS, cogging=MAP, effects=EFFECTS)
    positions = np.linspace(0.0, 0.5, 2000)
    force = MAP.force(positions)

    def work(_):
        for _ in range(20):
            assert copy.deepcopy(model) == model
            assert pickle.loads(pickle.dumps(model)) == model
            np.testing.assert_array_equal(MAP.force(positions), force)
            assert BASIS.harmonics == [1, 2]
        return True

    assert at_once(work) == [True] * THREADS


def test_batches_on_threads_are_the_batch_of_one():
    """Batches that start threads of their own, from threads of Python."""
    many = [plant()] * 3, [pid()] * 3, sine()
    options = {"duration": 0.2, "seeds": [1, 2, 3], "threads": 2, "logs": True}
    alone = [columns(log) for log in cogging.closed_loop_batch(*many, **options)]
    for found in at_once(lambda _: [columns(log) for log in cogging.closed_loop_batch(*many, **options)]):
        np.testing.assert_array_equal(found, alone)
