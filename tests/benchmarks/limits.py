"""Are the detection limits of `diagnose` what they say? Effects hidden at 0.5, 1 and 2 times their limit.

    .venv/bin/python -m tests.benchmarks.limits --seed 1 --machines 8 --each 3

Machines, motions and noise are the blind suite's, whose simulator shares nothing with the package. Of each machine a
log without any effect is diagnosed, with other motion to confirm, for its limits; then effects are hidden at multiples
of theirs, in the same motions with fresh noise, of shapes drawn within the range for which the limit is told. Printed
for each multiple: shown (any verdict but no_gap), named (among names and alternatives), and how many should have been.
"""

import argparse
import sys
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import cogging
from cogging_command import run_command
from tests.blind.cases import LAWS_OF, SECTION
from tests.blind.hidden import Hidden
from tests.blind.machines import Machine, draw_machine
from tests.blind.motions import Motion
from tests.blind.suite import write_log
from tests.blind.truth import Plan
from tests.blind.vocabulary import CHANGES, VOCABULARY

MULTIPLES = (0.5, 1.0, 2.0)
DRAWS = 400  # of a shape, until one is within the range of the limit
#: Fields of the truth that stand for a size which has no field of its own there: the amplitude is the size.
WHOLE = ("cogging_modulation", "position_dependent_friction")


class NotDrawn(ValueError):
    """No such effect could be drawn within the range of the limit."""


def of_size(
    name: str, limit: Any, multiple: float, machine: Machine, motion: Motion, rng: np.random.Generator
) -> tuple[Hidden, float, float]:
    """An effect at a multiple of its limit: what it is, its amplitude, and its size as the limit has it."""
    for _ in range(DRAWS):
        effect = VOCABULARY[name](rng, machine, motion)
        fields = effect.parameters(effect.start)
        if effect.shape not in ("usual", "dahl") or (not fields and name not in WHOLE) or not within(fields, limit):
            continue
        size = multiple * limit.value
        if name in WHOLE:
            return effect, size, size
        if name == "command_saturation":  # the size is what is cut of the largest command
            full = fields["limit"][0] / (1.1 - effect.start)
            size = limit.sizes[0] - multiple * (limit.sizes[0] - limit.value)
            return effect, 1.1 - size / full, size
        if limit.smaller_shows:
            size = limit.value / multiple
            return effect, effect.start * fields[limit.parameter][0] / size, size
        names = ("sine", "cosine") if "sine" in fields else (limit.parameter,)
        one = float(np.hypot(*(fields[field][0] for field in names))) if len(names) > 1 else abs(fields[names[0]][0])
        return effect, effect.start * size / one, size
    raise NotDrawn(name)


def within(fields: Any, limit: Any) -> bool:
    """Whether the shape of what was drawn lies in the range for which the limit is told."""
    for field, span in limit.shape.items():
        if field in fields and field != "damping":
            low, high = span if isinstance(span, list) else (0.9 * span, 1.1 * span)
            if not low <= fields[field][0] <= high:
                return False
    return True


def changed(name: str, limit: Any, multiple: float, machine: Machine, rng: np.random.Generator) -> Any:
    """A level that differs from what the model states by a multiple of its limit."""
    nominal, sign = machine.model["axis"][SECTION[name]], float(rng.choice([-1.0, 1.0]))
    size = multiple * limit.value
    sign = 1.0 if size > 0.6 else sign

    def apply(plan: Plan, amplitude: float) -> None:
        plan[SECTION[name]] = nominal * (1.0 + sign * amplitude)

    return Hidden(name, "usual", size, 0.0, 2.0, apply), size, size


def promised(limit: Any, size: float) -> float:
    """The chance that the limit gives an effect of a size."""
    sizes, chances = np.array(limit.sizes), np.array(limit.chances)
    order = np.argsort(sizes)
    return float(np.interp(size, sizes[order], chances[order]))


def diagnosed(folder: Path, machine: Machine, plans: Sequence[Plan]) -> cogging.Diagnosis:
    """The result on the logs of two plans: given, and other motion."""
    for name, plan in zip(("log.csv", "confirm.csv"), plans, strict=True):
        write_log(folder / name, machine, plan, plan.run())
    model = cogging.Model.from_dict(machine.model)
    return cogging.diagnose(folder / "log.csv", model, confirm=[folder / "confirm.csv"])


def cases(seed: int, index: int, names: Sequence[str], slow: bool, folder: Path) -> Iterator[tuple[Any, ...]]:
    """Of one machine: each effect at each multiple, as (name, multiple, chance promised, verdict, names)."""
    rng = np.random.default_rng([seed, index])
    laws = [set(LAWS_OF[name]) for name in names if name in LAWS_OF]
    law = str(rng.choice(sorted(set.intersection(*laws)))) if laws else None
    while True:
        machine = draw_machine(rng, tight=any(name in CHANGES for name in names), law=law)
        if slow or machine.rate <= 1000.0:
            break
    motions = [machine.draw_motion(rng)[::-1] for _ in range(2)]
    null = diagnosed(folder, machine, [machine.plan(rng, *motion) for motion in motions])
    yield "nothing", 0.0, 0.0, null.verdict, called(null)
    for name in names:
        limit = null.limits[name]
        if limit.value is None:
            yield name, np.nan, np.nan, limit.why, []
            continue
        for multiple in MULTIPLES:
            try:
                if name in CHANGES:
                    effect, amplitude, size = changed(name, limit, multiple, machine, rng)
                else:
                    effect, amplitude, size = of_size(name, limit, multiple, machine, motions[0][0], rng)
                plans = [machine.plan(rng, *motion) for motion in motions]
                for plan in plans:
                    effect.apply(plan, amplitude)
                result = diagnosed(folder, machine, plans)
            except (NotDrawn, ArithmeticError) as error:
                yield name, np.nan, np.nan, f"not hidden: {error}", []
                continue
            yield name, multiple, promised(limit, size), result.verdict, called(result)


def called(result: cogging.Diagnosis) -> list[str]:
    """Names and alternatives of a result."""
    return [name for effect in result.effects for name in (effect.name, *effect.alternatives)]


def main(arguments: Sequence[str] | None = None) -> None:
    """Draw, hide, diagnose, print."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.limits", description=__doc__)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--machines", type=int, default=8)
    parser.add_argument("--each", type=int, default=3, help="effects of one machine, at three multiples each")
    parser.add_argument("--effects", default=",".join((*VOCABULARY, *CHANGES)))
    parser.add_argument("--fast", action="store_true", help="machines of 1 kHz only")
    options = parser.parse_args(arguments)
    pool = [str(n) for n in np.random.default_rng([options.seed, 0x11]).permutation(options.effects.split(","))]
    table: dict[float, list[tuple[float, bool, bool]]] = defaultdict(list)
    with TemporaryDirectory() as folder:
        for index in range(options.machines):
            wanted = [pool[(index * options.each + i) % len(pool)] for i in range(min(options.each, len(pool)))]
            begin = time.perf_counter()
            for name, multiple, chance, verdict, names in cases(
                options.seed, index, wanted, not options.fast, Path(folder)
            ):
                seconds, begin = time.perf_counter() - begin, time.perf_counter()
                print(f"{index:3d} {name:<28} {multiple:4.1f} promised {chance:4.2f} {verdict} {names} {seconds:.0f} s")
                sys.stdout.flush()
                if not np.isnan(multiple):
                    table[multiple].append((chance, verdict != "no_gap", name in names))
    print("\nmultiple  cases  promised  shown  named")
    for multiple, rows in sorted(table.items()):
        told = " ".join(f"{100.0 * np.mean(column):8.0f} %" for column in zip(*rows, strict=True))
        print(f"{multiple:8.1f}  {len(rows):5d} {told}")


if __name__ == "__main__":
    sys.exit(run_command(main))
