"""One-step prediction, force balance, whitening and added commands, each against an independent computation."""

import itertools

import numpy as np
import pytest
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

import cogging
from cogging import EFFECTS, AxisParameters, Model
from cogging._core import Predictor, autoregression, whiten

BANDWIDTH = 25.0
AXIS = AxisParameters(mass=0.7, viscous=3.0, coulomb=1.0, coulomb_width=0.2)
MASS_ALONE = AxisParameters(mass=0.7, viscous=0.0, coulomb=0.0)


@pytest.fixture
def columns():
    """A log's time (irregular), position and command, (400,), that no model made."""
    random = np.random.default_rng(3)
    time = np.cumsum(random.uniform(0.4e-3, 1.6e-3, 400))
    position = 0.1 * np.sin(9.0 * time) + 1e-4 * random.normal(size=400)
    return time, position, 4.0 * np.sin(30.0 * time + 1.0) + random.normal(size=400)


def observe(time, position, advance, initial_velocity=0.0, gap=np.inf):
    """Innovations (m) and velocities (m/s) of an observer around `advance`(k, x, v).

    With even steps both its poles stand at exp(-2 pi bandwidth h); a constant force shows alike whatever the steps.
    """
    steps = np.diff(time)
    h = sorted(steps)[len(steps) // 2]
    pole = np.exp(-2 * np.pi * BANDWIDTH * h)
    c = ((1 - pole) / h) ** 2
    d = (1 - pole**2) / h - 0.5 * c * h
    x, v = position[0], initial_velocity
    innovations, velocities = [0.0], [v]
    for k in range(len(time) - 1):
        h = time[k + 1] - time[k]
        x, v = advance(k, x, v)
        innovation = position[k + 1] - x
        if h > gap:
            x, v = position[k + 1], (position[k + 1] - position[k]) / h
            innovation = 0.0
        else:
            after = steps[min(k + 1, len(steps) - 1)]
            x, v = x + (d * after + 0.5 * c * after**2) * innovation, v + c * h * innovation
        innovations.append(innovation)
        velocities.append(v)
    return np.array(innovations), np.array(velocities)


def innovations_of(columns, model, **options):
    return Predictor(*columns, bandwidth=BANDWIDTH, **options).innovations([model.plant()])[0]


def test_linear_plant_against_its_exact_solution(columns):
    time, position, command = columns
    mass, viscous = 0.7, 3.0

    def advance(k, x, v):
        h, final = time[k + 1] - time[k], command[k] / viscous
        decay = np.exp(-viscous / mass * h)
        return x + final * h + (v - final) * (1 - decay) * mass / viscous, final + (v - final) * decay

    expected, velocity = observe(time, position, advance, initial_velocity=0.4)
    predictor = Predictor(time, position, command, bandwidth=BANDWIDTH, initial_velocity=0.4, steps_per_sample=4)
    plant = Model(axis=AxisParameters(mass=mass, viscous=viscous, coulomb=0.0)).plant()
    found = predictor.predict(plant)
    assert found.innovation == pytest.approx(expected, abs=1e-13)
    assert found.velocity == pytest.approx(velocity, abs=1e-10)
    assert predictor.innovations([plant, plant])[1] == pytest.approx(expected, abs=1e-13)


def test_a_constant_force_shows_alike_in_rows_that_jitter():
    """Otherwise slow forces would show at high frequencies, where encoders are quiet."""
    time = np.cumsum(1e-3 * (1.0 + 0.3 * np.random.default_rng(4).uniform(-1.0, 1.0, 3000)))
    force, mass = 0.2, 0.7
    position = 0.5 * force / mass * (time - time[0]) ** 2
    found = innovations_of((time, position, np.zeros(3000)), Model(axis=MASS_ALONE))[500:]
    step = np.median(np.diff(time))
    pole = np.exp(-2 * np.pi * BANDWIDTH * step)
    assert found == pytest.approx(force / mass * (step / (1 - pole)) ** 2, rel=1e-8)


def mean_of_strikes(log, axis, loads):
    """Mean innovations (m) of motor and load, a trajectory for each load: Runge-Kutta of both masses by hand."""
    ratio, gap = loads[0].mass_ratio, np.array([load.gap for load in loads])
    motor, mass = axis.mass * (1.0 - ratio), axis.mass * ratio
    reduced, w = motor * ratio, 2.0 * np.pi * loads[0].contact_frequency
    stiffness, damping = w**2 * reduced, 2.0 * loads[0].contact_damping_ratio * w * reduced

    def slope(state, command):
        _, v, q, r = state
        spring = stiffness * np.maximum(np.abs(q) - 0.5 * gap, 0.0) * np.sign(q)
        pull = spring + np.clip(damping * r, -np.abs(spring), np.abs(spring))
        friction = axis.viscous * v + axis.coulomb * 2.0 / np.pi * np.arctan(v / axis.coulomb_width)
        a = (command - friction + pull) / motor
        return np.array([v, a, r, -pull / mass - a])

    h, pieces = log.time[1] - log.time[0], 16
    pole = np.exp(-2.0 * np.pi * BANDWIDTH * h)
    gains = np.array([[1.0 - pole**2], [(1.0 - pole) ** 2 / h]])
    state, innovations, d = np.zeros((4, len(loads))), [np.zeros(len(loads))], h / pieces
    state[0] = log.position[0]
    for u, reading in zip(log.command[:-1], log.position[1:], strict=True):
        for _ in range(pieces):
            one = slope(state, u)
            two = slope(state + 0.5 * d * one, u)
            three = slope(state + 0.5 * d * two, u)
            state = state + d / 6.0 * (one + 2.0 * two + 2.0 * three + slope(state + d * three, u))
        innovations.append(reading - state[0])
        state[:2] += gains * innovations[-1]
    return np.mean(innovations, axis=1)


@pytest.mark.parametrize(("mass_ratio", "gap"), [(0.05, 2e-4), (0.4, 1e-4)])
def test_a_loose_load_does_on_average_what_single_trajectories_do(mass_ratio, gap):
    axis = AxisParameters(mass=0.8, viscous=3.0, coulomb=1.0, coulomb_width=0.002)
    controller = cogging.PidParameters(sample_rate=2000.0, kp=4000.0, kd=60.0)
    time = np.arange(601) / 2000.0
    motion = cogging.Sampled(time, 0.1 * np.sin(6.0 * time), None, None)
    shake = 0.3 * np.random.default_rng(1).normal(size=len(time))
    machine = Model(axis=axis, controller=controller, controller_type="pid")
    log = cogging.simulate(machine, motion, duration=0.3, added_command=shake)

    def plant(**fields):
        return Model(axis=axis, effects=(EFFECTS["backlash"](**fields),)).plant()

    predictor = Predictor(log.time, log.position, log.command, bandwidth=BANDWIDTH)
    loads = [EFFECTS["backlash"](gap=share * gap, mass_ratio=mass_ratio) for share in (0.7, 0.85, 1.0, 1.15, 1.3)]
    expected = mean_of_strikes(log, axis, loads)
    loose = plant(gap=gap, mass_ratio=mass_ratio)
    rigid, found, none = predictor.innovations([Model(axis=axis).plant(), loose, plant(gap=gap)])
    assert np.linalg.norm(expected - rigid) > 1e-6
    assert np.linalg.norm(found - expected) < 0.04 * np.linalg.norm(expected - rigid)
    np.testing.assert_array_equal(predictor.predict(loose).innovation, found)
    np.testing.assert_array_equal(none, rigid)
    sizes = np.array([1.0, 2.0, 0.5, -1.0, 4.0, 8.0])[:, None]  # powers of two: a row has the bits that it has alone
    table = predictor.propagate(predictor.predict(loose), 0.7, sizes * np.ones((1, len(log))))
    np.testing.assert_array_equal(table, sizes * table[0])


def test_delay_with_irregular_time_stamps(columns):
    time, position, command = columns
    delay, mass = 2.3e-3, 0.7

    def acting(start, end):
        """Pieces (length, command) of what acts over an interval; before the first row, the first command."""
        edges = np.unique(np.concatenate([[start, end], (time + delay)[(time + delay > start) & (time + delay < end)]]))
        for a, b in itertools.pairwise(edges):
            yield b - a, command[max(np.searchsorted(time + delay, 0.5 * (a + b)) - 1, 0)]

    def advance(k, x, v):
        for length, u in acting(time[k], time[k + 1]):
            x, v = x + v * length + 0.5 * u / mass * length**2, v + u / mass * length
        return x, v

    expected, _ = observe(time, position, advance)
    model = Model(axis=MASS_ALONE, effects=(EFFECTS["command_delay"](delay=delay),))
    assert innovations_of(columns, model) == pytest.approx(expected, abs=1e-12)
    mean = [sum(h * u for h, u in acting(a, b)) / (b - a) for a, b in itertools.pairwise(time)]
    force = Predictor(*columns).net_force([model.plant()], np.zeros(400), np.zeros(400))[0]
    assert force[:-1] == pytest.approx(mean, abs=1e-6)  # two times closer than 1 ns are one


def test_the_observer_starts_anew_after_a_gap(columns):
    time, position, command = (column.copy() for column in columns)
    time[200:] += 0.3

    def advance(k, x, v):
        h = time[k + 1] - time[k]
        return x + v * h + 0.5 * command[k] / 0.7 * h**2, v + command[k] / 0.7 * h

    expected, _ = observe(time, position, advance, gap=0.1)
    found = innovations_of((time, position, command), Model(axis=MASS_ALONE), gap=0.1)
    assert found == pytest.approx(expected, abs=1e-12)


def test_propagate_is_the_derivative_of_the_innovations(columns):
    time, position, command = columns
    spring = EFFECTS["cable_spring"](stiffness=40.0)
    options = {"bandwidth": BANDWIDTH, "initial_velocity": 0.9, "steps_per_sample": 4}

    def innovations(force, read=position):
        model = Model(axis=AXIS, effects=(spring, EFFECTS["constant_force"](force=force)))
        return Predictor(time, read, command, **options).innovations([model.plant()])[0]

    predictor = Predictor(time, position, command, **options)
    along = predictor.predict(Model(axis=AXIS, effects=(spring,)).plant())
    one = predictor.propagate(along, 0.7, np.ones((1, 400)))[0]
    difference = (innovations(1e-3) - innovations(-1e-3)) / 2e-3
    assert one == pytest.approx(difference, abs=0.02 * np.abs(difference).max())
    error = 1e-6 * np.sin(200.0 * time)
    read = predictor.propagate(along, 0.7, np.zeros((1, 400)), error[None, :])[0]
    difference = innovations(0.0, position - error) - innovations(0.0)
    assert read == pytest.approx(difference, abs=0.02 * np.abs(difference).max())


def test_net_force_is_that_of_the_law(columns):
    time, position, command = columns
    velocity = 0.5 * np.cos(9.0 * time)
    effects = (EFFECTS["command_saturation"](limit=3.0), EFFECTS["constant_force"](force=0.4))
    model = Model(axis=AXIS.replace(coulomb_width=0.0), effects=effects)
    force = Predictor(time, position, command).net_force([model.plant()], position, velocity)[0]
    expected = np.clip(command, -3.0, 3.0) + 0.4 - 3.0 * velocity - np.sign(velocity)
    assert force[:-1] == pytest.approx(expected[:-1], abs=1e-12)
    assert force[-1] == force[-2]


def test_autoregression_solves_the_equations_of_yule_and_walker():
    row = lfilter([1.0], [1.0, -1.5, 0.7], np.random.default_rng(0).normal(size=5000))
    covariance = np.array([row[lag:] @ row[: len(row) - lag] for lag in range(7)])
    first = covariance.copy()
    first[0] *= 1.0 + 1e-9
    expected = solve_toeplitz(first[:6], covariance[1:])
    assert autoregression(row, np.ones(len(row)), order=6) == pytest.approx(expected, abs=1e-9)
    row[1000:1100], counts = 1e6, np.ones(5000)
    counts[1000:1100] = 0.0  # rows that do not count
    assert autoregression(row, counts, order=2) == pytest.approx([1.5, -0.7], abs=0.03)


@pytest.mark.parametrize(("order", "length"), [(1, 50), (4, 1030), (12, 1024), (48, 50), (48, 3333)])
def test_whiten_is_the_filter_of_scipy_at_any_order_and_length(order, length):
    random = np.random.default_rng([order, length])
    rows, a = random.normal(size=(2, length)), random.normal(size=order)
    assert whiten(rows, a) == pytest.approx(lfilter([1.0, *-a], [1.0], rows, axis=1), abs=1e-11)


def test_an_added_command_is_a_force_that_the_controller_does_not_know():
    controller = cogging.PidParameters(sample_rate=1000.0, kp=2000.0, ki=2e4, kd=40.0)
    model = Model(axis=AXIS, controller=controller, controller_type="pid")
    time = np.arange(1001) / 1000.0
    reference = cogging.Sampled(time, 0.1 * np.sin(6.0 * time), None, None)
    constant = cogging.simulate(model.replace(effects=(EFFECTS["constant_force"](force=0.5),)), reference, duration=1.0)
    added = cogging.simulate(model, reference, duration=1.0, added_command=np.full(1001, 0.5))
    assert added.position == pytest.approx(constant.position, abs=1e-14)
    assert added.command - 0.5 == pytest.approx(constant.command, abs=1e-9)  # its integral runs on
    with pytest.raises(ValueError, match="added_command"):
        cogging.simulate(model, reference, duration=1.0, added_command=np.zeros(5))
    limited = model.replace(controller=controller.replace(command_limit=2.0))
    log = cogging.simulate(limited, reference, duration=1.0, added_command=np.full(1001, 5.0))
    assert np.abs(log.command).max() == 2.0  # together with the controller's
