"""What a model lacks moves no good prior: `identify` after `init` on drawn machines with one thing hidden in each."""

import numpy as np
import pytest

import cogging
from tests.fixtures.strokes import HIDDEN, as_believed, drawn


@pytest.fixture(scope="module")
def fits():
    """True mass, mass of the first model and fit; every second first model has the map and the controller."""
    table = []
    for number, hidden in enumerate(hidden for hidden in HIDDEN if hidden != "nothing"):
        machine, log = drawn(0, hidden, rate=500.0)
        first = as_believed(machine, log) if number % 2 else cogging.draft_model(log).model
        table.append((machine.axis.mass, first.axis.mass, cogging.identify(log, first)))
    return table


def test_a_mass_stays_good_and_its_interval_holds_the_truth_whatever_is_hidden(fits):
    truth, prior = (np.array([row[k] for row in fits]) for k in range(2))
    masses = [found["axis.mass"] for *_, found in fits]
    low, high = np.array([mass.ci95 for mass in masses]).T
    assert np.mean((low <= truth) & (truth <= high)) >= 0.9
    assert np.mean([mass.determined for mass in masses]) > 0.5
    worse = (np.abs([mass.value - t for mass, t in zip(masses, truth, strict=True)]) - np.abs(prior - truth)) / truth
    assert np.mean(worse > 0.02) <= 0.1
    assert worse.max() < 0.15
    named = [any("something is missing" in line and "run diagnose" in line for line in f.warnings) for *_, f in fits]
    assert sum(named) >= 8  # of 10: not a tone of its own and a backlash
    for *_, found in fits:
        assert found.model.intervals["axis.mass"] == found["axis.mass"].ci95


def test_a_bad_prior_moves_to_where_the_evidence_is():
    machine, log = drawn(0, "spring", rate=500.0)
    wrong = machine.replace(axis=machine.axis.replace(mass=4.0 * machine.axis.mass), effects=[])
    mass = cogging.identify(log, wrong)["axis.mass"]
    assert mass.value == pytest.approx(machine.axis.mass, rel=0.1)
    assert mass.ci95[0] < machine.axis.mass < mass.ci95[1]
