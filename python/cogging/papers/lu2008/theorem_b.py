"""Theorem 1 B of Lu, Chen, Yao, Wang 2008: without uncertain nonlinearity the error goes to zero.

With d~ = 0 and u_s2 left out, V + theta~^T Gamma^-1 theta~ / 2 has the derivative -z^T Q z at most (theorem.py), so
that p and e go to zero whatever is excited; nothing is said of the estimates, nor how long it takes. In sampled time an
error of the order of the sample time remains, since the command is held and the velocity is a backward difference.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from cogging._core import Dcarc, DivergedError, Plant
from cogging.arrays import FloatArray
from cogging.effects import ConstantForce
from cogging.papers.lu2008.condition import sufficient_gains
from cogging.papers.lu2008.setup import GantryAxis, controller_parameters, reference
from cogging.papers.lu2008.theorem import ESTIMATED, draw
from cogging.papers.result import Row, Table
from cogging.simulation.batch import closed_loop_batch

FASTER = 30.0  # times the printed adaptation rates, which take hundreds of periods; the theorem leaves Gamma open
PERIODS = {"X": 8, "Y": 4}  # moves there and back in `reproduce`
RATES = (5000.0, 10000.0, 20000.0)  # Hz
KEPT = 1000.0  # rows of the error a second


def errors_by_period(
    axis: GantryAxis,
    sample_rate: float,
    periods: int,
    *,
    faster: float = 1.0,
    seed: int = 0,
    gains: Mapping[str, float] = MappingProxyType({}),
) -> FloatArray:
    """The rms error (m) of DCARC in each move there and back on a drawn machine with d~ = 0, (periods,).

    Cogging of C3's harmonics, parameters and initial estimates within the bounds, an ideal encoder, no u_s2.

    Args:
        axis: gives bounds, motion and, where none are given, the printed gains.
        sample_rate: Hz.
        periods: moves there and back.
        faster: factor on all printed adaptation rates.
        seed: of the machine.
        gains: error_gain (1/s), feedback_gain (V/(m/s)).

    Raises:
        DivergedError: the run diverged.
    """
    trial, motion = draw(axis, seed, Dcarc), reference(axis, repeats=periods)
    printed = controller_parameters(axis, "C3")
    names = [f"{name}_adaptation" for name in (*ESTIMATED, "cogging")]
    changes: dict[str, Any] = {name: faster * getattr(printed, name) for name in names}
    changes |= {name: getattr(trial.parameters, name) for name in ESTIMATED}
    parameters = printed.replace(sample_rate=sample_rate, **changes, **gains)
    plant = Plant(
        trial.plant.axis, cogging=trial.plant.cogging, effects=[ConstantForce(force=trial.plant.effects[0].force)]
    )
    batch = closed_loop_batch(
        [plant], [Dcarc(parameters)], motion, columns=("true_position", "reference"), every=round(sample_rate / KEPT)
    )
    for failure in batch.failures:
        raise DivergedError(failure.reason)
    error = batch.columns["true_position"][0] - batch.columns["reference"][0]
    rows = round(motion.period * KEPT)
    return np.asarray(np.sqrt(np.mean(error[: periods * rows].reshape(periods, rows) ** 2, axis=1)))


def decays(axis: GantryAxis) -> dict[str, FloatArray]:
    """errors_by_period as printed at 5 kHz, and at each of RATES with gains that satisfy (29) and FASTER adaptation."""
    gains, periods = sufficient_gains(axis), PERIODS[axis.name]
    found = {"printed, 5 kHz": errors_by_period(axis, RATES[0], periods)}
    for rate in RATES:
        said = f"sufficient, {rate / 1000:g} kHz"
        found[said] = errors_by_period(axis, rate, periods, faster=FASTER, gains=gains)
    return found


def convergence_table(found: Mapping[str, Mapping[str, FloatArray]]) -> Table:
    """The error of the first and the last period.

    Args:
        found: of each axis by name, as `decays` gives them.
    """
    rows = []
    for axis, by_case in found.items():
        for case, errors in by_case.items():
            for period in (1, len(errors)):
                labels = {"axis": axis, "case": case, "period": str(period)}
                rows.append(Row("DCARC", "e_2", "m", None, float(errors[period - 1]), "exploratory", labels))
    faster = f"gains sufficient for (29) and adaptation {FASTER:.0f} times faster, or both as printed"
    return Table("theorem1b", f"Theorem 1 B: the rms error where only parameters are uncertain; {faster}", rows)
