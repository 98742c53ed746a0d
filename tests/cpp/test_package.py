"""A small project uses the library as its user does, and the programs of CTest: numbers, and a soak of controllers."""

import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

import cogging
from cogging.files import parse_toml

ROOT = Path(__file__).resolve().parents[2]
CONSUMER = Path(__file__).parent / "consumer"
COMMAND = 0.01 * 9600.0 + 0.01 * 1e-3 * 1e5  # V: kp and ki of an error of 10 mm in the first sample


def build_consumer(cmake, compiler, name, option):
    """Build and run the program; it was built with the package's flags, and without Python."""
    built = cmake.build(CONSUMER, name, option, "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON")
    assert float(cmake.run(cmake.program(built, "consumer"))) == pytest.approx(COMMAND, rel=1e-12)
    commands = (built / "compile_commands.json").read_text()
    assert "-ffp-contract=off" in commands or "cl.exe" in Path(compiler).name
    folders = re.findall(r"-(?:I|isystem) ?([^\s\"]+)", commands)
    headers = ("Python.h", "pybind11")
    assert not any((Path(folder) / header).exists() for folder in folders for header in headers)


def test_find_package(cmake, compiler, prefix):
    build_consumer(cmake, compiler, "installed", f"-DCMAKE_PREFIX_PATH={prefix}")


def test_fetch_content(cmake, compiler):
    build_consumer(cmake, compiler, "fetched", f"-DCOGGING_SOURCE={ROOT}")


def test_the_prefix_holds_headers_and_package_alone(prefix):
    files = {path.relative_to(prefix) for path in prefix.rglob("*") if path.is_file()}
    headers = {Path("include") / path.relative_to(ROOT / "cpp") for path in (ROOT / "cpp" / "cogging").rglob("*.hpp")}
    package = Path("share/cmake/cogging")
    names = {"coggingConfig.cmake", "coggingConfigVersion.cmake", "coggingTargets.cmake"}
    assert files == headers | {package / name for name in names}
    project = parse_toml((ROOT / "pyproject.toml").read_text())
    version = project["tool"]["setuptools_scm"]["fallback_version"].partition(".dev")[0]
    assert f'set(PACKAGE_VERSION "{version}")' in (prefix / package / "coggingConfigVersion.cmake").read_text()


def test_the_package_prints_its_paths(cmake, compiler):
    """Of a source tree it prints one line that says what to do."""
    found = {}
    for option in ("--include-dir", "--cmake-dir"):
        found[option] = subprocess.run([sys.executable, "-m", "cogging", option], capture_output=True, text=True)
    assert found["--include-dir"].stdout.strip() == cogging.get_include()
    assert (Path(cogging.get_include()) / "cogging" / "control" / "pid.hpp").is_file()
    if (Path(cogging.__file__).parent / "share").is_dir():
        assert found["--cmake-dir"].stdout.strip() == cogging.get_cmake_dir()
        build_consumer(cmake, compiler, "wheel", f"-Dcogging_DIR={cogging.get_cmake_dir()}")
    else:
        assert found["--cmake-dir"].returncode == 2
        assert re.fullmatch(r".*must be an installed package \(pip install \.\).*\n", found["--cmake-dir"].stderr)
        with pytest.raises(cogging.InputError, match="add_subdirectory"):
            cogging.get_cmake_dir()


@pytest.mark.parametrize("header", ["basis/regressor", "control/sample_guard", "plant/body_with_states"])
def test_a_header_can_be_included_alone(cmake, compiler, header, tmp_path):
    (tmp_path / "alone.cpp").write_text(f'#include "cogging/{header}.hpp"\n')
    flags = ["-std=c++20", "-Wall", "-Wextra", "-Werror", f"-I{ROOT / 'cpp'}"]
    cmake.run(compiler, *flags, "-fsyntax-only", tmp_path / "alone.cpp")


def test_programs_pass(cmake, programs, tmp_path):
    report = tmp_path / "report.xml"
    options = ["--output-on-failure", "-C", "Debug", "--output-junit", report]
    cmake.run(cmake.ctest, "--test-dir", programs, *options)
    passed = {case.get("name") for case in ElementTree.parse(report).iter("testcase") if case.get("status") == "run"}
    assert passed == {"numbers", "soak", "soak_refuses"}


# The folders of the core: each includes only from those before it, and each has a binding file of its name ----------

CPP = ROOT / "cpp"
CORE = CPP / "cogging"
#: In their order; headers beside the folders are their base and use no folder.
FOLDERS = ["table", "basis", "reference", "plant", "control", "simulation", "estimation"]
#: Physics of the machine and laws of control do not know each other.
APART = {"plant": {"reference"}, "control": {"plant"}}
#: Bindings of no folder: objects of Python within the core, and what several bindings share.
OTHER_BINDINGS = {"own_controller", "own_effect", "parameters", "module"}


def test_a_folder_includes_only_from_those_before_it():
    headers = [path.relative_to(CORE) for path in CORE.rglob("*.hpp")]
    assert {path.parts[0] for path in headers if len(path.parts) > 1} == set(FOLDERS)
    for path in headers:
        folder = path.parts[0] if len(path.parts) > 1 else None
        allowed = set(FOLDERS[: FOLDERS.index(folder) + 1] if folder else ()) - APART.get(folder, set())
        for name in re.findall(r'#include\s*"([^"]+)"', (CORE / path).read_text()):
            assert (CPP / name).is_file(), f"{path} includes {name}"
            assert name.count("/") == 1 or name.split("/")[1] in allowed, f"{path} includes {name}"


def test_every_folder_has_a_binding_file_of_its_name():
    assert {path.stem for path in (CPP / "bindings").glob("*.cpp")} - OTHER_BINDINGS == set(FOLDERS)
