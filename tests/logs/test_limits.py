"""Small files that ask for much are refused by what they state, before they are read."""

import os
import re

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from cogging.files import InputError
from cogging.logs.readers import isolate
from tests.fixtures.log_files import COLUMNS, mat_bytes, mdf_bytes, parquet_bytes

ROWS = 863_000_000  # 6.9 GB a column


def test_a_small_file_that_states_much_is_refused_before_it_is_read(tmp_path, capsys):
    import h5py

    path = tmp_path / "a.mat"
    with h5py.File(path, "w") as file:
        for name in ("time", "position", "command"):
            file.create_dataset(name, shape=(ROWS,), dtype="f8", chunks=(1000,), compression="gzip")
    assert path.stat().st_size < 20_000
    assert main(["audit", str(path)]) == 2
    refused = capsys.readouterr().err
    rule = r"\w+: must ask for at most \d+ numbers in a file of \d+ bytes"
    assert re.fullmatch(rf"cogging: .*: {rule}, got {ROWS} rows, .* numbers\n", refused), refused


@pytest.mark.parametrize(("name", "make"), [("a.mat", mat_bytes), ("a.mf4", mdf_bytes), ("a.parquet", parquet_bytes)])
def test_the_reader_of_each_format_compares_what_a_file_states_with_its_size(name, make, tmp_path, monkeypatch):
    (tmp_path / name).write_bytes(make(tmp_path) if make is mdf_bytes else make())
    np.testing.assert_array_equal(cogging.read_log(tmp_path / name).position, COLUMNS["position"])
    little = "import cogging.logs.readers.column_request as limits; limits.SMALL, limits.EXPANSION = 1000, 0; "
    monkeypatch.setattr(isolate, "START", little + isolate.START)
    with pytest.raises(InputError, match=r"must ask for at most 125 numbers in a file of \d+ bytes, got 200 rows"):
        cogging.read_log(tmp_path / name)


@pytest.mark.skipif(os.name == "nt", reason="a file with holes takes its whole length there")
def test_a_text_of_more_rows_than_fit_is_refused_before_it_is_read(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("time,position,command\n" + "".join(f"{i},0.5,0.5\n" for i in range(40_000)))
    with open(path, "r+b") as file:
        file.truncate(10**12)
    with pytest.raises(InputError, match=r"a.csv: rows: must fit into memory: about .* rows of 3 columns take .* GB"):
        cogging.read_log(path)
    assert len(cogging.read_log(path, rows=slice(0, 1000))) == 1000
