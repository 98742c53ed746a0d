"""The plant against force balances by hand, closed forms of stick and slip, and statistics of its noise.

Whole runs with every effect beside an independent integrator: test_fast_plants.py.
"""

import numpy as np
import pytest
from scipy import stats

import cogging
from tests.fixtures.log_columns import columns_of
from tests.fixtures.plants_by_hand import EXAMPLES, TWO_PI, driven, effect, exact_axis, example, free, pid, sine, wave


def atan_sign(v, width):
    """S(v) = (2/pi) atan(v / width), eq. 2 in the smooth form of the contract."""
    return 2 / np.pi * np.arctan(v / width)


# Force balance ---------------------------------------------------------------------------------------------


def test_acceleration_is_eq_10():
    rng = np.random.default_rng(1)
    basis = cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2, 3], order=3, control_points=13)
    for _ in range(50):
        mass, viscous, coulomb, width = rng.uniform([0.05, 0, 0, -4], [2, 1, 1, -1])
        axis = cogging.AxisParameters(mass=mass, viscous=viscous, coulomb=coulomb, coulomb_width=10**width)
        model = cogging.CoggingModel(basis, *rng.normal(size=(2, 3, 13)))
        x, v, u = rng.uniform(0, 0.5), rng.normal(), rng.normal()
        friction = axis.viscous * v + axis.coulomb * atan_sign(v, axis.coulomb_width)
        expected = (u - friction - basis.regressor(np.array([x]))[0] @ model.coefficients) / axis.mass
        got = cogging.Plant(axis, cogging=model).acceleration(position=x, velocity=v, command=u)
        assert got == pytest.approx(expected, rel=1e-12, abs=1e-12)
        bare = cogging.Plant(axis).acceleration(position=x, velocity=v, command=u)
        assert bare == pytest.approx((u - friction) / axis.mass, rel=1e-13, abs=1e-13)


# What an effect answers, by what it is called in EXAMPLES: hook, method, and where it is asked.
ANSWERS = {
    "force": ("force", "force_at", "position velocity time"),
    "level": ("friction_level", "friction_level_at", "position velocity"),
    "gain": ("command_gain", "gain_at", "position time"),
    "shape": ("shape_command", "shape_at", "command"),
    "reading_error": ("reading", "reading_at", "position"),
    "delay": ("command_delay", None, ""),
    "lag": ("lag", None, ""),
    "bristle": ("state", None, ""),
    "coupling": ("state", None, ""),
}


@pytest.mark.parametrize("name", sorted(cogging.EFFECTS))
def test_each_law_is_its_formula(name):
    """Each law alone, on scalars and arrays, and what forces, levels and gains do in the force balance."""
    one, by_hand = example(name), EXAMPLES[name][1]
    assert {ANSWERS[key][0] for key in by_hand if key in ANSWERS} == set(one.HOOKS)
    axis = cogging.AxisParameters(mass=0.4, viscous=0.2, coulomb=0.3, coulomb_width=0.01)
    plant, bare = cogging.Plant(axis, effects=[one]), cogging.Plant(axis)
    rng = np.random.default_rng(2)
    x, u, t = rng.uniform(-0.1, 0.5, 200), rng.normal(size=200), rng.uniform(0, 0.4, 200)
    v = np.append(rng.normal(size=199) * 10 ** rng.uniform(-4, 0, 199), 0.0)
    places, law = {"position": x, "velocity": v, "time": t, "command": u}, dict.fromkeys(ANSWERS, np.zeros(200))
    for key, (_, method, names) in ANSWERS.items():
        assert method is None or hasattr(one, method) == (key in by_hand)
        if method and key in by_hand:
            where = {name: places[name] for name in names.split()}
            law[key] = by_hand[key](*where.values()) * np.ones(200)
            got = getattr(one, method)(**where) - (x if key == "reading_error" else 0.0)
            np.testing.assert_allclose(got, law[key], rtol=1e-12, atol=1e-13)
            first = getattr(one, method)(**{name: values[0] for name, values in where.items()})
            assert isinstance(first, float)
            assert first == getattr(one, method)(**where)[0]
    added = law["force"] - law["level"] * atan_sign(v, 0.01) + law["gain"] * 0.7
    for i in range(200):
        where = {"position": x[i], "velocity": v[i], "time": t[i]}
        difference = plant.acceleration(**where, command=0.7) - bare.acceleration(**where, command=0.7)
        assert difference == pytest.approx(added[i] / 0.4, rel=1e-11, abs=1e-12)


SMOOTH = cogging.AxisParameters(mass=0.3, viscous=0.8, coulomb=0.2, coulomb_width=0.05)
PERIODIC = cogging.CoggingModel(cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2]), [[0.3], [-0.1]], [[0.1], [0.2]])


def tracking_run(effects, sample_rate=200.0, duration=0.4, steps=32, axis=SMOOTH):
    plant = cogging.Plant(axis, cogging=PERIODIC, effects=effects)
    controller = pid(sample_rate, kp=120.0, ki=300.0, kd=4.0, mass=0.3)
    reference = sine(center=0.05, amplitude=0.03, frequency=4.0)
    return cogging.closed_loop(plant, controller, reference, duration=duration, steps_per_sample=steps)


@pytest.mark.parametrize("name", sorted(cogging.EFFECTS))
@pytest.mark.parametrize(
    "axis",
    [SMOOTH, SMOOTH.replace(coulomb_width=0.0), SMOOTH.replace(coulomb_width=0.0, coulomb=0.0)],
    ids=["smooth", "exact", "frictionless"],
)
def test_an_effect_with_neutral_parameters_vanishes(name, axis):
    """A whole run, bit for bit; 1e-12 where a friction law cuts the steps of a frictionless axis."""
    neutral = tracking_run([cogging.EFFECTS[name]()], axis=axis)
    without = tracking_run([], axis=axis)
    for column in columns_of(without):
        if axis.coulomb == 0.0 and hasattr(cogging.EFFECTS[name], "friction_level_at"):
            scale = np.abs(getattr(without, column)).max()
            np.testing.assert_allclose(getattr(neutral, column), getattr(without, column), rtol=0, atol=1e-12 * scale)
        else:
            np.testing.assert_array_equal(getattr(neutral, column), getattr(without, column))


def test_delays_add_and_the_order_of_effects_is_free():
    commands = np.random.default_rng(5).normal(size=60)
    axis = cogging.AxisParameters(mass=0.2, viscous=0.7)
    one, two, whole = (effect("command_delay", delay=seconds) for seconds in (0.0013, 0.0021, 0.0034))

    def run(*effects):
        return driven(cogging.Plant(axis, effects=list(effects)), commands, 1000.0)

    np.testing.assert_allclose(run(one, two).true_position, run(whole).true_position, rtol=0, atol=1e-15)
    lag, cut = effect("actuator_lag", time_constant=0.003), effect("command_saturation", limit=0.8)
    forward = run(one, lag, cut)
    assert np.abs(forward.command).max() > 0.8  # logged before the limit of the amplifier
    for order in ((cut, lag, one), (lag, cut, one)):
        np.testing.assert_array_equal(run(*order).true_position, forward.true_position)


# Exact Coulomb friction ------------------------------------------------------------------------------------


ASYMMETRY = [effect("coulomb_asymmetry", difference=-0.2), effect("stribeck_friction", static_excess=0.1)]
OFFSET = [effect("constant_force", force=0.25)]
BREAKS = [([], 1, 0.8), (ASYMMETRY, 1, 0.8), (ASYMMETRY, -1, 1.0), (OFFSET, 1, 0.55), (OFFSET, -1, 1.05)]


@pytest.mark.parametrize(("effects", "direction", "level"), BREAKS)
def test_it_breaks_away_at_the_level(effects, direction, level):
    ramp = direction * np.linspace(0, 2, 2001)  # 1 mV a sample
    log = driven(cogging.Plant(exact_axis(), effects=effects), ramp, 1000.0)
    moving = log.true_velocity != 0.0
    first = np.argmax(moving)
    assert not log.true_position[:first].any()
    assert moving[first:].all()
    assert np.sign(log.true_velocity[first]) == direction
    # The command of sample first - 1 was the first above the level.
    assert abs(ramp[first - 2]) <= level * (1 + 1e-12)
    assert abs(ramp[first - 1]) >= level * (1 - 1e-12)


@pytest.mark.parametrize("ki", [0.0, 20000.0])
def test_no_chatter_at_rest_under_a_controller(ki):
    """The velocity never alternates from sample to sample; without integral action each rest is a rest."""
    steep = effect("stribeck_friction", static_excess=0.4, velocity=0.005)
    encoder = cogging.EncoderParameters(resolution=1e-6)
    motion = {"distance": 0.05, "velocity": 0.2, "acceleration": 3.0, "dwell": 1.0}
    reference = cogging.PointToPoint(cogging.PointToPointParameters(**motion))
    plant = cogging.Plant(exact_axis(viscous=0.3), effects=[steep], encoder=encoder)
    log = cogging.closed_loop(plant, pid(2000.0, kp=3000.0, ki=ki, kd=60.0), reference)
    direction = np.sign(log.true_velocity)
    assert not ((direction[2:] * direction[1:-1] < 0) & (direction[1:-1] * direction[:-2] < 0)).any()
    assert (direction == 0.0).mean() > 0.1
    into_the_rest = log.time % (reference.period / 2) - reference.move_time
    assert ki or not direction[(into_the_rest > 0.1) & (into_the_rest < 0.99)].any()


@pytest.mark.parametrize("stiffness", [1e2, 1e5, 1e9])
def test_presliding_is_stable_however_stiff_and_tends_to_the_exact_form(stiffness):
    commands = 1.5 * np.sin(4 * np.pi * np.arange(1001) / 1000.0)
    axis = exact_axis(viscous=0.3)
    exact = driven(cogging.Plant(axis), commands, 1000.0).true_position
    bristle = effect("presliding_friction", stiffness=stiffness, damping=0.5)
    log = driven(cogging.Plant(axis, effects=[bristle]), commands, 1000.0)
    assert np.abs(log.true_velocity).max() < 1.0
    # The contact gives way by g / stiffness at a period of sqrt(M / stiffness): a speed of g / sqrt(M stiffness).
    assert np.abs(log.true_position - exact).max() < 0.8 / np.sqrt(0.5 * stiffness)


# Encoder and noise -----------------------------------------------------------------------------------------

FREE = cogging.AxisParameters()


@pytest.mark.parametrize("resolution", [0.5e-6, 1e-3])
def test_the_reading_is_the_nearest_count(resolution):
    encoders = (cogging.EncoderParameters(resolution=r) for r in (0.0, resolution))
    ideal, real = (free(cogging.Plant(FREE, encoder=encoder), 2.0, v0=0.1234567) for encoder in encoders)
    np.testing.assert_array_equal(ideal.position, ideal.true_position)
    counts = real.true_position / resolution
    clear = np.abs(counts - np.floor(counts) - 0.5) > 1e-9  # no tie
    assert clear.mean() > 0.99
    np.testing.assert_array_equal(real.position[clear], resolution * np.floor(counts + 0.5)[clear])


def test_errors_of_the_encoder_come_before_noise_and_rounding():
    errors = [example("encoder_periodic_error"), example("encoder_scale_error")]
    encoder = cogging.EncoderParameters(resolution=1e-6, noise=2e-6)
    plants = (cogging.Plant(FREE, effects=effects, encoder=encoder) for effects in ([], errors))
    plain, wrong = (free(plant, 2.0, v0=0.1, seed=4) for plant in plants)
    x = wrong.true_position
    np.testing.assert_array_equal(x, plain.true_position)
    counts = wrong.position / 1e-6
    np.testing.assert_allclose(counts, np.round(counts), rtol=0, atol=1e-8)
    error = wave(x, 0.004, 3e-5, -2e-5) + 0.004 * x
    # The same noise in both: the readings differ by the error, each rounded.
    assert np.abs(wrong.position - plain.position - error).max() <= 1e-6 * (1 + 1e-6)


def encoder_noise(resolution, seed, samples=30_000):
    encoder = cogging.EncoderParameters(resolution=resolution, noise=3e-6)
    log = free(cogging.Plant(FREE, encoder=encoder), samples / 1000.0, seed=seed)
    return log.position - log.true_position


def assert_white_and_normal(noise):
    n = len(noise)
    correlation = [np.mean(noise[k:] * noise[:-k]) / np.mean(noise**2) for k in range(1, 20)]
    assert np.abs(correlation).max() < 4 / np.sqrt(n)
    assert stats.kstest(noise / noise.std(), "norm").pvalue > 1e-3


def test_encoder_noise_is_white_and_normal_and_comes_before_the_rounding():
    noise = encoder_noise(0.0, seed=11)
    n = len(noise)
    assert noise.mean() == pytest.approx(0.0, abs=4 * 3e-6 / np.sqrt(n))
    assert noise.std() == pytest.approx(3e-6, rel=4 / np.sqrt(2 * n))
    assert_white_and_normal(noise)
    counts = encoder_noise(1e-6, seed=12) / 1e-6  # the true position is 0
    assert np.abs(counts - np.round(counts)).max() < 1e-9
    # Sheppard: rounding adds a twelfth of a count squared.
    assert counts.std() == pytest.approx(np.sqrt(9 + 1 / 12), rel=4 / np.sqrt(2 * n))


def noise_forces(rms, bandwidth, rate, seed, samples=30_000):
    """Return what pushes a free mass, from the steps of its velocity: the force is held over each sample."""
    noise = cogging.NoiseParameters(force=rms, bandwidth=bandwidth)
    log = free(cogging.Plant(cogging.AxisParameters(mass=0.5), noise=noise), samples / rate, rate, seed=seed)
    return np.diff(log.true_velocity) * rate * 0.5


@pytest.mark.parametrize(("bandwidth", "rate"), [(50.0, 5000.0), (400.0, 2000.0)])
def test_force_noise_is_a_first_order_process_of_its_rms(bandwidth, rate):
    rms = 0.03
    force = noise_forces(rms, bandwidth, rate, seed=13)
    n, decay = len(force), np.exp(-TWO_PI * bandwidth / rate)
    # The variance of a squared first-order process decays as decay^2.
    squares = n * (1 - decay**2) / (1 + decay**2)
    assert np.mean(force**2) == pytest.approx(rms**2, rel=4 * np.sqrt(2 / squares))
    # Its innovations are white, normal, and of rms sqrt(1 - decay^2): this fixes the whole process.
    innovation = (force[1:] - decay * force[:-1]) / (rms * np.sqrt(1 - decay**2))
    assert innovation.std() == pytest.approx(1.0, rel=4 / np.sqrt(2 * n))
    assert np.abs(np.mean(innovation * force[:-1])) / rms < 4 / np.sqrt(n)
    assert_white_and_normal(innovation)


def test_the_noise_starts_stationary_and_differs_by_seed():
    """The first force of a run is as large as any: rms over seeds, not a start from zero."""
    first = np.array([noise_forces(0.03, 5.0, 1000.0, seed, samples=3)[0] for seed in range(200)])
    assert first.std() == pytest.approx(0.03, rel=4 / np.sqrt(2 * 200))
    assert len(set(first)) == 200
