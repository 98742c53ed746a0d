"""What a maintainer releases with: contents of wheel and source archive, the recipe of conda, licences."""

import functools
import gzip
import json
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


TEXT = (ROOT / "THIRD_PARTY.md").read_text(encoding="utf-8")
#: Of whoever installs cogging for use; those of its tests and its site are not listed one by one.
OF_USERS = [name for name in PROJECT["project"]["optional-dependencies"] if name not in ("test", "docs", "lint", "all")]
OF_USERS.remove("benchmark")


def table(heading):
    """The rows of the table below a heading, as lists of cells."""
    part = TEXT.partition(f"## {heading}\n")[2].partition("\n## ")[0]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in part.splitlines() if line.startswith("|")]
    assert len(rows) > 2, heading
    return rows[2:]


def test_each_dependency_of_a_user_is_listed():
    """With the extra that asks for it."""
    named = dict.fromkeys(PROJECT["project"]["dependencies"], "all")
    for extra in OF_USERS:
        for one in PROJECT["project"]["optional-dependencies"][extra]:
            named.setdefault(one, f"extra `{extra}`")
    brought = {re.match(r"[\w-]+", name)[0]: use for name, use in named.items()} | {"tomli": "Python 3.10"}
    assert {name: use for name, _, use in table("Brought by pip, not shipped")} == brought


@pytest.mark.parametrize(
    ("given", "runtime"),
    [
        ({}, {}),
        ({"COGGING_OWN_RUNTIME": "1", "CMAKE_CXX_COMPILER_VERSION": "12.2.0"}, {"libstdc++": "12.2.0"}),
        ({"MSVC": "1", "CMAKE_CXX_COMPILER_VERSION": "19.44"}, {"msvc-runtime": "19.44"}),
    ],
    ids=["none", "GCC's", "Microsoft's"],
)
def test_the_bill_of_materials_lists_what_is_compiled_in(given, runtime, tmp_path):
    """As CMake writes it at a build."""
    import cmake
    from cyclonedx import schema
    from cyclonedx.validation.json import JsonStrictValidator

    known = {"version": "0.1.0", "pybind11_version": "3.1.0"} | given
    words = [f"-D{name}={value}" for name, value in known.items()] + [f"-Dbill_of_materials={tmp_path / 'bill.json'}"]
    command = [Path(cmake.CMAKE_BIN_DIR) / "cmake", *words, "-P", ROOT / "packaging" / "bill_of_materials.cmake"]
    subprocess.run(command, check=True, capture_output=True)
    text = (tmp_path / "bill.json").read_text(encoding="utf-8")
    bill = json.loads(text)
    versions = {one["name"]: one["version"] for one in bill["components"]}
    assert versions == {"pybind11": "3.1.0", "fdlibm": "5.3", **runtime}
    assert bill["dependencies"] == [{"ref": "cogging", "dependsOn": list(versions)}]
    assert bill["metadata"]["component"]["version"] == "0.1.0"
    listed = " ".join(" ".join(row[:2]) for row in table("Compiled in"))
    for one in bill["components"]:
        (licence,) = one["licenses"]
        stated = licence.get("expression") or licence["license"].get("id")
        assert stated is None or stated in listed
    assert JsonStrictValidator(schema.SchemaVersion.V1_6).validate_str(text) is None
