"""The naive baseline: filtered inverse dynamics, forward selection over a library of terms, BIC counting all samples.

What many would write first: differentiate the low-passed encoder twice, regress the command on what the model has
and on candidate terms, add the best while BIC falls. It cannot say `unlisted`, and states its names with certainty.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import butter, sosfiltfilt

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

CORNER = 40.0  # Hz, of the parallel low-pass on all columns
DIFFERENCES = 4.0  # corner of the low-pass before differentiation, in units of CORNER
MOST = 8  # terms at most
FLOOR = 0.02  # of the rms
Columns = dict[str, np.ndarray]


def diagnose_naively(log: Path, model: Path, confirm: list[Path], *, careful: bool = False) -> dict[str, Any]:
    """Diagnose a log as the contract's JSON; see the module.

    careful: a term stays only if it takes FLOOR off the residual here and on the confirm log, with frozen amplitudes.
    """
    with model.open("rb") as file:
        nominal = tomllib.load(file)
    data = _prepare(log)
    known, extra = _known(data, nominal), _library(data, nominal)
    target = _reduced(data, data["command"])
    other = _prepare(confirm[0]) if confirm else data
    target_there = _reduced(other, other["command"])
    base, library = _known(other, nominal), _library(other, nominal)
    design_there = np.column_stack(list(base.values()))
    small, large = design_there, design_there
    design = np.column_stack(list(known.values()))
    small_here, before = design, _residual(design, target)
    chosen: list[str] = []
    rest, count = before, len(target)
    criterion = _bic(rest, design.shape[1], count)
    while len(chosen) < MOST:
        orthogonal = np.linalg.qr(design)[0]
        best, best_criterion = "", criterion
        for name, block in extra.items():
            if name in chosen:
                continue
            block = block - orthogonal @ (orthogonal.T @ block)
            trial = rest - block @ np.linalg.lstsq(block, rest, rcond=1e-9)[0]
            value = _bic(trial, design.shape[1] + block.shape[1], count)
            if value < best_criterion:
                best, best_criterion = name, value
        if not best:
            break
        larger, larger_there = np.column_stack([design, extra[best]]), np.column_stack([large, library[best]])
        trial = _residual(larger, target)
        if careful:
            there = [target_there - m @ _fit(d, target) for m, d in ((large, design), (larger_there, larger))]
            if _rms(trial) > (1 - FLOOR) * _rms(rest) or _rms(there[1]) > (1 - FLOOR) * _rms(there[0]):
                break
        chosen.append(best)
        design, large, rest, criterion = larger, larger_there, trial, best_criterion
    names = list(dict.fromkeys(name.split(" ")[0] for name in chosen))
    gap: dict[str, Any] = {"unit": "V", "floor": None, "before": _rms(before), "after": _rms(rest)}
    gap |= {"confirm_before": None, "confirm_after": None}
    if confirm:
        gap["confirm_before"] = _rms(target_there - small @ _fit(small_here, target))
        gap["confirm_after"] = _rms(target_there - large @ _fit(design, target))
    return {
        "verdict": "named" if names else "no_gap",
        "effects": [{"name": name, "alternatives": [], "confidence": 0.99, "parameters": {}} for name in names],
        "unlisted": None,
        "gap": gap,
        "separating_experiment": None,
    }


def _prepare(path: Path) -> Columns:
    """Low-passed position, its differences and the command between the samples, on a grid of some 1000 Hz."""
    with path.open() as file:
        header = file.readline().strip().split(",")
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    column = {name: table[:, i] for i, name in enumerate(header)}
    step = float(np.median(np.diff(column["time"])))
    corner = min(DIFFERENCES * CORNER, 0.2 / step)
    position = sosfiltfilt(butter(4, corner * 2 * step, output="sos"), column["position"])
    velocity = np.gradient(position, step)
    # the command is held: around a sample, half of it is the one before
    command = 0.5 * (column["command"] + np.concatenate([column["command"][:1], column["command"][:-1]]))
    thin = max(1, int(1 / (6 * corner * step)))
    if thin > 1:
        command = sosfiltfilt(butter(4, corner * 2 * step, output="sos"), command)
    return {
        "time": (column["time"] - column["time"][0])[::thin],
        "position": position[::thin],
        "velocity": velocity[::thin],
        "acceleration": np.gradient(velocity, step)[::thin],
        "command": command[::thin],
        "slope": np.gradient(command, step)[::thin],
        "step": np.full(1, step * thin),
    }


def _reduced(data: Columns, block: np.ndarray) -> np.ndarray:
    """The parallel filter: what is on either side of the regression, low-passed and thinned alike."""
    step = float(data["step"][0])
    low = sosfiltfilt(butter(4, CORNER * 2 * step, output="sos"), block, axis=0)
    edge = int(0.1 / step)
    return low[edge : -edge : max(1, int(1 / (5 * CORNER * step)))]


def _sign(data: Columns, width: float) -> np.ndarray:
    return 2 / np.pi * np.arctan(data["velocity"] / width)


def _waves(argument: np.ndarray, period: float) -> np.ndarray:
    return np.column_stack([np.sin(2 * np.pi * argument / period), np.cos(2 * np.pi * argument / period)])


def _periods(nominal: dict[str, Any]) -> list[float]:
    cogging = nominal.get("cogging", {})
    return list(cogging.get("periods") or [cogging["pitch"] / h for h in cogging.get("harmonics", [])])


def _known(data: Columns, nominal: dict[str, Any]) -> Columns:
    """Terms that the model has, amplitudes free."""
    known = {"mass": data["acceleration"], "viscous": data["velocity"]}
    known["coulomb"] = _sign(data, max(nominal["axis"]["coulomb_width"], 1e-5))
    for i, period in enumerate(_periods(nominal)):
        waves = _waves(data["position"], period)
        known[f"sine {i}"], known[f"cosine {i}"] = waves[:, 0], waves[:, 1]
    return {name: _reduced(data, column) for name, column in known.items()}


def _library(data: Columns, nominal: dict[str, Any]) -> Columns:
    """Candidate terms by `name detail`, (n, p) each."""
    x, v, a, u, t = (data[name] for name in ("position", "velocity", "acceleration", "command", "time"))
    low, high = nominal["axis"]["travel"]
    length, duration = high - low, float(t[-1])
    s = (x - low) / length
    sign = _sign(data, max(nominal["axis"]["coulomb_width"], 1e-5))
    slope = data["slope"]
    terms: dict[str, np.ndarray] = {
        "constant_force": np.ones_like(x),
        "cable_spring": s - 0.5,
        "end_effect": np.exp(-(high - x) / (0.07 * length)) - np.exp(-(x - low) / (0.07 * length)),
        "coulomb_asymmetry": np.abs(sign),
        "viscous_asymmetry": np.abs(v),
        "quadratic_drag": v * np.abs(v),
        "force_constant_drift": u * (1 - np.exp(-t / (0.3 * duration))),
        "command_delay": slope,
        "actuator_lag": np.gradient(slope),
        "command_dead_zone": np.sign(u),
        "command_saturation": np.sign(u) * np.maximum(np.abs(u) - 0.9 * np.abs(u).max(), 0),
        "position_dependent_friction": np.column_stack([sign * np.cos(np.pi * k * s) for k in (1, 2, 3)]),
        "encoder_scale_error": np.column_stack([x * a, x * v]),
        "flexible_mode": np.gradient(np.gradient(a)),
    }
    for speed in (3e-3, 1e-2, 3e-2):
        terms[f"stribeck_friction {speed:g}"] = sign * np.exp(-((v / speed) ** 2))
    for i, period in enumerate(_periods(nominal)):
        waves = _waves(x, period)
        terms[f"cogging_modulation {i}"] = np.column_stack(
            [waves * f[:, None] for f in (np.cos(np.pi * s), np.cos(2 * np.pi * s))]
        )
        terms[f"force_constant_ripple {i}"] = u[:, None] * waves
    for period in np.geomspace(4e-3, min(0.09, 0.4 * length), 80):
        terms[f"cogging_harmonic {period:g}"] = _waves(x, period)
    for period in np.geomspace(1e-3, 0.03, 60):
        terms[f"encoder_periodic_error {period:g}"] = (v**2)[:, None] * _waves(x, period)
    for frequency in np.geomspace(2.0, 0.9 * CORNER, 120):
        terms[f"disturbance_tone {frequency:g}"] = _waves(t, 1 / frequency)
    for begin in np.linspace(0.1, 0.6, 6):
        for span in (0.1, 0.2, 0.35):
            inside = (t > begin * duration) & (t < (begin + span) * duration)
            terms[f"disturbance_step {begin:g} {span:g}"] = inside.astype(float)
    return {name: _reduced(data, block.reshape(len(x), -1)) for name, block in terms.items()}


def _residual(design: np.ndarray, target: np.ndarray) -> np.ndarray:
    return target - design @ _fit(design, target)


def _fit(design: np.ndarray, target: np.ndarray) -> np.ndarray:
    return np.linalg.lstsq(design, target, rcond=1e-9)[0]


def _bic(residual: np.ndarray, parameters: int, count: int) -> float:
    return float(count * np.log(np.mean(residual**2)) + parameters * np.log(count))


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
