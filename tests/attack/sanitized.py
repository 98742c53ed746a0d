"""The core and its bindings under the compiler's sanitizers: `python -m tests.attack.sanitized [PART ...]`.

Addresses and undefined behaviour: the module, built with both and put into a copy of the package, runs the drawn calls
of the bindings (`calls`) and the tests of the core (`rooms`); the programs of tests/cpp (`programs`), which hold no
Python, are checked for leaks too. Threads: batches on 1 to 16 of them (`threads`). Two commands run at once; each
prints its processor time. Needs a compiler with its sanitizers' libraries, as GCC has them, and the build requirements
of the package. `--cases N` drawn calls, `--build FOLDER` keeps the builds, `--long` adds slow tests and a longer soak.
"""

import argparse
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).parents[2]
#: Tests of the core in three processes; `bindings` would ask for the system's limits, and sweeps are Python.
RUNS = ("batch", "lanes", "own_controllers", "simulation")
ROOMS = (("control", "estimation"), ("basis", "plant", "reference"), [f"simulation/test_{name}.py" for name in RUNS])
#: Programs with their arguments, and those of soak unless `--long`: the samples of each controller.
PROGRAMS = {"numbers": [], "soak": ["300000"]}
PARTS = ("calls", "rooms", "programs", "threads")
#: GCC's undefined behaviour leaves out numbers that no integer holds. Not optimised: the build is then half as long.
CHECKED = "-O0 -g1 -fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all -fno-omit-frame-pointer"
THREADS = "-O1 -g1 -fsanitize=thread -fno-omit-frame-pointer"
#: Leaks at exit of pybind11 and Python are not looked at.
IN_PYTHON = {
    "ASAN_OPTIONS": "detect_leaks=0:allocator_may_return_null=1:malloc_context_size=4",
    "PYTHONMALLOC": "malloc",
    "OPENBLAS_NUM_THREADS": "1",
}
ALONE = {"ASAN_OPTIONS": "detect_leaks=1:detect_stack_use_after_return=1", "TSAN_OPTIONS": "halt_on_error=1"}


def main() -> int:
    """Build and run; status 1 where anything was found."""
    parser = argparse.ArgumentParser(prog="python -m tests.attack.sanitized", description=__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"{', '.join(PARTS)}; all when none is named")
    parser.add_argument("--cases", type=int, default=20_000)
    parser.add_argument("--build", default="")
    parser.add_argument("--long", action="store_true")
    options = parser.parse_args()
    parts = set(options.parts or PARTS)
    if unknown := parts - set(PARTS):
        parser.error(f"PART: must be one of {', '.join(PARTS)}, got {', '.join(sorted(unknown))}")
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(2) as pool:
        place = Path(options.build or f"{folder}/build").resolve()
        checked, threads = place / "checked", place / "threads"

        def run_threads() -> bool:
            built = build(threads, THREADS, ["batches"], python=False)
            return built and run([f"{threads / 'tests' / 'cpp' / 'batches'}"], ALONE)

        running = [pool.submit(run_threads)] if "threads" in parts else []
        in_python = bool({"calls", "rooms"} & parts)
        programs = PROGRAMS if "programs" in parts else {}
        targets = [*(["_core"] if in_python else []), *programs]
        if targets and not build(checked, CHECKED, targets, python=in_python):
            return 1
        if in_python:
            package = Path(folder) / "python"
            shutil.copytree(ROOT / "python", package, ignore=shutil.ignore_patterns("_core*.so", "__pycache__"))
            shutil.copy(next(checked.rglob("_core*.so")), package / "cogging")
            environment = {**IN_PYTHON, "LD_PRELOAD": libraries(), "PYTHONPATH": f"{package}"}
            pytest = ["pytest", "-q", "-p", "no:cacheprovider", *([] if options.long else ["-m", "not slow"])]
            calls = ["tests.attack", "bindings", "--cases", str(options.cases), "--processes", "1"]
            words = [[*pytest, *(f"tests/{room}" for room in rooms)] for rooms in ROOMS if "rooms" in parts]
            words += [calls] if "calls" in parts else []
            running += [pool.submit(run, [sys.executable, "-m", *some], environment) for some in words]
        for name, words in programs.items():
            command = [f"{checked / 'tests' / 'cpp' / name}", *([] if options.long else words)]
            running.append(pool.submit(run, command, ALONE))
        return int(not all(one.result() for one in running))


def build(folder: Path, checks: str, targets: Sequence[str], *, python: bool) -> bool:
    """Configure and build targets with these checks; whether that succeeded."""
    native = {"x86_64": "v3", "amd64": "v3", "aarch64": "neon", "arm64": "neon"}  # one set: fewer are built sooner
    options = {
        "CMAKE_BUILD_TYPE": "Release",
        "CMAKE_CXX_FLAGS_RELEASE": "-DNDEBUG",
        "CMAKE_CXX_FLAGS": checks,
        "COGGING_FMI": "OFF",
        "COGGING_PYTHON": "ON" if python else "OFF",
        "COGGING_TESTS": "ON",
        "COGGING_INSTRUCTION_SETS": native.get(platform.machine().lower(), ""),
    }
    if python:
        ask = [sys.executable, "-m", "pybind11", "--cmakedir"]
        bindings = subprocess.run(ask, capture_output=True, text=True, check=True).stdout.strip()
        options |= {"CMAKE_PREFIX_PATH": bindings, "Python_EXECUTABLE": sys.executable}
    if cache := shutil.which("ccache"):
        options["CMAKE_CXX_COMPILER_LAUNCHER"] = cache
    given = [f"-D{name}={value}" for name, value in options.items()]
    parallel = str(os.cpu_count() or 1)  # ninja would start two more, each of which may need 3 GB
    return run(["cmake", "-S", f"{ROOT}", "-B", f"{folder}", "-G", "Ninja", *given], {}) and run(
        ["cmake", "--build", f"{folder}", "--parallel", parallel, "--target", *targets], {}
    )


def run(command: Sequence[str], environment: Mapping[str, str]) -> bool:
    """Run a command to its end and print its times and last line, all lines where it fails; whether it succeeded."""
    begin = time.monotonic()
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"  # pip puts cmake and ninja there
    with tempfile.TemporaryFile() as output:
        environment = {**os.environ, "PATH": path, **environment}
        process = subprocess.Popen(command, cwd=ROOT, env=environment, stdout=output, stderr=subprocess.STDOUT)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = status  # it has been waited for
        output.seek(0)
        text = output.read().decode(errors="replace")
    seconds = f"{used.ru_utime + used.ru_stime:.0f} s of processor, {time.monotonic() - begin:.0f} s"
    print(f"{' '.join(command)[-100:]}: {'FAILED' if status else 'sound'}, {seconds}", flush=True)
    print(text if status else "\n".join(text.splitlines()[-1:]), flush=True)
    return status == 0


def libraries() -> str:
    """The sanitizers' libraries and the C++ library whose exceptions they intercept: loaded before Python's own."""
    names = ("libasan.so", "libubsan.so", "libstdc++.so.6")
    asked = [[os.environ.get("CXX", "c++"), f"-print-file-name={name}"] for name in names]
    return " ".join(subprocess.run(one, capture_output=True, text=True, check=True).stdout.strip() for one in asked)


if __name__ == "__main__":
    sys.exit(main())
