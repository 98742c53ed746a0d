"""The cogging map against known truth, plain numpy and scipy, and a real scan (72 detents a turn)."""

import re

import numpy as np
import pytest
from scipy import stats
from scipy.signal import lfilter

import cogging
from cogging import fit_map
from cogging.files import read_toml

PITCH = 0.05
STEP = 1e-3
NOISE = 0.03
HARMONICS = [1, 2, 3, 6, 12]
BASE = np.array([0.5, 0.3, 0.2, 0.1, 0.08])[:, None]  # V
GRID = np.arange(511) * STEP  # 0 to 0.51 m, as Lu et al. 2008 measured
THERE_AND_BACK = np.concatenate([GRID, GRID[::-1]])
DIRECTION = np.repeat([1.0, -1.0], GRID.size)


def fit(force, x=GRID, **options):
    return fit_map(x, force, pitch=PITCH, **options)


def fit_known(force, x=GRID, **options):
    """The fit with the true harmonics."""
    return fit(force, x, **{"harmonics": HARMONICS, "origin": 0.0, **options})


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


def two_way_scan(seed, model, correlation=0.0):
    """Force there and back, with a Coulomb level of 0.15 V and an offset of 0.2 V."""
    rng = np.random.default_rng(seed)
    both = [noise(rng, GRID.size, correlation) for _ in range(2)]
    return model.force(THERE_AND_BACK) + 0.2 + 0.15 * DIRECTION + np.concatenate(both)


def found(fit):
    return [entry.harmonic for entry in fit.amplitudes]


def has_note(fit, words):
    return any(words in note for note in fit.notes)


def deviations(fit, model, columns=slice(None)):
    """Sines and cosines of the map beside the truth, in standard errors."""
    sine = (fit.cogging.sine - model.sine) / fit.sine_standard_error
    cosine = (fit.cogging.cosine - model.cosine) / fit.cosine_standard_error
    return list(np.concatenate([sine[:, columns], cosine[:, columns]]).ravel())


# --- known truth ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("correlation", [0.0, np.exp(-1 / 5)])
def test_modulated_truth_is_found_within_its_standard_errors(correlation):
    """Noise white, and correlated over 5 mm: errors must be honest about it."""
    apart, amplitudes, coulomb, orders = [], [], [], []
    for seed in range(8):
        model = truth(seed)
        made = fit(two_way_scan(seed, model, correlation), THERE_AND_BACK, origin=0.0)
        assert found(made) == HARMONICS, seed
        orders.append(made.order)
        coulomb.append((made.coulomb - 0.15) / made.coulomb_standard_error)
        if made.order == 3:
            apart += deviations(made, model)
            weights = model.basis.spline.design_matrix(made.position)
            squares = (weights @ model.sine.T) ** 2 + (weights @ model.cosine.T) ** 2
            true = np.sqrt(squares.mean(axis=0))
            amplitudes += [(e.amplitude - a) / e.standard_error for e, a in zip(made.amplitudes, true, strict=True)]
    assert orders.count(3) >= 7
    assert 0.91 <= np.mean(np.abs(apart) < 1.96) <= 0.995  # 95 % stated; 0.96 seen
    assert np.std(apart) < 1.1
    # The noise level of red noise is itself an estimate, which widens the tails.
    assert max(np.abs(apart)) < (8.0 if correlation else 4.5)
    assert 0.3 < np.sqrt(np.mean(np.square(amplitudes))) < 1.3
    assert np.sqrt(np.mean(np.square(coulomb))) < 1.6


@pytest.mark.parametrize(("order", "correlation"), [(0, 0.82), (1, 0.0), (2, 0.0)])
def test_cross_validation_chooses_the_order_of_the_truth(order, correlation):
    """Of order 3: test_modulated_truth_is_found_within_its_standard_errors."""
    orders = []
    for seed in range(8):
        made = fit_known(two_way_scan(seed, truth(seed, order=order), correlation), THERE_AND_BACK)
        orders.append(made.order)
        if order:
            assert [score.coefficients for score in made.cross_validation] == [10, 110, 120, 130, 140]
            table = {score.order: score.rms for score in made.cross_validation}
            assert table[0] > 2.0 * table[order]  # the change along the travel is ten times the noise
            assert NOISE * 0.95 < table[order] < NOISE * 2.0  # 120 coefficients of 1,022 points
    assert orders.count(order) >= 7


# --- noise ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("correlation", "false_alarm", "runs"), [(0.95, 0.01, 100), (0.0, 0.1, 50)])
def test_noise_alone_yields_harmonics_no_more_often_than_stated(correlation, false_alarm, runs):
    rng = np.random.default_rng(7)
    alarms = 0
    for _ in range(runs):
        made = fit(noise(rng, GRID.size, correlation), false_alarm=false_alarm)
        alarms += bool(made.amplitudes)
        assert bool(made.amplitudes) != has_note(made, "no harmonic")
        if not made.amplitudes:
            assert np.all(made.cogging.force(GRID) == 0.0)
            assert made.cross_validation == ()
    # Were the rate any higher than stated, more alarms than this would come once in a thousand.
    assert alarms <= stats.binom.ppf(0.999, runs, false_alarm)


def test_a_harmonic_little_above_its_threshold_is_found_and_a_strong_one_lends_no_leakage():
    hits, amplitude = 0, 6.0 * NOISE * np.sqrt(2.0 / GRID.size)
    for seed in range(20):
        rng = np.random.default_rng(seed)
        force = amplitude * np.sin(2.0 * np.pi * 7.0 * GRID / PITCH + seed) + noise(rng, GRID.size)
        hits += found(fit(force)) == [7]
    assert hits >= 15
    # Ten thousand times the noise over 10.2 pitches: its side lobes stand far above the noise everywhere.
    strong = 30.0 * np.sin(2.0 * np.pi * 3.0 * GRID / PITCH)
    assert found(fit(strong + 0.1 * noise(np.random.default_rng(0), GRID.size))) == [3]


# --- friction, offset, trend ------------------------------------------------------------------------------------------


def test_force_sign_turns_the_sensor_round():
    force = two_way_scan(1, truth(1))
    made, turned, wrong = (
        fit_known(sign * force, THERE_AND_BACK, force_sign=stated) for sign, stated in ((1, 1), (-1, -1), (-1, 1))
    )
    assert np.array_equal(made.cogging.sine, turned.cogging.sine)
    assert made.coulomb == turned.coulomb
    assert wrong.coulomb == pytest.approx(-0.15, abs=0.01)
    assert has_note(wrong, "force_sign")
    assert not has_note(made, "force_sign")


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_one_way_scan_reports_that_friction_is_unknown(direction):
    x = GRID[:: int(direction)]
    force = truth(2).force(x) + 0.2 + 0.15 * direction + noise(np.random.default_rng(2), x.size)
    made = fit_known(force, x, order=3)
    assert (made.coulomb, made.coulomb_standard_error) == (None, None)
    assert (made.direction_amplitudes, made.direction_lag) == ((), None)
    assert made.offset == pytest.approx(0.2 + 0.15 * direction, abs=5.0 * made.offset_standard_error)
    assert has_note(made, "one way")
    assert "coulomb" not in made.text()
    assert np.all(made.direction == direction)


def test_direction_is_that_of_the_motion_and_not_of_the_encoder_noise():
    """Rests of 40 rows with a noise of half a step; the backward pass is offset by a third of a step."""
    rng, model = np.random.default_rng(4), truth(4, order=0)
    places = np.concatenate([GRID, GRID[::-1] - STEP / 3.0])
    x = np.repeat(places, 40) + 0.2 * STEP * rng.normal(size=40 * places.size)
    direction = np.repeat(DIRECTION, 40)
    assert np.mean(np.sign(np.diff(x)) != direction[1:]) > 0.4  # what the raw sign would say
    made = fit_known(model.force(x) + 0.15 * direction + noise(rng, x.size), x, order=0)
    assert made.coulomb == pytest.approx(0.15, abs=5.0 * made.coulomb_standard_error)
    assert made.coulomb_standard_error < 0.002
    assert made.cogging.sine == pytest.approx(model.sine, abs=0.004)


def test_rows_just_after_a_reversal_are_left_out():
    """Friction that turns over 4 mm, like a spring, after each reversal would spoil the Coulomb level."""
    way = np.minimum(np.arange(GRID.size) * STEP / 0.004, 1.0)
    friction = 0.15 * np.concatenate([np.ones(GRID.size), 1.0 - 2.0 * way])
    made = fit_known(truth(6, order=0).force(THERE_AND_BACK) + friction, THERE_AND_BACK, order=0)
    assert made.coulomb == pytest.approx(0.15, abs=1e-9)
    assert has_note(made, "after a reversal")


def test_a_trend_is_reported_where_there_is_one():
    force = two_way_scan(9, truth(9))
    flat = fit_known(force, THERE_AND_BACK, order=3)
    assert (flat.trend, flat.trend_standard_error, has_note(flat, "trend")) == (0.0, 0.0, False)
    tilted = fit_known(force + 0.4 * THERE_AND_BACK, THERE_AND_BACK, order=3)
    assert tilted.trend == pytest.approx(0.4, abs=5.0 * tilted.trend_standard_error)
    assert tilted.trend_standard_error < 0.02
    assert tilted.offset == pytest.approx(0.2 + 0.4 * 0.255, abs=0.01)  # at the centre of the travel
    assert has_note(tilted, "trend")
    total = tilted.cogging.force(tilted.position) + tilted.offset + tilted.coulomb * tilted.direction
    assert tilted.fitted == pytest.approx(total + tilted.trend * (tilted.position - 0.255), abs=1e-9)


# --- what the scan does not determine ---------------------------------------------------------------------------------


def test_control_points_without_data_are_listed_and_continue_their_neighbours():
    model = truth(10)
    x = np.concatenate([GRID[GRID < 0.1505], GRID[GRID > 0.3495]])  # a gap of four pitches
    made = fit_known(model.force(x) + noise(np.random.default_rng(10), x.size), x, order=3)
    # Point c acts on [(c - 2) pitch, (c + 1) pitch): 5 and 6 lie in the gap, 12 on the last 10 mm, hardly.
    assert made.unexcited == (5, 6, 12)
    assert has_note(made, "control points 5, 6, 12")
    sine = made.cogging.sine
    assert sine[:, 5] == pytest.approx((2.0 * sine[:, 4] + sine[:, 7]) / 3.0, abs=0.02)
    assert sine[:, 12] == pytest.approx(sine[:, 11], abs=0.1)
    seen = np.setdiff1d(np.arange(13), made.unexcited)
    assert np.min(made.sine_standard_error[:, [5, 6, 12]]) > 5.0 * np.median(made.sine_standard_error[:, seen])
    assert np.max(np.abs(deviations(made, model, seen))) < 4.5


def test_periods_and_harmonics_that_are_left_out_are_named():
    force = 0.5 * np.sin(2 * np.pi * GRID / PITCH) + 0.1 * np.sin(2 * np.pi * 2.4 * GRID / PITCH)
    made = fit(force + noise(np.random.default_rng(11), GRID.size))
    assert found(made) == [1]
    assert any(re.match(r"not in the map: 0\.(099|1|1\d?) V with period 0\.0209 m", note) for note in made.notes)
    assert made.residual_rms > 2.0 * made.noise
    without = fit(two_way_scan(0, truth(0, order=0)), THERE_AND_BACK, harmonics=[1, 2, 3, 12], order=0)
    assert has_note(without, "harmonic 6)")
    assert has_note(fit_known(two_way_scan(0, truth(0)), THERE_AND_BACK, order=0), "change along the travel")


# --- independent formulas ---------------------------------------------------------------------------------------------


def test_periodic_fit_is_the_least_squares_solution():
    made = fit(two_way_scan(13, truth(13, order=0)), THERE_AND_BACK, harmonics=[2, 1], order=0)
    x, y = made.position, made.force
    angles = 2.0 * np.pi * x[:, None] * np.array([2.0, 1.0]) / PITCH
    columns = np.column_stack([np.sin(angles), np.cos(angles), np.ones(x.size), made.direction])
    plain, *_ = np.linalg.lstsq(columns, y, rcond=None)
    assert made.cogging.basis.harmonics == [2, 1]  # in the order given
    assert [*made.cogging.sine[:, 0], *made.cogging.cosine[:, 0]] == pytest.approx(plain[:4], abs=1e-9)
    assert (made.offset, made.coulomb) == pytest.approx(tuple(plain[4:]), abs=1e-9)
    entry = made.amplitudes[0]
    assert entry.amplitude * np.exp(1j * entry.phase) == pytest.approx(plain[0] + 1j * plain[2], abs=1e-9)
    assert made.residual_rms == pytest.approx(np.sqrt(np.mean((y - columns @ plain) ** 2)), rel=1e-9)


# --- calls and results ------------------------------------------------------------------------------------------------

WAVE = np.sin(2.0 * np.pi * GRID / PITCH)


JITTER = 1e-6 * np.random.default_rng(5).normal(size=THERE_AND_BACK.size)
FEW = np.concatenate([np.repeat([0.0, 0.05], 5), np.arange(0.0, 0.05, 0.013)])
REFUSED = [
    ({"position": FEW, "force": np.sin(FEW)}, r"position: must hold at least 10 points that differ, got \d$"),
    (  # both ways with jitter there are points 1 um apart, but they resolve no more than one every mm
        {"position": THERE_AND_BACK + JITTER, "force": np.zeros(JITTER.size), "harmonics": [20]},
        "harmonics: must be at most 19 with points this far apart, got 20",
    ),
    ({"force": np.where(np.arange(511) == 9, np.inf, WAVE)}, r"force: must be finite numbers, got inf in row 9"),
    ({"force": WAVE[:-1]}, r"force: must have one value for each of the 511 positions, got 510"),
    ({"position": GRID.reshape(7, 73)}, r"position: must be one-dimensional and not empty, got shape \(7, 73\)"),
    ({"position": 0.09 * GRID}, r"position: must travel at least one pitch \(0.05 m\), got 0.0459 m"),
    ({"position": 30.0 * GRID}, r"position: must have a point every 0.0133 m or less, got one every 0.03 m"),
    ({"force_sign": 0}, r"force_sign: must be 1 or -1, got 0"),
    ({"harmonics": [1, 1]}, r"harmonics: each may stand once, got 1"),
    ({"order": 17}, r"order: must be a whole number from 1 to 16, or 0 for a periodic map, got 17"),
    ({"order": 3, "origin": -1e9}, r"order: must need at most 507 coefficients .*got 4\d+ for order 3"),
    ({"origin": 0.51}, r"origin: must lie below the scan's highest position 0.51 m, got 0.51"),
    ({"false_alarm": 0.0}, r"false_alarm: must lie between 0 and 1, got 0.0"),
]


@pytest.mark.parametrize(("change", "message"), REFUSED)
def test_refused(change, message):
    with pytest.raises(ValueError, match=f"^{message}") as caught:
        fit_map(**({"position": GRID, "force": WAVE, "pitch": PITCH} | change))
    assert "\n" not in str(caught.value)


def test_a_scan_without_noise_gives_the_truth_and_its_file_the_map(tmp_path):
    x, model = GRID[:501], truth(21)
    made = fit_known(model.force(x) + 0.3, x, order=3)
    assert made.cogging.force(x) == pytest.approx(model.force(x), abs=1e-5)
    assert made.notes == ("the scan goes one way only: friction and offset cannot be told apart, `offset` holds both",)
    made.write(tmp_path / "map.toml")
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["map.png", "map.toml"]
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")
    section = read_toml(tmp_path / "map.toml")["cogging"]
    sine, cosine = section.pop("sine"), section.pop("cosine")
    basis = cogging.SplineHarmonics(control_points=len(sine[0]), **section)
    assert np.array_equal(cogging.CoggingModel(basis, sine, cosine).force(x), made.cogging.force(x))
    with pytest.raises(ValueError, match="cannot be written"):
        made.write(tmp_path / "no" / "map.toml")
