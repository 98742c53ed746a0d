"""Localisation of a gap without naming an effect: coordinates, places, spatial periods and frequencies."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from cogging.calls import check_arguments
from cogging.diagnosis.balance.candidates import Search, peaks_of, sharpen, wave_scan, wave_sum
from cogging.diagnosis.balance.cells import hats
from cogging.diagnosis.balance.decision import Outcome
from cogging.diagnosis.balance.differenced_balance import DifferencedBalance
from cogging.diagnosis.balance.evidence import Evidence
from cogging.diagnosis.generic_force import Predicted, predicted
from cogging.diagnosis.location import SIGNIFICANT, Location, Wave
from cogging.diagnosis.preparation import Logs, read_logs
from cogging.diagnosis.yardstick import Discrepancy, Yardstick
from cogging.log_check.log_audit import check_against_model
from cogging.model.model import Model
from cogging.resources import on_one_blas_thread
from cogging.simulation.arguments import LOGS, MODEL

PLACES = 12  # nodes of the generic force that is tested along each coordinate
WAVES = 4  # maximum number of frequencies that are tested
TURNS = 4.0  # minimum periods in the travel or the log; slower waves show in the coordinates
SHADOW = 0.1  # of the largest share: smaller waves are side lobes
SMALL = 1e-3  # of the rms command: a smaller gap is integration and rounding error
ROUNDS = 3  # of re-tuning


@check_arguments(logs=LOGS, model=MODEL)
@on_one_blas_thread(scipy=True)
def locate_gap(logs: Logs, model: Model | str | os.PathLike[str]) -> Location:
    """Locate the gap between logs and a model by coordinate, place, spatial period and frequency.

    The model is first re-tuned within its stated uncertainty. The unexplained force is then tested against a generic
    force along each coordinate and against waves in position and time. No effect is named.

    Args:
        logs: one log or several, or their files.
        model: model to compare with the logs, or its file.

    Returns:
        Shares of the gap by coordinate, spatial period and frequency; print it to read them.

    Raises:
        ValueError: a log or the model is invalid.
        InputError: a file cannot be read.

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
    balances = [DifferencedBalance(log, model.axis.coulomb_width, model.encoder.resolution) for log in read]
    evidence = Evidence(balances, model, model).prepare(ROUNDS, listen=True)
    found = Outcome(evidence, evidence, evidence, [], [], [])
    gap = Yardstick(found, read, (), model, replay=False).on_given(evidence.model)
    return location_of(evidence, gap, predicted(gap))


def location_of(evidence: Evidence, gap: Discrepancy, rest: Predicted) -> Location:
    """Return the location of the unexplained force of a re-tuned model.

    Args:
        evidence: evidence of the given logs under that model.
        gap: unexplained force.
        rest: prediction of it by a generic force.
    """
    shapes = []
    nothing = gap.rms < SMALL * gap.rms_of("command")
    for curve in rest.curves:
        name, tables = curve.coordinate, []
        for b, u in zip(evidence.balances, evidence.drives, strict=True):
            table = hats(u if name == "command" else getattr(b, name), _places(evidence, name))
            if name == "position":
                table = np.vstack([table * (b.velocity > 0.0), table * (b.velocity <= 0.0)])
            tables.append(b.rows(table))
        statistic, _, freedom = evidence.score(tables)
        chance = float(chi2.logsf(statistic, max(freedom, 1)) + np.log(len(rest.curves)))
        shapes.append(replace(curve, statistic=statistic, log_p_value=0.0 if nothing else min(chance, 0.0)))
    shapes.sort(key=lambda shape: shape.log_p_value)
    series = gap.columns | {"gap": list(gap.series), "mask": [mask.astype(float) for mask in gap.masks]}
    return Location(tuple(shapes), () if nothing else tuple(_waves(evidence, gap)), gap.rms, evidence.model, series)


def _places(evidence: Evidence, name: str) -> np.ndarray:
    """Return the nodes of a coordinate: equally spaced along position and time, else at quantiles."""
    drives = zip(evidence.balances, evidence.drives, strict=True)
    values = np.concatenate([(u if name == "command" else getattr(b, name))[b.keep > 0] for b, u in drives])
    if name in ("position", "time"):
        return np.linspace(float(values.min()), float(values.max()), PLACES)
    places = np.unique(np.quantile(values, np.linspace(0.0, 1.0, PLACES)))
    return places if len(places) > 1 else np.array([values.min() - 1.0, values.max() + 1.0])


def _waves(evidence: Evidence, gap: Discrepancy) -> list[Wave]:
    """Return the significant waves of force in position and in time, the strongest first."""
    search, balances = Search(evidence), evidence.balances
    weights, travel, duration = search.weights, float(search.length), float(search.duration)

    def refine(name: str, number: float, extent: float) -> float:
        return sharpen(wave_sum(weights, [getattr(b, name) for b in balances]), number, 0.25 / extent)

    found: list[tuple[str, float, int]] = []  # coordinate, cycles per unit of it, trials
    peaks, trials = wave_scan(search, [np.ones(len(b.time)) for b in balances])
    found += [("position", refine("position", k, travel), trials) for k, _ in peaks if k * travel >= TURNS]
    size = int(2 ** np.ceil(np.log2(2 * max(len(g) for g in weights))))
    power = np.sum([np.abs(np.fft.rfft(g, size)) ** 2 for g in weights], axis=0)
    frequency = np.asarray(np.fft.rfftfreq(size, balances[0].step), dtype=np.float64)
    power[(frequency < TURNS / duration) | (frequency > 0.4 * evidence.rate)] = 0.0
    for j in peaks_of(power, frequency, 1.0 / duration, WAVES):
        number = refine("time", float(frequency[j]), duration)
        found.append(("time", number, int(duration * 0.4 * evidence.rate)))
    waves: list[Wave] = []
    for name, number, trials in found:
        turns = [2.0 * np.pi * number * getattr(b, name) for b in balances]
        tables = [b.rows(np.vstack([np.sin(t), np.cos(t)])) for b, t in zip(balances, turns, strict=True)]
        statistic, _, freedom = evidence.score(tables)
        chance = float(chi2.logsf(statistic, max(freedom, 1)) + np.log(trials))
        if chance < SIGNIFICANT:
            place = gap.in_motion(name)
            turn = np.array([np.ones(len(place)), *(f(2.0 * np.pi * number * place) for f in (np.sin, np.cos))])
            amplitude = float(np.hypot(*np.linalg.lstsq(turn.T, gap.in_motion(), rcond=None)[0][1:]))
            share = min(1.0, 0.5 * amplitude**2 / gap.rms**2)
            kind = ("spatial period", 1.0 / number, "m") if name == "position" else ("frequency", number, "Hz")
            waves.append(Wave(*kind, amplitude, chance, share))
    waves.sort(key=lambda wave: -wave.share)
    return [wave for wave in waves if wave.share >= SHADOW * waves[0].share]
