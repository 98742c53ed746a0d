"""Small files that ask for much are refused by what they state, before they are read; limits as documented."""

import os
import re
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

import cogging
from cogging import files
from cogging.cli.main import main
from cogging.files import InputError
from cogging.logs.columns import read_columns
from cogging.logs.readers import column_request as requests
from cogging.logs.readers import isolate
from cogging.logs.readers.column_request import Request
from tests.fixtures.log_files import COLUMNS, TIME, hdf5_bytes, mat_bytes, mdf_bytes, parquet_bytes

ROWS = 863_000_000  # 6.9 GB a column
DOCUMENT = Path(__file__).parents[2] / "docs" / "reading_files.md"


def hdf5_of(folder, rows, **storage):
    import h5py

    with h5py.File(folder / "a.mat", "w") as file:
        for name in ("time", "position", "command"):
            file.create_dataset(name, shape=(rows,), dtype="f8", chunks=(1000,), **storage)
    return folder / "a.mat"


def mat_of(folder, rows):
    """A compressed file whose every variable states so many rows."""
    content = mat_bytes(compress=True)
    made, at = content[:128], 128
    while at < len(content):
        kind, size = struct.unpack("<II", content[at : at + 8])
        inner = bytearray(zlib.decompress(content[at + 8 : at + 8 + size]))
        assert struct.unpack("<II", inner[24:32]) == (5, 8)  # the dimensions, of two 32-bit numbers
        inner[32:36] = struct.pack("<i", rows)
        packed = zlib.compress(bytes(inner))
        made += struct.pack("<II", kind, len(packed)) + packed
        at += 8 + size
    (folder / "a.mat").write_bytes(made)
    return folder / "a.mat"


def mdf_of(folder, rows):
    """A file whose channel group states so many cycles."""
    content = bytearray(mdf_bytes(folder))
    at = content.index(b"##CG") + 24 + 6 * 8 + 8
    assert struct.unpack("<Q", content[at : at + 8]) == (len(TIME),)
    content[at : at + 8] = struct.pack("<Q", rows)
    (folder / "a.mf4").write_bytes(content)
    return folder / "a.mf4"


def varint(number):
    number *= 2  # zigzag
    made = bytearray()
    while number > 127:
        made.append(number & 127 | 128)
        number >>= 7
    return bytes([*made, number])


def parquet_of(folder, rows):
    """A file whose footer states so many rows."""
    content = parquet_bytes()
    (size,) = struct.unpack("<I", content[-8:-4])
    data, footer = content[: -8 - size], content[-8 - size : -8]
    stated = b"\x16" + varint(len(TIME)) + b"\x19"  # the third field, and the fourth begins
    assert footer.count(stated) == 1
    footer = footer.replace(stated, b"\x16" + varint(rows) + b"\x19")
    (folder / "a.parquet").write_bytes(data + footer + struct.pack("<I", len(footer)) + b"PAR1")
    return folder / "a.parquet"


BOMBS = {
    "HDF5": hdf5_of,
    "HDF5, packed": lambda folder, rows: hdf5_of(folder, rows, compression="gzip"),
    "MATLAB 5": mat_of,
    "MDF": mdf_of,
    "Parquet": parquet_of,
}


@pytest.mark.parametrize("name", BOMBS)
def test_a_small_file_that_asks_for_much_is_refused_by_what_it_states(name, tmp_path, capsys):
    path = BOMBS[name](tmp_path, ROWS)
    assert path.stat().st_size < 20_000
    assert main(["audit", str(path)]) == 2
    told = capsys.readouterr().err
    most = requests.numbers_most(path.stat().st_size) // 8
    assert re.fullmatch(
        rf"cogging: .*: \w+: must ask for at most {most} numbers in a file of \d+ bytes, got {ROWS} rows, .* numbers\n",
        told,
    ), told


@pytest.mark.parametrize("name", ["MATLAB 5", "MDF", "Parquet"])
def test_the_same_file_that_states_what_it_has_is_read(name, tmp_path):
    log = cogging.read_log(BOMBS[name](tmp_path, len(TIME)))
    np.testing.assert_array_equal(log.position, COLUMNS["position"])


def test_what_is_not_stored_is_read_where_it_is_little(tmp_path):
    path = hdf5_of(tmp_path, 1000)
    assert not read_columns(path, ["position"])["position"].any()


def test_a_file_may_ask_for_as_much_as_its_size_allows(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(b"0" * 1000)
    most = (requests.SMALL + 1000 * requests.EXPANSION) // 8
    request = Request(path, ("position",))
    request.require_room("position", most, float(most))
    with pytest.raises(InputError, match=rf"a: position: must ask for at most {most} numbers in a file of 1000 bytes"):
        request.require_room("position", most + 1, most + 1.0)


@pytest.mark.parametrize("size", [0, 10**6, 10**12])
def test_a_reading_process_gets_no_more_than_is_left(size):
    assert isolate.memory_most(size, 1e8) == isolate.ADDRESSES + 10**8
    assert isolate.memory_most(size, np.inf) == isolate.LIBRARIES + isolate.COPIES * requests.numbers_most(size)


@pytest.mark.parametrize(
    ("columns", "taken"), [(requests.COLUMNS, True), (requests.COLUMNS + 1, False), (100_000, False)]
)
def test_a_header_of_many_columns(columns, taken, tmp_path):
    names = ["time", "position", "command", *"x" * (columns - 3)]
    path = tmp_path / "a.csv"
    path.write_text("\n".join(",".join(row) for row in (names, ["0"] * columns, ["1"] * columns)) + "\n")
    if taken:
        assert len(cogging.read_log(path)) == 2
    else:
        with pytest.raises(InputError, match=f"header: must have at most {requests.COLUMNS} columns, got {columns}$"):
            cogging.read_log(path)


@pytest.mark.skipif(os.name == "nt", reason="a file with holes takes its whole length there")
def test_a_text_of_more_rows_than_fit_is_refused_before_it_is_read(tmp_path):
    path = tmp_path / "a.csv"
    rows = "".join(f"{i},0.5,0.5\n" for i in range(40_000))
    path.write_text("time,position,command\n" + rows)
    assert len(cogging.read_log(path)) == 40_000
    with open(path, "r+b") as file:
        file.truncate(10**12)
    with pytest.raises(InputError, match=r"a.csv: rows: must fit into memory: about .* rows of 3 columns take .* GB"):
        cogging.read_log(path)
    assert len(cogging.read_log(path, rows=slice(0, 1000))) == 1000


@pytest.mark.parametrize("text", ["[{}]\n", "{} = 0\n", 'x = [{}"" ]\n'])
def test_keys_tables_and_lists_are_counted_before_they_are_made(text, tmp_path, monkeypatch):
    path = tmp_path / "a.toml"
    monkeypatch.setattr(files, "MOST_MARKS", 100)
    lists = text.startswith("x")
    marks = 98 if lists else 100  # beside that of the list itself and its key
    for more in (0, 1):
        count = marks + more
        made = text.format("[]," * count) if lists else "".join(text.format(f"a{i}") for i in range(count))
        path.write_text(made)
        if not more:
            assert files.read_toml(path)
            continue
        with pytest.raises(InputError, match=r"a.toml: must be TOML: keys, tables and lists must be at most 100"):
            files.read_toml(path)


@pytest.mark.parametrize("kind", ["a.mat", "hdf5.mat", "a.parquet", "a.csv"])
def test_truth_values_in_a_column_are_no_numbers(kind, tmp_path):
    name, values = "command", COLUMNS["command"] > 0.0
    columns = {**COLUMNS, name: values}
    path = tmp_path / kind
    if kind == "a.csv":
        rows = zip(*(column.tolist() for column in columns.values()), strict=True)
        path.write_text(",".join(columns) + "\n" + "".join(",".join(map(str, row)).lower() + "\n" for row in rows))
    else:
        path.write_bytes({"a.mat": mat_bytes, "hdf5.mat": hdf5_bytes, "a.parquet": parquet_bytes}[kind](columns))
    with pytest.raises(
        InputError, match=rf"{name}: must be (real numbers, got (truth values|bool)|a finite number, got)"
    ):
        cogging.read_log(path)


@pytest.mark.parametrize("make", [mat_bytes, hdf5_bytes, parquet_bytes])
def test_whole_numbers_in_a_column_are_numbers(make, tmp_path):
    path = tmp_path / ("a.parquet" if make is parquet_bytes else "a.mat")
    path.write_bytes(make({**COLUMNS, "command": np.arange(len(TIME), dtype=np.int16)}))
    np.testing.assert_array_equal(cogging.read_log(path).command, np.arange(200.0))


def test_logical_values_of_matlab_are_no_numbers(tmp_path):
    path = tmp_path / "a.mat"
    columns = {**COLUMNS, "command": (COLUMNS["command"] > 0.0).astype(np.uint8)}
    path.write_bytes(hdf5_bytes(columns, [("command", "uint8")]))
    assert set(cogging.read_log(path).command) == {0.0, 1.0}
    path.write_bytes(hdf5_bytes(columns, [("command", "logical")]))
    with pytest.raises(InputError, match="command: must be real numbers, got logical"):
        cogging.read_log(path)


def test_logical_values_in_a_struct_are_no_numbers(tmp_path):
    path = tmp_path / "a.mat"
    path.write_bytes(mat_bytes({"log": {**COLUMNS, "command": np.arange(len(TIME), dtype=np.uint8)}}))
    named = {name: f"log.{name}" for name in ("time", "position", "command")}
    assert cogging.read_log(path, columns=named).command[-1] == 199.0
    path.write_bytes(mat_bytes({"log": {**COLUMNS, "command": COLUMNS["command"] > 0.0}}))
    with pytest.raises(InputError, match="command: must be real numbers, got truth values"):
        cogging.read_log(path, columns=named)


@pytest.mark.parametrize("header", ["x" + " " * 200_000 + "[", "x [" + " " * 200_000 + "m", "[" * 200_000])
def test_a_header_of_blanks_without_end_is_answered(header, tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(f"time,{header}\n0,1\n1,2\n")
    with pytest.raises(InputError) as told:
        cogging.read_log(path)
    assert len(str(told.value)) < 4000


def test_a_unit_without_end_is_shortened(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(f"time [{'x' * 5000}],position,command\n0,1,2\n1,2,3\n")
    with pytest.raises(
        InputError, match=r"column time.*: must be in s, got the unit 'x+ \.\.\. x+'; give --scale time=FACTOR"
    ) as told:
        cogging.read_log(path)
    assert len(str(told.value)) < 1000


@pytest.mark.parametrize("name", ["time\n", "ti\x1bme", "t\u202eime", "t\r\nx", "\x00\x01\n\x02"])
def test_an_error_is_one_line_whatever_names_a_file_holds(name, tmp_path):
    import h5py

    path = tmp_path / "log.mat"
    with h5py.File(path, "w") as file:
        for column in (name.replace("\x00", "0"), "position", "command"):
            file[column] = np.arange(9.0)
    with pytest.raises(InputError, match="column time") as told:
        cogging.read_log(path)
    assert str(told.value).isprintable()
