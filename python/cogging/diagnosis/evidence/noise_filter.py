"""Whitening: an autoregressive filter, and a gain over frequency for what it leaves."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cogging._core import whiten
from cogging.arrays import FloatArray
from cogging.diagnosis.thresholds import DISTRIBUTION, SCORE_TEST, WHITENING
from cogging.estimation.innovations import Innovations


@dataclass(frozen=True)
class Filter:
    """What makes one log's residual white: an autoregressive filter, then a gain over frequency for what it left.

    Attributes:
        coefficients: coefficients of the autoregressive filter.
        rms: rms of its output, V, by which that is divided.
        frequency: frequencies at which the spectrum of the divided output is known, Hz, increasing.
        level: that spectrum; 1 is white.
    """

    coefficients: FloatArray
    rms: float
    frequency: FloatArray
    level: FloatArray
    _gains: dict[tuple[int, float], FloatArray] = field(default_factory=dict, compare=False, repr=False)

    def gain(self, length: int, sample_time: float) -> FloatArray:
        """Gain level^(-1/2) of each line of a transform of so many rows, (length // 2 + 1,); made once of each length.

        Args:
            length: rows of the transform.
            sample_time: of the rows, s.
        """
        key = (length, sample_time)
        if key not in self._gains:
            frequency = np.fft.rfftfreq(length, sample_time)
            self._gains[key] = 1.0 / np.sqrt(np.interp(frequency, self.frequency, self.level))
        return self._gains[key]


def filtered(table: FloatArray, source: Innovations, filter_: Filter) -> FloatArray:
    """Rows (p, n), V, made white; rows that do not count are taken as 0 between the two filters."""
    white, weight = np.empty(table.shape), source.mask / filter_.rms
    for rows in together(len(table)):
        part = np.asarray(whiten(table[rows], list(filter_.coefficients)))
        part *= weight
        white[rows] = _coloured(part, source, filter_)
    return white


def coloured(white: FloatArray, source: Innovations, filter_: Filter) -> FloatArray:
    """The second filter alone: gain level^(-1/2) over frequency, without phase."""
    result = np.empty(white.shape)
    for rows in together(len(white)):
        result[rows] = _coloured(white[rows], source, filter_)
    return result


def together(rows: int) -> list[slice]:
    """Rows that are filtered at once: so few that they stay close to the processor."""
    step = SCORE_TEST.columns_together
    return [slice(first, min(first + step, rows)) for first in range(0, rows, step)]


def _coloured(white: FloatArray, source: Innovations, filter_: Filter) -> FloatArray:
    from scipy.fft import irfft, rfft  # several rows abreast, which numpy does in one direction only

    n = white.shape[1]
    length = periodogram_length(n + n // 8)  # what runs over the end comes back into the padding
    spectrum = rfft(white, length, axis=1)
    spectrum *= filter_.gain(length, source.scales.sample_time)
    return np.asarray(irfft(spectrum, length, axis=1, overwrite_x=True)[:, :n])


def periodogram_length(rows: int) -> int:
    """The next length 2^k 3^a 5^b with a, b <= 3: quick to transform.

    scipy.fft.next_fast_len knows more such lengths. Where its are others, the lines of the spectrum move, the noise is
    told from others, and ln p of a finding by some per cent: it may take this one's place only where that is looked at.
    """
    best = 1 << rows.bit_length()
    for five in (1, 5, 25, 125):
        for three in (1, 3, 9, 27):
            factor = five * three
            two = 1 << max(0, (-(-rows // factor) - 1).bit_length())
            if factor * two >= rows:
                best = min(best, factor * two)
    return best


def periodogram(white: FloatArray, source: Innovations) -> tuple[FloatArray, FloatArray]:
    """Power, 1 where the rows that count are white with rms 1, and its frequencies, Hz."""
    length = periodogram_length(len(white))
    power = np.abs(np.fft.rfft(white, length)) ** 2 / max(float(source.mask.sum()), 1.0)
    return np.asarray(power), np.asarray(np.fft.rfftfreq(length, source.scales.sample_time))


def bands(frequency: FloatArray) -> list[slice]:
    """Lines of a periodogram in bands of a third of an octave, each of some lines; the constant stands apart."""
    parts, first = [], 1
    while first < len(frequency):
        last = min(
            len(frequency),
            max(first + WHITENING.band_lines, int(np.searchsorted(frequency, WHITENING.band_ratio * frequency[first]))),
        )
        if len(frequency) - last < WHITENING.band_lines:
            last = len(frequency)
        parts.append(slice(first, last))
        first = last
    return parts


def spectrum(white: FloatArray, source: Innovations) -> tuple[FloatArray, FloatArray]:
    """Frequencies and levels of the power in bands: medians, since lines are signal."""
    power, frequency = periodogram(white, source)
    parts = bands(frequency)
    places = [float(np.sqrt(frequency[part.start] * frequency[part.stop - 1])) for part in parts]
    levels = [float(np.median(power[part]) / np.log(2.0)) for part in parts]
    return np.array(places), np.maximum(np.array(levels), WHITENING.band_level_min)


def robust_rms(values: FloatArray) -> float:
    """Rms with outliers cut, as the median size tells them."""
    limit = WHITENING.outlier * DISTRIBUTION.normal_median * float(np.median(np.abs(values)))
    rms = float(np.sqrt(np.mean(np.clip(values, -limit, limit) ** 2))) if limit > 0 else float(values.std())
    return rms if rms > 0.0 else 1.0
