"""A closed loop in a C++ program without Python gives the bits of the same loop in Python."""

import numpy as np
import pytest

import cogging
from cogging.model.model import CONTROLLERS

PITCH, POINTS, TRAVEL = 0.05, 13, [0.0, 0.51]


def draw_effects(rng):
    """Some of the effects, in all rooms of the plant, of a size that is seen and leaves the loop stable."""
    effects = cogging.effects
    drawn = [
        effects.CableSpring(stiffness=rng.uniform(0, 2), center=0.2),
        effects.CoggingHarmonic(period=0.013, sine=rng.uniform(0, 0.05)),
        effects.StribeckFriction(static_excess=rng.uniform(0, 0.1), velocity=0.01),
        effects.CoulombAsymmetry(difference=rng.uniform(0, 0.05)),
        effects.ForceConstantRipple(period=0.03, sine=rng.uniform(0, 0.05)),
        effects.CommandDelay(delay=rng.uniform(0, 3e-4)),
        effects.ActuatorLag(time_constant=rng.uniform(1e-4, 5e-4)),
        effects.CommandSaturation(limit=rng.uniform(1, 3)),
        effects.EncoderPeriodicError(period=1e-3, sine=rng.uniform(0, 1e-6)),
        effects.DisturbanceStep(force=0.2, start=rng.uniform(0, 0.1), stop=0.2),
        effects.PositionDependentFriction(nodes=[0.1, 0.3], levels=[0.0, rng.uniform(0, 0.1)]),
    ]
    states = [
        effects.PreslidingFriction(stiffness=1e4, damping=5.0),
        effects.FlexibleMode(frequency=rng.uniform(60, 120), damping_ratio=0.02, mass_ratio=0.1),
        effects.Backlash(gap=1e-5, mass_ratio=0.1),
    ]
    chosen = [effect for effect in drawn if rng.random() < 0.4]
    return chosen + ([states[rng.integers(len(states))]] if rng.random() < 0.3 else [])


def draw_controller(name, rng):
    parameters, _ = CONTROLLERS[name]
    loop = {"sample_rate": 5000.0, "mass": 0.15, "viscous": 0.2, "coulomb": 0.1, "coulomb_width": 1e-3}
    loop |= {"feedforward_velocity": str(rng.choice(["reference", "measured"])), "command_limit": 4.0}
    fields = {
        "pid": loop | {"kp": rng.uniform(5e3, 1e4), "ki": 1e5, "kd": 48.0},
        "cascade": loop | {"kp": rng.uniform(50, 100), "kv": 40.0},
        "speed": loop | {"kp": rng.uniform(20, 40), "delay": rng.uniform(0, 6e-4)},
        "arc": {
            "mass_adaptation": 1.0,
            "coulomb_adaptation": rng.uniform(1, 20),
            "cogging_harmonics": [1, 2, 3],
            "cogging_control_points": POINTS,
            "cogging_adaptation": rng.uniform(10, 200),
            "epsilon": 0.1,
        },
        "output_feedback_arc": {"sample_rate": 2500.0, "coulomb": 0.1, "coulomb_width": 1e-3, "command_limit": 4.0},
        "observer_based": {"periods": [0.05, 0.025], "observer_gain": [300.0, 3e4, 1e6, *rng.uniform(-1e5, 1e5, 4)]},
    }
    fields["dcarc"] = fields["arc"]
    return parameters(**fields[name])


def draw_run(name, seed):
    """Plant, controller's parameters and motion of one run."""
    rng = np.random.default_rng([seed, *name.encode()])
    cogging_model = cogging.CoggingModel(
        cogging.SplineHarmonics(pitch=PITCH, harmonics=[1, 2, 3], control_points=POINTS),
        sine=rng.uniform(-0.05, 0.05, (3, POINTS)),
        cosine=rng.uniform(-0.05, 0.05, (3, POINTS)),
    )
    plant = cogging.Plant(
        cogging.AxisParameters(
            mass=rng.uniform(0.1, 0.2),
            viscous=rng.uniform(0.1, 0.3),
            coulomb=rng.uniform(0.1, 0.2),
            coulomb_width=float(rng.choice([0.0, 2e-3])),
            travel=TRAVEL,
        ),
        cogging=cogging_model,
        effects=draw_effects(rng),
        encoder=cogging.EncoderParameters(resolution=0.5e-6, noise=1e-7),
        noise=cogging.NoiseParameters(force=0.01),
    )
    motion = cogging.PointToPointParameters(
        start=0.1, distance=rng.uniform(0.02, 0.05), velocity=0.3, acceleration=10.0, jerk=rng.uniform(500, 2000)
    )
    return plant, draw_controller(name, rng), motion


def words(value):
    if isinstance(value, bool | int):
        return str(int(value))
    if isinstance(value, float):
        return value.hex()
    return value if isinstance(value, str) else " ".join(words(one) for one in value)


def lines(item, parameters):
    return [f"{item} {name} {words(value)}" for name, value in parameters.to_dict().items()]


def text_of(name, seed):
    """A run as runs.cpp reads it, and how far its commands reach (V)."""
    plant, parameters, motion = draw_run(name, seed)
    log = cogging.closed_loop(plant, CONTROLLERS[name][1](parameters), cogging.PointToPoint(motion), seed=seed)
    coefficients = np.stack([plant.cogging.sine, plant.cogging.cosine], axis=-1).transpose(1, 0, 2).ravel().tolist()
    text = [f"run {name}", f"seed {seed}", f"cogging {PITCH.hex()} {POINTS} {words(coefficients)}"]
    for item, struct in [("axis", plant.axis), ("encoder", plant.encoder), ("noise", plant.noise)]:
        text += lines(item, struct)
    for effect in plant.effects:
        text += [f"effect {effect.NAME}", *lines("effect_field", effect)]
    text += lines("reference", motion) + lines("controller", parameters)
    text += [f"{column} {words(getattr(log, column).tolist())}" for column in ("position", "command")]
    return [*text, "end"], np.ptp(log.command)


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_a_loop_without_python_gives_the_same_bits(cmake, programs, tmp_path, controller):
    text = []
    for seed in range(4):
        run, reach = text_of(controller, seed)
        assert reach > 0.1  # V: the axis moves
        text += run
    (tmp_path / "runs.txt").write_text("\n".join(text) + "\n")
    said = cmake.run(cmake.program(programs, "runs"), tmp_path / "runs.txt")
    assert int(said.split()[0]) > 100
