"""The rule of every number of every parameter struct, and the rules that bind several fields."""

import functools
import math
import re

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
INFINITE = "PointToPointParameters.jerk CommandSaturation.limit PreslidingFriction.stiffness FlexibleMode.frequency"
POLES = "OutputFeedbackArcParameters.observer_gain_1 OutputFeedbackArcParameters.observer_gain_2"
FURTHER = [
    ("must be finite and not 0", (0.0, NAN, INF), "PointToPointParameters.distance"),
    ("must be above 0 (infinite = none)", (0.0, -1.0, NAN), INFINITE),
    ("must be at least 0 and below 1", (-1.0, 1.0, NAN), "Backlash.mass_ratio FlexibleMode.mass_ratio"),
    ("must be above start = 0", (0.0, -1.0, NAN), "DisturbanceStep.stop"),
    ("must be 0 to 61 samples", (-1.0, 1.0, NAN), "ObserverBasedParameters.delay"),
    ("must be above 0, or A_0 is not stable", (0.0, -1.0, NAN), POLES),
]
for name, low, high in (("mass", 0.1, 0.2), ("viscous", 0, 1), ("coulomb", 0, 1), ("disturbance", -1, 1)):
    rule = f"must lie within {name}_bounds [{low}, {high}]"
    FURTHER.append((rule, (low - 1.0, high + 1.0, NAN), f"AdaptiveRobustParameters.{name}"))
RULE_OF = {f"{name}.{field}": POSITIVE for name, fields in PLAIN.items() for field in fields[0].split()}
RULE_OF |= {f"{name}.{field}": NOT_NEGATIVE for name, fields in PLAIN.items() for field in fields[1].split()}
RULE_OF |= {path: (rule, refused) for rule, refused, paths in FURTHER for path in paths.split()}
assert set(RULE_OF) <= NUMBERS


@pytest.mark.parametrize("path", sorted(NUMBERS))
def test_the_rule_of_a_number(path):
    name, field = path.split(".")
    rule, refused = RULE_OF.get(path, FINITE)
    for value in refused:
        with pytest.raises(ValueError, match=f"^{re.escape(f'{field}: {rule}, got {value:g}')}$"):
            STRUCTS[name](**{field: value})
    if rule.startswith("must be finite and at least 0"):
        STRUCTS[name](**{field: 0.0})


ADAPTIVE, OBSERVER, OUTPUT = (f"{name}Parameters" for name in ("AdaptiveRobust", "ObserverBased", "OutputFeedbackArc"))
FEEDBACK = [f"{kind}Parameters" for kind in ("Pid", "Cascade", "Speed")]
ONE = {"cogging_harmonics": [1]}
SPLINE = {"order": 3, "origin": 0.0, "pitch": 0.05, "control_points": 5}
BASIS = {"pitch": 0.05, "harmonics": [1, 2]}
PERIODS = {"pitch": 0.05, "periods": [0.02]}
STRUCTS |= {kind.__name__: kind for kind in (cogging.BSpline, cogging.SplineHarmonics)}
#: Struct, fields, and the field that the error names.
TOGETHER = [
    ("AxisParameters", {"travel": [0.5, 0.0]}, "travel"),
    ("EndEffect", {"travel": [0.5, NAN]}, "travel"),
    ("AxisParameters", {"mass": 1e300}, "mass"),
    *(("SplineHarmonics", {"pitch": x, "harmonics": [1]}, "pitch") for x in (1e300, 1e10)),
    ("SplineHarmonics", {"pitch": 0.05, "harmonics": [1, 2 * 10**9]}, "harmonics"),
    ("SplineHarmonics", {"periods": [0.05, 1e-12]}, "periods"),
    ("CoggingHarmonic", {"period": 1e-10}, "period"),
    ("ObserverBasedParameters", {"periods": [1e-10]}, "periods"),
    ("PointToPointParameters", {"repeats": 0}, "repeats"),
    ("DisturbanceStep", {"start": 1.0, "stop": 1.0}, "stop"),
    ("CoggingModulation", {"sine": [INF], "cosine": [0.0]}, "sine"),
    ("CoggingModulation", {"sine": [1, 2], "cosine": [1]}, "cosine"),
    ("CoggingModulation", {"order": 0}, "order"),
    ("CoggingModulation", {"pitch": 0.1, "sine": [1, 2], "cosine": [1, 2]}, "sine"),
    ("PositionDependentFriction", {"nodes": [0.0], "levels": [INF]}, "levels"),
    ("PositionDependentFriction", {"nodes": [0.1] * 2, "levels": [0] * 2}, "nodes"),
    ("PositionDependentFriction", {"nodes": [0, 1]}, "levels"),
    ("EmpiricalForce", {"time_nodes": [NAN], "time_forces": [0]}, "time_nodes"),
    ("EmpiricalForce", {"velocity_nodes": [0.1]}, "velocity_forces"),
    *((kind, {"feedforward_velocity": "desired"}, "feedforward_velocity") for kind in FEEDBACK),
    ("SpeedParameters", {"delay": 1e4}, "delay"),
    *(
        (ADAPTIVE, {f"{name}_bounds": [0.0, end]}, f"{name}_bounds")
        for name in ("mass", "viscous", "coulomb", "disturbance", "cogging")
        for end in (-1.0, INF)
    ),
    (ADAPTIVE, {"mass_bounds": [0.0, 0.2]}, "mass_bounds"),
    (ADAPTIVE, {"cogging_harmonics": [1, 0]}, "cogging_harmonics"),
    (ADAPTIVE, ONE | {"cogging_control_points": 2}, "control_points"),
    (ADAPTIVE, ONE | {"cogging_estimates": [0.1]}, "cogging_estimates"),
    (ADAPTIVE, ONE | {"cogging_estimates": [0.0, 0.2]}, "cogging_estimates"),
    (OBSERVER, {"periods": []}, "periods"),
    (OBSERVER, {"periods": [-0.01]}, "periods"),
    (OBSERVER, {"observer_gain": [1, 2]}, "observer_gain"),
    (OBSERVER, {"observer_gain_slope": [1]}, "observer_gain_slope"),
    (OBSERVER, {"rotation": "guessed"}, "rotation"),
    (OUTPUT, {"theta_min": [0, 2, -50]}, "theta_min"),
    (OUTPUT, {"theta_min": [60, 2.4, -50]}, "theta_min, theta_max"),
    (OUTPUT, {"theta": [100, 10, 0]}, "theta"),
    (OUTPUT, {"adaptation": [-1, 0, 0]}, "adaptation"),
    (OUTPUT, {"filter_steps": "tustin"}, "filter_steps"),
    (OUTPUT, {"observer_gain_2": 1e308, "sample_rate": 1e-3}, "sample_rate"),
    *(("BSpline", SPLINE | {"order": n}, "order") for n in (0, 17)),
    *(("BSpline", SPLINE | {"pitch": x}, "pitch") for x in POSITIVE[1]),
    *(("BSpline", SPLINE | {"origin": x}, "origin") for x in FINITE[1]),
    *(("BSpline", SPLINE | {"control_points": n}, "control_points") for n in (0, 2)),
    *(("SplineHarmonics", BASIS | {"pitch": x}, "pitch") for x in (NAN, None)),
    *(("SplineHarmonics", BASIS | {"harmonics": x}, "harmonics") for x in ([1, 0], [], [*range(1, 34)], [2, 1, 2])),
    *(("SplineHarmonics", fields, "harmonics, periods") for fields in (BASIS | PERIODS, {"pitch": 1})),
    *(("SplineHarmonics", PERIODS | {"periods": x}, "periods") for x in ([0.1, 0.0], [], [0.02] * 2)),
    ("SplineHarmonics", {"periods": [0.02], "control_points": 4}, "pitch"),
]


def assert_refused(call, field):
    """In one line that begins with the field and ends with what was given."""
    with pytest.raises(ValueError, match=rf"^(cogging_)?{field}: .*, got .+$"):
        call()


@pytest.mark.parametrize(("name", "fields", "field"), TOGETHER)
def test_the_rules_of_lists_words_and_several_fields(name, fields, field):
    assert_refused(lambda: STRUCTS[name](**fields), field)


def test_euler_steps_are_stable_up_to_twice_the_filter_s_time_constant():
    """Both filter poles at -200: up to a step of 0.01 s."""
    xu2001_setup.arc_parameters(sample_rate=100.5, filter_steps="euler")
    with pytest.raises(ValueError, match=r"^sample_rate: is too low for Euler steps of the observer's"):
        xu2001_setup.arc_parameters(sample_rate=99.5, filter_steps="euler")


def test_the_rules_of_amplitudes_slopes_and_sampled_motions():
    basis = cogging.SplineHarmonics(**BASIS, order=3, control_points=5)
    plain = np.zeros((2, 5))
    assert_refused(lambda: cogging.CoggingModel(basis, plain[:1], plain), "sine")
    for cosine in (plain[:, :4], plain - INF):
        assert_refused(lambda cosine=cosine: cogging.CoggingModel(basis, plain, cosine), "cosine")
    for name in ("friction_slope", "cogging_slope"):
        slopes = {"friction_slope": 1.0, "cogging_slope": 1.0} | {name: -1.0}
        condition = functools.partial(cogging.desired_compensation_condition, cogging.AdaptiveRobustParameters())
        assert_refused(functools.partial(condition, **slopes), name)
    for columns, name in (
        (([0, 1], [0, 1]), "time"),
        (([0, 2, 1], [0, 1, 2]), "time"),
        (([0, NAN, 1], [0, 1, 2]), "time"),
        (([0, 1, 2], [0, 1]), "position"),
        (([0, 1, 2], [0, NAN, 1]), "position"),
        (([0, 1, 2], [0, 1, 2], []), "velocity"),
        (([0, 1, 2], [0, 1, 2], None, [0, NAN, 0]), "acceleration"),
    ):
        assert_refused(lambda columns=columns: cogging.Sampled(*columns), name)
