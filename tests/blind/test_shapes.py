"""Shapes drawn at random: no two alike, each of the kind that its name says; and the laws of the truth they need."""

import numpy as np
import pytest
from scipy.signal import lti, step

from tests.blind import shapes, truth
from tests.blind.cases import Specification, draw_case
from tests.blind.machines import draw_machine
from tests.blind.truth import Plan
from tests.blind.vocabulary import DRAWN

SHARE = np.linspace(0.0, 1.0, 401)
DRAWS = {
    "any_wave": 2 * np.pi * SHARE,
    "any_profile": SHARE,
    "any_decay": 8.0 * SHARE,
    "any_rise": SHARE,
    "any_spring": SHARE,
    "any_pulse": 1.4 * SHARE - 0.2,
}


def drawn(name, seed):
    return np.asarray(getattr(shapes, name)(np.random.default_rng(seed))(DRAWS[name]), dtype=float)


@pytest.mark.parametrize("name", DRAWS)
def test_shapes_have_a_size_of_one_and_no_two_are_alike(name):
    many = [drawn(name, seed) for seed in range(60)]
    assert all(0.5 < np.abs(values).max() < 1.1 for values in many)
    apart = [np.abs(one - other).max() for i, one in enumerate(many) for other in many[:i]]
    assert np.mean(np.array(apart) > 0.02) > 0.9


def test_a_wave_repeats_itself_and_its_first_line_is_its_strongest():
    for seed in range(60):
        wave = shapes.any_wave(np.random.default_rng(seed))
        angle = np.linspace(0.0, 2 * np.pi, 720, endpoint=False)
        np.testing.assert_allclose(wave(angle), wave(angle + 2 * np.pi), atol=1e-9)
        lines = np.abs(np.fft.rfft(wave(angle)))
        assert np.argmax(lines) == 1


def test_rises_and_springs_never_fall_and_decays_never_rise():
    for seed in range(60):
        rise = drawn("any_rise", seed)
        assert rise[0] == pytest.approx(0.0, abs=1e-12)
        assert rise[-1] == pytest.approx(1.0)
        assert np.diff(rise).min() >= -1e-12
        assert np.diff(drawn("any_spring", seed)).min() > 0.0
        decay = drawn("any_decay", seed)
        assert decay[0] == pytest.approx(1.0)
        assert np.diff(decay).max() <= 1e-12
        assert decay[-1] < 0.1


def test_a_pulse_is_nothing_outside_its_time():
    for seed in range(60):
        values = drawn("any_pulse", seed)
        outside = (DRAWS["any_pulse"] < -1e-9) | (DRAWS["any_pulse"] > 1.0 + 1e-9)
        assert np.abs(values[outside]).max() == 0.0


def test_machines_are_drawn_with_laws_and_noises_of_many_kinds():
    machines = [draw_machine(np.random.default_rng(seed)) for seed in range(60)]
    assert {one.law for one in machines} == set(truth.LAWS)
    assert "mixture" in {one.colour for one in machines}


def force_of(**scalars):
    """Velocity of a free mass of one that is pushed by a command of one, from rest, after each sample."""
    plan = Plan.empty(np.arange(400) / 1000.0, (-1.0, 1.0))
    for name, value in {"rate": 1000.0, "mass": 1.0, "ff_mass": 1.0, "law": truth.TANH, **scalars}.items():
        plan[name] = value
    plan.rows[1:, truth.R_ACCELERATION] = 1.0  # the first sample rests: actuators start there
    return np.diff(plan.run().velocity)[1:] * 1000.0


@pytest.mark.parametrize("damping", [0.45, 0.7, 0.9])
def test_a_lag_of_second_order_is_that_of_scipy(damping):
    time_constant = 0.008
    found = force_of(lag=time_constant, lag_damping=damping)
    law = lti([1.0], [time_constant**2, 2 * damping * time_constant, 1.0])
    expected = step(law, T=np.arange(797) / 2000.0)[1][1::2]  # in the middle of each sample
    np.testing.assert_allclose(found, expected, atol=4e-3)
    assert found.max() > 1.0 + 0.5 * np.exp(-np.pi * damping / np.sqrt(1 - damping**2))


def test_commands_are_cut_softly_or_on_one_side_alone():
    assert force_of(saturation_soft=0.8, saturation_knee=3.0)[-1] == pytest.approx((1 + 0.8**-3) ** (-1 / 3))
    assert force_of(saturation_down=0.5)[-1] == pytest.approx(1.0)
    assert force_of(saturation_up=0.5)[-1] == pytest.approx(0.5)
    one_sided, rounded = (float(truth.DEAD_ZONES.index(name)) for name in ("one_sided", "rounded"))
    assert force_of(dead_zone=0.2, dead_zone_shape=one_sided)[-1] == pytest.approx(0.8)
    assert force_of(dead_zone=0.2, dead_zone_shape=one_sided, ff_mass=-1.0)[-1] == pytest.approx(-1.0)
    assert force_of(dead_zone=0.8, dead_zone_shape=rounded)[-1] == pytest.approx(1 - 0.8 * np.tanh(1.25))


def test_a_case_bears_the_name_of_its_cause_whatever_the_shape():
    keys = [draw_case([seed], Specification("effect", ("end_effect",), 300.0)).key["effects"][0] for seed in (1, 2, 3)]
    assert {key["name"] for key in keys} == {"end_effect"}
    assert {key["shape"] for key in keys} == {"usual", DRAWN}
    assert all(bool(key["parameters"]) == (key["shape"] == "usual") for key in keys)
