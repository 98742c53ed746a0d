"""The search for missing effects: scan, confirm, add, and look again at what is left."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cogging._core import EFFECTS, DivergedError
from cogging.diagnosis.candidates.intervals import acts_in_interval
from cogging.diagnosis.candidates.map_errors import freed, map_error
from cogging.diagnosis.candidates.scan import Finding, cleaned, judged, profiled, scan
from cogging.diagnosis.candidates.waves import is_spatial_wave, is_wave
from cogging.diagnosis.discrepancy import discrepancies, follows
from cogging.diagnosis.discrepancy import source_of as discrepancy_source
from cogging.diagnosis.evidence.evidence import Evidence, cosine, gather
from cogging.diagnosis.evidence.null import fit_null
from cogging.diagnosis.residual.events import with_events
from cogging.diagnosis.residual.modulated_look_alikes import modulated_look_alikes
from cogging.diagnosis.residual.shapes import Shape, low_power, shapes
from cogging.diagnosis.search.confirmation import INFORMATIVE, Confirmation, confirmation, retuned
from cogging.diagnosis.search.levels import with_levels
from cogging.diagnosis.search.refit import refit
from cogging.estimation.gauss_newton import Estimate
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.parameters import parameters_of, with_values

# Thresholds, frozen before a seed is drawn for a report (see tests/blind/seeds.toml).
#: ln of the chance that noise shows as much anywhere in one effect's scan: some 20 effects, 0.15 % in all.
DETECTED = -9.5
HINTED = -3.0  # the same, from which the confirm logs are asked
POSSIBLE = -1.5  # the same, from which a rival counts
JOINT = -15.0  # the same for both logs together, where that alone is not enough
UNSHOWN = -20.0  # the same for what the confirm logs cannot show
SLIPPERY = -60.0  # the same for a level of friction or a force in an interval: odd friction near rest looks like them
LEFT_OVER = -12.0  # the same for a generic shape: it also catches what friction laws differ by
NEAR_BEST = -5.0  # the same for a rival of what stands by itself
RIVAL = 2.0 * np.log(100.0)  # of the penalised 2 ln likelihood: a rival closer than this is an alternative
PAYS = 1.01  # times the gap on the confirm logs, which an effect may not make larger
WORTH = 0.01  # of the residual's power below 60 Hz: an effect that explains less is not worth a name
OVERWHELMING = 1000.0  # score beyond which effects are taken in the order of what they are worth
REACH = 60.0  # of the score: what is farther from the best is no rival
FORM = 0.05  # of T: how well the form of anything is known
SAME = 0.01  # of a period
LIKE = 0.5  # cosine between what two findings explain
MOSTLY, NEARLY = 0.7, 0.9  # of T
MANY = 4  # amplitudes
AGAIN = 150.0  # of the score: what is farther from the best is not looked at a second time
EFFECTS_MAX = 4
TERMS_MAX = 8
HARMONICS_MAX = 3  # terms of one name: a fourth would tell of the shape, and take the place of another effect


@dataclass
class Added:
    """An effect that was accepted, and what stood against it.

    Attributes:
        finding: as the scan found it.
        rivals: it and what explains about as much, the likeliest first.
        shapes: generic shapes of what was missing before it.
        confirmation: on other motion; None without.
        model: refitted with it, with levels tuned to its gap.
        or_map: whether errors of the cogging map explain nearly as much.
    """

    finding: Finding
    rivals: list[Finding]
    shapes: list[Shape]
    confirmation: Confirmation | None
    model: Model
    or_map: bool = False


@dataclass
class Search:
    """All that was found on the way.

    Attributes:
        nominal: fit of the model as it was given, and its evidence.
        tuned: the nominal model with levels tuned to its gap (with_levels).
        estimate: fit with all that was added, and its evidence.
        added, refused: effects in the order in which they were tried; the refused with the reason.
        nominal_shapes: generic shapes, and events, of what is missing in the nominal model.
        residual_shapes: the same of the last model.
        unused: the last scan, of which nothing was added.
        confirm_evidence: the confirm logs under the last model, None without.
    """

    nominal: Estimate
    nominal_evidence: Evidence
    tuned: Model
    estimate: Estimate
    evidence: Evidence
    added: list[Added]
    refused: list[tuple[Finding, str]]
    nominal_shapes: list[Shape]
    residual_shapes: list[Shape]
    unused: list[Finding]
    confirm_evidence: Evidence | None


def search(
    logs: Sequence[Log],
    model: Model,
    confirm: Sequence[Log] = (),
    progress: Callable[[str], None] = lambda step: None,
    replay: bool = False,
    free_map: bool = False,
) -> Search:
    """Scan, add what stands, until nothing significant is left or as many as can be told were added.

    Args:
        logs: that are searched.
        model: what is believed.
        confirm: logs of other motion.
        progress: is told what is being done.
        replay: an effect must pay by the gap of the replayed loop, where that follows the logs.
        free_map: errors of the cogging map are re-tuned; tried by itself where they explain as much as the best effect.
    """
    progress("re-tuning the model")
    nominal, evidence = fit_null(logs, model)
    if free_map:
        nominal, evidence = freed(nominal, evidence)
    quick = all(source.quick_starts for source in evidence.sources)
    estimate = nominal

    def elsewhere() -> Evidence | None:
        """The confirm logs under the present model; None where they cannot be predicted."""
        try:
            return retuned(confirm, estimate.model, model, estimate.paths, quick=quick) if confirm else None
        except (DivergedError, ValueError):
            return None

    confirm_evidence = elsewhere()
    levels = [discrepancy_source(log, nominal.model) for log in logs]
    tuned_nominal = tuned_before = with_levels(nominal.model, nominal.paths, levels)
    by_loop: bool | None = None
    added: list[Added] = []
    refused: list[tuple[Finding, str]] = []
    unpaid: set[str] = set()  # of the refused, those that nothing speaks against but what became of the model
    nominal_evidence = evidence
    left: list[Shape] = []
    first_shapes: list[Shape] = []
    while True:
        progress(f"scanning, effect {len(added) + 1}")
        findings, faint = told_apart(profiled(evidence, scan(evidence)))
        looked_at, left = evidence, shapes(evidence)
        first_shapes = first_shapes or with_events(evidence, left)
        # A strong effect in the residual is taken for noise by the filters: look again without the best explanation.
        best = max(findings, key=lambda f: f.score, default=None)
        if best is not None and best.log_p_value < 0.6 * DETECTED:
            raw, evidence = evidence, cleaned(evidence, best)
            near = {f.name for f in findings if f.score > best.score - AGAIN and f.log_p_value < POSSIBLE}
            sharper, still_faint = told_apart(profiled(raw, scan(evidence, sorted(near))))
            findings = [*sharper, *(f for f in findings if f.name not in near)]
            faint = [*still_faint, *(f for f in faint if f.name not in near)]
        names = {one.finding.name for one in added}
        if len(added) == TERMS_MAX:
            break
        wrong_map = None if free_map else map_error(estimate, evidence)
        # Re-tuning comes first.
        if wrong_map is not None and wrong_map.rivals(max((f.score for f in findings), default=0.0), RIVAL):
            return search(logs, model, confirm, progress, replay, free_map=True)
        barred = {finding.name for finding, _ in refused}
        if len(names) == EFFECTS_MAX:  # further harmonics of what was found may still come
            barred |= set(EFFECTS) - names
        barred |= {name for name in names if sum(one.finding.name == name for one in added) == HARMONICS_MAX}
        step = None
        power = low_power(evidence)
        other_power = low_power(confirm_evidence) if confirm_evidence is not None else 0.0
        worth = worths(estimate, evidence, findings)
        for finding in sorted(findings, key=lambda f: -worth.get(f.name, f.score if not worth else 0.0)):
            if finding.log_p_value > (HINTED if confirm else DETECTED) or finding.name in barred:
                continue
            if is_rounding(finding, faint):
                continue
            check = confirmation(confirm_evidence, finding)
            if confirm and check is None:  # the other logs cannot be predicted: they show nothing
                check = Confirmation(0.0, 0.0, 0.0)
            if not is_seen(finding, check, power, other_power):
                continue
            if check is not None and check.refuted:
                refused.append((finding, f"other motion shows {check.ratio:.2f} of what was foreseen"))
                continue
            if check is not None and check.noncentrality < INFORMATIVE and finding.log_p_value > needed(finding):
                refused.append((finding, f"the other motion cannot show it (lambda {check.noncentrality:.1f})"))
                continue
            if check is None or check.confirmed:
                step = (finding, check)
                break
            step = step or (finding, check)  # what other motion cannot show waits for what it does
        if step is None:
            break
        finding, check = step
        step_rivals, chosen, check = choose(findings, finding, check, confirm_evidence, barred - unpaid, worth, unpaid)
        try:
            progress(f"adding {chosen.name}")
            fitted = refit(estimate, chosen, evidence, len(model.effects))
        except (DivergedError, ValueError) as error:
            refused.append((chosen, f"the model with it cannot be fitted: {error}"))
            unpaid.add(chosen.name)
            continue
        tuned = with_levels(fitted.model, nominal.paths, levels)
        if confirm and (check is None or check.turn == 0.0):
            kept = with_levels_of(tuned_before, fitted.model, nominal.paths)
            if by_loop is None:
                by_loop = replay and follows(discrepancies(logs, [tuned_nominal], replay=True)[0], logs, tuned_nominal)
            tuned_or_none, growth = that_pays(logs, confirm, tuned_before, tuned, kept, by_loop)
            if tuned_or_none is None:
                refused.append((chosen, growth))
                unpaid.add(chosen.name)
                continue
            tuned = tuned_or_none
        estimate, tuned_before = fitted, tuned
        or_map = wrong_map is not None and wrong_map.rivals(
            step_rivals[0].score, max(2.0 * RIVAL, FORM * wrong_map.statistic)
        )
        added.append(
            Added(chosen, step_rivals, [*left, *modulated_look_alikes(evidence, chosen)], check, tuned, or_map)
        )
        evidence = gather(estimate, evidence.sources, memory=evidence.memory)
        confirm_evidence = elsewhere()
    known = left if evidence is looked_at else ()
    left = with_events(evidence, shapes(evidence, plain=True, known=known))
    return Search(
        nominal,
        nominal_evidence,
        tuned_nominal,
        estimate,
        evidence,
        added,
        refused,
        first_shapes,
        left,
        findings,
        confirm_evidence,
    )


def told_apart(findings: Sequence[Finding]) -> tuple[list[Finding], list[Finding]]:
    """Findings, and those that rounding may have made."""
    return [f for f in findings if not f.faint], [f for f in findings if f.faint]


def is_rounding(finding: Finding, faint: Sequence[Finding]) -> bool:
    """Whether a wave in the reading that rounding may have made explains more of what a finding does."""
    return any(other.score > finding.score and alike(other, finding) > LIKE for other in faint)


def is_seen(finding: Finding, check: Confirmation | None, power: float, other_power: float) -> bool:
    """Whether an effect stands out of the logs, or of both motions together, and is worth a name there.

    Args:
        finding: in the logs.
        check: on the other motion.
        power, other_power: of the residuals below 60 Hz, of the logs and of the other motion (low_power).
    """
    if finding.log_p_value <= DETECTED:
        return finding.test.statistic >= WORTH * power
    if check is None or finding.log_p_value + check.log_p_value > JOINT:
        return False
    return check.shown >= WORTH * other_power


def needed(finding: Finding) -> float:
    """ln of the chance by which an effect must stand out where the confirm logs cannot show it."""
    effect = EFFECTS[finding.name]
    return SLIPPERY if acts_in_interval(effect) or "friction_level" in effect.HOOKS else UNSHOWN


def with_levels_of(before: Model, model: Model, paths: Sequence[str]) -> Model:
    """A model with the levels that it had before something was added."""
    known = parameters_of(before, together=True)
    return with_values(model, {path: known[path].value for path in paths if not path.startswith("effects.")})


def that_pays(
    logs: Sequence[Log], confirm: Sequence[Log], before: Model, tuned: Model, kept: Model, replay: bool = False
) -> tuple[Model | None, str]:
    """The model with which the gap on the confirm logs does not grow: its levels re-tuned, or as they were before.

    Levels that are tuned with an effect follow what is particular to the logs they are tuned on; the effect itself may
    then pay where it is added alone. None, and why, where it does not pay either way. The gap is that of the replayed
    loop where it is asked for (`replay`) and can be had.
    """
    other = discrepancies(confirm, [before, tuned, kept], replay=replay)
    if other[1].rms <= PAYS * other[0].rms:
        return tuned, ""
    if other[2].rms < other[0].rms:
        own = discrepancies(logs, [before, kept], replay=replay)
        if own[1].rms <= PAYS * own[0].rms:
            return kept, ""
    return None, f"the gap on the other motion grows from {other[0].rms:.4g} to {other[1].rms:.4g} V with it"


def worths(estimate: Estimate, evidence: Evidence, findings: Sequence[Finding]) -> dict[str, float]:
    """What each effect explains of the gap itself, as T of rows that are not whitened; empty where none stands out.

    Where the evidence is overwhelming, every imperfection of the model is significant: then that is the order to take.
    """
    if max((f.score for f in findings), default=0.0) < OVERWHELMING:
        return {}
    plain = gather(estimate, evidence.sources, memory=evidence.memory, plain=True)
    worth = {}
    for finding in findings:
        if finding.log_p_value < DETECTED:
            again = judged(plain, [finding.candidate], 1.0)
            worth[finding.name] = again[0].test.statistic if again else 0.0
    return worth


def choose(
    findings: Sequence[Finding],
    best: Finding,
    check: Confirmation | None,
    confirm_evidence: Evidence | None,
    barred: set[str],
    worth: dict[str, float],
    unpaid: Collection[str] = (),
) -> tuple[list[Finding], Finding, Confirmation | None]:
    """Of the effects that explain about as much, the one that both motions favour; and those within reach of it.

    One that was refused because it does not pay (`unpaid`) is not chosen again, but what comes in its place may be it.
    """
    reach = max(REACH, FORM * best.test.statistic)
    seen = NEAR_BEST if best.log_p_value < DETECTED else POSSIBLE
    near = [
        f
        for f in findings
        if f is best
        or (f.score > best.score - reach and f.name not in barred and f.log_p_value < seen and alike(f, best) > LIKE)
    ]
    checks = {f.name: check if f is best else confirmation(confirm_evidence, f) for f in near}

    def gain(f: Finding) -> float:
        c = checks[f.name]
        return 0.0 if c is None else float(np.clip(c.gain, -60.0, None))

    standing = [f for f in near if f is best or not (checks[f.name] is not None and checks[f.name].refuted)]  # type: ignore[union-attr]
    ranked = sorted(standing, key=lambda f: worth.get(f.name, 0.0 if worth else f.score) + gain(f), reverse=True)
    chosen = plainer([f for f in ranked if f.name not in unpaid or f is best])
    top = max(f.score + gain(f) for f in ranked)
    rivals = [
        replace(chosen, score=top),
        *(replace(f, score=f.score + gain(f)) for f in ranked if f is not chosen),
    ]
    return rivals, chosen, checks[chosen.name]


def plainer(ranked: Sequence[Finding]) -> Finding:
    """The likeliest finding, or a plainer one that explains nearly as much.

    Many amplitudes along the travel always explain more: an effect of one or two that explains nearly all of it comes
    first, and of a period that the model has not, the plain wave that is most of it.
    """
    first = ranked[0]
    if len(first.candidate.amplitudes) > MANY:
        for other in ranked[1:]:
            if len(other.candidate.amplitudes) <= 2 and other.test.statistic > NEARLY * first.test.statistic:
                return other
    periods = [first.candidate.shape[f] for f in first.candidate.shape if f == "period"]
    if not periods or is_wave(EFFECTS[first.name]) or len(first.candidate.amplitudes) <= 2:
        return first
    for other in ranked[1:]:
        if is_spatial_wave(EFFECTS[other.name]) and EFFECTS[other.name].HOOKS == EFFECTS[first.name].HOOKS:
            (period,) = other.candidate.shape.values()
            if abs(period / periods[0] - 1.0) < SAME and other.test.statistic > MOSTLY * first.test.statistic:
                return other
    return first


def alike(one: Finding, other: Finding) -> float:
    """Cosine between the parts of the residual that two findings explain."""
    return cosine(one.test.explained, other.test.explained)
