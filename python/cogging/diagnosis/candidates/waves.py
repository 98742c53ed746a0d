"""Effects that are a sine and a cosine of one period or frequency: found at once by a spectrum of the adjoint."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from cogging._core import AxisParameters, Plant, Prediction, Predictor, whiten
from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.signatures import (
    Candidate,
    known_periods,
    quantities,
    shape_range,
    turn_periods,
)
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.noise_filter import Filter, coloured
from cogging.diagnosis.thresholds import GRID, SPECTRUM
from cogging.effects.effect import Effect, Wave, kind_of
from cogging.estimation.innovations import Innovations


def plain_wave(effect: Effect) -> Wave | None:
    """The sine, the cosine and the one period or frequency of which an effect consists; None where it is more."""
    wave = kind_of(effect, Wave)
    searched = {field for field, role in effect.ROLES.items() if role["role"] != "setting"}
    if wave is None or searched != {wave.shape, wave.sine, wave.cosine} or isinstance(getattr(effect, wave.sine), list):
        return None
    return wave


def is_wave(effect: Effect) -> bool:
    """Whether an effect is a sine and a cosine of one period or frequency."""
    return plain_wave(effect) is not None


def is_spatial_wave(effect: Effect) -> bool:
    """Whether it is a wave along the travel."""
    wave = plain_wave(effect)
    return wave is not None and bool(effect.ROLES[wave.shape]["quantity"] == "distance")


Gain = Callable[[Innovations, Prediction], FloatArray]  # by what a wave is multiplied in each row, (n,)


def peaks(evidence: Evidence, effect: Effect, gain: Gain | None = None) -> tuple[list[Candidate], float]:
    """The likeliest waves of an effect, and how many independent ones were tried.

    `gain`: instead of the effect's own, of a force (the command for one that acts by its gain, else 1).
    """
    spatial = is_spatial_wave(effect)
    wave_low, wave_high = wave_range(evidence, effect)
    statistic, wave = spectrum_of_score(evidence, effect, gain)
    statistic[(wave < wave_low) | (wave > wave_high)] = 0.0
    span = evidence.scales.position if spatial else evidence.scales.time
    cogging = evidence.model.cogging
    if spatial and gain is None and "force" in effect.HOOKS:
        owned = turn_periods(evidence.model)
        if cogging is not None and cogging.sine.shape[1] == 1:
            # Their sines and cosines are re-tuned: within a turn it is no other wave, but they change along the travel.
            owned += known_periods(evidence.model)
        for period in owned:
            statistic[np.abs(wave - 1.0 / period) < 1.0 / span] = 0.0
    even = levelled(statistic)
    trials = max(1.0, (min(wave_high, float(wave[-1])) - wave_low) * span)
    found = []
    # Both views, for a few broad peaks may lift the level of their stretch, and loud stretches hide quiet ones.
    for view in (even, statistic) * SPECTRUM.peaks_exact:
        best = int(np.argmax(view))
        if view[best] <= SPECTRUM.peak_min:
            continue
        value = 1.0 / float(wave[best]) if spatial else float(wave[best])
        found.append(wave_of(evidence, effect, value))
        near = np.abs(wave - wave[best]) < 1.0 / span
        even[near] = statistic[near] = 0.0
    return found, trials


def wave_range(evidence: Evidence, effect: Effect) -> tuple[float, float]:
    """Lowest and highest wavenumber (1/m), or frequency (Hz), at which a wave is sought."""
    role = next(r for r in effect.ROLES.values() if r["role"] == "shape")
    sizes = quantities(evidence)
    if role["quantity"] != "distance":
        return shape_range(evidence, role)
    low, high = role["low"] * sizes["distance"], role["high"] * sizes["distance"]
    wave_low, wave_high = 1.0 / high, 1.0 / low
    if "reading" not in effect.HOOKS:  # faster than a quarter of the sample rate, rows no longer follow it
        return wave_low, min(
            wave_high, SPECTRUM.followed_rate / (evidence.scales.sample_time * evidence.scales.velocity)
        )
    # Longer, it is a scale; shorter, the quantiser's own.
    wave_low = max(wave_low, SPECTRUM.reading_turns / sizes["position"])
    if evidence.model.encoder.resolution > 0.0:
        wave_high = min(wave_high, 1.0 / (SPECTRUM.rounding_counts * evidence.model.encoder.resolution))
    return wave_low, wave_high


def spectrum_of_score(evidence: Evidence, effect: Effect, gain: Gain | None) -> tuple[FloatArray, FloatArray]:
    """|score|^2 over its variance, chi-square with 2 degrees of freedom; and wavenumbers (1/m) or frequencies (Hz)."""
    spatial, on_reading = is_spatial_wave(effect), "reading" in effect.HOOKS
    span = evidence.scales.position if spatial else evidence.scales.time
    # Rows that share a bin in time would fold what is faster than the bins into lines that are not there.
    rows = 0 if spatial else 1 << int(np.ceil(np.log2(span / evidence.scales.sample_time + 1.0)))
    bins = max(SPECTRUM.bins, rows)
    origin = min(float(s.log.position.min()) for s in evidence.sources) if spatial else 0.0
    scores, powers, start = [], [], 0
    wave = np.zeros(0)
    for source, filter_, along in zip(evidence.sources, evidence.filters, evidence.alongs, strict=True):
        n = len(source.log)
        residual = evidence.free_residual[start : start + n]
        start += n
        if gain is not None:
            weight = gain(source, along)
        else:
            weight = source.log.command if "command_gain" in effect.HOOKS else np.ones(n)
        score, power, wave = _score(
            evidence, source, filter_, along, residual, weight, on_reading, spatial, origin, span, bins
        )
        scores.append(score)
        powers.append(power)
    total, norm = sum(scores[1:], scores[0]), sum(powers[1:], powers[0])
    return np.abs(total) ** 2 / np.maximum(norm, SPECTRUM.variance_min * float(norm.max())), wave


def wave_of(evidence: Evidence, effect: Effect, value: float) -> Candidate:
    """The wave of an effect at one period, or frequency."""
    wave = plain_wave(effect)
    if wave is None:
        raise ValueError(f"{effect.NAME}: must be a wave")
    role = effect.ROLES[wave.sine]
    unit = GRID.unit_share * abs(role["high"]) * quantities(evidence)[role["quantity"]]
    return Candidate(effect, {wave.shape: value}, ((wave.sine, None), (wave.cosine, None)), (unit, unit))


def levelled(statistic: FloatArray) -> FloatArray:
    """The statistic of a spectrum, divided in each stretch of it by how far its median is above that of chi-square.

    Where a force hardly reaches the reading, what leaks in from elsewhere would outshine a line that is really there.
    """
    edges = np.arange(0, len(statistic) + 1, SPECTRUM.level_bins)
    edges[-1] = len(statistic)
    result = statistic.copy()
    for first, last in itertools.pairwise(edges):
        result[first:last] /= max(1.0, float(np.median(statistic[first:last])) / (2.0 * np.log(2.0)))
    return result


def _score(
    evidence: Evidence,
    source: Innovations,
    filter_: Filter,
    along: Prediction,
    residual: FloatArray,
    gain: FloatArray,
    on_reading: bool,
    spatial: bool,
    origin: float,
    span: float,
    bins: int,
) -> tuple[npt.NDArray[np.complex128], FloatArray, FloatArray]:
    """Score and its variance over wavenumbers (1/m) or frequencies (Hz)."""
    model = evidence.model
    force, reading = adjoint(source, filter_, along, model.axis.mass, residual)
    back = reading if on_reading else force
    place = (
        (along.position if on_reading else along.middle_position) if spatial else source.log.time - source.log.time[0]
    )
    length = 2 * bins
    width = 2.0 * span / length  # twice the span: wavenumbers finer than independent ones
    inside = np.clip(((place - (origin if spatial else 0.0)) / width).astype(np.int64), 0, length - 1)
    spectrum = np.fft.rfft(np.bincount(inside, back * gain, length)[:length])
    wave = np.arange(len(spectrum)) / (width * length)
    frequency, response = _response(source, filter_, model.axis.mass, on_reading)
    weight = source.mask * gain**2
    if spatial:
        speed = np.abs(along.middle_velocity)
        edges = np.linspace(0.0, float(speed.max()) + 1e-12, SPECTRUM.speed_edges)
        share, _ = np.histogram(speed, edges, weights=weight)
        middle = 0.5 * (edges[1:] + edges[:-1])
        power = np.zeros(len(wave))
        for one, velocity in zip(share, middle, strict=True):
            power += 0.5 * one * np.interp(wave * velocity, frequency, response, right=0.0)
    else:
        power = 0.5 * weight.sum() * np.interp(wave, frequency, response, right=0.0)
    # |score|^2 / power is chi-square with 2 degrees of freedom: sine and cosine each have half the weight.
    return spectrum, power, wave


def adjoint(
    source: Innovations, filter_: Filter, along: Prediction, mass: float, residual: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Derivatives of half the squared whitened residual (n,) by a force in each interval and an error of each reading.

    One pass backwards through the filters and the observer's loop: the scores of all effects are sums of these.
    """
    back = coloured(residual[None, :], source, filter_)[0] * source.mask / filter_.rms
    back = np.asarray(whiten(back[None, ::-1], list(filter_.coefficients)))[0, ::-1] * source.scale
    force, reading = source.predictor.propagate_transposed(along, mass, np.ascontiguousarray(back))
    return np.asarray(force), np.asarray(reading)


def _response(source: Innovations, filter_: Filter, mass: float, reading: bool) -> tuple[FloatArray, FloatArray]:
    """Power gain from a force (or an error of the reading) to the whitened residual over frequency, Hz.

    By what one impulse does to the prediction of a free mass, which is all that the loop of the observer adds.
    """
    h, rows = source.scales.sample_time, SPECTRUM.probe_rows
    time, impulse = h * np.arange(rows), np.zeros((1, rows))
    impulse[0, rows // SPECTRUM.probe_start] = 1.0
    free = Predictor(time, time, np.zeros(rows), bandwidth=source.bandwidth, initial_velocity=1.0)  # at 1 m/s
    along = free.predict(Plant(axis=AxisParameters(mass=mass)))
    answer = free.propagate(along, mass, *((np.zeros_like(impulse), impulse) if reading else (impulse,)))
    white = np.asarray(whiten(np.asarray(answer), list(filter_.coefficients)))[0]
    frequency = np.asarray(np.fft.rfftfreq(rows, h))
    level = np.interp(frequency, filter_.frequency, filter_.level)
    return frequency, np.asarray(np.abs(source.scale * np.fft.rfft(white) / filter_.rms) ** 2 / level)


def beside_known(evidence: Evidence, effect: Effect) -> list[Candidate]:
    """Waves along the travel about the periods of the known cogging, of what is no force itself.

    Re-tuning the cogging takes most of what they do, and a spectrum does not allow for that: it would hardly show them.
    A force there is no other harmonic but the known one, changing along the travel.
    """
    if not is_spatial_wave(effect) or "force" in effect.HOOKS:
        return []
    role = next(r for r in effect.ROLES.values() if r["role"] == "shape")
    sizes = quantities(evidence)
    span = evidence.scales.position
    found = []
    for period in known_periods(evidence.model):
        for turns in span / period + np.array(SPECTRUM.beside_known):
            if turns > SPECTRUM.reading_turns and role["low"] < span / turns / sizes[role["quantity"]] < role["high"]:
                found.append(wave_of(evidence, effect, float(span / turns)))
    return found


def refine(evidence: Evidence, found: Sequence[Candidate]) -> list[Candidate]:
    """Each wave at four periods (or frequencies) about the one given, within the width of its peak."""
    near = []
    for candidate in found:
        field, value = next(iter(candidate.shape.items()))
        role = candidate.law.ROLES[field]
        spatial = role["quantity"] == "distance"
        span = evidence.scales.position if spatial else evidence.scales.time
        for shift in SPECTRUM.beside_peak:
            wave = (1.0 / value if spatial else value) + shift / span
            if wave > 0.0:
                near.append(
                    Candidate(
                        candidate.law, {field: 1.0 / wave if spatial else wave}, candidate.amplitudes, candidate.unit
                    )
                )
    return near
