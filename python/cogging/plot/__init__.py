"""Pictures of logs, models and results: one function a kind, each of which takes and returns axes (docs/plot.md)."""

from cogging.plot.friction_laws import friction_curve
from cogging.plot.gap_shares import ledger
from cogging.plot.gaps import residual
from cogging.plot.learned import adaptation
from cogging.plot.many_runs import prediction, sweep, trade_off
from cogging.plot.maps import cogging_map
from cogging.plot.over_time import error, log
from cogging.plot.parameter_intervals import intervals
from cogging.plot.spectra import spectrum

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
