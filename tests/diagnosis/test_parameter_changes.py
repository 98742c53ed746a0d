"""Mass and friction that differ from what is stated."""

from dataclasses import replace

import pytest

from cogging.diagnosis.naming.parameter_changes import changes, look_alikes
from cogging.diagnosis.search.search import search
from tests.fixtures.moving_axis import machine, record


def test_a_level_below_nothing_is_no_change():
    truth = machine().replace(axis=machine().axis.replace(viscous=9.0))
    found = search([record(truth, 11)], machine())
    (change,) = [one for one in changes(found, machine()) if one[0] == "viscous"]
    assert change[1] == pytest.approx(2.0, abs=0.2)
    lower = replace(found, estimate=replace(found.estimate, values=found.estimate.values - 1e3))
    assert changes(lower, machine()) == []


@pytest.mark.parametrize(("force", "expected"), [(0.02, ()), (0.3, ("quadratic_drag",))])
def test_a_change_that_noise_does_not_tell_from_drag_has_it_as_an_alternative(force, expected):
    nominal, noisy = machine(), machine(force=force)
    log = record(noisy.replace(axis=noisy.axis.replace(viscous=6.0)), 32)
    told = search([log], nominal)
    assert [change[0] for change in changes(told, nominal) if abs(change[3]) > 4.0] == ["viscous"]
    assert look_alikes(told, nominal, "viscous") == expected
    assert look_alikes(told, nominal, "mass") == ()
