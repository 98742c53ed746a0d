"""Residuals of the inverse dynamics: of many models at once what they are of each, also of none."""

import numpy as np

import cogging
from cogging.estimation.force_balance import ForceBalance

MODEL = cogging.Model(
    axis=cogging.AxisParameters(mass=0.12, viscous=0.2, coulomb=0.15, coulomb_width=0.01),
    controller=cogging.PidParameters(kp=9600.0, kd=48.0, mass=0.12),
    controller_type="pid",
)
MOVE = cogging.Sine(cogging.SineParameters(center=0.25, amplitude=0.05, frequency=2.0))


def test_residuals_of_many_models_are_those_of_each():
    dynamics = ForceBalance(cogging.simulate(MODEL, MOVE, duration=1.0, seed=1), cutoff=100.0)
    scale_error = cogging.effects.EncoderScaleError(scale=1e-3)  # another motion than that of the others
    models = [
        MODEL,
        MODEL.replace(axis=MODEL.axis.replace(mass=0.13)),
        MODEL.replace(effects=[scale_error]),
        MODEL.replace(axis=MODEL.axis.replace(viscous=0.3)),
        MODEL.replace(effects=[cogging.effects.CableSpring(stiffness=0.4), scale_error]),
    ]
    together = dynamics.of(models)
    for row, model in zip(together, models, strict=True):
        np.testing.assert_array_equal(row, dynamics.of([model])[0])
    assert np.ptp(together[:, len(dynamics.even) // 2]) > 1e-4  # V: they differ
    assert dynamics.of([]).shape == (0, len(dynamics.even))
