"""Columns of effects with a memory, kept from one scan of the same logs to the next."""

from __future__ import annotations

from collections.abc import Callable

from cogging.arrays import FloatArray
from cogging.diagnosis.thresholds import SCORE_TEST

Key = tuple[str, ...]


class ColumnMemory:
    """Columns by log, effect and shape, as predicted under the model under which each was first asked for.

    Those that are slow to predict are kept themselves; of the others so many as take SCORE_TEST.bytes_kept, and of the
    rest what makes them again, to the same bits.
    """

    def __init__(self) -> None:
        self._kept: dict[Key, FloatArray] = {}
        self._again: dict[Key, Callable[[], FloatArray]] = {}
        self._bytes = 0

    def __contains__(self, key: Key) -> bool:
        return key in self._kept or key in self._again

    def table(self, key: Key) -> FloatArray:
        """The columns, (p, n), V per unit; a KeyError where they were never kept."""
        return self._kept[key] if key in self._kept else self._again[key]()

    def keep(self, key: Key, table: FloatArray, again: Callable[[], FloatArray] | None) -> None:
        """Keep columns, or what makes them `again`, where that is quick."""
        if again is not None and self._bytes + table.nbytes > SCORE_TEST.bytes_kept:
            self._again[key] = again
            return
        self._kept[key] = table
        self._bytes += table.nbytes if again is not None else 0

    def clear(self) -> None:
        """Forget all."""
        self._kept.clear()
        self._again.clear()
        self._bytes = 0
