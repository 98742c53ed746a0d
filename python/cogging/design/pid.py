"""Gains from a design: where the poles shall be, for which mass."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from cogging._core import AxisParameters, PidParameters
from cogging.calls import check_arguments

POLE, RATE = 60.0, 1000.0  # 1/s and Hz, of the loop assumed without a stated controller
ASSUMED = f"a PID of three poles at {POLE:g} 1/s at {RATE:g} Hz"


@check_arguments()
def pid_gains(poles: Sequence[complex], mass: float) -> tuple[float, float, float]:
    """Place the poles of a PID on a pure mass: s^3 + kd/M s^2 + kp/M s + ki/M (Xu and Yao 2001, eq. 56).

    Args:
        poles: three of them, 1/s, left of the imaginary axis, complex ones in pairs.
        mass: M, V/(m/s^2).

    Returns:
        kp (V/m), ki (V/(m s)), kd (V/(m/s)).

    Raises:
        ValueError: not three poles, one without a negative real part, one without its pair, or mass <= 0.

    Example:
        >>> kp, ki, kd = cogging.pid_gains([-100.0, -100.0, -100.0], mass=0.12)
        >>> print(f"kp {kp:.0f} V/m, ki {ki:.0f} V/(m s), kd {kd:.0f} V/(m/s)")
        kp 3600 V/m, ki 120000 V/(m s), kd 36 V/(m/s)
    """
    if len(poles) != 3:
        raise ValueError(f"poles: must be three, got {len(poles)}")
    for pole in poles:
        if not (np.isfinite(pole) and np.real(pole) < 0):
            raise ValueError(f"poles: each must be finite with a real part below 0, got {pole}")
    if not (np.isfinite(mass) and mass > 0):
        raise ValueError(f"mass: must be finite and above 0, got {mass:g}")
    polynomial = np.poly(np.asarray(poles, dtype=complex))
    if np.abs(polynomial.imag).max() > 1e-9 * np.abs(polynomial).max():
        raise ValueError(f"poles: complex ones must come in pairs, got {list(poles)}")
    kd, kp, ki = (float(coefficient) * mass for coefficient in polynomial.real[1:])
    return kp, ki, kd


def assumed_pid(axis: AxisParameters) -> PidParameters:
    """Return the PID of ASSUMED for an axis whose controller is not known, with its mass and viscous friction."""
    kp, ki, kd = pid_gains([-POLE] * 3, axis.mass)
    return PidParameters(sample_rate=RATE, kp=kp, ki=ki, kd=kd, mass=axis.mass, viscous=axis.viscous)


@check_arguments()
def pid_poles(kp: float, ki: float, kd: float, mass: float) -> npt.NDArray[np.complex128]:
    """The poles (1/s) that PID gains give on a pure mass (Xu and Yao 2001, eq. 56): what pid_gains inverts.

    Args:
        kp: V/m.
        ki: V/(m s).
        kd: V/(m/s).
        mass: V/(m/s^2).

    Returns:
        The three poles, 1/s.

    Example:
        >>> [round(pole.real) for pole in cogging.pid_poles(3600.0, 120000.0, 36.0, mass=0.12)]
        [-100, -100, -100]
    """
    return np.asarray(np.roots([1.0, kd / mass, kp / mass, ki / mass]), dtype=np.complex128)
