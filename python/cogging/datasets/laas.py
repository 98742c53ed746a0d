"""LAAS: a direct-drive brushless motor with strong cogging, three logs in text files.

Source: H. Andrade, github.com/heitor-andrade/laas_anti_cogging, 2023. Licence: BSD-3-Clause.

The motor is rotary and its force constant is unknown: the position is in rad and the command is the current, so that a
mass is J/Kt, A/(rad/s^2). Rows are about a millisecond apart; some were lost.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np

from cogging.arrays import FloatArray
from cogging.datasets.source import Source
from cogging.logs.columns import read_columns
from cogging.logs.log import Log

PLACES = (".", "codes/Get_Data", "codes/Stopped/stopped_data", "codes/acceleration_data")
SOURCE = Source("laas", "github.com/heitor-andrade/laas_anti_cogging", "BSD-3-Clause", PLACES)
#: `stopped_data`: held at successive positions, one turn and back. `acc_current`: 0.4 A at 2 Hz, up to 160 rad/s.
#: `speed_test1`: a speed loop at one turn per second, half of the time with the authors' cogging compensation.
FILES = ("stopped_data", "acc_current", "speed_test1")
TURN = 2 * np.pi  # rad, the pitch of the motor's map
#: The speed loop of `speed_test1` as published: A/(rad/s), rad/s, s.
SPEED_LOOP = MappingProxyType({"gain": 0.09, "reference": TURN, "delay": 2e-3})


@dataclass(frozen=True, eq=False)
class RotaryLog:
    """Rows of a log of a motor; arrays of shape (n,)."""

    time: FloatArray  # s
    position: FloatArray  # rad
    velocity: FloatArray  # rad/s, as the drive reports it
    current: FloatArray  # A

    def __len__(self) -> int:
        return len(self.time)

    def between(self, start: float, stop: float) -> RotaryLog:
        """Return the rows with start <= time < stop (s)."""
        kept = (self.time >= start) & (self.time < stop)
        return RotaryLog(self.time[kept], self.position[kept], self.velocity[kept], self.current[kept])

    def log(self) -> Log:
        """Return the same as a log of an axis, with rad for m and A for V.

        Raises:
            ValueError: time is not strictly increasing.
        """
        return Log(time=self.time, position=self.position, command=self.current)


def files(folder: str | os.PathLike[str] | None = None) -> dict[str, Path]:
    """Return the paths of the three files by their names without `.txt`.

    Args:
        folder: of the data (see cogging.datasets): side by side, or as in a clone of the repository.

    Raises:
        InputError: a file is missing; names source and licence.
    """
    return {name: SOURCE.find(f"{name}.txt", folder) for name in FILES}


def read(name: str, folder: str | os.PathLike[str] | None = None, *, compensated: bool = False) -> RotaryLog:
    """Read one of the three logs.

    Args:
        name: one of FILES.
        folder: see `files`.
        compensated: of `speed_test1`, the rows with the authors' compensation instead of those without.

    Raises:
        ValueError: an unknown name, or one that was never compensated.
        InputError: the file is missing or invalid.
    """
    SOURCE.require_name(name, FILES)
    names = {"time": "Time", "position": "Position", "velocity": "Velocity", "current": "Iq"}
    if name == "speed_test1":
        names["compensation"] = "Function Activated"
    elif compensated:
        raise ValueError(f"compensated: must be False for {name}, which has no compensation, got True")
    table = read_columns(SOURCE.find(f"{name}.txt", folder), list(names), columns=names)
    on = table.pop("compensation", np.zeros(len(table["time"]))) != 0
    kept = on if compensated else ~on
    return RotaryLog(**{column: values[kept] for column, values in table.items()})
