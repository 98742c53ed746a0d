"""What the catalogue shows of an effect is what the effect does: law, size, coordinate, look-alikes."""

import numpy as np
import pytest
from coordinates import foretold, places
from effect_signatures import SECONDS_DRAWN, SHARE, signature
from small_machine import MOTIONS, left_by, machine, motion

import cogging
from cogging.effects.effect import VOCABULARY, laws_of

FORCES = sorted(name for name, law in VOCABULARY.items() if set(law.HOOKS) == {"force"})
DRAWN = sorted(np.random.default_rng(19).choice(sorted(VOCABULARY), 2, replace=False))
COURSE = motion("random moves")
AXIS = machine().axis


@pytest.fixture(scope="module")
def signatures():
    """Of some effects, drawn from the list, and of two that are one and the same while the axis moves."""
    return {name: signature(VOCABULARY[name]) for name in {*DRAWN, "coulomb_asymmetry"}}


def drawn_force(name, random):
    """An effect that is a force of place, speed or time, with numbers drawn over all that its fields may be."""
    values = {
        "position": (0.0, 0.5),
        "distance": (0.05, 0.3),
        "angle": (-3.0, 3.0),
        "time": (0.5, 5.0),
        "frequency": (0.5, 4.0),
    }
    fields = {}
    for field, role in VOCABULARY[name].ROLES.items():
        if isinstance(getattr(VOCABULARY[name], field), list):
            low, high = (0.0, 0.5) if "node" in field and "position" in field else (-0.02, 0.02)
            drawn = np.sort(random.uniform(low, high, 6)) if "node" in field else random.uniform(low, high, 6)
            fields[field] = [float(value) for value in drawn]
        elif role["role"] == "amplitude":
            fields[field] = float(random.uniform(0.02, 0.05) * random.choice([-1.0, 1.0]))
        elif role["role"] == "shape":
            fields[field] = float(random.uniform(*values[role["quantity"]]))
    if "start" in fields:
        fields["start"], fields["stop"] = 1.0, float(random.uniform(2.0, 5.0))
    if name == "end_effect":
        fields["travel"] = list(AXIS.travel)
    if name == "cogging_modulation":
        fields |= {"pitch": 0.125, "order": 3, "origin": 0.0}
    if name == "empirical_force":
        fields = {key: value for key, value in fields.items() if key.startswith("position")}
    return VOCABULARY[name].replace(**fields)


@pytest.mark.parametrize("name", FORCES)
def test_what_a_force_leaves_is_the_force(name):
    """What the model without it does not foresee is its law along the motion, but for the lag of the observer."""
    effect = drawn_force(name, np.random.default_rng([19, *name.encode()]))
    residual, rows = left_by(effect, COURSE)
    force = laws_of(effect).force_at(position=rows["position"], velocity=rows["velocity"], time=rows["time"])
    slope = float(residual @ force) / float(force @ force)
    assert float(residual @ force) > 0.97 * float(np.linalg.norm(residual) * np.linalg.norm(force))
    assert slope == pytest.approx(1.0, abs=0.1)


def test_a_coordinate_foretells_what_comes_with_it_and_nothing_else():
    random = np.random.default_rng(7)
    time = np.arange(20_000) * 1e-3
    position = 0.25 + 0.2 * np.sin(2 * np.pi * 0.35 * time)
    bins = np.minimum((position * 160).astype(int), 79)
    shape = random.standard_normal(80)[bins]
    assert foretold(shape, bins, time) > 0.97
    assert foretold(random.standard_normal(len(time)), bins, time) < 0.05
    mixed = foretold(shape / shape.std() + random.standard_normal(len(time)), bins, time)
    assert 0.4 < mixed < 0.6
    once = np.where((time > 10.0) & (time < 10.05), 1.0, 0.0)
    assert foretold(once, bins, time) < 0.3


@pytest.mark.parametrize("name", ["cable_spring", "quadratic_drag", "disturbance_step"])
def test_forces_of_place_speed_and_time_are_drawn_against_them(name):
    wanted = {"cable_spring": "position", "quadratic_drag": "velocity", "disturbance_step": "time"}
    effect = drawn_force(name, np.random.default_rng([3, *name.encode()]))
    residual, rows = left_by(effect, motion("random moves", SECONDS_DRAWN))
    ranked = places(effect, residual, rows)
    assert ranked[0].name == wanted[name]
    assert ranked[0].explained > 0.8
    assert ranked[-1].explained < 0.5


def test_signatures_have_the_stated_size_or_the_largest_that_the_machine_bears(signatures):
    log = cogging.simulate(machine(), motion("random moves", SECONDS_DRAWN), seed=1)
    goal = SHARE * float(np.sqrt(np.mean(log.command**2)))
    for name, found in signatures.items():
        rms = float(np.sqrt(np.mean(found.residual**2)))
        assert 0.0 < rms < 1.1 * goal, name
        assert found.effect != VOCABULARY[name]
    reached = float(np.sqrt(np.mean(signatures["coulomb_asymmetry"].residual ** 2)))
    assert reached == pytest.approx(goal, rel=0.1)


def test_look_alikes_are_all_other_effects_with_shares(signatures):
    for name, found in signatures.items():
        assert set(found.confusion) == set(MOTIONS)
        for confusion in found.confusion.values():
            names, shares = zip(*confusion.explained, strict=True)
            assert set(names) == set(VOCABULARY) - {name}
            assert list(shares) == sorted(shares, reverse=True)
            assert 0.0 <= shares[-1] <= shares[0] <= 1.0
            assert -1e-9 <= confusion.retuned <= 1.0


def test_what_is_the_same_in_motion_is_taken_for_it(signatures):
    """A Coulomb level that differs with direction pushes one way while the axis moves, as a constant force does."""
    for confusion in signatures["coulomb_asymmetry"].confusion.values():
        assert dict(confusion.explained)["constant_force"] > 0.98
