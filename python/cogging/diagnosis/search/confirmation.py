"""What motion that had no part in the choice says to an effect with frozen amplitudes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cogging._core import DivergedError
from cogging.diagnosis.candidates.findings import Finding
from cogging.diagnosis.candidates.intervals import acts_in_interval
from cogging.diagnosis.candidates.signatures import place
from cogging.diagnosis.candidates.tables import tables
from cogging.diagnosis.candidates.waves import is_spatial_wave, is_wave, plain_wave
from cogging.diagnosis.evidence.allowance import Allowance
from cogging.diagnosis.evidence.evidence import Evidence
from cogging.diagnosis.evidence.gather import gather
from cogging.diagnosis.evidence.log_p_value import log_survival
from cogging.diagnosis.evidence.null import limits_of, nuisances, sources_of
from cogging.diagnosis.thresholds import CONFIRMATION
from cogging.estimation.gauss_newton import fit
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.parameters import effect_paths, parameters_of, with_values


@dataclass(frozen=True)
class Confirmation:
    """An effect with frozen amplitudes on motion that had no part in the choice.

    Attributes:
        noncentrality: lambda, the expected T less its degrees of freedom on this motion if the effect is right.
        ratio: effect shown by this motion over effect expected, 1 where the effect is right.
        gain: increase of 2 ln likelihood.
        turn: angle (rad) by which a wave had to be turned, since the logs' zeros of position or time differ.
    """

    noncentrality: float
    ratio: float
    gain: float
    turn: float = 0.0

    @property
    def deviation(self) -> float:
        """1-sigma of the ratio; not below `amplitude_error`, since the amplitudes are estimates themselves."""
        return float(np.hypot(1.0 / np.sqrt(max(self.noncentrality, 1e-9)), CONFIRMATION.amplitude_error))

    @property
    def refuted(self) -> bool:
        """Whether the other motion speaks against it: it shows far less or more than expected, or fits worse."""
        far = (CONFIRMATION.less_refutes if self.ratio < 1.0 else CONFIRMATION.more_refutes) * self.deviation
        return self.noncentrality >= CONFIRMATION.informative and (abs(self.ratio - 1.0) > far or self.gain <= 0.0)

    @property
    def shown(self) -> float:
        """T of the effect on this motion, chi-square with one degree of freedom where there is no effect."""
        return self.ratio**2 * self.noncentrality

    @property
    def log_p_value(self) -> float:
        """ln of the probability that noise alone shows as much or more; 0 where the other motion does not show it."""
        if not self.confirmed:
            return 0.0
        if self.turn:
            return log_survival(self.shown, 2)
        return log_survival(self.shown, 1) - float(np.log(2.0))

    @property
    def confirmed(self) -> bool:
        """Whether the other motion shows it."""
        return self.noncentrality >= CONFIRMATION.informative and not self.refuted


def retuned(
    logs: Sequence[Log],
    model: Model,
    given: Model,
    tuned: Sequence[str],
    *,
    quick: bool = False,
    allowed: Allowance | None = None,
) -> Evidence:
    """Evidence of other logs under a model whose nuisances are re-tuned on them, what was added as it is.

    Effects that the given model has are re-tuned too: they may have masked what was added.

    Args:
        logs: logs of other motion.
        model: model with what was added.
        given: model without it.
        tuned: paths that were free in the fit of the first logs.
        quick: whether rows soon after a quick start count (see sources_of).
        allowed: how far mass and friction may move; None: freely.
    """
    own = [prefix for prefix, _ in effect_paths(model.effects)[: len(given.effects)]]
    paths = [p for p in tuned if not p.startswith("effects.")]
    paths += [p for p in nuisances(model) if p.startswith("effects.") and p.rpartition(".")[0] in own]
    sources = sources_of(logs, model, quick=quick)
    floors, ceilings = limits_of(sources, allowed)
    iterations = CONFIRMATION.retuning_iterations
    evidence = gather(fit(model, paths, sources, iterations=iterations, floors=floors, ceilings=ceilings), sources)
    return replace(evidence, turns=not same_zero(evidence, model))


def same_zero(evidence: Evidence, before: Model) -> bool:
    """Whether logs have the zero of position of those to which a model was fitted `before`.

    Its cogging, re-tuned on these logs, then lies where it lay. Where the model knows none, nobody can tell.
    """
    mine, its = evidence.model.cogging, before.cogging
    if mine is None or its is None or len(its.basis.wavenumbers) == 0:
        return False
    period = 2.0 * np.pi / float(np.min(its.basis.wavenumbers))
    places = np.linspace(*place(evidence), CONFIRMATION.travel_points)
    shifts = period * np.linspace(-0.5, 0.5, CONFIRMATION.shifts)
    force = np.asarray(its.force(places))
    alike = [float(force @ np.asarray(mine.force(places + shift))) for shift in shifts]
    return bool(max(alike) > 0.0 and abs(shifts[int(np.argmax(alike))]) < CONFIRMATION.zero_shift * period)


def confirmation(evidence: Evidence | None, finding: Finding) -> Confirmation | None:
    """What other motion says to an effect with frozen amplitudes; None without other motion."""
    if evidence is None:
        return None
    try:
        made = tables(evidence, [finding.candidate])[0]
    except (DivergedError, ValueError):
        return None
    columns = evidence.project(evidence.whitened(made))
    # Two logs need share neither the encoder's zero nor that of time: a wave may come back with another phase.
    law = finding.candidate.law
    turned = is_wave(law) and (evidence.turns or not is_spatial_wave(law))
    turns = np.linspace(0.0, 2.0 * np.pi, CONFIRMATION.wave_turns, endpoint=False) if turned else [0.0]
    best = Confirmation(0.0, 0.0, -np.inf)
    for turn in turns:
        amplitudes = finding.amplitudes
        if turn:
            rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
            amplitudes = rotation @ amplitudes
        predicted = amplitudes @ columns
        noncentrality = float(predicted @ predicted) / evidence.overdispersion
        if noncentrality <= 0.0:
            continue
        score = -float(predicted @ evidence.free_residual) / evidence.overdispersion
        gain = 2.0 * score - noncentrality - (0.0 if turn == 0.0 else CONFIRMATION.turn_penalty)
        if gain > best.gain:
            best = Confirmation(noncentrality, score / noncentrality, gain, float(turn))
    if not np.isfinite(best.gain):
        return Confirmation(0.0, 0.0, 0.0)
    if best.refuted and acts_in_interval(law):  # what happened once need not happen again
        return Confirmation(0.0, 0.0, min(best.gain, 0.0))
    return best


def as_there(model: Model, turns: Sequence[float]) -> Model:
    """The model as it holds on the other motion: waves that were added turned, where the zeros of the logs differ.

    Args:
        model: model whose last effects are those that were added.
        turns: angle (rad) of each of them in their order, 0 of what is no wave (Confirmation.turn).
    """
    if not any(turns):
        return model
    values, known = {}, parameters_of(model, together=True)
    added = effect_paths(model.effects)[len(model.effects) - len(turns) :]
    for (prefix, effect), turn in zip(added, turns, strict=True):
        wave = plain_wave(effect)
        if turn == 0.0 or wave is None:
            continue
        sine, cosine = (known[f"{prefix}.{field}"].value for field in (wave.sine, wave.cosine))
        values[f"{prefix}.{wave.sine}"] = np.cos(turn) * sine - np.sin(turn) * cosine
        values[f"{prefix}.{wave.cosine}"] = np.sin(turn) * sine + np.cos(turn) * cosine
    return with_values(model, values)
