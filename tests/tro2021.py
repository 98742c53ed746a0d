"""A lead-screw drive at constant speeds (Mablekos-Alexiou, da Cruz, Bergeles, IEEE T-RO 37(4), 2021).

Public as RViMLab/TRO2021-Dynamic-Modelling; speed in rpm, torque in % of nominal, no position.
"""

from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parents[1] / ".." / "shared" / "data" / "tro2021"
SETTLING = 20  # rows left out at the start of a run


def read(path):
    """Time (s), speed (rpm) and torque (%) of one file, each (n,); trailing rows without values are left out."""
    lines = path.read_text(encoding="utf-8-sig").splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("ms;")) + 1
    rows = [line.split(";") for line in lines[start:]]
    table = np.array([[float(cell) for cell in row[:3]] for row in rows if len(row) >= 3 and all(row[:3])])
    return 1e-3 * table[:, 0], table[:, 1], table[:, 2]


def steady_speeds():
    """Speed (rpm) and torque (%) of every constant-speed run, its rows averaged: each (32,)."""
    runs = sorted((FOLDER / "experiments" / "driveNo1" / "steady_state").glob("*/*.csv"))
    return np.array([[column[SETTLING:].mean() for column in read(path)[1:]] for path in runs]).T
