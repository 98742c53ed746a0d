"""Runs as pandas frames, xarray Datasets and files: the same numbers, units, and reasons of failed runs."""

import csv
import re

import numpy as np
import pandas
import pytest
from pyarrow import parquet

import cogging
from cogging.simulation.reductions import INDEXES
from tests.fixtures.sweeps import MOVE, SMALL, read_table

ASKED = ["error_quantile(0.9)", "command_tone(5.0)", "true_error_max"]
UNITS = {"axis.mass": "V/(m/s^2)", "controller.kp": "V/m", "reference.frequency": "Hz", "error_rms": "m"}
UNITS |= {"command_chatter": "1", "error_quantile(0.9)": "m", "command_tone(5.0)": "V", "failed_at": "s"}


@pytest.fixture(scope="module")
def runs():
    """Of a sweep, every third of which breaks a rule, and every fourth of which diverges."""
    vary = {"axis.mass": [0.11, 0.13, -1.0], "controller.kp": [9600.0, 9000.0, 8000.0, 1e12]}
    vary |= {"encoder.noise": [1e-6], "reference.frequency": [4, 5]}
    return cogging.sweep(SMALL, MOVE, vary, reductions=ASKED)


@pytest.fixture(scope="module")
def batch():
    """Three runs, the second of which diverges, with rows of two columns."""
    plants = [cogging.Plant(SMALL.axis)] * 3
    pids = [cogging.Pid(SMALL.controller.replace(kp=kp)) for kp in (9600.0, 1e12, 9000.0)]
    sine = cogging.Sine(cogging.SineParameters(amplitude=0.01, frequency=5.0))
    return cogging.closed_loop_batch(
        plants, pids, sine, duration=0.3, columns=["command", "true_velocity"], every=3, reductions=ASKED
    )


def check_frame(frame, runs):
    """A frame has what the table has: numbers to their last bit, NaN and reasons where runs failed."""
    assert (frame.index.tolist(), frame.index.name) == (list(range(24)), "run")
    for path in runs.varied:
        assert frame[path].dtype == np.float64
        np.testing.assert_array_equal(frame[path], runs.table[path])
    assert frame["seed"].dtype.kind == "i"
    fails = (frame["axis.mass"] < 0) | (frame["controller.kp"] > 1e11)
    assert fails.sum() == 12
    for name in (*INDEXES, *ASKED):
        assert frame[name].dtype == np.float64
        assert frame[name].isna().tolist() == fails.tolist()
        np.testing.assert_array_equal(frame[name], runs.table[name])
    assert (frame["reason"] != "").tolist() == fails.tolist()
    assert frame["reason"][frame["axis.mass"] < 0].str.contains("mass: must be").all()
    diverged = fails & (frame["axis.mass"] > 0)
    assert frame["reason"][diverged].str.startswith("the run diverged at ").all()
    assert frame["failed_at"].notna().tolist() == diverged.tolist()


def test_a_sweep_in_every_form(runs, tmp_path):
    check_frame(runs.to_pandas(), runs)
    dataset = runs.to_xarray()
    assert dict(dataset.sizes) == {"run": 24}
    check_frame(dataset.to_dataframe(), runs)
    runs.write(tmp_path / "runs.csv")
    frame = read_table(tmp_path / "runs.csv")
    frame["reason"] = frame["reason"].fillna("")
    frame["reference.frequency"] = frame["reference.frequency"].astype(float)
    check_frame(frame, runs)
    runs.write(tmp_path / "runs.Parquet")
    frame = pandas.read_parquet(tmp_path / "runs.Parquet")
    check_frame(frame.set_index("run"), runs)
    # Units in each of them.
    given = {name: unit for name, unit in UNITS.items() if unit != "1"}
    for one in (frame, runs.to_pandas()):
        assert {name: one.attrs["units"].get(name) for name in given} == given
    assert {name: dataset[name].attrs.get("units") for name in UNITS} == UNITS
    schema = parquet.read_schema(tmp_path / "runs.Parquet")
    assert {name: schema.field(name).metadata[b"units"].decode() for name in UNITS} == UNITS
    assert [str(schema.field(name).type) for name in ("reason", "run")] == ["string", "int64"]


def test_the_summary_of_a_sweep(runs):
    drawn = {"axis.viscous": {"from": 0.1, "to": 0.3}, "controller.kp": {"from": 1e3, "to": 1e4}}
    found = cogging.sweep(SMALL, MOVE, drawn, method="sobol", runs=64)
    shares = found.influence()
    assert list(shares) == ["controller.kp", "axis.viscous"]
    groups = np.array_split(found.table["error_rms"].argsort().argsort()[found.table["controller.kp"].argsort()], 10)
    within = sum(((group - group.mean()) ** 2).sum() for group in groups) / (64 - 10)
    assert shares["controller.kp"] == pytest.approx(1.0 - within / np.arange(64).var(ddof=1), abs=0.05)
    assert "alone: controller.kp 9" in found.text()
    assert "24 runs over axis.mass, controller.kp, encoder.noise, reference.frequency, 12 failed\n" in runs.text()
    assert "\n  8 failed: mass: must be" in runs.text()


def test_a_batch_as_a_dataset(batch):
    dataset = batch.to_xarray()
    assert dict(dataset.sizes) == {"run": 3, "row": 101}
    for name, unit in (("command", "V"), ("true_velocity", "m/s")):
        assert (dataset[name].dims, dataset[name].attrs["units"]) == (("run", "row"), unit)
        np.testing.assert_array_equal(dataset[name][[0, 2]], [batch.columns[name][run] for run in (0, 2)])
        assert np.isnan(dataset[name][1]).all()
    assert dataset["reason"].values.tolist() == ["", batch.failures[0].reason, ""]
    assert dataset["failed_at"][1] == batch.failures[0].time


def test_no_cell_of_a_csv_is_a_formula(runs, tmp_path):
    """Spreadsheets run cells that begin with = + - @: each cell is a number, or begins with a letter."""
    runs.write(tmp_path / "runs.csv")
    cogging.simulate(SMALL, MOVE, seed=1).write(tmp_path / "log.csv")
    for path in (tmp_path / "runs.csv", tmp_path / "log.csv"):
        with open(path, encoding="utf-8", newline="") as file:
            cells = {cell for row in csv.reader(file) for cell in row if cell}
        texts = {cell for cell in cells if not re.fullmatch(r"[+-]?\d[\d.]*(e[+-]?\d+)?|inf", cell)}
        assert texts
        assert all(text[0].isalpha() for text in texts)
