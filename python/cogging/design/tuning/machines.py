"""The machines that gains are judged on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from cogging.design.drawn_machines import DRAWS_MAX
from cogging.files import FieldError
from cogging.model.intervals import Intervals
from cogging.resources import require_machines
from cogging.simulation.varied import BOUNDS, SEED, Setup, Variation, refuse_unknown_paths, variation_of, with_numbers


class Machine(NamedTuple):
    """A machine with its motion, and the seed of its noise."""

    setup: Setup
    seed: int


def variations_of(setup: Setup, vary: Mapping[str, Any] | str) -> tuple[list[Variation], list[str]]:
    """How the machines differ, and what is to be said of that.

    Raises:
        FieldError: a number that cannot be varied here, or how it is breaks a rule.
        ValueError: a path that the run has not, with the nearest.
    """
    notes = []
    if vary == BOUNDS:
        intervals = Intervals(setup.model)
        vary = {}
        for path in intervals.paths:
            try:
                interval = intervals.of(path)
            except ValueError as error:
                notes.append(f"held: {error}")
                continue
            if interval is not None and interval[0] < interval[1]:
                vary[path] = BOUNDS
        if not vary:
            notes.append("the model has neither [bounds] nor [axis.uncertainty]: the machines differ in noise alone")
    if not isinstance(vary, Mapping):
        raise FieldError("", "vary", f'must be a table of numbers by path, or "bounds", got {vary!r}')
    refuse_unknown_paths(setup, vary)
    for path in vary:
        if path == SEED or path.startswith("controller."):
            rule = "each machine has noise of its own" if path == SEED else "the controller is one for all machines"
            raise FieldError("vary", path, f"must be a number of machine or motion: {rule}")
    return [variation_of(path, how, setup.model) for path, how in vary.items()], notes


def machines_of(setup: Setup, variations: list[Variation], count: int, seed: int, stream: int) -> list[Machine]:
    """Draw machines: a Latin hypercube, values that break a rule drawn anew. The same arguments give the same.

    Args:
        setup: the model as it is.
        variations: of its numbers.
        count: how many.
        seed: of the draws.
        stream: of that seed: machines of different streams are independent.

    Raises:
        ValueError: the distributions hold hardly a valid machine.
    """
    from scipy.stats import qmc

    require_machines("machines", count, len(variations))
    numbers = np.random.default_rng([seed, stream])
    seeds = numbers.integers(2**63, size=count)
    if not variations:
        return [Machine(setup, int(own)) for own in seeds]
    drawn = qmc.LatinHypercube(len(variations), seed=numbers).random(count)
    machines = []
    for shares, own in zip(drawn, seeds, strict=True):
        for _ in range(DRAWS_MAX):
            values = {one.path: float(one.of_shares(shares[[i]])[0]) for i, one in enumerate(variations)}
            try:
                made = with_numbers(setup, values)
                made.model.plant()
                break
            except ValueError as error:
                reason, shares = error, numbers.random(len(variations))
        else:
            raise ValueError(f"vary: {DRAWS_MAX} draws gave no valid machine; the last: {reason}")
        machines.append(Machine(made, int(own)))
    return machines
