"""The papers' gains, tuned on their own setups: `python -m studies.tuned_gains [FOLDER]`.

The command may be no larger than with the printed gains, and at least half of the delay that they bear must be left.
Gains are tuned on drawn machines (those of Lu et al. on fewer moves) and then compared with the printed ones on the
paper's own runs. Prints both, and what it costs in robustness; draws for Lu et al.'s X axis what each delay margin
costs in error.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cogging._core import Plant, Reference, performance
from cogging.design.tuning import Tuning, tune
from cogging.model.model import Model
from cogging.papers.lu2008 import gantry as lu2008
from cogging.papers.xu2001 import epoxy_motor as xu2001
from cogging.simulation.run import closed_loop
from studies.command import run_study

RANGE = 10.0  # above and below the printed gain
LIMITS = {"command_max": {"present": 1.0}, "delay_margin": {"present": 0.5}}
LU2008_MACHINES = {"mass": 0.03, "viscous": 0.1, "coulomb": 0.1}  # relative 1 sigma, not reported, assumed
LU2008_REPEATS = 3  # of the shorter motion


@dataclass(frozen=True)
class Case:
    """A controller of a paper on its setup."""

    name: str  # paper, axis and controller
    model: Model  # the machine with the printed gains
    gains: tuple[str, ...]  # that are tuned
    vary: Mapping[str, Any] | str  # how machines differ
    motion: Reference  # that is tuned on
    duration: float  # of it, s
    start: float  # s: error and command are judged from here on
    #: The paper's own runs by name: machine, motion, duration and start (s), seed of the noise.
    own: Mapping[str, tuple[Plant, Reference, float, float, int]]


def lu2008_case(name: str) -> Case:
    """C3 on an axis of Lu et al. 2008."""
    axis = lu2008.AXES[name]
    cogging = lu2008.cogging_map(axis, lu2008.shipped_amplitudes(axis))
    machine = lu2008.plant(axis, cogging)
    own, motion = lu2008.reference(axis), lu2008.reference(axis, repeats=LU2008_REPEATS)
    return Case(
        name=f"lu2008, {name} axis, C3",
        model=Model(
            axis=machine.axis,
            cogging=cogging,
            encoder=machine.encoder,
            controller=lu2008.controller_parameters(axis, "C3"),
            controller_type="dcarc",
            uncertainty=LU2008_MACHINES,
        ),
        gains=("error_gain", "feedback_gain", "disturbance_adaptation", "cogging_adaptation"),
        vary="bounds",
        motion=motion,
        duration=0.0,
        start=motion.end - motion.period,
        own={f"{axis.repeats} moves, the last": (machine, own, 0.0, own.end - own.period, 0)},
    )


def xu2001_case() -> Case:
    """The ARC of Xu and Yao 2001; the machines are those from no payload to the paper's."""
    unknowns = xu2001.shipped_unknowns()
    machines = {name: xu2001.plant(unknowns, name) for name in xu2001.SETS}
    lightest = machines["1"]
    motion, own = xu2001.reference(), (xu2001.reference(), xu2001.DURATION, -np.inf, xu2001.SEED)
    return Case(
        name="xu2001, ARC",
        model=Model(
            axis=lightest.axis,
            effects=lightest.effects,
            encoder=lightest.encoder,
            controller=xu2001.arc_parameters(),
            controller_type="output_feedback_arc",
        ),
        gains=("gain_1", "gain_2", "observer_gain_1", "observer_gain_2"),
        vary={"axis.mass": {"from": xu2001.MASSES["1"], "to": xu2001.MASSES["2"]}},
        motion=motion,
        duration=xu2001.DURATION,
        start=-np.inf,  # the start counts as much as in the paper
        own={f"set {name}": (machine, *own) for name, machine in machines.items()},
    )


def tuned(case: Case, *, trials: int = 100, machines: int = 8, **options: Any) -> Tuning:
    """Tune a paper's gains, each from a tenth to ten times the printed one, within LIMITS."""
    printed = case.model.controller.to_dict() if case.model.controller is not None else {}
    return tune(
        case.model,
        case.motion,
        {f"controller.{name}": {"from": printed[name] / RANGE, "to": printed[name] * RANGE} for name in case.gains},
        limits=LIMITS,
        vary=case.vary,
        trials=trials,
        machines=machines,
        held_out=2 * machines,
        duration=case.duration,
        start=case.start,
        **options,
    )


def on_own_runs(case: Case, model: Model) -> dict[str, tuple[float, float, float]]:
    """Rms and largest error (m) and largest command (V) of a model's gains on each of the paper's own runs."""
    found = {}
    for name, (machine, motion, duration, start, seed) in case.own.items():
        log = closed_loop(machine, model.make_controller(), motion, duration=duration, seed=seed)
        indexes = performance(log.time, log.error, log.command, start=start)
        found[name] = (indexes.error_rms, indexes.error_max, float(np.abs(log.command).max()))
    return found


def main(folder: str = ".", show: Callable[[str], None] = print) -> None:
    """Tune and compare."""
    for case in (lu2008_case("X"), xu2001_case()):
        tuning = tuned(case, progress=True)
        show(f"{case.name}\n{tuning.text()}")
        if tuning.model is None:
            continue
        for kind, model in (("as printed", case.model), ("tuned", tuning.model)):
            for name, (rms, largest, command) in on_own_runs(case, model).items():
                indexes = f"rms {1e6 * rms:7.3f} um   max {1e6 * largest:7.2f} um   |u| {command:.4f} V"
                show(f"    {f'{name}, {kind}':<36}{indexes}")
    trade_off = tuned(lu2008_case("X"), trials=80, machines=4, against="delay_margin", progress=True)
    trade_off.write_figure(Path(folder) / "lu2008_tuning.png")
    for rms, margin in zip(trade_off.front["error_rms"], trade_off.front["delay_margin"], strict=True):
        show(f"    delay margin {1e3 * margin:6.3f} ms   rms {1e6 * rms:7.3f} um")


if __name__ == "__main__":
    sys.exit(run_study(__doc__, main, ".", "folder of the figure"))
