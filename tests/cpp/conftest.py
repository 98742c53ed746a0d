"""The tests in C++, configured, built and run by CTest once; what uses the installed library is built from a prefix."""

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
#: A C++ project has no use for these: were they looked for, the configuration would fail.
WITHOUT_PYTHON = [f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON" for name in ("Python", "Python3", "pybind11")]


@dataclass
class CMake:
    """The tools that build the programs, and the folder in which they do."""

    cmake: str
    ctest: str
    options: list[str]
    folder: Path

    def run(self, *command):
        """Run a command to its end and return its output."""
        done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
        said = done.stdout + done.stderr
        assert done.returncode == 0, f"{' '.join(map(str, command))}\n{said[-4000:]}"
        return said

    def build(self, source, name, *options):
        """Configure and build a project and return its folder."""
        built = self.folder / name
        self.run(self.cmake, "-S", source, "-B", built, *self.options, *WITHOUT_PYTHON, *options)
        self.run(self.cmake, "--build", built, "--config", "Debug", "--parallel", "2")
        return built

    def program(self, folder, name):
        """A program that was built there."""
        return shutil.which(name, path=os.pathsep.join([str(folder), str(folder / "Debug")]))


@pytest.fixture(scope="session")
def compiler():
    return shutil.which(os.environ.get("CXX", "g++")) or shutil.which("c++")


@pytest.fixture(scope="session")
def cmake(compiler, tmp_path_factory):
    places = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])  # pip puts them there
    found = {name: shutil.which(name, path=places) for name in ("cmake", "ctest", "ninja")}
    options = [f"-DCMAKE_CXX_COMPILER={compiler}", "-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_CXX_FLAGS_DEBUG=-O1"]
    options += ["-G", "Ninja", f"-DCMAKE_MAKE_PROGRAM={found['ninja']}"] if found["ninja"] else []
    return CMake(found["cmake"], found["ctest"], options, tmp_path_factory.mktemp("cmake"))


@pytest.fixture(scope="session")
def programs(cmake):
    """The folder of the built programs."""
    return cmake.build(ROOT, "tests", "-DCOGGING_TESTS=ON", "-DCOGGING_WARNINGS_AS_ERRORS=ON") / "tests" / "cpp"


@pytest.fixture(scope="session")
def prefix(cmake):
    """A folder in which the library is installed, as `cmake --install` does."""
    folder = cmake.folder / "prefix"
    cmake.run(cmake.cmake, "--install", cmake.build(ROOT, "library"), "--prefix", folder)
    return folder
