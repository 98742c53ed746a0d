"""What an effect leaves in a log, and which other effects leave nearly the same: computed from the core's list.

No effect is known by name here. Each stands in the middle of the shapes at which a search looks for it, at the size at
which it makes a stated share of the command, and acts on one small machine along two motions.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from coordinates import Place, places
from small_machine import MOTIONS, RATE, left_by, machine, motion

import cogging
from cogging._core import DivergedError
from cogging.arrays import FloatArray
from cogging.diagnosis.balance.candidates import search_once
from cogging.diagnosis.balance.differenced_balance import DifferencedBalance
from cogging.diagnosis.balance.evidence import Evidence
from cogging.diagnosis.detection_limits import size_of
from cogging.effects.effect import VOCABULARY, Effect, Knots, SplineKnots, Window, kind_of

SECONDS_DRAWN = 24.0  # of that of a figure: so long that each place is passed at many times and speeds
SHARE = 0.05  # of the rms command: what the effect of a figure makes
SMALLEST = 1e-6  # of the strongest size: where the search for the size begins
NODES = 6  # of a list along the travel
BEHIND = 0.2  # of the mass, where a share of it is behind a contact or a spring
TRIES = 12  # until the size is found, or the largest that the machine bears
CLOSE_ENOUGH = 0.02  # of that share
SEPARATES = 0.5  # share that a coordinate has to explain; below it the residual is drawn over time, close up


@dataclass(frozen=True)
class Signature:
    """What an effect leaves of a model without it, and what else would explain that.

    Attributes:
        effect: the effect, at the size of the figure.
        residual: what the model without it does not foresee along the last of MOTIONS, in rows in motion, without noise
            and encoder, V, (n,).
        rows: `time`, `position`, `velocity`, `acceleration` and `command` of the same rows, (n,).
        place: the coordinate that separates it best.
        confusion: by the name of each motion.
    """

    effect: Effect
    residual: FloatArray
    rows: Mapping[str, FloatArray]
    place: Place
    confusion: Mapping[str, Confusion]


@dataclass(frozen=True)
class Confusion:
    """What a search would take an effect for along a motion, with noise and encoder.

    Attributes:
        retuned: share of the power of what it leaves that re-tuning axis and map takes away.
        explained: name of each other effect and the share that it explains of what then remains, largest first.
    """

    retuned: float
    explained: tuple[tuple[str, float], ...]


def signature(law: Effect) -> Signature:
    """What an effect of the list leaves, and what else leaves nearly the same."""
    effect = _sized(law)
    residual, rows = left_by(effect, motion(list(MOTIONS)[-1], SECONDS_DRAWN))
    return Signature(
        effect, residual, rows, places(effect, residual, rows)[0], {name: _confused(effect, name) for name in MOTIONS}
    )


def _confused(effect: Effect, name: str) -> Confusion:
    """What else explains what an effect leaves along a motion."""
    model = machine()
    log = cogging.simulate(model.replace(effects=(effect,)), motion(name), seed=1)
    balance = DifferencedBalance(log, model.axis.coulomb_width, model.encoder.resolution)
    evidence = Evidence([balance], model, model).prepare(2, listen=True)
    root, _, free = evidence.basis
    left = max(float(free @ free), 1e-300)
    found = search_once(evidence, {})
    most = max([one.T for one in found], default=0.0) or 1.0  # what can be explained at all: noise cannot
    seen = {one.name: min(1.0, one.T / most) for one in found}
    shares = {other: float(seen.get(other, 0.0)) for other in VOCABULARY if other != effect.NAME}
    whole = evidence.screen.r * root
    retuned = max(0.0, 1.0 - left / max(float(whole @ whole), left))
    return Confusion(retuned, tuple(sorted(shares.items(), key=lambda item: -item[1])))


def _sized(law: Effect) -> Effect:
    """The effect in the middle of its shapes, at the size that leaves SHARE of the rms command, or its strongest."""
    model, course, size = machine(), motion(list(MOTIONS)[-1], SECONDS_DRAWN), size_of(law)
    assert size is not None, law.NAME
    empty = cogging.simulate(model, course, seed=1)
    goal = SHARE * float(np.sqrt(np.mean(empty.command**2)))
    role, scales = law.ROLES[size.field], _scales(empty)
    weak, strong = (float(role[end]) * scales.get(role["quantity"], 1.0) for end in ("low", "high"))
    weak, strong = (max(weak, SMALLEST * strong), strong) if size.grows else (strong, weak)
    if role["role"] == "amplitude":
        weak = SMALLEST * strong
    fields, value = _middle(law, scales, size.field), float(np.sqrt(weak * strong))
    for _ in range(TRIES):
        left = _rms_left(_at(law, fields, size.field, value), course)
        if abs(left / goal - 1.0) < CLOSE_ENOUGH:
            return _at(law, fields, size.field, value)
        weak, strong = (weak, value) if left > goal else (value, strong)
        guess = value * (goal / left if size.grows else left / goal) if 0.0 < left < np.inf else 0.0
        value = guess if min(weak, strong) < guess < max(weak, strong) else float(np.sqrt(weak * strong))
    return _at(law, fields, size.field, weak)


def _rms_left(effect: Effect, course: Any) -> float:
    """What an effect leaves along a motion, V; infinite where it is stronger than the machine bears."""
    try:
        residual, _ = left_by(effect, course)
    except (DivergedError, ValueError):
        return float(np.inf)
    return float(np.sqrt(np.mean(residual**2)))


def _scales(log: cogging.Log) -> dict[str, float]:
    """What ranges of a search are multiples of, on the small machine."""
    travel, speed = float(np.ptp(log.position)), float(np.abs(np.gradient(log.position, log.time)).max())
    force, axis = float(np.abs(log.command).max()), machine().axis
    known = {"position": travel, "distance": travel, "velocity": speed, "time": float(log.time[-1]), "force": force}
    known |= {"command": force, "friction": axis.coulomb, "sample_time": 1.0 / RATE, "frequency": 0.5 * RATE}
    known |= {"force_per_position": force / travel, "force_per_velocity": force / speed}
    return known | {"force_per_velocity_squared": force / speed**2, "stiffness": axis.coulomb / travel, "angle": 6.28}


def _middle(law: Effect, scales: Mapping[str, float], sized: str) -> dict[str, Any]:
    """The fields of an effect beside its size: each shape in the middle of its range, lists along the travel."""
    fields: dict[str, Any] = {}
    for field, role in law.ROLES.items():
        if role["role"] != "shape" or field == sized or isinstance(getattr(law, field), list):
            continue
        low, high = float(role["low"]), float(role["high"])
        value = np.sqrt(low * high) if role["logarithmic"] and low > 0.0 else 0.5 * (low + high)
        fields[field] = float(value * scales.get(role["quantity"], 1.0))
        if role["quantity"] == "relative" and role["neutral"] == 0.0:
            fields[field] = BEHIND
    window, knots, spline = kind_of(law, Window), kind_of(law, Knots), kind_of(law, SplineKnots)
    if window is not None:
        fields |= {window.start: 0.3 * scales["time"], window.stop: 0.6 * scales["time"]}
    if knots is not None:
        fields[knots.nodes] = np.linspace(0.0, machine().axis.travel[1], NODES).tolist()
    if spline is not None:
        fields |= {spline.pitch: machine().axis.travel[1] / (NODES - 2), spline.order: 3, spline.origin: 0.0}
    return fields


def _at(law: Effect, fields: Mapping[str, Any], sized: str, value: float) -> Effect:
    """The effect of this size; lists go up and down along the travel."""
    told = dict(fields)
    pattern = np.cos(np.pi * np.arange(NODES)) * np.linspace(0.5, 1.0, NODES)
    for field, role in law.ROLES.items():
        listed = isinstance(getattr(law, field), list)
        if role["role"] == "amplitude":
            of_first_knots = not listed or field == sized or kind_of(law, SplineKnots) is not None
            size = value if field == sized else 0.0
            if of_first_knots:
                told[field] = (size * pattern).tolist() if listed else size
    return law.replace(
        **told if sized in law.ROLES and law.ROLES[sized]["role"] == "amplitude" else {**told, sized: value}
    )
