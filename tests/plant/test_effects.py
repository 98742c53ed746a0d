"""The fields that an effect gets from its plant, and its description for programs that know no effect by name."""

import math
import pickle

import numpy as np
import pytest

import cogging
from tests.fixtures.own_laws import COPIES, own_eddy
from tests.fixtures.plants_by_hand import TWO_PI, effect, example, spline, wave

VALUES = {"sine": [0.5, 0.2, -0.4, 0.8, 0.1], "cosine": [-0.3, 0.6, 0.2, 0.0, 0.4]}
POSITIONS = np.linspace(-0.05, 0.3, 1001)


def cogging_model(order, points, origin=0.02, harmonics=(1,)):
    basis = cogging.SplineHarmonics(
        pitch=0.05, harmonics=list(harmonics), order=order, origin=origin, control_points=points
    )
    return cogging.CoggingModel(basis, *np.zeros((2, len(harmonics), points)))


def modulation_force(plant, axis):
    bare = cogging.Plant(axis)
    at = {"velocity": 0.0, "command": 0.0}
    return axis.mass * np.array(
        [plant.acceleration(position=x, **at) - bare.acceleration(position=x, **at) for x in POSITIONS]
    )


@pytest.mark.parametrize(("order", "points"), [(3, 5), (1, 5), (4, 5), (3, 1)])
def test_a_modulation_uses_the_knots_of_the_cogging(order, points):
    axis = cogging.AxisParameters(mass=0.4, travel=[-0.012, 0.5])
    one = effect("cogging_modulation", period=0.05, **VALUES)
    model = cogging_model(order, points)
    # Constant amplitudes have no knots: order 3, from the multiple of the pitch below the travel.
    knots = (0.05, order, 0.02) if points > 1 else (0.05, 3, -0.05)
    s, c = (spline(POSITIONS, VALUES[key], *knots) for key in ("sine", "cosine"))
    expected = -(s * np.sin(TWO_PI * POSITIONS / 0.05) + c * np.cos(TWO_PI * POSITIONS / 0.05))
    got = modulation_force(cogging.Plant(axis, cogging=model, effects=[one]), axis)
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-12)
    alone = one.resolved(axis, model)
    assert (alone.pitch, alone.order, alone.origin) == knots
    np.testing.assert_allclose(alone.force_at(position=POSITIONS), expected, rtol=0, atol=1e-12)
    assert alone.resolved(axis, model) == alone
    assert pickle.loads(pickle.dumps(alone)) == alone


def test_a_modulation_has_knots_of_its_own_or_needs_those_of_the_cogging():
    axis = cogging.AxisParameters(mass=0.4)
    constant = effect("cogging_modulation", period=0.05, pitch=1.0, sine=[0.3], cosine=[0.2])
    np.testing.assert_allclose(constant.force_at(position=POSITIONS), -wave(POSITIONS, 0.05, 0.3, 0.2), atol=1e-14)
    one, two = effect("cogging_modulation", **VALUES), effect("cogging_modulation", sine=[1, 2], cosine=[1, 2])
    rule = r"cogging_modulation\.pitch: must be given where there is no \[cogging\]"
    calls = [(lambda: cogging.Plant(axis, effects=[one]), rule), (lambda: one.force_at(), rule)]
    for model, law, message in (
        (cogging_model(3, 7), one, r"cogging_modulation\.sine: .* of \[cogging\] = 7, got 5"),
        (cogging_model(3, 1), two, "sine: more than one value must be at least the order = 3, got 2"),
    ):
        calls.append((lambda model=model, law=law: cogging.Plant(axis, cogging=model, effects=[law]), message))
    for call, message in calls:
        with pytest.raises(ValueError, match=f"^{message}"):
            call()


def test_an_end_effect_uses_the_ends_of_the_travel():
    fields = {"force": 0.9, "decay_length": 0.03}
    own = effect("end_effect", travel=[-0.1, 0.4], **fields)
    axis = cogging.AxisParameters(mass=0.4, travel=[-0.1, 0.4])
    taken = effect("end_effect", **fields)
    got = modulation_force(cogging.Plant(axis, effects=[taken]), axis)
    np.testing.assert_allclose(got, own.force_at(position=POSITIONS), rtol=0, atol=1e-13)
    assert taken.resolved(axis) == own
    half = effect("end_effect", travel=[-0.1, math.inf], **fields)
    assert half.resolved(axis.replace(travel=[-5.0, 0.4])) == own
    with pytest.raises(ValueError, match=r"^end_effect\.travel: needs two ends, here or in \[axis\], got inf"):
        cogging.Plant(cogging.AxisParameters(travel=[-0.1, math.inf]), effects=[taken])
    with pytest.raises(ValueError, match=r"^end_effect\.travel: needs two ends"):
        taken.force_at(position=0.1)


#: The same with other parameters.
ACTIVE = {name: example(name) for name in cogging.EFFECTS}
ACTIVE |= {make().NAME: make().replace(**fields) for make, fields in COPIES.values()}
ACTIVE |= {"eddy_drag": own_eddy().replace(slope=1.3, corner=0.4)}


@pytest.mark.parametrize("name", sorted(ACTIVE))
def test_an_effect_is_linear_in_its_amplitudes_and_vanishes_with_them(name):
    one = ACTIVE[name]
    roles = one.ROLES
    amplitudes = {field for field, role in roles.items() if role["role"] == "amplitude"}
    rng = np.random.default_rng(3)
    x, v, t, u = rng.uniform(0, 0.3, 50), rng.normal(size=50), rng.uniform(0, 1, 50), rng.normal(size=50)

    calls = {
        "force": lambda it: it.force_at(position=x, velocity=v, time=t),
        "friction_level": lambda it: it.friction_level_at(position=x, velocity=v, time=t),
        "command_gain": lambda it: it.gain_at(position=x, time=t),
        "reading": lambda it: it.reading_at(x) - x,
        "shape_command": lambda it: it.shape_at(u) - u,
    }

    def answer(it):
        return np.concatenate([calls[hook](it) for hook in it.HOOKS if hook in calls] or [np.zeros(0)])

    def scaled(factor):
        changed = {field: (np.array(getattr(one, field)) * factor).tolist() for field in amplitudes}
        return one.replace(**changed)

    if amplitudes:
        np.testing.assert_allclose(answer(scaled(-1.5)), -1.5 * answer(one), rtol=1e-9, atol=1e-14)
        np.testing.assert_array_equal(answer(scaled(0.0)), 0.0)
    for field, role in roles.items():
        if role["role"] == "shape" and role["neutral"] is not None:
            np.testing.assert_array_equal(answer(one.replace(**{field: role["neutral"]})), 0.0)
