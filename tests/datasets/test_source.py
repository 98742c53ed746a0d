"""Where the public data sets are looked for, the error where they are missing or broken, and their text files."""

import io
import sys

import numpy as np
import pytest
from scipy.io import savemat

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
    ("case", "how"), covering(range(len(CALLS)), ["nothing", "empty", "folder", "file", "variable"])
)
def test_without_data_one_line_says_where_to_get_them(case, how, tmp_path, monkeypatch):
    data, call = CALLS[case]
    folder = {"folder": tmp_path, "file": tmp_path / "a.txt"}.get(how)
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


@pytest.mark.data
@pytest.mark.parametrize("data", SETS, ids=lambda data: data.SOURCE.name)
def test_the_folder_of_the_set_that_of_all_and_the_variable_are_the_same(data, monkeypatch):
    direct, within = data.files(FOLDER / data.SOURCE.name), data.files(str(FOLDER))
    monkeypatch.setenv("COGGING_DATA", str(FOLDER))
    assert direct == within == data.files()
    assert all(path.is_file() for path in direct.values())


#: Of each file its place in a clone and its header.
FILES = {
    "stopped_data": ("codes/Stopped/stopped_data", "Time, Position, Velocity, Iq, Uq, Vsupply, Error Position"),
    "acc_current": ("codes/acceleration_data", "Time, Position, Velocity, Iq, Uq, Vsupply"),
    "speed_test1": ("codes/Get_Data", "Time, Position, Velocity, Reference Velocity, Iq, Function Activated"),
}
LAAS = {"time": "Time", "position": "Position", "velocity": "Velocity", "current": "Iq"}


def write_laas(path, name, rng):
    """A file with the header of theirs and drawn rows: the table by column."""
    columns = FILES[name][1].split(", ")
    table = rng.normal(size=(40, len(columns))).round(5)
    table[:, 0] = np.cumsum(rng.uniform(2e-4, 9e-3, 40)).round(5)
    if name == "speed_test1":
        table[:, -1] = np.arange(40) % 2
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([FILES[name][1], *(", ".join(map(str, row)) for row in table)]) + "\n")
    return dict(zip(columns, table.T, strict=True))


@pytest.mark.parametrize("where", ["named", "clone"])
def test_laas_columns_and_rows_with_and_without_the_compensation(tmp_path, where):
    for name in laas.FILES:
        place = tmp_path / ("laas" if where == "named" else FILES[name][0]) / f"{name}.txt"
        table = write_laas(place, name, np.random.default_rng(0))
        on = table.get("Function Activated", np.zeros(40)) == 1
        for is_on in {False, bool(on.any())}:
            rows = laas.read(name, tmp_path, compensated=is_on)
            for column, theirs in LAAS.items():
                np.testing.assert_array_equal(getattr(rows, column), table[theirs][on == is_on])
    with pytest.raises(ValueError, match="compensated: must be False for acc_current"):
        laas.read("acc_current", tmp_path, compensated=True)


HEAD = "\ufeffDate:;2020-07-08 21:30:14\nSampling period:;40.000\n;Velocity actual value averaged;Torque actual value\n"


def write_tro2021(path, rng, rows):
    """A file as the drive's program writes it, with what it adds behind the last values: (rows, 3)."""
    table = np.column_stack([np.arange(rows) * 40.0, rng.integers(-9, 200, rows), rng.normal(30.0, 9.0, rows).round(1)])
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [";".join(map(str, row)) for row in table]
    path.write_text(HEAD + "ms;rpm;%\n" + "\n".join([*lines, "800.0;;", ";;", ""]), encoding="utf-8")
    return table


@pytest.mark.parametrize("below", [".", "tro2021/experiments/driveNo1"])
def test_every_run_of_tro2021_and_its_mean(tmp_path, below):
    rng = np.random.default_rng(len(below))
    names = ["start_stop/50", *(f"steady_state/0.096kg/{name}" for name in ("10", "n10", "n2"))]
    tables = {name: write_tro2021(tmp_path / below / f"{name}.csv", rng, int(rng.integers(21, 90))) for name in names}
    files = tro2021.files(tmp_path)
    assert files.keys() == tables.keys()
    for name, table in tables.items():
        run = tro2021.read(files[name])
        np.testing.assert_allclose([run.time, run.speed, run.torque], table.T * [[1e-3], [1], [1]], rtol=1e-15)
    means = [tables[name][20:, 1:].mean(axis=0) for name in names[1:]]
    np.testing.assert_allclose(np.column_stack(tro2021.steady_speeds(tmp_path)), means, rtol=1e-12)


def content_of(values):
    """The bytes of a file of text, of a table of MATLAB, or of an array of numpy."""
    if isinstance(values, bytes | str):
        return values.encode() if isinstance(values, str) else values
    file = io.BytesIO()
    savemat(file, values) if isinstance(values, dict) else np.save(file, values)
    return file.getvalue()


RUN, ARRAY, STEADY = "slow2_comp_0", "must be a numpy array of numbers", "steady_state/0.096kg/n7.csv"
#: File, what is in it, what reads it, and the error.
BROKEN = [
    ("DATA_EMPS.mat", "<!DOCTYPE html>", emps.read, "must be a MATLAB"),
    ("DATA_EMPS_PULSES.mat", {"t": [0.0, 1.0], "gtau": 35.15}, emps.pulses, "column pulses_N: must be"),
    *(
        (f"{RUN}.npy", values, lambda folder: odrive.read(RUN, folder), what)
        for values, what in (
            (np.zeros((2, 9)), r"must be three rows of values: time, position, current, got \(2, 9\)"),
            (np.zeros((3, 9)), "time: must increase"),
            (np.full((3, 9), np.nan), "must hold finite numbers"),
            (np.array([[None] * 9] * 3), ARRAY),
            (b"\x93NUMPY\x01\x00", ARRAY),
        )
    ),
    (
        "cogging_measure_final_iso_16.npy",
        np.zeros(512),
        lambda folder: odrive.scan("alone", folder),
        r"must be 8192 values, a count each, got \(512,\)",
    ),
    (
        "acc_current.txt",
        "Time, Position, Iq\n0, 1, 2\n",
        lambda folder: laas.read("acc_current", folder),
        "column Velocity: must be",
    ),
    (STEADY, "", tro2021.steady_speeds, "must have a row of units"),
    (STEADY, "ms;rpm;%\n0;1;2\n40;one;2\n", tro2021.steady_speeds, "line 3: must be three finite numbers, got '40"),
    (STEADY, "ms;rpm;%\n0;1;2\n40;1;2\n", tro2021.steady_speeds, "rows: must be more than 20, got 2"),
]


@pytest.mark.parametrize(("name", "values", "read", "what"), BROKEN, ids=range(len(BROKEN)))
def test_a_broken_file_is_named_in_one_line(name, values, read, what, tmp_path):
    for one in (name, *(f"{other}.mat" for other in emps.FILES if name.startswith("DATA"))):
        (tmp_path / one).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / one).write_bytes(content_of(values))
    with pytest.raises(InputError, match=what) as caught:
        read(folder=tmp_path)
    assert str(tmp_path / name) in str(caught.value)
    assert "\n" not in str(caught.value)
