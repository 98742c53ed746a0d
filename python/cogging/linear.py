"""Linear least squares in which units do not matter."""

from __future__ import annotations

import numpy as np

from cogging.arrays import FloatArray


def least_squares(columns: FloatArray, row: FloatArray, rcond: float = 1e-12) -> FloatArray:
    """Weights (p,) of columns (p, n) that make a row (n,), of all such the smallest.

    Args:
        columns: are scaled to unit rms first.
        row: what they are to make.
        rcond: directions of the scaled columns with a singular value below this share of the largest weigh nothing.
    """
    matrix = np.ascontiguousarray(columns.T)
    size = np.sqrt(np.mean(matrix**2, axis=0))
    size[size == 0.0] = 1.0
    return np.asarray(np.linalg.lstsq(matrix / size, row, rcond=rcond)[0] / size)


def least_squares_of_long_rows(columns: FloatArray, row: FloatArray, rcond: float = 1e-10) -> FloatArray:
    """The same by the normal equations: a quarter of the time where rows are long and columns few.

    They square the condition of the columns; `rcond` is a share of the largest eigenvalue, below which a direction of
    the scaled columns weighs nothing: 1e-10 for columns that differ by 1e-5 of their size or more.
    """
    size = row_sizes(columns)
    scaled = columns / size[:, None]
    return solved(scaled @ scaled.T, scaled @ row, rcond) / size


def row_sizes(columns: FloatArray) -> FloatArray:
    """Euclidean length of each row of (p, n), 1 where it is 0, (p,)."""
    size = np.sqrt(np.einsum("ij,ij->i", columns, columns))
    size[size == 0.0] = 1.0
    return np.asarray(size)


def solved(gram: FloatArray, right: FloatArray, rcond: float = 1e-10) -> FloatArray:
    """Weights (p,) from normal equations of rows of length 1: their Gram matrix (p, p), and their products (p,)."""
    return np.asarray(np.linalg.pinv(gram, rcond=rcond, hermitian=True) @ right)
