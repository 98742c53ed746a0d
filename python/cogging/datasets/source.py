"""Where a public data set comes from, and where its files are looked for."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from cogging.files import InputError
from cogging.shown import one_line

VARIABLE = "COGGING_DATA"  # the environment variable that names the folder of all sets


@dataclass(frozen=True)
class Source:
    """A public data set.

    Attributes:
        name: of the set, and of its folder within the folder of all sets.
        origin: where the public gets it.
        licence: under which it stands there.
        places: folders below that of the set in which its files may lie, as its origin or a flat copy has them.
    """

    name: str
    origin: str
    licence: str
    places: tuple[str, ...] = (".",)

    def folders(self, folder: str | os.PathLike[str] | None = None) -> list[Path]:
        """Where the set is looked for: `folder`, or that of COGGING_DATA, and the one of the set's name within it."""
        named = folder if folder is not None else os.environ.get(VARIABLE) or None
        if named is None:
            return []
        base = Path(named).expanduser()
        return [base, base / self.name]

    def candidates(self, file: str, folder: str | os.PathLike[str] | None = None) -> list[Path]:
        """The paths at which a file, or a folder, of the set may stand, best first."""
        return [base / place / file for base in self.folders(folder) for place in self.places]

    def find(self, file: str, folder: str | os.PathLike[str] | None = None) -> Path:
        """Find a file of the set.

        Args:
            file: its name.
            folder: where the set lies; by default that of COGGING_DATA.

        Returns:
            Its path.
        """
        for path in self.candidates(file, folder):
            if path.is_file():
                return path
        raise self.absent(file, self.folders(folder))

    def absent(self, file: str, looked: Iterable[Path], also: str = "") -> InputError:
        """The error that says what is missing, where it was looked for, and where to get it under which licence."""
        folders = " or ".join(map(str, looked))
        missing = f"must be in {folders}, is not" if folders else f"needs folder=..., or {VARIABLE} in the environment"
        return InputError(one_line(f"{self.name}: {file}: {missing}; public at {self.origin} ({self.licence}){also}"))
