"""A log made in memory obeys the rules of one from a file: one line that names column, row and value."""

import copy
import dataclasses
import pickle
import re

import numpy as np
import pandas
import pytest

import cogging
from cogging import Log

ROWS = 400
TIME = np.arange(ROWS) * 1e-3
COLUMNS = {
    "time": TIME,
    "position": 0.1 * np.sin(5.0 * TIME),
    "command": np.cos(5.0 * TIME),
    "reference": 0.1 * np.sin(5.0 * TIME),
    "reference_velocity": 0.5 * np.cos(5.0 * TIME),
    "reference_acceleration": -2.5 * np.sin(5.0 * TIME),
}


def test_rows_of_a_log_are_a_log():
    log = Log(**COLUMNS, estimates=np.outer(TIME, [1.0, 2.0]), metadata={"seed": 1})
    for part in (log[100:200], log[(log.time > 0.0995) & (log.time < 0.1995)], log.between(0.1, 0.2)):
        assert (len(part), part.metadata) == (100, {"seed": 1})
        for name in (*COLUMNS, "estimates"):
            np.testing.assert_array_equal(getattr(part, name), getattr(log, name)[100:200])
    whole = cogging.performance(log.time, log.error, log.command, start=0.1, stop=0.2)
    assert cogging.performance(log, start=0.1, stop=0.2) == cogging.performance(log.between(0.1, 0.2)) == whole
    with pytest.raises(ValueError, match="time: must have at least 1 row"):
        log[5:5]


#: Replacement of a column, row that the error names, message.
REFUSED = {
    "nan": (lambda column: np.where(TIME == 0.0, np.nan, column), 0, "must be a finite number, got nan"),
    "masked": (lambda column: np.ma.masked_array(column, np.arange(ROWS) == 211), 211, "must not be masked"),
    "a table": (lambda column: column.reshape(20, 20), None, r"must have the shape \(rows,\), got \(20, 20\)"),
    "nothing": (lambda column: [], None, "must (have at least 1 row, got 0|be as long as time)"),
    "complex": (lambda column: column.astype(complex), None, "must be real numbers, got complex128"),
    "truth values": (lambda column: column > 0.0, None, "must be real numbers, got bool"),
    "text": (lambda column: column.astype(str), None, "must be real numbers, got <U"),
    "ragged": (lambda column: [[1.0], [1.0, 2.0]], None, "must be real numbers, got a list that is no array"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_invalid_columns_are_refused_by_name_row_and_value(case):
    replace, row, message = REFUSED[case]
    for name, column in COLUMNS.items():
        with pytest.raises(ValueError, match=rf"^{'' if row is None else f'row {row}: '}{name}: {message}"):
            Log(**{**COLUMNS, name: replace(column)})


def test_columns_that_are_missing_or_not_as_long_as_time_are_refused():
    for name, column in list(COLUMNS.items())[1:]:
        for rows in (1, ROWS - 1, ROWS + 1):
            with pytest.raises(ValueError, match=rf"^{name}: must be as long as time \({ROWS} rows\), got {rows}$"):
                Log(**{**COLUMNS, name: np.resize(column, rows)})
    for name in ("time", "position", "command"):
        with pytest.raises(ValueError, match=f"^{name}: must be real numbers, got none$"):
            Log(**{**COLUMNS, name: None})


@pytest.mark.parametrize(
    ("start", "row", "later", "values"),
    [(0.0, 1, 0.0, "0 after 0"), (0.0, ROWS - 1, 3e-3, r"0\.003 after 0\.398"), (1e9, 7, 6e-3, r"\S+ after \S+006")],
)
def test_a_time_that_does_not_rise_is_refused_with_all_its_digits(start, row, later, values):
    time = start + TIME
    time[row] = np.nextafter(start + later, 0.0) if start else later
    with pytest.raises(ValueError, match=rf"^row {row}: time: must be strictly increasing, got {values}") as refused:
        Log(**{**COLUMNS, "time": time})
    one, other = re.search(r"got (\S+) after ([\d.]+)", str(refused.value)).groups()
    assert float(one) == time[row]
    assert float(other) == time[row - 1]


ARRAYS = {
    "big endian": lambda column: column.astype(">f8"),
    "series": lambda column: pandas.Series(column, index=np.arange(ROWS)[::-1]).astype("Float64"),
    "single precision": lambda column: np.round(column, 3).astype(np.float32),
    "integers": lambda column: (1e6 * column).astype(np.int32),
}


@pytest.mark.parametrize("kind", ARRAYS)
def test_other_arrays_of_numbers_become_columns(kind):
    log = Log(**{name: ARRAYS[kind](column) for name, column in COLUMNS.items()})
    for name, column in COLUMNS.items():
        assert type(getattr(log, name)) is np.ndarray
        assert getattr(log, name).dtype == np.dtype(float)
        np.testing.assert_array_equal(getattr(log, name), np.asarray(ARRAYS[kind](column), dtype=float))


def test_columns_are_not_copied_and_cannot_be_written_through_the_log():
    own = {name: column.copy() for name, column in COLUMNS.items()}
    log = Log(**own)
    for name, column in own.items():
        assert np.shares_memory(getattr(log, name), column)
        assert np.shares_memory(getattr(log[100:200], name), column)
        assert column.flags.writeable
        with pytest.raises(ValueError, match="read-only"):
            getattr(log, name)[3] = np.nan
    for other in (copy.deepcopy(log), pickle.loads(pickle.dumps(log)), dataclasses.replace(log)):
        np.testing.assert_array_equal(other.position, log.position)
        with pytest.raises(ValueError, match="read-only"):
            other.position[0] = 1.0
    with pytest.raises(ValueError, match="position: must be as long as time"):
        dataclasses.replace(log, position=log.position[1:])
