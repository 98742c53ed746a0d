"""Plots of logs, models and results: functions that take and return axes (docs/plot.md).

Each function takes `units`, the labels of command and position (cogging.Units; None: those of the model or result), and
`ax`, axes of matplotlib (None: a new figure), and returns the axes. An argument of another type raises TypeError.
"""

from cogging.plot.characteristics import cogging_map, friction_curve, intervals, spectrum
from cogging.plot.gaps import ledger, residual
from cogging.plot.many_runs import prediction, sweep, trade_off
from cogging.plot.over_time import adaptation, error, log

__all__ = [
    "adaptation",
    "cogging_map",
    "error",
    "friction_curve",
    "intervals",
    "ledger",
    "log",
    "prediction",
    "residual",
    "spectrum",
    "sweep",
    "trade_off",
]


def __dir__() -> list[str]:
    """Return the plots."""
    return __all__
