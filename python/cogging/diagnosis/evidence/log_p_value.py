"""Tails of the chi-square and normal distributions, in logarithms: significance goes far beyond what a double holds."""

from __future__ import annotations

import math

import numpy as np


def log_survival(statistic: float, freedom: int) -> float:
    """ln P(chi-square with `freedom` degrees of freedom > statistic), by the finite sums for even and odd numbers.

    scipy.stats.chi2.logsf is the logarithm of what a double holds: -inf from a statistic of some 1490 on.
    """
    if statistic <= 0.0:
        return 0.0
    half = 0.5 * statistic
    terms = []
    if freedom % 2:
        from scipy.special import log_ndtr

        terms.append(math.log(2.0) + float(log_ndtr(-math.sqrt(statistic))))
    for i in range(freedom // 2):
        power = i + 0.5 * (freedom % 2)
        terms.append(power * math.log(half) - math.lgamma(power + 1.0) - half)
    return min(0.0, float(np.logaddexp.reduce(terms)))


def log_choices(pool: float, count: int) -> float:
    """ln of the number of ways to choose `count` among `pool`, which need not be whole."""
    return math.lgamma(pool + 1.0) - math.lgamma(count + 1.0) - math.lgamma(max(pool - count, 0.0) + 1.0)
