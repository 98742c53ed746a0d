"""The linear loop beside what the simulator does with a small sine, python-control's own margins, and the tuning's."""

import numpy as np
import pytest

import cogging
from cogging import effects
from cogging.design.linear_plant import modulus_margin

KINDS = ("pid", "cascade", "speed", "arc", "dcarc")


def machine(rng, kind, rigid=False):
    """A machine under a linear controller: delays of any length, current loop, spring, resonance, smooth friction."""
    mass, rate = float(10 ** rng.uniform(-2, 1)), float(rng.choice([1000.0, 2000.0, 5000.0]))
    bandwidth = float(rng.uniform(0.02, 0.07) * rate)
    fields = {
        "pid": {"kp": mass * bandwidth**2, "kd": 1.8 * mass * bandwidth, "ki": 0.1 * mass * bandwidth**3},
        "cascade": {"kp": 0.4 * bandwidth, "kv": 1.6 * mass * bandwidth},
        "speed": {"kp": mass * bandwidth, "delay": float(rng.uniform(0.0, 2.5) / rate)},
        "arc": {"error_gain": 0.5 * bandwidth, "feedback_gain": 1.6 * mass * bandwidth},
    }
    fields["dcarc"] = fields["arc"]
    document = {
        "axis": {"mass": mass, "viscous": float(rng.uniform(0.1, 3.0) * mass)},
        "controller": {"type": kind, "sample_rate": rate, **fields[kind]},
    }
    if kind in ("pid", "cascade", "speed") and rng.random() < 0.5:
        document["controller"] |= {"feedforward_velocity": "measured", "viscous": 0.5 * mass}
    added = [effects.CommandDelay(delay=float(rng.uniform(0.0, 1.7) / rate))] if rng.random() < 0.7 else []
    if rng.random() < 0.5:
        added.append(effects.ActuatorLag(time_constant=float(rng.uniform(0.3, 1.0) / rate)))
    if not rigid:
        document["axis"] |= {"coulomb": float(rng.uniform(0.0, 0.4) * mass), "coulomb_width": 0.02}
        if kind != "speed":  # which lets it go slowly
            added.append(effects.CableSpring(stiffness=float(rng.uniform(-1.0, 1.0) * mass * 20.0)))
        added.append(effects.StribeckFriction(static_excess=0.1 * mass, velocity=0.05))
        share, place = float(rng.uniform(0.05, 0.2)), float(rng.uniform(0.03, 0.15) * rate)
        added.append(effects.FlexibleMode(frequency=place, damping_ratio=0.1, mass_ratio=share))
        added.append(effects.EncoderScaleError(scale=float(rng.uniform(-0.1, 0.1))))
    return cogging.Model.from_dict(document).replace(effects=added)


def stable(rng, kind, rigid=False, **about):
    """One whose loop is stable with some room, and that loop."""
    for _ in range(40):
        model = machine(rng, kind, rigid)
        loop = model.to_control(**about)
        margins = loop.margins()
        if margins.stable and margins.modulus > 0.25:
            return model, loop
    raise AssertionError("no stable machine in forty")


def response_at(model, multiple, speed=0.0, window=800, before=5000):
    """Reading over command, and command over error, at multiple/window of the sample rate.

    Two runs at constant speed that differ in a small sine that is added to the command: what was there cancels.
    """
    rate, rows = model.controller.sample_rate, window + before
    time = np.linspace(0.0, (rows + 1) / rate, 5)
    motion = {"type": "sampled", "time": time.tolist(), "reference": (speed * time).tolist()}
    motion |= {"reference_velocity": [speed] * 5, "reference_acceleration": [0.0] * 5}
    sine = 1e-6 * model.axis.mass * rate * np.sin(2 * np.pi * multiple * np.arange(rows + 2) / window)
    last = slice(before, before + window)
    turn = np.exp(-2j * np.pi * multiple * np.arange(window) / window)
    quiet, stirred = (
        cogging.simulate(model, motion, duration=rows / rate, initial_velocity=speed, added_command=added)
        for added in (None, sine)
    )
    y, u = ((getattr(stirred, name) - getattr(quiet, name))[last] @ turn for name in ("position", "command"))
    return y / u, -(u - sine[last] @ turn) / y


def linear_at(loop, multiple, window=800):
    z = np.exp(2j * np.pi * multiple / window)
    return loop.plant(z), loop.controller(z)


@pytest.mark.parametrize("kind", KINDS)
def test_the_simulator_answers_a_small_sine_as_the_linear_loop_does(kind):
    model, loop = stable(np.random.default_rng([1, len(kind)]), kind, speed=0.0)
    assert loop.left_out == ()
    for multiple in (12, 300):
        np.testing.assert_allclose(response_at(model, multiple), linear_at(loop, multiple), rtol=1e-5)


def test_friction_is_linearised_at_the_speed():
    """Falling friction and drag change the damping by more than the bounds: a wrong speed would show."""
    model, _ = stable(np.random.default_rng(0), "pid", rigid=True)
    mass, speed = model.axis.mass, 0.04
    pid = model.controller.replace(feedforward_velocity="measured", viscous=0.2 * mass, coulomb=0.3 * mass)
    model = model.replace(
        axis=model.axis.replace(coulomb=0.5 * mass, coulomb_width=0.01),
        controller=pid.replace(coulomb_width=0.01),
        effects=[
            effects.StribeckFriction(static_excess=0.5 * mass, velocity=0.05),
            effects.QuadraticDrag(coefficient=40.0 * mass),
            effects.ViscousAsymmetry(difference=3.0 * mass),
        ],
    )
    linear, other = (linear_at(model.to_control(speed=one), 4) for one in (speed, 0.0))
    np.testing.assert_allclose(response_at(model, 4, speed=speed), linear, rtol=2e-4)
    assert max(abs(one / right - 1) for one, right in zip(other, linear, strict=True)) > 0.03


def test_cogging_is_a_spring_at_the_place():
    model, _ = stable(np.random.default_rng(4), "pid", rigid=True)
    basis = cogging.SplineHarmonics(pitch=0.04, harmonics=[1, 3])
    size = 0.3 * model.axis.mass
    cog = cogging.CoggingModel(basis, [[size], [0.2 * size]], [[0.0], [0.0]])
    model = model.replace(cogging=cog, axis=model.axis.replace(coulomb=0.0))
    ripple = effects.ForceConstantRipple(period=0.03, cosine=0.1)
    wrong = effects.EncoderPeriodicError(period=0.02, sine=2e-4)
    model = model.replace(effects=[*model.effects, ripple, wrong])
    measured, linear = response_at(model, 4), linear_at(model.to_control(position=0.0), 4)
    assert abs(measured[0] / linear[0] - 1) < 2e-4
    without = model.to_control()
    assert without.left_out == ("cogging (no position given)", "force_constant_ripple", "encoder_periodic_error")
    assert abs(linear_at(without, 4)[0] / linear[0] - 1) > 0.05


@pytest.mark.parametrize("kind", ["speed", "dcarc"])
def test_sensitivities_and_margins_are_those_of_the_frequency_response(kind):
    model, loop = stable(np.random.default_rng([7, len(kind)]), kind, rigid=True)
    margins, period = loop.margins(), loop.plant.dt
    assert period == loop.loop.dt == 1 / model.controller.sample_rate
    z = np.exp(2j * np.pi * np.array([0.001, 0.01, 0.1, 0.4]))
    total = loop.plant(z) * loop.controller(z)
    np.testing.assert_allclose(loop.loop(z), total, rtol=1e-6)
    np.testing.assert_allclose(loop.response(np.angle(z) / (2 * np.pi * period)), total, rtol=1e-6)
    np.testing.assert_allclose(loop.sensitivity(z), 1 / (1 + total), rtol=1e-6)
    np.testing.assert_allclose(loop.complementary(z), total / (1 + total), rtol=1e-6)
    total = loop.loop(np.exp(2j * np.pi * np.geomspace(1e-4, 0.5, 20_000)))
    assert margins.modulus == pytest.approx(np.abs(1 + total).min(), rel=2e-3)
    assert margins.modulus == pytest.approx(modulus_margin(model), rel=2e-3)
    (crossing,) = loop.loop(np.exp(2j * np.pi * np.array([margins.crossover * period])))
    assert abs(crossing) == pytest.approx(1.0, rel=2e-3)
    assert margins.phase == pytest.approx(180.0 + np.degrees(np.angle(crossing)), rel=5e-3)


def test_in_continuous_time_the_delay_is_approximated():
    model, loop = stable(np.random.default_rng([3, 0]), "pid", speed=0.0)
    delay = sum(one.delay for one in model.effects if isinstance(one, effects.CommandDelay))
    time = loop.plant.dt
    for turns in (0.002, 0.02):  # of the sample rate
        w = 2 * np.pi * turns / time
        held = loop.plant(np.exp(1j * w * time))
        # A held command acts half a sample later in the mean, and a little less.
        expected = loop.continuous(1j * w) * np.exp(-0.5j * w * time) * np.sinc(turns)
        assert abs(held / expected - 1) < 10 * turns**2
        bare = model.to_control(speed=0.0, pade=0).continuous(1j * w)
        assert abs(loop.continuous(1j * w) / (bare * np.exp(-1j * w * delay)) - 1) < 1e-4


def test_a_model_without_a_controller_is_a_plant_alone():
    loop = cogging.Model(cogging.AxisParameters(mass=0.5, viscous=0.1)).to_control(sample_rate=1000.0)
    assert loop.controller is loop.loop is loop.sensitivity is loop.complementary is None
    np.testing.assert_allclose(sorted(np.abs(loop.plant.poles())), [np.exp(-0.2e-3), 1.0], rtol=1e-12)
    with pytest.raises(ValueError, match="controller: must be given for margins"):
        loop.margins()


@pytest.mark.parametrize(
    ("change", "arguments", "rule"),
    [
        ({"controller": None, "controller_type": None}, {}, "sample_rate: must be given for a model without"),
        ({}, {"speed": 0.0}, "speed: must be other than 0 where coulomb_width is 0"),
        ({"effects": [effects.CommandDelay(delay=2.0)]}, {}, "command_delay: must be at most 1000 samples, got 2000"),
        (
            {"controller": cogging.ObserverBasedParameters(), "controller_type": "observer_based"},
            {},
            "controller: must be linear in the error, got observer_based: its observer turns with the motion",
        ),
    ],
)
def test_what_cannot_be_linearised(change, arguments, rule):
    pid = cogging.PidParameters(sample_rate=1000.0, kp=100.0)
    model = cogging.Model(cogging.AxisParameters(mass=0.1, coulomb=0.1), controller=pid, controller_type="pid")
    with pytest.raises(ValueError, match=rule):
        model.replace(**change).to_control(**arguments)
