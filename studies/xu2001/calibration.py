"""Calibrates what Xu and Yao 2001 do not report: `python -m studies.xu2001.calibration [FILE]`.

Everything is fitted to e_M, e_F, e_rms, u_rms, c_u of Table 1, in some 15 minutes of one core, and comes with the
package as plant.toml, each fit with the error that it left:

- by friction law: the plant, on the 15 numbers of the PID at one seed of the encoder noise;
- `joint`: plant and a common factor on the adaptation rates, by model of the plant, on the means of all 30 numbers
  over eight seeds;
- `earlier_runs`, `readings`: the same with other numbers of earlier runs, and with what the printed rates may mean;
- `held_out`: the same on a part of the numbers, the others being left to predict.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import cogging.papers.xu2001
from cogging.outputs import to_toml, write_text
from cogging.papers.xu2001.conditions import ALL, HELD_OUT, JOINT_LAW, LAWS, PID
from cogging.papers.xu2001.conditions_fit import START, Fit, Problem, calibrate, start_of
from cogging.papers.xu2001.setup import SEED
from cogging_command import run_command

PID_STARTS = 8
EARLIER_RUNS = 2  # of 0 to 3 the number that comes nearest: `earlier_runs` of plant.toml
#: Where the joint search begins: what an earlier one had found at one seed, rounded. Held-out fits, which may not know
#: that, begin where the plant's does, with the adaptation as printed.
JOINT_START = {
    "coulomb": 0.135,
    "coulomb_width": 1e-3,
    "static_excess": 0.02,
    "stribeck_velocity": 0.0077,
    "offset": 0.005,
    "delay": 3.6e-4,
    "encoder_noise": 0.39e-6,
    "ripple": 0.112,
    "ripple_period": 0.0525,
    "adaptation_factor": 2.9,
}
HELD_OUT_START = START | {"adaptation_factor": 1.0}
#: Readings of the printed numbers that would make the adaptation as fast as the joint fit has it: the factor on Gamma
#: and what else is changed. All else is fitted to the 30 numbers.
READINGS: dict[str, tuple[float, Mapping[str, Any]]] = {
    "Gamma as printed": (1.0, {}),
    "Gamma x 2.5: steps of 1 ms in a loop of 0.4 ms": (2.5, {}),
    "Gamma x 3.7: 1/M of set 1 over that of set 2": (3.7, {}),
    "w_2 = 0.3 for 0.1": (1.0, {"weight_2": 0.3}),
}
MOST_EARLIER_RUNS = 3
BRIEFLY = (1, 0)  # iterations of the fits that begin where another ended


def nested_in(law: str) -> list[str]:
    """The models of the plant that are this one with more of its quantities held at zero."""
    return [other for other in LAWS if other != law and LAWS[law].items() <= LAWS[other].items()]


def by_model(problem: Problem, laws: list[str], done: Mapping[str, Fit], starts: int = 1) -> dict[str, Fit]:
    """The fits of models of the plant, each after those that are nested in it, whose best is a further start."""
    found = dict(done)
    for law in sorted(laws, key=lambda law: -len(LAWS[law])):
        nested = [found[other] for other in nested_in(law) if other in found]
        nested = sorted(nested, key=lambda fit: fit.errors[0])[:1]
        found[law] = calibrate(replace(problem, law=law), starts if starts > 1 or not nested else 0, nested)
    return found


def plants() -> dict[str, Fit]:
    """The plant on the PID columns, by friction law."""
    laws = [law for law in LAWS if law != JOINT_LAW]
    return by_model(Problem(PID, seeds=(SEED,)), laws, {}, PID_STARTS)


def joint_fit() -> Fit:
    """Plant and adaptation factor on all numbers, with the model of the plant that is shipped."""
    return calibrate(Problem(ALL, JOINT_LAW, JOINT_START, earlier_runs=EARLIER_RUNS, iterations=(8, 4)))


def other_law_fits(joint: Fit) -> dict[str, Fit]:
    """The joint fit with the other models of the plant."""
    problem = Problem(ALL, start=JOINT_START, earlier_runs=EARLIER_RUNS, iterations=(2, 0))
    return by_model(problem, [law for law in LAWS if law != JOINT_LAW], {JOINT_LAW: joint})


def earlier_run_fits(joint: Fit) -> dict[str, Fit]:
    """The joint fit with other numbers of earlier runs, each from the end of the shipped one."""
    others = [number for number in range(MOST_EARLIER_RUNS + 1) if number != EARLIER_RUNS]
    problem = Problem(ALL, start=start_of(joint.conditions), iterations=BRIEFLY)
    return {str(number): calibrate(replace(problem, earlier_runs=number)) for number in others}


def reading_fits(joint: Fit) -> dict[str, Fit]:
    """The joint fit under each of READINGS, from the end of the shipped one."""
    plant = {name: value for name, value in start_of(joint.conditions).items() if name != "adaptation_factor"}
    fixed = Problem(ALL, start=plant, earlier_runs=EARLIER_RUNS, iterations=BRIEFLY)
    return {name: calibrate(replace(fixed, adaptation_factor=x, changes=y)) for name, (x, y) in READINGS.items()}


def held_out_fit(split: str) -> Fit:
    """Plant, factor and number of earlier runs (0 to 2) on the numbers of a split alone, from the printed start."""
    problem = Problem(HELD_OUT[split], start=HELD_OUT_START, iterations=BRIEFLY)
    fits = [calibrate(replace(problem, earlier_runs=number)) for number in range(EARLIER_RUNS + 1)]
    best = min(fits, key=lambda fit: fit.errors[0]).conditions
    return calibrate(replace(problem, start=start_of(best), earlier_runs=best.earlier_runs, iterations=(3, 0)))


def plant_toml() -> str:
    """The text of plant.toml."""
    joint = joint_fit()
    document: dict[str, Any] = {law: fit.to_dict(arc=False) for law, fit in plants().items()}
    parts = {
        "joint": other_law_fits(joint),
        "earlier_runs": earlier_run_fits(joint),
        "readings": reading_fits(joint),
        "held_out": {split: held_out_fit(split) for split in HELD_OUT},
    }
    document |= {part: {name: fit.to_dict() for name, fit in fits.items()} for part, fits in parts.items()}
    return text_of(document)


def text_of(document: Mapping[str, Any]) -> str:
    """A document as the file."""
    head = "# What the paper does not report, by what it was fitted to, written by studies.xu2001.calibration.\n"
    return head + to_toml(document)


def main(target: str) -> None:
    """Calibrate and write the file."""
    write_text(target, plant_toml())
    print(f"{target} written")


if __name__ == "__main__":
    own = str(Path(cogging.papers.xu2001.__file__).with_name("plant.toml"))
    sys.exit(run_command(lambda: main(sys.argv[1] if len(sys.argv) > 1 else own)))
