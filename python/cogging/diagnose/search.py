"""The search for missing effects: scan, confirm, add, and look again at what is left."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cogging._core import EFFECTS, DivergedError
from cogging.diagnose.chances import log_survival
from cogging.diagnose.evidence import Evidence, gather
from cogging.diagnose.gap import gaps
from cogging.diagnose.gap import source_of as gap_source
from cogging.diagnose.levels import with_levels
from cogging.diagnose.null import fit_null, nuisances, sources_of, width_floor
from cogging.diagnose.rest import Shape, low_power, shapes
from cogging.diagnose.scan import Finding, cleaned, in_range, judged, profiled, scan
from cogging.diagnose.signatures import quantities, tables
from cogging.diagnose.spells import is_spell
from cogging.diagnose.waves import is_spatial_wave, is_wave
from cogging.estimation import Estimate, fit
from cogging.logs import Log
from cogging.model import Model
from cogging.parameters import effect_paths, parameters_of, role_of

FloatArray = npt.NDArray[np.float64]

#: Thresholds, frozen before a seed is drawn for a report (see tests/blind/seeds.toml).
#: ln of the chance that noise shows as much anywhere in one effect's scan: some 20 effects, 0.15 % in all.
DETECTED = -9.5
SUSPECTED = -6.0  # the same for what the confirm logs show by themselves
PAYS = 1.01  # times the gap on the confirm logs, which an effect may not make larger
GAIN = 6.0  # of 2 ln likelihood with frozen amplitudes, from which they do
UNSHOWN = -20.0  # the same for what the confirm logs cannot show
LEFT_OVER = -12.0  # the same for a generic shape: it also catches what friction laws differ by
RIVAL = 2.0 * np.log(100.0)  # of the penalised 2 ln likelihood: a rival closer than this is an alternative
INFORMATIVE = 10.0  # lambda that the confirm logs must be able to show, for their silence to count
CHANGED = 4.2  # stated and found deviations together, beyond which mass, viscous or Coulomb friction has changed
WORTH = 0.01  # of the residual's power below 60 Hz: an effect that explains less is not worth a name
OVERWHELMING = 1000.0  # score beyond which effects are taken in the order of what they are worth
VANISHING = 1e-3  # of the command: a force below it is as good as none
SAME = 0.01  # of a period
MOSTLY = 0.7  # of T
AGAIN = 150.0  # of the score: what is farther from the best is not looked at a second time
EFFECTS_MAX = 4
TERMS_MAX = 6


@dataclass(frozen=True)
class Confirmation:
    """An effect with frozen amplitudes on motion that had no part in the choice.

    Attributes:
        foreseen: lambda that this motion can show.
        ratio: of what it shows over what was foreseen, 1 where the effect is right.
        gain: of 2 ln likelihood.
        turn: rad, by which a wave had to be turned: the logs' zeros of position or time differ.
    """

    foreseen: float
    ratio: float
    gain: float
    turn: float = 0.0

    @property
    def deviation(self) -> float:
        """1-sigma of the ratio, 0.15 at least for amplitudes that are estimates themselves."""
        return float(np.hypot(1.0 / np.sqrt(max(self.foreseen, 1e-9)), 0.15))

    @property
    def refuted(self) -> bool:
        """Whether the other motion speaks against it: it shows far less or more than foreseen, or is worse off."""
        far = 3.0 * self.deviation if self.ratio < 1.0 else 5.0 * self.deviation
        return self.foreseen >= INFORMATIVE and (abs(self.ratio - 1.0) > far or self.gain <= 0.0)

    @property
    def sure(self) -> bool:
        """Whether the other motion alone would be evidence: by chance, 1 of 300 effects gains as much there."""
        return self.confirmed and self.gain > GAIN

    @property
    def confirmed(self) -> bool:
        """Whether the other motion shows it."""
        return self.foreseen >= INFORMATIVE and not self.refuted


@dataclass
class Added:
    """An effect that was accepted, and what stood against it.

    Attributes:
        finding: as the scan found it.
        rivals: it and what explains about as much, the likeliest first.
        shapes: generic shapes of what was missing before it.
        confirmation: on other motion; None without.
        model: refitted with it, with levels tuned to its gap.
    """

    finding: Finding
    rivals: list[Finding]
    shapes: list[Shape]
    confirmation: Confirmation | None
    model: Model


@dataclass
class Search:
    """All that was found on the way.

    Attributes:
        nominal: fit of the model as it was given, and its evidence.
        tuned: the nominal model with levels tuned to its gap (with_levels).
        estimate: fit with all that was added, and its evidence.
        added, refused: effects in the order in which they were tried; the refused with the reason.
        first_shapes, left: generic shapes of what is missing in the nominal and in the last model.
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
    first_shapes: list[Shape]
    left: list[Shape]
    unused: list[Finding]
    confirm_evidence: Evidence | None


def search(
    logs: Sequence[Log],
    model: Model,
    confirm: Sequence[Log] = (),
    progress: Callable[[str], None] = lambda step: None,
) -> Search:
    """Scan, add what stands, until nothing significant is left or as many as can be told were added."""
    progress("re-tuning the model")
    nominal, evidence = fit_null(logs, model)
    confirm_evidence = None
    if confirm:
        try:
            confirm_evidence = retuned(confirm, nominal.model, model)
        except (DivergedError, ValueError):
            confirm_evidence = None
    estimate = nominal
    levels = [gap_source(log, nominal.model) for log in logs]
    tuned_nominal = tuned_before = with_levels(nominal.model, nominal.paths, levels)
    added: list[Added] = []
    refused: list[tuple[Finding, str]] = []
    nominal_evidence = evidence
    left: list[Shape] = []
    first_shapes: list[Shape] | None = None
    findings: list[Finding] = []
    while True:
        progress(f"scanning, effect {len(added) + 1}")
        findings = profiled(evidence, scan(evidence))
        # A strong effect in the residual is taken for noise by the filters: look again without the best explanation.
        left = shapes(evidence)
        first_shapes = left if first_shapes is None else first_shapes
        best = max(findings, key=lambda f: f.score, default=None)
        if best is not None and best.log_chance < 0.6 * DETECTED:
            raw, evidence = evidence, cleaned(evidence, best)
            near = {f.name for f in findings if f.score > best.score - AGAIN and f.log_chance < -1.5}
            sharper = profiled(raw, scan(evidence, sorted(near)))
            findings = [*sharper, *(f for f in findings if f.name not in near)]
        names = {one.finding.name for one in added}
        if len(added) == TERMS_MAX:
            break
        barred = {finding.name for finding, _ in refused}
        if len(names) == EFFECTS_MAX:  # further harmonics of what was found may still come
            barred |= set(EFFECTS) - names
        step = None
        power = low_power(evidence)
        for finding in by_worth(estimate, evidence, findings):
            if finding.log_chance > SUSPECTED or finding.name in barred or finding.test.statistic < WORTH * power:
                continue
            check = confirmation(confirm_evidence, finding)
            if finding.log_chance > DETECTED and not (check is not None and check.sure):
                continue
            if check is not None and check.refuted:
                refused.append((finding, f"other motion shows {check.ratio:.2f} of what was foreseen"))
                continue
            if check is not None and check.foreseen < INFORMATIVE and finding.log_chance > UNSHOWN:
                refused.append((finding, f"the other motion cannot show it (lambda {check.foreseen:.1f})"))
                continue
            if check is None or check.confirmed:
                step = (finding, check)
                break
            step = step or (finding, check)  # what other motion cannot show waits for what it does
        if step is None:
            break
        finding, check = step
        step_rivals, chosen, check = choose(evidence, findings, finding, check, confirm_evidence, barred)
        try:
            progress(f"adding {chosen.name}")
            fitted = refit(estimate, chosen, evidence, len(model.effects))
        except (DivergedError, ValueError) as error:
            refused.append((chosen, f"the model with it cannot be fitted: {error}"))
            continue
        tuned = with_levels(fitted.model, nominal.paths, levels)
        if confirm and (check is None or check.turn == 0.0):
            worse = gaps(confirm, [tuned_before, tuned], replay=False)
            if worse[1].rms > PAYS * worse[0].rms:
                reason = f"the gap on the other motion grows from {worse[0].rms:.4g} to {worse[1].rms:.4g} V with it"
                refused.append((chosen, reason))
                continue
        estimate, tuned_before = fitted, tuned
        added.append(Added(chosen, step_rivals, left, check, tuned))
        evidence = gather(estimate, evidence.sources, memory=evidence.memory)
        if confirm_evidence is not None:
            try:
                confirm_evidence = retuned(confirm, estimate.model, model)
            except (DivergedError, ValueError):
                confirm_evidence = None
    return Search(
        nominal,
        nominal_evidence,
        tuned_nominal,
        estimate,
        evidence,
        added,
        refused,
        first_shapes or left,
        left,
        findings,
        confirm_evidence,
    )


def by_worth(estimate: Estimate, evidence: Evidence, findings: Sequence[Finding]) -> list[Finding]:
    """The findings in the order in which to take them: the likeliest first.

    Where the evidence is overwhelming, every imperfection of the model is significant: then what makes most of the gap.
    """
    ranked = sorted(findings, key=lambda f: -f.score)
    if not ranked or ranked[0].score < OVERWHELMING:
        return ranked
    plain = gather(estimate, evidence.sources, memory=evidence.memory, plain=True)
    worth = {}
    for finding in ranked:
        if finding.log_chance < DETECTED:
            again = judged(plain, [finding.candidate], 1.0)
            worth[finding.name] = again[0].test.statistic if again else 0.0
    return sorted(ranked, key=lambda f: -worth.get(f.name, 0.0))


def choose(
    evidence: Evidence,
    findings: Sequence[Finding],
    best: Finding,
    check: Confirmation | None,
    confirm_evidence: Evidence | None,
    barred: set[str],
) -> tuple[list[Finding], Finding, Confirmation | None]:
    """Of the effects that explain about as much, the one that both motions favour; and those within reach of it."""
    near = [
        f
        for f in findings
        if f is best
        or (f.score > best.score - 60.0 and f.name not in barred and f.log_chance < -5.0 and alike(f, best) > 0.5)
    ]
    checks = {f.name: check if f is best else confirmation(confirm_evidence, f) for f in near}

    def total(f: Finding) -> float:
        c = checks[f.name]
        return f.score + (0.0 if c is None else float(np.clip(c.gain, -60.0, None)))

    standing = [f for f in near if f is best or not (checks[f.name] is not None and checks[f.name].refuted)]  # type: ignore[union-attr]
    ranked = sorted(standing, key=total, reverse=True)
    chosen = plainer(ranked)
    top = total(ranked[0])
    rivals = [replace(chosen, score=top), *(replace(f, score=total(f)) for f in ranked if f is not chosen)]
    return rivals, chosen, checks[chosen.name]


def plainer(ranked: Sequence[Finding]) -> Finding:
    """The likeliest finding; the wave in it where it is one of changing amplitude that is mostly a plain wave.

    Many amplitudes along the travel always explain more; of a period that the model has not, the wave comes first.
    """
    first = ranked[0]
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
    a, b = one.test.explained, other.test.explained
    size = float(np.sqrt((a @ a) * (b @ b)))
    return abs(float(a @ b)) / size if size > 0.0 else 0.0


def retuned(logs: Sequence[Log], model: Model, given: Model) -> Evidence:
    """Evidence of other logs under a model whose nuisances are re-tuned on them, what was added as it is.

    Effects that the given model has are re-tuned too: they may have stood in for what was added.
    """
    own = [prefix for prefix, _ in effect_paths(model.effects)[: len(given.effects)]]
    paths = [p for p in nuisances(model) if not p.startswith("effects.") or p.rpartition(".")[0] in own]
    sources = sources_of(logs, model)
    return gather(fit(model, paths, sources, iterations=4, floors=width_floor(sources)), sources)


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
    turns = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False) if is_wave(EFFECTS[finding.name]) else [0.0]
    best = Confirmation(0.0, 0.0, -np.inf)
    for turn in turns:
        amplitudes = finding.amplitudes
        if turn:
            turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
            amplitudes = turned @ amplitudes
        foreseen = amplitudes @ columns
        size = float(foreseen @ foreseen) / evidence.excess
        if size <= 0.0:
            continue
        score = -float(foreseen @ evidence.free_residual) / evidence.excess
        gain = 2.0 * score - size - (0.0 if turn == 0.0 else 4.0)
        if gain > best.gain:
            best = Confirmation(size, score / size, gain, float(turn))
    if not np.isfinite(best.gain):
        return Confirmation(0.0, 0.0, 0.0)
    if best.refuted and is_spell(EFFECTS[finding.name]):  # what happened once need not happen again
        return Confirmation(0.0, 0.0, min(best.gain, 0.0))
    return best


def refit(estimate: Estimate, finding: Finding, evidence: Evidence, given: int) -> Estimate:
    """Fit the model with the effect in it: nuisances, amplitudes, and shapes that are numbers.

    Of the effects that the model was `given`, the amplitudes are fitted, as they are without anything added.
    """
    model = estimate.model.replace(effects=(*estimate.model.effects, finding.effect()))
    own = {prefix for prefix, _ in effect_paths(model.effects)[:given]}
    paths = [p for p in estimate.paths if not p.startswith("effects.")]
    paths += [
        p for p in effect_parameters(model) if p.rpartition(".")[0] not in own or role_of(model, p) == "amplitude"
    ]
    floors, ceilings = shape_limits(model, evidence)
    floors |= width_floor(evidence.sources)
    fitted = fit(model, paths, evidence.sources, iterations=8, floors=floors, ceilings=ceilings)
    sizes = quantities(evidence)
    for effect in fitted.model.effects[given:]:
        for name, role in effect.ROLES.items():
            value = getattr(effect, name)
            if role["role"] == "amplitude" and np.max(np.abs(value)) > 1.01 * role["high"] * sizes[role["quantity"]]:
                raise ValueError(f"its {name} runs to {np.max(np.abs(value)):.3g}")
            if role["role"] == "shape" and isinstance(value, float) and not in_range(evidence, role, value):
                # The shape runs off where the log does not hold it: shapes stay where the scan found them.
                held = [p for p in paths if p not in shape_paths(model)]
                return fit(model, held, evidence.sources, iterations=8, floors=floors, ceilings=ceilings)
    return fitted


def shape_limits(model: Model, evidence: Evidence) -> tuple[dict[str, float], dict[str, float]]:
    """Values that shapes keep between while a fit moves them: twice the range in which their effect is looked for.

    An amplitude that has a sign keeps it.

    Beyond it a log holds them no more, and what is stiff (a contact, a mode) would be simulated in ever finer steps.
    """
    floors, ceilings = {}, {}
    sizes = quantities(evidence)
    for prefix, effect in effect_paths(model.effects):
        for name, role in effect.ROLES.items():
            if role["role"] == "shape" and role["quantity"] not in ("position", "time", "exponent"):
                size = sizes[role["quantity"]]
                floors[f"{prefix}.{name}"] = max(0.5 * role["low"], 1e-4 * role["high"]) * size
                ceilings[f"{prefix}.{name}"] = (1.0 if role["quantity"] == "relative" else 2.0) * role["high"] * size
            elif role["role"] == "amplitude" and role["low"] == 0.0:
                floors[f"{prefix}.{name}"] = 0.0
    return floors, ceilings


def shape_paths(model: Model) -> set[str]:
    """Paths of the effects' shapes."""
    return {
        f"{prefix}.{name}"
        for prefix, effect in effect_paths(model.effects)
        for name, role in effect.ROLES.items()
        if role["role"] == "shape"
    }


def effect_parameters(model: Model) -> list[str]:
    """Paths of the effects' amplitudes and shapes that a fit can move."""
    known = parameters_of(model)
    paths = []
    for prefix, effect in effect_paths(model.effects):
        for name, role in effect.ROLES.items():
            value = getattr(effect, name)
            if role["role"] == "setting" or (role["role"] == "shape" and isinstance(value, list)):
                continue
            if role["quantity"] in ("time", "exponent") or (role["quantity"] == "position"):
                continue  # edges and places: where the scan found them
            paths += [p for p in known if p == f"{prefix}.{name}" or p.startswith(f"{prefix}.{name}[")]
    return [p for p in paths if np.isfinite(known[p].value)]


def changes(search_: Search, model: Model) -> list[tuple[str, float, float, float]]:
    """Mass, viscous and Coulomb friction beyond what the model states: (name, change, deviation, how many deviations).

    Shapes of friction close to rest are nuisances here too: what they take up is no change of the level.
    """
    values, covariance = level_estimates(search_.evidence, search_.estimate)
    known = parameters_of(model)
    found = []
    for i, path in enumerate(search_.estimate.paths):
        name = path.removeprefix("axis.")
        if name not in ("mass", "viscous", "coulomb") or model.uncertainty.get(name) is None:
            continue
        prior = getattr(model.axis, name)
        if prior <= VANISHING * search_.evidence.scales.of(known[path].unit):
            continue  # a deviation relative to nothing says nothing
        stated = model.uncertainty[name] * prior
        deviation = float(np.sqrt(covariance[i, i] + stated**2))
        beyond = (values[i] - prior) / deviation if deviation > 0.0 else 0.0
        found.append((name, values[i] / prior - 1.0, float(np.sqrt(covariance[i, i])) / prior, float(beyond)))
    return found


def level_estimates(evidence: Evidence, estimate: Estimate) -> tuple[FloatArray, FloatArray]:
    """Values and covariance of the free parameters with the shapes of slow friction free beside them."""
    columns = evidence.columns
    size = np.sqrt(np.einsum("ij,ij->i", columns, columns))
    size[size == 0.0] = 1.0
    scaled = columns / size[:, None]
    gram = scaled @ scaled.T
    inverse = np.linalg.pinv(gram, rcond=1e-9, hermitian=True)
    step = -(inverse @ (scaled @ evidence.residual)) / size
    p = len(estimate.paths)
    covariance = (inverse / np.outer(size, size) * evidence.excess)[:p, :p]
    return estimate.values + step[:p], covariance


def variance_jumps(evidence: Evidence) -> float:
    """ln of the chance that a white residual's power jumps as high in any three blocks, 0.6 s."""
    worst = 0.0
    for block in range(0, int(evidence.block[-1]) + 1, 3):
        rows = (evidence.block >= block) & (evidence.block < block + 3) & (evidence.residual != 0.0)
        n = int(rows.sum())
        if n < 100:
            continue
        power = float((evidence.free_residual[rows] ** 2).sum())
        worst = min(worst, log_survival(power, n))
    return worst
