"""Seconds that `diagnose` takes for 20 s at 5 kHz, beside `identify` on the same log in the same run.

    .venv/bin/python -m tests.benchmarks.diagnose

With nothing hidden, one effect, and two; without and with other motion to confirm. Nothing is asserted: times on a
shared machine say little, their ratios more.
"""

import sys
import time
from collections.abc import Callable
from typing import Any

from tests.fixtures.moving_axis import motion

import cogging
from cogging import EFFECTS, Model
from cogging_command import run_command

RATE, SECONDS = 5000.0, 20.0
HIDDEN = {
    "nothing": [],
    "cable_spring": [EFFECTS["cable_spring"](stiffness=1.5)],
    "cogging_harmonic, viscous_asymmetry": [
        EFFECTS["cogging_harmonic"](period=0.0113, sine=0.05),
        EFFECTS["viscous_asymmetry"](difference=0.8),
    ],
}


def machine(*effects: object) -> Model:
    """An axis of 2 V/(m/s^2) with three known harmonics of cogging."""
    kp, ki, kd = cogging.pid_gains([-120.0] * 3, 2.0)
    return Model(
        axis=cogging.AxisParameters(mass=2.0, viscous=3.0, coulomb=1.5, coulomb_width=2e-3),
        cogging=cogging.CoggingModel(
            cogging.SplineHarmonics(pitch=0.03, harmonics=[1, 2, 3]), [[0.4], [0.1], [0.05]], [[0.2], [0.1], [0.02]]
        ),
        effects=tuple(effects),
        encoder=cogging.EncoderParameters(resolution=1e-7),
        noise=cogging.NoiseParameters(force=0.02, bandwidth=60.0),
        controller=cogging.PidParameters(sample_rate=RATE, kp=kp, ki=ki, kd=kd),
        controller_type="pid",
        uncertainty={"mass": 0.03, "viscous": 0.2, "coulomb": 0.2},
    )


def record(seed: int, *effects: object) -> cogging.Log:
    """A simulated log."""
    return cogging.simulate(
        machine(*effects), motion(seed, RATE, SECONDS), seed=seed, duration=SECONDS, steps_per_sample=2
    )


def timed(run: Callable[[], Any]) -> tuple[float, Any]:
    """Seconds of a call, and what it gives."""
    start = time.perf_counter()
    result = run()
    return time.perf_counter() - start, result


def main() -> None:
    """Print the table."""
    print(f"{'hidden':<38}{'identify':>10}{'diagnose':>10}{'ratio':>7}{'--confirm':>11}{'ratio':>7}  named")
    for name, effects in HIDDEN.items():
        log, other = record(1, *effects), record(2, *effects)
        usual, _ = timed(lambda log=log: cogging.identify(log, machine()))
        alone, _ = timed(lambda log=log: cogging.diagnose(log, machine()))
        both, result = timed(lambda log=log, other=other: cogging.diagnose(log, machine(), confirm=other))
        named = ", ".join(effect.name for effect in result.effects) or result.verdict
        print(
            f"{name:<38}{usual:>8.1f} s{alone:>8.1f} s{alone / usual:>7.1f}{both:>9.1f} s{both / usual:>7.1f}  {named}"
        )


if __name__ == "__main__":
    sys.exit(run_command(main))
