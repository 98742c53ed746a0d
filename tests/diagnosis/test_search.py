"""What the search adds."""

import numpy as np
import pytest

import cogging
from cogging import EFFECTS
from cogging.diagnosis.search.search import search
from tests.fixtures.moving_axis import machine, record


@pytest.mark.parametrize(
    ("effect", "others"),
    [
        (EFFECTS["cable_spring"](stiffness=1.5), set()),
        (EFFECTS["cogging_harmonic"](period=0.0113, sine=0.12, cosine=-0.05), set()),
        (EFFECTS["viscous_asymmetry"](difference=1.2), set()),
        (EFFECTS["disturbance_tone"](frequency=7.3, sine=0.05, cosine=0.05), set()),
        (EFFECTS["force_constant_ripple"](period=0.021, sine=0.03, cosine=0.0), set()),
        (EFFECTS["quadratic_drag"](coefficient=4.0), {"stribeck_friction"}),
        # A logged command carries the noise that the loop fed back, and so do columns made of it: a delay above a
        # sample comes out too small, and on some logs (not on this one) other motion refutes it for that.
        (EFFECTS["command_delay"](delay=1.5e-3), {"actuator_lag"}),
    ],
    ids=lambda value: getattr(value, "NAME", ""),
)
def test_a_hidden_effect_is_found_first(effect, others):
    truth, nominal = machine([effect]), machine()
    found = search([record(truth, 11)], nominal, [record(truth, 12)])
    assert found.added
    assert found.added[0].finding.name in {effect.NAME} | others


@pytest.mark.parametrize(
    ("effect", "field"),
    [
        (EFFECTS["cable_spring"](stiffness=1.5, center=0.03), "center"),
        (EFFECTS["force_constant_drift"](change=0.2, time_constant=1.7), "time_constant"),
    ],
    ids=lambda value: getattr(value, "NAME", value),
)
def test_centres_and_time_constants_are_fitted_and_leave_nothing_to_add(effect, field):
    found = search([record(machine([effect]), 11)], machine(), [record(machine([effect]), 12)])
    assert [added.finding.name for added in found.added] == [effect.NAME]
    (place,) = [i for i, path in enumerate(found.estimate.paths) if path.endswith(f"{effect.NAME}.{field}")]
    error = found.estimate.values[place] - getattr(effect, field)
    assert abs(error) < 2.0 * found.estimate.half_width[place]
    assert np.isfinite(found.estimate.half_width[place])


def test_a_loose_load_is_named_whatever_its_contact():
    """In the log the contact is four times as stiff, and rebounds: gap and mass must not hang on that."""
    hidden = EFFECTS["backlash"](gap=3e-5, mass_ratio=0.06, contact_frequency=1500.0, contact_damping_ratio=0.6)
    result = cogging.diagnose(record(machine([hidden]), 1), machine(), confirm=record(machine([hidden]), 2))
    found = next(effect for effect in result.effects if effect.name == "backlash")
    assert found.alternatives == ()
    assert found.parameters["gap"].value == pytest.approx(hidden.gap, rel=0.2)
    assert found.parameters["mass_ratio"].value == pytest.approx(hidden.mass_ratio, rel=0.2)
