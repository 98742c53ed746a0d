"""What a maintainer releases with: the wheel's contents, the check of an installed package, the recipe of conda."""

import importlib.util
import re
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

import cogging

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
INFO = "cogging-0.1.0.dist-info"


def script(name):
    """A program of `packaging/` as a module."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "packaging" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


WHEELS = script("build_wheels")


def names_of_a_wheel(library=".so"):
    names = [
        "_core.cpython-311-x86_64-linux-gnu.so",
        "_core/__init__.pyi",
        "py.typed",
        f"share/fmi/cogging_axis{library}",
    ]
    names += [f"share/cmake/cogging/cogging{part}.cmake" for part in ("Config", "Targets", "ConfigVersion")]
    names += [f"include/{path.relative_to(ROOT / 'cpp').as_posix()}" for path in (ROOT / "cpp/cogging").rglob("*.hpp")]
    names += [path.relative_to(ROOT / "python/cogging").as_posix() for path in (ROOT / "python/cogging").rglob("*.py")]
    told = ["licenses/LICENSE", "licenses/THIRD_PARTY.md", "sboms/cogging.cdx.json"]
    return [f"cogging/{name}" for name in names] + ["cogging_command/__init__.py", *(f"{INFO}/{name}" for name in told)]


@pytest.mark.parametrize("library", [".so", ".dylib", ".dll"])
def test_a_whole_wheel_has_no_faults(library):
    assert WHEELS.faults_of_wheel(names_of_a_wheel(library), 5_000_000) == []


def test_what_a_wheel_lacks_is_told():
    names = names_of_a_wheel()
    for what, pattern in WHEELS.NEEDED.items():
        left = [name for name in names if not re.fullmatch(pattern, name)]
        assert len(left) < len(names), what
        assert f"lacks {what}" in WHEELS.faults_of_wheel(left, 1)
    for name in names:
        if name.endswith("require.hpp"):
            left = [other for other in names if other != name]
            assert WHEELS.faults_of_wheel(left, 1) == ["lacks the header cogging/require.hpp"]


@pytest.mark.parametrize(
    "name",
    [
        "tests/test_face.py",
        "cogging/build/x",
        "cogging.libs/libgomp-a34b3233.so.1.0.0",
        "cogging/_core.cpp",
        "docs/a.md",
    ],
)
def test_what_a_wheel_should_not_hold_is_told(name):
    assert WHEELS.faults_of_wheel([*names_of_a_wheel(), name], 1) == [f"holds {name}"]


def test_a_wheel_that_has_grown_is_told():
    (fault,) = WHEELS.faults_of_wheel(names_of_a_wheel(), WHEELS.MOST_BYTES + 1)
    assert "more than" in fault


def test_the_check_of_an_installed_package():
    """Passes where cogging is installed with its library, and says so where it runs from its sources."""
    check = ROOT / "packaging" / "check_installed.py"
    done = subprocess.run([sys.executable, check], capture_output=True, text=True, cwd=ROOT / "packaging")
    if (Path(cogging.__file__).parents[1] / "cogging" / "include").is_dir():
        assert done.returncode == 0, done.stderr
        assert "whole, and works" in done.stdout
    else:
        assert done.returncode == 1
        assert "is a source tree, not an installed package" in done.stderr


def test_what_the_check_runs_works_here(tmp_path):
    check = script("check_installed")
    check.check_run()
    if (ROOT / "build").is_dir() or (Path(cogging.__file__).parent / "share").is_dir():
        check.check_unit(tmp_path)


def tracked_or_new():
    """What git knows, and what it would take up: paths below the root, of a checkout alone."""
    if not (ROOT / ".git").exists():
        pytest.skip("the source archive itself is no checkout")
    listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(listed, cwd=ROOT, capture_output=True, check=True).stdout.decode().split("\0")
    return {name for name in names if name and (ROOT / name).exists()}


def test_the_source_archive_holds_what_git_holds(tmp_path, monkeypatch):
    """Its tests, all that they read, and nothing that lies about: but for this project's own checks of a change."""
    import scikit_build_core.build as backend

    monkeypatch.chdir(ROOT)
    known = tracked_or_new()
    with tarfile.open(tmp_path / backend.build_sdist(str(tmp_path))) as archive:
        files = {one.name.partition("/")[2] for one in archive.getmembers() if one.isfile()}
    assert files - known == {"PKG-INFO"}
    assert {name for name in known - files if not name.startswith(".ci/")} == set()
    assert {"tests/conftest.py", "notebooks/01_lu2008.ipynb", "docs/conf.py", "examples/cpp/model.toml"} <= files
    assert not [name for name in files if re.search(r"\.(so|pyd|pyc|o|whl)$|(^|/)(build|dist|\.venv)/", name)]


def test_the_recipe_of_conda_asks_for_what_the_project_asks_for():
    text = (ROOT / "packaging" / "conda" / "recipe.yaml").read_text()
    released = PROJECT["tool"]["setuptools_scm"]["fallback_version"].partition(".dev")[0]
    assert f'version: "{released}"' in text
    assert f"\nversion: {released}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    run = text.partition("  run:\n")[2].partition("\ntests:")[0]
    for wanted in PROJECT["project"]["dependencies"]:
        name, _, bound = wanted.partition(";")[0].strip().partition(">=")
        called = {"matplotlib": "matplotlib-base"}.get(name, name)
        assert re.search(rf"(- |then: ){called} >={re.escape(bound)}$", run, re.MULTILINE), wanted
    host = text.partition("  host:\n")[2].partition("  run:\n")[0]
    for wanted in PROJECT["build-system"]["requires"]:
        name, rule, bound = re.fullmatch(r"([\w-]+)([>=]=)(.*)", wanted).groups()
        called = {"cmeel-eigen": "eigen"}.get(name, name)
        assert re.search(rf"- {called} {rule}{re.escape(bound)}$", host, re.MULTILINE), wanted
