"""A yardstick for the answers: `python -m studies.public_logs.plain FOLDER`, after `python -m studies.public_logs --out FOLDER`.

Two forces and no inertia: friction that slips beyond a spring of width w, and a constant. Least squares of the command
on given.csv, for the best of some w, then held against confirm.csv as it is: rms in motion, in the units of the CSV.
"""

import sys
from pathlib import Path

import numpy as np

WIDTHS = (1e-6, 1e-3, 3e-3, 0.01, 0.03, 0.06, 0.08, 0.1)  # of the travel on given.csv
REST = 0.3  # of the top speed


def load(path, width):
    time, position, command = np.loadtxt(path, delimiter=",", skiprows=1)[:, :3].T
    way = np.diff(position, prepend=position[0]) / width
    slip = np.zeros_like(position)
    for row in range(1, len(position)):
        slip[row] = min(max(slip[row - 1] + way[row], -1.0), 1.0)
    rows = max(2, len(time) // 500)
    speed = np.abs(np.interp(time + time[rows], time, position) - np.interp(time - time[rows], time, position))
    moving = speed > REST * np.max(speed)
    return np.column_stack([slip, np.ones_like(slip)])[moving], command[moving]


def main():
    for folder in sorted(Path(sys.argv[1]).iterdir()):
        if not (folder / "confirm.csv").exists():
            continue
        travel, tried = np.ptp(np.loadtxt(folder / "given.csv", delimiter=",", skiprows=1)[:, 1]), []
        for width in WIDTHS:
            found, command = load(folder / "given.csv", width * travel)
            fit = np.linalg.lstsq(found, command, rcond=None)[0]
            tried.append((np.std(command - found @ fit), width, fit))
        left, width, fit = min(tried, key=lambda one: one[0])
        found, other = load(folder / "confirm.csv", width * travel)
        print(f"{folder.name:<14}friction {fit[0]:.3g} beyond {width:g} of the travel, constant {fit[1]:.3g}: ", end="")
        rms = np.sqrt(np.mean(other**2))
        print(f"leaves {left:.3g}, on the other log {np.sqrt(np.mean((other - found @ fit) ** 2)):.3g} of {rms:.3g}")


if __name__ == "__main__":
    main()
