"""Time and memory of `diagnose` and `identify` on 20 s of a log: `python -m tests.benchmarks.diagnose [CASE ...]`.

Each case runs in a process of its own, so that its peak of memory is its own. Nothing is asserted.
"""

import sys
import time

import cogging
from cogging import EFFECTS
from cogging_command import run_command
from tests.benchmarks import child
from tests.fixtures.moving_axis import motion

SECONDS = 20.0
SPRING = [EFFECTS["cable_spring"](stiffness=1.5)]
TWO = [EFFECTS["cogging_harmonic"](period=0.0113, sine=0.05), EFFECTS["viscous_asymmetry"](difference=0.8)]
#: Sample rate (Hz), hidden effects, whether a log of other motion confirms, and the function to call.
CASES = {
    "nothing": (5000.0, [], False, "diagnose"),
    "cable_spring": (5000.0, SPRING, False, "diagnose"),
    "two effects, confirm": (5000.0, TWO, True, "diagnose"),
    "nothing, 8 kHz": (8000.0, [], False, "diagnose"),
    "identify": (5000.0, [], False, "identify"),
}


def machine(rate):
    """An axis of 2 V/(m/s^2) with three known harmonics of cogging."""
    kp, ki, kd = cogging.pid_gains([-120.0] * 3, 2.0)
    basis = cogging.SplineHarmonics(pitch=0.03, harmonics=[1, 2, 3])
    return cogging.Model(
        axis=cogging.AxisParameters(mass=2.0, viscous=3.0, coulomb=1.5, coulomb_width=2e-3),
        cogging=cogging.CoggingModel(basis, [[0.4], [0.1], [0.05]], [[0.2], [0.1], [0.02]]),
        encoder=cogging.EncoderParameters(resolution=1e-7),
        noise=cogging.NoiseParameters(force=0.02, bandwidth=60.0),
        controller=cogging.PidParameters(sample_rate=rate, kp=kp, ki=ki, kd=kd),
        controller_type="pid",
        uncertainty={"mass": 0.03, "viscous": 0.2, "coulomb": 0.2},
    )


def measured(name):
    """Wall and processor time (s), peak memory (MB) and result of a case in this process."""
    rate, effects, confirmed, function = CASES[name]
    model = machine(rate)
    real = model.replace(effects=effects)
    log, other = (
        cogging.simulate(real, motion(seed, rate, SECONDS), seed=seed, duration=SECONDS, steps_per_sample=2)
        for seed in (1, 2)
    )
    wall, processor = time.perf_counter(), time.process_time()
    if function == "identify":
        found = f"mass {cogging.identify(log, model).model.axis.mass:.6g}"
    else:
        result = cogging.diagnose(log, model, confirm=other if confirmed else ())
        found = ", ".join(effect.name for effect in result.effects) or result.verdict
    return time.perf_counter() - wall, time.process_time() - processor, child.peak_megabytes(), found


def main(names):
    """Print a line for each case."""
    for name in names or CASES:
        wall, processor, memory, found = child.call(measured, name)
        print(f"{name:<24}{wall:>6.1f} s{processor:>9.1f} s of processor{memory:>6.0f} MB  {found}", flush=True)


if __name__ == "__main__":
    sys.exit(run_command(lambda: main(sys.argv[1:])))
