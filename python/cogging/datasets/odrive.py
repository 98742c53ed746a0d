"""ODrive: a direct-drive hobby motor of 12 slots and 7 pole pairs whose current mostly compensates cogging.

Source: G. Chen, github.com/gchenfc/ODrive, branch master, folder `analysis`, 2020. Licence: MIT.

The motor is rotary and its force constant is unknown: the position is in rad and the command is the current, so that a
mass is J/Kt, A/(rad/s^2). The drive was polled every 1.5 to 6 ms. Three of the slow runs begin with a fast return to
the start. The drive reports a smoothed current: `read` inverts the filter.
"""

from __future__ import annotations

import os
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from cogging.arrays import FloatArray
from cogging.datasets.source import Source
from cogging.files import InputError
from cogging.logs.log import Log
from cogging.shown import one_line

PLACES = (".", "analysis/cogging_torque", "analysis/cogging_torque/coggingmap_0")
SOURCE = Source("odrive", "github.com/gchenfc/ODrive", "MIT", PLACES)
COUNTS = 8192  # of a turn
TURN = 2 * np.pi  # rad
#: One slow turn under an undocumented controller, 10 s, and `slower` 33 s; `comp` with the authors' cogging
#: compensation, `nocomp` without.
FILES = (
    *("slow2_nocomp_0", "slow2_nocomp_1", "slow2_nocomp_2", "slow2_comp_0"),
    *("slow2_slower_nocomp_0", "slow2_slower_comp_0"),
)
#: Holding current at successive counts, by file: forward, backward, and forward without the neighbouring motor, which
#: causes most of the harmonic of 7 per turn.
SCANS = MappingProxyType({"forward": "final_a_16", "backward": "final_rev_16", "alone": "final_iso_16"})
#: s, time constant of the reported current: the authors set `I_measured_report_filter_k` to 0.001, with 8,000 samples
#: of the current per second.
SMOOTHING = 0.125
REWIND_SPEED = 6.0  # rad/s: above the jumps between teeth of a slow run, below the return at 30
REWIND_REST = 0.3  # s, settling time after the return


class Scan(NamedTuple):
    """Holding current at rest."""

    position: FloatArray  # rad, (n,)
    current: FloatArray  # A, (n,)


def files(folder: str | os.PathLike[str] | None = None) -> dict[str, Path]:
    """Return the paths of the slow runs and the scans by the names of FILES and SCANS.

    Args:
        folder: of the data (see cogging.datasets): side by side, or as in a clone of the repository.

    Raises:
        InputError: a file is missing; names source and licence.
    """
    return {name: _find(name, folder) for name in (*FILES, *SCANS)}


def read(
    name: str, folder: str | os.PathLike[str] | None = None, *, smoothed: bool = False, rewind: bool = False
) -> Log:
    """Read one of the slow runs: time s, position rad, command A.

    The reported current i lags the actual current u: T di/dt = u - i with T = SMOOTHING. Between two rows dt apart
    u = (i_1 - e i_0) / (1 - e), e = exp(-dt / T), assigned to the first of them; the last row is omitted.

    Args:
        name: one of FILES.
        folder: see `files`.
        smoothed: the current as recorded, delayed by SMOOTHING; fast harmonics of the cogging appear smaller, that of
            28 per turn by a fifth to two thirds.
        rewind: include the return to the start in `slow2_nocomp_1`, `slow2_nocomp_2` and `slow2_slower_comp_0`.

    Raises:
        ValueError: an unknown name.
        InputError: the file is missing or invalid.
    """
    SOURCE.require_name(name, FILES)
    path = _find(name, folder)
    table = _array(path)
    if table.ndim != 2 or table.shape[0] != 3 or table.shape[1] < 3:
        raise InputError(f"{path}: must be three rows of values: time, position, current, got {table.shape}")
    time, counts, current = table
    if np.any(np.diff(time) <= 0.0):
        raise InputError(f"{path}: time: must increase from value to value, does not")
    position = TURN / COUNTS * counts
    if not smoothed:
        kept = np.exp(-np.diff(time) / SMOOTHING)
        time, position, current = time[:-1], position[:-1], (current[1:] - kept * current[:-1]) / (1.0 - kept)
    start, fast = 0, np.flatnonzero(np.abs(np.diff(position)) / np.diff(time) > REWIND_SPEED)
    if len(fast) and not rewind:
        start = int(np.searchsorted(time, time[fast[-1]] + REWIND_REST))
    return Log(time=time[start:], position=position[start:], command=current[start:])


def scan(name: str, folder: str | os.PathLike[str] | None = None) -> Scan:
    """Read the holding current at every 16th count of a turn.

    Args:
        name: one of SCANS.
        folder: see `files`.

    Raises:
        ValueError: an unknown name.
        InputError: the file is missing or invalid.
    """
    SOURCE.require_name(name, SCANS)
    path = _find(name, folder)
    held = _array(path)
    if held.shape != (COUNTS,):
        raise InputError(f"{path}: must be {COUNTS} values, a count each, got {held.shape}")
    visited = np.flatnonzero(held)
    return Scan(np.asarray(TURN / COUNTS * visited, dtype=np.float64), held[visited])


def _find(name: str, folder: str | os.PathLike[str] | None) -> Path:
    """Return the file of a run or a scan, in a flat folder or in a clone of the repository."""
    if name in SCANS:
        return SOURCE.find(f"cogging_measure_{SCANS[name]}.npy", folder)
    group, run, number = name.rsplit("_", 2)
    for path in SOURCE.candidates(f"{group}/{run}_{number}.npy", folder):
        if path.is_file():
            return path
    return SOURCE.find(f"{name}.npy", folder)


def _array(path: Path) -> FloatArray:
    """Return the finite numbers of a file; no object is unpickled."""
    try:
        with path.open("rb") as file:
            values = np.asarray(np.lib.format.read_array(file, allow_pickle=False), dtype=np.float64)
    except (OSError, ValueError, TypeError, MemoryError) as error:
        raise InputError(one_line(f"{path}: must be a numpy array of numbers: {error}")) from None
    if not np.isfinite(values).all():
        raise InputError(f"{path}: must hold finite numbers, holds others")
    return values
