"""Fits positive quantities of a simulated setup to published numbers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cogging.arrays import FloatArray


def fit_logarithms(
    gap: Callable[[FloatArray], FloatArray],
    start: FloatArray,
    *,
    step: float,
    tolerance: float = 0.0,
    iterations: int = 12,
) -> tuple[FloatArray, FloatArray]:
    """Find positive values x that make gap(x) small, in the least-squares sense.

    Each iteration differentiates by steps of `step` in log x, long enough to stand above the roughness that quantiser
    and noise give the gap, and halves its move until the sum of squares falls.

    scipy.optimize.least_squares ends elsewhere in that roughness and has no end at a largest entry: the calibrations
    that are shipped, to four digits, would be others (malaize2009, ironless: 0.01631 V for 0.01635 V).

    Args:
        gap: log-ratios simulated / published, (m,), of values (n,).
        start: where the search begins, (n,), all above 0.
        step: of the differences, in log x.
        tolerance: largest entry of the gap at which the search is over.
        iterations: at most.

    Returns:
        The values (n,) and their gap (m,).
    """
    x = np.log(start)
    y = gap(np.exp(x))
    damping = 1e-3
    for _ in range(iterations):
        if np.abs(y).max() < tolerance:
            break
        jacobian = np.column_stack([(gap(np.exp(x + move)) - y) / step for move in step * np.eye(x.size)])
        normal = jacobian.T @ jacobian + damping * np.eye(x.size)
        move = np.clip(np.linalg.solve(normal, -jacobian.T @ y), -0.7, 0.7)
        for fraction in (1.0, 0.5, 0.25, 0.125):
            candidate = gap(np.exp(x + fraction * move))
            if candidate @ candidate < y @ y:
                x, y = x + fraction * move, candidate
                damping = max(damping / 3.0, 1e-4)
                break
        else:
            if damping > 10.0:
                break
            damping *= 10.0
    return np.exp(x), y


def round_to_digits(value: float, digits: int = 4) -> float:
    """The value with so many significant digits, as a file keeps it."""
    return float(f"{value:.{digits}g}")
