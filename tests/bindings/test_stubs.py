"""The committed stubs are those that the bindings generate, and what is public is documented."""

import inspect
import subprocess
import sys
from pathlib import Path

import cogging
from cogging import _core

STUBS = Path(__file__).parents[2] / "python" / "cogging" / "_core"


def test_stubs_are_up_to_date(tmp_path):
    subprocess.run(
        [sys.executable, "-m", "pybind11_stubgen", "cogging._core", "-o", str(tmp_path)],
        check=True,
        capture_output=True,
    )
    made = {path.name: path.read_text() for path in (tmp_path / "cogging" / "_core").glob("*.pyi")}
    committed = {path.name: path.read_text() for path in STUBS.glob("*.pyi")}
    assert made == committed, "run: python -m pybind11_stubgen cogging._core -o python"


def test_everything_public_is_documented():
    undocumented = [
        name
        for name in cogging.__all__
        if callable(getattr(cogging, name)) and not inspect.getdoc(getattr(cogging, name))
    ]
    assert undocumented == []


def test_parameter_structs_are_read_only_and_say_their_units():
    structs = [kind for kind in vars(_core).values() if inspect.isclass(kind) and hasattr(kind, "FIELDS")]
    structs += list(cogging.EFFECTS.values())
    assert len(structs) > 15
    for struct in structs:
        made = struct()
        for name, (_unit, meaning) in struct.FIELDS.items():
            assert meaning, f"{struct.__name__}.{name} has no meaning"
            try:
                setattr(made, name, 1.0)
            except AttributeError:
                continue
            raise AssertionError(f"{struct.__name__}.{name} can be changed")
