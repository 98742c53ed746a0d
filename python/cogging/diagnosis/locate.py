"""Locating a gap before anything is named: which coordinate, which place in it, which period or frequency."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cogging._core import DivergedError
from cogging.arrays import FloatArray
from cogging.blas_threads import on_one_blas_thread
from cogging.calls import takes
from cogging.diagnosis.candidates.findings import Finding, judged
from cogging.diagnosis.candidates.scan import sharpen
from cogging.diagnosis.candidates.tables import tables
from cogging.diagnosis.candidates.waves import is_wave, peaks, refine
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.given_logs import Logs, read_logs
from cogging.diagnosis.evidence.null import fit_null
from cogging.diagnosis.evidence.score_test import orthonormal
from cogging.diagnosis.location import Location, Wave
from cogging.diagnosis.residual.events import with_events
from cogging.diagnosis.residual.shape import Shape
from cogging.diagnosis.residual.shapes import low_power, shapes
from cogging.diagnosis.thresholds import GAP, LOCATION
from cogging.effects.effect import VOCABULARY, Effect
from cogging.estimation.statistics import moving_average
from cogging.log_check.unit_check import check_against_model
from cogging.model.model import Model
from cogging.simulation.arguments import LOGS, MODEL


@takes(logs=LOGS, model=MODEL)
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
    estimate, evidence = fit_null(read, model)
    return location_of(evidence, estimate.model)


def location_of(evidence: Evidence, model: Model, found: Sequence[Shape] | None = None) -> Location:
    """The location of what evidence of a re-tuned model leaves; `found`: its shapes, where they are known."""
    mask = np.concatenate([source.mask > 0 for source in evidence.sources])
    left = np.concatenate(evidence.residuals)[mask]
    return Location(
        tuple(with_events(evidence, shapes(evidence)) if found is None else found),
        tuple(waves_of(evidence)),
        float(np.sqrt(np.mean(left**2))),
        model,
        series_of(evidence, evidence.residuals),
    )


def series_of(evidence: Evidence, gap: Sequence[FloatArray]) -> dict[str, list[FloatArray]]:
    """Rows of the logs by name, with a gap (V), one (n,) a log."""
    series: dict[str, list[FloatArray]] = {"gap": [np.asarray(row) for row in gap]}
    for source in evidence.sources:
        log, velocity = source.log, source.along.velocity
        smooth = moving_average(velocity, round(GAP.smoothing / source.scales.sample_time))
        for name, values in (
            ("time", log.time),
            ("position", log.position),
            ("command", log.command),
            ("velocity", velocity),
            ("acceleration", np.gradient(smooth, log.time)),
            ("mask", source.mask > 0),
        ):
            series.setdefault(name, []).append(np.asarray(values))
    return series


def waves_of(evidence: Evidence) -> list[Wave]:
    """Waves of force in place and in time, the strongest first, each seen beside those before it.

    The list of effects is asked which of them are a plain force of one period or of one frequency.
    """
    kinds = [effect for effect in VOCABULARY.values() if is_wave(effect) and set(effect.HOOKS) == {"force"}]
    found: list[Wave] = []
    power = low_power(evidence)
    for _ in range(LOCATION.waves_max):
        best: Finding | None = None
        for kind in kinds:
            for finding in _waves(evidence, kind):
                if best is None or finding.score > best.score:
                    best = finding
        if best is None or best.log_p_value > LOCATION.told:
            break
        best = sharpen(evidence, best)
        field, value = next(iter(best.candidate.shape.items()))
        if found and best.test.statistic / power < LOCATION.wave_share_min * found[0].share:
            break
        spatial = best.candidate.law.ROLES[field]["quantity"] == "distance"
        found.append(
            Wave(
                "spatial period" if spatial else "frequency",
                float(value),
                "m" if spatial else "Hz",
                float(np.hypot(*best.amplitudes)),
                best.log_p_value,
                min(1.0, best.test.statistic / power),
            )
        )
        columns = evidence.project(evidence.whitened(tables(evidence, [best.candidate])[0]))
        evidence = replace(evidence, basis=np.vstack([evidence.basis, orthonormal(columns)]))
    return sorted(found, key=lambda wave: -wave.share)


def _waves(evidence: Evidence, law: Effect) -> list[Finding]:
    found, trials = peaks(evidence, law)
    spatial = next(r for r in law.ROLES.values() if r["role"] == "shape")["quantity"] == "distance"
    scales = evidence.scales

    def turns(value: float) -> float:
        return scales.position / value if spatial else scales.time * value

    fast = [candidate for candidate in found if turns(next(iter(candidate.shape.values()))) >= LOCATION.wave_turns_min]
    try:
        return judged(evidence, refine(evidence, fast[: LOCATION.waves_refined]), trials)
    except (DivergedError, ValueError):
        return []
