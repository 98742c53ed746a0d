"""Errors of the cogging map."""

import numpy as np
import pytest

import cogging
from cogging import EFFECTS
from cogging.diagnosis.search.search import search
from tests.fixtures.moving_axis import machine, record


def test_an_error_of_the_map_is_retuning_where_no_effect_explains_more():
    """The amplitude changes along the travel. What is added to it everywhere is no size and no phase."""
    nominal = machine(force=0.004)
    basis = cogging.SplineHarmonics(pitch=0.03, harmonics=[1], order=3, origin=-0.2, control_points=18)
    places = np.linspace(0.0, 1.0, 18)
    sine, cosine = 0.4 + 0.3 * np.sin(5.0 * places), 0.2 + 0.1 * np.cos(4.0 * places)
    axis = nominal.axis.replace(travel=[-0.2, 0.2])
    mapped = nominal.replace(axis=axis, cogging=cogging.CoggingModel(basis, [sine], [cosine]))
    for wrong, free in ((sine + 0.2, True), (1.2 * sine, False), (sine, False)):
        truth = mapped.replace(cogging=cogging.CoggingModel(basis, [wrong], [1.0 * cosine]))
        found = search([record(truth, 31)], mapped)
        assert found.added == []
        assert ("cogging.sine[0][*]" in found.nominal.paths) == free
    scaled = mapped.replace(effects=(EFFECTS["encoder_scale_error"](scale=2e-3),))
    found = search([record(scaled, 31)], mapped)
    assert [one.finding.name for one in found.added] == ["encoder_scale_error"]
    assert found.estimate.values[list(found.estimate.paths).index("effects.encoder_scale_error.scale")] == (
        pytest.approx(2e-3, rel=0.1)
    )
