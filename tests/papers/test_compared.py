"""Panels of compared controllers share one scale and mark the printed value; tables count what comes near."""

import numpy as np
import pytest

from cogging.papers.compared import Trace, compared
from cogging.papers.result import Row, Table


def traces(seed, count):
    random = np.random.default_rng([20, seed])
    time = np.arange(int(random.integers(500, 20_000))) / random.choice([1000.0, 5000.0])
    sizes = 10.0 ** random.uniform(-9, -3, count)
    printed = [float(2.0 * size) if random.random() < 0.7 else None for size in sizes]
    values = [size * np.sin(2 * np.pi * random.uniform(1, 50) * time) for size in sizes]
    return [Trace(f"C{i}", time, y, p) for i, (y, p) in enumerate(zip(values, printed, strict=True))]


@pytest.mark.parametrize("seed", range(3))
def test_all_panels_have_one_scale_that_holds_trace_and_printed_value(seed):
    drawn = traces(seed, count=seed % 3 + 1)
    zoom = (0.1, 0.3) if seed % 2 else None
    figure = compared("title", drawn, zoom=zoom)
    columns = 2 if zoom else 1
    assert len(figure.axes) == columns * len(drawn)
    assert len({axes.get_ylim() for axes in figure.axes}) == 1
    low, high = figure.axes[0].get_ylim()
    assert low == -high
    # Every line: the trace in the unit of its label, then the printed value on both sides.
    unit = {"m": 1.0, "mm": 1e3, "µm": 1e6, "nm": 1e9}[figure.axes[0].get_ylabel().split("(")[1].rstrip(")")]
    for axes, trace in zip(figure.axes[::columns], drawn, strict=True):
        line, *marks = axes.lines
        assert np.nanmax(line.get_ydata()) == pytest.approx(unit * trace.values.max())
        expected = [] if trace.printed is None else [-unit * trace.printed, unit * trace.printed]
        assert [mark.get_ydata()[0] for mark in marks] == pytest.approx(expected)
        assert all(abs(mark.get_ydata()[0]) < high for mark in marks)
    if zoom:
        shown = figure.axes[1].lines[0].get_xdata()
        assert zoom[0] <= shown.min() < shown.max() <= zoom[1]


def test_a_limit_cuts_the_scale_as_a_paper_does():
    (trace,) = traces(0, 1)
    figure = compared("title", [trace, trace], limit=0.3 * trace.values.max())
    for axes in figure.axes:
        ends = axes.get_ylim()[1] / np.nanmax(axes.lines[0].get_ydata())
        assert ends == pytest.approx(0.3)


def counted(errors, statuses):
    pairs = zip(errors, statuses, strict=True)
    rows = [Row("C", f"e_{i}", "m", 1e-6, 1e-6 * (1.0 + error), status) for i, (error, status) in enumerate(pairs)]
    return Table("t", "T", [*rows, Row("C", "none", "m", None, 1.0, "exploratory")], free=["a", "b"])


@pytest.mark.parametrize("seed", range(3))
def test_counts_are_of_printed_numbers_by_their_status(seed):
    random = np.random.default_rng([21, seed])
    errors = random.uniform(-0.6, 0.6, 30)
    statuses = random.choice(["calibrated", "predicted"], 30)
    found = counted(errors, statuses).counts()
    assert (found.numbers, found.free) == (30, 2)
    assert found.calibrated == (statuses == "calibrated").sum() == 30 - found.predicted
    assert found.within == tuple((np.abs(errors) <= share).sum() for share in (0.05, 0.15, 0.40))
    predicted = np.abs(errors[statuses == "predicted"])
    assert found.predicted_within == tuple((predicted <= share).sum() for share in (0.05, 0.15, 0.40))


def test_a_table_shows_the_numbers_of_before_and_its_counts():
    before = counted([0.5, 0.1], ["predicted", "calibrated"])
    now = Table("t", "T", counted([0.04, 0.0], ["calibrated", "predicted"]).rows, free=["a"], before=before)
    head, *lines = now.text().splitlines()[1:]
    assert head.split() == ["controller", "index", "paper", "before", "ratio", "simulated", "ratio"]
    assert lines[0].split() == ["C", "e_0", "1", "um", "1.5", "um", "1.500", "1.04", "um", "1.040", "calibrated"]
    near = "2 numbers, 1 calibrated by {} within 5 %, 15 %, 40 %: {}, of the 1 predicted {}"
    assert lines[-3].strip() == "before: " + near.format("2 free parameters;", "0, 1, 1", "0, 0, 0")
    assert lines[-2].strip() == near.format("1 free parameter;", "2, 2, 2", "1, 1, 1")
    assert now.to_dict()["free_parameters"] == ["a"]
    assert now.to_dict()["counts"]["within"] == {"5": 2, "15": 2, "40": 2}
    assert "counts" not in Table("t", "T", now.rows).to_dict()
