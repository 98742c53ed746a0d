"""The core and its bindings under the compiler's sanitizers: `python -m tests.attack.sanitized [PART ...]`.

Addresses and undefined behaviour: the module, built with both in a folder of its own and beside a copy of the package,
takes the drawn calls of the bindings (`calls`) and the tests of the core's rooms (`rooms`); the programs of tests/cpp
(`programs`), which hold no Python, are looked at for leaks too. Threads: batches on 1 to 16 of them (`threads`). Two
parts run at once; each tells its processor time. Needs a compiler with its sanitizers' libraries, as GCC has them, and
what the package is built with. `--cases N` drawn calls, `--build FOLDER` to keep what was built, `--long` with the
tests of long runs as well.
"""

from __future__ import annotations

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
#: Those of the core, in three processes; `bindings` would ask for the system's limits, a sweep is none of the core's.
RUNS = [
    f"simulation/test_{name}.py" for name in ("batch", "lanes", "own_controllers", "simulation", "steps_per_sample")
]
ROOMS = (("control", "estimation"), ("basis", "plant", "reference"), tuple(RUNS))
#: Long runs, which take two thirds of the time there and go where shorter ones go: left out, but for `--long`.
LONG = (
    "control/test_observer_based.py::test_too_much_decay_is_refused_with_an_offer",
    "estimation/test_added.py::test_a_loose_load_does_on_average_what_single_trajectories_do",
    "plant/test_fast_plants.py::test_more_steps_give_no_other_result",
    "plant/test_fast_plants.py::test_random_plants_are_those_of_scipy",
    "plant/test_plant_states.py::test_a_stiff_bristle_is_that_of_the_stiff_integrator",
    "plant/test_plant_states.py::test_it_is_stable_however_stiff_and_tends_to_the_exact_form",
    "simulation/test_simulation.py::test_another_thread_runs_meanwhile",
)
#: Packs of runs have their tests among the rooms; `lanes` would take two minutes for them.
PROGRAMS = ("constructors", "drive", "numbers", "soak")
PARTS = ("calls", "rooms", "programs", "threads")
#: What GCC calls undefined leaves out numbers that no integer holds. A division by zero is none: IEEE says what it is.
#: Not optimised: the build is then half as long, and longer than what runs.
CHECKED = "-O0 -g1 -fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all -fno-omit-frame-pointer"
THREADS = "-O1 -g1 -fsanitize=thread -fno-omit-frame-pointer"
#: Files of the bindings that are compiled as one: what they include is then compiled once, in less than half the time.
TOGETHER = 7
#: What pybind11 and Python do at exit is not looked at: leaks are what they leave to the system.
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
    arguments = parser.parse_args()
    parts = arguments.parts or PARTS
    if unknown := set(parts) - set(PARTS):
        parser.error(f"PART: must be one of {', '.join(PARTS)}, got {', '.join(sorted(unknown))}")
    with tempfile.TemporaryDirectory() as folder:
        beside = Path(folder)
        build = Path(arguments.build or beside / "build").resolve()
        with ThreadPoolExecutor(2) as at_once:  # one part builds while another runs
            threads = at_once.submit(_threads, build / "threads") if "threads" in parts else None
            without = () if arguments.long else LONG
            checked = _checked(parts, build / "checked", beside, arguments.cases, at_once, without)
            found = [*checked, *([threads.result()] if threads else [])]
    return 1 if any(found) else 0


def _checked(
    parts: Sequence[str], build: Path, beside: Path, cases: int, at_once: ThreadPoolExecutor, without: Sequence[str]
) -> list[int]:
    """What runs under the sanitizers of addresses and undefined behaviour; of each command, whether it found any."""
    in_python = {"calls", "rooms"} & set(parts)
    programs = PROGRAMS if "programs" in parts else ()
    if not in_python and not programs:
        return []
    targets = [*(["_core"] if in_python else []), *programs]
    if configured(build, CHECKED, python=bool(in_python)) or built(build, targets):
        return [1]
    commands: list[tuple[str, list[str], Mapping[str, str]]] = []
    if in_python:
        environment = {**IN_PYTHON, "LD_PRELOAD": libraries(), "PYTHONPATH": f"{package(build, beside)}"}
        calls = [sys.executable, "-m", "tests.attack", "bindings", "--cases", str(cases), "--processes", "1"]
        pytest = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
        pytest += [word for test in without for word in ("--deselect", f"tests/{test}")]
        told = [("rooms", f"rooms {rooms[0]} ...", pytest + [f"tests/{room}" for room in rooms]) for rooms in ROOMS]
        told += [("calls", "calls", calls)]  # the shortest last
        commands += [(name, command, environment) for part, name, command in told if part in parts]
    commands += [(name, [f"{program(build, name)}"], ALONE) for name in programs]
    return [done.result() for done in [at_once.submit(run, *command) for command in commands]]


def _threads(build: Path) -> int:
    """Batches under the sanitizer of threads; whether anything was found."""
    if configured(build, THREADS, python=False) or built(build, ["batches"]):
        return 1
    return run("threads", [f"{program(build, 'batches')}"], ALONE)


def configured(build: Path, checks: str, *, python: bool) -> int:
    """Sets up a build with these checks; 0, or 1 where that failed."""
    options = {
        "CMAKE_BUILD_TYPE": "Release",
        "CMAKE_CXX_FLAGS_RELEASE": "-DNDEBUG",
        "CMAKE_CXX_FLAGS": checks,
        "CMAKE_INTERPROCEDURAL_OPTIMIZATION": "OFF",
        "COGGING_FMI": "OFF",
        "COGGING_PYTHON": "ON" if python else "OFF",
        "COGGING_TESTS": "ON",
        "COGGING_INSTRUCTION_SETS": lanes(),
        "CMAKE_UNITY_BUILD": "ON",
        "CMAKE_UNITY_BUILD_BATCH_SIZE": f"{TOGETHER}",
    }
    if python:
        eigen = next((place for path in sys.path if (place := Path(path) / "cmeel.prefix").exists()), "")
        asked = [sys.executable, "-m", "pybind11", "--cmakedir"]
        bindings = subprocess.run(asked, capture_output=True, text=True, check=True).stdout.strip()
        options |= {"CMAKE_PREFIX_PATH": f"{eigen};{bindings}", "Python_EXECUTABLE": sys.executable}
    if cache := shutil.which("ccache"):
        options["CMAKE_CXX_COMPILER_LAUNCHER"] = cache
    given = [f"-D{name}={value}" for name, value in options.items()]
    return run("", ["cmake", "-S", f"{ROOT}", "-B", f"{build}", "-G", "Ninja", *given])


def built(build: Path, targets: Sequence[str]) -> int:
    """Builds them; 0, or 1 where that failed."""
    together = str(os.cpu_count() or 1)  # ninja would start two more, each of which may need 3 GB
    command = ["cmake", "--build", f"{build}", "--parallel", together, "--target", *targets]
    return run(f"build of {', '.join(targets)}", command)


def lanes() -> str:
    """One instruction set for packs of runs, the widest that any processor of today has: fewer are built sooner."""
    machine = platform.machine().lower()
    return {"x86_64": "v3", "amd64": "v3", "aarch64": "neon", "arm64": "neon"}.get(machine, "")


def package(build: Path, beside: Path) -> Path:
    """A copy of the package with the module that was built."""
    copy = beside / "python"
    shutil.copytree(ROOT / "python", copy, ignore=shutil.ignore_patterns("_core*.so", "__pycache__"))
    (module,) = build.rglob("_core*.so")
    shutil.copy(module, copy / "cogging")
    return copy


def program(build: Path, name: str) -> Path:
    """One of the programs of tests/cpp."""
    return build / "tests" / "cpp" / name


def run(name: str, command: Sequence[str], environment: Mapping[str, str] | None = None) -> int:
    """A command to its end, told under its name with its times; 0, or 1 where it found something."""
    begun = time.monotonic()
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"  # pip puts cmake and ninja there
    everything = {**os.environ, "PATH": path, **(environment or {})}
    with tempfile.TemporaryFile() as said:
        process = subprocess.Popen(command, cwd=ROOT, env=everything, stdout=said, stderr=subprocess.STDOUT)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = status  # it has been waited for
        said.seek(0)
        text = said.read().decode(errors="replace")
    if name or status:
        elapsed = time.monotonic() - begun
        line = f"{name or ' '.join(command)}: {'found something' if status else 'sound'}"
        print(f"{line}, {used.ru_utime + used.ru_stime:.0f} s of processor, {elapsed:.0f} s", flush=True)
        print(text if status else "\n".join(text.splitlines()[-1:]), flush=True)
    return 1 if status else 0


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
