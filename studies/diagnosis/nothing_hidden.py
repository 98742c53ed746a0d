"""What `diagnose` says where nothing is hidden: `python -m studies.diagnosis.nothing_hidden [MACHINES [FIRST]]`.

Axes under a PID controller are drawn, with force noise of 0.2 to 2 % of the largest command and an encoder so fine that
it shows how this noise moves the axis at rest. Each is judged with its reference and without it.
"""

import sys

import numpy as np

import cogging
from cogging_command import run_command


def drawn(seed: int) -> tuple[cogging.Model, cogging.Model, list[cogging.PointToPoint]]:
    """Draw a machine: as it is, as it is stated, and its given and confirm motion."""
    rng = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    mass, acceleration, velocity, length = between(0.05, 20.0), between(2.0, 15.0), between(0.1, 0.6), between(0.1, 0.6)
    peak = mass * acceleration
    stated = {
        "mass": mass,
        "viscous": peak * between(0.01, 0.15) / velocity,
        "coulomb": peak * between(0.01, 0.25),
        "coulomb_width": between(3e-4, 3e-3),
    }
    true = {name: value * between(0.95, 1.05) for name, value in stated.items()}
    rate = float(rng.choice([1000, 2000, 4000]))
    crossover, noise = min(between(80.0, 500.0), 0.4 * rate), peak * between(0.002, 0.02)  # rad/s, V
    gains = {"kp": 0.2 * mass * crossover**2, "ki": mass * crossover**3 * between(0.003, 0.03), "kd": mass * crossover}
    same = {
        "encoder": cogging.EncoderParameters(resolution=between(0.1, 8.0) * noise / (mass * crossover * rate)),
        "noise": cogging.NoiseParameters(force=noise, bandwidth=between(15.0, 200.0)),
        "controller": cogging.PidParameters(sample_rate=rate, **gains, **stated),
        "controller_type": "pid",
        "uncertainty": {"mass": 0.05, "viscous": 0.2, "coulomb": 0.2},
    }
    travel = [0.0, 1.25 * length]

    def motion(slower: float, start: float, distance: float) -> cogging.PointToPoint:
        limits = {"velocity": velocity * slower, "acceleration": acceleration * slower}
        jerk, places = 60.0 * acceleration * slower, {"start": start * length, "distance": distance * length}
        return cogging.PointToPoint(cogging.PointToPointParameters(**places, **limits, jerk=jerk, dwell=0.1, repeats=3))

    models = [cogging.Model(axis=cogging.AxisParameters(**axis, travel=travel), **same) for axis in (true, stated)]
    return models[0], models[1], [motion(0.65, 0.1, 0.7), motion(1.0, 0.3, 0.45)]


def main() -> int:
    count, first = (int(text) for text in (*sys.argv[1:], *("100", "0")[len(sys.argv) - 1 :]))
    wrong = {"with the reference": 0, "without": 0}
    for seed in range(first, first + count):
        true, stated, motions = drawn(seed)
        runs = [cogging.simulate(true, motion, duration=8.0, seed=10 * seed + k) for k, motion in enumerate(motions)]
        bare = [cogging.Log(log.time, log.position, log.command) for log in runs]
        for case, logs in zip(wrong, (runs, bare), strict=True):
            model = stated.replace(controller=None, controller_type=None)
            said = cogging.diagnose(logs[0], model, confirm=logs[1])
            wrong[case] += said.verdict != "no_gap"
            if said.verdict != "no_gap":
                names = ", ".join(f"{effect.name} ({effect.confidence:.2f})" for effect in said.effects)
                print(f"machine {seed}, {case}: {said.verdict} {names}", flush=True)
    print(f"machines of {count} that do not end in no_gap: {', '.join(f'{n} {case}' for case, n in wrong.items())}")
    return 0


if __name__ == "__main__":
    sys.exit(run_command(main))
