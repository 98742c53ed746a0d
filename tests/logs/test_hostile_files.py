"""Hostile files: code beside a log and in it, logs that name other files or ask for much, readers and their parent."""

import importlib
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from cogging.files import InputError
from cogging.logs.readers import isolate
from tests.fixtures.log_files import COLUMNS, TIME, hdf5_bytes, mat_bytes, mdf_bytes, parquet_bytes

FORMATS = {"a.mat": mat_bytes, "hdf5.mat": hdf5_bytes, "a.mf4": mdf_bytes, "a.parquet": parquet_bytes}
PLANTED = ("json", "types", "sys", "numpy", "cogging", "sitecustomize", "usercustomize", "scipy", "h5py", "asammdf")
PLANTED += ("pyarrow", "pandas", "numexpr", "sympy", "isal", "canmatrix", "tempfile", "ctypes", "resource", "site")


def write_log(name, folder):
    make = FORMATS[name]
    (folder / name).write_bytes(make(folder) if make is mdf_bytes else make())
    return folder / name


# --- code beside a log ------------------------------------------------------------------------------------------------


@pytest.fixture
def planted(tmp_path):
    """A folder with a log of each format and code that leaves a mark when it is imported, loaded or called."""
    mark, folder = tmp_path / "executed", tmp_path / "logs"
    folder.mkdir()
    for name in FORMATS:
        write_log(name, folder)
    for name in PLANTED:
        (folder / f"{name}.py").write_text(f"open({str(mark)!r}, 'a').write({name!r} + ' ')\n")
    for name in ("uname", "ldconfig", "gcc"):
        (folder / name).write_text(f"#!/bin/sh\necho {name} >> {mark}\n")
        (folder / name).chmod(0o755)
    yield folder
    assert not mark.exists(), mark.read_text()


@pytest.mark.parametrize("name", FORMATS)
def test_nothing_beside_a_log_is_executed(name, planted, monkeypatch):
    folder = str(planted)
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "path", ["", ".", folder, "relative", *sys.path, "", folder])
    for variable in ("PYTHONPATH", "PYTHONHOME", "PYTHONUSERBASE", "HDF5_PLUGIN_PATH"):
        monkeypatch.setenv(variable, folder)
    monkeypatch.setenv("PYTHONSTARTUP", str(planted / "json.py"))
    for variable in ("PATH", "LD_LIBRARY_PATH"):
        monkeypatch.setenv(variable, f":.:{os.environ.get(variable, '')}")
    np.testing.assert_array_equal(cogging.read_log(name).command, COLUMNS["command"])


def test_the_command_runs_nothing_from_the_current_folder(planted, tmp_path):
    script = tmp_path / "cogging-command"
    script.write_text("import sys\nfrom cogging.cli.main import main\nsys.exit(main())\n")
    done = subprocess.run([sys.executable, script, "audit", "a.mat"], cwd=planted, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


# --- code in a log ----------------------------------------------------------------------------------------------------


def conversion(kind, version="4", **fields):
    pytest.importorskip("asammdf")
    name = {"4": "v4", "3": "v2_v3"}[version]
    blocks, constants = (importlib.import_module(f"asammdf.blocks.{name}_{part}") for part in ("blocks", "constants"))
    return blocks.ChannelConversion(conversion_type=getattr(constants, f"CONVERSION_TYPE_{kind}"), **fields)


def doubled():
    return conversion("LIN", a=2.0, b=0.0)


def range_to_text(default):
    """A table from a range of values to a text, and another conversion for all other values."""
    texts = {"text_0": b"invalid", "default_addr": default}
    return conversion("RTABX", ref_param_nr=2, lower_0=300.0, upper_0=400.0, **texts)


def write_mdf(path, conversion, version="4.10", time_conversion=None):
    """An MDF file whose `command` (raw counts) has a conversion."""
    pytest.importorskip("asammdf")
    from asammdf import MDF, Signal

    with MDF(version=version) as mdf:
        command = Signal(np.arange(200, dtype=np.int16), TIME, name="command", conversion=conversion)
        mdf.append([command, Signal(COLUMNS["position"], TIME, name="position")])
        if time_conversion is not None:
            mdf.groups[0].channels[mdf.masters_db[0]].conversion = time_conversion
        return mdf.save(path, overwrite=True)  # which chooses the suffix


def payload(mark, name):
    return f"__import__('os').system('touch {mark}')*0+{name}"


#: What is written into a log, of the file that marks an execution.
FORMULAS = {
    "3.30": lambda mark: (conversion("FORMULA", "3", formula=payload(mark, "X1").encode()), "3.30"),
    "of a table": lambda mark: (range_to_text(conversion("ALG", formula=payload(mark, "X"))),),
    "of the time": lambda mark: (None, "4.10", conversion("ALG", formula=payload(mark, "X"))),
}


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("case", FORMULAS)
def test_a_formula_in_a_log_is_refused_by_name_and_not_evaluated(case, tmp_path, capsys):
    mark = tmp_path / "RUN"  # asammdf writes every small x large
    path = write_mdf(tmp_path / "a.mf4", *FORMULAS[case](mark))
    assert main(["audit", str(path), "--json", str(tmp_path / "o.json")]) == 2
    assert re.search(r"(command|time): must be converted without a formula, .* got ['\"]", capsys.readouterr().err)
    assert sorted(tmp_path.iterdir()) == [path]


RAW = np.random.default_rng(5).integers(500, 30000, 200).astype(np.int16)
RATIONAL = {"P1": 0.25, "P2": -2.0, "P3": 3.0, "P4": 1e-3, "P5": 0.5, "P6": 7.25}


def quotient(x):
    return (0.25 * x**2 - 2.0 * x + 3.0) / (1e-3 * x**2 + 0.5 * x + 7.25)


#: Version, conversion and law of each channel.
PHYSICAL = {
    "linear": ("4.10", lambda: conversion("LIN", a=1e-3, b=-2.0), lambda x: 1e-3 * x - 2.0),
    "rational": ("4.10", lambda: conversion("RAT", **RATIONAL), quotient),
    "texts": ("4.10", lambda: range_to_text(doubled()), lambda x: 2.0 * x),
    "rational, version 3": ("3.30", lambda: conversion("RAT", "3", **RATIONAL), quotient),
}


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("version", ["4.10", "3.30"])
def test_asam_mdf_gives_physical_numbers(version, tmp_path):
    pytest.importorskip("asammdf")
    from asammdf import MDF, Signal

    from cogging.logs.columns import read_columns

    cases = {name: case for name, (of, *case) in PHYSICAL.items() if of == version}
    names = ["time", *cases]
    with MDF(version=version) as mdf:
        mdf.append([Signal(RAW, TIME, name=name, conversion=make()) for name, (make, _) in cases.items()])
        mdf.append([Signal(TIME[::5], TIME[::5], name="temperature", unit="K")])
        path = mdf.save(tmp_path / "a.dat", overwrite=True)
    read = read_columns(path, names, scale=dict.fromkeys(names, 1.0))
    np.testing.assert_allclose(read["time"], TIME, rtol=1e-12, atol=1e-15)
    for name, (_, law) in cases.items():
        np.testing.assert_allclose(read[name], law(RAW.astype(float)), rtol=1e-12, err_msg=name)


RANGES = {"val_param_nr": 7, "default": 9.0, "lower_0": 0.0, "upper_0": 9999.0, "phys_0": 1.5}
RANGES |= {"lower_1": 10000.0, "upper_1": 20000.0, "phys_1": -2.5}
#: Conversion and error.
RAW_COUNTS = {
    "ranges of whole numbers": (  # which asammdf 8.8 takes for their neighbours
        lambda: conversion("RTAB", **RANGES),
        r"command: must have a conversion of numbers to numbers that is read rightly, got number 6 of MDF 4",
    ),
    "some values to texts": (
        lambda: conversion("TABX", ref_param_nr=2, val_0=7.0, text_0=b"x", default_addr=doubled()),
        r"row 7: command: must be a finite number, got nan",
    ),
}


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("case", RAW_COUNTS)
def test_raw_counts_never_pass_as_volts(case, tmp_path):
    conversion, message = RAW_COUNTS[case]
    path = write_mdf(tmp_path / "a.mf4", conversion())
    with pytest.raises(InputError, match=message):
        cogging.read_log(path)


# --- logs that name other files ---------------------------------------------------------------------------------------


def external_storage(file, secret):
    file.create_dataset("command", (200,), "f8", external=[(str(secret), 0, 1600)])


def external_link(file, secret):
    file["aside"] = h5py.ExternalLink(str(secret), "/")
    file["command"] = h5py.SoftLink("/aside/command")


def virtual_of(file, *source, **options):
    layout = h5py.VirtualLayout(shape=(200,), dtype="f8")
    layout[:] = h5py.VirtualSource(*source, **options)
    file.create_virtual_dataset("command", layout)


def virtual(file, secret):
    virtual_of(file, str(secret), "command", shape=(200,))


def virtual_of_external_storage(file, secret):
    virtual_of(file, file.create_dataset("inner", (200,), "f8", external=[(str(secret), 0, 1600)]))


ELSEWHERE = [
    (external_storage, "external storage in"),
    (external_link, "a link to"),
    (virtual, "a virtual dataset of"),
    (virtual_of_external_storage, "external storage in"),
]


@pytest.mark.parametrize(("name_other_file", "what"), ELSEWHERE)
def test_numbers_of_another_file_are_refused_by_name(name_other_file, what, tmp_path):
    secret, path = tmp_path / "secret.h5", tmp_path / "a.mat"
    with h5py.File(secret, "w") as other:
        other["command"] = COLUMNS["command"]
    with h5py.File(path, "w") as file:
        for name in ("time", "position"):
            file[name] = COLUMNS[name]
        name_other_file(file, secret)
    if name_other_file in (external_link, virtual):  # a pipe, whose opening would wait for ever
        secret.unlink()
        os.mkfifo(secret)
    got = f"{what} '{re.escape(str(secret))}'"
    with pytest.raises(InputError, match=f"command: must be numbers in this file, got {got}"):
        cogging.read_log(path)


def test_links_within_a_file_are_followed(tmp_path):
    with h5py.File(tmp_path / "a.mat", "w") as file:
        for name in ("time", "position"):
            file[f"runs/last/{name}"] = COLUMNS[name]
        file["newest"] = h5py.SoftLink("runs/./last")
        virtual_of(file, file.create_dataset("inner", data=COLUMNS["command"]))
        file["round"] = h5py.SoftLink("/round")
    columns = {"time": "newest.time", "position": "newest.position"}
    log = cogging.read_log(tmp_path / "a.mat", columns=columns)
    for name in ("time", "position", "command"):
        np.testing.assert_array_equal(getattr(log, name), COLUMNS[name])
    with pytest.raises(InputError, match="round: must be a dataset, got more than 32 links on the way to it"):
        cogging.read_log(tmp_path / "a.mat", columns={**columns, "command": "round"})


# --- readers and their parent -----------------------------------------------------------------------------------------

#: Begins the program of a reader, which then runs this code in place of reading.
SUBSTITUTE = (
    "import cogging.logs.readers.isolate as isolate; "
    "isolate.FORMATS = dict.fromkeys(isolate.FORMATS, ('MATLAB file', 'matlab', lambda request: exec({!r}))); "
)
PARENT = """
import signal, sys, cogging
signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # as the command does
from cogging.logs.readers import isolate
isolate.START = {start!r} + isolate.START
cogging.read_log({log!r})
"""


def is_alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    state = Path(f"/proc/{pid}/stat")
    return not state.exists() or state.read_text().rpartition(")")[2].split()[0] != "Z"


def wait_for(condition, seconds=20.0):
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)
    return condition()


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize(
    ("how", "busy"), [("SIGKILL", "while True: pass"), ("SIGTERM", "import time; time.sleep(600)")]
)
def test_a_reader_ends_with_its_parent(how, busy, tmp_path):
    name = "a.mat" if how == "SIGKILL" else "a.mf4"  # whose reader has a folder for temporary files
    path = write_log(name, tmp_path)
    temporary, pid = tmp_path / "temporary", tmp_path / "pid"
    temporary.mkdir()
    report = f"import os, pathlib; p = pathlib.Path({str(pid)!r}); q = p.with_suffix('.new'); "
    report += "q.write_text(str(os.getpid())); q.rename(p)\n"
    parent = subprocess.Popen(
        [sys.executable, "-c", PARENT.format(start=SUBSTITUTE.format(report + busy), log=str(path))],
        env={**os.environ, "TMPDIR": str(temporary)},
        stderr=subprocess.DEVNULL,
    )
    try:
        assert wait_for(pid.exists)
        reader = int(pid.read_text())
        assert is_alive(reader)
        assert len(list(temporary.iterdir())) == (name == "a.mf4")
        parent.send_signal(getattr(signal, how))
        parent.wait(20)
        assert wait_for(lambda: not is_alive(reader), 5.0)
        assert not list(temporary.iterdir())
    finally:
        parent.kill()
        parent.wait()
        if pid.exists() and is_alive(int(pid.read_text())):
            os.kill(int(pid.read_text()), signal.SIGKILL)


#: What a reader does, and the error.
FAILURES = [
    ("import os; os.abort()", "ends its reader (signal 6)"),
    ("import time; time.sleep(60)", "is not read within 2 s"),
    ("bytearray(1 << 46)", "asks for more memory than there is"),
    ("raise RuntimeError('two\\nlines')", "got RuntimeError: two lines"),
    ("raise OSError(28, 'No space left')", "cannot be read: no room for temporary files: No space left"),
    ("raise ModuleNotFoundError('no', name='h5py')", "needs h5py to read a MATLAB file: pip install 'cogging[matlab]'"),
]


@pytest.mark.parametrize(("behaviour", "message"), FAILURES)
def test_a_reader_that_fails_is_one_error(behaviour, message, tmp_path, monkeypatch):
    path = write_log("a.mat", tmp_path)
    if "sleep" in behaviour:  # the others need their time to start, where the machine is busy
        monkeypatch.setattr(isolate, "SECONDS", 2.0)
    monkeypatch.setattr(isolate, "START", SUBSTITUTE.format(behaviour) + isolate.START)
    with pytest.raises(InputError) as caught:
        cogging.read_log(path)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


# --- small files that ask for much are refused by what they state, before they are read -------------------------------

ROWS = 863_000_000  # 6.9 GB a column


def test_a_small_file_that_states_much_is_refused_before_it_is_read(tmp_path, capsys):
    path = tmp_path / "a.mat"
    with h5py.File(path, "w") as file:
        for name in ("time", "position", "command"):
            file.create_dataset(name, shape=(ROWS,), dtype="f8", chunks=(1000,), compression="gzip")
    assert path.stat().st_size < 20_000
    assert main(["audit", str(path)]) == 2
    refused = capsys.readouterr().err
    rule = r"\w+: must ask for at most \d+ numbers in a file of \d+ bytes"
    assert re.fullmatch(rf"cogging: .*: {rule}, got {ROWS} rows, .* numbers\n", refused), refused


@pytest.mark.parametrize("name", ["a.mat", "a.mf4", "a.parquet"])
def test_the_reader_of_each_format_compares_what_a_file_states_with_its_size(name, tmp_path, monkeypatch):
    path = write_log(name, tmp_path)
    np.testing.assert_array_equal(cogging.read_log(path).position, COLUMNS["position"])
    little = "import cogging.logs.readers.column_request as limits; limits.SMALL, limits.EXPANSION = 1000, 0; "
    monkeypatch.setattr(isolate, "START", little + isolate.START)
    with pytest.raises(InputError, match=r"must ask for at most 125 numbers in a file of \d+ bytes, got 200 rows"):
        cogging.read_log(path)


@pytest.mark.skipif(os.name == "nt", reason="a file with holes takes its whole length there")
def test_a_text_of_more_rows_than_fit_is_refused_before_it_is_read(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("time,position,command\n" + "".join(f"{i},0.5,0.5\n" for i in range(40_000)))
    with open(path, "r+b") as file:
        file.truncate(10**12)
    with pytest.raises(InputError, match=r"a.csv: rows: must fit into memory: about .* rows of 3 columns take .* GB"):
        cogging.read_log(path)
    assert len(cogging.read_log(path, rows=slice(0, 1000))) == 1000
