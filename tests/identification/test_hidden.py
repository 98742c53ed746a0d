"""What a model lacks moves no good prior: `identify` after `init` on drawn machines with one thing hidden in each."""

import itertools

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from tests.fixtures.strokes import HIDDEN, as_believed, drawn

CASES = [hidden for hidden in HIDDEN if hidden != "nothing"]


@pytest.fixture(scope="module", params=[[0], pytest.param([0, 1], marks=pytest.mark.study)], ids=["one", "two"])
def fits(request):
    """Truth, first model and fit, for the first model alone and with the map and the controller."""
    table = []
    for seed, hidden in itertools.product(request.param, CASES):
        machine, log = drawn(seed, hidden)
        for first in (cogging.draft_model(log).model, as_believed(machine, log)):
            table.append((machine.axis.mass, first.axis.mass, cogging.identify(log, first)))
    return table


def test_the_interval_of_a_mass_holds_the_truth_whatever_is_hidden(fits):
    held = [found["axis.mass"].ci95[0] <= truth <= found["axis.mass"].ci95[1] for truth, _, found in fits]
    assert np.mean(held) >= 0.9
    told = [found["axis.mass"].determined for _, _, found in fits]
    assert np.mean(told) > 0.5  # and not by telling nothing
    for _, _, found in fits:
        mass = found["axis.mass"]
        assert found.model.intervals["axis.mass"] == mass.ci95
        assert mass.ci95[0] <= found.model.axis.mass == mass.value <= mass.ci95[1]


def test_no_good_mass_is_replaced_by_a_bad_one(fits):
    worse = [abs(found["axis.mass"].value - truth) - abs(prior - truth) for truth, prior, found in fits]
    sizes = np.array(worse) / [truth for truth, _, _ in fits]
    assert np.mean(sizes > 0.02) <= 0.1
    assert sizes.max() < 0.15


@pytest.mark.parametrize("seed", range(2))
def test_a_machine_as_its_model_says_gets_a_narrow_interval_and_a_right_one(seed):
    machine, log = drawn(seed, "nothing")
    found = cogging.identify(log, as_believed(machine, log))
    mass = found["axis.mass"]
    assert mass.ci95[0] < machine.axis.mass < mass.ci95[1]
    assert mass.ci95[1] - mass.ci95[0] < 0.02 * machine.axis.mass
    assert found.warnings == ()


def test_the_prior_stands_and_the_next_command_is_diagnose(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    machine, log = drawn(1, "spring")
    log.write("run.csv")
    assert main(["init", "run.csv"]) == 0
    first = cogging.Model.read("model.toml")
    capsys.readouterr()
    assert main(["identify", "run.csv", "--model", "model.toml", "--out", "fitted.toml"]) == 0
    said, fitted = capsys.readouterr().out, cogging.Model.read("fitted.toml")
    assert fitted.axis.mass == first.axis.mass
    assert fitted.intervals["axis.mass"][0] < machine.axis.mass < fitted.intervals["axis.mass"][1]
    assert "unmodelled forces are too strong to fit axis.mass" in said
    assert "contradict each other" not in said
    assert "worse than the model as given" not in said
    assert said.splitlines()[-1].startswith("next: cogging diagnose run.csv --model model.toml")


def test_a_bad_prior_goes_where_the_evidence_excludes_it():
    machine, log = drawn(0, "spring")
    wrong = machine.replace(axis=machine.axis.replace(mass=4.0 * machine.axis.mass), effects=[])
    mass = cogging.identify(log, wrong)["axis.mass"]
    assert mass.value == pytest.approx(machine.axis.mass, rel=0.1)
    assert mass.ci95[0] < machine.axis.mass < mass.ci95[1]
