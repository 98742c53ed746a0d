"""What happens at moments: readings that jump, friction that comes and goes. How many of them, the log says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.waves import adjoint
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.log_p_value import log_choices, log_survival
from cogging.diagnosis.residual.shape import FRICTION_INTERVALS, JUMPS, Shape
from cogging.diagnosis.thresholds import DISTRIBUTION, EVENT
from cogging.estimation.innovations import Innovations


def with_events(evidence: Evidence, found: Sequence[Shape]) -> list[Shape]:
    """Generic shapes and what happens at moments, the likeliest first."""
    return sorted([*found, *events(evidence)], key=lambda shape: shape.log_p_value)


def events(evidence: Evidence) -> list[Shape]:
    """Jumps of the reading and intervals of other friction, as shapes."""
    forces, readings = [], []
    start = 0
    for source, filter_, along in zip(evidence.sources, evidence.filters, evidence.alongs, strict=True):
        n = len(source.log)
        residual = evidence.free_residual[start : start + n]
        force, reading = adjoint(source, filter_, along, evidence.model.axis.mass, residual)
        forces.append(force * np.sign(along.middle_velocity))
        readings.append(reading)
        start += n
    return [shape for shape in (_jumps(evidence, readings), _friction_intervals(evidence, forces)) if shape is not None]


def level_of(score: FloatArray) -> float:
    """Mean of squared scores of noise, from their median, or from what all but one in a hundred stay below."""
    if len(score) == 0:
        return 0.0
    middle = np.median(score) / DISTRIBUTION.chi_square_median
    return float(max(middle, np.quantile(score, EVENT.tail) / DISTRIBUTION.chi_square_hundredth))


def _jumps(evidence: Evidence, readings: list[FloatArray]) -> Shape | None:
    """Steps of the reading: their score is what the adjoint of all later rows adds up to."""
    chosen: list[tuple[float, int, int]] = []
    rows = 0.0
    for number, (source, reading) in enumerate(zip(evidence.sources, readings, strict=True)):
        score = np.cumsum(reading[::-1])[::-1] ** 2 * source.mask
        level = level_of(score[source.mask > 0])
        rows += float(source.mask.sum())
        near = max(1, round(EVENT.jumps_apart / source.scales.sample_time))
        for _ in range(EVENT.events_max):
            row = int(np.argmax(score))
            if level <= 0.0 or score[row] <= 0.0:
                break
            chosen.append((float(score[row]) / level, number, row))
            score[max(0, row - near) : row + near + 1] = 0.0
    chosen = sorted(chosen, reverse=True)[: EVENT.events_max]
    found = _told(evidence, chosen, rows)
    if found is None or found.log_p_value > EVENT.jumps_suspected:
        return found
    return _told(evidence, [one for one in chosen if not _is_blow(evidence, one[1], one[2])], rows)


def _told(evidence: Evidence, chosen: Sequence[tuple[float, int, int]], trials: float) -> Shape | None:
    """Jumps in given rows of given logs, as a shape."""
    tables = []
    for number, source in enumerate(evidence.sources):
        errors = np.zeros((len(chosen), len(source.log)))
        for i, (_, which, row) in enumerate(chosen):
            if which == number:
                errors[i, row:] = 1.0
        tables.append(source.rows_of_readings(evidence.alongs[number], errors, evidence.model.axis.mass))
    times = [evidence.sources[n].log.time[row] - evidence.sources[n].log.time[0] for _, n, row in chosen]
    smallest = EVENT.jump_counts * evidence.model.encoder.resolution
    return _best(evidence, JUMPS, tables, times, trials, smallest)


def _is_blow(evidence: Evidence, number: int, row: int) -> bool:
    """Whether a short force about a row explains more of the residual there than a step of the reading does."""
    source, along, mass = evidence.sources[number], evidence.alongs[number], evidence.model.axis.mass
    n, h = len(source.log), source.scales.sample_time
    error, blows = np.zeros((1, n)), []
    error[0, row:] = 1.0
    for length in {max(1, round(seconds / h)) for seconds in EVENT.blow_lengths}:
        for first in (row - length, row - length // 2, row):
            blow = np.zeros(n)
            blow[max(0, first) : first + length] = 1.0
            blows.append(blow)
    rows = np.vstack([source.rows_of_readings(along, error, mass), source.rows_of_forces(along, np.array(blows), mass)])
    other = [np.zeros((len(rows), len(one.log))) for one in evidence.sources]
    other[number] = rows
    told = [evidence.test(evidence.whitened([table[i : i + 1] for table in other])).statistic for i in range(len(rows))]
    return max(told[1:]) > told[0]


def _friction_intervals(evidence: Evidence, forces: list[FloatArray]) -> Shape | None:
    """Intervals in which friction is higher or lower: the strongest that do not overlap."""
    found: list[tuple[float, int, int, int]] = []
    trials = 0.0
    for number, (source, force) in enumerate(zip(evidence.sources, forces, strict=True)):
        strongest, tried = _strongest(source, force)
        found += [(score, number, row, length) for score, row, length in strongest]
        for count in tried:
            trials += count
    chosen = _apart(found)
    tables = []
    for number, source in enumerate(evidence.sources):
        along = evidence.alongs[number]
        columns = np.zeros((len(chosen), len(source.log)))
        for i, (_, which, row, length) in enumerate(chosen):
            if which == number:
                columns[i, row : row + length] = np.sign(along.middle_velocity[row : row + length])
        tables.append(source.rows_of_forces(along, columns, evidence.model.axis.mass))
    times = [
        evidence.sources[n].log.time[row + length // 2] - evidence.sources[n].log.time[0]
        for _, n, row, length in chosen
    ]
    return _best(evidence, FRICTION_INTERVALS, tables, times, trials)


def _strongest(source: Innovations, force: FloatArray) -> tuple[list[tuple[float, int, int]], list[float]]:
    """The strongest intervals in a log, as (score, first row, rows), and how many were tried of each length."""
    total = np.concatenate([[0.0], np.cumsum(force * source.mask)])
    found, trials = [], []
    for seconds in EVENT.friction_lengths:
        length = max(2, round(seconds / source.scales.sample_time))
        if length >= len(force):
            continue
        score = (total[length:] - total[:-length]) ** 2
        level = level_of(score[score > 0.0])
        if level <= 0.0:
            continue
        trials.append(float(source.mask.sum()) / length)
        for _ in range(EVENT.events_max):
            row = int(np.argmax(score))
            if score[row] <= EVENT.friction_level * level:
                break
            found.append((float(score[row]) / level, row, length))
            score[max(0, row - length // 2) : row + length // 2 + 1] = 0.0
    return found, trials


def _apart(found: Sequence[tuple[float, int, int, int]]) -> list[tuple[float, int, int, int]]:
    """Of intervals, as (score, log, first row, rows), the strongest that do not overlap in a log."""
    chosen: list[tuple[float, int, int, int]] = []
    for one in sorted(found, reverse=True):
        if len(chosen) == EVENT.events_max:
            break
        if all(o[1] != one[1] or one[2] >= o[2] + o[3] or o[2] >= one[2] + one[3] for o in chosen):
            chosen.append(one)
    return chosen


def _best(
    evidence: Evidence,
    coordinate: str,
    tables: list[FloatArray],
    times: list[float],
    trials: float,
    smallest: float = 0.0,
) -> Shape | None:
    """As many of the events, the strongest first, as are the least likely to be noise; none below the smallest."""
    if times:
        test = evidence.test(evidence.whitened(tables))
        large = [i for i in range(len(times)) if abs(test.amplitudes[i]) > smallest]
        tables, times = [table[large] for table in tables], [times[i] for i in large]
    best: Shape | None = None
    for count in range(1, len(times) + 1):
        test = evidence.test(evidence.whitened([table[:count] for table in tables]))
        if test.freedom == 0:
            continue
        value = min(test.statistic, evidence.bounded(test))
        chance = log_survival(value, test.freedom) + log_choices(trials, count) + float(np.log(EVENT.events_max))
        if best is None or chance < best.log_p_value:
            order = np.argsort(times[:count])
            best = Shape(
                coordinate,
                "s",
                replace(test, statistic=value),
                np.asarray(times[:count])[order],
                -test.amplitudes[order],
                test.deviations[order],
                min(0.0, chance),
                0.0,
            )
    return best
