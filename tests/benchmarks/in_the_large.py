"""Two machines whose model lacks what makes most of their command, by the project's own simulator, over scales.

    .venv/bin/python -m tests.benchmarks.in_the_large harmonic
    .venv/bin/python -m tests.benchmarks.in_the_large resonance --scales 1

`harmonic`: a motor that cogs 7 times a turn with 0.79 V times the scale, slow moves under a PID that is not stated.
`resonance`: two masses whose resonance lies within the band of a multisine, which drives them in open loop with 1 V rms
times the scale. One line a case: verdict, names, parameters, gaps, seconds. Nothing is asserted.
"""

import argparse
import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np

import cogging
from cogging import EFFECTS, AxisParameters, EncoderParameters, Log, Model, PidParameters
from cogging_command import run_command
from tests.blind.runners import within

SCALES = (0.02, 0.03, 0.1, 0.3, 1.0, 3.0)
QUANTUM = 9.6e-5  # rad, 2^16 counts a turn
SIZE = (0.6, 0.514)  # V, sine and cosine of the harmonic at the scale 1: 0.79 V
TWO_MASSES = {"sample_rate": 1000.0, "seconds": 10.0, "band": (2.0, 150.0)}


def motor(*effects: object) -> Model:
    """A small motor in its bearings, position in rad; it sticks."""
    return Model(
        axis=AxisParameters(mass=0.0035, viscous=0.14, coulomb=0.17, coulomb_width=0.0),
        effects=tuple(effects),
        encoder=EncoderParameters(resolution=QUANTUM),
    )


def harmonic_logs(scale: float) -> tuple[Log, Log]:
    """A turn and back at 0.63 rad/s, and at 0.19 rad/s, without a reference."""
    sine, cosine = scale * np.array(SIZE)
    truth = motor(EFFECTS["cogging_harmonic"](period=2 * np.pi / 7, sine=sine, cosine=cosine))
    loop = PidParameters(sample_rate=400.0, kp=20.0, ki=20.0, kd=0.3)
    truth = truth.replace(controller=loop, controller_type="pid")
    logs = []
    for seed, velocity in enumerate((0.63, 0.19)):
        move = {"type": "point_to_point", "start": 0.0, "distance": 6.26, "velocity": velocity}
        move |= {"acceleration": 5.0, "jerk": 100.0, "dwell": 0.2, "repeats": 1}
        log = cogging.simulate(truth, move, seed=seed)
        logs.append(Log(log.time, log.position, log.command))
    return logs[0], logs[1]


def two_masses(*effects: object) -> Model:
    """A motor with a load behind a belt, position in m."""
    return Model(
        axis=AxisParameters(mass=0.5, viscous=1.0, coulomb=0.1, coulomb_width=2e-3),
        effects=tuple(effects),
        encoder=EncoderParameters(resolution=1e-7),
    )


def multisine(seed: int, scale: float) -> np.ndarray:
    """A command whose tones are even between the ends of the band, of random phase, (n,)."""
    rng = np.random.default_rng(seed)
    rate, seconds = TWO_MASSES["sample_rate"], TWO_MASSES["seconds"]
    t = np.arange(int(rate * seconds)) / rate
    lines = np.unique(np.round(np.linspace(*TWO_MASSES["band"], 120) * seconds)) / seconds
    waves = np.sin(2 * np.pi * np.outer(t, lines) + rng.uniform(0, 2 * np.pi, len(lines))).sum(axis=1)
    return scale * waves / np.sqrt(np.mean(waves**2)) * np.clip(np.minimum(t, t[-1] - t) / 0.3, 0.0, 1.0)


def resonance_logs(scale: float, frequency: float, load: float) -> tuple[Log, Log]:
    """Two runs in open loop, of other phases."""
    mode = EFFECTS["flexible_mode"](frequency=frequency, damping_ratio=0.03, mass_ratio=load)
    rate = TWO_MASSES["sample_rate"]
    idle = PidParameters(sample_rate=rate, kp=0.0, ki=0.0, kd=0.0)
    truth = two_masses(mode).replace(controller=idle, controller_type="pid")
    logs = []
    for seed in (1, 2):
        command = multisine(seed, scale)
        t = np.arange(len(command)) / rate
        still = cogging.Sampled(time=t, position=0 * t, velocity=0 * t)
        log = cogging.simulate(truth, still, duration=float(t[-1]), seed=seed, added_command=command)
        logs.append(Log(log.time, log.position, log.command))
    return logs[0], logs[1]


def cases(which: str, scales: list[float]) -> Iterator[tuple[str, tuple[Log, Log], Model]]:
    """What each case is, its log and the one to confirm, and the model of its user."""
    for scale in scales:
        if which == "harmonic":
            yield f"{0.79 * scale:.3g} V at 2 pi / 7 = 0.8976", harmonic_logs(scale), motor()
        else:
            for frequency, load in ((40.0, 0.3), (40.0, 0.6), (60.0, 0.45), (90.0, 0.3), (90.0, 0.6)):
                told = f"{frequency:g} Hz, load {load:g}, {scale:g} V rms"
                yield told, resonance_logs(scale, frequency, load), two_masses()


def tell(log: Log, confirm: Log, model: Model) -> str:
    """Diagnose, and say what came of it on one line."""
    begin = time.perf_counter()
    result = cogging.diagnose(log, model, confirm=confirm)
    seconds = time.perf_counter() - begin
    names = [f"{e.name} {e.confidence:.2f} ({_values(e)})" for e in result.effects]
    kept = ("given", "before", "after", "floor", "confirm_before", "confirm_after")
    values = {name: getattr(result.gap, name, None) for name in kept}
    gaps = ", ".join(f"{name} {value:.3g}" for name, value in values.items() if value is not None)
    axis = result.model.axis
    tuned = f"mass {axis.mass:.3g}, viscous {axis.viscous:.3g}, coulomb {axis.coulomb:.3g}"
    return f"{result.verdict}: {'; '.join(names) or 'nothing'}; gap {gaps}; {tuned}; {seconds:.1f} s"


def _values(effect: Any) -> str:
    found = [effect.parameters, *getattr(effect, "further", ())]
    return " | ".join(", ".join(f"{name} {np.round(p.value, 6)}" for name, p in one.items()) for one in found)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; exit status 0 whatever comes."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.in_the_large", description=__doc__)
    parser.add_argument("which", choices=("harmonic", "resonance"))
    parser.add_argument("--scales", type=float, nargs="+", help="default: 0.02 to 3, of the resonance 0.15 and 1")
    parser.add_argument("--limit", type=float, default=120.0, help="seconds a case; then it has no answer")
    options = parser.parse_args(arguments)
    scales = options.scales or (SCALES if options.which == "harmonic" else (0.15, 1.0))
    for told, (log, confirm), model in cases(options.which, list(scales)):
        answer = within(options.limit, tell, log, confirm, model)
        print(f"{told}: {answer or f'no answer in {options.limit:g} s'}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(run_command(main))
