"""Effects with a state of their own: presliding friction, backlash, flexible mode. Against closed forms, stiff
integration by scipy, balances of momentum and energy; in drawn plants: test_fast_plants.py."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import cogging
from tests.fixtures.log_columns import columns_of
from tests.fixtures.plants_by_hand import driven, effect, exact_axis, free

TWO_PI = 2 * np.pi

# Presliding friction ---------------------------------------------------------------------------------------


def stiff(commands, rate, mass, viscous, level, stiffness, damping):
    """Positions at the samples, by a stiff integrator, sample by sample."""

    def rhs(_, state, u):
        v, z = state[1:]
        g = level(v)
        z_rate = v - stiffness * abs(v) * z / g
        return [v, (u - viscous * v - stiffness * z - damping * z_rate) / mass, z_rate]

    states = [np.zeros(3)]
    for u in commands[:-1]:
        solved = solve_ivp(rhs, (0, 1 / rate), states[-1], "LSODA", args=(u,), rtol=1e-11, atol=1e-16)
        assert solved.success
        states.append(solved.y[:, -1])
    return np.array(states)


@pytest.mark.parametrize(("stiffness", "damping"), [(2e4, 0.0), (2e4, 20.0), (1e6, 0.0), (1e6, 50.0)])
def test_a_stiff_bristle_is_that_of_the_stiff_integrator(stiffness, damping):
    """1 ms steps; where the axis slides, the bristle's rate stiffness |v| / g is 17,000 to 800,000 /s."""
    mass, viscous, rate = 0.12, 0.2, 1000.0
    t = np.arange(401) / rate
    commands = 0.5 * np.sin(TWO_PI * 6 * t) + 0.3 * np.sin(TWO_PI * 14 * t)

    def level(v):
        return 0.15 + 0.06 * np.exp(-((v / 0.02) ** 2))

    expected = stiff(commands, rate, mass, viscous, level, stiffness, damping)
    assert stiffness * np.abs(expected[:, 1]).max() / 0.15 > 1e4
    plant = cogging.Plant(
        cogging.AxisParameters(mass=mass, viscous=viscous, coulomb=0.15, coulomb_width=1e-3),
        effects=[
            effect("presliding_friction", stiffness=stiffness, damping=damping),
            effect("stribeck_friction", static_excess=0.06, velocity=0.02),
        ],
    )
    for steps in (1, 16):  # one is enough
        x = driven(plant, commands, rate, steps_per_sample=steps).true_position
        # Seen: 3e-8 to 1.2e-6, the most where a contact of 1e6 V/m rings and nothing damps it.
        assert np.abs(x - expected[:, 0]).max() < 2e-6 * np.ptp(expected[:, 0])


@pytest.mark.parametrize("stiffness", [1e2, 1e4, 1e6, 1e9])
def test_it_is_stable_however_stiff_and_tends_to_the_exact_form(stiffness):
    commands = 1.5 * np.sin(TWO_PI * 2 * np.arange(1001) / 1000.0)
    axis = exact_axis(viscous=0.3)
    exact = driven(cogging.Plant(axis), commands, 1000.0).true_position
    bristle = effect("presliding_friction", stiffness=stiffness, damping=0.5)
    log = driven(cogging.Plant(axis, effects=[bristle]), commands, 1000.0)
    assert np.abs(log.true_velocity).max() < 1.0
    # The contact gives way by g / stiffness at a period of sqrt(M / stiffness): a speed of g / sqrt(M stiffness).
    assert np.abs(log.true_position - exact).max() < 0.8 / math.sqrt(0.5 * stiffness)


def test_too_stiff_for_its_step_is_said():
    plant = cogging.Plant(exact_axis(), effects=[effect("presliding_friction", stiffness=1e19)])
    with pytest.raises(ValueError, match=r"^stiffness, frequency: must need at most 1e5 substeps a step, got"):
        driven(plant, np.ones(3), 1000.0)


def test_presliding_follows_the_hysteresis_of_dahl():
    """Pushed slowly to U < Fc and back: x = -(g / s) ln(1 - U / g), then (g / s) ln(1 + U / g) of it is returned."""
    stiffness, level, push = 4e3, 0.8, 0.6
    plant = cogging.Plant(
        exact_axis(viscous=400.0, coulomb_width=0.01),  # creeps: no overshoot
        effects=[effect("presliding_friction", stiffness=stiffness)],
    )
    commands = np.where(np.arange(16001) < 8000, push, 0.0)
    x = driven(plant, commands, 1000.0, steps_per_sample=8).true_position
    gone = -level / stiffness * np.log(1 - push / level)
    back = level / stiffness * np.log(1 + push / level)
    assert x[8000] == pytest.approx(gone, rel=1e-5)
    assert x[16000] == pytest.approx(gone - back, rel=1e-5)
    assert (np.diff(x[:8000]) >= 0).all()
    assert (np.diff(x[8001:]) <= 0).all()


@pytest.mark.parametrize("seed", range(6))
def test_a_bristle_gives_no_energy(seed):
    """On a spring: energy never above its start, and rest is where the contact can hold the spring."""
    rng = np.random.default_rng(seed)
    k, stiffness, mass = rng.uniform(5, 50), 10 ** rng.uniform(2.5, 6), rng.uniform(0.2, 1)
    level = rng.uniform(0.06, 0.3)
    axis = cogging.AxisParameters(mass=mass, coulomb=level)
    effects = [
        effect("presliding_friction", stiffness=stiffness, damping=rng.uniform(0, 1)),
        effect("cable_spring", stiffness=k),
    ]
    start = rng.choice([-1, 1]) * rng.uniform(2, 20) * level / k
    log = free(cogging.Plant(axis, effects=effects), 30 * math.sqrt(mass / k) * TWO_PI, 2000.0, x0=start)
    x, v = log.true_position, log.true_velocity
    energy = 0.5 * mass * v**2 + 0.5 * k * x**2
    assert energy.max() <= energy[0] * (1 + 1e-9)
    assert energy[-1] < 0.5 * energy[0]
    # What the contact holds may come back to the axis, but no more: g^2 / (2 stiffness).
    lowest = np.minimum.accumulate(energy)
    assert (energy - lowest).max() <= 0.5 * level**2 / stiffness * (1 + 1e-6) + 1e-9 * energy[0]
    assert abs(k * x[-1]) <= level * 1.02


# Flexible mode ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "effects",
    [
        [effect("flexible_mode", frequency=20.0)],
        [effect("flexible_mode", mass_ratio=0.5)],
        [effect("backlash", gap=1e-3)],
        [effect("backlash", mass_ratio=0.5)],
        [effect("backlash"), effect("flexible_mode"), effect("presliding_friction", damping=3.0)],
    ],
)
@pytest.mark.parametrize("width", [0.0, 0.01])
def test_a_load_that_is_none_leaves_every_bit(effects, width):
    commands = 2 * np.random.default_rng(8).normal(size=300)
    axis = exact_axis(viscous=0.3, coulomb_width=width)
    with_them, without = (driven(cogging.Plant(axis, effects=e), commands, 1000.0) for e in (effects, []))
    for column, values in columns_of(without).items():
        np.testing.assert_array_equal(getattr(with_them, column), values)


def test_one_load_and_one_bristle_an_axis():
    load = [effect("backlash", gap=1e-3, mass_ratio=0.2), effect("flexible_mode", frequency=9.0, mass_ratio=0.2)]
    bristle = effect("presliding_friction", stiffness=1e4)
    axis = exact_axis()
    for pair, name in ((load, "flexible_mode"), (load[::-1], "backlash"), ([bristle] * 2, "presliding_friction")):
        with pytest.raises(ValueError, match=rf"^{name}: may not join another of its kind"):
            cogging.Plant(axis, effects=pair)
    cogging.Plant(axis, effects=[load[0], bristle])


# Backlash --------------------------------------------------------------------------------------------------


def load_from_momentum(log, push, mass, ratio):
    """(q, q'): without friction the momentum of both masses is the impulse; position and velocity of the load less
    those of the motor."""
    t = log.time
    v1 = log.true_velocity
    steps = np.diff(t) * push[:-1]
    momentum = mass * v1[0] + np.concatenate([[0], np.cumsum(steps)])
    r = (momentum - (1 - ratio) * mass * v1) / (ratio * mass) - v1
    centre = log.true_position[0] + np.concatenate([[0], np.cumsum((momentum[:-1] + 0.5 * steps) / mass * np.diff(t))])
    return (centre - log.true_position) / ratio, r


def test_the_motor_moves_through_the_gap_before_the_load_follows():
    mass, ratio, gap, push = 0.5, 0.4, 4e-3, 0.3
    lost = effect("backlash", gap=gap, mass_ratio=ratio)
    log = driven(cogging.Plant(cogging.AxisParameters(mass=mass), effects=[lost]), np.full(4001, push), 5000.0)
    t, x = log.time, log.true_position
    alone = 0.5 * push / ((1 - ratio) * mass) * t**2
    free_of_load = alone <= gap / 2
    assert free_of_load.sum() > 100
    np.testing.assert_allclose(x[free_of_load], alone[free_of_load], rtol=0, atol=1e-14)
    assert (x[~free_of_load][1:] < alone[~free_of_load][1:]).all()
    # Then the two bounce and settle on one acceleration: the mean motion is that of the whole mass.
    settled = t > 0.6
    acceleration = 2 * np.polyfit(t[settled], x[settled], 2)[0]
    assert acceleration == pytest.approx(push / mass, rel=0.02)
    q, _ = load_from_momentum(log, np.full(4001, push), mass, ratio)
    assert q[settled].max() < -0.99 * gap / 2  # the load is pushed from behind


@pytest.mark.parametrize("frequency", [50.0, 200.0, 3000.0])
@pytest.mark.parametrize("zeta", [0.0, 0.05, 0.3, 2.0])
def test_bounces_take_energy_and_never_give_any(frequency, zeta):
    mass, ratio, gap = 0.5, 0.4, 2e-3
    lost = effect("backlash", gap=gap, mass_ratio=ratio, contact_frequency=frequency, contact_damping_ratio=zeta)
    hit = effect("disturbance_step", force=20.0, start=0.0, stop=0.01)
    log = free(cogging.Plant(cogging.AxisParameters(mass=mass), effects=[lost, hit]), 1.0, 2000.0)
    push = np.where(log.time < 0.01 - 1e-9, 20.0, 0.0)
    q, r = load_from_momentum(log, push, mass, ratio)
    m1, m2 = (1 - ratio) * mass, ratio * mass
    v1 = log.true_velocity
    strain = q - np.clip(q, -gap / 2, gap / 2)
    spring = 0.5 * (TWO_PI * frequency) ** 2 * mass * ratio * (1 - ratio) * strain**2
    energy = (0.5 * m1 * v1**2 + 0.5 * m2 * (v1 + r) ** 2 + spring)[log.time >= 0.01]
    least = 0.5 * mass * (20.0 * 0.01 / mass) ** 2  # both at one speed
    # Without a damper it is kept, but for the error of the substeps: 2e-3 over some hundred bounces.
    tolerance = 2e-3 * energy[0]
    assert np.diff(energy).max() < tolerance
    assert energy.max() < energy[0] + tolerance
    assert energy.min() > least * (1 - 1e-9)
    if zeta == 0.0:
        assert energy[-1] == pytest.approx(energy[0], abs=tolerance)
    else:
        assert energy[-1] - least < 0.5 * (energy[0] - least)
