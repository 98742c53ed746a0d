"""Files made to hurt: code beside a log and in it, logs that name other files, readers that outlive their parent."""

import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import venv
import warnings
from pathlib import Path

import numpy as np
import pytest

import cogging
import cogging_command
from cogging.cli.main import main
from cogging.files import InputError
from cogging.logs.columns import read_columns
from cogging.logs.readers import isolate
from tests.fixtures.covering import covering
from tests.fixtures.log_files import COLUMNS, TIME, hdf5_bytes, mat_bytes, mdf_bytes, parquet_bytes

FORMATS = {"a.mat": mat_bytes, "hdf5.mat": hdf5_bytes, "a.mf4": mdf_bytes, "a.parquet": parquet_bytes}
PLANTED = ("json", "types", "sys", "numpy", "cogging", "sitecustomize", "usercustomize", "scipy", "h5py", "asammdf")
PLANTED += ("pyarrow", "pandas", "numexpr", "sympy", "isal", "canmatrix", "tempfile", "ctypes", "resource", "site")


def made(name, folder):
    make = FORMATS[name]
    (folder / name).write_bytes(make(folder) if make is mdf_bytes else make())
    return folder / name


def plant(folder, mark):
    """What runs if it is ever imported, loaded or called from a folder."""
    for name in PLANTED:
        (folder / f"{name}.py").write_text(f"open({str(mark)!r}, 'a').write({name!r} + ' ')\n")
    for name in ("uname", "ldconfig", "gcc"):
        (folder / name).write_text(f"#!/bin/sh\necho {name} >> {mark}\n")
        (folder / name).chmod(0o755)


# --- code beside a log ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FORMATS)
def test_nothing_beside_a_log_is_executed(name, tmp_path, monkeypatch):
    mark, folder = tmp_path / "executed", tmp_path / "logs"
    folder.mkdir()
    made(name, folder)
    plant(folder, mark)
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "path", ["", ".", str(folder), "relative", *sys.path, "", str(folder)])
    for variable in ("PYTHONPATH", "PYTHONHOME", "PYTHONUSERBASE", "HDF5_PLUGIN_PATH"):
        monkeypatch.setenv(variable, str(folder))
    monkeypatch.setenv("PYTHONSTARTUP", str(folder / "json.py"))
    for variable in ("PATH", "LD_LIBRARY_PATH"):
        monkeypatch.setenv(variable, f":.:{os.environ.get(variable, '')}")
    log = cogging.read_log(name)
    np.testing.assert_array_equal(log.command, COLUMNS["command"])
    assert not mark.exists(), mark.read_text()


def test_the_command_runs_nothing_from_the_current_folder(tmp_path):
    mark, folder = tmp_path / "executed", tmp_path / "logs"
    folder.mkdir()
    made("a.mat", folder)
    plant(folder, mark)
    script = tmp_path / "cogging-command"
    script.write_text("import sys\nfrom cogging.cli.main import main\nsys.exit(main())\n")
    done = subprocess.run([sys.executable, script, "audit", "a.mat"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert not mark.exists(), mark.read_text()


@pytest.mark.parametrize("found_through", ["a .pth file", "the current folder"])
def test_cogging_is_found_where_its_parent_found_it(found_through, tmp_path):
    """An interpreter of its own, without any library, so that only what is handed on is found."""
    home, library = tmp_path / "home", tmp_path / "library"
    venv.create(home, symlinks=True)
    python = home / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    library.mkdir()
    for package in (cogging, cogging_command):
        (library / package.__name__).symlink_to(Path(package.__file__).parent)
    path = [str(Path(module.__file__).parents[1]) for module in (np, __import__("scipy"), __import__("tqdm"))]
    folder = library if found_through == "the current folder" else tmp_path
    made("a.mat", tmp_path)
    if found_through == "a .pth file":
        words = [python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]
        site = subprocess.run(words, capture_output=True, text=True).stdout.strip()
        Path(site, "cogging.pth").write_text("".join(f"{folder}\n" for folder in [library, *path]))
        path = []
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path)}
    code = f"import cogging; print(cogging.__file__, len(cogging.read_log({str(tmp_path / 'a.mat')!r})))"
    done = subprocess.run([python, "-c", code], cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [str(library / "cogging" / "__init__.py"), "200"]


# --- code in a log ----------------------------------------------------------------------------------------------------


def mdf_with(path, conversion, version="4.10", time_conversion=None, raw=None):
    """An MDF file whose `command` (raw counts) has a conversion."""
    pytest.importorskip("asammdf")
    from asammdf import MDF, Signal

    raw = np.arange(200, dtype=np.int16) if raw is None else raw
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with MDF(version=version) as mdf:
            signals = [Signal(raw, TIME, name="command", conversion=conversion)]
            mdf.append([*signals, Signal(COLUMNS["position"], TIME, name="position")])
            if time_conversion is not None:
                group = mdf.groups[0]
                group.channels[mdf.masters_db[0]].conversion = time_conversion
            return mdf.save(path, overwrite=True)  # which chooses the suffix


def conversion4(kind, **fields):
    pytest.importorskip("asammdf")
    from asammdf.blocks import v4_blocks, v4_constants

    return v4_blocks.ChannelConversion(conversion_type=getattr(v4_constants, f"CONVERSION_TYPE_{kind}"), **fields)


def conversion3(kind, **fields):
    pytest.importorskip("asammdf")
    from asammdf.blocks import v2_v3_blocks, v2_v3_constants

    return v2_v3_blocks.ChannelConversion(conversion_type=getattr(v2_v3_constants, f"CONVERSION_TYPE_{kind}"), **fields)


def values_to_texts(inner, place, kind="TABX"):
    """A table from values (or ranges) to texts, one of which is another conversion."""
    bounds = {"val_0": 300.0} if kind == "TABX" else {"lower_0": 300.0, "upper_0": 400.0}
    links = {"text_0": b"invalid", "default_addr": conversion4("LIN", a=2.0, b=0.0)} | {place: inner}
    return conversion4(kind, ref_param_nr=2, **bounds, **links)


RAW = np.random.default_rng(5).integers(500, 30000, 200).astype(np.int16)


def payload(mark, name):
    return f"__import__('os').system('touch {mark}')*0+{name}"


EXPLOITS = {
    "4.10": lambda mark: {"conversion": conversion4("ALG", formula=payload(mark, "X"))},
    "4.20, harmless": lambda mark: {"conversion": conversion4("ALG", formula="2*X+1"), "version": "4.20"},
    "3.30": lambda mark: {
        "conversion": conversion3("FORMULA", formula=payload(mark, "X1").encode()),
        "version": "3.30",
    },
    "of other values, 3.30": lambda mark: {
        "conversion": conversion3(
            "RTABX",
            ref_param_nr=2,
            lower_0=0.0,
            upper_0=100.0,
            text_0=b"low",
            default_addr=b'"2*{X}*{X}+1"',
        ),
        "version": "3.30",
        "raw": RAW,
    },
    "of a range": lambda mark: {
        "conversion": values_to_texts(conversion4("ALG", formula=payload(mark, "X")), "text_0", kind="RTABX")
    },
    "of a table in a table": lambda mark: {
        "conversion": values_to_texts(
            values_to_texts(conversion4("ALG", formula=payload(mark, "X")), "default_addr", kind="RTABX"), "text_0"
        )
    },
    "of the time": lambda mark: {"conversion": None, "time_conversion": conversion4("ALG", formula=payload(mark, "X"))},
}


@pytest.mark.parametrize("case", EXPLOITS)
def test_a_formula_in_a_log_is_refused_by_name_and_not_evaluated(case, tmp_path, capsys):
    mark = tmp_path / "RUN"  # asammdf writes every small x large
    assert "x" not in str(mark)
    path = mdf_with(tmp_path / "a.mf4", **EXPLOITS[case](mark))
    assert main(["audit", str(path), "--json", str(tmp_path / "o.json")]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert re.search(r"(command|time): must be converted without a formula, .* got ['\"]", said), said
    assert not mark.exists()
    assert sorted(tmp_path.iterdir()) == [path]


def test_a_formula_that_no_other_rule_refuses_is_not_evaluated(tmp_path):
    """The reader's last rule, tried in a process of its own as the reader is."""
    pytest.importorskip("asammdf")
    code = """
import numpy as np
from cogging.logs.readers.mdf import Formulas
formulas = Formulas()
from asammdf.blocks import v4_blocks as v4, v4_constants as c4, v2_v3_blocks as v3, v2_v3_constants as c3
X = np.arange(-5, 6, dtype=np.int16) * 6001
v4.ChannelConversion(conversion_type=c4.CONVERSION_TYPE_ALG, formula="X*2+print(7)").convert(X)
v3.ChannelConversion(conversion_type=c3.CONVERSION_TYPE_FORMULA, formula="X1*3").convert(X)
assert formulas.refused == ["X*2+print(7)", "X1*3"], formulas.refused
try:
    import sympy
except ImportError:
    print("blocked")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "blocked\n"


P = {"P1": 0.25, "P2": -2.0, "P3": 3.0, "P4": 1e-3, "P5": 0.5, "P6": 7.25}
KNOTS = np.array([-100.0, 10.0, 5000.0, 20000.0, 31000.0])
TABLE = {f"raw_{i}": knot for i, knot in enumerate(KNOTS)} | {f"phys_{i}": i**2 - 3.0 for i in range(5)}
RANGES = {
    "val_param_nr": 7,
    "default": 9.0,
    "lower_0": 0.0,
    "upper_0": 9999.0,
    "phys_0": 1.5,
    "lower_1": 10000.0,
    "upper_1": 20000.0,
    "phys_1": -2.5,
}


def rational(x):
    return (P["P1"] * x**2 + P["P2"] * x + P["P3"]) / (P["P4"] * x**2 + P["P5"] * x + P["P6"])


PHYSICAL = {
    "4.10": {
        "none": (lambda: None, lambda x: x),
        "linear": (lambda: conversion4("LIN", a=1e-3, b=-2.0), lambda x: 1e-3 * x - 2.0),
        "rational": (lambda: conversion4("RAT", **P), rational),
        "interpolated table": (
            lambda: conversion4("TABI", val_param_nr=10, **TABLE),
            lambda x: np.interp(x, KNOTS, np.arange(5) ** 2 - 3.0),
        ),
        "texts of other values": (lambda: values_to_texts(b"bad", "text_0", kind="RTABX"), lambda x: 2.0 * x),
    },
    "3.30": {
        "linear": (lambda: conversion3("LINEAR", a=1e-3, b=-2.0), lambda x: 1e-3 * x - 2.0),
        "rational": (lambda: conversion3("RAT", **P), rational),
    },
}


@pytest.mark.parametrize("version", PHYSICAL)
def test_conversions_give_physical_numbers(version, tmp_path):
    pytest.importorskip("asammdf")
    from asammdf import MDF, Signal

    cases = PHYSICAL[version]
    with MDF(version=version) as mdf:
        mdf.append([Signal(RAW, TIME, name=name, conversion=make()) for name, (make, _) in cases.items()])
        path = mdf.save(tmp_path / "a", overwrite=True)
    read = read_columns(path, list(cases), scale=dict.fromkeys(cases, 1.0))
    for name, (_, law) in cases.items():
        np.testing.assert_allclose(read[name], law(RAW.astype(float)), rtol=1e-12, err_msg=name)


def with_unknown_kind(content):
    at = content.rfind(b"##CC")
    links = int.from_bytes(content[at + 16 : at + 24], "little")
    place = at + 24 + 8 * links
    assert content[place] == 1, "a linear conversion"
    return content[:place] + bytes([77]) + content[place + 1 :]


RAW_COUNTS = {
    "a conversion that cannot be read": (
        lambda: conversion4("LIN", a=1e-3, b=0.0),
        lambda content: content.replace(b"##CC", b"##CX"),
        r"command: must have a whole conversion, got one that cannot be read",
    ),
    "a conversion beyond the end": (
        lambda: conversion4("LIN", a=1e-3, b=0.0),
        lambda content: (
            content[: content.rfind(b"##CC") + 8]
            + (1 << 40).to_bytes(8, "little")
            + content[content.rfind(b"##CC") + 16 :]
        ),
        r"command: must have a whole conversion, got one that cannot be read",
    ),
    "a conversion of another kind": (
        lambda: conversion4("LIN", a=1e-3, b=0.0),
        with_unknown_kind,
        r"command: must have a (whole conversion|conversion of numbers to numbers that is read rightly), got ",
    ),
    "ranges of whole numbers": (  # which asammdf 8.8 takes for their neighbours
        lambda: conversion4("RTAB", **RANGES),
        lambda content: content,
        r"command: must have a conversion of numbers to numbers that is read rightly, got number 6 of MDF 4",
    ),
    "some values to texts": (
        lambda: conversion4(
            "TABX", ref_param_nr=2, val_0=7.0, text_0=b"invalid", default_addr=conversion4("LIN", a=2.0, b=0.0)
        ),
        lambda content: content,
        r"row 7: command: must be a finite number, got nan",
    ),
}


@pytest.mark.parametrize("case", RAW_COUNTS)
def test_raw_counts_never_pass_as_volts(case, tmp_path):
    conversion, change, message = RAW_COUNTS[case]
    path = mdf_with(tmp_path / "a.mf4", conversion())
    path.write_bytes(change(path.read_bytes()))
    with pytest.raises(InputError, match=message):
        cogging.read_log(path)


def test_a_time_that_the_library_leaves_in_counts(tmp_path):
    """asammdf applies no conversion but a linear one to the time of version 3."""
    path = mdf_with(tmp_path / "a.mdf", None, "3.30", time_conversion=conversion3("RAT", **P))
    with pytest.raises(InputError, match=r"time \(time\): must be converted linearly, got conversion 9"):
        cogging.read_log(path)


# --- logs that name other files ---------------------------------------------------------------------------------------


def hdf5_naming(path, secret, how):
    """An HDF5 log whose `command` is what `how` makes of another file."""
    import h5py

    with h5py.File(secret, "w") as other:
        other["command"] = COLUMNS["command"]
    with h5py.File(path, "w") as file:
        for name in ("time", "position"):
            file[name] = COLUMNS[name]
        how(file, secret)
    return path


def external_storage(file, secret):
    file.create_dataset("command", (200,), "f8", external=[(str(secret), 0, 1600)])


def external_link(file, secret):
    import h5py

    file["command"] = h5py.ExternalLink(str(secret), "/command")


def soft_link_through_an_external_one(file, secret):
    import h5py

    file["aside"] = h5py.ExternalLink(str(secret), "/")
    file["command"] = h5py.SoftLink("/aside/command")


def virtual(file, secret):
    import h5py

    layout = h5py.VirtualLayout(shape=(200,), dtype="f8")
    layout[:] = h5py.VirtualSource(str(secret), "command", shape=(200,))
    file.create_virtual_dataset("command", layout)


def virtual_of_external_storage(file, secret):
    import h5py

    inner = file.create_dataset("inner", (200,), "f8", external=[(str(secret), 0, 1600)])
    layout = h5py.VirtualLayout(shape=(200,), dtype="f8")
    layout[:] = h5py.VirtualSource(inner)
    file.create_virtual_dataset("command", layout)


ELSEWHERE = [
    (external_storage, "external storage in"),
    (external_link, "a link to"),
    (soft_link_through_an_external_one, "a link to"),
    (virtual, "a virtual dataset of"),
    (virtual_of_external_storage, "external storage in"),
]


@pytest.mark.parametrize(("case", "kind"), covering(range(len(ELSEWHERE)), ["file", "pipe"]))
def test_numbers_of_another_file_are_refused_by_name(case, kind, tmp_path):
    how, what = ELSEWHERE[case]
    secret = tmp_path / "secret.h5"
    path = hdf5_naming(tmp_path / "a.mat", secret, how)
    if kind == "pipe":  # whose opening would wait for ever
        secret.unlink()
        os.mkfifo(secret)
    got = f"{what} '{re.escape(str(secret))}'"
    with pytest.raises(InputError, match=f"command: must be numbers in this file, got {got}"):
        cogging.read_log(path)


def test_links_within_a_file(tmp_path):
    import h5py

    with h5py.File(tmp_path / "a.mat", "w") as file:
        group = file.create_group("runs/last")
        for name in ("time", "position", "command"):
            group[name] = COLUMNS[name]
        file["newest"] = h5py.SoftLink("runs/./last")
        group["position again"] = h5py.SoftLink("position")
        layout = h5py.VirtualLayout(shape=(200,), dtype="f8")
        layout[:] = h5py.VirtualSource(group["command"])
        file.create_virtual_dataset("copy", layout)
        file["round"] = h5py.SoftLink("/about")
        file["about"] = h5py.SoftLink("/round")
    columns = {"time": "newest.time", "position": "newest.position again", "command": "copy"}
    log = cogging.read_log(tmp_path / "a.mat", columns=columns)
    for name in columns:
        np.testing.assert_array_equal(getattr(log, name), COLUMNS[name])
    with pytest.raises(InputError, match="round: must be a dataset, got more than 32 links on the way to it"):
        cogging.read_log(tmp_path / "a.mat", columns={**columns, "command": "round"})
    with pytest.raises(InputError, match=r"column newest.torque: must be in the file, which has .*runs.last.time"):
        cogging.read_log(tmp_path / "a.mat", columns={**columns, "command": "newest.torque"})


# --- readers and their parent -----------------------------------------------------------------------------------------

SLOW = (
    "import cogging.logs.readers.isolate as isolate; "
    "isolate.FORMATS = dict.fromkeys(isolate.FORMATS, ('file', 'matlab', lambda r: exec({!r}))); "
)
PARENT = """
import signal, sys, cogging
signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # as the command does
from cogging.logs.readers import isolate
isolate.START = {start!r} + isolate.START
cogging.read_log({log!r})
"""


def alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    state = Path(f"/proc/{pid}/stat")
    return not state.exists() or state.read_text().rpartition(")")[2].split()[0] != "Z"


def waits(condition, seconds=20.0):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize(
    ("how", "busy"), covering(["SIGKILL", "SIGTERM", "SIGINT"], ["while True: pass", "import time; time.sleep(600)"])
)
def test_a_reader_ends_with_its_parent(how, busy, tmp_path):
    name = "a.mat" if how == "SIGKILL" else "a.mf4"  # whose reader has a folder for temporary files
    path = made(name, tmp_path)
    temporary, told = tmp_path / "temporary", tmp_path / "pid"
    temporary.mkdir()
    tell = f"import os, pathlib; p = pathlib.Path({str(told)!r}); q = p.with_suffix('.new'); "
    tell += "q.write_text(str(os.getpid())); q.rename(p)\n"
    code = PARENT.format(start=SLOW.format(tell + busy), log=str(path))
    environment = {**os.environ, "TMPDIR": str(temporary)}
    parent = subprocess.Popen([sys.executable, "-c", code], env=environment, stderr=subprocess.DEVNULL)
    try:
        assert waits(told.exists)
        reader = int(told.read_text())
        assert alive(reader)
        assert len(list(temporary.iterdir())) == (name == "a.mf4")
        parent.send_signal(getattr(signal, how))
        parent.wait(20)
        assert waits(lambda: not alive(reader), 5.0)
        assert not list(temporary.iterdir()), "nothing is left in the temporary folder"
    finally:
        parent.kill()
        parent.wait()
        if told.exists() and alive(int(told.read_text())):
            os.kill(int(told.read_text()), signal.SIGKILL)


def test_a_reader_ends_with_its_parent_where_the_system_does_not_end_it(tmp_path):
    """The second way, alone: the end of its standard input."""
    code = "import sys; sys.platform = 'other'\nfrom cogging.logs.readers.isolate import confine\n"
    code += "confine({'memory': 8 << 30, 'seconds': 60.0})\nprint('ready', flush=True)\n"
    code += "import time; time.sleep(600)"
    reader = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    try:
        assert reader.stdout.readline() == b"ready\n"
        assert reader.poll() is None
        reader.stdin.close()
        assert reader.wait(10) == 1
    finally:
        reader.kill()
        reader.wait()
        reader.stdout.close()


@pytest.mark.parametrize("name", ["a.mat", "a.mf4"])
def test_without_room_for_temporary_files_a_reader_needs_none_or_says_so(name, tmp_path):
    """A limit of no bytes a file is what a full disk is: every write to a file fails, whatever the folder."""
    pytest.importorskip("resource")
    path = made(name, tmp_path)
    code = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))\nimport sys\n"
    code += f"from cogging.cli.main import main; sys.exit(main(['audit', {str(path)!r}]))"
    done = subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True, cwd=tmp_path)
    if name == "a.mf4":  # whose library wants a temporary file whatever it does
        assert done.returncode == 2
        assert done.stderr.count("\n") == 1
        assert re.search(r"a\.mf4: cannot be read: no room for temporary files", done.stderr), done.stderr
        assert "whole" not in done.stderr
    else:
        assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("cut", [None, 3000])
def test_no_temporary_file_is_left(cut, tmp_path, monkeypatch):
    """asammdf makes one for each file that it opens; cut files are closed by nobody."""
    path, temporary = made("a.mf4", tmp_path), tmp_path / "temporary"
    temporary.mkdir()
    path.write_bytes(path.read_bytes()[:cut])
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    monkeypatch.setattr(isolate, "START", "import tempfile; tempfile.mkstemp(dir=job['temporary']); " + isolate.START)
    try:
        cogging.read_log(path)
        assert cut is None
    except InputError:
        assert cut is not None
    assert not list(temporary.iterdir())


def test_a_temporary_folder_that_is_not_there(tmp_path, monkeypatch):
    path = made("a.mat", tmp_path)
    monkeypatch.setenv("TMPDIR", str(tmp_path / "missing"))
    np.testing.assert_array_equal(cogging.read_log(path).position, COLUMNS["position"])


def test_what_a_library_prints_is_no_answer(tmp_path, monkeypatch):
    path = made("a.mat", tmp_path)
    monkeypatch.setattr(isolate, "START", 'print(\'{"error": "no"}\', flush=True); ' + isolate.START)
    np.testing.assert_array_equal(cogging.read_log(path).position, COLUMNS["position"])
