"""Licences: all that is compiled in, or brought by pip, is named with the licence that it states."""

import importlib.metadata
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
TEXT = (ROOT / "THIRD_PARTY.md").read_text(encoding="utf-8")
#: Of whoever installs cogging for use; those of its tests and its site are not listed one by one.
OF_USERS = [name for name in PROJECT["project"]["optional-dependencies"] if name not in ("test", "docs", "lint", "all")]
OF_USERS.remove("benchmark")
INSTALLED = {re.sub(r"[-_.]+", "-", one.name).lower() for one in importlib.metadata.distributions()}
#: How packages word a licence that the page names by its identifier.
WORDS = {
    "BSD-3-Clause": r"BSD|Enthought",
    "Apache-2.0": r"Apache",
    "MIT": r"MIT",
    "MPL-2.0": r"MPL|Mozilla",
    "MPL-2.0 AND MIT": r"MPL.*MIT",
    "LGPL-3.0-or-later": r"LGPLv3\+|LGPL-3.0-or-later",
    "Python Software Foundation's, adapted": r"Python Software Foundation|matplotlib",
}


def table(heading):
    """The rows of the table below a heading, as lists of cells."""
    part = TEXT.partition(f"## {heading}\n")[2].partition("\n## ")[0]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in part.splitlines() if line.startswith("|")]
    assert len(rows) > 2, heading
    return rows[2:]


def brought():
    """Names of what pip brings, and the extra that asks for it."""
    named = dict.fromkeys(PROJECT["project"]["dependencies"], "all")
    for extra in OF_USERS:
        for one in PROJECT["project"]["optional-dependencies"][extra]:
            named.setdefault(one, f"extra `{extra}`")
    return {re.match(r"[\w-]+", name)[0]: use for name, use in named.items()} | {"tomli": "Python 3.10"}


def test_each_dependency_of_a_user_is_listed():
    assert {name: use for name, _, use in table("Brought by pip, not shipped")} == brought()


@pytest.mark.parametrize(
    ("name", "licence"), [row[:2] for row in table("Brought by pip, not shipped") if row[0].lower() in INSTALLED]
)
def test_each_has_the_licence_that_its_package_states(name, licence):
    stated = importlib.metadata.metadata(name)
    classifiers = [one for one in stated.get_all("Classifier") or [] if one.startswith("License")]
    words = f"{stated.get('License-Expression')} {stated.get('License')} {' '.join(classifiers)}"
    assert re.search(WORDS[licence], words, re.DOTALL), words[:300]


def includes(folder):
    """What the sources of a folder include in angle brackets, up to the first slash."""
    files = [path for path in (ROOT / "cpp" / folder).rglob("*") if path.suffix in (".hpp", ".cpp")]
    assert files
    return {
        match[1]
        for path in files
        for match in re.finditer(r"^ *# *include *<([\w+.-]+)", path.read_text(encoding="utf-8"), re.MULTILINE)
    }


def test_the_core_includes_nothing_of_others_and_the_bindings_what_is_listed():
    """Beside the standard library's headers, which have no suffix, and those of systems and processors."""
    systems = {"immintrin.h", "arm_neon.h", "x86intrin.h", "emmintrin.h"}
    systems |= {"unistd.h", "sys/resource.h", "windows.h", "mach/mach.h"}
    suffixed = {folder: {one for one in includes(folder) if "." in one} - systems for folder in ("cogging", "fmi")}
    assert suffixed == {"cogging": set(), "fmi": set()}
    named = {one for one in includes("bindings") if one in ("pybind11", "Eigen") or "." in one}
    assert named - systems == {"pybind11"}  # whose eigen.h brings Eigen
    found = re.findall(r"find_package\((\w+)", (ROOT / "cpp" / "bindings" / "CMakeLists.txt").read_text("utf-8"))
    assert set(found) == {"Python", "pybind11", "Eigen3"}


def test_no_file_of_others_lies_in_what_ships():
    """Sources, texts, our style sheet: no fonts, scripts, archives, binaries or data that came from elsewhere."""
    ours = {".py", ".pyi", ".hpp", ".cpp", ".txt", ".map", ".cmake", ".toml", ".css", ".j2", ".mplstyle", ".typed", ""}
    files = [path for folder in ("python", "cpp") for path in (ROOT / folder).rglob("*") if path.is_file()]
    foreign = {p for p in files if p.suffix not in ours | {".so", ".pyd", ".pyc"} and ".mypy_cache" not in p.parts}
    assert foreign == set()
    holders = {
        line.strip(" /#")
        for path in files
        if path.suffix in ours
        for line in path.read_text(encoding="utf-8").splitlines()
        if re.search(r"copyright \(c\)", line, re.IGNORECASE)
    }
    assert len(holders) == 1
    assert "Sun Microsystems" in holders.pop()
    assert "Copyright (C) 1993 by Sun Microsystems" in TEXT


def bill_of_materials(folder, **given):
    """What CMake writes at a build, as JSON."""
    import cmake

    known = {"version": "0.1.0", "eigen_version": "3.4.0", "pybind11_version": "3.1.0"} | given
    words = [f"-D{name}={value}" for name, value in known.items()] + [f"-Dbill_of_materials={folder / 'bill.json'}"]
    command = [Path(cmake.CMAKE_BIN_DIR) / "cmake", *words, "-P", ROOT / "packaging" / "bill_of_materials.cmake"]
    subprocess.run(command, check=True, capture_output=True)
    return json.loads((folder / "bill.json").read_text(encoding="utf-8"))


RUNTIMES = {
    "none": {},
    "GCC's": {"COGGING_OWN_RUNTIME": "1", "CMAKE_CXX_COMPILER_VERSION": "12.2.0"},
    "Microsoft's": {"MSVC": "1", "CMAKE_CXX_COMPILER_VERSION": "19.44"},
}


@pytest.mark.parametrize("runtime", RUNTIMES)
def test_the_bill_of_materials_lists_what_is_compiled_in(runtime, tmp_path):
    bill = bill_of_materials(tmp_path, **RUNTIMES[runtime])
    versions = {one["name"]: one["version"] for one in bill["components"]}
    compiler = {"none": {}, "GCC's": {"libstdc++": "12.2.0"}, "Microsoft's": {"msvc-runtime": "19.44"}}[runtime]
    assert versions == {"eigen": "3.4.0", "pybind11": "3.1.0", "fdlibm": "5.3", **compiler}
    assert bill["dependencies"] == [{"ref": "cogging", "dependsOn": list(versions)}]
    assert bill["metadata"]["component"]["version"] == "0.1.0"
    listed = " ".join(" ".join(row[:2]) for row in table("Compiled in"))
    for one in bill["components"]:
        (licence,) = one["licenses"]
        stated = licence.get("expression") or licence["license"].get("id")
        assert stated is None or stated in listed
    from cyclonedx import schema
    from cyclonedx.validation.json import JsonStrictValidator

    validator = JsonStrictValidator(schema.SchemaVersion.V1_6)
    assert validator.validate_str((tmp_path / "bill.json").read_text(encoding="utf-8")) is None
    assert validator.validate_str(json.dumps(bill | {"specVersion": 6})) is not None
