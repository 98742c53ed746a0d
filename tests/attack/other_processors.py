"""`python -m tests.attack.other_processors`: the core on other processors, emulated; status 1 where numbers differ.

tests/cpp/bits.cpp runs every controller, effect and motion, and predictions along what they logged. It is built for
this machine and for 64-bit ARM, and run here, and by qemu on ARM and on older x86-64 processors (Debian:
g++-aarch64-linux-gnu, qemu-user). A run whose tools are missing is reported and left out.
"""

import functools
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FLAGS = ["-static", "-O1", "-std=c++20", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-I", str(ROOT / "cpp")]
#: Runs: what the processor is, the compiler and its flags, a feature that this machine must have, and the emulator.
RUNS = [
    ("this machine", ["g++"], "", []),
    ("this machine, v3", ["g++", "-march=x86-64-v3"], "avx2", []),
    ("this machine, v4", ["g++", "-march=x86-64-v4"], "avx512f", []),
    ("x86-64 without AVX (Nehalem)", ["g++"], "", ["qemu-x86_64", "-cpu", "Nehalem"]),
    ("x86-64 with AVX2 and FMA (Haswell)", ["g++"], "", ["qemu-x86_64", "-cpu", "Haswell"]),
    ("aarch64 (Cortex-A72)", ["aarch64-linux-gnu-g++"], "", ["qemu-aarch64", "-cpu", "cortex-a72"]),
]
ALLOWED = 1e-12  # relative, where the bits differ


@functools.cache
def built(folder, *compiler):
    """The program, built once for each compiler and its flags."""
    program = Path(folder) / "_".join(compiler)
    subprocess.run([*compiler, *FLAGS, str(ROOT / "tests/cpp/bits.cpp"), "-o", str(program)], check=True)
    return program


def cases(text):
    """Of each case the hash over its bits, and the numbers that are printed, column by column."""
    found = {}
    for line in text.splitlines():
        head, *columns = line.split(" |")
        name, bits = head.split()
        found[name] = bits, [[float(number) for number in column.split()] for column in columns]
    return found


def difference(ours, others):
    """The largest difference of the printed numbers, as a share of the largest in its column."""
    largest = 0.0
    for column, other in zip(ours, others, strict=True):
        size = max(map(abs, column), default=0.0) or 1.0
        largest = max(largest, *(abs(a - b) / size for a, b in zip(column, other, strict=True)))
    return largest


def compared(name, ours, others):
    """The line of a run, and whether it is as it must be."""
    if ours.keys() != others.keys() or not ours:
        return f"{name}: other cases", False
    apart = {case: difference(ours[case][1], others[case][1]) for case in ours if ours[case][0] != others[case][0]}
    if not apart:
        return f"{name}: same bits in {len(ours)} cases", True
    worst = max(apart, key=apart.__getitem__)
    same = f"{len(ours) - len(apart)} of {len(ours)} cases with the same bits"
    return f"{name}: {same}, else up to {apart[worst]:.2g} ({worst})", apart[worst] < ALLOWED


def main():
    here = Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""
    ours, good = None, True
    with tempfile.TemporaryDirectory() as folder:
        for name, compiler, feature, emulator in RUNS:
            missing = [tool for tool in (compiler[0], *emulator[:1]) if not shutil.which(tool)]
            missing += [feature] if feature and not re.search(rf"\b{feature}\b", here) else []
            if missing:
                print(f"{name}: left out, no {' or '.join(missing)}", flush=True)
                continue
            done = subprocess.run([*emulator, built(folder, *compiler)], capture_output=True, text=True)
            others = cases(done.stdout) if done.returncode == 0 else {}
            ours = ours or others
            line, same = compared(name, ours, others)
            good = good and same
            print(line, flush=True)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
