"""Licences: all that is compiled in, or brought by pip, is named with the licence that it states."""

import json
import re
import subprocess
from pathlib import Path

import pytest

from cogging.files import parse_toml

ROOT = Path(__file__).resolve().parents[1]
PROJECT = parse_toml((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
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
