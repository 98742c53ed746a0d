"""Calibrates the plant of Xu and Yao 2001 on the PID columns: `python -m cogging.papers.xu2001.calibration [FILE]`.

For each of four friction laws the unknowns are fitted to 15 numbers: e_M, e_F, e_rms, u_rms, c_u of the PID in the
three sets (du_rms = c_u u_rms is printed to one digit). From several starts; the fit's own error is kept with the
result, which comes with the package as plant.toml. The ARC columns take no part.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

from cogging._core import DivergedError, Pid
from cogging.arrays import FloatArray
from cogging.outputs import to_toml, write_text
from cogging.papers.fitting import fit_logarithms, round_to_digits
from cogging.papers.xu2001.setup import INDEXES, SETS, TABLE_1, Unknowns, indexes, pid_parameters, run, to_dict
from cogging_command import run_command

FITTED = ("e_M", "e_F", "e_rms", "u_rms", "c_u")

#: Where the search begins and what each law holds fixed: 0 takes an effect away. The values that an earlier search had
#: found for smooth_stribeck, rounded.
START = {
    "coulomb": 0.154,
    "coulomb_width": 1.7e-3,
    "static_excess": 0.0194,
    "stribeck_velocity": 0.011,
    "offset": 0.0106,
    "delay": 3.73e-4,
    "encoder_noise": 0.368e-6,
    "ripple": 0.0783,
    "ripple_period": 0.0419,
}
LAWS: dict[str, dict[str, float]] = {
    "smooth_stribeck": {},
    "smooth_coulomb": {"static_excess": 0.0, "stribeck_velocity": 0.01},
    "exact_stribeck": {"coulomb_width": 0.0},
    "exact_coulomb": {"coulomb_width": 0.0, "static_excess": 0.0, "stribeck_velocity": 0.01},
}
STARTS = 8  # the first as above, the others with each unknown off by a factor of about 1.5


def log_ratios(unknowns: Unknowns) -> FloatArray:
    """Logarithms of simulated / printed for the 15 PID numbers, (15,)."""
    logs = run(unknowns, Pid(pid_parameters()))
    found = [[indexes(logs[name])[index] for index in FITTED] for name in SETS]
    printed = [[TABLE_1["PID"][name][INDEXES.index(index)] for index in FITTED] for name in SETS]
    return np.asarray(np.log(np.array(found) / np.array(printed)).ravel())


def calibrate(law: str, starts: int = STARTS) -> tuple[Unknowns, FloatArray, list[float]]:
    """Fit the unknowns of a friction law: the best ones, their log-ratios, and the rms log-ratio of every start."""
    fixed = LAWS[law]
    names = [name for name in START if name not in fixed]

    def unknowns_of(values: FloatArray) -> Unknowns:
        return Unknowns(**fixed, **{name: round_to_digits(value) for name, value in zip(names, values, strict=True)})

    def gap(values: FloatArray) -> FloatArray:
        try:
            return log_ratios(unknowns_of(values))
        except DivergedError:
            return np.full(len(SETS) * len(FITTED), 5.0)  # worse than any run that ends

    results: list[tuple[float, Any, Any]] = []
    for start in range(starts):
        spread = 0.4 * np.random.default_rng([2001, start]).normal(size=len(names)) if start else 0.0
        values, _ = fit_logarithms(gap, np.array([START[name] for name in names]) * np.exp(spread), step=0.03)
        values, y = fit_logarithms(gap, values, step=0.006, iterations=8)
        results.append((float(np.sqrt(np.mean(y**2))), unknowns_of(values), y))
    results.sort(key=lambda result: result[0])
    return results[0][1], results[0][2], [result[0] for result in results]


def plant_toml() -> str:
    """The text of plant.toml: unknowns and fit error of each friction law."""
    document: dict[str, Any] = {}
    for law in LAWS:
        unknowns, gap, errors = calibrate(law)
        document[law] = {
            "rms_log_error": round_to_digits(errors[0], 3),
            "largest_relative_error": round_to_digits(float(np.abs(np.expm1(gap)).max()), 3),
            "rms_log_error_of_starts": [round_to_digits(error, 3) for error in errors],
            "unknowns": to_dict(unknowns),
        }
    head = "# Unknowns of the plant by friction law, written by cogging.papers.xu2001.calibration.\n"
    return head + to_toml(document)


def main(target: str) -> None:
    """Calibrate and write the file."""
    write_text(target, plant_toml())
    print(f"{target} written")


if __name__ == "__main__":
    own = str(Path(__file__).with_name("plant.toml"))
    sys.exit(run_command(lambda: main(sys.argv[1] if len(sys.argv) > 1 else own)))
