"""Where the public data sets are looked for, the error where they are missing or broken, and what is read of each.

From files like the originals with drawn numbers.
"""

import io
import sys
from types import ModuleType

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


def write_emps(folder, seed):
    """Both files with drawn columns, n by 1 as theirs; what was written by file."""
    rng = np.random.default_rng(seed)
    written = {}
    folder.mkdir(parents=True, exist_ok=True)
    for name in emps.FILES:
        rows = int(rng.integers(2, 300))
        table = {column: rng.normal(size=(rows, 1)) for column in ("qm", "qg", "vir")}
        table["t"] = np.cumsum(rng.uniform(1e-4, 1e-2, (rows, 1)), axis=0)
        table |= {"gtau": 35.15, "kp": 160.18, "kv": 243.45}
        if name == "DATA_EMPS_PULSES":
            table["pulses_N"] = rng.choice([0, 5], (rows, 1)).astype(np.uint8)
        savemat(folder / f"{name}.mat", table)
        written[name] = table
    return written


@pytest.mark.parametrize(("seed", "below"), [(0, "."), (1, "emps")])
def test_columns_are_in_si_and_the_command_in_newtons(tmp_path, seed, below):
    written = write_emps(tmp_path / below, seed)
    for name, table in written.items():
        log = emps.read(name, tmp_path)
        for column, theirs in {"time": "t", "position": "qm", "reference": "qg"}.items():
            np.testing.assert_array_equal(getattr(log, column), table[theirs][:, 0])
        np.testing.assert_allclose(log.command, 35.15065 * table["vir"][:, 0], rtol=1e-15)
    units = written["DATA_EMPS_PULSES"]["pulses_N"][:, 0]
    np.testing.assert_allclose(emps.pulses(tmp_path), 1.08 * 35.15065 * units, rtol=1e-15)


def replace_package(monkeypatch, answer):
    """Replace the package by its one function that is used here, with its signature."""

    def load(train_test_split=True, data_file_locations=False, dir_placement=None, force_download=False):
        assert data_file_locations
        return answer()

    stand_in = ModuleType("nonlinear_benchmarks")
    stand_in.EMPS = load
    monkeypatch.setitem(sys.modules, "nonlinear_benchmarks", stand_in)


def test_the_package_is_asked_where_no_folder_has_them(tmp_path, monkeypatch):
    kept, own = tmp_path / "kept", tmp_path / "own"
    written = write_emps(kept, 1)
    replace_package(monkeypatch, lambda: [str(kept / f"{name}.mat") for name in emps.FILES])
    assert emps.files() == {name: kept / f"{name}.mat" for name in emps.FILES}
    np.testing.assert_array_equal(emps.read().position, written["DATA_EMPS"]["qm"][:, 0])
    monkeypatch.setenv("COGGING_DATA", str(own))
    assert len(emps.pulses()) == len(written["DATA_EMPS_PULSES"]["qm"])
    write_emps(own / "emps", 2)
    assert {path.parent for path in emps.files().values()} == {own / "emps"}  # the caller's own come first
    with pytest.raises(InputError, match="nowhere"):
        emps.files(tmp_path / "nowhere")  # who names a folder means it


def test_a_download_that_fails_is_one_line(tmp_path, monkeypatch):
    def fail():
        raise OSError("no network\nat all")

    replace_package(monkeypatch, fail)
    with pytest.raises(InputError, match=r"public at nonlinearbenchmark\.org .*cite") as caught:
        emps.read()
    assert str(caught.value).isprintable()
    assert "nonlinear-benchmarks could not fetch it: OSError: no network" in str(caught.value)
    replace_package(monkeypatch, lambda: [str(tmp_path / f"{name}.mat") for name in emps.FILES])
    with pytest.raises(InputError, match=f"DATA_EMPS.mat: must be in {tmp_path}, is not; public at nonlin"):
        emps.read()


CLONE = "analysis/cogging_torque"


def place(name, below):
    """Where a file stands: in a folder of the set's name, or as in a clone."""
    if name in odrive.SCANS:
        file = f"cogging_measure_{odrive.SCANS[name]}.npy"
        return f"odrive/{file}" if below == "named" else f"{CLONE}/{file}"
    group, run, number = name.rsplit("_", 2)
    return f"odrive/{name}.npy" if below == "named" else f"{CLONE}/{group}/{run}_{number}.npy"


def write_odrive(path, values):
    path.parent.mkdir(parents=True, exist_ok=True)
    np.save(path, values)


def polled(rng, rows=400):
    """Time, counts and the current that acts between the rows of a slow run that jumps from tooth to tooth."""
    time = np.cumsum(rng.uniform(1.5e-3, 6e-3, rows))
    counts = 8192 / (2 * np.pi) * (0.5 * time + 0.05 * np.sin(20 * time))
    return time, counts, rng.normal(0.3, 0.8, rows)


def smoothed(time, current, before=0.0):
    """What the drive reports at the rows of a current that is held between them: exactly, by its equation."""
    smooth = [before]
    for step, acting in zip(np.diff(time), current[:-1], strict=True):
        smooth.append(acting + (smooth[-1] - acting) * np.exp(-step / odrive.SMOOTHING))
    return np.array(smooth)


@pytest.mark.parametrize(("below", "seed"), [("named", 1), ("clone", 2)])
def test_the_acting_current_is_recovered_from_the_smoothed_one(tmp_path, seed, below):
    rng = np.random.default_rng(seed)
    name = str(rng.choice(odrive.FILES))
    time, counts, current = polled(rng)
    smooth = smoothed(time, current, rng.normal())
    write_odrive(tmp_path / place(name, below), np.array([time, counts, smooth]))
    log = odrive.read(name, tmp_path)
    np.testing.assert_array_equal(log.time, time[:-1])
    np.testing.assert_allclose(log.position, counts[:-1] * 2 * np.pi / 8192, rtol=1e-14)
    np.testing.assert_allclose(log.command, current[:-1], atol=1e-9)
    recorded = odrive.read(name, tmp_path, smoothed=True)
    np.testing.assert_array_equal(recorded.time, time)
    np.testing.assert_array_equal(recorded.command, smooth)


def test_a_way_back_is_left_out_until_the_motor_rests(tmp_path):
    rng = np.random.default_rng(0)
    time, counts, current = polled(rng, 800)
    back = int(rng.integers(60, 120))
    counts[:back] += np.linspace(8192 * rng.uniform(0.9, 1.0), 0.0, back)
    write_odrive(tmp_path / "slow2_nocomp_1.npy", np.array([time, counts, current]))
    log, whole = (odrive.read("slow2_nocomp_1", tmp_path, smoothed=True, rewind=rewind) for rewind in (False, True))
    assert len(whole.time) == 800
    assert time[back - 1] + 0.29 < log.time[0] < time[back - 1] + 0.32
    np.testing.assert_array_equal(log.command, whole.command[-len(log.time) :])
    assert log.time[-1] == whole.time[-1]


@pytest.mark.parametrize(("name", "below"), list(zip(odrive.SCANS, ["named", "named", "clone"], strict=True)))
def test_a_scan_holds_the_places_that_were_visited(tmp_path, name, below):
    rng = np.random.default_rng(len(name))
    first = 15 if name == "backward" else 0
    held = np.zeros(8192)
    held[first::16] = rng.normal(0.2, 0.5, 512)
    write_odrive(tmp_path / place(name, below), held)
    scan = odrive.scan(name, tmp_path)
    np.testing.assert_array_equal(scan.current, held[first::16])
    np.testing.assert_allclose(np.diff(scan.position), 2 * np.pi / 512)
    assert scan.position[0] == pytest.approx(first * 2 * np.pi / 8192)
