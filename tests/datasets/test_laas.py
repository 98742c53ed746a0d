"""The logs of a motor that cogs: files as theirs with drawn numbers, and theirs."""

import numpy as np
import pytest

from cogging import InputError
from cogging.datasets import laas
from cogging.datasets.laas import RotaryLog
from tests.fixtures.measured import FOLDER

HEADERS = {
    "stopped_data": "Time, Position, Velocity, Iq, Uq, Vsupply, Error Position",
    "acc_current": "Time, Position, Velocity, Iq, Uq, Vsupply",
    "speed_test1": "Time, Position, Velocity, Reference Velocity, Iq, Function Activated",
}
CLONE = {
    "stopped_data": "codes/Stopped/stopped_data",
    "acc_current": "codes/acceleration_data",
    "speed_test1": "codes/Get_Data",
}


def write(path, name, seed):
    """A file with the header of theirs and drawn rows: the table by column."""
    rng = np.random.default_rng(seed)
    columns = HEADERS[name].split(", ")
    table = rng.normal(size=(int(rng.integers(2, 60)), len(columns))).round(5)
    table[:, 0] = np.cumsum(rng.uniform(2e-4, 9e-3, len(table))).round(5)
    if name == "speed_test1":
        table[:, -1] = rng.integers(0, 2, len(table))
        table[0, -1] = 1
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([HEADERS[name], *(", ".join(map(str, row)) for row in table)]) + "\n")
    return dict(zip(columns, table.T, strict=True))


@pytest.mark.parametrize(("where", "seed"), [("flat", 0), ("named", 1), ("clone", 2)])
def test_columns_and_rows_without_the_compensation(tmp_path, seed, where):
    for name in laas.FILES:
        below = {"flat": ".", "named": "laas", "clone": CLONE[name]}[where]
        table = write(tmp_path / below / f"{name}.txt", name, seed)
        on = table.get("Function Activated", np.zeros(len(table["Time"]))) == 1
        wanted = {"off": (laas.read(name, tmp_path), ~on)}
        if on.any():
            wanted["on"] = (laas.read(name, tmp_path, compensated=True), on)
        for rows, kept in wanted.values():
            for column, theirs in {"time": "Time", "position": "Position", "velocity": "Velocity"}.items():
                np.testing.assert_array_equal(getattr(rows, column), table[theirs][kept])
            np.testing.assert_array_equal(rows.current, table["Iq"][kept])
    assert len(laas.files(tmp_path)) == 3
    with pytest.raises(ValueError, match="compensated: must be False for acc_current"):
        laas.read("acc_current", tmp_path, compensated=True)


def test_a_broken_file_is_named(tmp_path):
    (tmp_path / "acc_current.txt").write_text("Time, Position, Iq\n0, 1, 2\n")
    with pytest.raises(InputError, match=r"acc_current\.txt: column Velocity: must be"):
        laas.read("acc_current", tmp_path)


def test_a_part_of_a_log_and_the_log_of_an_axis():
    rng = np.random.default_rng(5)
    time = np.cumsum(rng.uniform(1e-4, 1e-2, 500))
    rows = RotaryLog(time, *rng.normal(size=(3, 500)))
    part = rows.between(time[100], time[300])
    assert len(part) == 200
    np.testing.assert_array_equal(part.current, rows.current[100:300])
    log = part.log()
    np.testing.assert_array_equal(log.command, part.current)
    np.testing.assert_array_equal(log.position, part.position)


@pytest.mark.data
@pytest.mark.parametrize("name", laas.FILES)
def test_theirs(name):
    table = np.genfromtxt(laas.files(FOLDER)[name], delimiter=",", names=True, autostrip=True)
    off = table["Function_Activated"] == 0 if name == "speed_test1" else np.full(len(table), True)
    rows = laas.read(name, FOLDER)
    assert np.all(np.diff(rows.time) > 0)
    for column, theirs in {"time": "Time", "position": "Position", "velocity": "Velocity", "current": "Iq"}.items():
        np.testing.assert_array_equal(getattr(rows, column), table[theirs][off])
    if name == "speed_test1":
        on = laas.read(name, FOLDER, compensated=True)
        assert len(on) + len(rows) == 30001
        assert on.velocity.std() < rows.velocity.std()  # it did compensate
