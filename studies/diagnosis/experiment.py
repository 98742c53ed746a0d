"""Whether the proposed experiment settles what a log left open, beside other motion of the same time.

    python -m studies.diagnosis.experiment --seed N --cases M --out DIR [--minutes MINUTES]

Machines with one hidden effect, by the simulator of the blind suite, are drawn until M of their logs are ambiguous: the
right name has alternatives. `plan_experiment` then proposes 20 s of motion; the machine runs it, the given motion once
more for as long, and random motion for as long, each with noise of its own; each new log is diagnosed together with
the old one. A case is settled where the right name stands alone. The proposal is worth its while where it settles at
least twice as many as a repetition. DIR/cases.jsonl holds what came out, case by case: a second call with the
same seed goes on where the first ended.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

import cogging
from cogging_command import run_command
from tests.blind.cases import Case, Specification, Unreachable, draw_case
from tests.blind.motions import Motion, draw_motion
from tests.blind.truth import Plan, Run

SECONDS = 20.0  # of each new motion
RATIOS = (100.0, 300.0)
FASTEST = 2500.0  # Hz, of machines: a log of 20 s is diagnosed three times a case
ARMS = ("proposed", "repeated", "random")
#: Effects whose logs are often ambiguous, each with a part of the vocabulary that looks like it.
EFFECTS = (
    "cable_spring",
    "end_effect",
    "cogging_harmonic",
    "force_constant_ripple",
    "encoder_periodic_error",
    "command_delay",
    "actuator_lag",
    "coulomb_asymmetry",
    "viscous_asymmetry",
    "position_dependent_friction",
    "quadratic_drag",
    "constant_force",
    "force_constant_drift",
    "disturbance_step",
    "encoder_scale_error",
)


def record(case: Case, motion: Motion, moments: np.ndarray, seed: list[int]) -> cogging.Log:
    """A log of the case's machine, its effect in it, on a motion; noise of its own."""
    plan: Plan = case.machine.plan(np.random.default_rng(seed), motion, moments)
    for effect, amplitude in case.hidden:
        effect.apply(plan, amplitude)
    return as_log(plan, plan.run())


def as_log(plan: Plan, run: Run) -> cogging.Log:
    """A run as the user's log has it."""
    rows = plan.rows
    return cogging.Log(plan.stamps, run.reading, run.command, rows[:, 0], rows[:, 1], rows[:, 2])


def motions(case: Case, plan: cogging.ExperimentPlan, seed: int) -> dict[str, Motion]:
    """The three motions that are compared."""
    machine = case.machine
    moments = np.arange(int(SECONDS * machine.rate)) / machine.rate
    given = case.main.rows[:, :3]
    # There and back to where it began, at rest: the same motion, backwards in every second turn.
    back = np.column_stack([given[::-1, 0], -given[::-1, 1], given[::-1, 2]])
    turns = int(np.ceil(len(moments) / len(given)))
    again = np.concatenate([given if turn % 2 == 0 else back for turn in range(turns)])[: len(moments)]
    random = draw_motion(
        np.random.default_rng([seed, 7]), moments, machine.travel, machine.velocity, machine.acceleration
    )
    return {"proposed": Motion(*plan.motion.sample(moments)), "repeated": Motion(*again.T), "random": random}


def told(result: cogging.Diagnosis, name: str) -> dict[str, Any]:
    """What a result says of the one hidden effect."""
    names = [[effect.name, *effect.alternatives] for effect in result.effects]
    return {
        "verdict": result.verdict,
        "names": names,
        "settled": names == [[name]],
        "first": any(group[0] == name for group in names),
        "held": any(name in group for group in names),
        "wrong": bool(names) and not any(name in group for group in names),
    }


def ask(seed: int, index: int) -> dict[str, Any] | None:
    """One case; None where it cannot be drawn, states no controller, is sampled fast or leaves nothing open."""
    name, ratio = EFFECTS[index % len(EFFECTS)], RATIOS[index // len(EFFECTS) % len(RATIOS)]
    try:
        case = draw_case([seed, index], Specification("effect", (name,), ratio))
    except Unreachable:
        return None
    machine = case.machine
    if not machine.stated_controller or machine.rate > FASTEST:
        return None
    model, old = cogging.Model.from_dict(machine.model), as_log(case.main, case.main_run)
    first = cogging.diagnose(old, model)
    mine = [effect for effect in first.effects if name in (effect.name, *effect.alternatives)]
    if not any(effect.alternatives for effect in mine):
        return None
    limits = cogging.MotionLimits(machine.velocity, machine.acceleration, SECONDS, command=3.0 * machine.peak)
    answer: dict[str, Any] = {"name": name, "ratio": ratio, "before": told(first, name)}
    begun = time.perf_counter()
    try:
        plan = cogging.plan_experiment(model, limits, result=first, logs=[old], seed=index)
    except ValueError as error:
        return answer | {"refused": str(error)}
    answer |= {"seconds": time.perf_counter() - begun, "plan": [element.kind for element in plan.elements]}
    moments = np.arange(int(SECONDS * machine.rate)) / machine.rate
    for number, (arm, motion) in enumerate(motions(case, plan, seed + index).items()):
        try:
            log = record(case, motion, moments, [seed, index, number])
            answer[arm] = told(cogging.diagnose([old, log], model), name)
        except ArithmeticError as error:
            answer[arm] = dict.fromkeys(("settled", "first", "held", "wrong"), False) | {"error": str(error)}
    return answer


def table(answers: list[dict[str, Any]]) -> str:
    """The table of what was settled."""
    run = [answer for answer in answers if "refused" not in answer]
    lines = [f"{len(answers)} ambiguous cases, {len(run)} with a proposed motion of {SECONDS:g} s"]
    lines.append(f"{'new motion':<12}{'settled':>9}{'right first':>13}{'right among':>13}{'wrong':>7}")
    counts = {arm: [sum(one[arm][key] for one in run) for key in ("settled", "first", "held", "wrong")] for arm in ARMS}
    lines += [f"{arm:<12}{a:>9}{b:>13}{c:>13}{d:>7}" for arm, (a, b, c, d) in counts.items()]
    if run:
        enough = counts["proposed"][0] >= 2 * counts["repeated"][0]
        lines.append(f"at least twice as many as a repetition: {'yes' if enough else 'no'}")
        lines.append(f"seconds a plan: median {np.median([answer['seconds'] for answer in run]):.0f}")
    for answer in run:
        marks = " ".join(f"{arm} {'settled' if answer[arm]['settled'] else answer[arm]['names']}" for arm in ARMS)
        lines.append(f"  {answer['name']} {answer['ratio']:g}: before {answer['before']['names']}; {marks}")
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> int:
    """Draw, ask, print; exit status 0."""
    parser = argparse.ArgumentParser(prog="python -m studies.diagnosis.experiment", description=__doc__)
    parser.add_argument("--seed", type=int, required=True, help="of the machines")
    parser.add_argument("--cases", type=int, default=40, help="ambiguous ones, that are asked for")
    parser.add_argument("--minutes", type=float, default=1e9, help="after which no further case is begun")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    file = options.out / "cases.jsonl"
    known = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    begun, index = time.perf_counter(), len(known)
    answers = [entry for entry in known if "name" in entry]
    while len(answers) < options.cases and time.perf_counter() - begun < 60.0 * options.minutes:
        answer = ask(options.seed, index)
        with file.open("a") as out:
            out.write(json.dumps(answer or {}) + "\n")
        if answer is not None:
            answers.append(answer)
        print(f"{index}: {answer and answer['before']['names']}", file=sys.stderr, flush=True)
        index += 1
    print(table(answers))
    return 0


if __name__ == "__main__":
    sys.exit(run_command(main))
