"""The rule of every number of every parameter struct, and the rules that bind several fields."""

import math

import numpy as np
import pytest

import cogging
from cogging import _core
from cogging.papers.xu2001 import epoxy_motor as xu2001_setup

NAN, INF = math.nan, math.inf
STRUCTS = {kind.__name__: kind for kind in vars(_core).values() if hasattr(kind, "FIELDS")}
STRUCTS |= {kind.__name__: kind for kind in cogging.EFFECTS.values()}
NUMBERS = {
    f"{name}.{field}"
    for name, kind in STRUCTS.items()
    for field, value in kind().to_dict().items()
    if isinstance(value, float)
}
POSITIVE = "must be finite and above 0", (0.0, -1.0, NAN, INF)
NOT_NEGATIVE = "must be finite and at least 0", (-1.0, NAN, INF)
FINITE = "must be a finite number", (NAN, INF, -INF)
#: The fields of each struct that must be above 0, and at least 0; one that stands nowhere need only be finite.
PLAIN = {
    "PointToPointParameters": ("velocity acceleration", "dwell"),
    "SineParameters": ("frequency", "amplitude"),
    "FilteredSineParameters": ("frequency beta_1 beta_2", "amplitude"),
    "AxisParameters": ("mass", "viscous coulomb coulomb_width"),
    "NoiseParameters": ("bandwidth", "force"),
    "PidParameters": ("sample_rate", "kp ki kd mass viscous coulomb coulomb_width command_limit"),
    "CascadeParameters": ("sample_rate", "kp kv mass viscous coulomb coulomb_width command_limit"),
    "SpeedParameters": ("sample_rate", "kp delay mass viscous coulomb coulomb_width command_limit"),
    "AdaptiveRobustParameters": (
        "sample_rate error_gain feedback_gain cogging_pitch",
        "mass_adaptation viscous_adaptation coulomb_adaptation coulomb_width disturbance_adaptation "
        "cogging_adaptation epsilon disturbance_bound command_limit",
    ),
    "ObserverBasedParameters": ("sample_rate position_gain mass", "viscous velocity_min command_limit"),
    "OutputFeedbackArcParameters": (
        "sample_rate weight_1 weight_2 gain_1 gain_2 epsilon_11 epsilon_12 epsilon_21 epsilon_22",
        "robust_factor coulomb coulomb_width command_limit",
    ),
    "EndEffect": ("decay_length", ""),
    "LocalForce": ("width", ""),
    "CoggingHarmonic": ("period", ""),
    "CoggingModulation": ("period", "pitch"),
    "StribeckFriction": ("velocity exponent", ""),
    "ForceConstantRipple": ("period", ""),
    "ForceConstantDrift": ("time_constant", ""),
    "EncoderPeriodicError": ("period", ""),
    "Backlash": ("contact_frequency", "gap contact_damping_ratio"),
    "DisturbanceTone": ("frequency", ""),
    "EncoderParameters": ("", "resolution noise"),
    "PreslidingFriction": ("", "damping"),
    "CommandDelay": ("", "delay"),
    "ActuatorLag": ("", "time_constant"),
    "CommandDeadZone": ("", "width"),
    "FlexibleMode": ("", "damping_ratio"),
}
#: What further rules say, what they refuse, and of which numbers.
FURTHER = [
    ("must be finite and not 0", (0.0, NAN, INF), "PointToPointParameters.distance"),
    ("must be above 0 (infinite = none)", (0.0, -1.0, NAN), "PointToPointParameters.jerk"),
    ("must be above 0 (infinite = none)", (0.0, -1.0, NAN), "CommandSaturation.limit"),
    ("must be above 0 (infinite = none)", (0.0, -1.0, NAN), "PreslidingFriction.stiffness"),
    ("must be above 0 (infinite = rigid)", (0.0, -1.0, NAN), "FlexibleMode.frequency"),
    ("must be at least 0 and below 1", (-1.0, 1.0, NAN), "Backlash.mass_ratio"),
    ("must be at least 0 and below 1", (-1.0, 1.0, NAN), "FlexibleMode.mass_ratio"),
    ("must be above start = 0", (0.0, -1.0, NAN), "DisturbanceStep.stop"),
    ("must be 0 to 61 samples", (-1.0, 1.0, NAN), "ObserverBasedParameters.delay"),
    ("must be above 0, or A_0 is not stable", (0.0, -1.0, NAN), "OutputFeedbackArcParameters.observer_gain_1"),
    ("must be above 0, or A_0 is not stable", (0.0, -1.0, NAN), "OutputFeedbackArcParameters.observer_gain_2"),
    ("must lie within mass_bounds [0.1, 0.2]", (0.0, 0.3, NAN), "AdaptiveRobustParameters.mass"),
    ("must lie within viscous_bounds [0, 1]", (-1.0, 2.0, NAN), "AdaptiveRobustParameters.viscous"),
    ("must lie within coulomb_bounds [0, 1]", (-1.0, 2.0, NAN), "AdaptiveRobustParameters.coulomb"),
    ("must lie within disturbance_bounds [-1, 1]", (-2.0, 2.0, NAN), "AdaptiveRobustParameters.disturbance"),
]
RULE_OF = {f"{name}.{field}": POSITIVE for name, fields in PLAIN.items() for field in fields[0].split()}
RULE_OF |= {f"{name}.{field}": NOT_NEGATIVE for name, fields in PLAIN.items() for field in fields[1].split()}
RULE_OF |= {path: (rule, refused) for rule, refused, path in FURTHER}


def message_of(kind, *arguments, **fields):
    with pytest.raises(ValueError) as caught:  # noqa: PT011 the message is compared whole
        kind(*arguments, **fields)
    return str(caught.value)


assert set(RULE_OF) <= NUMBERS


@pytest.mark.parametrize("path", sorted(NUMBERS))
def test_the_rule_of_a_number(path):
    name, field = path.split(".")
    rule, refused = RULE_OF.get(path, FINITE)
    for value in refused:
        assert message_of(STRUCTS[name], **{field: value}) == f"{field}: {rule}, got {value:g}"
    if rule.startswith("must be finite and at least 0"):
        STRUCTS[name](**{field: 0.0})


ADAPTIVE, OBSERVER, OUTPUT = (f"{name}Parameters" for name in ("AdaptiveRobust", "ObserverBased", "OutputFeedbackArc"))
ORDERED = "needs minimum <= maximum, both finite"
ONE_HARMONIC = {"cogging_harmonics": [1]}
#: Struct, fields, and the field, rule and value of the message.
BETWEEN = [
    ("AxisParameters", {"travel": [0.5, 0.0]}, "travel: needs lower end < upper end, got [0.5, 0]"),
    ("EndEffect", {"travel": [0.5, NAN]}, "travel: needs lower end < upper end, got [0.5, nan]"),
    ("PointToPointParameters", {"repeats": 0}, "repeats: must be at least 1, got 0"),
    ("DisturbanceStep", {"start": 1.0, "stop": 1.0}, "stop: must be above start = 1, got 1"),
    ("CoggingModulation", {"sine": [INF], "cosine": [0.0]}, "sine: must be a finite number, got inf"),
    ("CoggingModulation", {"sine": [1, 2], "cosine": [1]}, "cosine: must have as many values as sine = 2, got 1"),
    ("CoggingModulation", {"order": 0}, "order: must be from 1 to 16, got 0"),
    (
        "CoggingModulation",
        {"pitch": 0.1, "sine": [1, 2], "cosine": [1, 2]},
        "sine: more than one value must be at least the order = 3, got 2",
    ),
    ("PositionDependentFriction", {"nodes": [0.0], "levels": [INF]}, "levels: must be a finite number, got inf"),
    ("PositionDependentFriction", {"nodes": [0.1] * 2, "levels": [0] * 2}, "nodes: must increase: above 0.1, got 0.1"),
    ("PositionDependentFriction", {"nodes": [0, 1]}, "levels: must have as many values as nodes = 2, got 0"),
    ("EmpiricalForce", {"time_nodes": [NAN], "time_forces": [0]}, "time_nodes: must be a finite number, got nan"),
    (
        "EmpiricalForce",
        {"velocity_nodes": [0.1]},
        "velocity_forces: must have as many values as velocity_nodes = 1, got 0",
    ),
    *(
        (
            f"{kind}Parameters",
            {"feedforward_velocity": "desired"},
            'feedforward_velocity: must be "reference" or "measured", got desired',
        )
        for kind in ("Pid", "Cascade", "Speed")
    ),
    ("SpeedParameters", {"delay": 1e4}, "delay: must be below a million samples, got 10000"),
    *(
        (
            ADAPTIVE,
            {f"{name}_bounds": [0.0, end]},
            f"{name}_bounds: needs minimum <= maximum, both finite, got [0, {end:g}]",
        )
        for name in ("mass", "viscous", "coulomb", "disturbance", "cogging")
        for end in (-1.0, INF)
    ),
    (ADAPTIVE, {"mass_bounds": [0.0, 0.2]}, "mass_bounds: must be finite and above 0, got 0"),
    (ADAPTIVE, {"cogging_harmonics": [1, 0]}, "cogging_harmonics: each must be at least 1, got 0"),
    (
        ADAPTIVE,
        ONE_HARMONIC | {"cogging_control_points": 2},
        "cogging_control_points: must be 1 or at least the order 3, got 2",
    ),
    (
        ADAPTIVE,
        ONE_HARMONIC | {"cogging_estimates": [0.1]},
        "cogging_estimates: must hold control points times twice the harmonics = 2 values, got 1",
    ),
    (
        ADAPTIVE,
        ONE_HARMONIC | {"cogging_estimates": [0.0, 0.2]},
        "cogging_estimates: must lie within cogging_bounds, got 0.2",
    ),
    (OBSERVER, {"periods": []}, "periods: must list 1 to 16, got 0"),
    (OBSERVER, {"periods": [-0.01]}, "periods: must be finite and above 0, got -0.01"),
    (OBSERVER, {"observer_gain": [1, 2]}, "observer_gain: must hold 3 + 2 periods = 5 values, got 2"),
    (
        OBSERVER,
        {"observer_gain_slope": [1]},
        "observer_gain_slope: must be empty or hold 3 + 2 periods = 5 values, got 1",
    ),
    (OBSERVER, {"rotation": "guessed"}, 'rotation: must be "reference" or "measured", got guessed'),
    (OUTPUT, {"theta_min": [0, 2, -50]}, "theta_min: must be finite and above 0, got 0"),
    (
        OUTPUT,
        {"theta_min": [60, 2.4, -50]},
        "theta_min, theta_max: needs minimum <= maximum, both finite, got [60, 50]",
    ),
    (OUTPUT, {"theta": [100, 10, 0]}, "theta: must lie within theta_min and theta_max, got 100"),
    (OUTPUT, {"adaptation": [-1, 0, 0]}, "adaptation: must be finite and at least 0, got -1"),
    (OUTPUT, {"filter_steps": "tustin"}, 'filter_steps: must be "exact" or "euler", got tustin'),
]


@pytest.mark.parametrize(("name", "fields", "message"), BETWEEN)
def test_the_rules_of_lists_words_and_several_fields(name, fields, message):
    # The rules of the cogging basis may name its field with or without the prefix that it has in a controller.
    assert message_of(STRUCTS[name], **fields).removeprefix("cogging_") == message.removeprefix("cogging_")


def test_euler_steps_are_stable_up_to_twice_the_filter_s_time_constant():
    """Both filter poles at -200: up to a step of 0.01 s."""
    xu2001_setup.arc_parameters(sample_rate=100.5, filter_steps="euler")
    with pytest.raises(ValueError, match=r"^sample_rate: is too low for Euler steps of the observer's"):
        xu2001_setup.arc_parameters(sample_rate=99.5, filter_steps="euler")


SPLINE = {"order": 3, "origin": 0.0, "pitch": 0.05, "control_points": 5}
BASIS = {"pitch": 0.05, "harmonics": [1, 2]}
PERIODS = {"pitch": 0.05, "periods": [0.02]}


@pytest.mark.parametrize(
    ("kind", "fields", "message"),
    [
        *((cogging.BSpline, {"order": n}, f"order: must be from 1 to 16, got {n}") for n in (0, 17)),
        *((cogging.BSpline, {"pitch": x}, f"pitch: {POSITIVE[0]}, got {x:g}") for x in POSITIVE[1]),
        *((cogging.BSpline, {"origin": x}, f"origin: {FINITE[0]}, got {x:g}") for x in FINITE[1]),
        (cogging.BSpline, {"control_points": 0}, "control_points: must be at least 1, got 0"),
        (cogging.BSpline, {"control_points": 2}, "control_points: more than one must be at least the order 3, got 2"),
        (cogging.SplineHarmonics, BASIS | {"pitch": NAN}, f"pitch: {POSITIVE[0]}, got nan"),
        (cogging.SplineHarmonics, BASIS | {"harmonics": [1, 0]}, "harmonics: each must be at least 1, got 0"),
        *(
            (
                cogging.SplineHarmonics,
                BASIS | {"harmonics": [*range(1, n)]},
                f"harmonics: must list 1 to 32 terms, got {n - 1}",
            )
            for n in (1, 34)
        ),
        (cogging.SplineHarmonics, BASIS | {"harmonics": [2, 1, 2]}, "harmonics: each may stand once, got 2"),
        (cogging.SplineHarmonics, BASIS | {"pitch": None}, "pitch: must be given, got nothing"),
        (cogging.SplineHarmonics, BASIS | PERIODS, "harmonics, periods: exactly one of them must be given, got both"),
        (cogging.SplineHarmonics, {"pitch": 1}, "harmonics, periods: exactly one of them must be given, got neither"),
        (cogging.SplineHarmonics, PERIODS | {"periods": [0.1, 0.0]}, "periods: must be finite and above 0, got 0"),
        (cogging.SplineHarmonics, PERIODS | {"periods": []}, "periods: must list 1 to 32 terms, got 0"),
        (cogging.SplineHarmonics, PERIODS | {"periods": [0.02] * 2}, "periods: each may stand once, got 0.02"),
        (cogging.SplineHarmonics, {"periods": [0.02], "control_points": 4}, "pitch: must be given, got nothing"),
    ],
)
def test_the_rules_of_splines_and_harmonics(kind, fields, message):
    assert message_of(kind, **((SPLINE | fields) if kind is cogging.BSpline else fields)) == message


@pytest.mark.parametrize(
    ("sine", "cosine", "message"),
    [
        (np.zeros((1, 5)), np.zeros((2, 5)), "sine: must have 2 rows .* of 5 .*, got 1 rows of 5"),
        (np.zeros((2, 5)), np.zeros((2, 4)), "cosine: must have 2 rows .* of 5 .*, got 2 rows of 4"),
        (np.zeros((2, 5)), np.full((2, 5), -INF), "cosine: must be a finite number, got -inf"),
    ],
)
def test_the_rules_of_amplitudes(sine, cosine, message):
    basis = cogging.SplineHarmonics(**BASIS, order=3, control_points=5)
    with pytest.raises(ValueError, match=f"^{message}$"):
        cogging.CoggingModel(basis, sine, cosine)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        (([0, 1], [0, 1]), "time: must hold at least 3 samples, got 2"),
        (([0, 2, 1], [0, 1, 2]), "time: must be strictly increasing, got 1"),
        (([0, NAN, 1], [0, 1, 2]), "time: must be a finite number, got nan"),
        (([0, 1, 2], [0, 1]), "position: must be as long as time (3), got 2"),
        (([0, 1, 2], [0, NAN, 1]), "position: must be a finite number, got nan"),
        (([0, 1, 2], [0, 1, 2], []), "velocity: must be as long as time (3), got 0"),
        (([0, 1, 2], [0, 1, 2], None, [0, NAN, 0]), "acceleration: must be a finite number, got nan"),
    ],
)
def test_the_rules_of_a_sampled_motion(columns, message):
    assert message_of(cogging.Sampled, *columns) == message


@pytest.mark.parametrize("name", ["friction_slope", "cogging_slope"])
def test_the_rules_of_slopes(name):
    slopes = {"friction_slope": 1.0, "cogging_slope": 1.0} | {name: -1.0}
    said = message_of(cogging.desired_compensation_condition, cogging.AdaptiveRobustParameters(), **slopes)
    assert said == f"{name}: {NOT_NEGATIVE[0]}, got -1"
