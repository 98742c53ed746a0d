"""Sweeps: the run of each row, every path, every way of drawing, and wrong arguments."""

import itertools

import numpy as np
import pytest

import cogging
from cogging.simulation.varied import points_of, variation_of
from tests.fixtures.examples import MOVE as STROKE
from tests.fixtures.sweeps import MOVE, SMALL

pytestmark = pytest.mark.filterwarnings("ignore:The balance properties of Sobol")


def test_a_row_is_the_run_that_its_numbers_say():
    gains = {"from": 5e3, "to": 9e3, "points": 2}
    vary = {"axis.mass": [0.1, 0.14], "controller.kp": gains, "reference.frequency": [4, 6]}
    runs = cogging.sweep(SMALL, MOVE, vary, seed=11, reductions=["command_max"])
    expected = list(itertools.product([0.1, 0.14], [5e3, 9e3], [4.0, 6.0]))
    assert list(zip(*(runs.table[path] for path in vary), strict=True)) == expected
    for run, (mass, kp, frequency) in enumerate(expected):
        model = SMALL.replace(axis=SMALL.axis.replace(mass=mass), controller=SMALL.controller.replace(kp=kp))
        log = cogging.simulate(model, {**MOVE, "frequency": frequency}, seed=11 + run)
        assert runs.table["seed"][run] == 11 + run
        assert runs.table["error_rms"][run] == cogging.performance(log.time, log.error, log.command).error_rms
        assert runs.table["command_max"][run] == abs(log.command).max()


def test_a_number_that_breaks_its_rule_is_a_row_with_the_reason():
    runs = cogging.sweep(SMALL, STROKE, {"reference.repeats": [1, 1.5]}, duration=0.1)
    assert runs.table["reason"].tolist() == ["", "reference.repeats: must be a whole number, got 1.5"]


@pytest.mark.parametrize("method", ["random", "latin_hypercube", "sobol"])
def test_draws_have_the_stated_distributions(method):
    stated = {
        "axis.mass": "bounds",
        "axis.viscous": {"from": 0.1, "to": 0.3},
        "controller.kp": {"from": 1e2, "to": 1e4, "scale": "log"},
        "axis.coulomb": {"mean": 0.2, "deviation": 0.01},
        "seed": [1, 5, 9],
    }
    variations = [variation_of(path, how, SMALL) for path, how in stated.items()]
    drawn = points_of(variations, method, 4096, 3)
    np.testing.assert_array_equal(drawn, points_of(variations, method, 4096, 3))
    assert (drawn != points_of(variations, method, 4096, 4)).any()
    mass, viscous, gain, coulomb, seed = drawn.T
    wide = 1.0 if method == "random" else 0.3  # of four standard errors: the others fill space evenly
    assert np.mean((mass > 0.11) & (mass < 0.135)) == pytest.approx(0.95, abs=0.014 * wide)
    assert np.median(mass) == pytest.approx(0.12, abs=1e-3 * wide)
    assert np.quantile(viscous, [0, 0.25, 1]) == pytest.approx([0.1, 0.15, 0.3], abs=6e-3 * wide)
    assert np.median(np.log10(gain)) == pytest.approx(3.0, abs=0.08 * wide)
    assert coulomb.std() == pytest.approx(0.01, rel=0.05 * wide + 0.01)
    assert [np.mean(seed == value) for value in (1, 5, 9)] == pytest.approx([1 / 3] * 3, abs=0.03 * wide)
    assert np.corrcoef(drawn.T)[np.triu_indices(5, 1)] == pytest.approx(0.0, abs=0.07)
