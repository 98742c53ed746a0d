"""Malformed logs: each is answered in one line and status 2, and nothing is written."""

import errno
import os
import re

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from cogging.files import InputError
from cogging.logs.readers import isolate
from tests.attack.logs import FORMATS, run_case
from tests.fixtures.log_files import COLUMNS, TIME, hdf5_bytes, mat_bytes, mdf_bytes, parquet_bytes

HEAD = b"time,position,command\n"


def csv_bytes(columns=COLUMNS):
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return (",".join(columns) + "\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows)).encode()


def changed(name, values):
    return {**COLUMNS, name: values}


#: What a log holds, and what the answer must say.
CSV = {
    "missing column": (b"time,position,torque\n0,1,2\n", "column command: .* which has time, position, torque"),
    "text in a number": (HEAD + b"0,1,2\n1,abc,2\n", "line 3: position: .* got 'abc'"),
    "an empty field": (HEAD + b"0,1,2\n1,,2\n", "line 3: position: .* got ''"),
    "commas of thousands or of decimals": (
        b"time;position;command\n0;1,500;2\n",
        "line 2: must show whether a comma is a decimal mark or parts thousands: .* got numbers like '1,500' alone",
    ),
    "a point far below commas": (
        b"time;position;command\n" + b"".join(b"%d;0,5;2\n" % k for k in range(40_000)) + b"40000;1.5;2\n",
        "line 40002: position: must be a finite number, got '1.5'",
    ),
    "thousands and decimals": (b"time;position;command\n0;1.234,5;2\n", "line 2: position: .* '1.234,5'"),
    "too large a number": (HEAD + b"0,1e999,2\n", "line 2: position: .* finite"),
    "NaN": (HEAD + b"0,1,2\n1,2,nan\n", "line 3: command: must be a finite number, got 'nan'"),
    "half a line behind what is wanted": (
        b"time,position,command,extra,more\n0,1,2,3,4\n1,2,3,4",
        "line 3: must have 5 columns as the header, got 4",
    ),
    "repeated time": (HEAD + b"0,1,2\n0,1,2\n", "row 1: time: must be strictly increasing, got 0"),
    "time runs back": (HEAD + b"0,1,2\n2,1,2\n1,1,2\n", "row 2: time: .* got 1 after 2"),
    "empty": (b"", "column time: must be in the header, which has none"),
    "only a header": (HEAD, "rows: must be at least 1, got 0"),
    "no header": (b"0,1,2\n1,2,3\n", "column time: must be in the header, which has 0, 1, 2"),
    "UTF-16": (HEAD.decode().encode("utf-16"), "must be UTF-8 text"),
    "binary": (bytes(range(256)) * 4, "must be UTF-8 text"),
    "old line ends": (csv_bytes().replace(b"\n", b"\r"), "must end with LF or CR LF"),
    "zip archive": (b"PK\x03\x04" + bytes(40), "must be a log .* got a ZIP archive"),
    "directory": (None, "must be a file, got a directory"),
    "millimetres": (b"time,position [mm],command\n0,1,2\n1,2,3\n", r"unit 'mm'; give --scale position=0.001"),
    "percent of what": (b"time;position;command\ns;m;%\n0;1;2\n1;2;3\n", r"command: must be in V, A, N or Nm, got .*%"),
    "degrees": (b"time,position [deg],command\n0,1,2\n1,2,3\n", r"unit 'deg'; give --scale position=0.0174533"),
    "turns a minute": (
        b"time,position [rpm],command\n0,1,2\n1,2,3\n",
        r"position: must be in m or rad, got the unit 'rpm'; give --scale position=FACTOR",
    ),
}
#: The same with options.
CSV_READ_WITH = {
    "mapped to a missing column": (csv_bytes(), "--columns command=vir", "column vir: must be in the header"),
    "rows beyond the end": (csv_bytes(), "--rows 500:600", "rows: must be at least 1, got 0"),
    "scale of zero": (csv_bytes(), "--scale position=0", "scale: position: must be a finite number and not 0"),
    "scale of what is not there": (csv_bytes(), "--scale speed=2", "scale: speed: must be one of"),
    "scaled beyond all numbers": (
        csv_bytes(changed("command", 100.0 + TIME)),
        "--scale command=1e308",
        "command: must stay finite when scaled",
    ),
}
MATLAB = {
    "MATLAB: not one": (b"hello", "must be a MATLAB file as its name says, got b'hello'"),
    "MATLAB: cut": (lambda _: mat_bytes()[:3000], "must be a whole MATLAB file"),
    "MATLAB: struct": (lambda _: mat_bytes({"log": COLUMNS}), "column time: .* which has log.time, log.position"),
    "MATLAB: struct as a column": (
        lambda _: mat_bytes(changed("command", np.array([[(1.0,)], [(2.0,)]], dtype=[("x", "O")]))),
        "command: must be real numbers, got a struct of x",
    ),
    "MATLAB: cells": (
        lambda _: mat_bytes(changed("command", np.array([1.0, "a"], dtype=object))),
        "command: must be real numbers, got objects",
    ),
    "MATLAB: complex": (lambda _: mat_bytes(changed("command", TIME + 1j)), "command: must be real .* got complex"),
    "MATLAB: lengths": (
        lambda _: mat_bytes(changed("command", TIME[:100])),
        r"must be as long as time \(200\), got 100",
    ),
    "MATLAB: matrix": (
        lambda _: mat_bytes(changed("command", np.ones((200, 3)))),
        "must be one column, got an array of 200 x 3",
    ),
    "MATLAB 7.3: cut": (lambda _: hdf5_bytes()[:4000], r"must be a whole MATLAB 7.3 \(HDF5\) file"),
    "MATLAB 7.3: text": (
        lambda _: hdf5_bytes(changed("command", np.arange(200, dtype=np.uint16)), [("command", "char")]),
        "command: must be real numbers, got char",
    ),
}
MDF = {
    "MDF: millimetres": (lambda folder: mdf_bytes(folder, unit="mm"), "unit 'mm'; give --scale position=0.001"),
    "MDF: two time bases": (lambda folder: mdf_bytes(folder, groups=3), "must stand in one channel group"),
}
PARQUET = {
    "Parquet: text": (
        lambda _: parquet_bytes(changed("command", ["a"] * 200)),
        "command: must be real numbers, got string",
    ),
    "Parquet: null": (
        lambda _: parquet_bytes(changed("command", [None, *[1.0] * 199])),
        "row 0: command: must be a finite number, got null",
    ),
}
#: File name, content (bytes, or made from the folder), further arguments, and what the answer must say.
CASES = {
    **{case: ("a.csv", content, "", message) for case, (content, message) in CSV.items()},
    **{case: ("a.mat", content, "", message) for case, (content, message) in MATLAB.items()},
    **{case: ("a.mf4", content, "", message) for case, (content, message) in MDF.items()},
    **{case: ("a.parquet", content, "", message) for case, (content, message) in PARQUET.items()},
    **{case: ("a.csv", *told) for case, told in CSV_READ_WITH.items()},
    "missing file": ("b.csv", ..., "", "cannot be read: No such file"),
    "MATLAB: NaN, rows counted in the file": (
        "a.mat",
        mat_bytes(changed("position", np.where(np.arange(200) == 7, np.nan, COLUMNS["position"]))),
        "--rows 5:50",
        "row 7: position: must be a finite number",
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_a_malformed_log_is_answered_in_one_line(case, tmp_path, capsys, monkeypatch):
    name, content, arguments, message = CASES[case]
    monkeypatch.chdir(tmp_path)
    path = tmp_path / name
    if content is None:
        path.mkdir()
    elif content is not ...:
        path.write_bytes(content(tmp_path) if callable(content) else content)
    before = sorted(tmp_path.rglob("*"))
    status = main(["audit", name, "--json", "out.json", *arguments.split()])
    said = capsys.readouterr()
    assert status == 2
    assert said.err.count("\n") == 1
    assert said.err.startswith("cogging: ")
    assert re.search(message, said.err), said.err
    assert "Traceback" not in said.err
    assert sorted(tmp_path.rglob("*")) == before, "nothing is written"


def test_a_file_that_may_not_be_read(tmp_path, monkeypatch, capsys):
    """As the system would say; an administrator may read any."""
    path = tmp_path / "a.csv"
    path.write_bytes(csv_bytes())

    def opened(file, *given, _open=open, **named):
        if str(file) == str(path):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        return _open(file, *given, **named)

    monkeypatch.setattr("builtins.open", opened)
    assert main(["audit", str(path)]) == 2
    assert "cannot be read: Permission denied" in capsys.readouterr().err


def test_a_pipe_does_not_block(tmp_path):
    if not hasattr(os, "mkfifo"):
        pytest.skip("no pipes on this system")
    os.mkfifo(tmp_path / "a.csv")
    with pytest.raises(InputError, match="must be a file, got a device or pipe"):
        cogging.read_log(tmp_path / "a.csv")


def test_metadata_that_are_broken(tmp_path):
    (tmp_path / "a.csv").write_bytes(csv_bytes())
    (tmp_path / "a.csv.toml").write_text("seed = \n")
    with pytest.raises(InputError, match=r"a\.csv\.toml: must be TOML"):
        cogging.read_log(tmp_path / "a.csv")


MODEL = """
[axis]
mass = 0.12
travel = [0.0, 0.51]
[controller]
type = "pid"
sample_rate = 1000
kp = 1000.0
"""


UNITS = {
    "position in mm": (
        changed("position", 25e3 * COLUMNS["position"]),
        "spans .* m but the model's travel is 0.51 m: give --scale position=0.001 if it is in mm",
    ),
    "time in ms": (
        changed("time", 1e3 * TIME),
        "rows 1 s apart but .* 1000 Hz: give --scale time=0.001 if it is in ms",
    ),
    "reference in mm": (
        changed("reference", 1e3 * COLUMNS["reference"]),
        "reference: spans .* but the position .*: give --scale reference=0.001",
    ),
    "elsewhere": (changed("position", 5.0 + COLUMNS["position"]), "far outside the model's travel"),
}


@pytest.mark.parametrize(("columns", "message"), UNITS.values(), ids=UNITS)
def test_units_that_cannot_be_the_models(columns, message, tmp_path, capsys):
    (tmp_path / "a.csv").write_bytes(csv_bytes(columns))
    (tmp_path / "model.toml").write_text(MODEL)
    assert main(["audit", str(tmp_path / "a.csv"), "--model", str(tmp_path / "model.toml")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert re.search(message, error), error


# --- mutated files ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", FORMATS)
def test_a_mutated_log_is_read_or_refused_in_one_line(kind):
    """The first cases of `python -m tests.attack`, read as a user reads them."""
    found = [run_case(seed, kind, whole=True) for seed in range(60 if kind == "csv" else 3)]
    assert not [one for one in found if one is not None and not one.startswith("~")]


@pytest.mark.parametrize(
    ("behaviour", "message"),
    [
        ("import os; os.abort()", "ends its reader (signal 6)"),
        ("import time; time.sleep(60)", "is not read within 2 s"),
        ("bytearray(1 << 46)", "asks for more memory than there is"),
        ("raise RuntimeError('two\\nlines')", "got RuntimeError: two lines"),
        ("raise OSError(28, 'No space left')", "cannot be read: no room for temporary files: No space left"),
        (
            "raise ModuleNotFoundError('no', name='h5py')",
            "needs h5py to read a MATLAB file: pip install 'cogging[matlab]'",
        ),
    ],
)
def test_a_reader_that_fails_in_any_way(behaviour, message, tmp_path, monkeypatch):
    path = tmp_path / "a.mat"
    path.write_bytes(mat_bytes())
    reader = f"('MATLAB file', 'matlab', lambda request: exec({behaviour!r}))"
    start = f"import cogging.logs.readers.isolate as isolate; isolate.FORMATS['matlab'] = {reader}; "
    if "sleep" in behaviour:  # the others need their time to start, where the machine is busy
        monkeypatch.setattr(isolate, "SECONDS", 2.0)
    monkeypatch.setattr(isolate, "START", isolate.START.replace("from cogging", f"{start}from cogging", 1))
    with pytest.raises(InputError) as caught:
        cogging.read_log(path)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
