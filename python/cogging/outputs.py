"""What a call may write: never what it reads, and nothing twice."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterable, Mapping
from pathlib import Path

from cogging.files import InputError, same_file, target_of

AnyPath = str | os.PathLike[str]


def check_outputs(outputs: Mapping[str, AnyPath | None], inputs: Iterable[AnyPath] = ()) -> None:
    """Refuse what would destroy an input or another output, before anything is computed.

    Args:
        outputs: files that the call writes, by what asks for them (`--out`); None where nothing does.
        inputs: files that it reads, those that may stand beside them included (with_sidecars).

    Raises:
        InputError: an output is an input by whatever name, or another output, or cannot be written.
    """
    given = {name: path for name, path in outputs.items() if path is not None}
    read = list(inputs)
    for name, path in given.items():
        for other in read:
            if same_file(path, other):
                raise InputError(f"{name}: {path}: must not be a file that is read, got {os.fspath(other)}")
    for (name, path), (second, other) in itertools.combinations(given.items(), 2):
        if same_file(path, other):
            raise InputError(f"{name}, {second}: must be different files, got one twice")
    for path in given.values():
        target_of(path)


def check_folder(path: AnyPath) -> None:
    """Refuse a folder for results that is none and cannot be made, before anything is computed.

    Raises:
        InputError: a file stands there or on the way there, or nothing may be written there.
    """
    place = Path(os.path.realpath(path))
    while not place.exists() and place != place.parent:
        place = place.parent
    if not place.is_dir():
        raise InputError(f"{path}: cannot be made: {place} is no folder")
    if not os.access(place, os.W_OK):
        raise InputError(f"{path}: cannot be made: Permission denied")


def sidecar(log: AnyPath) -> str:
    """The file beside a log in which stands what a table of numbers cannot hold."""
    return f"{os.fspath(log)}.toml"


def with_sidecars(logs: Iterable[AnyPath]) -> list[AnyPath]:
    """Logs and what may stand beside them."""
    return [path for log in logs for path in (log, sidecar(log))]
