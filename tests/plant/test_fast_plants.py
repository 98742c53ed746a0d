"""Plants that are fast beside their sample time: as many steps as they need, or an error.

The reference is a second plant (fixtures/random_plants.py), written from the formulas and integrated by scipy at tight
tolerances. Both are driven by given commands, so that no feedback reduces an error.
"""

from collections import Counter

import numpy as np
import pytest

import cogging
from tests.fixtures.random_plants import Driven, ScipyPlant, draw

TWO_PI = 2 * np.pi
SHARE = 1e-6  # of the motion: what may be wrong
STIFFEST = 1e5  # of friction's rate times the sample time: below it no plant is refused


def error_of(driven, **options):
    """The largest error of the position, as a share of the motion."""
    simulated = driven.simulated(**options)
    expected = driven.expected()
    wrong = np.abs(simulated - expected)[:, 0].max()
    return wrong / np.ptp(expected[:, 0]) if wrong > 0.0 else 0.0  # some stick for all of the run


def check(seeds, fastest):
    """Errors of the machines that run, by seed; a refused one must be stiff, and its error names the rate."""
    errors, refused, unsolved = {}, 0, 0
    for seed in seeds:
        driven = draw(seed, fastest)
        try:
            errors[seed] = error_of(driven)
        except (ValueError, cogging.DivergedError) as error:
            text = str(error)
            if text == "f(a) and f(b) must have different signs":  # scipy's search for a stop
                unsolved += 1
                continue
            refused += 1
            assert text.startswith(("axis: must change slowly enough", "stiffness, frequency: must need at most")), text
            assert driven.stiffness > STIFFEST, (seed, text)
    assert unsolved <= len(seeds) // 100
    return errors, refused, {seed: error for seed, error in errors.items() if not error <= SHARE}


#: Machines among which every effect that acts on the motion is in two at least.
COVERING = (0, 8, 14, 31, 46, 58, 68, 75, 82, 90, 99, 100, 115, 117)


def test_random_plants_are_those_of_scipy():
    drawn = Counter(name for seed in COVERING for name, _ in draw(seed, 100.0).plant.effects)
    assert set(drawn) | {"encoder_periodic_error", "encoder_scale_error"} == set(cogging.EFFECTS)
    assert min(drawn.values()) >= 2
    errors, refused, wrong = check(COVERING, fastest=100.0)
    assert not wrong
    assert refused == 0
    assert set(errors) == set(COVERING)


def test_motors_that_stick_while_their_loads_ring_are_those_of_scipy():
    """The pull of the load is in the balance of the resting motor; it tears it loose again, some times in each run."""
    seeds = (19, 79, 113)
    for seed in seeds:
        rests = draw(seed, 20.0).simulated()[:, 1] == 0.0
        assert np.count_nonzero(rests[1:] != rests[:-1]) >= 3
    errors, _, wrong = check(seeds, fastest=20.0)
    assert not wrong
    assert set(errors) == set(seeds)


@pytest.mark.study
def test_five_hundred_plants_up_to_stiff_are_those_of_scipy_or_refused():
    """pytest tests/plant/test_fast_plants.py -m study -s (20 minutes); prints what docs/evidence.md shows."""
    errors, refused, wrong = check(range(1000, 1500), fastest=3000.0)
    values = np.array(list(errors.values()))
    shown = ", ".join(f"{q:.0%} {np.quantile(values, q):.1e}" for q in (0.5, 0.9, 0.99, 1.0))
    print(f"\n{len(errors)} plants, error over motion: {shown}; {refused} refused, {len(wrong)} above {SHARE}")
    assert not wrong
    assert refused < 25


@pytest.mark.parametrize("multiple", [0.999, 7.0])
def test_a_tone_at_any_multiple_of_the_sample_rate(multiple):
    rate, mass, viscous = 1000.0, 0.2, 4.0
    f = multiple * rate
    tone = {"frequency": f, "sine": 0.7, "cosine": 0.9}
    driven = Driven(rate, np.zeros(200), 0.0, 0.0, ScipyPlant(mass, viscous, effects=[("disturbance_tone", tone)]))
    t, w, decay = driven.time, TWO_PI * f, viscous / mass
    # v' = -decay v + Re((cosine - i sine) exp(i w t)) / mass, from rest, in closed form.
    gain = (tone["cosine"] - 1j * tone["sine"]) / mass / (1j * w + decay)
    x = (gain * ((np.exp(1j * w * t) - 1) / (1j * w) + (np.exp(-decay * t) - 1) / decay)).real
    assert np.abs(driven.simulated()[:, 0] - x).max() < SHARE * np.ptp(x)


@pytest.mark.parametrize("coulomb", [0.0, 0.3])
@pytest.mark.parametrize("stiff", [2.9, 3e4])
def test_viscous_friction_however_fast(stiff, coulomb):
    rate, viscous = 1000.0, 2.0
    commands = 1.5 * np.sign(np.sin(np.arange(60) / 6.5))
    driven = Driven(rate, commands, 0.0, 0.0, ScipyPlant(viscous / rate / stiff, viscous, coulomb))
    assert error_of(driven) < SHARE
    assert np.abs(driven.simulated()[-1, 1]) == pytest.approx((1.5 - coulomb) / viscous, rel=1e-6)


def test_what_cannot_be_followed_is_refused_with_its_rate():
    driven = Driven(1000.0, np.ones(5), 0.0, 0.0, ScipyPlant(1e-12, 1.0))
    text = r"^axis: must change slowly enough to be integrated in 1e5 steps .* 1/s at 0 s$"
    with pytest.raises(cogging.DivergedError, match=text):
        driven.simulated()


@pytest.mark.parametrize("coulomb_width", [0.0, 1e-3])
def test_a_run_that_diverges_is_no_rest(coulomb_width):
    """An unstable loop, with sticking too, ends as diverged: it never comes to rest at a number that is none."""
    axis = cogging.AxisParameters(mass=0.1, viscous=0.2, coulomb=0.1, coulomb_width=coulomb_width, travel=[-1.0, 1.0])
    lag = cogging.effects.ActuatorLag(time_constant=2e-3)
    controller = cogging.Pid(cogging.PidParameters(sample_rate=1000.0, kp=1e6, kd=1e3))
    reference = cogging.Sine(cogging.SineParameters(amplitude=0.1, frequency=2.0))
    with pytest.raises(cogging.DivergedError, match=r"^the run diverged at 0\.\d+ s"):
        cogging.closed_loop(cogging.Plant(axis, effects=[lag]), controller, reference, duration=1.0)
