"""Figures of a gap: bands, the spectrum, what becomes of colours and text."""

import re

import numpy as np
import pytest

from cogging.diagnosis.report.pictures import COLOURS, in_schemes, pictures_of, spectrum
from cogging.plot.gaps import Rows, binned
from tests.fixtures.drawn_results import drawn_result


def test_bands_hold_the_truth_and_the_spectrum_its_scale():
    rng = np.random.default_rng(0)
    inside = []
    for _ in range(200):
        block = np.repeat(np.arange(60), 50)
        gap = 0.3 + np.repeat(rng.normal(0.0, 1.0, 60), 50) + rng.normal(0.0, 0.1, 3000)
        _, mean, half = binned(Rows(gap, {"place": rng.uniform(0.0, 1.0, 3000)}, block), "place")
        inside.append(np.abs(mean - 0.3) < half)
    assert 0.9 < np.mean(inside) < 0.98  # rows of a block say the same; bands of single rows would hold 25 %
    frequency, density = spectrum(np.arange(20000) / 1000.0, rng.normal(0.0, 2.0, 20000))
    assert frequency[-1] == pytest.approx(500.0, rel=1e-2)
    assert np.sqrt(np.mean(density**2)) == pytest.approx(2.0 / np.sqrt(500.0), rel=0.05)


def test_every_colour_of_a_figure_is_one_of_the_page_in_light_and_dark():
    pictures = pictures_of(drawn_result(np.random.default_rng(1), "ambiguous"))
    drawn = "".join(one.svg for part in pictures.values() for one in part)
    assert set(re.findall(r"#[0-9a-f]{6}", drawn)) == set()
    used = set(re.findall(r"var\((--\w+)\)", drawn))
    assert {"--first", "--second", "--soft"} <= used <= set(COLOURS.values())
    light, dark = in_schemes(drawn).values()
    assert "var(" not in light + dark
    assert light.count("#0072b2") == dark.count("#56b4e9") > 0
