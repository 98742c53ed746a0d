"""What `diagnose` and `identify` take for 20 s of a log: seconds, processor seconds, memory, and where they go.

    .venv/bin/python -m tests.benchmarks.diagnose
    .venv/bin/python -m tests.benchmarks.diagnose --against ../other/python --repeats 3
    .venv/bin/python -m tests.benchmarks.diagnose --profile --cases nothing

Each run is a process of its own, so that its peak of memory is its own; with `--against` a package elsewhere takes
turns with this one. `--profile` runs all on one thread and says which calls the time goes to. Nothing is asserted:
times on a shared machine say little, their ratios more.
"""

import argparse
import concurrent.futures
import cProfile
import json
import os
import pstats
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import cogging
from cogging import EFFECTS, Model
from cogging_command import run_command
from tests.fixtures.moving_axis import motion

SECONDS = 20.0
ROOT = Path(__file__).parents[2]
HIDDEN: dict[str, list[Any]] = {
    "nothing": [],
    "cable_spring": [EFFECTS["cable_spring"](stiffness=1.5)],
    "two effects": [
        EFFECTS["cogging_harmonic"](period=0.0113, sine=0.05),
        EFFECTS["viscous_asymmetry"](difference=0.8),
    ],
}
#: Sample rate (Hz), what is hidden, whether there is other motion to confirm, and what is called.
CASES = {
    "nothing": (5000.0, "nothing", False, "diagnose"),
    "cable_spring": (5000.0, "cable_spring", False, "diagnose"),
    "two effects, confirm": (5000.0, "two effects", True, "diagnose"),
    "nothing, 8 kHz": (8000.0, "nothing", False, "diagnose"),
    "identify": (5000.0, "nothing", False, "identify"),
}
#: What each call counts as: the name of the function, as a profile has it.
GROUPS = {
    "columns of effects": ("added", "propagate", "propagate_transposed", "net_force", "reading_at"),
    "predictions": ("predict", "innovations"),
    "transforms": ("r2c", "c2r", "dct", "_raw_fft"),
    "whitening": ("filtered", "noise_filter", "unadded"),
    "likelihoods": ("fitted", "likeliest", "student_cost"),
    "projections": ("score", "project", "orthonormal", "lstsq", "eigh", "solve"),
    "replays": ("closed_loop", "replay_controller"),
    "imports": ("_find_and_load_unlocked", "_compile_bytecode", "loads", "create_dynamic"),
}


def machine(rate: float, *effects: object) -> Model:
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
        controller=cogging.PidParameters(sample_rate=rate, kp=kp, ki=ki, kd=kd),
        controller_type="pid",
        uncertainty={"mass": 0.03, "viscous": 0.2, "coulomb": 0.2},
    )


def record(seed: int, rate: float, *effects: object) -> cogging.Log:
    """A simulated log."""
    reference = motion(seed, rate, SECONDS)
    return cogging.simulate(machine(rate, *effects), reference, seed=seed, duration=SECONDS, steps_per_sample=2)


def call_of(name: str) -> Callable[[], str]:
    """What a case calls: gives what was found, in a word or two."""
    rate, hidden, confirmed, command = CASES[name]
    effects, model = HIDDEN[hidden], machine(rate)
    log, other = record(1, rate, *effects), record(2, rate, *effects)
    if command == "identify":
        return lambda: f"mass {cogging.identify(log, model).model.axis.mass:.6g}"

    def found() -> str:
        result = cogging.diagnose(log, model, confirm=other if confirmed else ())
        return ", ".join(effect.name for effect in result.effects) or result.verdict

    return found


def peak_of_memory() -> float:
    """The most that this process has held, MB; nan where the system does not say."""
    try:
        import resource
    except ImportError:  # Windows
        return float("nan")
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3)


def measured(name: str) -> dict[str, Any]:
    """One run of a case in this process."""
    call = call_of(name)
    wall, processor = time.perf_counter(), time.process_time()
    found = call()
    spent = {"wall": time.perf_counter() - wall, "processor": time.process_time() - processor}
    return {**spent, "memory": peak_of_memory(), "found": found}


class OneThread(concurrent.futures.Executor):
    """Runs what it is given at once, so that one profile sees all."""

    def __init__(self, *_: Any, **__: Any) -> None:
        pass

    def submit(self, call: Callable[..., Any], /, *arguments: Any, **named: Any) -> concurrent.futures.Future[Any]:
        """Run it."""
        done: concurrent.futures.Future[Any] = concurrent.futures.Future()
        try:
            done.set_result(call(*arguments, **named))
        except Exception as error:
            done.set_exception(error)
        return done

    def map(self, call: Callable[..., Any], *rows: Iterable[Any], **_: Any) -> Iterator[Any]:
        """Run it on each."""
        return map(call, *rows)


def profiled(name: str) -> dict[str, float]:
    """Share of the time that goes to each of GROUPS, all on one thread."""
    for module in list(sys.modules.values()):
        if getattr(module, "__name__", "").startswith("cogging.") and hasattr(module, "ThreadPoolExecutor"):
            module.ThreadPoolExecutor = OneThread  # type: ignore[attr-defined]
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # the core's own threads
    call, profile = call_of(name), cProfile.Profile()
    profile.runcall(call)
    told = dict.fromkeys((*GROUPS, "the rest"), 0.0)
    entries = pstats.Stats(profile).stats  # type: ignore[attr-defined]
    total = sum(entry[2] for entry in entries.values())
    for (_, _, function), entry in entries.items():
        last = function.strip("<>").split(" ")[-1].rsplit(".", 1)[-1].rstrip(">")
        group = next((group for group, names in GROUPS.items() if last in names), "the rest")
        told[group] += entry[2] / total
    return told


def in_process(name: str, package: Path, *options: str) -> dict[str, Any]:
    """The same in a process that imports a package from a folder."""
    paths = os.pathsep.join((str(package), str(ROOT)))
    command = [sys.executable, "-m", "tests.benchmarks.diagnose", "--alone", name, *options]
    done = subprocess.run(command, env=os.environ | {"PYTHONPATH": paths}, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise ValueError(f"{name}: {done.stderr.strip().splitlines()[-1]}")
    return dict(json.loads(done.stdout.splitlines()[-1]))


def table(names: list[str], packages: list[Path], repeats: int) -> None:
    """Print medians of each case, the packages by turns."""
    print(f"{'':<24}{'package':<28}{'wall':>8}{'processor':>11}{'memory':>9}  found")
    for name in names:
        runs: dict[Path, list[dict[str, Any]]] = {package: [] for package in packages}
        for _ in range(repeats):
            for package in packages:
                runs[package].append(in_process(name, package))
        for package, its in runs.items():
            wall, processor, memory = (
                statistics.median(r[key] for r in its) for key in ("wall", "processor", "memory")
            )
            where = str(package)[-26:]
            print(f"{name:<24}{where:<28}{wall:>6.1f} s{processor:>9.1f} s{memory:>6.0f} MB  {its[0]['found']}")


def main() -> None:
    """Print the table, or where the time goes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", nargs="*", choices=list(CASES), default=list(CASES))
    parser.add_argument("--against", type=Path, action="append", default=[], help="folder of another package")
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--profile", action="store_true")
    parser.add_argument("--alone", choices=list(CASES), help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.alone:
        print(json.dumps(profiled(asked.alone) if asked.profile else measured(asked.alone)))
    elif asked.profile:
        for package in [ROOT / "python", *(path.absolute() for path in asked.against)]:
            for name in asked.cases:
                told = in_process(name, package, "--profile")
                shares = ", ".join(f"{group} {100 * share:.0f} %" for group, share in told.items())
                print(f"{name}, {str(package)[-26:]}: {shares}")
    else:
        table(asked.cases, [ROOT / "python", *(path.absolute() for path in asked.against)], asked.repeats)


if __name__ == "__main__":
    sys.exit(run_command(main))
