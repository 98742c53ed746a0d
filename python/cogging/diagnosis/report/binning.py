"""What the figures draw of held rows: bins with bands, spectra, traces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from cogging.arrays import FloatArray, Mask
from cogging.estimation.statistics import moving_average
from cogging.model.intervals import SIGMAS_95

Series = Mapping[str, Sequence[FloatArray]]
BLOCK = 0.25  # s: closer rows say much the same; bands are computed from blocks
EDGES, QUANTILES, EVEN = 41, 33, 17  # of bins in position and time; elsewhere by rows, and of equal width beside them
NARROWEST = 1e-2  # of the whole range: no bin is narrower
ROWS = 20  # of a bin: the mean of fewer is noise
TRACE = 0.01  # s over which traces are averaged


def rows_of(series: Series, name: str, direction: float = 0.0) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Values of a coordinate, gap and block of the rows that count, of all logs."""
    values, gaps, blocks = [], [], []
    offset = 0.0
    for i, gap in enumerate(series["gap"]):
        kept = np.asarray(series["mask"][i]) > 0
        if direction:
            kept = kept & (direction * np.asarray(series["velocity"][i]) > 0.0)
        block = np.floor((series["time"][i] - series["time"][i][0]) / BLOCK)
        values.append(np.asarray(series[name][i])[kept])
        gaps.append(np.asarray(gap)[kept])
        blocks.append(block[kept] + offset)
        offset += float(block[-1]) + 1.0
    return np.concatenate(values), np.concatenate(gaps), np.concatenate(blocks)


def bins_of(values: FloatArray, name: str) -> FloatArray:
    """Edges of bins: of equal width in position and time, denser where there are more rows elsewhere."""
    if name in ("position", "time"):
        return np.linspace(float(values.min()), float(values.max()), EDGES)
    low, high = float(values.min()), float(values.max())
    both = np.union1d(np.quantile(values, np.linspace(0.0, 1.0, QUANTILES)), np.linspace(low, high, EVEN))
    kept = [low]  # cruising fills many quantiles with one value: no bin is narrower than one percent
    for edge in both[1:]:
        if edge - kept[-1] > NARROWEST * (high - low):
            kept.append(float(edge))
    return np.array(kept) if len(kept) > 2 else np.linspace(low, high, 4)


def binned(
    values: FloatArray, gap: FloatArray, block: FloatArray, edges: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Places, means and half widths of 95 % intervals in bins; rows of one block count as one observation."""
    count = len(edges) - 1
    place = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, count - 1)
    blocks, block_of = np.unique(block, return_inverse=True)
    cell = place * len(blocks) + block_of
    rows = np.bincount(cell, minlength=count * len(blocks)).reshape(count, -1).astype(float)
    sums = np.bincount(cell, gap, count * len(blocks)).reshape(count, -1)
    total = rows.sum(axis=1)
    middle = np.bincount(place, values, count)
    kept = total >= ROWS  # the mean of fewer rows is noise
    total, rows, sums, middle = total[kept], rows[kept], sums[kept], middle[kept] / total[kept]
    mean = sums.sum(axis=1) / total
    seen = (rows > 0).sum(axis=1)
    spread = ((sums - mean[:, None] * rows) ** 2).sum(axis=1) / total**2
    half = SIGMAS_95 * np.sqrt(spread * np.where(seen > 1, seen / np.maximum(seen - 1.0, 1.0), np.nan))
    return middle, mean, half


def spectrum(time: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Frequencies and amplitude density (per √Hz), averaged over half-overlapping Hann windows of an eighth."""
    step = float(np.median(np.diff(time)))
    length = max(256, 2 * (len(values) // 16))
    length = min(length, len(values))
    window = np.hanning(length)
    parts = [values[first : first + length] for first in range(0, len(values) - length + 1, max(1, length // 2))]
    power = np.mean([np.abs(np.fft.rfft(window * (part - part.mean()))) ** 2 for part in parts], axis=0)
    density = np.sqrt(2.0 * power * step / float((window**2).sum()))
    return np.asarray(np.fft.rfftfreq(length, step)[1:]), np.asarray(density[1:])


def smoothed(values: FloatArray, time: FloatArray) -> FloatArray:
    """Running mean over `trace_window`."""
    return moving_average(values, round(TRACE / float(np.median(np.diff(time)))))


def liveliest(gap: FloatArray, mask: Mask, rows: int) -> slice:
    """A stretch of that many rows in the middle of the log in which the axis moves most of the time."""
    moving = np.concatenate([[0], np.cumsum(mask > 0)])
    starts = np.arange(0, max(1, len(gap) - rows), max(1, rows // 4))
    share = moving[np.minimum(starts + rows, len(gap))] - moving[starts]
    good = starts[share >= 0.95 * share.max()]
    first = int(good[len(good) // 2])
    return slice(first, first + rows)


def envelope(time: FloatArray, values: FloatArray, few: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Smallest and largest of every `few` rows, so that a long trace loses no peak; nan where all are nan."""
    if few < 2:
        return time, values, values
    end = len(time) // few * few
    rows = values[:end].reshape(-1, few)
    missing = np.isnan(rows).all(axis=1)
    low = np.where(missing, np.nan, np.min(np.where(np.isnan(rows), np.inf, rows), axis=1))
    high = np.where(missing, np.nan, np.max(np.where(np.isnan(rows), -np.inf, rows), axis=1))
    return time[:end].reshape(-1, few).mean(axis=1), low, high
