"""What the tests of `diagnose` share."""

import numpy as np
import pytest

import cogging
from tests.fixtures.measured import FOLDER, needs
from tests.fixtures.pid_axis import MODEL, other, run


@pytest.fixture(scope="session")
def found():
    """An asymmetry of friction, named with a confirm log."""
    hidden = cogging.effects.ViscousAsymmetry(difference=0.12)
    return cogging.diagnose(run(hidden), MODEL, confirm=other(hidden))


@pytest.fixture(scope="session")
def two_mass():
    """What reads some rows of a log of the set `two_mass` by its letter."""
    needs("two_mass")
    from scipy.io import loadmat

    def read(letter, rows):
        table = loadmat(FOLDER / "two_mass" / f"MultisineType{letter}.mat", squeeze_me=True)
        columns = (("time", 1e-6), ("theta_mx", 1.0), ("iq_adx", 1.0))
        return cogging.Log(*(np.ravel(table[name])[rows] * unit for name, unit in columns))

    return read
