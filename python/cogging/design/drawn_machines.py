"""Machines that a model with intervals may stand for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cogging.arrays import FloatArray, real_array
from cogging.model.intervals import SIGMAS_95, Interval, Intervals
from cogging.model.model import Model
from cogging.model.parameters import with_values
from cogging.resources import require_machines

DRAWS_MAX = 1000  # of one machine, until its values are valid


class DrawnMachine(NamedTuple):
    """A machine, the seed of its noise, and the parameters that were drawn, by path."""

    model: Model
    seed: int
    values: dict[str, float]


def drawn_machines(
    intervals: Intervals, samples: int, seed: int, covariance: tuple[Sequence[str], npt.ArrayLike] | None = None
) -> list[tuple[Model, int]]:
    """Draw machines from the intervals of a model, each with the seed of its noise (see drawn_samples)."""
    return [(drawn.model, drawn.seed) for drawn in drawn_samples(intervals, samples, seed, covariance)]


def drawn_samples(
    intervals: Intervals, samples: int, seed: int, covariance: tuple[Sequence[str], npt.ArrayLike] | None = None
) -> list[DrawnMachine]:
    """Draw machines from the intervals of a model, and keep what was drawn.

    Each parameter is normal around the model's value, jointly where a covariance is given; a machine with a value that
    breaks its field's rule is drawn anew. Machine i is the same however many are drawn.

    Args:
        intervals: of the model; a parameter without one is held.
        samples: how many.
        seed: of the draws.
        covariance: paths (p) and covariance (p, p), in place of their intervals.

    Raises:
        ValueError: an infinite interval, a covariance that is none, or intervals that hold hardly a valid machine.
    """
    model = intervals.model
    joint, root = covariance_root(covariance or ((), np.empty((0, 0))), intervals.paths)
    alone = {path: intervals.of(path) for path in intervals.paths if path not in joint}
    spread = {path: interval for path, interval in alone.items() if interval is not None and interval[0] < interval[1]}
    require_machines("samples", samples, len(joint) + len(spread))
    machines = []
    for place in range(samples):
        numbers = np.random.default_rng([seed, place])
        noise_seed = int(numbers.integers(2**63))
        for _ in range(DRAWS_MAX):
            normals = numbers.standard_normal(len(joint) + len(spread))
            values = dict(zip(joint, root @ normals[: len(joint)], strict=True))
            values = {path: intervals.value(path) + float(change) for path, change in values.items()}
            for (path, interval), normal in zip(spread.items(), normals[len(joint) :], strict=True):
                values[path] = draw(intervals.value(path), interval, float(normal))
            try:
                machines.append(DrawnMachine(with_values(model, values), noise_seed, values))
                break
            except ValueError as error:
                reason = error
        else:
            raise ValueError(f"bounds: {DRAWS_MAX} draws gave no valid machine; the last: {reason}")
    return machines


def draw(value: float, interval: Interval, normal: float) -> float:
    """A value by its standard normal number: median `value`, 95 % in the interval, a normal shape on either side."""
    side = interval[1] - value if normal > 0 else value - interval[0]
    return value + normal * side / SIGMAS_95


def covariance_root(
    covariance: tuple[Sequence[str], npt.ArrayLike], paths: tuple[str, ...]
) -> tuple[list[str], FloatArray]:
    """The paths and a matrix R with R R^T the covariance.

    Raises:
        ValueError: a path that the model has not or twice, a matrix that is not finite, (p, p), symmetric and without
            negative eigenvalues.
    """
    names, matrix = list(covariance[0]), real_array("covariance", covariance[1])
    for name in names:
        if name not in paths:
            raise ValueError(f"covariance: {name!r} must be a parameter of the model")
    if len(set(names)) != len(names):
        raise ValueError("covariance: each path must be given once")
    if matrix.shape != (len(names), len(names)) or not np.isfinite(matrix).all():
        raise ValueError(f"covariance: must be finite, ({len(names)}, {len(names)}), got {matrix.shape}")
    # Variances of different units stand side by side: judged as correlations.
    scale = np.sqrt(np.where(np.diag(matrix) > 0, np.diag(matrix), 1.0))
    correlation = matrix / np.outer(scale, scale)
    if np.abs(correlation - correlation.T).max(initial=0.0) > 1e-6:
        raise ValueError("covariance: must be symmetric")
    values, vectors = np.linalg.eigh((correlation + correlation.T) / 2)
    if values.min(initial=0.0) < -1e-6 * len(names):
        raise ValueError(f"covariance: must have no negative eigenvalue, got {values.min():.3g} of the correlation")
    root: FloatArray = scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    return names, root
