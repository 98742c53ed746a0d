"""A blind suite: cases under opaque names, logs and models as a user has them, and the key in a folder of its own."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from .cases import LAMBDAS, Case, Specification, Unreachable, draw_case
from .large import NAMES, draw_large
from .machines import NULL_FAMILIES, Machine
from .outside import OUTSIDE
from .truth import Plan, Run
from .vocabulary import CHANGES, VOCABULARY

#: Share of each kind of case in a suite.
SHARES = {"null": 0.33, "effect": 0.42, "outside": 0.16, "pair": 0.06, "triple": 0.03}
KINDS = (*SHARES, "large")  # the last is drawn where it is asked for, as often as nulls
PAIR_RATIO = 300.0


def plan_suite(
    seed: int,
    count: int,
    *,
    kinds: Sequence[str] = tuple(SHARES),
    families: Sequence[str] = NULL_FAMILIES,
    effects: Sequence[str] = (*VOCABULARY, *CHANGES),
    ratios: Sequence[float] = LAMBDAS,
) -> list[Specification]:
    """Decide what the cases hold: families, effects and ratios each as even as the count allows, in random order."""
    rng = np.random.default_rng([seed, 0xB11D])
    total = sum(SHARES.get(kind, SHARES["null"]) for kind in kinds)
    exact = np.array([count * SHARES.get(kind, SHARES["null"]) / total for kind in kinds])
    numbers = np.floor(exact).astype(int)
    for index in np.argsort(numbers - exact)[: count - numbers.sum()]:
        numbers[index] += 1
    specifications: list[Specification] = []
    for kind, number in zip(kinds, numbers, strict=True):
        if kind == "null":
            specifications += [Specification(kind, family=family) for family in _even(rng, families, number)]
        elif kind == "large":
            pool = NAMES if set(VOCABULARY) <= set(effects) else [name for name in NAMES if name in effects]
            specifications += [Specification(kind, (name,)) for name in _even(rng, pool, number)]
        elif kind in ("effect", "outside"):
            names = _even(rng, effects if kind == "effect" else tuple(OUTSIDE), number)
            drawn = _even(rng, ratios, number)
            specifications += [Specification(kind, (n,), float(r)) for n, r in zip(names, drawn, strict=True)]
        else:
            pool = [name for name in effects if name not in CHANGES]
            size = min(2 if kind == "pair" else 3, len(pool))
            for _ in range(number):
                names = tuple(str(n) for n in rng.choice(pool, size, replace=False))
                specifications.append(Specification(kind, names, PAIR_RATIO))
    # a change below five times its stated deviation is none: the smallest ratio goes to another effect
    for index, one in enumerate(specifications):
        if 0.0 < one.ratio < 25.0 and set(one.names) & set(CHANGES):
            specifications[index] = replace(one, ratio=30.0)
    rng.shuffle(specifications)  # type: ignore[arg-type]
    return specifications


def _even(rng: np.random.Generator, pool: Sequence[Any], count: int) -> list[Any]:
    """Draw count entries, each as often as any other, in random order."""
    drawn: list[Any] = []
    while len(drawn) < count:
        drawn += [pool[i] for i in rng.permutation(len(pool))]
    return drawn[:count]


def mapped(function: Callable[[Any], Any], tasks: Sequence[Any], jobs: int) -> Iterator[Any]:
    """Answers of a function in the order of its tasks; by so many processes if more than one."""
    if jobs > 1:
        with ProcessPoolExecutor(jobs) as pool:
            yield from pool.map(function, tasks)
    else:
        yield from map(function, tasks)


def draw_suite(
    seed: int, folder: Path, key_folder: Path, specifications: Sequence[Specification | None], jobs: int = 1
) -> dict[str, Any]:
    """Draw all cases, write folder/case_XXXX/{log.csv, confirm.csv, model.toml} and key_folder/key.json.

    Returns the key. A case is drawn by its place in the list: one that is None is left out. A ratio that no machine of
    some dozens can show (below what is physical for the effect) is replaced by the next larger one; a pair that cannot
    be told apart by another pair. What still fails is named in the key.
    """
    key_folder.mkdir(parents=True, exist_ok=True)
    tasks = [(seed, index, folder, one) for index, one in enumerate(specifications) if one is not None]
    answers = list(mapped(_draw_and_write, tasks, jobs))
    key = {
        "seed": seed,
        "cases": {name: entry for name, entry in answers if "unreachable" not in entry},
        "unreachable": [entry["unreachable"] for _, entry in answers if "unreachable" in entry],
    }
    (key_folder / "key.json").write_text(json.dumps(key, indent=1))
    return key


def _draw_and_write(task: tuple[int, int, Path, Specification]) -> tuple[str, dict[str, Any]]:
    seed, index, folder, specification = task
    name = f"case_{index:04d}"
    for retry in range(6):
        try:
            draw = draw_large if specification.kind == "large" else draw_case
            case = draw([seed, index, retry], specification)
        except Unreachable as error:
            reason = str(error)
        else:
            write_case(case, folder / name)
            return name, case.key
        larger = [ratio for ratio in LAMBDAS if ratio > specification.ratio]
        if specification.kind in ("pair", "triple"):
            rng = np.random.default_rng([seed, index, retry, 1])
            names = tuple(str(n) for n in rng.choice(list(VOCABULARY), len(specification.names), replace=False))
            specification = replace(specification, names=names)
        elif larger and specification.names:
            specification = replace(specification, ratio=larger[0])
        else:
            break
    return name, {"unreachable": reason}


def write_case(case: Case, folder: Path) -> None:
    """Write the two logs and the model of a case, as a user would have them."""
    folder.mkdir(parents=True, exist_ok=True)
    write_log(folder / "log.csv", case.machine, case.main, case.main_run, case.factors)
    write_log(folder / "confirm.csv", case.machine, case.confirm, case.confirm_run, case.factors)
    (folder / "model.toml").write_text(tomli_w.dumps(case.machine.model))


def write_log(path: Path, machine: Machine, plan: Plan, run: Run, factors: Mapping[str, float] | None = None) -> None:
    """Write a log as CSV: twelve digits, reference columns where the machine's log has them, in units by `factors`."""
    names = ["time", "position", "command"]
    columns = [plan.stamps, run.reading, run.command]
    if machine.reference_columns:
        names += ["reference", "reference_velocity", "reference_acceleration"]
        columns += [*plan.rows[:, :3].T]
    scaled = [(factors or {}).get(name, 1.0) * column for name, column in zip(names, columns, strict=True)]
    np.savetxt(path, np.transpose(scaled), "%.12g", ",", header=",".join(names), comments="")
