"""Friction narrower than the motion shows: a fit ends where its width stops to matter, and stays there."""

import numpy as np
import pytest

import cogging
from cogging.estimation.force_balance import NARROW, REST, bounded_step


def narrow_machine():
    kp, ki, kd = cogging.pid_gains([-90.0] * 3, 3.2)
    law = cogging.effects.Custom("law", force=lambda velocity: -4.5 * np.tanh(velocity / 3e-3), velocity_scale=1e-3)
    return cogging.Model(
        axis=cogging.AxisParameters(mass=3.2, viscous=9.0, coulomb=0.0, coulomb_width=2e-3, travel=[0.0, 0.4]),
        effects=[law],
        encoder=cogging.EncoderParameters(resolution=2e-7),
        noise=cogging.NoiseParameters(force=0.08, bandwidth=60.0),
        controller=cogging.PidParameters(sample_rate=1000.0, kp=kp, ki=ki, kd=kd, mass=3.2, viscous=9.0),
        controller_type="pid",
        units=cogging.Units(command="N"),
    )


@pytest.fixture(scope="module")
def logged():
    """A log whose friction has no slow flank, which the fitted law has at any width; and the prior."""
    machine = narrow_machine()
    motion = cogging.PointToPoint(
        cogging.PointToPointParameters(
            start=0.03, distance=0.34, velocity=0.4, acceleration=4.0, jerk=80.0, dwell=0.15, repeats=1
        )
    )
    prior = machine.replace(effects=[], axis=machine.axis.replace(mass=3.3, viscous=8.5, coulomb=4.2))
    return cogging.simulate(machine, motion, seed=1), prior


def test_rounding_of_a_log_does_not_move_its_fit(logged):
    """Sums that another processor adds up otherwise differ by 1e-15 of themselves: so much the less may the fit."""
    log, prior = logged
    columns = dict(log.columns())
    shaken = cogging.Log(**{**columns, "command": columns["command"] * (1.0 + 1e-13)})
    one, other = (cogging.identify(which, prior) for which in (log, shaken))
    for path in ("axis.mass", "axis.viscous", "axis.coulomb"):
        assert other[path].value == pytest.approx(one[path].value, rel=1e-8)
        assert other[path].ci95 == pytest.approx(one[path].ci95, rel=1e-6)


def test_a_narrow_width_stays_where_it_stops_to_matter(logged):
    log, prior = logged
    rest = REST * 0.4
    found = cogging.identify(log, prior, free=["axis.viscous", "axis.coulomb", "axis.coulomb_width"])
    assert found.model.axis.coulomb_width >= 0.9 * NARROW * rest
    assert found["axis.coulomb"].value == pytest.approx(4.5, rel=0.05)


@pytest.mark.parametrize("seed", range(8))
def test_a_step_ends_at_the_bounds_and_is_the_best_there(seed):
    """Of a least squares with lower ends: as good as scipy's, whose method is another."""
    from scipy.optimize import lsq_linear

    random = np.random.default_rng(seed)
    p = int(random.integers(2, 7))
    matrix = random.normal(size=(40, p)) * 10.0 ** random.uniform(-3, 3, p)
    target, lowest = random.normal(size=40), -(10.0 ** random.uniform(-4, 1, p))
    lowest[random.random(p) < 0.5] = -np.inf
    step = bounded_step(matrix.T @ matrix, -matrix.T @ target, lowest)
    assert (step >= lowest).all()
    free = step > lowest
    gradient = matrix.T @ (matrix @ step - target)
    assert np.abs(gradient[free]).max(initial=0.0) <= 1e-6 * np.abs(matrix.T @ target).max()
    best = lsq_linear(matrix, target, bounds=(lowest, np.inf)).cost
    assert 0.5 * np.sum((matrix @ step - target) ** 2) <= 1.05 * best + 1e-12
