"""Bands and spectra of the figures."""

import numpy as np
import pytest

from cogging.diagnosis.report.binning import binned, spectrum


def test_bands_hold_the_truth_and_the_spectrum_its_scale():
    rng = np.random.default_rng(0)
    inside = []
    for _ in range(200):
        block = np.repeat(np.arange(60), 50)
        gap = 0.3 + np.repeat(rng.normal(0.0, 1.0, 60), 50) + rng.normal(0.0, 0.1, 3000)
        _, mean, half = binned(rng.uniform(0.0, 1.0, 3000), gap, block.astype(float), np.linspace(0.0, 1.0, 5))
        inside.append(np.abs(mean - 0.3) < half)
    assert 0.9 < np.mean(inside) < 0.98  # rows of a block say the same; bands of single rows would hold 25 %
    frequency, density = spectrum(np.arange(20000) / 1000.0, rng.normal(0.0, 2.0, 20000))
    assert frequency[-1] == pytest.approx(500.0, rel=1e-2)
    assert np.sqrt(np.mean(density**2)) == pytest.approx(2.0 / np.sqrt(500.0), rel=0.05)
