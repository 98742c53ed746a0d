"""The logs of a ball-screw axis: read from files like the originals with drawn numbers."""

import sys
from types import ModuleType

import numpy as np
import pytest
from scipy.io import savemat

from cogging import InputError
from cogging.datasets import emps


def write(folder, seed):
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
    written = write(tmp_path / below, seed)
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
    written = write(kept, 1)
    replace_package(monkeypatch, lambda: [str(kept / f"{name}.mat") for name in emps.FILES])
    monkeypatch.delenv("COGGING_DATA", raising=False)
    assert emps.files() == {name: kept / f"{name}.mat" for name in emps.FILES}
    np.testing.assert_array_equal(emps.read().position, written["DATA_EMPS"]["qm"][:, 0])
    monkeypatch.setenv("COGGING_DATA", str(own))
    assert len(emps.pulses()) == len(written["DATA_EMPS_PULSES"]["qm"])
    write(own / "emps", 2)
    assert {path.parent for path in emps.files().values()} == {own / "emps"}  # the caller's own come first
    with pytest.raises(InputError, match="nowhere"):
        emps.files(tmp_path / "nowhere")  # who names a folder means it


def test_a_download_that_fails_is_one_line(tmp_path, monkeypatch):
    def fail():
        raise OSError("no network\nat all")

    replace_package(monkeypatch, fail)
    monkeypatch.delenv("COGGING_DATA", raising=False)
    with pytest.raises(InputError, match=r"public at nonlinearbenchmark\.org .*cite") as caught:
        emps.read()
    assert str(caught.value).isprintable()
    assert "nonlinear-benchmarks could not fetch it: OSError: no network" in str(caught.value)
    replace_package(monkeypatch, lambda: [str(tmp_path / f"{name}.mat") for name in emps.FILES])
    with pytest.raises(InputError, match=f"DATA_EMPS.mat: must be in {tmp_path}, is not; public at nonlin"):
        emps.read()
