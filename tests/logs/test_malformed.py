"""Malformed logs: each is answered in one line and status 2, and nothing is written."""

import re

import numpy as np
import pytest

from cogging.cli.main import main
from tests.attack.logs import FORMATS, run_case
from tests.fixtures.command_files import csv_bytes
from tests.fixtures.log_files import COLUMNS, TIME, hdf5_bytes, mat_bytes, mdf_bytes, parquet_bytes

HEAD = b"time,position,command\n"


def changed(name, values):
    return {**COLUMNS, name: values}


def with_command(make, values, *arguments):
    """The bytes of a log whose command has these values."""
    return lambda folder: make(changed("command", values), *arguments)


#: What a log holds, and what the answer must say.
CSV = {
    "text in a number": (HEAD + b"0,1,2\n1,abc,2\n", "line 3: position: .* got 'abc'"),
    "commas of thousands or of decimals": (
        b"time;position;command\n0;1,500;2\n",
        "line 2: must show whether a comma is a decimal mark or parts thousands: .* got numbers like '1,500' alone",
    ),
    "NaN": (HEAD + b"0,1,2\n1,2,nan\n", "line 3: command: must be a finite number, got 'nan'"),
    "half a line behind the wanted columns": (
        b"time,position,command,extra,more\n0,1,2,3,4\n1,2,3,4",
        "line 3: must have 5 columns as the header, got 4",
    ),
    "time runs back": (HEAD + b"0,1,2\n2,1,2\n1,1,2\n", "row 2: time: .* got 1 after 2"),
    "empty": (b"", "column time: must be in the header, which has none"),
    "only a header": (HEAD, "rows: must be at least 1, got 0"),
    "no header": (b"0,1,2\n1,2,3\n", "column time: must be in the header, which has 0, 1, 2"),
    "UTF-16": (HEAD.decode().encode("utf-16"), "must be UTF-8 text"),
    "metadata": (
        lambda folder: (folder / "a.csv.toml").write_text("seed = \n") and csv_bytes(COLUMNS),
        r"a\.csv\.toml: must be TOML",
    ),
    "millimetres": (b"time,position [mm],command\n0,1,2\n1,2,3\n", r"unit 'mm'; give --scale position=0.001"),
    "turns a minute": (
        b"time,position [rpm],command\n0,1,2\n1,2,3\n",
        r"position: must be in m or rad, got the unit 'rpm'; give --scale position=FACTOR",
    ),
}
#: Of a sound log and these options.
OPTIONS = {
    "--columns command=vir": "column vir: must be in the header",
    "--rows 500:600": "rows: must be at least 1, got 0",
    "--scale position=0": "scale: position: must be a finite number and not 0",
    "--scale command=1e308 --rows 10:40": "command: must stay finite when scaled",
}
MATLAB = {
    "not one": (b"hello", "must be a MATLAB file as its name says, got b'hello'"),
    "struct": (lambda _: mat_bytes({"log": COLUMNS}), "column time: .* which has log.time, log.position"),
    "struct as a column": (
        with_command(mat_bytes, np.array([[(1.0,)], [(2.0,)]], dtype=[("x", "O")])),
        "command: must be real numbers, got a struct of x",
    ),
    "cells": (with_command(mat_bytes, np.array([1.0, "a"], dtype=object)), "must be real numbers, got objects"),
    "matrix": (with_command(mat_bytes, np.ones((200, 3))), "must be one column, got an array of 200 x 3"),
    "7.3, cut": (lambda _: hdf5_bytes()[:4000], r"must be a whole MATLAB 7.3 \(HDF5\) file"),
    "7.3, text": (
        with_command(hdf5_bytes, np.arange(200, dtype=np.uint16), [("command", "char")]),
        "command: must be real numbers, got char",
    ),
    "NaN, rows counted in the file": (
        lambda _: mat_bytes(changed("position", np.where(np.arange(200) == 7, np.nan, COLUMNS["position"]))),
        "row 7: position: must be a finite number",
        "--rows 5:50",
    ),
}
MDF = {
    "millimetres": (lambda folder: mdf_bytes(folder, unit="mm"), "unit 'mm'; give --scale position=0.001"),
    "two time bases": (lambda folder: mdf_bytes(folder, groups=3), "must stand in one channel group"),
}
PARQUET = {"text": (with_command(parquet_bytes, ["a"] * 200), "command: must be real numbers, got string")}
MODEL = """
[axis]
mass = 0.12
travel = [0.0, 0.51]
"""


def beside_a_model(name, factor):
    """A log with a column times a factor, beside a model."""
    return lambda folder: (folder / "m.toml").write_text(MODEL) and csv_bytes(changed(name, factor * COLUMNS[name]))


UNITS = {
    "position in mm": (
        beside_a_model("position", 25e3),
        "spans .* m but the model's travel is 0.51 m: give --scale position=0.001 if it is in mm",
    ),
    "reference in mm": (
        beside_a_model("reference", 1e3),
        "reference: spans .* but the position .*: give --scale reference=0.001",
    ),
}
#: File name, content (bytes, or made from the folder), what the answer must say, and further arguments.
CASES = {
    **{case: ("a.csv", *log) for case, log in CSV.items()},
    **{options: ("a.csv", csv_bytes(changed("command", 100.0 + TIME)), m, options) for options, m in OPTIONS.items()},
    **{case: ("a.csv", *log, "--model m.toml") for case, log in UNITS.items()},
    **{f"MATLAB: {case}": ("a.mat", *log) for case, log in MATLAB.items()},
    **{f"MDF: {case}": ("a.mf4", *log) for case, log in MDF.items()},
    **{f"Parquet: {case}": ("a.parquet", *log) for case, log in PARQUET.items()},
}


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("case", CASES)
def test_a_malformed_log_is_answered_in_one_line(case, tmp_path, capsys, monkeypatch):
    name, content, message, *options = CASES[case]
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_bytes(content(tmp_path) if callable(content) else content)
    before = sorted(tmp_path.rglob("*"))
    assert main(["audit", name, "--json", "out.json", *" ".join(options).split()]) == 2
    error = capsys.readouterr().err
    assert re.fullmatch(f"cogging: .*{message}.*\n", error), error
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize("kind", FORMATS)
def test_a_mutated_log_is_read_or_refused_in_one_line(kind):
    """The first cases of `python -m tests.attack`, read as a user reads them."""
    found = [run_case(seed, kind, whole=True) for seed in range(40 if kind == "csv" else 1)]
    assert not [one for one in found if one is not None and not one.startswith("~")]
