"""The chance that a search accepts an effect that is there, by the rules of choice and confirmation."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from cogging.arrays import FloatArray
from cogging.diagnosis.thresholds import CHANCE, CHOICE, CONFIRMATION, SEARCH


def _equally_likely(count: int) -> FloatArray:
    """Equally likely values of a normal variable."""
    normal = NormalDist()
    return np.array([normal.inv_cdf((i + 0.5) / count) for i in range(count)])


def _of_deviation_one(values: FloatArray) -> FloatArray:
    return np.asarray(values / np.sqrt(np.mean(values**2)))


NORMAL = _equally_likely(CHANCE.noise_values)
NOISE = _of_deviation_one(_equally_likely(CHANCE.level_values))  # of the level of the noise
GRID = np.geomspace(*CHANCE.statistics)  # of T
LAMBDAS = np.geomspace(*CHANCE.lambdas)  # at which the chance is computed


@dataclass(frozen=True)
class Powers:
    """Least T that is worth a name: on these logs, and on the other motion."""

    own: float
    other: float


@dataclass(frozen=True)
class Visibility:
    """How well the logs see an effect of one shape.

    Attributes:
        trials: number of independent shapes that a scan tries.
        freedom: degrees of freedom p of its T.
        spread: deviation of ln T from one log to the next, as far as the level of the noise is told from few lines.
        spread_there: the same of the other motion.
        bounded: T at each of GRID, allowed for levels of noise that are known from few lines (Evidence.bounded).
        other: noncentrality that the other motion has for each of these logs'; None without other motion.
        least: T below which it is too small to be told from rounding.
        needed: log p-value that it needs where the other motion cannot show it.
        once: whether it need not happen again on the other motion.
    """

    trials: float
    freedom: int
    spread: float
    spread_there: float
    bounded: FloatArray
    other: float | None
    least: float
    needed: float
    once: bool


def chances(one: Visibility, worth: Powers) -> FloatArray:
    """The chance that an effect is accepted, at each noncentrality of LAMBDAS, (28,).

    T = ((sqrt(lambda) + z)^2 + w) exp(spread e): z and e normal, w chi-square with p - 1 degrees of freedom. The
    amplitudes that were found are frozen; of the noncentrality that they promise, lambda_other / lambda of T, the other
    motion shows the ratio (lambda + sqrt(lambda) z) / T, with the deviation that its noise gives it. The level of that
    noise too is told from few lines: the promise is taken for larger or smaller than it is.
    """
    from scipy.special import chdtrc, chdtri, ndtr

    root, z = np.sqrt(LAMBDAS)[:, None, None, None, None], NORMAL[:, None, None, None]
    w = (chdtri(one.freedom - 1, np.array(CHANCE.other_chances)) if one.freedom > 1 else np.zeros(1))[:, None, None]
    statistic = (root + z) ** 2 + w
    louder = statistic * np.exp(_levels(one.spread))[:, None]
    levels = np.minimum(np.log(np.maximum(chdtrc(one.freedom, one.bounded), 1e-300)) + np.log(one.trials), 0.0)
    shown, level = np.interp(louder, GRID, one.bounded), np.interp(louder, GRID, levels)
    strong = (level <= CHOICE.detected) & (shown >= worth.own) & (statistic >= one.least)
    if one.other is None:
        return np.asarray(strong.mean(axis=(1, 2, 3, 4)))
    mean, deviation = (root**2 + root * z) / statistic, 1.0 / np.sqrt(np.maximum(statistic * one.other, 1e-12))
    promised = np.exp(_levels(one.spread_there)) / deviation**2
    allowed = np.hypot(1.0 / np.sqrt(promised), CONFIRMATION.amplitude_error)
    low = np.maximum(CHANCE.ratio_gains, 1.0 - CONFIRMATION.less_refutes * allowed)
    together = np.sqrt(np.maximum(_needed_there(level), worth.other) / promised)
    hinted = (level > CHOICE.detected) & (level <= SEARCH.hinted) & (statistic >= one.least)
    low = np.where(strong, low, np.where(hinted, np.maximum(low, together), np.inf))
    confirmed = np.maximum(
        ndtr((mean - low) / deviation) - ndtr((mean - 1.0 - CONFIRMATION.more_refutes * allowed) / deviation), 0.0
    )
    alone = strong & (level <= one.needed)
    answer = np.where(promised >= CONFIRMATION.informative, confirmed + (1.0 - confirmed) * (alone & one.once), alone)
    return np.asarray(answer.mean(axis=(1, 2, 3, 4)))


def _levels(spread: float) -> FloatArray:
    """Equally likely logarithms of the level of the noise."""
    return spread * NOISE if spread > CHANCE.level_firm else np.zeros(1)


def _needed_there(level: FloatArray) -> FloatArray:
    """T, of one degree of freedom and one sign, that the other motion must show beside a log p-value on these."""
    from scipy.special import ndtri

    wanted = np.minimum(CHOICE.joint - level, np.log(0.5))
    return np.asarray(ndtri(np.exp(wanted)) ** 2)
