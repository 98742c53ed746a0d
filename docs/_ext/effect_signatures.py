"""What an effect leaves in a log, and which other effects leave nearly the same: computed from the core's list.

No effect is known by name here. Each stands in the middle of the shapes at which a search looks for it, at the size at
which it makes a stated share of the command, and acts on one small machine along two motions.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import cogging
from cogging._core import DivergedError
from cogging.arrays import FloatArray
from cogging.diagnosis.candidates.findings import judged
from cogging.diagnosis.candidates.scan import begun, sharpen
from cogging.diagnosis.candidates.signatures import Candidate, place
from cogging.diagnosis.candidates.sizes import Size, directions, is_share, is_sought, likely_shapes, range_of, size_of
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.null import nuisances, sources_of
from cogging.diagnosis.experiment.limits import MotionLimits
from cogging.diagnosis.experiment.motion import KINDS, Element, Track
from cogging.diagnosis.experiment.observation import as_residual, evidence_of, looked_for
from cogging.diagnosis.thresholds import LIMIT
from cogging.effects.effect import VOCABULARY, Effect, Knots, Wave, kind_of
from cogging.model.model import Model

SHARE = 0.05  # of the rms command: what the effect of a figure makes
SECONDS = 6.0  # of the motions
SECONDS_DRAWN = 12.0  # of that of a figure: so long that each place is passed at many times and speeds
SMALLEST = 1e-6  # of the strongest size: where the search for the size begins
RATE = 1000.0  # Hz
REST = 0.005  # m/s, below which rows do not count
NODES = 6  # of a list along the travel of which a search makes none
HALVINGS = 12  # of the range in which the size is looked for: to some 1 %
BINS = 40  # of a coordinate: time is told to a third of a second
PLACES = 80  # bins of the position, of each direction: half of the shortest period that the machine's map has
BLOCK = 0.05  # s: rows that come one after the other, of which the next ones are foretold
CLEARLY = 0.1  # share
SEPARATES = 0.5  # share that a coordinate has to explain; below it the residual is drawn over time, close up
#: The motions, by what they are called: of the dictionary of `cogging experiment`.
MOTIONS = {
    "even strokes": Element("strokes", {"reach": 1.0, "speed": 1.0}),
    "random moves": Element("random_moves", {"seed": 1.0, "slowest": 0.2}),
}
LIMITS = MotionLimits(travel=(0.0, 0.5), velocity=0.5, acceleration=10.0, jerk=1000.0, duration=SECONDS)


def machine() -> Model:
    """The small machine: a linear axis of a usual size with two harmonics of cogging, a PID and an encoder."""
    return cogging.Model(
        axis=cogging.AxisParameters(mass=0.12, viscous=0.166, coulomb=0.15, coulomb_width=1e-3, travel=[0.0, 0.5]),
        cogging=cogging.CoggingModel(
            cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2]), sine=[[0.08], [0.04]], cosine=[[0.0], [0.02]]
        ),
        encoder=cogging.EncoderParameters(resolution=0.5e-6),
        noise=cogging.NoiseParameters(force=0.005),
        controller=cogging.PidParameters(kp=2400.0, ki=2e4, kd=24.0, mass=0.12, viscous=0.166, sample_rate=RATE),
        controller_type="pid",
    )


def motion(name: str, seconds: float = SECONDS) -> Any:
    """One of MOTIONS."""
    element = MOTIONS[name]
    track = Track(LIMITS, RATE, seconds)
    KINDS[element.kind](track, element.parameters)
    return track.motion()


@dataclass(frozen=True)
class Place:
    """A coordinate against which a residual is drawn.

    Attributes:
        name, unit: of the coordinate.
        explained: share of the residual's power that its means in bins foretell (see foretold).
    """

    name: str
    unit: str
    explained: float


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
    residual, rows = _left(effect, motion(list(MOTIONS)[-1], SECONDS_DRAWN))
    return Signature(
        effect, residual, rows, places(effect, residual, rows)[0], {name: _confused(effect, name) for name in MOTIONS}
    )


def _confused(effect: Effect, name: str) -> Confusion:
    """What else explains what an effect leaves along a motion."""
    model = machine()
    truth = model.replace(effects=(effect,))
    log = cogging.simulate(truth, motion(name), seed=1)
    evidence, signal = evidence_of(log, model, nuisances(model), REST, truth)
    seen = as_residual(evidence, signal)
    left = max(float(seen.free_residual @ seen.free_residual), 1e-300)
    shares = {other: _explained(seen, VOCABULARY[other], effect, left) for other in VOCABULARY if other != effect.NAME}
    retuned = 1.0 - left / max(float(signal @ signal), 1e-300)
    return Confusion(retuned, tuple(sorted(shares.items(), key=lambda item: -item[1])))


def _left(effect: Effect, course: Any) -> tuple[FloatArray, dict[str, FloatArray]]:
    """What the model without the effect does not foresee, V, and where, in rows in motion; no noise, no encoder."""
    model = machine().replace(noise=cogging.NoiseParameters(), encoder=cogging.EncoderParameters())
    log = cogging.simulate(model.replace(effects=(effect,)), course)
    source = sources_of([log], model, rest=REST, quick=True)[0]
    kept, velocity = source.mask > 0, source.along.velocity
    rows = {"time": log.time, "position": log.position, "velocity": velocity}
    rows |= {"acceleration": np.gradient(velocity, log.time), "command": log.command}
    return source.of([model])[0][kept], {each: np.asarray(values)[kept] for each, values in rows.items()}


def _sized(law: Effect) -> Effect:
    """The effect in the middle of its shapes, at the size that leaves SHARE of the rms command, or its strongest."""
    model, course, size = machine(), motion(list(MOTIONS)[-1], SECONDS_DRAWN), size_of(law)
    assert size is not None, law.NAME
    empty = cogging.simulate(model, course, seed=1)
    evidence, _ = evidence_of(empty, model, nuisances(model), REST, model)
    candidate = _middle(evidence, law)
    goal = SHARE * float(np.sqrt(np.mean(empty.command**2)))
    weak, strong = range_of(evidence, law, size)
    weak = weak or SMALLEST * strong
    for _ in range(HALVINGS):
        middle = float(np.sqrt(weak * strong))
        try:
            residual, _ = _left(_at(candidate, size, middle), course)
            enough = float(np.sqrt(np.mean(residual**2))) > goal
        except (DivergedError, ValueError):  # stronger than this machine bears
            enough = True
        weak, strong = (weak, middle) if enough else (middle, strong)
    return _at(candidate, size, float(f"{weak:.3g}"))


def _middle(evidence: Evidence, law: Effect) -> Candidate:
    """The effect in the middle of the shapes at which it may hide; lists of which a search makes none, along x."""
    if is_sought(law):
        shapes, _ = likely_shapes(evidence, law)
        return shapes[len(shapes) // 2]
    knots = kind_of(law, Knots)
    assert knots is not None, law.NAME
    nodes = [float(value) for value in np.linspace(*place(evidence), NODES)]
    columns = tuple((knots.levels, i) for i in range(NODES))
    return Candidate(law, {knots.nodes: nodes}, columns, (1.0,) * NODES)


def _at(candidate: Candidate, size: Size, value: float) -> Effect:
    """The effect of this size."""
    if not size.made_by_shape:
        return candidate.effect([float(part) for part in value * directions(candidate)[0]])
    shares = {
        field: LIMIT.share_behind
        for field, role in candidate.law.ROLES.items()
        if role["role"] == "shape" and is_share(role) and field != size.field
    }
    return replace(candidate, shape={**candidate.shape, **shares, size.field: value}).effect()


def _explained(seen: Evidence, other: Effect, effect: Effect, left: float) -> float:
    """Share of what an effect leaves after re-tuning that another explains at its best shape and size."""
    if not is_sought(other):
        return 0.0
    findings = judged(seen, looked_for(seen, other, effect), 1.0)
    if not findings:
        return 0.0
    best = max(findings, key=lambda finding: finding.score)
    if not best.candidate.amplitudes:
        known = judged(seen, [begun(best)], 1.0, exact=True)
        best = known[0] if known else best
    best = sharpen(seen, best)
    explained = best.test.explained
    return float(min(1.0, explained @ explained / max(left, 1e-300)))


UNITS = {"position": "m", "velocity": "m/s", "acceleration": "m/s²", "command": "V", "time": "s"}


def places(effect: Effect, residual: FloatArray, rows: Mapping[str, FloatArray]) -> list[Place]:
    """Every coordinate with what it explains of a residual, the best first; time only where it is better by CLEARLY.

    A time is hardly ever passed twice, so that it foretells what comes with anything that changes slowly.
    """
    found = []
    for name, values in {**rows, **folded(effect, rows)}.items():
        count = PLACES if name == "position" else BINS
        bins = np.minimum(((values - values.min()) / np.ptp(values) * count).astype(int), count - 1)
        if name == "position":  # each direction by itself
            bins = bins + count * (rows["velocity"] < 0.0)
        found.append(Place(name, UNITS[name.split()[0]], foretold(residual, bins, rows["time"])))
    return sorted(found, key=lambda one: (one.name == "time") * CLEARLY - one.explained)


def foretold(residual: FloatArray, bins: Any, time: FloatArray) -> float:
    """Share of a residual's power that the bins of every second BLOCK foretell in the others, and the other way round.

    What happens once, at a place that is passed once, is thus not explained by that place.
    """
    second = np.floor(time / BLOCK).astype(int) % 2 == 1
    left = residual.copy()
    for known, asked in ((second, ~second), (~second, second)):
        rows = np.bincount(bins[known], minlength=int(bins.max()) + 1)
        sums = np.bincount(bins[known], residual[known], len(rows))
        left[asked] -= (sums / np.maximum(rows, 1))[bins[asked]]
    return max(0.0, 1.0 - float(left @ left) / max(float(residual @ residual), 1e-300))


def folded(effect: Effect, rows: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """The position, or the time, within the period of an effect that has one."""
    wave = kind_of(effect, Wave)
    if wave is None:
        return {}
    value, spatial = float(getattr(effect, wave.shape)), effect.ROLES[wave.shape]["quantity"] == "distance"
    name, period = ("position", value) if spatial else ("time", 1.0 / value)
    return {f"{name} within the period": np.mod(rows[name], period)}
