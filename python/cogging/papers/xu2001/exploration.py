"""Which change of the ARC's numbers brings its columns near those that Xu and Yao 2001 print. Exploratory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from cogging._core import DivergedError, OutputFeedbackArc
from cogging.arrays import FloatArray
from cogging.logs.log import Log
from cogging.model.controller import ListedController
from cogging.papers.xu2001.conditions import Conditions
from cogging.papers.xu2001.setup import INDEXES, SETS, TABLE_1, Unknowns, arc_parameters, indexes, run

JUDGED = ("e_M", "e_F", "e_rms", "u_rms", "c_u")


def columns(controller: ListedController, unknowns: Unknowns, seed: int = 2001, earlier_runs: int = 0) -> FloatArray:
    """The judged indexes of a controller in the three sets, (3, 5).

    Raises:
        DivergedError: a run diverged.
    """
    return columns_of(run(unknowns, controller, seed=seed, earlier_runs=earlier_runs))


def columns_of(logs: Mapping[str, Log]) -> FloatArray:
    """The same of logs by set."""
    return np.array([[indexes(logs[name])[index] for index in JUDGED] for name in SETS])


def printed(controller: str) -> FloatArray:
    """The same of Table 1, (3, 5)."""
    return np.array([[TABLE_1[controller][name][INDEXES.index(index)] for index in JUDGED] for name in SETS])


def gap(found: FloatArray, controller: str = "ARC") -> float:
    """The rms log-ratio to the printed column."""
    return float(np.sqrt(np.mean(np.log(found / printed(controller)) ** 2)))


def changes() -> dict[str, dict[str, Any]]:
    """The changes of the ARC's numbers that are tried, each alone and some together."""
    base = arc_parameters()

    def adaptation(factor: float) -> dict[str, Any]:
        return {"adaptation": [factor * rate for rate in base.adaptation]}

    def gains(factor: float) -> dict[str, Any]:
        return {"gain_1": factor * base.gain_1, "gain_2": factor * base.gain_2}

    observer = {"observer_gain_1": 2 * base.observer_gain_1, "observer_gain_2": 4 * base.observer_gain_2}
    together = {
        "adaptation x 3.5": adaptation(3.5),
        "gains x 1.2": gains(1.2),
        "theta_1(0) = 37": {"theta": [37.0, 10.0, 0.0]},
        "theta_1(0) = 20": {"theta": [20.0, 10.0, 0.0]},
    }
    return {
        "as printed, g only": {},
        "adaptation x 2": adaptation(2.0),
        **together,
        "adaptation x 5": adaptation(5.0),
        "gains x 0.8": gains(0.8),
        "observer poles at -400": observer,
        "with the C_phi1 term": {"use_c_phi_1": True},
        "Euler steps of the filters": {"filter_steps": "euler"},
        "no friction compensation": {"coulomb": 0.0},
        "adaptation x 3.5, gains x 1.2": {**adaptation(3.5), **gains(1.2)},
        "adaptation x 3.5, theta_1(0) = 20": {**adaptation(3.5), "theta": [20.0, 10.0, 0.0]},
        "all three": {**adaptation(3.5), **gains(1.2), "theta": [20.0, 10.0, 0.0]},
    }


def explore(unknowns: Unknowns) -> dict[str, float]:
    """The gap of the ARC columns for each of the changes; infinite where a run diverges."""
    found = {}
    for name, change in changes().items():
        try:
            found[name] = gap(columns(OutputFeedbackArc(arc_parameters(**change)), unknowns))
        except DivergedError:
            found[name] = float("inf")
    return found


def explore_conditions(unknowns: Unknowns, joint: Conditions, arc_logs: Mapping[str, Log]) -> dict[str, float]:
    """The same on the way to the joint conditions, whose ARC logs are given: earlier runs, the factor, the plant."""
    runs, factor = joint.earlier_runs, joint.adaptation_factor
    kept = f"{runs} earlier runs"
    both = f"{kept}, adaptation x {factor:.3g}"
    return {
        kept: gap(columns_of(Conditions(unknowns, earlier_runs=runs).logs("ARC"))),
        both: gap(columns_of(replace(joint, unknowns=unknowns).logs("ARC"))),
        f"{both}, all fitted": gap(columns_of(arc_logs)),
    }
