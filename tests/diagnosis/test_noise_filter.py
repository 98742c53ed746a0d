"""Filters that make residuals white."""

import numpy as np
import pytest

from cogging.diagnosis.evidence.noise_filter import spectrum


def test_spectrum_of_white_noise_is_one(quiet_evidence):
    source = quiet_evidence.sources[0]
    noise = np.random.default_rng(2).normal(size=len(source.log)) * (source.mask > 0)
    _, level = spectrum(noise, source)
    assert np.all((level > 0.4) & (level < 2.2))
    assert np.median(level) == pytest.approx(1.0, abs=0.2)
