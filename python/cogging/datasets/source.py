"""Origin and location of a public data set."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from cogging.files import InputError
from cogging.shown import not_one_of, one_line

VARIABLE = "COGGING_DATA"  # the environment variable that names the folder of all sets


@dataclass(frozen=True)
class Source:
    """A public data set."""

    name: str  # of the set, and of its folder within the folder of all sets
    origin: str  # where it is published
    licence: str  # of the publication
    places: tuple[str, ...] = (".",)  # subfolders in which its files may be, as at the origin or in a flat copy

    def folders(self, folder: str | os.PathLike[str] | None = None) -> list[Path]:
        """Return the folders to search: `folder` or that of COGGING_DATA, and the subfolder with the set's name."""
        named = folder if folder is not None else os.environ.get(VARIABLE) or None
        if named is None:
            return []
        base = Path(named).expanduser()
        return [base, base / self.name]

    def candidates(self, file: str, folder: str | os.PathLike[str] | None = None) -> list[Path]:
        """Return the possible paths of a file or folder of the set, best first."""
        return [base / place / file for base in self.folders(folder) for place in self.places]

    def find(self, file: str, folder: str | os.PathLike[str] | None = None) -> Path:
        """Return the path of a file of the set, searched in `folder` or that of COGGING_DATA."""
        for path in self.candidates(file, folder):
            if path.is_file():
                return path
        raise self.absent(file, self.folders(folder))

    @staticmethod
    def require_name(name: str, names: Iterable[str]) -> None:
        """Raise ValueError for a name that is not one of some."""
        if name not in (known := list(names)):
            raise ValueError(f"name: {not_one_of(name, known)}")

    def absent(self, file: str, looked: Iterable[Path], also: str = "") -> InputError:
        """Return the error for a missing file: where it was searched, where to get it, and the licence."""
        folders = " or ".join(map(str, looked))
        missing = f"must be in {folders}, is not" if folders else f"needs folder=..., or {VARIABLE} in the environment"
        return InputError(one_line(f"{self.name}: {file}: {missing}; public at {self.origin} ({self.licence}){also}"))
