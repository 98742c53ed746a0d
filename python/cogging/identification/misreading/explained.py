"""The share of a command that a model explains."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cogging.identification.misreading.balance import AXIS, Balance, Bounds, bounded, thinned
from cogging.logs.log import Log
from cogging.model.model import Model

FACTOR = 3.0  # by which a parameter of no stated uncertainty may be wrong, either way
SIGMAS = 3.0  # of a stated uncertainty


def stated_bounds(model: Model) -> Bounds:
    """Mass and friction within their stated uncertainty: 0 is exact, and a factor of three either way where none is."""
    bounds = {}
    for name in AXIS:
        value, sigma = getattr(model.axis, name), model.uncertainty.get(name)
        if sigma is None:
            bounds[name] = (value / FACTOR, value * FACTOR)
        else:
            bounds[name] = (value * max(1.0 - SIGMAS * sigma, 0.0), value * (1.0 + SIGMAS * sigma))
    return bounds


@np.errstate(all="ignore")  # wild numbers are refused by those who compute with them
def explained_share(logs: Sequence[Log], model: Model) -> float | None:
    """Share of the command's power in motion that a model explains with mass and friction as uncertain as stated.

    1 - sum (u - F)^2 / sum u^2 over rows in motion of all logs. u is the low-pass filtered command, F the force that
    the model needs along the measured motion, through the same filter, with the mass, viscous and Coulomb friction
    within their bounds (stated_bounds) that leave least. It is a share of force: no smaller mass makes it larger.

    Args:
        logs: measured.
        model: what is believed of the machine.

    Returns:
        1 where all is explained, 0 where nothing is, negative where the model is worse than none; None where no log
        moves or acts.

    Raises:
        ValueError: a log's rows fill hardly any of its time.

    Example:
        >>> from cogging.identification.misreading.explained import explained_share
        >>> 0.99 < explained_share([log], model) <= 1.0
        True
    """
    balances = [balance for log in logs if (balance := Balance.of(thinned(log), model)) is not None]
    if not balances:
        return None
    command = np.concatenate([balance.command[balance.taken] for balance in balances])
    target = np.concatenate([(balance.command + balance.known)[balance.taken] for balance in balances])
    columns = np.array([np.concatenate([balance.needs[name] for balance in balances]) for name in AXIS])
    power = float(np.mean(command**2))
    if power == 0.0:
        return None
    size = np.sqrt(np.mean(columns**2, axis=1))
    size[size == 0.0] = 1.0
    bounds = stated_bounds(model)
    factors = np.linalg.qr((columns / size[:, None]).T)
    found = bounded(size, factors, target, np.array([bounds[name] for name in AXIS]))
    return 1.0 - float(np.mean((target - found @ columns) ** 2)) / power
