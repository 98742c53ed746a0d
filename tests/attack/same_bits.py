"""`python -m tests.attack.same_bits [NAME ...]`: the commands under other conditions; status 1 where bits differ.

Each command runs in a process of its own under another hash seed, locale, time zone and folder, other numbers of
threads, and the instructions of other processors: kernels of OpenBLAS, NumPy's and the mathematics library's functions,
our packs. On another processor the answer of the core alone has the same bits; one with linear algebra in it has the
same words, choices and counts, and numbers as near as told.
"""

import argparse
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from cogging import _core
from tests.fixtures.same_bits import CALLS, Condition, answer, difference, written

OPENBLAS = ("Prescott", "Nehalem", "Sandybridge", "Haswell", "SkylakeX")
NEEDS = {"Sandybridge": "AVX", "Haswell": "AVX2", "SkylakeX": "AVX512F"}
#: Of the mathematics library of GNU, by processors without these.
OLD_LIBRARY = "glibc.cpu.hwcaps=-AVX2,-AVX2_Usable,-FMA,-FMA_Usable,-FMA4,-AVX512F"
APART = 1e-4  # relative: further an answer with linear algebra must not lie on another processor


def locales():
    """Those that there are of some that write numbers and sort otherwise."""
    try:
        known = subprocess.run(["locale", "-a"], capture_output=True, text=True).stdout.split()
    except OSError:
        known = []
    return [name for name in ("C", "C.utf8", "de_DE.utf8", "tr_TR.utf8", "ja_JP.utf8") if name in known]


def conditions():
    """All that this machine can have."""
    made = [Condition("a new process")]
    made += [Condition(f"hash seed {seed}", {"PYTHONHASHSEED": seed}) for seed in ("1", "4711")]
    made += [Condition(f"locale {name}", {"LC_ALL": name}) for name in locales()]
    made += [Condition("time zone of Auckland", {"TZ": "Pacific/Auckland"})]
    made += [Condition("another folder", folder="another, dé folder")]
    for many in ("1", "2", "4"):
        names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
        made.append(Condition(f"{many} BLAS threads", dict.fromkeys(names, many)))
    for many in ("1", "2", "7", "100"):
        made.append(Condition(f"{many} threads", options=dict.fromkeys(("sweep", "tune"), ("--threads", many))))
    for name in ("none", *_core.instruction_sets()):
        made.append(Condition(f"packs: {name}", {"COGGING_INSTRUCTIONS": name}))
    return made + processors()


def processors():
    """What other processors of this kind would choose."""
    if platform.machine().lower() not in ("x86_64", "amd64"):
        return []
    numpy_core = getattr(np, "_core", None) or np.core
    features = numpy_core._multiarray_umath.__cpu_features__
    made = []
    for name in OPENBLAS:
        if features.get(NEEDS.get(name, "SSE3"), False):
            made.append(Condition(f"OpenBLAS for {name}", {"OPENBLAS_CORETYPE": name}, processor=True))
    dispatched = [name for name in numpy_core._multiarray_umath.__cpu_dispatch__ if features.get(name)]
    if dispatched:
        without = {"NPY_DISABLE_CPU_FEATURES": " ".join(dispatched)}
        made.append(Condition(f"NumPy without {', '.join(dispatched)}", without, processor=True))
    if platform.libc_ver()[0] == "glibc":
        made.append(Condition("mathematics library without FMA", {"GLIBC_TUNABLES": OLD_LIBRARY}, processor=True))
    return made


def judged(name, condition, apart):
    """The line, and whether it is as it must be."""
    line = "same bits" if apart == 0.0 else f"up to {apart:.1e} apart" if apart < 1.0 else "other words or choices"
    good = apart == 0.0 or (condition.processor and not CALLS[name].core and apart < APART)
    return f"{name}, {condition.name}: {line}{'' if good else '  FAULT'}", good


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.attack.same_bits", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(CALLS)}; all when none is named")
    parser.add_argument("--condition", default="", help="only those whose name has this in it")
    arguments = parser.parse_args()
    started, faults, lines = time.monotonic(), 0, 0
    with tempfile.TemporaryDirectory() as place:
        inputs = Path(place) / "inputs"
        written(inputs)
        chosen = [one for one in conditions() if arguments.condition in one.name]
        for name in arguments.names or CALLS:
            usual = answer(name, Condition("as usual"), inputs, Path(place) / "0")
            for number, condition in enumerate(chosen, 1):
                if condition.options and name not in condition.options:
                    continue
                found = answer(name, condition, inputs, Path(place) / str(number))
                line, good = judged(name, condition, difference(usual, found))
                print(line, flush=True)
                faults, lines = faults + (not good), lines + 1
    print(f"{lines} comparisons, {faults} faults ({time.monotonic() - started:.0f} s)")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
