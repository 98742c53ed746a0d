"""Small files that ask for much are refused by what they state, before they are read."""

import os
import re
import struct
import zlib

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from cogging.files import InputError
from tests.fixtures.log_files import COLUMNS, TIME, mat_bytes, mdf_bytes, parquet_bytes

ROWS = 863_000_000  # 6.9 GB a column


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
    refused = capsys.readouterr().err
    rule = r"\w+: must ask for at most \d+ numbers in a file of \d+ bytes"
    assert re.fullmatch(rf"cogging: .*: {rule}, got {ROWS} rows, .* numbers\n", refused), refused
    if "HDF5" not in name:  # whose numbers are not stored
        log = cogging.read_log(BOMBS[name](tmp_path, len(TIME)))
        np.testing.assert_array_equal(log.position, COLUMNS["position"])


@pytest.mark.skipif(os.name == "nt", reason="a file with holes takes its whole length there")
def test_a_text_of_more_rows_than_fit_is_refused_before_it_is_read(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("time,position,command\n" + "".join(f"{i},0.5,0.5\n" for i in range(40_000)))
    with open(path, "r+b") as file:
        file.truncate(10**12)
    with pytest.raises(InputError, match=r"a.csv: rows: must fit into memory: about .* rows of 3 columns take .* GB"):
        cogging.read_log(path)
    assert len(cogging.read_log(path, rows=slice(0, 1000))) == 1000
