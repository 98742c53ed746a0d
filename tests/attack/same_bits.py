"""`python -m tests.attack.same_bits [NAME ...]`: the commands under other conditions; status 1 where bits differ.

Each command runs in a process of its own under another hash seed, locale, time zone and folder, other numbers of
threads, and the instructions of other processors: kernels of OpenBLAS, functions of NumPy and the mathematics library,
our packs. On another processor what the core alone computes has the same bits; where linear algebra takes part, words,
choices and counts are the same, and numbers within ALLOWED.
"""

import argparse
import os
import platform
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import cogging
from cogging import _core
from cogging.outputs import to_toml
from tests.fixtures import command_files

#: Words of each command over the files of `write_inputs`.
CALLS = {
    "simulate": "simulate noisy.toml --reference ref.toml --out run.csv --seed 3",
    "sweep": "sweep runs.toml --out runs.csv",
    "reproduce": "reproduce xu2001 --out results",
    "init": "init log.csv --out first.toml --reference moves.toml",
    "audit": "audit log.csv --model model.toml --json audit.json",
    "map": "map scan.csv --pitch 0.05 --json map.json",
    "identify": "identify log.csv other.csv --model model.toml --out fitted.toml --json fit.json",
    "diagnose": "diagnose log.csv --model model.toml --confirm other.csv --out better.toml --json found.json",
    "experiment": "experiment --model model.toml --result result.json --limits limits.toml --out next.toml",
    "predict": "predict model.toml --reference ref.toml --samples 8 --json errors.json",
    "tune": "tune tune.toml --out tuned.toml --json tuned.json",
}
CORE_ALONE = ("simulate", "sweep")
ALLOWED = 1e-4  # relative, of numbers of an answer with linear algebra in it on another processor
ROUNDING = 1e-12  # smaller numbers are what is left of a difference: they have no first digit
NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?!\w)")
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
#: OpenBLAS kernels and what each needs.
OPENBLAS = {"Prescott": "SSE3", "Nehalem": "SSE3", "Sandybridge": "AVX", "Haswell": "AVX2", "SkylakeX": "AVX512F"}
#: Tunables of GNU's mathematics library, by processors without these.
OLD_LIBRARY = "glibc.cpu.hwcaps=-AVX2,-AVX2_Usable,-FMA,-FMA_Usable,-FMA4,-AVX512F"


@dataclass(frozen=True)
class Condition:
    """What differs: environment, more words of `sweep` and `tune`, folder; `is_processor`: another of the same kind."""

    name: str
    variables: dict[str, str] = field(default_factory=dict)
    words: tuple[str, ...] = ()
    folder: str = "usual"
    is_processor: bool = False


def write_inputs(folder: Path) -> None:
    folder.mkdir(parents=True)
    command_files.write(folder)
    noisy = {**command_files.MODEL, "noise": {"force": 0.02}, "encoder": {"resolution": 1e-6, "noise": 2e-7}}
    noisy["effects"] = [{"name": "stribeck_friction", "static_excess": 0.05, "velocity": 0.01, "exponent": 1.4}]
    noisy["effects"] += [{"name": "actuator_lag", "time_constant": 4e-4}]
    noisy["effects"] += [{"name": "end_effect", "force": 0.3, "decay_length": 0.03}]
    (folder / "noisy.toml").write_text(to_toml(noisy))
    vary = {"axis.mass": {"from": 0.11, "to": 0.13}, "axis.coulomb": {"from": 0.1, "to": 0.2}}
    runs = {**command_files.SWEEP, "model": "noisy.toml", "runs": 24, "duration": 0.2, "vary": vary}
    (folder / "runs.toml").write_text(to_toml(runs))


def answer(name: str, condition: Condition, inputs: Path, scratch: Path) -> dict[str, str]:
    """Texts that a command printed (by "") and wrote (by path) under a condition, from a copy of its inputs."""
    folder = scratch / condition.folder / name
    folder.mkdir(parents=True)
    for path in inputs.iterdir():
        (folder / path.name).write_bytes(path.read_bytes())
    environment = {key: value for key, value in os.environ.items() if not key.endswith("_NUM_THREADS")}
    package = str(Path(cogging.__file__).resolve().parents[1])
    environment |= {"PYTHONHASHSEED": "0", "PYTHONPATH": package, "MPLBACKEND": "agg", **condition.variables}
    words = [*CALLS[name].split(), *condition.words]
    command = [sys.executable, "-m", "cogging", *words]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", cwd=folder, env=environment)
    assert done.returncode == 0, f"{' '.join(words)}, {condition.name}: {done.stderr}"
    made = {
        path.relative_to(folder).as_posix(): path.read_text("utf-8")
        for path in sorted(folder.rglob("*"))
        if path.suffix in (".json", ".csv", ".toml") and not (inputs / path.relative_to(folder)).exists()
    }
    assert made, name
    return {"": NUMBER.sub("", done.stdout)} | made


def difference(one: dict[str, str], other: dict[str, str]) -> float:
    """0.0 with the same bits, the largest relative difference of numbers, or inf where words or counts differ."""
    if one.keys() != other.keys():
        return float("inf")
    largest = 0.0
    for text, text_ in ((text, other[key]) for key, text in one.items() if text != other[key]):
        if NUMBER.sub("", text) != NUMBER.sub("", text_):
            return float("inf")
        for pair in zip(NUMBER.findall(text), NUMBER.findall(text_), strict=True):
            if pair[0] == pair[1]:
                continue
            if not any(mark in number for number in pair for mark in ".e"):
                return float("inf")
            a, b = map(float, pair)
            size = max(abs(a), abs(b))
            largest = max(largest, abs(a - b) / size if size > ROUNDING else 0.0, 1e-17)
    return largest


def conditions() -> list[Condition]:
    """All that this machine can have."""
    made = [Condition("a new process"), Condition("another folder", folder="another, dé folder")]
    made += [Condition(f"hash seed {seed}", {"PYTHONHASHSEED": seed}) for seed in ("1", "4711")]
    made += [Condition("time zone of Auckland", {"TZ": "Pacific/Auckland"})]
    made += [Condition(f"locale {name}", {"LC_ALL": f"{name}.utf8"}) for name in ("C", "de_DE", "tr_TR", "ja_JP")]
    made += [Condition(f"{many} BLAS threads", dict.fromkeys(THREADS, many)) for many in ("1", "2", "4")]
    made += [Condition(f"{many} threads", words=("--threads", many)) for many in ("1", "2", "7", "100")]
    sets = ("none", *_core.instruction_sets())
    made += [Condition(f"packs: {name}", {"COGGING_INSTRUCTIONS": name}) for name in sets]
    if platform.machine().lower() in ("x86_64", "amd64"):
        core = (getattr(np, "_core", None) or np.core)._multiarray_umath
        kernels = [name for name, feature in OPENBLAS.items() if core.__cpu_features__.get(feature)]
        others = {f"OpenBLAS for {name}": {"OPENBLAS_CORETYPE": name} for name in kernels}
        dispatched = " ".join(name for name in core.__cpu_dispatch__ if core.__cpu_features__.get(name))
        others |= {f"NumPy without {dispatched}": {"NPY_DISABLE_CPU_FEATURES": dispatched}} if dispatched else {}
        if platform.libc_ver()[0] == "glibc":
            others["mathematics library without FMA"] = {"GLIBC_TUNABLES": OLD_LIBRARY}
        made += [Condition(name, variables, is_processor=True) for name, variables in others.items()]
    return made


def main() -> int:
    """Compare and print; status 1 where bits differ."""
    parser = argparse.ArgumentParser(prog="python -m tests.attack.same_bits", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(CALLS)}; all when none is named")
    parser.add_argument("--condition", default="", help="only those whose name has this in it")
    options, faults = parser.parse_args(), 0
    with tempfile.TemporaryDirectory() as place:
        inputs = Path(place) / "inputs"
        write_inputs(inputs)
        chosen = [one for one in conditions() if options.condition in one.name]
        for name in options.names or CALLS:
            usual = answer(name, Condition("as usual"), inputs, Path(place) / "0")
            for number, condition in enumerate(chosen, 1):
                if condition.words and name not in ("sweep", "tune"):
                    continue
                apart = difference(usual, answer(name, condition, inputs, Path(place) / str(number)))
                allowed = ALLOWED if condition.is_processor and name not in CORE_ALONE else 0.0
                faults += apart > allowed
                print(f"{name}, {condition.name}: {apart:.1e} apart{' FAULT' * (apart > allowed)}", flush=True)
    print(f"{faults} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
