"""A small project takes the library as its user does: find_package, FetchContent, and what the Python package tells."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import cogging
from cogging.files import parse_toml

ROOT = Path(__file__).resolve().parents[2]
CONSUMER = Path(__file__).parent / "consumer"
COMMAND = 0.01 * 9600.0 + 0.01 * 1e-3 * 1e5  # V: kp and ki of an error of 10 mm in the first sample


def judge(cmake, built, compiler):
    """The program runs, and was built with what the package asks for."""
    assert float(cmake.run(cmake.program(built, "consumer"))) == pytest.approx(COMMAND, rel=1e-12)
    commands = (built / "compile_commands.json").read_text()
    if "cl.exe" not in Path(compiler).name:
        assert "-ffp-contract=off" in commands
    folders = re.findall(r"-(?:I|isystem) ?([^\s\"]+)", commands)
    assert not any((Path(folder) / header).exists() for folder in folders for header in ("Python.h", "pybind11"))


def test_find_package(cmake, compiler, prefix):
    options = [f"-DCMAKE_PREFIX_PATH={prefix}", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON"]
    judge(cmake, cmake.build(CONSUMER, "installed", *options), compiler)


def test_fetch_content(cmake, compiler):
    options = [f"-DCOGGING_SOURCE={ROOT}", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON"]
    judge(cmake, cmake.build(CONSUMER, "fetched", *options), compiler)


def test_the_prefix_holds_headers_and_package_alone(prefix):
    files = {path.relative_to(prefix) for path in prefix.rglob("*") if path.is_file()}
    headers = {path.relative_to(ROOT / "cpp") for path in (ROOT / "cpp" / "cogging").rglob("*.hpp")}
    assert {path.relative_to("include") for path in files if path.parts[0] == "include"} == headers
    names = {"coggingConfig.cmake", "coggingConfigVersion.cmake", "coggingTargets.cmake"}
    assert {path for path in files if path.parts[0] != "include"} == {
        Path("share/cmake/cogging", name) for name in names
    }
    project = parse_toml((ROOT / "pyproject.toml").read_text())
    version = project["tool"]["setuptools_scm"]["fallback_version"].partition(".dev")[0]
    assert (
        f'set(PACKAGE_VERSION "{version}")' in (prefix / "share/cmake/cogging/coggingConfigVersion.cmake").read_text()
    )


def test_a_wrong_version_is_not_found(cmake, prefix, tmp_path):
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.20)\nproject(later LANGUAGES CXX)\nfind_package(cogging 99 REQUIRED)\n"
    )
    with pytest.raises(AssertionError, match="version: 0"):
        cmake.build(tmp_path, "later", f"-DCMAKE_PREFIX_PATH={prefix}")


def asked(*arguments):
    return subprocess.run([sys.executable, "-m", "cogging", *arguments], capture_output=True, text=True)


def test_the_package_says_where_its_headers_are():
    told = asked("--include-dir")
    assert told.returncode == 0
    assert told.stdout.strip() == cogging.get_include()
    assert (Path(cogging.get_include()) / "cogging" / "control" / "pid.hpp").is_file()


def test_the_package_says_where_its_cmake_package_is(cmake, compiler):
    """Installed, it is usable; of a source tree, one line says what to do."""
    told = asked("--cmake-dir")
    if (Path(cogging.__file__).parent / "share").is_dir():
        assert told.stdout.strip() == cogging.get_cmake_dir()
        options = [f"-Dcogging_DIR={cogging.get_cmake_dir()}", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON"]
        judge(cmake, cmake.build(CONSUMER, "wheel", *options), compiler)
    else:
        assert told.returncode == 2
        assert told.stderr.count("\n") == 1
        assert "must be an installed package (pip install .)" in told.stderr
        with pytest.raises(cogging.InputError, match="add_subdirectory"):
            cogging.get_cmake_dir()


@pytest.mark.skipif(os.name == "nt", reason="the wheel's layout is laid out here by a Unix command")
def test_the_layout_of_the_wheel(cmake, compiler, tmp_path):
    """What pip installs below the package is found there, wherever the environment lies."""
    built = cmake.folder / "as_wheel"
    places = ["-DCMAKE_INSTALL_INCLUDEDIR=cogging/include", "-DCMAKE_INSTALL_DATADIR=cogging/share"]
    cmake.run(cmake.cmake, "-S", ROOT, "-B", built, *cmake.options, *places)
    cmake.run(cmake.cmake, "--install", built, "--prefix", tmp_path / "site-packages")
    (tmp_path / "site-packages").rename(tmp_path / "elsewhere")
    found = tmp_path / "elsewhere" / "cogging" / "share" / "cmake" / "cogging"
    options = [f"-Dcogging_DIR={found}", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON"]
    judge(cmake, cmake.build(CONSUMER, "from_wheel", *options), compiler)


@pytest.mark.parametrize(
    "header", ["basis/regressor", "control/sample_guard", "estimation/predictor", "lanes", "plant/body_with_states"]
)
def test_a_header_stands_alone(cmake, compiler, header, tmp_path):
    (tmp_path / "alone.cpp").write_text(f'#include "cogging/{header}.hpp"\n')
    flags = ["-std=c++20", "-Wall", "-Wextra", "-Werror", f"-I{ROOT / 'cpp'}"]
    cmake.run(compiler, *flags, "-fsyntax-only", tmp_path / "alone.cpp")
