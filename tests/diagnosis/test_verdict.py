"""What no effect explains, and by how much it must stand out."""

from dataclasses import replace

import numpy as np
import pytest

import cogging
from cogging.diagnosis.naming.verdict import standing, unlisted
from cogging.diagnosis.residual.shape import FRICTION_INTERVALS, JUMPS
from cogging.diagnosis.residual.shapes import shapes
from cogging.diagnosis.search.search import search
from tests.fixtures.moving_axis import machine, record


@pytest.mark.parametrize(
    ("coordinate", "mine", "its", "checked", "told"),
    [
        ("position", -13.0, -6.0, True, True),
        ("position", -9.0, -18.0, True, True),
        ("position", -7.0, -18.0, True, None),
        ("position", -7.0, -9.0, True, None),
        ("drag over time", -10.0, -24.0, True, True),
        ("drag over time", -13.0, -6.0, True, True),
        ("position", -4.0, -90.0, True, None),
        ("position", -13.0, 0.0, True, None),
        ("position", -13.0, 0.0, False, False),
        ("time", -101.0, 0.0, True, False),
        ("time", -99.0, 0.0, True, None),
        (JUMPS, -19.0, 0.0, True, False),
        (JUMPS, -17.0, -4.0, True, None),
        (JUMPS, -8.0, -6.0, True, True),
        (FRICTION_INTERVALS, -19.0, -9.0, True, None),
        (FRICTION_INTERVALS, -25.0, -14.0, True, None),
        (FRICTION_INTERVALS, -45.0, -20.0, True, True),
        (FRICTION_INTERVALS, -101.0, 0.0, False, True),
    ],
)
def test_what_is_left_stands_by_both_motions(coordinate, mine, its, checked, told, quiet_evidence):
    shape = replace(shapes(quiet_evidence)[0], coordinate=coordinate, log_p_value=mine)
    assert standing(shape, replace(shape, log_p_value=its), checked) is told


def test_where_an_encoder_is_coarse_what_is_left_must_stand_out_twice_as_far():
    told = search([record(machine(), 34)], machine())
    source, part = told.evidence.sources[0], told.evidence.parts[0]
    power = np.mean((part.residual[source.mask > 0] / source.scale) ** 2)
    assert told.evidence.rounding == pytest.approx(1e-14 / 12.0 / power, rel=1e-9)

    def seen_with(resolution):
        encoder = cogging.EncoderParameters(resolution=resolution)
        return replace(told.evidence, model=told.evidence.model.replace(encoder=encoder))

    fine, coarse = seen_with(1e-9), seen_with(1e-5)
    assert fine.rounding < 1e-4
    assert coarse.rounding == 1.0
    shape = replace(shapes(told.evidence)[0], coordinate="position", log_p_value=-20.0)
    for evidence, log_p_value, expected in ((fine, -20.0, True), (coarse, -20.0, False), (coarse, -30.0, True)):
        left = replace(told, evidence=evidence, residual_shapes=[replace(shape, log_p_value=log_p_value)])
        assert (unlisted(left, [], checked=False) is not None) is expected
