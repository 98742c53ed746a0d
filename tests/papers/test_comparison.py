"""The comparison of the three papers' controllers on the same machines."""

import json
from pathlib import Path

import numpy as np
import pytest

import cogging
from cogging.papers import comparison
from cogging.papers.lu2008 import gantry
from studies import comparison_gains

ROOT = Path(__file__).parents[2]


def test_the_evidence_quotes_the_tables_of_the_notebook():
    """They are computed in tests/test_notebooks.py."""
    notebook = json.loads((ROOT / "notebooks" / "04_comparison.ipynb").read_text(encoding="utf-8"))
    outputs = [output for cell in notebook["cells"] for output in cell.get("outputs", [])]
    tables = ["".join(output["text"]) for output in outputs if "    controller " in "".join(output.get("text", []))]
    assert [("exploratory" in table) for table in tables] == [True, False, True]
    evidence = (ROOT / "docs" / "evidence.md").read_text(encoding="utf-8")
    for line in (line for table in tables for line in table.splitlines()[1:]):
        assert line.rstrip() in evidence, line


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
