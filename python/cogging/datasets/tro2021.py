"""TRO2021: a lead-screw drive at 32 constant speeds and in two start-stop runs, text files of the drive's software.

Source: A. Mablekos-Alexiou, L. da Cruz, C. Bergeles, IEEE Transactions on Robotics 37(4), 2021;
github.com/RViMLab/TRO2021-Dynamic-Modelling. Licence: MIT.

Speed is in rpm, torque in % of nominal; there is no position. `files` finds the first drive of the repository; `read`
reads a file of any.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cogging.arrays import FloatArray
from cogging.datasets.source import Source
from cogging.files import InputError, read_text
from cogging.shown import quoted

LICENCE = "MIT; cite Mablekos-Alexiou, da Cruz and Bergeles 2021"
PLACES = ("experiments/driveNo1", "driveNo1", ".")
SOURCE = Source("tro2021", "github.com/RViMLab/TRO2021-Dynamic-Modelling", LICENCE, PLACES)
SETTLING = 20  # rows at the start of a constant-speed run that its mean omits


class Run(NamedTuple):
    """A run of the drive."""

    time: FloatArray  # s, (n,)
    speed: FloatArray  # rpm, averaged by the drive, (n,)
    torque: FloatArray  # % of the nominal torque, averaged by the drive, (n,)


class SteadySpeeds(NamedTuple):
    """Means of constant-speed runs, in the order of the files' names."""

    speed: FloatArray  # rpm, (n,), 16 each way in the whole set
    torque: FloatArray  # % of the nominal torque, (n,)


def files(folder: str | os.PathLike[str] | None = None) -> dict[str, Path]:
    """Return the paths of the runs: `steady_state/0.096kg/20`, `.../n20` the other way, `start_stop/200`.

    Args:
        folder: of the data (see cogging.datasets): a clone of the repository, or its `driveNo1`.

    Raises:
        InputError: no file was found; names source and licence.
    """
    for root in SOURCE.candidates("", folder):
        paths = sorted((*root.glob("steady_state/*/*.csv"), *root.glob("start_stop/*.csv")))
        if paths:
            return {path.relative_to(root).with_suffix("").as_posix(): path for path in paths}
    raise SOURCE.absent("steady_state/*/*.csv", SOURCE.folders(folder))


def read(path: str | os.PathLike[str]) -> Run:
    """Read one run, without rows that have no values.

    Args:
        path: of a file, as `files` gives it.

    Raises:
        InputError: the file is invalid; names the row.
    """
    lines = read_text(path).splitlines()
    start = next((number for number, line in enumerate(lines, start=1) if line.startswith("ms;")), 0)
    if not start:
        raise InputError(f"{path}: must have a row of units that begins with `ms;`, got none")
    rows = []
    for number, line in enumerate(lines[start:], start=start + 1):
        cells = line.split(";")[:3]
        if len(cells) < 3 or not all(cells):
            continue
        try:
            rows.append([float(cell) for cell in cells])
        except ValueError:
            rows.append([np.nan])
        if not np.isfinite(rows[-1]).all():
            raise InputError(f"{path}: line {number}: must be three finite numbers, got {quoted(line)}")
    if not rows:
        raise InputError(f"{path}: rows: must be at least 1, got 0")
    time, speed, torque = np.array(rows).T
    return Run(1e-3 * time, speed, torque)


def steady_speeds(folder: str | os.PathLike[str] | None = None) -> SteadySpeeds:
    """Average every constant-speed run after its first SETTLING rows.

    Args:
        folder: see `files`.

    Raises:
        InputError: no run was found, or one is invalid or too short.
    """
    means = []
    for path in (path for name, path in files(folder).items() if name.startswith("steady_state/")):
        run = read(path)
        if len(run.time) <= SETTLING:
            raise InputError(f"{path}: rows: must be more than {SETTLING}, got {len(run.time)}")
        means.append((run.speed[SETTLING:].mean(), run.torque[SETTLING:].mean()))
    if not means:
        raise SOURCE.absent("steady_state/*/*.csv", SOURCE.folders(folder))
    speed, torque = np.array(means).T
    return SteadySpeeds(speed, torque)
