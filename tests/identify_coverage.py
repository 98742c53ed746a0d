"""How often the 95 % intervals of `identify` hold the truth: random machines with quantiser and coloured noise.

Run `python -m tests.identify_coverage --machines 200` from the project's root.
"""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

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


def standing(seed: int) -> dict[str, tuple[float, float, float, bool]]:
    """(error / half interval, error of the output error in its sigma, value / truth, determined) of each parameter."""
    case = draw(seed)
    result = identify(case.log, case.nominal)
    known = cogging.parameters_of(case.truth)
    found = {}
    for p in result.parameters:
        true = known[p.path].value
        half = 0.5 * (p.ci95[1] - p.ci95[0])
        found[p.path] = ((p.value - true) / half, p.difference or 0.0, p.value - true, p.determined)
    return found


def coverage(seeds: range, jobs: int) -> dict[str, list[tuple[float, float, float, bool]]]:
    """What `standing` says, by parameter, over the seeds."""
    table: dict[str, list[tuple[float, float, float, bool]]] = {}
    with ProcessPoolExecutor(jobs) as pool:
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
    held = total = 0
    print(f"{'parameter':<32} {'determined':>10} {'held by 95 % interval':>22} {'|check| < 3 sigma':>18}")
    for path, entries in table.items():
        good = [abs(e[0]) <= 1.0 for e in entries if e[3]]
        agree = [abs(e[1]) < 3.0 for e in entries if e[3]]
        held, total = held + sum(good), total + len(good)
        print(f"{path:<32} {len(good):>10} {100 * np.mean(good):>20.1f} % {100 * np.mean(agree):>16.1f} %")
    print(f"{'all':<32} {total:>10} {100 * held / total:>20.1f} %")


if __name__ == "__main__":
    main()
