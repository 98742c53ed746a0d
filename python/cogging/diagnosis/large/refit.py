"""Nonlinear least squares of the force balance: nuisances within what is allowed, amplitudes and shapes of effects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cogging._core import DivergedError
from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.movable import effect_parameters, shape_limits
from cogging.diagnosis.evidence.allowance import Allowance
from cogging.diagnosis.evidence.null import nuisances
from cogging.diagnosis.large.balance import Balances
from cogging.diagnosis.large.seeds import amplitude_ends
from cogging.diagnosis.thresholds import LARGE
from cogging.model.model import Model
from cogging.model.parameters import effect_paths, parameters_of, role_of, with_values


def refitted(balances: Balances, allowed: Allowance, given: int) -> Balances:
    """The balances under the model that leaves least of them; as they are where no step does better.

    Args:
        balances: logs and the model to start from.
        allowed: how far its nuisances may go.
        given: effects of the model that were there from the start: of them the amplitudes move, not the shapes.
    """
    from scipy.optimize import least_squares

    model = balances.model
    paths = movable(model, allowed, given)
    known = parameters_of(model, together=True)
    start = np.array([known[path].value for path in paths])
    low, high = _ends(balances, allowed, given, paths)
    paths, start, low, high = _that_move(paths, np.clip(start, low, high), low, high)
    if not paths:
        return balances
    seen: dict[bytes, Balances] = {}

    def at(values: FloatArray) -> Balances:
        key = values.tobytes()
        if key not in seen:
            seen.clear()
            seen[key] = balances.under(with_values(model, dict(zip(paths, values, strict=True))))
        return seen[key]

    def slopes(values: FloatArray) -> FloatArray:
        there = at(values)
        known = parameters_of(there.model, together=True)
        return there.columns([known[path] for path in paths]).T

    try:
        found = least_squares(
            lambda values: at(values).residual,
            start,
            jac=slopes,
            bounds=(low, high),
            x_scale="jac",
            max_nfev=LARGE.refit_evaluations,
            ftol=LARGE.tolerance,
        )
        better = balances.under(with_values(model, dict(zip(paths, found.x, strict=True))))
    except (DivergedError, ValueError, np.linalg.LinAlgError):
        return balances
    return better if better.rms < balances.rms else balances


def _ends(balances: Balances, allowed: Allowance, given: int, paths: Sequence[str]) -> tuple[FloatArray, FloatArray]:
    """Between what each of the paths may move: as the model's statement, its shapes and its largest command allow."""
    floors, ceilings = shape_limits(balances.model, balances)
    for path, (least, most) in amplitude_limits(balances.model, balances, given).items():
        floors[path], ceilings[path] = max(floors.get(path, least), least), min(ceilings.get(path, most), most)
    low = np.array([max(allowed.floors.get(p, -np.inf), floors.get(p, -np.inf)) for p in paths])
    high = np.array([min(allowed.ceilings.get(p, np.inf), ceilings.get(p, np.inf)) for p in paths])
    return low, high


def amplitude_limits(model: Model, balances: Balances, given: int) -> dict[str, tuple[float, float]]:
    """Between what the amplitudes of the effects that were added stay: no force is larger than the largest command."""
    limits: dict[str, tuple[float, float]] = {}
    for prefix, effect in effect_paths(model.effects)[given:]:
        for name, role in effect.ROLES.items():
            if role["role"] == "amplitude":
                ends = amplitude_ends(role, balances)
                value = getattr(effect, name)
                places = [f"[{i}]" for i in range(len(value))] if isinstance(value, list) else [""]
                limits |= {f"{prefix}.{name}{place}": ends for place in places}
    return limits


def movable(model: Model, allowed: Allowance, given: int) -> list[str]:
    """Paths that a fit of the large effects moves."""
    paths = [p for p in nuisances(model) if not p.startswith("effects.") and p not in allowed.exact]
    own = {prefix for prefix, _ in effect_paths(model.effects)[:given]}
    paths += [
        p for p in effect_parameters(model) if p.rpartition(".")[0] not in own or role_of(model, p) == "amplitude"
    ]
    return [p for p in paths if p != "axis.coulomb_width"]


def _that_move(
    paths: Sequence[str], start: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[list[str], FloatArray, FloatArray, FloatArray]:
    """What has room to move, a little inside its ends: from an end itself, a bounded fit does not start."""
    room = high > low
    with np.errstate(invalid="ignore"):
        closed = np.isfinite(high - low)
        width = np.where(closed, high - low, np.maximum(np.abs(start), 1e-6))
    inner = np.maximum(start, np.where(np.isfinite(low), low + LARGE.inside * width, -np.inf))
    inner = np.minimum(inner, np.where(np.isfinite(high), high - LARGE.inside * width, np.inf))
    return [p for p, one in zip(paths, room, strict=True) if one], inner[room], low[room], high[room]
