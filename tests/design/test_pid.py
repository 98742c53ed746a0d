"""Gains from poles."""

import numpy as np
import pytest

import cogging


def test_the_papers_pid_gains():
    # Xu and Yao 2001, section 4.3: three poles at -300 (and -320) for a mass of 0.02.
    assert cogging.pid_gains([-300] * 3, 0.02) == pytest.approx((5.4e3, 5.4e5, 18.0), rel=1e-12)
    assert cogging.pid_gains([-320] * 3, 0.02) == pytest.approx((6144.0, 655360.0, 19.2), rel=1e-12)
    poles = sorted(cogging.pid_poles(5.4e3, 5.4e5, 18.0, 0.027), key=lambda pole: pole.imag)
    np.testing.assert_allclose(poles, [-245 - 231j, -176, -245 + 231j], atol=1.0)  # on the real mass


def test_poles_and_gains_are_inverses():
    random = np.random.default_rng(4)
    for _ in range(100):
        real, imaginary, mass = -random.uniform(1, 500), random.uniform(0, 400), random.uniform(0.01, 10)
        poles = [-random.uniform(1, 500), complex(real, imaginary), complex(real, -imaginary)]
        found = cogging.pid_poles(*cogging.pid_gains(poles, mass), mass)
        np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(np.array(poles)), rtol=1e-6)


@pytest.mark.parametrize(
    ("poles", "mass", "message"),
    [
        ([-1, -2], 1.0, "poles: must be three, got 2"),
        ([-1, -2, 0], 1.0, "poles: each must be finite with a real part below 0, got 0"),
        ([-1, -2, -3 + 1j], 1.0, "poles: complex ones must come in pairs"),
        ([-1, -2, -3], 0.0, "mass: must be finite and above 0, got 0"),
    ],
)
def test_rules(poles, mass, message):
    with pytest.raises(ValueError, match=message):
        cogging.pid_gains(poles, mass)
