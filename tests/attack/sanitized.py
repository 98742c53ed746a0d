"""The core and its bindings under the address and undefined-behaviour sanitizers: `python -m tests.attack.sanitized`.

Builds the module with them in a folder of its own, and runs there, beside a copy of the package, the drawn calls of the
bindings and the tests of the core's rooms. Needs a compiler with its sanitizers' libraries, as GCC has them, and what
the package is built with. Options: `--cases N` drawn calls, `--build FOLDER` to keep the build.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[2]
ROOMS = ("basis", "control", "estimation", "plant", "reference")  # those of `bindings` ask for the system's limits
CHECKED = "-fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer"
#: What pybind11 and Python do at exit is not looked at: leaks are what they leave to the system.
ENVIRONMENT = {
    "ASAN_OPTIONS": "detect_leaks=0:allocator_may_return_null=1",
    "UBSAN_OPTIONS": "print_stacktrace=1",
    "PYTHONMALLOC": "malloc",
    "OPENBLAS_NUM_THREADS": "1",
}


def main() -> int:
    """Build and run; status 1 where anything was found."""
    parser = argparse.ArgumentParser(prog="python -m tests.attack.sanitized", description=__doc__)
    parser.add_argument("--cases", type=int, default=20_000)
    parser.add_argument("--build", default="")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        beside = Path(folder)
        shutil.copytree(ROOT / "python", beside / "python", ignore=shutil.ignore_patterns("_core*.so", "__pycache__"))
        module = built(Path(arguments.build or beside / "build"))
        shutil.copy(module, beside / "python" / "cogging")
        environment = {**os.environ, **ENVIRONMENT, "LD_PRELOAD": libraries(), "PYTHONPATH": f"{beside / 'python'}"}
        calls = [sys.executable, "-m", "tests.attack", "bindings", "--cases", str(arguments.cases)]
        tests = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *(f"tests/{room}" for room in ROOMS)]
        status = 0
        for command in (calls, tests):
            status |= subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode
    return 1 if status else 0


def built(folder: Path) -> Path:
    """The module, built with the sanitizers in a folder."""
    eigen = next((place for path in sys.path if (place := Path(path) / "cmeel.prefix").exists()), "")
    bindings = subprocess.run(
        [sys.executable, "-m", "pybind11", "--cmakedir"], capture_output=True, text=True, check=True
    ).stdout.strip()
    options = {
        "CMAKE_BUILD_TYPE": "Release",
        "CMAKE_CXX_FLAGS_RELEASE": "-O1 -g1 -DNDEBUG",
        "CMAKE_CXX_FLAGS": CHECKED,
        "CMAKE_INTERPROCEDURAL_OPTIMIZATION": "OFF",
        "CMAKE_PREFIX_PATH": f"{eigen};{bindings}",
        "COGGING_FMI": "OFF",
        "COGGING_PYTHON": "ON",
        "Python_EXECUTABLE": sys.executable,
    }
    given = [f"-D{name}={value}" for name, value in options.items()]
    subprocess.run(["cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", *given], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", folder, "--target", "_core"], check=True, stdout=subprocess.DEVNULL)
    (module,) = folder.rglob("_core*.so")
    return module


def libraries() -> str:
    """The sanitizers' libraries, which must be there before Python's own."""
    names = ("libasan.so", "libubsan.so", "libstdc++.so.6")
    compiler = os.environ.get("CXX", "c++")
    found = [
        subprocess.run(
            [compiler, f"-print-file-name={name}"], capture_output=True, text=True, check=True
        ).stdout.strip()
        for name in names
    ]
    return " ".join(found)


if __name__ == "__main__":
    sys.exit(main())
