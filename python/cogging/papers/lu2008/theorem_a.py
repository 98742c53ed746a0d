"""Theorem 1 A of Lu, Chen, Yao, Wang 2008 as a table: with its conditions met, and with one of them dropped."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cogging._core import Arc, AxisParameters, Dcarc, DivergedError, Plant, Sampled, friction_slope_max
from cogging.effects import ConstantForce
from cogging.logs.log import Log
from cogging.papers.lu2008.condition import sufficient_gains, width_borne
from cogging.papers.lu2008.setup import COULOMB_WIDTH, START, TRAVEL, GantryAxis, controller_parameters, reference
from cogging.papers.lu2008.theorem import DISTURBANCE, EPSILON, ESTIMATED, SAMPLE_RATE, Law, Trial, draw
from cogging.papers.result import Row, Table
from cogging.simulation.batch import closed_loop_batch
from cogging.simulation.run import closed_loop

MACHINES = 4  # an axis and controller in `reproduce`
EPSILONS = (1.0, 0.1, 0.01)  # V m/s, with which the printed gains run beside the tables' machine
SMOOTHER = 1.01  # times the least width of S_f with which the printed gains satisfy (29)
BEYOND = 30.0  # times delta_d: a d~ beyond the bound that the controller assumes


def with_disturbance_times(trial: Trial, factor: float) -> Trial:
    """The same trial, with a constant d~ of `factor` times delta_d and no other."""
    offset = trial.plant.effects[0].force
    plant = Plant(
        trial.plant.axis,
        cogging=trial.plant.cogging,
        effects=[ConstantForce(force=offset + factor * DISTURBANCE)],
    )
    return replace(trial, plant=plant)


def growth_at_rest(axis: GantryAxis, **gains: Any) -> float:
    """The largest V of DCARC over its first one, held at rest by exact parameters: nothing is uncertain, no d~.

    The machine has the smallest mass and the largest frictions of the bounds and no cogging, and starts at the (p, e)
    that Q likes least, at 0.1 mm/s. Where (29) is positive, V only falls.
    """
    masses, viscous, coulomb, _ = axis.bounds
    values: dict[str, Any] = {"mass": masses[0], "viscous": viscous[1], "coulomb": coulomb[1]}
    held: dict[str, Any] = {f"{name}_adaptation": 0.0 for name in (*ESTIMATED, "cogging")}
    parameters = controller_parameters(axis, "C3", sample_rate=SAMPLE_RATE, **values, **held, **gains)
    k, mass = parameters.error_gain, values["mass"]
    friction = values["viscous"] + values["coulomb"] * friction_slope_max(COULOMB_WIDTH)
    corner, mixed = parameters.feedback_gain - mass * k + friction, -0.5 * k * friction
    # Of Q relative to diag(M, M k_1^2) / 2, in the terms p and k_1 e.
    relative = np.array([[corner, mixed / k], [mixed / k, mass * k]])
    p, ke = np.linalg.eigh(relative)[1][:, 0]
    scale = 1e-4 / abs(p - ke)
    t = np.arange(0.0, 0.02, 1.0 / SAMPLE_RATE)
    motion = Sampled(t, np.full_like(t, START), np.zeros_like(t), np.zeros_like(t))
    plant = Plant(AxisParameters(**values, coulomb_width=COULOMB_WIDTH, travel=list(TRAVEL)))
    start = (START + scale * ke / k, scale * (p - ke))
    trial = Trial(Dcarc, plant, parameters, np.zeros(0), motion, start, 0.0)
    log = closed_loop(plant, Dcarc(parameters), motion, initial_position=start[0], initial_velocity=start[1])
    found = trial.lyapunov(log)
    return float(found.max() / found[0])


def groups(axis: GantryAxis) -> tuple[tuple[Law, str, dict[str, float]], ...]:
    """Controllers that meet the conditions: law, name of the gains, and gains and width of S_f as `draw` takes them.

    ARC asks nothing of its gains. DCARC meets (29) with the printed gains where S_f is smooth enough, and with our S_f
    where the gains are large enough.
    """
    smooth = {"width": SMOOTHER * width_borne(axis)}
    return (
        (Arc, "printed", {}),
        (Dcarc, "printed, smooth S_f", smooth),
        (Dcarc, "sufficient", sufficient_gains(axis)),
    )


def theorem_table(axis: GantryAxis, machine: Plant, machines: int = MACHINES) -> Table:
    """Theorem 1 A on drawn machines, for each of `groups`, and what DCARC does with the printed gains and our S_f.

    Args:
        axis: gives bounds and motion.
        machine: on which C3 runs with its printed gains and rate and u_s2 beside them.
        machines: how many are drawn.

    Returns:
        For each: the share of machines whose V stays below its bound (held), the largest V over epsilon / lambda once
        the start is forgotten (v_settled), what (23) says of |e| then and what it is, the two conditions of (30), and
        the same with a condition dropped.
    """
    enough = sufficient_gains(axis)
    rows = []
    for law, said, conditions in groups(axis):
        trials = [draw(axis, seed, law, **conditions) for seed in range(machines)]
        logs = [trial.run() for trial in trials]
        terms = np.max([trial.robust_term(log) for trial, log in zip(trials, logs, strict=True)], axis=0)
        beyond = [with_disturbance_times(trials[0], BEYOND)]
        found = [
            ("decay_rate", "1/s", trials[0].rate, "u_s2 on"),
            *_against_the_bound(trials, logs, "u_s2 on"),
            ("e_bound", "m", max(trial.error_bound() for trial in trials), "u_s2 on"),
            ("e_inf", "m", _largest_settled(trials, logs), "u_s2 on"),
            ("condition_1", "1", terms[0], "(20) or (30), over epsilon"),
            ("condition_2", "1", terms[1], "(20) or (30), over epsilon"),
            *_against_the_bound(trials, [trial.run(epsilon=0.0) for trial in trials], "u_s2 off"),
            *_against_the_bound(beyond, [beyond[0].run()], f"{BEYOND:.0f} delta_d, machine 0"),
        ]
        rows += [_row(law, said, *one) for one in found]
    trials = [draw(axis, seed, Dcarc) for seed in range(machines)]
    erred = _largest_settled(trials, [trial.run() for trial in trials])
    rows += [
        _row(Dcarc, "printed", "decay_rate", "1/s", trials[0].rate, "u_s2 on"),
        _row(Dcarc, "printed", "e_inf", "m", erred, "u_s2 on"),
        _row(Dcarc, "printed", "v_growth", "1", growth_at_rest(axis), "at rest"),
        _row(Dcarc, "sufficient", "v_growth", "1", growth_at_rest(axis, **enough), "at rest"),
    ]
    rows += _with_robust_term(axis, machine)
    title = f"Theorem 1 A on {machines} drawn machines, {axis.name} axis: V, and its bound {EPSILON:g} V m/s / lambda"
    return Table(f"theorem1a_{axis.name}", title, rows)


def _with_robust_term(axis: GantryAxis, machine: Plant) -> list[Row]:
    motion = reference(axis)
    parameters = [
        controller_parameters(axis, "C3", epsilon=epsilon, disturbance_bound=DISTURBANCE) for epsilon in EPSILONS
    ]
    batch = closed_loop_batch(
        [machine] * len(parameters), list(map(Dcarc, parameters)), motion, start=motion.end - motion.period
    )
    for failure in batch.failures:
        raise DivergedError(failure.reason)
    return [
        Row("C3", "e_2", "m", axis.error_rms[2], float(found), "exploratory", {"case": f"5 kHz, epsilon {epsilon:g}"})
        for epsilon, found in zip(EPSILONS, batch.indexes["error_rms"], strict=True)
    ]


def _largest_settled(trials: Sequence[Trial], logs: Sequence[Log]) -> float:
    return max(trial.settled_error(log) for trial, log in zip(trials, logs, strict=True))


def _against_the_bound(trials: Sequence[Trial], logs: Sequence[Log], case: str) -> list[tuple[str, str, float, str]]:
    pairs = list(zip(trials, logs, strict=True))
    held = float(np.mean([trial.holds(log) for trial, log in pairs]))
    settled = max(trial.settled(log) for trial, log in pairs)
    return [("held", "1", held, case), ("v_settled", "1", settled, case)]


def _row(law: Law, gains: str, index: str, unit: str, value: float, case: str) -> Row:
    return Row(law.__name__.upper(), index, unit, None, value, "exploratory", {"gains": gains, "case": case})
