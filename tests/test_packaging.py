"""What a maintainer releases with: the contents of wheel and source archive, the recipe of conda."""

import functools
import gzip
import re
import runpy
import subprocess
import tarfile
from pathlib import Path
from types import SimpleNamespace

import pytest

from cogging.files import parse_toml

ROOT = Path(__file__).resolve().parents[1]
PROJECT = parse_toml((ROOT / "pyproject.toml").read_text())
WHEELS = SimpleNamespace(**runpy.run_path(str(ROOT / "packaging" / "build_wheels.py")))


def test_a_whole_wheel_has_no_faults_and_each_fault_is_named():
    names = ["_core.cpython-311-x86_64-linux-gnu.so", "_core/__init__.pyi", "py.typed"]
    names += [f"share/cmake/cogging/cogging{part}.cmake" for part in ("Config", "Targets", "ConfigVersion")]
    names += [f"include/{path.relative_to(ROOT / 'cpp').as_posix()}" for path in (ROOT / "cpp/cogging").rglob("*.hpp")]
    names += [path.relative_to(ROOT / "python/cogging").as_posix() for path in (ROOT / "python/cogging").rglob("*.py")]
    beside = ["licenses/LICENSE", "licenses/THIRD_PARTY.md", "sboms/cogging.cdx.json"]
    names = [f"cogging/{name}" for name in names] + [f"cogging-0.1.0.dist-info/{name}" for name in beside]
    names += ["cogging_command/__init__.py"]
    for library in (".so", ".dylib", ".dll"):
        assert WHEELS.faults_of_wheel([*names, f"cogging/share/fmi/cogging_axis{library}"], 5_000_000) == []
    names += ["cogging/share/fmi/cogging_axis.so"]
    for what, pattern in WHEELS.NEEDED.items():
        left = [name for name in names if not re.fullmatch(pattern, name)]
        assert f"lacks {what}" in WHEELS.faults_of_wheel(left, 1)
    left = [name for name in names if not name.endswith("require.hpp")]
    assert WHEELS.faults_of_wheel(left, 1) == ["lacks the header cogging/require.hpp"]
    for name in ("tests/test_face.py", "cogging.libs/libgomp-a34b3233.so.1.0.0", "cogging/_core.cpp"):
        assert WHEELS.faults_of_wheel([*names, name], 1) == [f"holds {name}"]
    assert "more than" in WHEELS.faults_of_wheel(names, WHEELS.MOST_BYTES + 1)[0]


@pytest.mark.filterwarnings("ignore:Configuration was created without VcsEnvironment:DeprecationWarning")
def test_the_source_archive_holds_what_git_holds(tmp_path, monkeypatch):
    """Its tests, all that they read, and nothing that lies about: but for this project's own checks of a change."""
    import scikit_build_core.build as backend

    if not (ROOT / ".git").exists():
        pytest.skip("the source archive itself is no checkout")
    listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(listed, cwd=ROOT, capture_output=True, check=True).stdout.decode().split("\0")
    known = {name for name in names if name and (ROOT / name).exists()}
    monkeypatch.chdir(ROOT)
    with monkeypatch.context() as patch:  # nobody keeps this archive
        patch.setattr(gzip, "GzipFile", functools.partial(gzip.GzipFile, compresslevel=0))
        name = backend.build_sdist(str(tmp_path))
    with tarfile.open(tmp_path / name) as archive:
        files = {one.name.partition("/")[2] for one in archive.getmembers() if one.isfile()}
    assert files - known == {"PKG-INFO"}
    assert {name for name in known - files if not name.startswith(".ci/")} == set()
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
        assert re.search(rf"- {name} {rule}{re.escape(bound)}$", host, re.MULTILINE), wanted
