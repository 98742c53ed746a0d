"""Whether what is left is noise: how much of it a generic force, fitted on some motion, predicts on other motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cogging.arrays import FloatArray, Mask
from cogging.diagnosis.candidates.forms import hats
from cogging.diagnosis.discrepancy import Discrepancy
from cogging.diagnosis.evidence.score_test import ScoreTest
from cogging.diagnosis.report.words import COORDINATE_UNITS
from cogging.diagnosis.residual.shape import Shape
from cogging.diagnosis.thresholds import GAP, PREDICTABLE
from cogging.estimation.statistics import moving_average
from cogging.logs.log import Log

PLACES = dict(zip(("position", "velocity", "acceleration", "command"), PREDICTABLE.generic_bends, strict=True))


@dataclass(frozen=True)
class Predicted:
    """What a generic force predicts of the power of what is left.

    Attributes:
        within: of the power that is left on the given logs, what the force predicts of blocks from the others; 0 to 1.
        elsewhere: of that on the confirm logs, what it predicts fitted to the given logs; None without confirm logs.
        shape: force in the one coordinate that predicts most by itself, with the share that it predicts.
    """

    within: float
    elsewhere: float | None
    shape: Shape

    @property
    def share(self) -> float:
        """What it predicts at best: what repeats itself on the given logs alone is no noise either."""
        return max(self.within, self.elsewhere or 0.0)


def predicted(
    logs: Sequence[Log], given: Discrepancy, others: Sequence[Log] = (), confirm: Discrepancy | None = None
) -> Predicted:
    """Fit a force of place and direction, speed, acceleration and command to what is left, and predict elsewhere.

    The force is a sum of piecewise linear functions and of the drive at other moments, fitted by ridge regression. It
    is no function of time.

    Args:
        logs, given: given logs and what is left of them.
        others, confirm: the same of the confirm logs.
    """
    here = [_motion(log, one, given) for log, one in zip(logs, given.series, strict=True)]
    places = {
        name: _places(name, [m[name][mask] for m, mask in zip(here, given.masks, strict=True)]) for name in PLACES
    }
    groups, table, left = _rows(here, given, places)
    folds = np.concatenate(
        [
            (np.arange(len(mask)) * PREDICTABLE.fold_blocks // len(mask) % PREDICTABLE.folds)[mask]
            for mask in given.masks
        ]
    )
    sums = [_sums(table[:, folds == fold], left[folds == fold]) for fold in range(PREDICTABLE.folds)]
    elsewhere = None
    if confirm is not None:
        motions = [_motion(log, one, confirm) for log, one in zip(others, confirm.series, strict=True)]
        elsewhere = _sums(*_rows(motions, confirm, places)[1:])
    alone = {name: _fit(sums, elsewhere, groups == name) for name in PLACES}
    best = max(alone, key=lambda name: alone[name][0])
    share, force, deviation = alone[best]
    test = ScoreTest(np.nan, len(force), force, left, deviation)
    shape = Shape(best, COORDINATE_UNITS[best], test, places[best], pushes(given) * force, deviation, 0.0, share)
    every = np.ones(len(groups), dtype=bool)
    there = None if elsewhere is None else _fit(sums, elsewhere, every)[0]
    return Predicted(_fit(sums, None, every)[0], there, shape)


def pushes(gap: Discrepancy) -> float:
    """Towards where a force pushes that is missing where a gap is positive: innovations are forces, others commands."""
    return 1.0 if gap.signal.startswith("innovations") else -1.0


def _motion(log: Log, left: FloatArray, gap: Discrepancy) -> dict[str, FloatArray]:
    """What the machine was asked for, in which the noise that is left is not: the reference, and the replayed command.

    Without a reference the readings stand for it, and the logged command for the drive.
    """
    asked = log.reference is not None
    position = log.reference if log.reference is not None else log.position
    average = max(1, round(GAP.smoothing / float(np.median(np.diff(log.time)))))
    velocity = moving_average(np.gradient(position, log.time), average)
    acceleration = moving_average(np.gradient(velocity, log.time), average)
    command = log.command + pushes(gap) * left
    drive = command if gap.position is not None else acceleration if asked else log.command
    return {
        "position": position,
        "velocity": velocity,
        "acceleration": acceleration,
        "command": moving_average(command, average),
        "drive": np.stack(
            [_later(drive, lag) for lag in PREDICTABLE.lags + tuple(-lag for lag in PREDICTABLE.lags) * asked]
        ),
    }


def _later(values: FloatArray, rows: int) -> FloatArray:
    """Values some rows later, or earlier for fewer than 0; the first or last for what is not there."""
    return np.asarray(values[np.clip(np.arange(len(values)) - rows, 0, len(values) - 1)])


def _places(name: str, values: Sequence[FloatArray]) -> FloatArray:
    """Where a force may bend: evenly along the travel, else where as many rows are between."""
    seen, share = np.concatenate(values), np.linspace(0.0, 1.0, PLACES[name])
    return np.unique(seen.min() + np.ptp(seen) * share if name == "position" else np.quantile(seen, share))


def _rows(
    motions: Sequence[Mapping[str, FloatArray]], gap: Discrepancy, places: Mapping[str, FloatArray]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Coordinate of each column, columns, and what is left, over rows in motion."""
    tables = []
    for motion, mask in zip(motions, gap.masks, strict=True):
        parts = {name: hats(motion[name][mask], at) for name, at in places.items()}
        forward = motion["velocity"][mask] > 0.0
        parts["position"] = np.vstack([parts["position"] * forward, parts["position"] * ~forward])
        parts["drive"] = motion["drive"][:, mask]
        tables.append(np.vstack(list(parts.values())))
    names = np.repeat(list(parts), [len(part) for part in parts.values()])
    left = np.concatenate([row[mask] for row, mask in zip(gap.series, gap.masks, strict=True)])
    return names, np.concatenate(tables, axis=1), left


Sums = tuple[FloatArray, FloatArray, float, int]  # columns by columns and by what is left, its power, rows


def _sums(table: FloatArray, left: FloatArray) -> Sums:
    return table @ table.T, table @ left, float(left @ left), len(left)


def _fit(folds: Sequence[Sums], elsewhere: Sums | None, used: Mask) -> tuple[float, FloatArray, FloatArray]:
    """Share of the power that some columns predict, and their amplitudes with deviations."""
    parts = [_only(used, sums) for sums in folds]
    gram, right = np.sum([part[0] for part in parts], axis=0), np.sum([part[1] for part in parts], axis=0)
    total, rows = sum(part[2] for part in parts), sum(part[3] for part in parts)
    size = np.diag(gram) + PREDICTABLE.column_least * np.diag(gram).max()

    def lost(ridge: float) -> float:
        weight = ridge * np.diag(size)
        return sum(_lost(np.linalg.solve(gram - one[0] + weight, right - one[1]), one) for one in parts)

    ridge = min(10.0 ** (0.5 * np.arange(*PREDICTABLE.ridges)), key=lost)
    inverse = np.linalg.inv(gram + ridge * np.diag(size))
    force = inverse @ right
    noise = _lost(force, (gram, right, total, rows)) / max(rows - len(force), 1)
    remains, power = lost(ridge), total
    if elsewhere is not None:
        power = elsewhere[2]
        remains = _lost(force, _only(used, elsewhere))
    return (
        float(np.clip(1.0 - remains / power, 0.0, 1.0)) if power > 0.0 else 0.0,
        force,
        np.sqrt(noise * np.diag(inverse)),
    )


def _only(used: Mask, sums: Sums) -> Sums:
    """The sums of some of the columns."""
    return sums[0][np.ix_(used, used)], sums[1][used], *sums[2:]


def _lost(force: FloatArray, sums: Sums) -> float:
    """Power that is left with a force."""
    gram, right, power = sums[:3]
    return float(power - 2.0 * force @ right + force @ gram @ force)
