"""Tails of the chi-square and normal distributions, in logarithms: significance goes far beyond what a double holds."""

from __future__ import annotations

import math


def log_survival(statistic: float, freedom: int) -> float:
    """ln P(chi-square with `freedom` degrees of freedom > statistic), by the finite sums for even and odd numbers."""
    if statistic <= 0.0:
        return 0.0
    half = 0.5 * statistic
    if freedom % 2 == 0:
        terms = [i * math.log(half) - math.lgamma(i + 1.0) for i in range(freedom // 2)]
        return min(0.0, -half + _log_sum(terms))
    start = _log_erfc(math.sqrt(half))
    terms = [(i + 0.5) * math.log(half) - math.lgamma(i + 1.5) - half for i in range((freedom - 1) // 2)]
    return min(0.0, _log_sum([start, *terms]))


def log_choices(pool: float, count: int) -> float:
    """ln of the number of ways to choose `count` among `pool`, which need not be whole."""
    return math.lgamma(pool + 1.0) - math.lgamma(count + 1.0) - math.lgamma(max(pool - count, 0.0) + 1.0)


def _log_erfc(x: float) -> float:
    if x < 20.0:
        return math.log(math.erfc(x))
    return -x * x - math.log(x * math.sqrt(math.pi)) + math.log1p(-0.5 / (x * x))


def _log_sum(terms: list[float]) -> float:
    top = max(terms)
    return top + math.log(sum(math.exp(t - top) for t in terms))
