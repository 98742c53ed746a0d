"""`python -m tests.attack.other_processors`: the core on other processors, emulated; status 1 where bits differ.

tests/cpp/bits.cpp runs every controller, effect and motion, and predictions along logs. It is built for x86-64 and
64-bit ARM, and runs here and by qemu (Debian: g++-aarch64-linux-gnu, qemu-user); without its tools a run is left out.
"""

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FLAGS = ["-static", "-O3", "-std=c++20", "-ffp-contract=off", "-fno-tree-slp-vectorize", f"-I{ROOT / 'cpp'}"]
FLAGS += ["-Wall", "-Wextra", "-Werror"]
#: Runs: the processor, the compiler and its flags, a feature that this machine must have, and the emulator.
RUNS = [
    ("this machine", ["g++"], "", []),
    ("this machine, v3", ["g++", "-march=x86-64-v3"], "avx2", []),
    ("this machine, v4", ["g++", "-march=x86-64-v4"], "avx512f", []),
    ("x86-64 without AVX (Nehalem)", ["g++"], "", ["qemu-x86_64", "-cpu", "Nehalem"]),
    ("x86-64 with AVX2 and FMA (Haswell)", ["g++"], "", ["qemu-x86_64", "-cpu", "Haswell"]),
    ("aarch64 (Cortex-A72)", ["aarch64-linux-gnu-g++"], "", ["qemu-aarch64", "-cpu", "cortex-a72"]),
]


def main():
    here = Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""
    ours, faults = [], 0
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
            found = subprocess.run([*emulator, program], capture_output=True, text=True).stdout.splitlines()
            ours = ours or found
            same = sum(one == other for one, other in zip(ours, found, strict=False))
            faults += not same == len(ours) == len(found)
            print(f"{name}: same bits in {same} of {len(ours)} cases", flush=True)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
