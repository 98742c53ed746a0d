"""How alike two rows are at every shift."""

from __future__ import annotations

import numpy as np

from cogging.arrays import FloatArray


def cross_correlation(row: FloatArray, other: FloatArray) -> FloatArray:
    """sum_k row_(k + lag) other_k for every lag from 1 - len(other) to len(row) - 1, by Fourier transforms.

    As scipy.signal.correlate gives it; to load that package takes longer than all that is correlated here.

    Args:
        row: (n,).
        other: (m,).

    Returns:
        (n + m - 1,), the lag 0 at place m - 1.

    Example:
        >>> from cogging.correlation import cross_correlation
        >>> alike = cross_correlation(np.array([0.0, 1.0, 2.0, 0.0]), np.array([1.0, 2.0]))
        >>> int(np.argmax(alike)) - 1
        1
    """
    from scipy.fft import irfft, next_fast_len, rfft

    length = len(row) + len(other) - 1
    padded = next_fast_len(length, real=True)
    return np.asarray(irfft(rfft(row, padded) * rfft(other[::-1], padded), padded)[:length])
