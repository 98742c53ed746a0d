"""A score test, and the geometry of rows that it rests on."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cogging.arrays import FloatArray
from cogging.diagnosis.thresholds import SCORE_TEST


class Explained:
    """What a test's columns explain of the residual, (n,), made where it is first asked for: most never are.

    Args:
        make: makes it; what it holds is let go with it.
    """

    def __init__(self, make: Callable[[], FloatArray]) -> None:
        self._make: Callable[[], FloatArray] | None = make
        self._row: FloatArray | None = None

    def row(self) -> FloatArray:
        """The row; threads that ask at once may each make it."""
        make, row = self._make, self._row  # in this order: who made it sets the row first
        if row is None:
            assert make is not None
            row = self._row = make()
            self._make = None
        return row

    def made_by(self, make: Callable[[], FloatArray]) -> None:
        """Make it in another way if it is ever asked for, so that what it was to be made from is let go."""
        if self._row is None:
            self._make = make


@dataclass(frozen=True)
class ScoreTest:
    """A score test.

    Attributes:
        statistic: T = s' G^-1 s / overdispersion, with the score s and the Gram matrix G of the columns, both freed of
            what the free parameters explain; chi-square with `freedom` degrees of freedom where there is no effect.
        freedom: degrees of freedom p.
        amplitudes: factors G^-1 s of the columns that fit the residual best, (p,), with its sign.
        part: of the whitened residual, what the columns explain, (n,), or what makes that (see `explained`).
        deviations: 1-sigma of each amplitude beside the others, (p,); infinite where nothing is seen of it.
    """

    statistic: float
    freedom: int
    amplitudes: FloatArray
    part: FloatArray | Explained
    deviations: FloatArray

    @property
    def explained(self) -> FloatArray:
        """Part of the whitened residual that the columns explain, (n,)."""
        return self.part.row() if isinstance(self.part, Explained) else self.part


def groups(sizes: Sequence[int], together: int) -> Iterator[tuple[int, int]]:
    """First and last number (excluded) of neighbours that sum up to `together` or more, the last fewer."""
    first, total = 0, 0
    for i, size in enumerate(sizes):
        total += size
        if total >= together or i + 1 == len(sizes):
            yield first, i + 1
            first, total = i + 1, 0


def cosine(one: FloatArray, other: FloatArray) -> float:
    """Cosine between two rows, without sign."""
    size = float(np.sqrt((one @ one) * (other @ other)))
    return abs(float(one @ other)) / size if size > 0.0 else 0.0


def orthonormal(columns: FloatArray) -> FloatArray:
    """An orthonormal basis (q, n) of rows (p, n), directions lost to rounding left out."""
    if len(columns) == 0:
        return columns
    size = np.sqrt(np.einsum("ij,ij->i", columns, columns))
    rows = columns / size[:, None] if size.all() else columns[size > 0.0] / size[size > 0.0, None]
    values, vectors = np.linalg.eigh(rows @ rows.T)
    good = values > SCORE_TEST.basis_rank * max(values[-1], 1e-300)
    return np.asarray((vectors[:, good] / np.sqrt(values[good])).T @ rows)
