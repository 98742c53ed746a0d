"""The folders of the core: each uses only those before it, and each has a binding file of its name."""

import re
from pathlib import Path

import pytest

CPP = Path(__file__).resolve().parents[2] / "cpp"
CORE = CPP / "cogging"
#: In their order. What stands beside them, in no folder, is their base and uses no folder.
FOLDERS = ["table", "basis", "reference", "plant", "control", "simulation", "estimation"]
#: Physics of the machine and laws of control do not know each other.
APART = {"plant": {"reference"}, "control": {"plant"}}
BASE = "."
#: What brings objects of Python into the core, and what several bindings share: bindings of no folder.
OF_THE_USERS = {"own_controller", "own_effect", "parameters"}


def folder_of(path):
    """The folder of a header by its path below cpp/cogging."""
    return Path(path).parts[0] if len(Path(path).parts) > 1 else BASE


def used_by(header):
    """Folders of the core that a header includes from."""
    return {folder_of(path) for path in re.findall(r'#include\s*[<"]cogging/([^">]+)[">]', header.read_text())}


HEADERS = sorted(path.relative_to(CORE) for path in CORE.rglob("*.hpp"))


@pytest.mark.parametrize("folder", [BASE, *FOLDERS])
def test_a_folder_uses_only_those_before_it(folder):
    allowed = {BASE} if folder == BASE else {BASE, *FOLDERS[: FOLDERS.index(folder) + 1]} - APART.get(folder, set())
    headers = [path for path in HEADERS if folder_of(path) == folder]
    assert headers
    beyond = {str(path): sorted(used_by(CORE / path) - allowed) for path in headers}
    assert {path: folders for path, folders in beyond.items() if folders} == {}


def test_every_folder_is_in_the_order_and_has_a_binding_file_of_its_name():
    assert {folder_of(path) for path in HEADERS} == {BASE, *FOLDERS}
    files = {path.stem for path in (CPP / "bindings").glob("*.cpp")}
    assert files - OF_THE_USERS == {"module", *FOLDERS}


def test_includes_of_the_core_are_found():
    """Each include names a header that is there, so that none escapes the order by another spelling."""
    for path in HEADERS:
        for name in re.findall(r'#include\s*"([^"]+)"', (CORE / path).read_text()):
            assert (CPP / name).is_file(), f"{path} includes {name}"
