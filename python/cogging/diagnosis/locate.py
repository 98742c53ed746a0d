"""Locating a gap before anything is named: which coordinate, which place in it, which period or frequency."""

from __future__ import annotations

import os

import numpy as np
from scipy.stats import chi2

from cogging.calls import check_arguments
from cogging.diagnosis.balance.candidates import Search, sharpen, wave_scan
from cogging.diagnosis.balance.cells import hats
from cogging.diagnosis.balance.decision import Outcome
from cogging.diagnosis.balance.evidence import Evidence
from cogging.diagnosis.balance.force_balance import ForceBalance
from cogging.diagnosis.generic_force import Predicted, predicted
from cogging.diagnosis.location import TOLD, Location, Wave
from cogging.diagnosis.places import COORDINATE_UNITS, Shape
from cogging.diagnosis.preparation import Logs, read_logs
from cogging.diagnosis.yardstick import Discrepancy, Yardstick
from cogging.log_check.log_audit import check_against_model
from cogging.model.model import Model
from cogging.resources import on_one_blas_thread
from cogging.simulation.arguments import LOGS, MODEL

PLACES = 12  # at which a force of any shape in one coordinate is tested
WAVES = 4  # periods, and as many frequencies, that are looked at
TURNS = 4.0  # in the travel or the log: coordinates tell slower waves
SHADOW = 0.1  # of the strongest wave's share: weaker ones are its shadows
SMALL = 1e-3  # of the rms command: what is left of less is that of integration and rounding
ROUNDS = 3  # of re-tuning


@check_arguments(logs=LOGS, model=MODEL)
@on_one_blas_thread(scipy=True)
def locate_gap(
    logs: Logs,
    model: Model | str | os.PathLike[str],
) -> Location:
    """Say where logs and a model disagree: in which coordinate, where in it, at which period or frequency.

    The model is re-tuned first, as far as its statement allows; what is left is tested against a force of any shape in
    each coordinate and against waves in place and in time. No effect is named.

    Args:
        logs: one or several, or their files.
        model: what is believed, or its file.

    Returns:
        Shares of the gap by coordinate, and what repeats itself in place or time; print it to read them.

    Raises:
        ValueError: a log or model that cannot be used.
        InputError: a file that cannot be read.

    Example:
        >>> where = cogging.locate_gap(log, model)
        >>> where.significant
        ()
    """
    if not isinstance(model, Model):
        model = Model.read(model)
    read, names = read_logs(logs)
    if not read:
        raise ValueError("logs: must be at least 1, got 0")
    for name, log in zip(names, read, strict=True):
        check_against_model(log, model, name)
    balances = [ForceBalance(log, model.axis.coulomb_width, model.encoder.resolution) for log in read]
    evidence = Evidence(balances, model, model).prepare(ROUNDS, listen=True)
    found = Outcome(evidence, evidence, evidence, [], [], [])
    gap = Yardstick(found, read, (), model, replay=False).on_given(evidence.model)
    return location_of(evidence, gap, predicted(gap))


def location_of(evidence: Evidence, gap: Discrepancy, rest: Predicted) -> Location:
    """The location of what a re-tuned model leaves.

    Args:
        evidence: of the given logs under that model.
        gap: what it leaves.
        rest: what a generic force predicts of that.
    """
    shapes = []
    command = np.concatenate([rows["command"][mask] for rows, mask in zip(gap.rows, gap.masks, strict=True)])
    nothing = gap.rms < SMALL * float(np.sqrt(np.mean(command**2)))
    for curve in rest.curves:
        name, tables = curve.coordinate, []
        for b, u in zip(evidence.balances, evidence.drives, strict=True):
            values = {"command": u}.get(name)
            table = hats(getattr(b, name) if values is None else values, _places(evidence, name))
            if name == "position":
                table = np.vstack([table * (b.velocity > 0.0), table * (b.velocity <= 0.0)])
            tables.append(b.rows(table))
        statistic, _, freedom = evidence.score(tables)
        chance = float(chi2.logsf(statistic, max(freedom, 1)) + np.log(len(rest.curves)))
        shapes.append(
            Shape(
                name,
                COORDINATE_UNITS[name],
                curve.places,
                curve.force,
                curve.deviation,
                statistic,
                0.0 if nothing else min(chance, 0.0),
                curve.share,
            )
        )
    shapes.sort(key=lambda shape: shape.log_p_value)
    series = {name: [rows[name] for rows in gap.rows] for name in gap.rows[0]}
    series |= {"gap": list(gap.series), "mask": [mask.astype(float) for mask in gap.masks]}
    return Location(tuple(shapes), () if nothing else tuple(_waves(evidence, gap)), gap.rms, evidence.model, series)


def _places(evidence: Evidence, name: str) -> np.ndarray:
    drives = zip(evidence.balances, evidence.drives, strict=True)
    values = np.concatenate([(u if name == "command" else getattr(b, name))[b.keep > 0] for b, u in drives])
    if name in ("position", "time"):
        return np.linspace(float(values.min()), float(values.max()), PLACES)
    places = np.unique(np.quantile(values, np.linspace(0.0, 1.0, PLACES)))
    return places if len(places) > 1 else np.array([values.min() - 1.0, values.max() + 1.0])


def _waves(evidence: Evidence, gap: Discrepancy) -> list[Wave]:
    """Waves of force in place and in time, the strongest first."""
    search, balances = Search(evidence), evidence.balances
    weighed = search.weights
    low = min(float(b.position.min()) for b in balances)
    travel = max(float(b.position.max()) for b in balances) - low
    duration = max(float(b.time[-1]) for b in balances)
    found = []
    every = [np.ones(len(b.time)) for b in balances]
    peaks, trials = wave_scan(search, every)
    places, pulls = np.concatenate([b.position for b in balances]), np.concatenate(weighed)
    for number, _ in peaks:
        if number * travel < TURNS:
            continue
        number = sharpen(lambda k: float(abs(pulls @ np.exp(2j * np.pi * k * places))), number, 0.25 / travel)
        found.append(("spatial period", number, 1.0 / number, "m", [b.position for b in balances], trials))
    times = np.concatenate([b.time for b in balances])
    size = int(2 ** np.ceil(np.log2(2 * max(len(g) for g in weighed))))
    loud = np.sum([np.abs(np.fft.rfft(g, size)) ** 2 for g in weighed], axis=0)
    rate = np.fft.rfftfreq(size, balances[0].step)
    loud[(rate < TURNS / duration) | (rate > 0.4 * evidence.rate)] = 0.0
    for _ in range(WAVES):
        number = float(rate[int(np.argmax(loud))])
        if number > 0.0 and loud.max() > 0.0:
            trials = int(duration * 0.4 * evidence.rate)
            loudest = number
            number = sharpen(lambda f: float(abs(pulls @ np.exp(2j * np.pi * f * times))), number, 0.25 / duration)
            found.append(("frequency", number, number, "Hz", [b.time for b in balances], trials))
            loud[np.abs(rate - loudest) < 1.0 / duration] = 0.0
    told: list[Wave] = []
    for coordinate, number, value, unit, along, trials in found:
        turns = [2.0 * np.pi * number * one for one in along]
        tables = [b.rows(np.vstack([np.sin(t), np.cos(t)])) for b, t in zip(balances, turns, strict=True)]
        statistic, _, freedom = evidence.score(tables)
        chance = float(chi2.logsf(statistic, max(freedom, 1)) + np.log(trials))
        if chance < TOLD:
            name = "position" if coordinate == "spatial period" else "time"
            place = np.concatenate([rows[name][mask] for rows, mask in zip(gap.rows, gap.masks, strict=True)])
            left = np.concatenate([row[mask] for row, mask in zip(gap.series, gap.masks, strict=True)])
            turn = np.array([np.ones(len(place)), *(f(2.0 * np.pi * number * place) for f in (np.sin, np.cos))])
            amplitude = float(np.hypot(*np.linalg.lstsq(turn.T, left, rcond=None)[0][1:]))
            share = min(1.0, 0.5 * amplitude**2 / gap.rms**2)
            told.append(Wave(coordinate, float(value), unit, amplitude, chance, share))
    told.sort(key=lambda wave: -wave.share)
    return [wave for wave in told if wave.share >= SHADOW * told[0].share]
