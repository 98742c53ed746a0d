"""`python -m tests.attack.other_processors`: the core on other processors, emulated; status 1 where numbers differ.

tests/cpp/bits.cpp runs every controller, effect and motion, and predictions along what they logged. It is built for
this machine and for 64-bit ARM, and run here, and by qemu on ARM and on older x86-64 processors (Debian:
g++-aarch64-linux-gnu, qemu-user). What lacks its tools is told and left out.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FLAGS = ["-static", "-O1", "-std=c++20", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-I", str(ROOT / "cpp")]
#: Builds by name: the compiler, and what is added to its flags.
BUILDS = {
    "x86-64": ("g++", []),
    "x86-64-v3": ("g++", ["-march=x86-64-v3"]),
    "x86-64-v4": ("g++", ["-march=x86-64-v4"]),
    "aarch64": ("aarch64-linux-gnu-g++", []),
}
#: Runs by name: the build, and what runs it.
RUNS = {
    "this machine": ("x86-64", []),
    "this machine, v3": ("x86-64-v3", []),
    "this machine, v4": ("x86-64-v4", []),
    "x86-64 without AVX (Nehalem)": ("x86-64", ["qemu-x86_64", "-cpu", "Nehalem"]),
    "x86-64 with AVX2 and FMA (Haswell)": ("x86-64", ["qemu-x86_64", "-cpu", "Haswell"]),
    "aarch64 (Cortex-A72)": ("aarch64", ["qemu-aarch64", "-cpu", "cortex-a72"]),
}
ALLOWED = 1e-12  # relative, where the bits differ


def build(name, folder):
    """The program, or None without its compiler."""
    compiler, more = BUILDS[name]
    if not shutil.which(compiler):
        return None
    program = folder / name
    subprocess.run([compiler, *FLAGS, *more, str(ROOT / "tests/cpp/bits.cpp"), "-o", str(program)], check=True)
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
    """The largest one of the printed numbers, as a share of the largest in its column."""
    largest = 0.0
    for ours_there, others_there in zip(ours, others, strict=True):
        size = max(map(abs, ours_there), default=0.0) or 1.0
        apart = [abs(a - b) / size for a, b in zip(ours_there, others_there, strict=True)]
        largest = max(largest, *apart)
    return largest


def compared(name, ours, others):
    """The line of a run, and whether it is as it must be."""
    if ours.keys() != others.keys() or not ours:
        return f"{name}: other cases", False
    apart = {case: difference(ours[case][1], others[case][1]) for case in ours if ours[case][0] != others[case][0]}
    if not apart:
        return f"{name}: same bits in {len(ours)} cases", True
    worst = max(apart, key=apart.__getitem__)
    told = f"{len(ours) - len(apart)} of {len(ours)} cases with the same bits, else up to {apart[worst]:.2g} ({worst})"
    return f"{name}: {told}", apart[worst] < ALLOWED


def main():
    argparse.ArgumentParser(prog="python -m tests.attack.other_processors", description=__doc__).parse_args()
    here = Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""
    lacking = {"x86-64-v3": "avx2", "x86-64-v4": "avx512f"}
    with tempfile.TemporaryDirectory() as folder:
        programs = {}
        ours, good = None, True
        for name, (built, emulator) in RUNS.items():
            if emulator and not shutil.which(emulator[0]):
                print(f"{name}: left out, no {emulator[0]}", flush=True)
                continue
            if built in lacking and not re.search(rf"\b{lacking[built]}\b", here):
                print(f"{name}: left out, this machine lacks it", flush=True)
                continue
            if built not in programs:
                programs[built] = build(built, Path(folder))
            if programs[built] is None:
                print(f"{name}: left out, no {BUILDS[built][0]}", flush=True)
                continue
            done = subprocess.run([*emulator, programs[built]], capture_output=True, text=True, env=os.environ)
            others = cases(done.stdout) if done.returncode == 0 else {}
            ours = ours or others
            line, same = compared(name, ours, others)
            good = good and same
            print(line, flush=True)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
