"""The numbers of a model by path, and the sizes against which they are judged."""

import numpy as np
import pytest

from cogging import EFFECTS, AxisParameters, CoggingModel, Model, SplineHarmonics, parameters_of
from cogging.model.parameters import Parameter, with_values


@pytest.fixture
def model():
    basis = SplineHarmonics(pitch=0.05, harmonics=[1, 2], control_points=3)
    return Model(
        axis=AxisParameters(mass=1.5, viscous=2.0, coulomb=0.7, coulomb_width=1e-3),
        cogging=CoggingModel(basis, np.arange(6.0).reshape(2, 3), -np.arange(6.0).reshape(2, 3)),
        effects=(
            EFFECTS["constant_force"](force=0.3),
            EFFECTS["cogging_harmonic"](period=0.024, sine=0.1),
            EFFECTS["position_dependent_friction"](nodes=[0.0, 0.2], levels=[0.1, -0.1]),
            EFFECTS["cogging_harmonic"](period=0.016, cosine=0.2),
            EFFECTS["command_saturation"](),
            EFFECTS["end_effect"](force=0.1, decay_length=0.01, travel=[0.0, 0.5]),
        ),
        uncertainty={"mass": 0.03},
    )


def test_every_number_has_a_path_that_with_values_follows(model):
    known = parameters_of(model)
    assert known["axis.mass"] == Parameter("axis.mass", 1.5, "V/(m/s^2)", 0.03)
    assert known["axis.coulomb"].uncertainty is None
    assert known["cogging.cosine[1][2]"].value == -5.0
    assert known["effects.cogging_harmonic[1].period"].value == 0.016
    assert known["effects.position_dependent_friction.levels[1]"].unit == "V"
    assert [path for path in known if path.endswith(("force", "limit"))] == [
        "effects.constant_force.force",
        "effects.command_saturation.limit",
        "effects.end_effect.force",
    ]
    for path in known:
        moved = parameters_of(with_values(model, {path: 0.123}))
        assert moved[path].value == 0.123
        assert {p: v for p, v in moved.items() if p != path} == {p: v for p, v in known.items() if p != path}


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("axis.weight", 1.0, "axis.weight: must be a parameter of the model"),
        ("effects.cable_spring.stiffness", 1.0, "effects.cable_spring.stiffness: must be a parameter"),
        ("effects.cogging_harmonic.period", 1.0, "must be a parameter"),  # there are two
        ("cogging.sine", 1.0, "cogging.sine: must be a parameter"),
        ("effects.position_dependent_friction.levels[x]", 1.0, "must be a parameter"),
        ("axis.mass", -1.0, "mass"),
        ("effects.cogging_harmonic[0].period", 0.0, "period"),
    ],
)
def test_a_wrong_path_or_value_is_named(model, path, value, message):
    with pytest.raises(ValueError, match=message):
        with_values(model, {path: value})
