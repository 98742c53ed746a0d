"""How often the 95 % intervals of `identify` hold the truth: random machines with quantiser and coloured noise.

Run `python -m tests.identify_coverage --machines 200` from the project's root.
"""

from __future__ import annotations

import argparse
import signal
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context

import numpy as np

import cogging
from cogging import (
    EFFECTS,
    AxisParameters,
    CoggingModel,
    EncoderParameters,
    Log,
    Model,
    NoiseParameters,
    PidParameters,
    Sampled,
    SplineHarmonics,
    pid_gains,
)
from cogging.identify import identify
from cogging_command import run_command


@dataclass(frozen=True)
class Case:
    truth: Model
    nominal: Model
    log: Log


def moves(random: np.random.Generator, travel: float, speed: float, duration: float, rate: float) -> Sampled:
    """Smooth moves of random lengths and speeds, with creep, within the travel."""
    time = np.arange(int(duration * rate) + 1) / rate
    position = np.zeros(len(time))
    now, at = 0.1, 0.0
    while now < duration:
        goal = random.uniform(-0.5, 0.5) * travel
        top = speed * float(np.exp(random.uniform(np.log(0.05), 0.0)))
        if abs(goal - at) / top > 2.0:  # creep goes only a little way
            goal = at + np.sign(goal - at) * 2.0 * top
        length = 1.9 * abs(goal - at) / top + 0.02
        s = np.clip((time - now) / length, 0.0, 1.0)
        position += (goal - at) * s**3 * (10 - 15 * s + 6 * s * s)  # minimum jerk: top speed 1.9 times the mean
        now, at = now + length + random.uniform(0.0, 0.1), goal
    return Sampled(time, position, None, None)


def draw(seed: int) -> Case:
    """A machine, what is wrongly believed of it, and its log."""
    random = np.random.default_rng(seed)
    mass = float(np.exp(random.uniform(np.log(0.1), np.log(50.0))))
    travel, speed = random.uniform(0.2, 0.6), random.uniform(0.1, 0.6)
    rate = float(random.choice([1000.0, 2000.0, 5000.0]))
    level = mass * random.uniform(0.5, 2.0)  # V, Coulomb friction as that of 0.5 to 2 m/s^2
    exact = random.random() < 0.3
    width = 0.0 if exact else float(np.exp(random.uniform(np.log(5e-4), np.log(5e-3))))
    axis = AxisParameters(
        mass=mass, viscous=level / speed * random.uniform(0.1, 1.0), coulomb=level, coulomb_width=width
    )
    pitch = random.uniform(0.02, 0.05)
    basis = SplineHarmonics(pitch=pitch, harmonics=[1, 2], control_points=1)
    sine, cosine = (level * random.normal(0.0, 0.3, (2, 1)) for _ in range(2))
    offset = level * random.normal(0.0, 0.2)
    kp, ki, kd = pid_gains([-random.uniform(60.0, 150.0)] * 3, mass)
    controller = PidParameters(sample_rate=rate, kp=kp, ki=ki, kd=kd)
    truth = Model(
        axis=axis,
        cogging=CoggingModel(basis, sine, cosine),
        effects=(EFFECTS["constant_force"](force=offset),),
        encoder=EncoderParameters(resolution=float(random.choice([1e-7, 5e-7, 1e-6])), noise=1e-7),
        noise=NoiseParameters(
            force=level * float(np.exp(random.uniform(np.log(0.005), np.log(0.05)))),
            bandwidth=float(np.exp(random.uniform(np.log(10.0), np.log(200.0)))),
        ),
        controller=controller,
        controller_type="pid",
    )
    wrong = 1.0 + 0.2 * random.normal(size=3).clip(-2, 2)
    nominal = truth.replace(
        axis=axis.replace(
            mass=mass * (1.0 + 0.05 * random.normal()),
            viscous=axis.viscous * wrong[1],
            coulomb=level * wrong[2],
            coulomb_width=width * float(np.exp(random.normal(0.0, 0.3))),
        ),
        cogging=CoggingModel(basis, sine * 0.9, cosine + 0.05 * level),
        effects=(EFFECTS["constant_force"](force=0.0),),
        noise=NoiseParameters(),
    )
    reference = moves(random, travel, speed, 12.0, rate)
    return Case(truth, nominal, cogging.simulate(truth, reference, seed=seed, duration=12.0, steps_per_sample=20))


@dataclass(frozen=True)
class Standing:
    """One fitted parameter beside the truth.

    Attributes:
        error: in halves of the 95 % interval: at most 1 where it holds the truth.
        check: output error less inverse dynamics, in their standard deviation.
    """

    error: float
    check: float


def standing(seed: int) -> dict[str, Standing | None]:
    """Where the truth of each parameter stands; None where the log does not determine it."""
    case = draw(seed)
    known = cogging.parameters_of(case.truth)
    found: dict[str, Standing | None] = {}
    for p in identify(case.log, case.nominal).parameters:
        half = 0.5 * (p.ci95[1] - p.ci95[0])
        error = (p.value - known[p.path].value) / half
        found[p.path] = Standing(error, p.difference or 0.0) if p.determined else None
    return found


def coverage(seeds: range, jobs: int) -> dict[str, list[Standing | None]]:
    """What `standing` says, by parameter, over the seeds."""
    table: dict[str, list[Standing | None]] = {}
    ignored = {"initializer": signal.signal, "initargs": (signal.SIGINT, signal.SIG_IGN)}  # the parent ends them
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), **ignored) as pool:
        for found in pool.map(standing, seeds):
            for path, entry in found.items():
                table.setdefault(path, []).append(entry)
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--machines", type=int, default=200)
    parser.add_argument("--seed", type=int, default=10_000)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    table = coverage(range(options.seed, options.seed + options.machines), options.jobs)
    everything = [entry for entries in table.values() for entry in entries]
    print(f"{'parameter':<32} {'determined':>12} {'held by the 95 % interval':>26} {'|check| < 3 sigma':>18}")
    for path, entries in {**table, "all": everything}.items():
        good = [entry for entry in entries if entry is not None]
        held = np.mean([abs(entry.error) <= 1.0 for entry in good])
        agree = np.mean([abs(entry.check) < 3.0 for entry in good])
        share = f"{len(good)}/{len(entries)}"
        print(f"{path:<32} {share:>12} {100 * held:>24.1f} % {100 * agree:>16.1f} %")


if __name__ == "__main__":
    sys.exit(run_command(main))
