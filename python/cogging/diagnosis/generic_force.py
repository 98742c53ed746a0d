"""Test whether an unexplained force is noise: how much of it a generic force, fitted to some motion, predicts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cogging.arrays import FloatArray, Mask
from cogging.diagnosis.balance.cells import hats
from cogging.diagnosis.places import COORDINATE_UNITS, Shape
from cogging.diagnosis.yardstick import Discrepancy

#: Nodes of the piecewise linear force along each coordinate.
BENDS = {"position": 41, "velocity": 15, "acceleration": 13, "drive": 13, "time": 13}
LAGS = tuple(2**k for k in range(9))  # rows by which the acceleration is delayed, for actuator dynamics
FOLDS, BLOCKS = 5, 20  # folds of the cross-validation; blocks of a log that are dealt to them in turn
RIDGES = 10.0 ** (0.5 * np.arange(-8.0, 5.0))  # ridge parameters, relative to a column's power
LASTING = 0.05  # of the power: where another coordinate predicts more, time is listed after it
APART = 0.01  # of the range: minimum distance of nodes
LEAST = 1e-9  # of the largest column's power: minimum power of a column
ROWS = 10000  # of a log, which suffice for some 150 columns


@dataclass(frozen=True)
class Predicted:
    """Share of the gap's power that a generic force predicts."""

    within: float  # share on the given logs by cross-validation, 0 to 1
    elsewhere: float | None  # share on the confirm logs after a fit to the given logs; None without confirm logs
    curves: tuple[Shape, ...]  # force along each coordinate alone, the largest share first; untested
    noise: float  # rms residual of the whole force on the given logs, V, corrected for its degrees of freedom

    @property
    def share(self) -> float:
        """The larger share of given and confirm logs."""
        return max(self.within, self.elsewhere or 0.0)


def predicted(given: Discrepancy, confirm: Discrepancy | None = None) -> Predicted:
    """Fit a force of position, direction, speed, acceleration, command and time, and return what it predicts.

    The force is a sum of piecewise linear functions and of delayed accelerations, fitted by ridge regression.

    Args:
        given: unexplained force of the given logs.
        confirm: unexplained force of the confirm logs, to which the force of time does not apply.
    """
    places = {name: _places(name, given) for name in BENDS}
    groups, table, left = _rows(given, places)
    folds = np.concatenate([(np.arange(len(m)) * BLOCKS // len(m) % FOLDS)[m] for m in _thinned(given)])
    sums = [_sums(table[:, folds == fold], left[folds == fold]) for fold in range(FOLDS)]
    elsewhere = None if confirm is None else _sums(*_rows(confirm, places)[1:])
    curves = []
    for name in BENDS:
        share, force, deviation = _fit(sums, None if name == "time" else elsewhere, groups == name)
        missing = given.push * force
        said = "command" if name == "drive" else name
        curves.append(Shape(said, COORDINATE_UNITS[said], places[name], missing, deviation, 0.0, 0.0, share))
    # every persistent force is a function of time too: list time after the other coordinates
    lasts = max(curve.share for curve in curves if curve.coordinate != "time") > LASTING
    curves.sort(key=lambda curve: -curve.share * (not lasts or curve.coordinate != "time"))
    lasting = groups != "time"
    there = None if elsewhere is None else _fit(sums, elsewhere, lasting)[0]
    whole = (*_total(sums)[:2], float(left @ left))
    (weights,) = _weights(whole, RIDGES[:1])
    noise = max(_lost(weights, whole), 0.0) / max(len(left) - len(groups), 1)
    return Predicted(_fit(sums, None, lasting)[0], there, tuple(curves), float(np.sqrt(noise)))


def _places(name: str, given: Discrepancy) -> FloatArray:
    """Return the nodes of a coordinate: equally spaced along position and time, else at quantiles."""
    seen, share = given.in_motion(name), np.linspace(0.0, 1.0, BENDS[name])
    if name in ("position", "time"):
        return np.unique(seen.min() + np.ptp(seen) * share)
    kept: list[float] = []
    for place in np.quantile(seen, share):  # cruising fills many quantiles with nearly one value
        if not kept or place - kept[-1] > APART * np.ptp(seen):
            kept.append(place)
    return np.array(kept)


def _rows(gap: Discrepancy, places: Mapping[str, FloatArray]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the coordinate of each column, the columns and the unexplained force over rows in motion."""
    tables = []
    masks = _thinned(gap)
    for rows, mask in zip(gap.rows, masks, strict=True):
        parts = {
            name: hats(rows[name][mask], at) if len(at) > 1 else np.zeros((1, mask.sum()))
            for name, at in places.items()
        }
        forward = rows["velocity"][mask] > 0.0
        parts["position"] = np.vstack([parts["position"] * forward, parts["position"] * ~forward])
        caused = rows["acceleration"]
        later = [np.clip(np.arange(len(caused)) - lag, 0, len(caused) - 1) for lag in LAGS]
        parts["later"] = caused[np.array(later)][:, mask]
        tables.append(np.vstack(list(parts.values())))
    names = np.repeat(list(parts), [len(part) for part in parts.values()])
    left = np.concatenate([row[mask] for row, mask in zip(gap.series, masks, strict=True)])
    return names, np.concatenate(tables, axis=1), left


def _thinned(gap: Discrepancy) -> list[Mask]:
    """Return the rows in motion of each log, every n-th of a long one."""
    return [m & (np.arange(len(m)) % max(1, len(m) // ROWS) == 0) for m in gap.masks]


Sums = tuple[FloatArray, FloatArray, float]  # Gram matrix of columns, their products with the force, its power


def _sums(table: FloatArray, left: FloatArray) -> Sums:
    return table @ table.T, table @ left, float(left @ left)


def _total(parts: Sequence[Sums]) -> Sums:
    grams, rights, powers = zip(*parts, strict=True)
    return np.sum(grams, axis=0), np.sum(rights, axis=0), float(sum(powers))


def _weights(sums: Sums, ridges: FloatArray) -> FloatArray:
    """Return the amplitudes of ridge regressions, (ridges, columns)."""
    gram, right, _ = sums
    size = np.diag(gram) + LEAST * np.diag(gram).max() + 1e-300
    return np.asarray(np.linalg.solve(gram + ridges[:, None, None] * np.diag(size), right[:, None])[..., 0])


def _fit(parts: Sequence[Sums], elsewhere: Sums | None, used: Mask) -> tuple[float, FloatArray, FloatArray]:
    """Return the share of the power that some columns predict, their amplitudes and standard deviations."""
    own = [(gram[np.ix_(used, used)], right[used], power) for gram, right, power in parts]
    lost = np.zeros(len(RIDGES))
    for k, one in enumerate(own):
        lost += [_lost(force, one) for force in _weights(_total(own[:k] + own[k + 1 :]), RIDGES)]
    best, whole = int(np.argmin(lost)), _total(own)
    (force,) = _weights(whole, RIDGES[[best]])
    gram, right, power = whole
    size = np.diag(gram) + LEAST * np.diag(gram).max() + 1e-300
    noise = max(_lost(force, whole), 0.0) / max(float(np.trace(gram)), 1.0)
    deviation = np.sqrt(noise * np.diag(np.linalg.inv(gram + RIDGES[best] * np.diag(size))))
    remains = float(lost[best])
    if elsewhere is not None:
        gram, right, power = elsewhere
        remains = _lost(force, (gram[np.ix_(used, used)], right[used], power))
    share = float(np.clip(1.0 - remains / power, 0.0, 1.0)) if power > 0.0 else 0.0
    return share, force, deviation


def _lost(force: FloatArray, sums: Sums) -> float:
    """Return the residual power of a force."""
    gram, right, power = sums
    return float(power - 2.0 * force @ right + force @ gram @ force)
