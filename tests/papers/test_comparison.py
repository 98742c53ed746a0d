"""The comparison of the three papers' controllers on the same machines."""

from pathlib import Path

import numpy as np
import pytest

import cogging
from cogging.papers import comparison
from cogging.papers.lu2008 import gantry
from studies import comparison_gains


def test_the_comparison_is_that_of_the_evidence():
    result = cogging.compare()
    assert {row.status for table in result.tables for row in table.rows} == {"exploratory"}
    evidence = (Path(__file__).parents[2] / "docs" / "evidence.md").read_text(encoding="utf-8")
    for table in result.tables:
        for line in table.text().splitlines()[1:]:  # but for the last column of the first, the time of a step
            assert (line[:-11] if table is result.tables[0] else line).rstrip() in evidence, line


@pytest.mark.parametrize("name", ["pid", "observer_based"])
def test_scaled_controllers_have_the_stated_delay_margin(name):
    for axis in gantry.AXES.values():
        margin = comparison_gains.delay_margin(comparison.at_equal_margin(axis)[name], axis)
        assert margin == pytest.approx(comparison.DELAY_MARGIN, rel=0.08), axis.name


def test_the_comparisons_gains_are_those_of_the_design():
    shipped = comparison.shipped()["own"]
    for name, radius in comparison.POLE_RADII.items():
        made = cogging.design_observer(comparison.observer_problem(radius)).observer_gain
        np.testing.assert_allclose(shipped[name], made, rtol=0.02, atol=1e-3 * np.abs(made).max())
