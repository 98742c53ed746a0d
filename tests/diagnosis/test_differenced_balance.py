"""What the force balance, its evidence and its candidates promise, against formulas of their own."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import lsq_linear
from scipy.signal import lfilter

import cogging
from cogging.diagnosis.balance.candidates import Search, wave_scan
from cogging.diagnosis.balance.cells import dahl, load_response, lost_motion
from cogging.diagnosis.balance.decision import block_edges, score_of
from cogging.diagnosis.balance.differenced_balance import DifferencedBalance
from cogging.diagnosis.balance.evidence import Evidence, likeliest, noise_filter, student_cost
from cogging.diagnosis.balance.nuisances import instruments_of
from cogging.effects.effect import VOCABULARY as E
from tests.fixtures.pid_axis import FAST, run

RATE = 5000.0  # Hz
MASS = 0.12


def machine(*effects):
    axis = cogging.AxisParameters(mass=MASS, viscous=0.166, coulomb=0.0, coulomb_width=5e-3, travel=[-0.3, 0.3])
    return cogging.Model(axis=axis, effects=effects)


def motion(seconds=1.5, size=0.1):
    """Time, position, velocity and acceleration of a motion that is known in closed form."""
    t = np.arange(0.0, seconds, 1.0 / RATE)
    w = 2 * np.pi * np.array([1.3, 3.1])[:, None]
    a = size * np.array([1.0, 0.1])[:, None]
    x, v = np.sum(a * np.sin(w * t), axis=0), np.sum(a * w * np.cos(w * t), axis=0)
    return t, x, v, np.sum(-a * w * w * np.sin(w * t), axis=0)


def moved(force=0.0, noise=0.0, seed=0, seconds=1.5):
    """A log of that motion whose command is what the axis needs, with an extra force (V, a function of t, x, v)."""
    t, x, v, a = motion(seconds)
    command = MASS * a + 0.166 * v - (force(t, x, v) if callable(force) else force)
    command = command + noise * np.random.default_rng(seed).standard_normal(len(t))
    # held over the step that follows: its value there
    return cogging.Log(t, x, np.append(0.5 * (command[1:] + command[:-1]), command[-1]))


FORCES = {
    "constant_force": ({"force": 0.2}, lambda t, x, v: 0.2 + 0 * x),
    "cable_spring": ({"stiffness": 2.0, "center": 0.02}, lambda t, x, v: -2.0 * (x - 0.02)),
    "local_force": (
        {"force": 0.3, "center": 0.03, "width": 0.04},
        lambda t, x, v: 0.3 * np.exp(-(((x - 0.03) / 0.04) ** 2)),
    ),
    "end_effect": (
        {"force": 0.3, "decay_length": 0.1, "travel": [-0.3, 0.3]},
        lambda t, x, v: 0.3 * (np.exp(-(0.3 - x) / 0.1) - np.exp(-(x + 0.3) / 0.1)),
    ),
    "cogging_harmonic": (
        {"period": 0.05, "sine": 0.2, "cosine": 0.1},
        lambda t, x, v: -(0.2 * np.sin(2 * np.pi * x / 0.05) + 0.1 * np.cos(2 * np.pi * x / 0.05)),
    ),
    "viscous_asymmetry": ({"difference": 0.05}, lambda t, x, v: -0.025 * np.abs(v)),
    "quadratic_drag": ({"coefficient": 0.1}, lambda t, x, v: -0.1 * v * np.abs(v)),
    "disturbance_tone": (
        {"frequency": 7.0, "sine": 0.2, "cosine": -0.1},
        lambda t, x, v: 0.2 * np.sin(14 * np.pi * t) - 0.1 * np.cos(14 * np.pi * t),
    ),
}


@pytest.mark.parametrize("name", FORCES)
def test_nothing_is_left_of_a_known_force_and_all_of_a_missing_one(name):
    fields, law = FORCES[name]
    effect, log = E[name].replace(**fields), moved(law)
    b = DifferencedBalance(log, 5e-3)
    inner = slice(20, -20)
    expected = law(b.time, b.position, b.velocity)[inner]
    scale = np.max(np.abs(expected))
    np.testing.assert_allclose(b.residual(machine(effect))[inner], 0.0, atol=5e-3 * scale)
    np.testing.assert_allclose(b.residual(machine())[inner], expected, atol=5e-3 * scale)
    # `added` is the mean of the law over the steps on both sides, whatever the model
    added = b.added(machine(), [effect], b.command)[0]
    half = 0.5 / RATE
    grid = np.linspace(-2.0, 2.0, 41) * half
    weights = 1.0 - np.abs(grid) / (2.0 * half)
    at = b.time[inner, None] + grid
    x, v = np.interp(at, b.time, b.position), np.interp(at, b.time, b.velocity)
    mean = law(at, x, v) @ weights / weights.sum()
    np.testing.assert_allclose(added[inner], mean, atol=2e-3 * scale)


MORE = {
    "coulomb_asymmetry": {"difference": 0.02},
    "stribeck_friction": {"static_excess": 0.03, "velocity": 0.05},
    "position_dependent_friction": {"nodes": [-0.3, 0.0, 0.3], "levels": [0.02, -0.02, 0.02]},
    "force_constant_ripple": {"period": 0.04, "sine": 0.03},
    "force_constant_drift": {"change": 0.1, "time_constant": 0.5},
    "disturbance_step": {"force": 0.1, "start": 0.4, "stop": 0.9},
    "encoder_periodic_error": {"period": 0.02, "sine": 1e-6},
    "encoder_scale_error": {"scale": 1e-3},
}


@pytest.mark.parametrize("name", [*FORCES, *MORE])
def test_the_balance_of_a_simulated_run_is_zero(name):
    """Noise-free runs of drawn machines with friction, cogging and an effect that the model has."""
    rng = np.random.default_rng([*FORCES, *MORE].index(name))
    mass, pitch = rng.uniform(0.08, 0.3), rng.uniform(0.03, 0.06)
    level = rng.uniform(0.05, 0.15)
    axis = cogging.AxisParameters(
        mass=mass, viscous=rng.uniform(0.1, 0.5), coulomb=level, coulomb_width=0.02, travel=[-0.3, 0.3]
    )
    basis = cogging.SplineHarmonics(pitch=pitch, harmonics=[1, 2])
    effect = E[name].replace(**(FORCES[name][0] if name in FORCES else MORE[name]))
    pid = cogging.PidParameters(sample_rate=RATE, kp=8e4 * mass, ki=8e5 * mass, kd=400.0 * mass, mass=mass)
    model = cogging.Model(
        axis=axis,
        cogging=cogging.CoggingModel(basis, level * rng.uniform(-1, 1, (2, 1)), level * rng.uniform(-1, 1, (2, 1))),
        effects=[effect],
        controller=pid,
        controller_type="pid",
    )
    move = {"type": "point_to_point", "start": -0.1, "distance": 0.2, "velocity": 0.4, "acceleration": 8.0}
    log = cogging.simulate(model, {**move, "jerk": 200.0, "dwell": 0.0, "repeats": 1})
    b = DifferencedBalance(log, 0.02)
    rows = slice(len(b.rows(b.command)[0]) // 5, None)
    left, without = (b.rows(b.residual(m))[0][rows] for m in (model, model.replace(effects=())))
    limit = 5e-3 * np.sqrt(np.mean(without**2)) + 5e-5 * np.sqrt(np.mean(b.command**2))
    assert np.sqrt(np.mean(left**2)) < limit


NEUTRAL = {
    "force_constant_ripple": {"period": 0.02, "sine": 1e-12},
    "force_constant_drift": {"change": 1e-12, "time_constant": 1.0},
    "command_saturation": {"limit": 1e6},
    "command_dead_zone": {"width": 1e-12},
    "command_delay": {"delay": 1e-12},
    "actuator_lag": {"time_constant": 1e-9},
    "encoder_scale_error": {"scale": 1e-12},
    "flexible_mode": {"frequency": 40.0, "mass_ratio": 1e-12},
    "backlash": {"gap": 1e-4, "mass_ratio": 1e-12},
}


@pytest.mark.parametrize("name", NEUTRAL)
def test_an_effect_without_size_leaves_the_residual_and_its_noise_as_they_are(name):
    """The noise of the command is that of M a: a mean over the rows would smooth one of the two."""
    balance = DifferencedBalance(moved(0.2, noise=0.1))
    instruments = instruments_of(balance, machine())
    alone, beside = (instruments.residual(balance, m) for m in (machine(), machine(E[name].replace(**NEUTRAL[name]))))
    counted = balance.keep > 0
    assert np.std(alone[counted]) > 0.02
    np.testing.assert_allclose(beside[counted], alone[counted], atol=1e-4)


@pytest.mark.parametrize("rate", [1000.0, 5000.0, 20000.0])
def test_rows_and_adjoint_are_transposes(rate):
    rng = np.random.default_rng(1)
    t = np.arange(0.0, 1.0, 1.0 / rate)
    b = DifferencedBalance(cogging.Log(time=t, position=0.1 * np.sin(9 * t), command=np.cos(9 * t)), 1e-3)
    for corner in (20.0, 250.0):
        b.corner = corner
        column = rng.standard_normal(len(b.time))
        rows = b.rows(column)[0]
        weights = rng.standard_normal(len(rows))
        assert rows @ weights == pytest.approx(column @ b.adjoint(weights), rel=1e-9)


def test_a_moved_balance_has_its_positions_elsewhere():
    b = DifferencedBalance(moved(), 5e-3)
    spring = machine(E["cable_spring"].replace(stiffness=2.0))
    np.testing.assert_allclose(b.moved(0.01).residual(spring) - b.residual(spring), 0.02, rtol=1e-9)


@pytest.mark.parametrize("factor", [1.0, 3.0])
def test_rows_within_a_noisy_second_have_its_level(factor):
    fine = FAST.replace(encoder=cogging.EncoderParameters(resolution=1e-9))
    log, rng = run(model=fine, seed=3), np.random.default_rng(8)
    noisy = (log.time > 1.5) & (log.time < 2.5)
    noise = 0.06 * rng.standard_normal(len(log.time)) * np.where(noisy, factor, 1.0)
    balance = DifferencedBalance(cogging.Log(log.time, log.position, log.command + noise, log.reference), quantum=1e-9)
    evidence = Evidence([balance], fine, fine).prepare(2, listen=True)
    time = balance.time[:: balance.every][evidence.counted[0]]
    inside, outside = (time > 1.7) & (time < 2.3), (time < 1.3) | (time > 2.7)
    level = evidence.levels[0]
    assert np.median(level[inside]) / np.median(level[outside]) == pytest.approx(factor, rel=0.2)


@pytest.mark.parametrize(("pole", "zero"), [(0.9, 0.0), (0.0, 0.6), (0.95, -0.5)])
def test_the_noise_filter_whitens(pole, zero):
    """Rows (1 + zero q) / (1 - pole q) of white noise: the filter is close to the inverse, whose first tap is 1."""
    rows = lfilter([1.0, zero], [1.0, -pole], np.random.default_rng(2).standard_normal(60_000))
    taps = noise_filter(rows, np.ones(len(rows), bool), 500.0)
    left = lfilter(taps, 1.0, rows)[1000:]
    assert taps[0] == 1.0
    assert np.std(left) == pytest.approx(1.0, abs=0.03)
    for lag in (1, 2, 5, 20):
        # the spectrum is smoothed over a third of an octave, in which that of a zero near half the rate bends
        assert abs(np.corrcoef(left[lag:], left[:-lag])[0, 1]) < (0.08 if zero > 0.0 else 0.03)


def test_a_line_stays_behind_the_noise_filter():
    n = 20_000
    rows = np.random.default_rng(3).standard_normal(n) + 3.0 * np.sin(2 * np.pi * 0.05 * np.arange(n))
    taps = noise_filter(rows, np.ones(n, bool), 500.0)
    gain = np.abs(np.exp(-2j * np.pi * 0.05 * np.arange(len(taps))) @ taps)
    assert gain == pytest.approx(1.0, abs=0.25)


def test_likeliest_is_least_squares_of_normal_rows_and_ignores_outliers():
    rng = np.random.default_rng(4)
    x = rng.standard_normal((3, 4000))
    r = np.array([1.0, -2.0, 0.5]) @ x + 0.1 * rng.standard_normal(4000)
    r[::50] += 100.0
    free = likeliest(x, r, np.full(3, np.inf), np.zeros(3), 10)
    np.testing.assert_allclose(free.w, [1.0, -2.0, 0.5], atol=0.02)
    held = likeliest(x, r, np.array([np.inf, 1e-9, np.inf]), np.array([0.0, -1.9, 0.0]), 10)
    assert held.w[1] == pytest.approx(-1.9, abs=1e-6)
    assert held.cost > free.cost


def test_dahl_solves_its_equation():
    t = np.linspace(0.0, 2.0, 4001)

    def x(s):
        return 1e-3 * np.sin(5.0 * s) + 4e-4 * s

    def slope(s, z):
        v = 5e-3 * np.cos(5.0 * s) + 4e-4
        return (v - abs(v) * z) / 2e-4

    solved = solve_ivp(slope, (0.0, 2.0), [0.0], t_eval=t, max_step=2e-3, rtol=1e-8, atol=1e-10).y[0]
    np.testing.assert_allclose(dahl(x(t), 2e-4), solved, atol=5e-3)


def test_lost_motion_against_a_load_between_stiff_stops():
    """The load, a free mass between two stiff and damped stops, as a differential equation of its own."""
    step, gap = 1e-3, 2e-4
    t = np.arange(0.0, 1.5, step)
    w = 2 * np.pi * 2.0
    a = -0.02 * w**2 * np.sin(w * t)

    def moves(s, y):
        lead = 0.02 * np.sin(w * s) - y[0]
        depth = np.sign(lead) * max(abs(lead) - gap / 2, 0.0)  # to which the motor presses into a stop
        return [y[1], 2e7 * depth + 1e4 * (depth != 0.0) * (0.02 * w * np.cos(w * s) - y[1])]

    start, exact = [gap / 2, 0.02 * w], {"max_step": 5e-4, "rtol": 1e-7, "atol": 1e-10}
    load = solve_ivp(moves, (0.0, t[-1]), start, method="Radau", t_eval=t, **exact).y
    relative = 0.02 * w * np.cos(w * t) - load[1]
    found, alone = lost_motion(a, step, gap)
    assert np.max(np.abs(relative)) > 0.01
    assert np.corrcoef(found[100:], relative[100:])[0, 1] > 0.9
    assert np.max(np.abs(found)) == pytest.approx(np.max(np.abs(relative[100:])), rel=0.3)
    np.testing.assert_array_equal(alone[alone != 0.0], a[alone != 0.0])
    assert np.mean((alone == 0.0) == (found == 0.0)) > 0.98  # but for the rows in which they meet


def test_lost_motion_is_continuous_in_the_gap():
    """Else the likelihood of a gap has a peak wherever an impact falls into another row."""
    a = -0.02 * (4 * np.pi) ** 2 * np.sin(4 * np.pi * np.arange(0.0, 1.5, 1e-3))
    gaps = 2e-4 * (1.0 + 1e-4 * np.arange(400))
    found = np.array([lost_motion(a, 1e-3, gap)[0] for gap in gaps])
    assert 0.0 < np.max(np.abs(np.diff(found, axis=0))) < 2e-3 * np.max(np.abs(found))


def test_a_load_answers_as_its_transfer_function_says():
    step, f, damping, tone = 1e-4, 40.0, 0.1, 25.0
    t = np.arange(0.0, 2.0, step)
    out = load_response(np.sin(2 * np.pi * tone * t), step, f, damping)[10_000:]
    phasor = 2 * np.mean(out * np.exp(-2j * np.pi * tone * t[10_000:])) * 1j
    q = 1j * tone / f
    assert phasor == pytest.approx((2 * damping * q + 1) / (q * q + 2 * damping * q + 1), rel=0.01)


def test_a_period_is_found_within_its_resolution():
    model = machine().replace(uncertainty={"mass": 0.03, "viscous": 0.2, "coulomb": 0.2})
    b = DifferencedBalance(moved(lambda t, x, v: 0.1 * np.sin(2 * np.pi * x / 0.021), noise=0.02), 5e-3)
    s = Search(Evidence([b], model, model).prepare())
    peaks, trials = wave_scan(s, [np.ones(len(b.time))])
    assert abs(peaks[0][0] - 1 / 0.021) < 1.0 / s.length
    assert trials > 10


@pytest.mark.parametrize("width", [1e-3, 2e-2])
def test_a_model_alone_leaves_no_more_than_the_one_it_was_fitted_beside(width):
    """Friction that rises otherwise than the model's: a mixture of laws explains it, and the model must do without."""
    log = moved(lambda t, x, v: -0.05 * np.tanh(v / 0.1), 0.01, seed=3, seconds=4.0)
    axis = cogging.AxisParameters(mass=0.13, viscous=0.2, coulomb=0.04, coulomb_width=width)
    model = cogging.Model(axis=axis, uncertainty={"mass": 0.2, "viscous": 0.5, "coulomb": 0.5})
    balance = DifferencedBalance(log, width)
    evidence = Evidence([balance], model, model).prepare(2, listen=True)

    def left(one):
        return float(np.std(balance.rows(balance.residual(one))[0][balance.mask]))

    alone = evidence.settled(evidence.model)
    assert left(alone) <= left(evidence.model) * 1.001
    assert left(alone) < left(model)
    # no step in a parameter of the axis makes it smaller by a thousandth
    for name in ("mass", "viscous", "coulomb"):
        for factor in (0.98, 1.02):
            changed = alone.axis.replace(**{name: factor * getattr(alone.axis, name)})
            assert left(alone.replace(axis=changed)) > 0.999 * left(alone)


def test_a_model_alone_without_an_effect_moves_the_others_to_where_they_are_likeliest():
    """An offset beside a spring whose center is not the travel's: without the spring it is the mean of both."""
    log = moved(lambda t, x, v: 0.3 - 2.0 * (x - 0.05), seconds=4.0)
    spring, offset = E["cable_spring"].replace(stiffness=2.0, center=0.05), E["constant_force"].replace(force=0.3)
    plain = machine()
    evidence = Evidence([DifferencedBalance(log, 5e-3)], plain, plain.replace(effects=(spring, offset))).prepare()
    less = evidence.settled(evidence.model, ["effects.cable_spring"])
    assert [e.NAME for e in less.effects] == ["constant_force"]
    assert less.effects[0].force == pytest.approx(0.3 + 2.0 * (0.05 - np.mean(log.position)), abs=0.02)
    two = evidence.model.replace(effects=(*evidence.model.effects, spring))
    assert "effects.cable_spring[0].stiffness" in evidence.paths_in(two)
    assert "effects.cable_spring.stiffness" in evidence.paths_in(evidence.model)


def test_a_step_of_re_tuning_moves_along_a_line():
    """The width of friction, too: beside its whole change, a short step of the others would be another."""
    log = moved(lambda t, x, v: -0.05 * np.tanh(v / 0.1), 0.01, 3, seconds=4.0)
    axis = cogging.AxisParameters(mass=MASS, viscous=0.166, coulomb=0.05, coulomb_width=2e-2)
    stated = cogging.Model(axis=axis, uncertainty={"mass": 0.2, "viscous": 0.5, "coulomb": 0.5})
    evidence = Evidence([DifferencedBalance(log, 2e-2)], stated, stated).prepare()
    model, half, whole = (evidence.retuned(evidence.fit.theta, share) for share in (0.0, 0.5, 1.0))
    assert model == stated
    assert whole.axis.coulomb_width > 1.5 * axis.coulomb_width
    for name in ("mass", "viscous", "coulomb", "coulomb_width"):
        mean = 0.5 * (getattr(stated.axis, name) + getattr(whole.axis, name))
        assert getattr(half.axis, name) == pytest.approx(mean, rel=1e-12)


def test_two_effects_may_have_more_trials_than_an_integer_of_64_bits_counts():
    assert score_of(200.0, 2, 2**70, 10) == pytest.approx(200.0 - 2.0 * np.log1p(100.0) - 140.0 * np.log(2.0))


def test_a_scale_error_is_no_way_to_explain_the_noise_of_the_readings():
    """Derivatives by an accepted scale error have the acceleration that acts, not the measured one with its noise."""
    exact = moved()
    model = machine().replace(uncertainty={"mass": 0.5, "viscous": 0.5})
    wrong = model.replace(effects=(E["encoder_scale_error"].replace(scale=1e-3),))
    columns, residuals = [], []
    for size in (0.0, 2e-4):
        noise = size * np.random.default_rng(6).standard_normal(len(exact))
        log = replace(exact, position=exact.position + noise, reference=exact.position)
        evidence = Evidence([DifferencedBalance(log, 5e-3)], model, wrong).prepare()
        columns.append(evidence.nuisances[0][evidence.paths.index("effects.encoder_scale_error.scale")][100:-100])
        residuals.append(evidence.residuals[0][100:-100])
    assert np.std(residuals[1] - residuals[0]) > 0.2 * np.std(columns[0])
    assert np.std(columns[1] - columns[0]) < 0.02 * np.std(columns[0])


def test_intervals_end_where_the_likelihood_ratio_does():
    """Against a bounded least squares of all amplitudes at once: no friction law has a negative level."""
    log = moved(
        lambda t, x, v: -0.05 * np.tanh(v / 0.1) - 0.04 * np.exp(-np.abs(v) / 0.05) * np.sign(v), 0.01, 3, seconds=4.0
    )
    axis = cogging.AxisParameters(mass=MASS, viscous=0.166, coulomb=0.05, coulomb_width=2e-2)
    stated = cogging.Model(axis=axis, uncertainty={"mass": 0.2, "viscous": 0.5, "coulomb": 0.5})
    bump = E["stribeck_friction"].replace(static_excess=0.03, velocity=0.05)
    evidence = Evidence([DifferencedBalance(log, 2e-2)], stated, stated.replace(effects=(bump,))).prepare(2)
    fit, mixture = evidence.null, evidence.mixture
    assert len(mixture) > 1
    # information of a row by differences of its -2 ln likelihood, for any distribution of the noise
    costs = [student_cost(fit.rest + step, fit.variance) for step in (-1e-3, 0.0, 1e-3)]
    score, bend = (costs[2] - costs[0]) / 4e-3, (costs[0] - 2.0 * costs[1] + costs[2]) / 2e-6
    prior = 1.0 / fit.prior[0] ** 2
    rows = (fit.x * fit.weight) @ fit.x.T / fit.weight.mean() * bend.mean() ** 2 / np.mean(score**2)
    root = np.linalg.cholesky(rows + np.diag(prior)).T
    own = evidence.paths.index("axis.coulomb")  # the change of all levels together: that of the own law is what remains
    low = np.where(np.isin(np.arange(len(fit.w)), [own, *mixture]), 0.0, -np.inf)
    columns = root * fit.size
    columns[:, mixture] += columns[:, [own]]
    measured = root @ fit.w + columns[:, own] * evidence.model.axis.coulomb

    def cost(k, moved):
        rest = np.arange(len(fit.w)) != k
        target = measured - (columns[:, k] * (fit.theta[k] + moved) if k >= 0 else 0.0)
        return 2.0 * lsq_linear(columns[:, rest], target, (low[rest], np.inf), "bvls").cost

    least = cost(-1, 0.0)
    for path in ("effects.stribeck_friction.static_excess", "axis.mass"):
        k = evidence.paths.index(path)
        ends = evidence.interval(k)
        assert ends[0] < 0.0 < ends[1]
        for end in ends:
            assert cost(k, end) - least == pytest.approx(1.959964**2, rel=1e-2)


@pytest.mark.parametrize("noise", ["standard_normal", "laplace", "standard_t"])
def test_deviations_of_amplitudes_are_those_of_many_draws(noise):
    """Whatever the distribution of the noise: the weights of the rows belong to a Student distribution.

    Their rms ratio has a deviation of 0.02; with the variance alone it is 1.12 to 1.19.
    """
    rng = np.random.default_rng(7)
    x, none, inf = rng.standard_normal((2, 300)), np.zeros(2), np.full(2, np.inf)
    freedom = (4.0,) if noise == "standard_t" else ()
    errors = []
    for _ in range(600):
        fit = likeliest(x, getattr(rng, noise)(*freedom, size=300), inf, none)
        errors.append(fit.w / np.sqrt(np.diag(np.linalg.inv(fit.gram)) * fit.spread))
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(1.0, abs=0.07)


def test_friction_that_saturates_slowly_keeps_its_level_near_the_interval_of_coulomb():
    """It lies above what an arctangent fits to the speeds of the log. No law of the model is the true one."""

    def law(speed):
        return 0.3 * (0.5 * np.tanh(speed / 3e-3) + 0.5 * speed / (np.abs(speed) + 1.2e-2))

    axis = cogging.AxisParameters(mass=MASS, viscous=0.166, coulomb=0.15, coulomb_width=5e-3)
    model = cogging.Model(axis=axis, uncertainty={"mass": 0.02, "viscous": 0.3, "coulomb": 0.1})
    level, short = law(np.std(motion(4.0)[2])) / 0.15 - 1.0, []
    for seed in range(3):
        found = cogging.diagnose(moved(lambda t, x, v: -law(v), 0.02, seed, seconds=4.0), model)
        assert [effect.name for effect in found.effects] == ["coulomb_change"]
        change = found.effects[0].parameters["change"]
        low, high = change.ci95
        assert low <= change.value < level
        assert high < 1.02
        short.append(level - high)
    assert np.sum(np.array(short) > 0.0) <= 1
    assert max(short) < 0.01


@pytest.mark.parametrize("widths", [(2e-3, 2e-3), (2e-3, 8e-3), (1e-2, 2e-3)])
def test_mass_and_friction_lie_within_their_intervals(widths):
    """Whether the width of the friction law is stated rightly or not; seen are 15 to 20 of 20.

    With all friction laws beside the true one, the level of Coulomb friction was within in 10 to 15.
    """
    true, stated = widths
    axis = cogging.AxisParameters(mass=MASS, viscous=0.18, coulomb=0.14, coulomb_width=stated)
    model = cogging.Model(axis=axis, uncertainty={"mass": 0.03, "viscous": 0.2, "coulomb": 0.2})
    errors = []
    for seed in range(20):
        log = moved(lambda t, x, v: -0.15 * 2 / np.pi * np.arctan(v / true), 0.02, seed, seconds=8.0)
        evidence = Evidence([DifferencedBalance(log, 5e-3)], model, model).prepare(2)
        evidence = replace(evidence, with_width=True).prepare(1)
        errors.append([])
        for name, value in (("mass", MASS), ("viscous", 0.166), ("coulomb", 0.15), ("coulomb_width", true)):
            k = evidence.paths.index(f"axis.{name}")
            low, high = evidence.interval(k)
            error = value - getattr(evidence.model.axis, name) - evidence.null.theta[k]
            errors[-1].append(error / (high if error > 0.0 else -low))
    assert np.all(np.sum(np.abs(errors) < 1.0, axis=0) >= 14)
    assert np.all(np.abs(np.mean(errors, axis=0)) < 0.35)  # of half an interval: three deviations of a mean of 20
    assert np.all(np.sqrt(np.mean(np.square(errors), axis=0)) > 0.35)


def test_a_log_without_valid_rows_has_no_blocks():
    """As of a confirm log whose strokes are shorter than its filter."""
    moving, still = (DifferencedBalance(moved(0.2), 5e-3) for _ in range(2))
    still.keep = np.zeros_like(still.keep)
    for balances in ([moving, still], [still, moving]):
        evidence = Evidence(balances, machine(), machine()).prepare()
        edges = block_edges(evidence)
        assert list(edges) == list(block_edges(Evidence([moving], machine(), machine()).prepare()))
        assert len(np.add.reduceat(evidence.null.rest, edges)) == len(edges) > 1


def test_a_confirm_log_of_too_little_motion_confirms_nothing():
    log = moved(0.05, 0.02, seconds=4.0)
    found = cogging.diagnose(log[800:], machine(), confirm=log[:800])
    assert found.effects[0].name == "constant_force"
    assert found.gap.confirm_before is None
    assert any("confirm nothing" in note for note in found.notes)
