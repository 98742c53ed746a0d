"""Panels of compared controllers share one scale and mark the printed value."""

import numpy as np
import pytest

from cogging.papers.compared import Trace, compared


def traces(seed, count):
    random = np.random.default_rng([20, seed])
    time = np.arange(int(random.integers(500, 20_000))) / random.choice([1000.0, 5000.0])
    sizes = 10.0 ** random.uniform(-9, -3, count)
    printed = [float(2.0 * size) if random.random() < 0.7 else None for size in sizes]
    errors = [size * np.sin(2 * np.pi * random.uniform(1, 50) * time) for size in sizes]
    return [Trace(f"C{i}", time, error, p) for i, (error, p) in enumerate(zip(errors, printed, strict=True))]


def unit_of(axes):
    return {"m": 1.0, "mm": 1e3, "µm": 1e6, "nm": 1e9}[axes.get_ylabel().split("(")[1].rstrip(")")]


def test_all_panels_have_one_scale_that_holds_trace_and_printed_value():
    drawn, zoom = traces(1, count=2), (0.1, 0.3)
    figure = compared("title", drawn, zoom=zoom)
    assert len(figure.axes) == 2 * len(drawn)
    ((low, high),) = {axes.get_ylim() for axes in figure.axes}
    assert low == -high
    # Every line: the trace in the unit of its label, then the printed value on both sides.
    unit = unit_of(figure.axes[0])
    for axes, trace in zip(figure.axes[::2], drawn, strict=True):
        line, *marks = axes.lines
        assert np.nanmax(line.get_ydata()) == pytest.approx(unit * trace.error.max())
        expected = [] if trace.printed is None else [-unit * trace.printed, unit * trace.printed]
        assert [mark.get_ydata()[0] for mark in marks] == pytest.approx(expected)
        assert all(abs(mark.get_ydata()[0]) < high for mark in marks)
    shown = figure.axes[1].lines[0].get_xdata()
    assert zoom[0] <= shown.min() < shown.max() <= zoom[1]
    (cut,) = compared("title", drawn[:1], limit=1e-6).axes
    assert cut.get_ylim()[1] == pytest.approx(1e-6 * unit_of(cut))
