"""The folders of the core: each includes only from those before it, and each has a binding file of its name."""

import re
from pathlib import Path

CPP = Path(__file__).resolve().parents[2] / "cpp"
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
