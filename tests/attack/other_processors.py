"""`python -m tests.attack.other_processors`: the core on other processors, emulated; status 1 where numbers differ.

tests/cpp/bits.cpp runs every controller, effect and motion, and predictions along what they logged. It is built for
this machine and for 64-bit ARM, and run here, and by qemu on ARM and on older x86-64 processors (Debian:
g++-aarch64-linux-gnu, qemu-user). A run whose tools are missing is reported and left out.
"""

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FLAGS = ["-static", "-O1", "-std=c++20", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-I", str(ROOT / "cpp")]
#: Runs: the processor, the compiler and its flags, a feature that this machine must have, and the emulator.
RUNS = [
    ("this machine", ["g++"], "", []),
    ("this machine, v3", ["g++", "-march=x86-64-v3"], "avx2", []),
    ("this machine, v4", ["g++", "-march=x86-64-v4"], "avx512f", []),
    ("x86-64 without AVX (Nehalem)", ["g++"], "", ["qemu-x86_64", "-cpu", "Nehalem"]),
    ("x86-64 with AVX2 and FMA (Haswell)", ["g++"], "", ["qemu-x86_64", "-cpu", "Haswell"]),
    ("aarch64 (Cortex-A72)", ["aarch64-linux-gnu-g++"], "", ["qemu-aarch64", "-cpu", "cortex-a72"]),
]
ALLOWED = 1e-12  # relative to the largest number of a column, where the bits differ


def cases(text):
    """Hash over the bits of each case, and the numbers that are printed, column by column."""
    found = {}
    for line in text.splitlines():
        head, *columns = line.split(" |")
        name, bits = head.split()
        found[name] = bits, [[float(number) for number in column.split()] for column in columns]
    return found


def difference(ours, others):
    """The largest difference of printed numbers as a share of the largest in its column."""
    return max(
        max(abs(a - b) for a, b in zip(column, other, strict=True)) / (max(map(abs, column)) or 1.0)
        for column, other in zip(ours, others, strict=True)
    )


def main():
    here = Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""
    ours, faults = None, 0
    with tempfile.TemporaryDirectory() as folder:
        for name, compiler, feature, emulator in RUNS:
            missing = [tool for tool in (compiler[0], *emulator[:1]) if not shutil.which(tool)]
            missing += [feature] if feature and not re.search(rf"\b{feature}\b", here) else []
            if missing:
                print(f"{name}: left out, no {' or '.join(missing)}", flush=True)
                continue
            program = Path(folder) / "_".join(compiler)
            if not program.exists():
                subprocess.run([*compiler, *FLAGS, str(ROOT / "tests/cpp/bits.cpp"), "-o", str(program)], check=True)
            found = cases(subprocess.run([*emulator, program], capture_output=True, text=True).stdout)
            ours = ours or found
            apart = {case: difference(ours[case][1], one[1]) for case, one in found.items() if ours[case][0] != one[0]}
            worst = max(apart.values(), default=0.0)
            good = found and ours.keys() == found.keys() and worst < ALLOWED
            faults += not good
            print(
                f"{name}: same bits in {len(found) - len(apart)} of {len(ours)} cases, else up to {worst:.2g}",
                flush=True,
            )
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
