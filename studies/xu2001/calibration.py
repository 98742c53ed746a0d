"""Calibrates what Xu and Yao 2001 do not report: `python -m studies.xu2001.calibration [FILE]`.

Everything is fitted to e_M, e_F, e_rms, u_rms, c_u of Table 1, in some 15 minutes of one core, and comes with the
package as plant.toml, each fit with the error that it left:

- by friction law: the plant, on the 15 numbers of the PID;
- `joint`: plant and a common factor on the adaptation rates, on all 30 numbers, by friction law;
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
from cogging.papers.xu2001.conditions import ALL, HELD_OUT, PID
from cogging.papers.xu2001.conditions_fit import JOINT_LAW, LAWS, RATES, START, Fit, Problem, calibrate, start_of
from cogging_command import run_command

PID_STARTS, JOINT_STARTS = 8, 3
EARLIER_RUNS = 2  # of 0 to 4 the number that comes nearest: `earlier_runs` of plant.toml
#: Where the joint search begins: what an earlier one had found, rounded. Held-out fits, which may not know that, begin
#: where the plant's does, with the adaptation as printed.
JOINT_START = {
    "coulomb": 0.129,
    "coulomb_width": 1.55e-3,
    "static_excess": 0.035,
    "stribeck_velocity": 0.0077,
    "offset": 0.0055,
    "delay": 4.19e-4,
    "encoder_noise": 0.38e-6,
    "ripple": 0.112,
    "ripple_period": 0.0523,
    "adaptation_factor": 2.9,
}
HELD_OUT_START = START | {"adaptation_factor": 1.0}
#: Readings of the printed numbers that would make the adaptation as fast as the joint fit has it, and factors around
#: it: the factor on Gamma and what else is changed. All else is fitted to the 30 numbers.
READINGS: dict[str, tuple[float, Mapping[str, Any]]] = {
    "Gamma as printed": (1.0, {}),
    "Gamma x 2": (2.0, {}),
    "Gamma x 2.5: steps of 1 ms in a loop of 0.4 ms": (2.5, {}),
    "Gamma x 2.73: theta_2 of (52)": (2.73, {}),
    "Gamma x 3.7: 1/M of set 1 over that of set 2": (3.7, {}),
    "Gamma x 5": (5.0, {}),
    "w_2 = 0.3 for 0.1": (1.0, {"weight_2": 0.3}),
    "observer at -120 for -200": (1.0, {"observer_gain_1": 240.0, "observer_gain_2": 14400.0}),
}
EACH_RATE = "each of the three rates free"  # whether one factor serves all: from the printed rates, none is preferred
MOST_EARLIER_RUNS = 4
BRIEFLY = (5, 1)  # iterations of the fits that begin where another ended


def plants() -> dict[str, Any]:
    """The plant on the PID columns, by friction law."""
    return {law: calibrate(Problem(PID, law), PID_STARTS).to_dict(arc=False) for law in LAWS}


def joint_fit() -> Fit:
    """Plant and adaptation factor on all numbers, with the friction law of the shipped plant."""
    problem = Problem(ALL, JOINT_LAW, JOINT_START, earlier_runs=EARLIER_RUNS, iterations=(8, 4))
    return calibrate(problem, JOINT_STARTS)


def other_law_fits(start: Mapping[str, float]) -> dict[str, Any]:
    """The joint fit with the other friction laws, each from the end of the shipped one."""
    others = [law for law in LAWS if law != JOINT_LAW]
    problems = {law: Problem(ALL, law, start, earlier_runs=EARLIER_RUNS, iterations=BRIEFLY) for law in others}
    return {law: calibrate(problem).to_dict() for law, problem in problems.items()}


def earlier_run_fits(start: Mapping[str, float]) -> dict[str, Any]:
    """The joint fit with other numbers of earlier runs, each from the end of the shipped one."""
    others = [number for number in range(MOST_EARLIER_RUNS + 1) if number != EARLIER_RUNS]
    problems = {str(number): Problem(ALL, start=start, earlier_runs=number, iterations=BRIEFLY) for number in others}
    return {name: calibrate(problem).to_dict() for name, problem in problems.items()}


def reading_fits(start: Mapping[str, float]) -> dict[str, Any]:
    """The joint fit under each of READINGS and with each rate free, from the plant of the shipped one."""
    plant = {name: value for name, value in start.items() if name != "adaptation_factor"}
    fixed = Problem(ALL, start=plant, earlier_runs=EARLIER_RUNS, iterations=BRIEFLY)
    problems = {
        name: replace(fixed, adaptation_factor=factor, changes=changes) for name, (factor, changes) in READINGS.items()
    }
    as_printed = dict.fromkeys(RATES, 1.0)
    problems[EACH_RATE] = replace(fixed, start=plant | as_printed, iterations=(8, 2))
    return {name: calibrate(problem).to_dict() for name, problem in problems.items()}


def held_out_fit(split: str) -> Fit:
    """Plant, factor and number of earlier runs (0 to 2) on the numbers of a split alone, from the printed start."""
    problem = Problem(HELD_OUT[split], start=HELD_OUT_START, iterations=(9, 1))
    fits = [calibrate(replace(problem, earlier_runs=number)) for number in range(EARLIER_RUNS + 1)]
    return min(fits, key=lambda fit: fit.errors[0])


def plant_toml() -> str:
    """The text of plant.toml."""
    document = plants()
    joint = joint_fit()
    start = start_of(joint.conditions)
    document["joint"] = {JOINT_LAW: joint.to_dict(), **other_law_fits(start)}
    document["earlier_runs"], document["readings"] = earlier_run_fits(start), reading_fits(start)
    document["held_out"] = {split: held_out_fit(split).to_dict() for split in HELD_OUT}
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
