"""Detection limits: what every result says of every effect, how they scale, and that they are what they say."""

import json
from dataclasses import replace

import numpy as np
import pytest

import cogging
from cogging.diagnosis.candidates.findings import Finding
from cogging.diagnosis.candidates.signatures import Candidate
from cogging.diagnosis.candidates.sizes import directions, is_sought, likely_shapes, size_of
from cogging.diagnosis.evidence.log_p_value import log_survival
from cogging.diagnosis.evidence.null import fit_null
from cogging.diagnosis.evidence.score_test import ScoreTest
from cogging.diagnosis.limits import limit
from cogging.diagnosis.search.chance import GRID, LAMBDAS, Powers, Visibility, chances
from cogging.diagnosis.search.choice import is_seen, refusal
from cogging.diagnosis.search.confirmation import Confirmation
from cogging.diagnosis.search.growth import View
from cogging.diagnosis.thresholds import CHOICE
from cogging.effects.effect import VOCABULARY
from tests.fixtures.moving_axis import machine, record
from tests.fixtures.own_laws import own_drag
from tests.fixtures.pid_axis import MODEL, run

CHANGES = {"mass_change", "viscous_change", "coulomb_change"}
LISTED = {name for name, law in VOCABULARY.items() if is_sought(law)} | CHANGES


def view_of(logs, model):
    """The null of these logs alone."""
    evidence = fit_null(logs, model)[1]
    return View(evidence, evidence.basis, None, False, Powers(0.0, 0.0))


def limit_of(name, logs, model):
    """The limit of one effect there."""
    return limit(view_of(logs, model), VOCABULARY[name])


# What a result says ---------------------------------------------------------------------------------------------------


def test_every_effect_is_listed_as_the_contract_says(found):
    told = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert set(told["limits"]) == LISTED
    assert "empirical_force" not in LISTED
    assert len(LISTED) == 26
    shown = {name: entry for name, entry in told["limits"].items() if entry is not None}
    assert len(shown) > 15
    for name, entry in shown.items():
        assert set(entry) >= {"parameter", "value", "unit"}
        assert 0.0 < entry["value"] < np.inf
        if name in CHANGES:
            assert (entry["parameter"], entry["unit"]) == ("change", "1")
        else:
            assert entry["unit"] == VOCABULARY[name].FIELDS[entry["parameter"]][0]
    assert set(told["unseen"]) == LISTED - set(shown)
    assert all(told["unseen"].values())


def test_the_limit_of_what_was_found_is_less_than_what_was_found(found):
    """The model has it by now, but what is told is what these logs would have shown of it."""
    assert [effect.name for effect in found.effects] == ["viscous_asymmetry"]
    size = abs(found.effects[0].parameters["difference"].value)
    assert 0.02 * size < found.limits["viscous_asymmetry"].value < size


def test_text_and_page_say_them(found):
    text, page = found.text(), found.html()
    assert "would have been shown with 95 % chance" in text
    told = found.limits["cable_spring"]
    assert f"cable_spring                 stiffness {told.value:.4g} V/m" in text
    row = f'cable spring</td><td>stiffness</td><td class="n">{told.value:.4g}</td><td>V/m</td>'
    assert f'<td class="name">{row}' in page
    unseen = [name for name, one in found.limits.items() if one.value is None]
    assert unseen
    assert f"cannot be seen in this motion: {', '.join(unseen)}" in text
    assert all(f"<li>{name.replace('_', ' ')}: {found.limits[name].why}" in page for name in unseen)


def test_where_nothing_was_measured_nothing_can_be_seen():
    result = cogging.diagnose(run(duration=0.5), MODEL)
    assert result.verdict == "insufficient_excitation"
    told = result.to_dict()
    assert told["limits"] == dict.fromkeys(LISTED)
    assert set(told["unseen"].values()) == {"nothing was measured"}


def test_a_size_is_one_number_of_the_effect(views):
    """A wave's is that of sine and cosine together, a list's its largest; less of a limit or a stiffness does more."""
    for name, law in VOCABULARY.items():
        size = size_of(law)
        if name not in LISTED:
            continue
        assert size.field in law.ROLES
        shapes, trials = likely_shapes(views[0].evidence, law)
        assert trials >= 1.0
        for one in shapes if not size.made_by_shape else []:
            turned = directions(one)
            assert turned.shape[1] == len(one.amplitudes)
            pairs = turned.reshape(len(turned), len({field for field, _ in one.amplitudes}), -1)
            assert np.allclose(np.sqrt((pairs**2).sum(axis=1)).max(axis=1), 1.0), name
    told = limit(views[0], VOCABULARY["command_saturation"])
    assert told.smaller_shows
    assert 0.5 < told.value / views[0].evidence.sources[0].log.command.max() < 1.1
    assert told.to_dict()["smaller_shows"] is True
    assert not limit(views[0], VOCABULARY["command_dead_zone"]).smaller_shows


# What no motion shows -------------------------------------------------------------------------------------------------


def one_way(model, seconds=4.0):
    """A log of a move that never turns."""
    time = np.arange(int(seconds * 1000) + 1) / 1000.0
    s = np.clip((time - 0.05) / (seconds - 0.1), 0.0, 1.0)
    reference = cogging.Sampled(time, 0.3 * s**3 * (10 - 15 * s + 6 * s * s) - 0.15, None, None)
    return cogging.simulate(model, reference, seed=5, duration=seconds, steps_per_sample=4)


@pytest.mark.parametrize("name", ["constant_force", "coulomb_asymmetry", "viscous_asymmetry"])
def test_one_way_motion_shows_no_difference_of_directions(name):
    """A force that goes with the direction is then friction, which is re-tuned."""
    turning, never = limit_of(name, [record(machine(), 3)], machine()), limit_of(name, [one_way(machine())], machine())
    assert turning.value is not None
    assert never.value is None
    assert never.why


def test_what_the_model_lacks_cannot_change():
    model = machine().replace(cogging=None)
    assert limit_of("cogging_modulation", [record(machine(), 3)], model).value is None
    assert limit_of("cogging_modulation", [record(machine(), 3)], machine()).value is not None


def test_a_size_beyond_what_is_physical_is_none(views):
    """A force beyond the largest command is none, however little the logs see of a smaller one."""
    view = views[0]
    largest = max(float(np.abs(source.log.command).max()) for source in view.evidence.sources)
    seen = limit(view, VOCABULARY["constant_force"])
    assert 0.0 < seen.value < 0.1 * largest
    assert seen.sizes[-1] == pytest.approx(largest)
    hardly = limit(replace(view, worth=Powers(1e9, 0.0)), VOCABULARY["constant_force"])
    assert hardly.value is None
    assert f"beyond {largest:.3g} V" in hardly.why


# How they scale -------------------------------------------------------------------------------------------------------

#: Forces: what acts by the command is moved by its noise too, and stands against that of the encoder.
SCALED = ["cable_spring", "viscous_asymmetry", "cogging_harmonic", "quadratic_drag", "disturbance_tone"]


@pytest.fixture(scope="module")
def views():
    """Of the same motion with noise and with half of it, and of four motions."""
    logs = (
        [record(machine(force=0.04), 7)],
        [record(machine(force=0.02), 7)],
        [record(machine(force=0.04), seed) for seed in (7, 8, 9, 10)],
    )
    return [view_of(one, machine()) for one in logs]


@pytest.mark.parametrize("name", SCALED)
def test_a_limit_goes_with_the_noise_and_the_root_of_the_rows(name, views):
    loud, quiet, long = (limit(view, VOCABULARY[name]).value for view in views)
    assert 0.42 * loud < quiet < 0.62 * loud
    assert 0.35 * loud < long < 0.65 * loud


# The chance -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("freedom", "trials", "other", "spread"),
    [(1, 1.0, 0.5, 0.0), (2, 300.0, 0.2, 0.0), (1, 12.0, 2.0, 0.6), (6, 1.0, 1.0, 0.3)],
)
def test_the_chance_is_that_of_the_rules(freedom, trials, other, spread):
    """Effects drawn with their noise, and put to the functions by which a search accepts."""
    random, draws = np.random.default_rng(freedom), 1500
    law = VOCABULARY["viscous_asymmetry"]
    told = chances(
        Visibility(trials, freedom, spread, spread, GRID, other, 0.0, CHOICE.unshown, False), Powers(12.0, 12.0)
    )
    for power in (10.0, 25.0, 40.0, 80.0):
        accepted = 0
        for _ in range(draws):
            amplitude = np.zeros(freedom)
            amplitude[0] = np.sqrt(power)
            estimate = amplitude + random.standard_normal(freedom)
            promised = other * float(estimate @ estimate)
            statistic = float(estimate @ estimate) * np.exp(spread * random.standard_normal())
            level = min(0.0, log_survival(statistic, freedom) + np.log(trials))
            test = ScoreTest(statistic, freedom, -estimate, np.zeros(1), np.ones(freedom))
            finding = Finding(Candidate(law, {}, (), ()), test, estimate, trials, level, statistic)
            shown = other * float(estimate @ amplitude) + np.sqrt(promised) * random.standard_normal()
            shown, promised = np.array([shown, promised]) * np.exp(spread * random.standard_normal())
            check = Confirmation(promised, shown / promised, 2.0 * shown - promised)
            hinted = level <= -3.0
            accepted += hinted and is_seen(finding, check, 1200.0, 1200.0) and refusal(finding, check) is None
        chance = float(np.interp(power, LAMBDAS, told))
        assert abs(accepted / draws - chance) < 0.05, power


def test_without_other_motion_the_chance_is_that_of_the_tail():
    told = chances(Visibility(1.0, 1, 0.0, 0.0, GRID, None, 0.0, CHOICE.unshown, False), Powers(0.0, 0.0))
    assert np.all(np.diff(told) >= 0.0)
    half = float(np.interp(0.5, told, LAMBDAS))
    assert -log_survival(half, 1) == pytest.approx(9.5, rel=0.03)


# The check ------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def null():
    """Nothing hidden, with other motion and an effect of the user's own."""
    return cogging.diagnose(record(machine(), 3), machine(), confirm=record(machine(), 4), also=[own_drag()])


def test_own_effects_have_limits_too(null):
    """A copy of an effect of the list has its limit."""
    assert null.verdict == "no_gap"
    assert set(null.limits) == LISTED | {"own_drag"}
    told = null.to_dict()["limits"]
    assert (told["own_drag"]["parameter"], told["own_drag"]["unit"]) == ("coefficient", "V/(m/s)^2")
    assert told["own_drag"]["value"] == pytest.approx(told["quadratic_drag"]["value"], rel=1e-2)


@pytest.mark.parametrize(
    ("name", "field", "factor", "found"),
    [
        ("viscous_asymmetry", "difference", 2.0, True),
        ("cable_spring", "stiffness", 2.0, True),
        ("cable_spring", "stiffness", 0.3, False),
    ],
)
def test_what_is_twice_the_limit_is_found_and_a_third_of_it_is_not(null, name, field, factor, found):
    hidden = machine([VOCABULARY[name].replace(**{field: factor * null.limits[name].value})])
    result = cogging.diagnose(record(hidden, 13), machine(), confirm=record(hidden, 14))
    assert (result.verdict != "no_gap") is found
    names = {other for effect in result.effects for other in (effect.name, *effect.alternatives)}
    assert (name in names) is found
