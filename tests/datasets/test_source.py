"""Where the public data sets are looked for, and what is said where they are not there."""

import sys

import pytest

from cogging import InputError
from cogging.datasets import emps, laas, odrive, tro2021
from tests.fixtures.covering import covering
from tests.fixtures.measured import FOLDER

SETS = [emps, laas, odrive, tro2021]
CALLS = [
    *[(emps, call) for call in (emps.files, emps.read, emps.pulses)],
    *[(laas, call) for call in (laas.files, lambda folder=None: laas.read("acc_current", folder))],
    *[(odrive, call) for call in (odrive.files, lambda folder=None: odrive.read("slow2_comp_0", folder))],
    (odrive, lambda folder=None: odrive.scan("alone", folder)),
    *[(tro2021, call) for call in (tro2021.files, tro2021.steady_speeds)],
]
LICENCES = {"emps": "no licence stated: cite", "laas": "BSD-3-Clause", "odrive": "MIT", "tro2021": "MIT"}


@pytest.fixture(autouse=True)
def _no_package(monkeypatch):
    """Without `nonlinear-benchmarks`, where it is installed too, and without a folder of all sets."""
    monkeypatch.setitem(sys.modules, "nonlinear_benchmarks", None)
    monkeypatch.delenv("COGGING_DATA", raising=False)


@pytest.mark.parametrize(
    ("case", "how"), covering(range(len(CALLS)), ["nothing", "empty", "folder", "file", "named", "variable"])
)
def test_without_data_one_line_says_where_to_get_them(case, how, tmp_path, monkeypatch):
    data, call = CALLS[case]
    folder = {"folder": tmp_path, "file": tmp_path / "a.txt", "named": tmp_path / "nowhere"}.get(how)
    (tmp_path / "a.txt").write_text("no folder")
    if how in ("empty", "variable"):
        monkeypatch.setenv("COGGING_DATA", str(tmp_path) if how == "variable" else "")
    with pytest.raises(InputError) as caught:
        call(folder=folder)
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith(f"{data.SOURCE.name}: ")
    assert data.SOURCE.origin in line
    assert LICENCES[data.SOURCE.name] in line
    if how in ("nothing", "empty"):
        assert "COGGING_DATA" in line
    else:
        base = folder or tmp_path
        assert f"must be in {base} or {base / data.SOURCE.name}, is not" in line
    assert ("pip install nonlinear-benchmarks" in line) == (data is emps and folder is None)


@pytest.mark.parametrize("data", [emps, laas, odrive])
@pytest.mark.parametrize("name", ["", "DATA", "stopped_data.txt", "../acc_current", None, 3])
def test_a_log_that_is_not_of_the_set(data, name, tmp_path):
    with pytest.raises(ValueError, match=rf"^name: must be one of {', '.join(data.FILES)}, got "):
        data.read(name, tmp_path)


@pytest.mark.data
@pytest.mark.parametrize("data", SETS, ids=lambda data: data.SOURCE.name)
def test_the_folder_of_the_set_that_of_all_and_the_variable_are_the_same(data, monkeypatch):
    direct, within = data.files(FOLDER / data.SOURCE.name), data.files(str(FOLDER))
    monkeypatch.setenv("COGGING_DATA", str(FOLDER))
    assert direct == within == data.files()
    assert all(path.is_file() for path in direct.values())


def test_what_the_caller_names_is_not_replaced_by_the_variable(tmp_path, monkeypatch):
    here, there = tmp_path / "here", tmp_path / "there"
    for folder in (here, there):
        folder.mkdir()
        for name in laas.FILES:
            (folder / f"{name}.txt").write_text("Time, Position, Velocity, Iq\n0, 0, 0, 0\n1, 2, 3, 4\n")
    monkeypatch.setenv("COGGING_DATA", str(here))
    assert {path.parent for path in laas.files().values()} == {here}
    assert {path.parent for path in laas.files(there).values()} == {there}
    with pytest.raises(InputError):
        laas.files(tmp_path)
