"""The axis in motion that the tests of `diagnose` look at, and its logs."""

import numpy as np

import cogging
from cogging import Model

RATE = 1000.0


def machine(effects=(), force=0.02):
    kp, ki, kd = cogging.pid_gains([-80.0] * 3, 2.0)
    return Model(
        axis=cogging.AxisParameters(mass=2.0, viscous=3.0, coulomb=1.5, coulomb_width=2e-3),
        cogging=cogging.CoggingModel(cogging.SplineHarmonics(pitch=0.03, harmonics=[1]), [[0.4]], [[0.2]]),
        effects=tuple(effects),
        encoder=cogging.EncoderParameters(resolution=1e-7),
        noise=cogging.NoiseParameters(force=force, bandwidth=40.0),
        controller=cogging.PidParameters(sample_rate=RATE, kp=kp, ki=ki, kd=kd),
        controller_type="pid",
        uncertainty={"mass": 0.03, "viscous": 0.2, "coulomb": 0.2},
    )


def motion(seed, rate=RATE, seconds=8.0):
    """Moves of random length and speed over 0.3 m."""
    random = np.random.default_rng(seed)
    time = np.arange(int(seconds * rate) + 1) / rate
    position, at, now = np.zeros(len(time)), 0.0, 0.1
    while now < seconds - 0.1:
        goal, top = random.uniform(-0.15, 0.15), float(np.exp(random.uniform(np.log(0.02), np.log(0.4))))
        goal = at + float(np.clip(goal - at, -top, top))
        length = 1.9 * abs(goal - at) / top + 0.05
        s = np.clip((time - now) / length, 0.0, 1.0)
        position += (goal - at) * s**3 * (10 - 15 * s + 6 * s * s)
        at, now = goal, now + length + 0.02
    return cogging.Sampled(time, position, None, None)


def record(model, seed):
    return cogging.simulate(model, motion(seed), seed=seed, duration=8.0, steps_per_sample=4)


def pushed(force, seed):
    """A log in which `force` (V) of reference position and velocity acts beside the command, and nobody knows of it."""
    model, reference = machine(), motion(seed)
    log = record(model, seed)
    added = force(log.time, log.reference, np.gradient(log.reference, log.time))
    columns = cogging.closed_loop(
        model.plant(),
        model.make_controller(),
        reference,
        seed=seed,
        duration=8.0,
        steps_per_sample=4,
        added_command=added,
    )
    return cogging.Log(columns["time"], columns["position"], columns["command"] - added)
