"""A log that is made in memory is held to the rules of one that is read: one line that names column, row and value."""

import copy
import dataclasses
import decimal
import pickle

import numpy as np
import pytest

import cogging
from cogging import Log
from cogging.identification.identification import identify

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
NAMES = list(COLUMNS)


def with_entry(name, row, value):
    column = COLUMNS[name].copy()
    column[row] = value
    return {**COLUMNS, name: column}


def test_rows_of_a_log_are_a_log():
    log = Log(**COLUMNS, estimates=np.outer(TIME, [1.0, 2.0]), metadata={"seed": 1})
    for part in (log[100:200], log[(log.time > 0.0995) & (log.time < 0.1995)], log.between(0.1, 0.2)):
        assert (len(part), part.time[0], part.metadata) == (100, TIME[100], {"seed": 1})
        for name in NAMES:
            np.testing.assert_array_equal(getattr(part, name), COLUMNS[name][100:200])
        np.testing.assert_array_equal(part.estimates, log.estimates[100:200])
    assert log[100:200].position.base is not None  # no copy
    whole = cogging.performance(log.time, log.error, log.command, start=0.1, stop=0.2)
    assert cogging.performance(log, start=0.1, stop=0.2) == cogging.performance(log.between(0.1, 0.2)) == whole
    for rows, rule in (
        (slice(5, 5), "at least 1 row"),
        (slice(None, None, -1), "strictly increasing"),
    ):
        with pytest.raises(ValueError, match=f"time: must (have|be) {rule}"):
            log[rows]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("row", [0, 137, ROWS - 1])
def test_an_entry_that_is_not_finite(name, value, row):
    with pytest.raises(ValueError, match=rf"^row {row}: {name}: must be a finite number, got {value:g}$"):
        Log(**with_entry(name, row, value))


@pytest.mark.parametrize(("row", "before"), [(1, 0), (137, 136), (ROWS - 1, 3)])
def test_a_time_that_does_not_rise(row, before):
    with pytest.raises(ValueError, match=rf"^row {row}: time: must be strictly increasing, got .+ after .+$"):
        Log(**with_entry("time", row, TIME[before]))


def test_two_times_that_look_alike_are_told_apart():
    time = 1e9 + TIME
    time[7] = np.nextafter(time[6], 0.0)
    with pytest.raises(ValueError, match=r"row 7: time: .* got 1000000000\.00599\d+ after 1000000000\.006"):
        Log(**{**COLUMNS, "time": time})


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("shape", [(ROWS, 1), (1, ROWS), (20, 20), ()])
def test_a_shape_that_is_no_column(name, shape):
    value = np.float64(1.0) if shape == () else COLUMNS[name].reshape(shape)
    got = str(shape).replace("(", r"\(").replace(")", r"\)")
    with pytest.raises(ValueError, match=rf"^{name}: must have the shape \(rows,\), got {got}$"):
        Log(**{**COLUMNS, name: value})


@pytest.mark.parametrize("name", NAMES[1:])
@pytest.mark.parametrize("rows", [1, ROWS - 1, ROWS + 1])
def test_a_length_that_is_not_that_of_time(name, rows):
    with pytest.raises(ValueError, match=rf"^{name}: must be as long as time \({ROWS} rows\), got {rows}$"):
        Log(**{**COLUMNS, name: np.resize(COLUMNS[name], rows)})


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        (lambda column: column.astype(complex), "must be real numbers, got complex128"),
        (lambda column: column > 0.0, "must be real numbers, got bool"),
        (lambda column: column.astype(str), "must be real numbers, got <U"),
        (lambda column: column.astype("M8[s]"), r"must be real numbers, got datetime64\[s\]"),
        (lambda column: [*column.tolist()[:-1], None], "must be a real number, got None"),
        (lambda column: [decimal.Decimal(1)] * ROWS, r"must be a real number, got Decimal\('1'\)"),
        (lambda column: [[1.0], [1.0, 2.0]], "must be real numbers, got a list that is no array"),
        (lambda column: [], r"must have at least 1 row, got 0|must be as long as time"),
        (lambda column: [10**400] * ROWS, "must be a finite number, got inf"),
        (lambda column: column.astype(np.longdouble) + np.longdouble("1e4000"), "must be a finite number, got inf"),
    ],
)
@pytest.mark.parametrize("name", ["time", "position"])
def test_what_is_no_number(name, kind, said):
    with pytest.raises(ValueError, match=rf"^(row \d+: )?{name}: ({said})"):
        Log(**{**COLUMNS, name: kind(COLUMNS[name])})


@pytest.mark.parametrize("name", NAMES[:3])
def test_a_column_that_is_missing(name):
    with pytest.raises(ValueError, match=f"^{name}: must be real numbers, got none$"):
        Log(**{**COLUMNS, name: None})


@pytest.mark.parametrize("name", NAMES)
def test_a_mask_is_not_lost(name):
    masked = np.ma.masked_array(COLUMNS[name], np.arange(ROWS) == 211)
    with pytest.raises(ValueError, match=f"^row 211: {name}: must not be masked"):
        Log(**{**COLUMNS, name: masked})
    whole = Log(**{**COLUMNS, name: np.ma.masked_array(COLUMNS[name])})
    assert type(getattr(whole, name)) is np.ndarray
    np.testing.assert_array_equal(getattr(whole, name), COLUMNS[name])


@pytest.mark.parametrize(
    "kind",
    [
        list,
        tuple,
        lambda column: column.astype(">f8"),
        lambda column: np.repeat(column, 3)[::3],
        lambda column: column.astype(object),
        lambda column: memoryview(column),
    ],
)
def test_other_arrays_of_numbers_are_taken(kind):
    log = Log(**{name: kind(column) for name, column in COLUMNS.items()})
    for name, column in COLUMNS.items():
        assert getattr(log, name).dtype == np.dtype(float)
        np.testing.assert_array_equal(getattr(log, name), column)
    assert cogging.audit(log).rows == ROWS


def test_single_precision_and_integers_are_taken():
    counts = np.arange(ROWS)
    log = Log(counts, counts.astype(np.float32), counts.astype(np.uint16))
    for column in (log.time, log.position, log.command):
        assert column.dtype == np.dtype(float)
        np.testing.assert_array_equal(column, counts)


def test_series_are_taken():
    import pandas

    frame = pandas.DataFrame(COLUMNS, index=np.arange(ROWS)[::-1])
    log = Log(**{name: frame[name] for name in NAMES})
    np.testing.assert_array_equal(log.position, COLUMNS["position"])
    nullable = frame["position"].astype("Float64")
    assert len(Log(**{**COLUMNS, "position": nullable})) == ROWS
    nullable.iloc[5] = pandas.NA
    with pytest.raises(ValueError, match=r"row 5: position: must be a (real|finite) number, got"):
        Log(**{**COLUMNS, "position": nullable})


def test_columns_are_not_copied_and_cannot_be_written_through_the_log():
    own = {name: column.copy() for name, column in COLUMNS.items()}
    log = Log(**own)
    for name in NAMES:
        assert np.shares_memory(getattr(log, name), own[name])
        assert own[name].flags.writeable, "the caller's own array stays as it is"
        with pytest.raises(ValueError, match="read-only"):
            getattr(log, name)[3] = np.nan
    for other in (copy.deepcopy(log), pickle.loads(pickle.dumps(log)), dataclasses.replace(log)):
        np.testing.assert_array_equal(other.position, log.position)
    with pytest.raises(ValueError, match="position: must be as long as time"):
        dataclasses.replace(log, position=log.position[1:])


def test_what_only_a_simulation_has():
    log = Log(TIME, TIME, TIME, true_position=TIME, true_velocity=TIME, estimates=np.ones((ROWS, 3)))
    assert log.estimates.shape == (ROWS, 3)
    with pytest.raises(ValueError, match=r"estimates: must have the shape \(rows, estimates\), got \(400,\)"):
        Log(TIME, TIME, TIME, estimates=TIME)
    with pytest.raises(ValueError, match="row 2: estimates: must be a finite number, got nan"):
        Log(TIME, TIME, TIME, estimates=np.where(np.arange(3 * ROWS).reshape(ROWS, 3) == 7, np.nan, 1.0))
    with pytest.raises(ValueError, match="true_velocity: must be as long as time"):
        Log(TIME, TIME, TIME, true_velocity=TIME[:-1])


def test_nothing_is_concluded_from_such_a_log():
    """What was told as insufficient excitation, or as a traceback of something else."""
    model = cogging.Model(axis=cogging.AxisParameters(mass=1.0, viscous=1.0, coulomb=0.1, coulomb_width=1e-3))
    for judge in (cogging.audit, lambda log: identify(log, model), lambda log: cogging.diagnose(log, model)):
        with pytest.raises(ValueError, match="row 200: position: must be a finite number, got nan"):
            judge(Log(**with_entry("position", 200, np.nan)))
