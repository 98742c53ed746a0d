"""Waves: the transpose of the observer's loop, and peaks of the spectrum of the score."""

from dataclasses import replace

import numpy as np
import pytest

import cogging
from cogging import EFFECTS
from cogging._core import Predictor
from cogging.diagnosis.candidates import waves
from cogging.diagnosis.candidates.findings import judged
from cogging.diagnosis.candidates.scan import scan
from cogging.diagnosis.evidence.null import fit_null
from cogging.diagnosis.thresholds import SPECTRUM
from cogging.effects.effect import VOCABULARY
from tests.fixtures.moving_axis import machine, record


def test_transpose_of_propagate():
    log = record(machine(), 1)
    predictor = Predictor(log.time, log.position, log.command, bandwidth=40.0)
    along = predictor.predict(machine().plant())
    random = np.random.default_rng(0)
    force, error, weight = random.normal(size=(3, len(log)))
    force[-1] = 0.0  # no interval after the last row
    forward = predictor.propagate(along, 2.0, force[None, :], error[None, :] * 1e-3)[0]
    on_force, on_reading = predictor.propagate_transposed(along, 2.0, weight)
    assert weight @ forward == pytest.approx(on_force @ force + on_reading @ error * 1e-3, rel=1e-9)


def test_a_fast_tone_is_the_first_peak_however_few_bins_there_are(monkeypatch):
    """Bins longer than the rows would fold what is faster into lines that are not there."""
    truth = machine([EFFECTS["disturbance_tone"](frequency=103.0, sine=0.03)])
    evidence = fit_null([record(truth, 21)], machine())[1]
    monkeypatch.setattr(waves, "SPECTRUM", replace(SPECTRUM, bins=256))
    (first, *_), _ = waves.peaks(evidence, VOCABULARY["disturbance_tone"])
    assert first.shape["frequency"] == pytest.approx(103.0, abs=0.2)


def test_a_wave_beside_a_known_period_is_looked_at_though_retuning_takes_most_of_it():
    hidden = EFFECTS["encoder_periodic_error"](period=0.0304, cosine=4e-6)
    evidence = fit_null([record(machine([hidden]), 5)], machine())[1]
    spectral = [one.shape["period"] for one in waves.peaks(evidence, VOCABULARY["encoder_periodic_error"])[0]]
    assert all(abs(period / hidden.period - 1.0) > 0.02 for period in spectral)
    near = waves.beside_known(evidence, VOCABULARY["encoder_periodic_error"])
    turns = evidence.scales.position / np.array([one.shape["period"] for one in near])
    assert len(near) == 5
    np.testing.assert_allclose(turns - evidence.scales.position / 0.03, [-0.7, -0.35, 0.0, 0.35, 0.7], atol=1e-9)
    assert waves.beside_known(evidence, VOCABULARY["disturbance_tone"]) == []
    # A force there is the known cogging itself, changing along the travel.
    assert waves.beside_known(evidence, VOCABULARY["cogging_harmonic"]) == []
    forces = [one.shape["period"] for one in waves.peaks(evidence, VOCABULARY["cogging_harmonic"])[0]]
    assert all(abs(1.0 / period - 1.0 / 0.03) * evidence.scales.position > 0.99 for period in forces)
    best = scan(evidence, VOCABULARY.values())[0]
    assert best.name == "encoder_periodic_error"
    assert best.candidate.shape["period"] == pytest.approx(hidden.period, rel=0.01)
    assert not best.faint
    # Of an encoder whose counts are a hundred times as large, rounding may have made it.
    coarse = replace(evidence, model=evidence.model.replace(encoder=cogging.EncoderParameters(resolution=1e-4)))
    (faint,) = judged(coarse, [best.candidate], 1.0)
    assert faint.faint


def test_an_error_of_the_reading_repeats_in_the_travel(quiet_evidence):
    found, _ = waves.peaks(quiet_evidence, VOCABULARY["encoder_periodic_error"])
    assert found
    assert all(1.5 * one.shape["period"] < 1.01 * quiet_evidence.scales.position for one in found)
    encoder = cogging.EncoderParameters(resolution=1e-4)
    coarse = replace(quiet_evidence, model=quiet_evidence.model.replace(encoder=encoder))
    assert all(
        one.shape["period"] > 0.99 * 32e-4 for one in waves.peaks(coarse, VOCABULARY["encoder_periodic_error"])[0]
    )
