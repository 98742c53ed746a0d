"""The cogging map against known truth, plain numpy and scipy, and a real scan (72 detents a turn)."""

import re

import numpy as np
import pytest
from scipy import stats
from scipy.interpolate import BSpline as ScipySpline
from scipy.signal import lfilter

import cogging
from cogging.files import read_toml
from cogging.mapping.fit_map import fit_map
from tests.fixtures.measured import FOLDER

PITCH = 0.05
STEP = 1e-3
NOISE = 0.03
HARMONICS = [1, 2, 3, 6, 12]
BASE = np.array([0.5, 0.3, 0.2, 0.1, 0.08])[:, None]  # V
GRID = np.arange(511) * STEP  # 0 to 0.51 m, as Lu et al. 2008 measured
THERE_AND_BACK = np.concatenate([GRID, GRID[::-1]])
DIRECTION = np.repeat([1.0, -1.0], GRID.size)


def truth(seed, *, order=3, spread=0.3):
    """A random map on the knots of the paper's travel; periodic where order is 0."""
    rng = np.random.default_rng(1000 + seed)
    points = 11 + order - 1 if order else 1
    phase = rng.uniform(0.0, 2.0 * np.pi, (5, 1))
    change = spread * BASE * rng.normal(size=(2, 5, points)) if order else np.zeros((2, 5, 1))
    basis = cogging.SplineHarmonics(
        pitch=PITCH, harmonics=HARMONICS, order=max(order, 1), origin=0.0, control_points=points
    )
    return cogging.CoggingModel(basis, BASE * np.cos(phase) + change[0], BASE * np.sin(phase) + change[1])


def noise(rng, size, correlation=0.0):
    """White or first-order noise of NOISE V rms."""
    drive = NOISE * np.sqrt(1.0 - correlation**2) * rng.normal(size=size + 200)
    return lfilter([1.0], [1.0, -correlation], drive)[200:]


def two_way_scan(seed, model, coulomb=0.15, offset=0.2, correlation=0.0):
    rng = np.random.default_rng(seed)
    both = [noise(rng, GRID.size, correlation) for _ in range(2)]
    return model.force(THERE_AND_BACK) + offset + coulomb * DIRECTION + np.concatenate(both)


def local_amplitudes(model, x):
    weights = model.basis.spline.design_matrix(x)
    squares = (weights @ model.sine.T) ** 2 + (weights @ model.cosine.T) ** 2
    return np.sqrt(squares.mean(axis=0))


def found(fit):
    return [entry.harmonic for entry in fit.amplitudes]


# --- a real scan ------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def laas():
    """Position (rad) and current (A) of one turn forward and one back."""
    path = FOLDER / "laas" / "stopped_data.txt"
    table = np.genfromtxt(path, delimiter=",", names=True, deletechars="", autostrip=True)
    return table["Position"], table["Iq"]


@pytest.mark.data
def test_real_scan_over_one_turn(laas):
    position, current = laas
    fit = fit_map(position, current, pitch=2.0 * np.pi)
    amplitudes = {entry.harmonic: entry.amplitude for entry in fit.amplitudes}
    assert max(amplitudes, key=amplitudes.get) == 72
    assert amplitudes[72] == pytest.approx(0.184, rel=0.015)  # README of the data, fitted to rows, not to places
    assert amplitudes[18] == pytest.approx(0.0422, rel=0.03)
    assert amplitudes[12] == pytest.approx(0.0304, rel=0.03)
    assert amplitudes[144] == pytest.approx(0.0236, rel=0.03)
    assert {24, 36, 48, 54, 71, 73, 90} <= set(amplitudes)
    assert len(amplitudes) <= 30  # of 200 that are looked at
    assert max(entry.false_alarm for entry in fit.amplitudes if entry.harmonic in (12, 18, 72, 144)) < 1e-20
    assert fit.coulomb == pytest.approx(0.053, abs=0.002)
    assert 1e-4 < fit.coulomb_standard_error < 2e-3
    assert abs(fit.offset) < 0.002
    assert fit.residual_rms < 0.018  # 0.145 before
    assert fit.order == 0
    assert fit.trend == 0.0
    assert any("rows averaged" in note for note in fit.notes)


# --- known truth ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("correlation", [0.0, np.exp(-1 / 2), np.exp(-1 / 5)])
def test_modulated_truth_is_found_within_its_standard_errors(correlation):
    """Noise white, and correlated over 2 and 5 mm: errors must be honest about it."""
    deviations, amplitude_deviations, coulomb, orders = [], [], [], []
    for seed in range(8):
        model = truth(seed)
        fit = fit_map(THERE_AND_BACK, two_way_scan(seed, model, correlation=correlation), pitch=PITCH, origin=0.0)
        assert found(fit) == HARMONICS, seed
        orders.append(fit.order)
        if fit.order == 3:
            deviations += list(((fit.cogging.sine - model.sine) / fit.sine_standard_error).ravel())
            deviations += list(((fit.cogging.cosine - model.cosine) / fit.cosine_standard_error).ravel())
            true = local_amplitudes(model, fit.position)
            amplitude_deviations += [
                (entry.amplitude - a) / entry.standard_error for entry, a in zip(fit.amplitudes, true, strict=True)
            ]
        coulomb.append((fit.coulomb - 0.15) / fit.coulomb_standard_error)
    assert orders.count(3) >= 7
    assert 0.91 <= np.mean(np.abs(deviations) < 1.96) <= 0.995  # 95 % stated; 0.96 seen
    assert np.std(deviations) < 1.1
    # The noise level of red noise is itself an estimate, which widens the tails.
    assert max(np.abs(deviations)) < (8.0 if correlation else 4.5)
    assert 0.3 < np.sqrt(np.mean(np.square(amplitude_deviations))) < 1.3
    assert np.sqrt(np.mean(np.square(coulomb))) < 1.6


@pytest.mark.parametrize(("points", "correlation", "low", "high"), [(511, 0.0, 0.85, 1.15), (201, 0.78, 0.4, 1.3)])
def test_standard_errors_fit_white_noise_and_short_scans_of_correlated_noise(points, correlation, low, high):
    """Neighbouring points of two pitches are alike: errors that assume white noise would be 2.5 times too small."""
    x, deviations = np.linspace(0.0, 0.51 if points == 511 else 0.1, points), []
    for seed in range(40):
        model = truth(seed, order=0)
        force = model.force(x) + noise(np.random.default_rng(seed), points, correlation)
        fit = fit_map(x, force, pitch=PITCH, harmonics=HARMONICS, order=0)
        deviations += list(((fit.cogging.sine - model.sine) / fit.sine_standard_error).ravel())
    assert low < np.std(deviations) < high


@pytest.mark.parametrize(("order", "correlation"), [(0, 0.0), (0, 0.82), (1, 0.0), (2, 0.0), (3, 0.0)])
def test_cross_validation_chooses_the_order_of_the_truth(order, correlation):
    orders = []
    for seed in range(8):
        force = two_way_scan(seed, truth(seed, order=order), correlation=correlation)
        fit = fit_map(THERE_AND_BACK, force, pitch=PITCH, harmonics=HARMONICS, origin=0.0)
        orders.append(fit.order)
        if order == 0:
            continue
        assert [score.order for score in fit.cross_validation] == [0, 1, 2, 3, 4]
        assert [score.coefficients for score in fit.cross_validation] == [10, 110, 120, 130, 140]
        table = {score.order: score.rms for score in fit.cross_validation}
        assert table[0] > 2.0 * table[order]  # the change along the travel is ten times the noise
        assert NOISE * 0.95 < table[order] < NOISE * 2.0  # 120 coefficients of 1,022 points
    assert orders.count(order) >= 7


@pytest.mark.parametrize("seed", [1, 2])
def test_the_simplest_order_within_one_standard_error_of_the_best_is_chosen(seed):
    force = two_way_scan(seed, truth(seed, order=3, spread=0.1))
    fit = fit_map(THERE_AND_BACK, force, pitch=PITCH, harmonics=HARMONICS, origin=0.0)
    best = min(fit.cross_validation, key=lambda score: score.rms)
    alike = [score.order for score in fit.cross_validation if score.rms <= best.rms + best.standard_error]
    assert best.order == 2
    assert fit.order == min(alike) == 1


def test_modulation_with_no_line_at_the_harmonic_is_found():
    """An amplitude that changes sign half-way: all of it stands in the sidebands."""
    x = np.arange(501) * STEP
    rng = np.random.default_rng(3)
    force = 0.1 * np.cos(np.pi * x / 0.5) * np.sin(2.0 * np.pi * 4.0 * x / PITCH) + noise(rng, x.size)
    fit = fit_map(x, force, pitch=PITCH)
    assert found(fit) == [4]
    assert fit.order >= 1
    assert fit.amplitudes[0].amplitude == pytest.approx(0.1 / np.sqrt(2.0), rel=0.1)
    assert fit.cross_validation[0].rms > 1.5 * min(score.rms for score in fit.cross_validation)


def test_short_and_irregular_scans():
    for pitches, seed in [(1, 0), (2, 1), (3, 2)]:
        x = np.sort(np.random.default_rng(seed).uniform(0.0, pitches * PITCH, 80 * pitches))
        x[[0, -1]] = 0.0, pitches * PITCH
        model = truth(seed, order=0)
        fit = fit_map(x, model.force(x) + 0.3 * noise(np.random.default_rng(seed), x.size), pitch=PITCH, order=0)
        assert set(HARMONICS[:4]) <= set(found(fit)), pitches
        assert len(found(fit)) <= 6
        assert any("too short" in note for note in fit.notes) == (pitches < 3)


# --- noise ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("correlation", "false_alarm"), [(0.95, 0.01), (0.0, 0.1)])
def test_noise_alone_yields_harmonics_no_more_often_than_stated(correlation, false_alarm):
    rng = np.random.default_rng(7)
    runs, alarms = 120, 0
    for _ in range(runs):
        fit = fit_map(GRID, noise(rng, GRID.size, correlation), pitch=PITCH, false_alarm=false_alarm)
        alarms += bool(fit.amplitudes)
        assert bool(fit.amplitudes) != any("no harmonic" in note for note in fit.notes)
        if not fit.amplitudes:
            assert np.all(fit.cogging.force(GRID) == 0.0)
            assert fit.cross_validation == ()
    # Were the rate any higher than stated, more alarms than this would come once in a thousand.
    assert alarms <= stats.binom.ppf(0.999, runs, false_alarm)


def test_a_harmonic_little_above_its_threshold_is_found():
    hits, amplitude = 0, 6.0 * NOISE * np.sqrt(2.0 / GRID.size)
    for seed in range(20):
        rng = np.random.default_rng(seed)
        force = amplitude * np.sin(2.0 * np.pi * 7.0 * GRID / PITCH + seed) + noise(rng, GRID.size)
        hits += found(fit_map(GRID, force, pitch=PITCH)) == [7]
    assert hits >= 15


def test_a_strong_harmonic_lends_no_leakage():
    """Ten thousand times the noise over 10.2 pitches: its side lobes stand far above the noise everywhere."""
    rng = np.random.default_rng(0)
    force = 30.0 * np.sin(2.0 * np.pi * 3.0 * GRID / PITCH) + 0.1 * noise(rng, GRID.size)
    assert found(fit_map(GRID, force, pitch=PITCH)) == [3]


# --- friction, offset, trend ------------------------------------------------------------------------------------------


def test_force_sign_turns_the_sensor_round():
    model = truth(1)
    force = two_way_scan(1, model)
    fit = fit_map(THERE_AND_BACK, force, pitch=PITCH, harmonics=HARMONICS)
    turned = fit_map(THERE_AND_BACK, -force, pitch=PITCH, harmonics=HARMONICS, force_sign=-1)
    assert np.array_equal(fit.cogging.sine, turned.cogging.sine)
    assert fit.coulomb == turned.coulomb
    wrong = fit_map(THERE_AND_BACK, -force, pitch=PITCH, harmonics=HARMONICS)
    assert wrong.coulomb == pytest.approx(-0.15, abs=0.01)
    assert any("force_sign" in note for note in wrong.notes)
    assert not any("force_sign" in note for note in fit.notes)


def test_one_way_scan_says_that_friction_is_unknown():
    model = truth(2)
    rng = np.random.default_rng(2)
    for x, direction in [(GRID, 1.0), (GRID[::-1], -1.0)]:
        force = model.force(x) + 0.2 + 0.15 * direction + noise(rng, x.size)
        fit = fit_map(x, force, pitch=PITCH, harmonics=HARMONICS, order=3, origin=0.0)
        assert fit.coulomb is None
        assert (fit.coulomb_standard_error, fit.direction_amplitudes, fit.direction_lag) == (None, (), None)
        assert fit.offset == pytest.approx(0.2 + 0.15 * direction, abs=5.0 * fit.offset_standard_error)
        assert any("one way" in note for note in fit.notes)
        assert "coulomb" not in fit.text()
        assert np.all(fit.direction == direction)


def test_a_short_way_back_is_left_out():
    x = np.concatenate([GRID, GRID[:-40:-1]])  # 39 mm back: less than a pitch
    force = truth(2).force(x) + np.where(np.arange(x.size) < GRID.size, 0.15, -0.15)
    fit = fit_map(x, force, pitch=PITCH, harmonics=HARMONICS, order=3, origin=0.0)
    assert fit.coulomb is None
    assert fit.offset == pytest.approx(0.15, abs=1e-4)
    assert any("short way back" in note for note in fit.notes)


def test_direction_is_that_of_the_motion_and_not_of_the_encoder_noise():
    """Rests of 40 rows with a noise of half a step; the backward pass is offset by a third of a step."""
    rng = np.random.default_rng(4)
    places = np.concatenate([GRID, GRID[::-1] - STEP / 3.0])
    x = np.repeat(places, 40) + 0.2 * STEP * rng.normal(size=40 * places.size)
    direction = np.repeat(DIRECTION, 40)
    model = truth(4, order=0)
    force = model.force(x) + 0.15 * direction + noise(rng, x.size)
    assert np.mean(np.sign(np.diff(x)) != direction[1:]) > 0.4  # what the raw sign would say
    fit = fit_map(x, force, pitch=PITCH, harmonics=HARMONICS, order=0)
    assert fit.coulomb == pytest.approx(0.15, abs=5.0 * fit.coulomb_standard_error)
    assert fit.coulomb_standard_error < 0.002
    assert fit.cogging.sine == pytest.approx(model.sine, abs=0.004)


def test_friction_that_wanders_differently_in_each_direction_widens_the_error_of_its_level():
    deviations = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        wander = noise(rng, GRID.size, 0.98)  # of the friction level along the travel, the same in both directions
        friction = DIRECTION * np.concatenate([0.15 + wander, 0.15 + wander[::-1]])
        force = truth(seed, order=0).force(THERE_AND_BACK) + friction + 0.1 * noise(rng, DIRECTION.size)
        fit = fit_map(THERE_AND_BACK, force, pitch=PITCH, harmonics=HARMONICS, order=0)
        deviations.append((fit.coulomb - 0.15) / fit.coulomb_standard_error)
    assert 0.3 < np.sqrt(np.mean(np.square(deviations))) < 1.5


def test_rows_just_after_a_reversal_are_left_out():
    """Friction that turns over 4 mm, like a spring, after each reversal would spoil the Coulomb level."""
    way = np.minimum(np.arange(GRID.size) * STEP / 0.004, 1.0)
    friction = 0.15 * np.concatenate([np.ones(GRID.size), 1.0 - 2.0 * way])
    force = truth(6, order=0).force(THERE_AND_BACK) + friction
    fit = fit_map(THERE_AND_BACK, force, pitch=PITCH, harmonics=HARMONICS, order=0)
    assert fit.coulomb == pytest.approx(0.15, abs=1e-9)
    assert any("after a reversal" in note for note in fit.notes)


def test_a_long_rest_weighs_no_more_than_its_place():
    """Ten thousand rows at one place with a force that is wrong there move the map no more than one point does."""
    rng = np.random.default_rng(8)
    force = truth(8, order=0).force(GRID) + noise(rng, GRID.size)
    force[100] += 0.2
    times = np.where(np.arange(GRID.size) == 100, 10_000, 1)
    once = fit_map(GRID, force, pitch=PITCH, harmonics=HARMONICS, order=0)
    long = fit_map(np.repeat(GRID, times), np.repeat(force, times), pitch=PITCH, harmonics=HARMONICS, order=0)
    assert long.cogging.sine == pytest.approx(once.cogging.sine, abs=1e-12)
    assert len(long.position) == GRID.size


def test_a_trend_is_reported_where_there_is_one():
    model = truth(9)
    force = two_way_scan(9, model)
    flat = fit_map(THERE_AND_BACK, force, pitch=PITCH, harmonics=HARMONICS, order=3)
    assert (flat.trend, flat.trend_standard_error) == (0.0, 0.0)
    assert not any("trend" in note for note in flat.notes)
    tilted = fit_map(THERE_AND_BACK, force + 0.4 * THERE_AND_BACK, pitch=PITCH, harmonics=HARMONICS, order=3)
    assert tilted.trend == pytest.approx(0.4, abs=5.0 * tilted.trend_standard_error)
    assert tilted.trend_standard_error < 0.02
    assert tilted.offset == pytest.approx(0.2 + 0.4 * 0.255, abs=0.01)  # at the centre of the travel
    assert any("trend" in note for note in tilted.notes)
    assert "V/m" in tilted.text()


# --- what the scan does not say ---------------------------------------------------------------------------------------


def test_control_points_without_data_are_listed_and_continue_their_neighbours():
    model = truth(10)
    x = np.concatenate([GRID[GRID < 0.1505], GRID[GRID > 0.3495]])  # a gap of four pitches
    rng = np.random.default_rng(10)
    fit = fit_map(x, model.force(x) + noise(rng, x.size), pitch=PITCH, harmonics=HARMONICS, order=3, origin=0.0)
    # Point c acts on [(c - 2) pitch, (c + 1) pitch): 5 and 6 lie in the gap, 12 on the last 10 mm, hardly.
    assert fit.unexcited == (5, 6, 12)
    assert any("control points 5, 6, 12" in note for note in fit.notes)
    sine = fit.cogging.sine
    assert sine[:, 5] == pytest.approx((2.0 * sine[:, 4] + sine[:, 7]) / 3.0, abs=0.02)
    assert sine[:, 12] == pytest.approx(sine[:, 11], abs=0.1)
    seen = np.setdiff1d(np.arange(13), fit.unexcited)
    assert np.min(fit.sine_standard_error[:, [5, 6, 12]]) > 5.0 * np.median(fit.sine_standard_error[:, seen])
    deviations = (fit.cogging.sine - model.sine)[:, seen] / fit.sine_standard_error[:, seen]
    assert np.max(np.abs(deviations)) < 4.5


def test_knots_before_the_scan_are_listed():
    fit = fit_map(GRID, truth(0).force(GRID) + 0.2, pitch=PITCH, harmonics=HARMONICS, order=3, origin=-0.2)
    assert fit.cogging.basis.spline.origin == -0.2
    assert fit.cogging.basis.spline.control_points == 15 + 2
    assert {0, 1, 2, 3} <= set(fit.unexcited)
    for rows in (501, 503):  # a sliver of travel gets no span
        full = fit_map(GRID[:rows], truth(0).force(GRID[:rows]), pitch=PITCH, harmonics=HARMONICS, order=3)
        assert full.unexcited == ()
        assert (full.cogging.basis.spline.control_points, full.cogging.basis.spline.origin) == (12, 0.0)


def test_a_period_that_is_no_harmonic_is_named():
    rng = np.random.default_rng(11)
    force = 0.5 * np.sin(2 * np.pi * GRID / PITCH) + 0.1 * np.sin(2 * np.pi * 2.4 * GRID / PITCH)
    fit = fit_map(GRID, force + noise(rng, GRID.size), pitch=PITCH)
    assert found(fit) == [1]
    assert any(re.match(r"not in the map: 0\.(099|1|1\d?) V with period 0\.0209 m", note) for note in fit.notes)
    assert fit.residual_rms > 2.0 * fit.noise


def test_a_harmonic_left_out_by_the_user_is_named():
    fit = fit_map(THERE_AND_BACK, two_way_scan(0, truth(0, order=0)), pitch=PITCH, harmonics=[1, 2, 3, 12], order=0)
    assert any("harmonic 6)" in note for note in fit.notes)
    fixed = fit_map(THERE_AND_BACK, two_way_scan(0, truth(0)), pitch=PITCH, harmonics=HARMONICS, order=0)
    assert any("change along the travel" in note for note in fixed.notes)


def test_an_order_with_too_many_coefficients_is_not_tried():
    x = np.arange(101) * STEP * 4.0
    force = sum(np.sin(2.0 * np.pi * h * x / PITCH) for h in (1, 2, 3, 4))
    fit = fit_map(x, force, pitch=PITCH)
    assert [score.order for score in fit.cross_validation] == [0]
    assert sum("not tried" in note for note in fit.notes) == 4


# --- independent formulas ---------------------------------------------------------------------------------------------


def scipy_regressor(x, harmonics, order, origin, points):
    """Eq. 3 to 5 with scipy's splines: the columns in the order of the paper's A_r."""
    knots = origin + PITCH * np.arange(1 - order, points + 1)
    columns = []
    for point in range(points):
        weight = ScipySpline(knots, np.eye(points)[point], order - 1)(x)
        for h in harmonics:
            angle = 2.0 * np.pi * h * x / PITCH
            columns += [weight * np.sin(angle), weight * np.cos(angle)]
    return np.stack(columns, axis=1)


@pytest.mark.parametrize("order", [1, 3])
def test_fit_is_the_least_squares_solution_with_its_prior(order):
    x, points = GRID[:500] + 0.3 * STEP, 9 + order  # no point on a knot, where order 1 jumps
    model = truth(12, order=order)
    force = model.force(x) + noise(np.random.default_rng(12), x.size)
    fit = fit_map(x, force, pitch=PITCH, harmonics=HARMONICS, order=order, origin=0.0)
    assert fit.order == order
    columns = np.column_stack([scipy_regressor(x, HARMONICS, order, 0.0, points), np.ones(x.size)])
    plain, *_ = np.linalg.lstsq(columns, force, rcond=None)
    # Residual and prediction hardly know of the prior ...
    rest = force - columns @ plain
    assert np.std(fit.fitted - columns @ plain) < 0.25 * NOISE
    # ... but the coefficients at the ends do, where neighbouring harmonics with free amplitudes look alike.
    variance = rest @ rest / (x.size - columns.shape[1])
    difference = np.kron(np.diff(np.eye(points), axis=0), np.eye(10)) * np.sqrt(variance / np.var(force))
    further = np.column_stack([difference, np.zeros(len(difference))])
    rows, values = np.vstack([columns, further]), np.concatenate([force, np.zeros(len(further))])
    table = np.linalg.lstsq(rows, values, rcond=None)[0][:-1].reshape(points, 5, 2)
    assert fit.cogging.sine == pytest.approx(table[:, :, 0].T, abs=2e-4)
    assert fit.cogging.cosine == pytest.approx(table[:, :, 1].T, abs=2e-4)


def test_periodic_fit_is_the_least_squares_solution():
    force = two_way_scan(13, truth(13, order=0))
    fit = fit_map(THERE_AND_BACK, force, pitch=PITCH, harmonics=[2, 1], order=0)
    x, y = fit.position, fit.force
    angles = 2.0 * np.pi * x[:, None] * np.array([2.0, 1.0]) / PITCH
    columns = np.column_stack([np.sin(angles), np.cos(angles), np.ones(x.size), fit.direction])
    plain, *_ = np.linalg.lstsq(columns, y, rcond=None)
    assert fit.cogging.basis.harmonics == [2, 1]  # in the order given
    assert fit.cogging.sine[:, 0] == pytest.approx(plain[:2], abs=1e-9)
    assert fit.cogging.cosine[:, 0] == pytest.approx(plain[2:4], abs=1e-9)
    assert (fit.offset, fit.coulomb) == pytest.approx(tuple(plain[4:]), abs=1e-9)
    entry = fit.amplitudes[0]
    assert entry.amplitude * np.exp(1j * entry.phase) == pytest.approx(plain[0] + 1j * plain[2], abs=1e-9)
    assert fit.residual_rms == pytest.approx(np.sqrt(np.mean((y - columns @ plain) ** 2)), rel=1e-9)


def test_fitted_is_the_sum_of_what_the_fit_states():
    fit = fit_map(THERE_AND_BACK, two_way_scan(14, truth(14)) + 0.5 * THERE_AND_BACK, pitch=PITCH)
    centre = 0.5 * (fit.position.min() + fit.position.max())
    total = fit.cogging.force(fit.position) + fit.offset + fit.coulomb * fit.direction
    assert fit.trend != 0.0
    assert fit.fitted == pytest.approx(total + fit.trend * (fit.position - centre), abs=1e-9)


# --- what is refused --------------------------------------------------------------------------------------------------

WAVE = np.sin(2.0 * np.pi * GRID / PITCH)


def with_value(values, row, value):
    changed = values.copy()
    changed[row] = value
    return changed


JITTER = 1e-6 * np.random.default_rng(5).normal(size=THERE_AND_BACK.size)
FEW = np.concatenate([np.repeat([0.0, 0.05], 5), np.arange(0.0, 0.05, 0.013)])
REFUSED = [
    ({"position": FEW, "force": np.sin(FEW)}, r"position: must hold at least 10 points that differ, got \d$"),
    (  # both ways with jitter there are points 1 um apart, but they resolve no more than one every mm
        {"position": THERE_AND_BACK + JITTER, "force": np.zeros(JITTER.size), "harmonics": [20]},
        "harmonics: must be at most 19 with points this far apart, got 20",
    ),
    ({"position": with_value(GRID, 7, np.nan)}, r"position: must be finite numbers, got nan in row 7"),
    ({"force": with_value(WAVE, 9, np.inf)}, r"force: must be finite numbers, got inf in row 9"),
    ({"force": WAVE[:-1]}, r"force: must have one value for each of the 511 positions, got 510"),
    ({"position": GRID.reshape(7, 73)}, r"position: must be one-dimensional, got 2 dimensions"),
    ({"position": ["a"] * 511}, r"position: must be real numbers, got .a. among them"),
    ({"force": WAVE + 1j}, r"force: must be real numbers, got ndarray"),
    ({"position": GRID[:3], "force": WAVE[:3]}, r"position: must hold at least 10 points of a scan, got 3"),
    ({"position": 0.09 * GRID}, r"position: must travel at least one pitch \(0.05 m\), got 0.0459 m"),
    ({"position": 30.0 * GRID}, r"position: must have a point every 0.0133 m or less, got one every 0.03 m"),
    ({"pitch": 0.0}, r"pitch: must be finite and above 0, got 0.0"),
    ({"pitch": "0.05"}, r"pitch: must be finite and above 0, got 0.05"),
    ({"force_sign": 0}, r"force_sign: must be 1 or -1, got 0"),
    ({"harmonics": []}, r"harmonics: must list 1 to 32 terms, got 0"),
    ({"harmonics": [1, 1]}, r"harmonics: each may stand once, got 1"),
    ({"harmonics": [0]}, r"harmonics: must be a list of whole numbers from 1, got \[0\]"),
    ({"harmonics": 3}, r"harmonics: must be a list of whole numbers from 1, got 3"),
    ({"order": 17}, r"order: must be a whole number from 1 to 16, or 0 for a periodic map, got 17"),
    ({"order": 3, "origin": -1e9}, r"order: must need at most 507 coefficients .*got 4\d+ for order 3"),
    ({"origin": 0.51}, r"origin: must lie below the scan's highest position 0.51 m, got 0.51"),
    ({"origin": np.inf}, r"origin: must be a finite number, got inf"),
    ({"false_alarm": 0.0}, r"false_alarm: must lie between 0 and 1, got 0.0"),
    ({"highest_harmonic": 0}, r"highest_harmonic: must be a whole number from 1, got 0"),
]


@pytest.mark.parametrize(("change", "message"), REFUSED)
def test_refused(change, message):
    arguments = {"position": GRID, "force": WAVE, "pitch": PITCH} | change
    with pytest.raises(ValueError, match=f"^{message}") as caught:
        fit_map(arguments.pop("position"), arguments.pop("force"), **arguments)
    assert "\n" not in str(caught.value)


# --- the result -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def fit():
    return fit_map(THERE_AND_BACK, two_way_scan(20, truth(20)), pitch=PITCH, origin=0.0)


def test_plot(fit):
    force, residual, spectrum = fit.plot().axes
    forward = fit.direction == 1.0
    x, y = force.lines[2].get_data()
    assert y == pytest.approx(fit.cogging.force(1e-3 * x))
    left = np.asarray(residual.lines[1].get_ydata())
    assert left == pytest.approx(1e3 * (fit.force - fit.fitted)[~forward])
    peak = spectrum.lines[0].get_xdata()[np.argmax(spectrum.lines[0].get_ydata())]
    assert peak == pytest.approx(1.0, abs=1e-9)


def test_write_and_read_again(fit, tmp_path):
    path = tmp_path / "map.toml"
    fit.write(path)
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["map.png", "map.toml"]
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")
    section = read_toml(path)["cogging"]
    sine, cosine = section.pop("sine"), section.pop("cosine")
    basis = cogging.SplineHarmonics(control_points=len(sine[0]), **section)
    again = cogging.CoggingModel(basis, sine, cosine)
    assert np.array_equal(again.force(GRID), fit.cogging.force(GRID))
    with pytest.raises(ValueError, match="cannot be written"):
        fit.write(tmp_path / "no" / "map.toml")


def test_map_without_harmonics_has_the_whole_interface(tmp_path):
    fit = fit_map(GRID, np.full(GRID.size, 0.7), pitch=PITCH)
    assert fit.offset == pytest.approx(0.7)
    assert fit.amplitudes == ()
    assert "periodic" in fit.text()
    fit.write(tmp_path / "map.toml")
    assert read_toml(tmp_path / "map.toml")["cogging"]["sine"] == [[0.0]]


def test_a_scan_without_noise_gives_the_truth():
    x = GRID[:501]
    model = truth(21)
    fit = fit_map(x, model.force(x) + 0.3, pitch=PITCH, harmonics=HARMONICS, order=3, origin=0.0)
    assert fit.cogging.force(x) == pytest.approx(model.force(x), abs=1e-5)
    assert fit.notes == ("the scan goes one way only: friction and offset cannot be told apart, `offset` holds both",)
