"""What the tests of `diagnose` share."""

import pytest

import cogging
from tests.fixtures.pid_axis import MODEL, other, run


@pytest.fixture(scope="session")
def found():
    """An asymmetry of friction, named with a confirm log."""
    hidden = cogging.effects.ViscousAsymmetry(difference=0.12)
    return cogging.diagnose(run(hidden), MODEL, confirm=other(hidden))
