"""One blind case: a machine, two motions, hidden effects scaled to a stated identifiable ratio, and the key to it."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .hidden import Hidden
from .identifiable import START, Signal, signatures
from .machines import Machine, draw_machine
from .motions import Motion
from .outside import OUTSIDE
from .truth import Plan, Run
from .vocabulary import CHANGES, VOCABULARY

LAMBDAS = (10.0, 30.0, 100.0, 300.0, 1000.0)
TOLERANCE = 0.1  # of lambda
ATTEMPTS = 25
#: Fields of the machine that the key holds.
TRAITS = ("law", "colour", "stated_controller", "poor_motion", "jitter", "rate", "peak", "noise")
SECTION = {"mass_change": "mass", "viscous_change": "viscous", "coulomb_change": "coulomb"}
SMOOTH_LAWS = ("tanh", "algebraic", "arctangent", "mixture", "ramp")
#: Effects that need rigid friction or one mass: which friction laws their machines may have.
LAWS_OF = {"presliding_friction": ("bristle",), "backlash": SMOOTH_LAWS, "flexible_mode": SMOOTH_LAWS}


@dataclass(frozen=True)
class Specification:
    """What a case shall hold: `kind` is null, effect, outside, pair, triple or large; names may be empty for a null.

    Attributes:
        family: of nulls (machines.NULL_FAMILIES); "plain" draws everything.
        ratio: lambda of each effect.
    """

    kind: str
    names: tuple[str, ...] = ()
    ratio: float = 0.0
    family: str = "plain"


@dataclass
class Case:
    """A drawn case: plans and runs of both logs, the key, and factors of units on the columns of the logs."""

    machine: Machine
    main: Plan
    main_run: Run
    confirm: Plan
    confirm_run: Run
    base: Plan
    hidden: list[tuple[Hidden, float]]
    key: dict[str, Any] = field(default_factory=dict)
    factors: dict[str, float] = field(default_factory=dict)


class Unreachable(ArithmeticError):
    """The ratio cannot be reached within the physical range of this effect on this machine."""


def draw_case(seed: list[int], specification: Specification) -> Case:
    """Draw a case; machines on which the ratio cannot be reached are drawn again.

    Raises:
        Unreachable: no machine in ATTEMPTS draws fits.
    """
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng([*seed, attempt])
        try:
            case = _try_case(rng, specification)
        except ArithmeticError:
            continue
        case.key["attempts"] = attempt + 1
        return case
    raise Unreachable(f"{specification}: no machine in {ATTEMPTS} draws reaches it")


def scale(measure: Callable[[float], float], hidden: Hidden, ratio: float) -> tuple[float, float]:
    """Find the amplitude at which measure(amplitude) is ratio within TOLERANCE: secant in both logarithms.

    Raises:
        Unreachable: not within 10 steps, or outside the physical range.
    """
    amplitude, slope = min(max(hidden.start, hidden.low), hidden.high), 2.0
    before: tuple[float, float] | None = None
    at_edge = 0
    for _ in range(10):
        try:
            value = measure(amplitude)
        except ArithmeticError:  # so large that the loop is unstable
            hidden.high = amplitude
            amplitude = 0.3 * amplitude if before is None else np.sqrt(amplitude * before[0])
            continue
        if abs(value / ratio - 1) < TOLERANCE:
            return amplitude, value
        value = max(value, 1e-6 * ratio)
        if before is not None and amplitude != before[0]:
            slope = np.log(value / before[1]) / np.log(amplitude / before[0])
            slope = min(max(slope, 0.3), 12.0) if np.isfinite(slope) else 2.0
        before = (amplitude, value)
        step = np.clip(np.log(ratio / value) / slope, -3.0, 3.0)
        amplitude = min(max(amplitude * np.exp(step), hidden.low), hidden.high)
        if amplitude in (hidden.low, hidden.high):
            at_edge += 1
            if at_edge > 2:
                break
    raise Unreachable(f"{hidden.name}: ratio {ratio:g} not reached")


def _try_case(rng: np.random.Generator, specification: Specification) -> Case:
    names, ratio = specification.names, specification.ratio
    laws = [set(LAWS_OF[name]) for name in names if name in LAWS_OF]
    law = None
    if laws:
        common = sorted(set.intersection(*laws))
        if not common:
            raise Unreachable("no friction law fits both effects")
        law = str(rng.choice(common))
    machine = draw_machine(rng, specification.family, tight=bool(set(names) & set(CHANGES)), law=law)

    def moved() -> tuple[Motion, Plan]:
        time, motion = machine.draw_motion(rng)
        return motion, machine.plan(rng, motion, time)

    motion, base = moved()
    _sane_run(base, motion, machine)
    hidden: list[tuple[Hidden, float]] = []
    truths: list[dict[str, Any]] = []
    signal = Signal(base, machine)
    for name, seed in zip(names, rng.integers(2**31, size=len(names)), strict=True):
        draws = np.random.default_rng(int(seed))
        if name in CHANGES:
            effect, amplitude, value = _change(draws, name, machine, signal, ratio)
        else:
            effect = {**VOCABULARY, **OUTSIDE}[name](draws, machine, motion)

            def measure(amplitude: float, effect: Hidden = effect) -> float:
                return signal.ratio(signal.difference(with_hidden(base, [(effect, amplitude)])))

            amplitude, value = scale(measure, effect, ratio)
        hidden.append((effect, amplitude))
        truths.append(key_entry(effect, amplitude, value))
    if len(names) > 1:
        _require_separable(signal, base, hidden, truths, ratio)
    main = with_hidden(base, hidden)
    main_run = _sane_run(main, motion, machine)
    motion, confirm_base = moved()
    confirm = with_hidden(confirm_base, hidden)
    confirm_run = _sane_run(confirm, motion, machine)
    moving, quiet = np.abs(motion.velocity) > 1e-4, confirm.silent().run().command
    noise = (confirm_run.command - quiet)[moving]
    key = {"kind": specification.kind, "family": specification.family, "ratio": ratio, "effects": truths}
    key |= {name: getattr(machine, name) for name in TRAITS}
    key |= {"law_ratio": signal.law_ratio(), "confirm_floor": _rms(noise)}
    if hidden:
        fixed = tuple(SECTION[name] for name in names if name in SECTION)
        steps = signal.absorbed(signal.difference(main), fixed)
        key |= _closable(steps, confirm_base.silent(), machine, quiet, moving, noise)
    return Case(machine, main, main_run, confirm, confirm_run, base, hidden, key)


def _change(
    rng: np.random.Generator, name: str, machine: Machine, signal: Signal, ratio: float
) -> tuple[Hidden, float, float]:
    """A change of mass, viscous or Coulomb of at least 5 stated sigma.

    The change is that from the model's value to the truth's, which is what `diagnose` can see. Its lambda is
    change^2 / (stated sigma^2 + sigma of this log^2), the test of the change against what is stated.
    """
    section = SECTION[name]
    stated, own = machine.uncertainty[section], signal.deviation(section)
    deviation = float(np.hypot(stated, own))
    size = max(np.sqrt(ratio) * deviation, 5 * stated)
    sign = 1.0 if name == "mass_change" and rng.random() < 0.7 else float(rng.choice([-1.0, 1.0]))
    change = sign * size
    if not -0.6 < change < 1.5:
        raise Unreachable(f"{name}: {change:g} is no physical change")
    nominal = machine.model["axis"][section]
    fields = {"change": (lambda a: sign * a, "", lambda a: own * size / deviation / a)}
    effect = Hidden(size, 0.0, 2.0, lambda plan, a: plan.set(**{section: nominal * (1 + sign * a)}), fields, name=name)
    return effect, size, float((size / deviation) ** 2)


def with_hidden(base: Plan, hidden: list[tuple[Hidden, float]]) -> Plan:
    """A copy of a plan with effects of these amplitudes."""
    plan = base.copy()
    for effect, amplitude in hidden:
        effect.apply(plan, amplitude)
    return plan


def key_entry(effect: Hidden, amplitude: float, ratio: float, **more: float) -> dict[str, Any]:
    """Return the key's entry of an effect; a parameter's deviation is the Cramer-Rao bound, where it is simple."""
    parameters = {
        name: {"value": float(true), "unit": unit}
        | {"deviation": None if share is None or not ratio else float(abs(true) * share / np.sqrt(ratio))}
        for name, (true, unit, share) in effect.parameters(amplitude).items()
    }
    known = {"name": effect.name, "shape": effect.shape, "amplitude": float(amplitude), **more, "ratio": ratio}
    known |= {"in_vocabulary": effect.name not in OUTSIDE, "tolerated": list(effect.tolerated)}
    return known | {"parameters": parameters}


def _closable(
    steps: dict[str, float], silent: Plan, machine: Machine, quiet: np.ndarray, moving: np.ndarray, noise: np.ndarray
) -> dict[str, float]:
    """What the true model closes on the confirm log, to first order, beyond a nominal model re-tuned on the main log.

    `confirm_effect` is the rms of the effect, `confirm_rest` that of what re-tuning by `steps` leaves, both without
    noise (command unit, rows in motion); `confirm_closable` the mean square that the truth removes from this very log,
    noise included. `silent` is the plan without effect and noise, `quiet` the command without noise.
    """
    command = silent.run().command
    columns = signatures(silent, machine, command)
    effect = quiet - command
    rest = (effect - sum(step * columns[name] for name, step in steps.items() if name not in START))[moving]
    closable = float(np.mean((rest + noise) ** 2 - noise**2))
    return {"confirm_effect": _rms(effect[moving]), "confirm_rest": _rms(rest), "confirm_closable": closable}


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _require_separable(
    signal: Signal, base: Plan, hidden: list[tuple[Hidden, float]], truths: list[dict[str, Any]], ratio: float
) -> None:
    """Each effect keeps half of its ratio beside the others."""
    full = signal.difference(with_hidden(base, hidden))
    alone = [signal.difference(with_hidden(base, [one])) for one in hidden]
    for index, entry in enumerate(truths):
        others = [one for i, one in enumerate(hidden) if i != index]
        own = full - signal.difference(with_hidden(base, others))
        entry["ratio_beside"] = signal.ratio(own, *(d for i, d in enumerate(alone) if i != index))
        if entry["ratio_beside"] < 0.5 * ratio:
            raise Unreachable(f"{entry['name']}: hidden by the other effect")


def _sane_run(plan: Plan, motion: Motion, machine: Machine) -> Run:
    """A run that follows its reference, as a machine that is in use does."""
    run = plan.run()
    error = np.abs(run.reading - motion.position).max()
    if not (error < 0.03 * machine.length and np.abs(run.command).max() < 4 * machine.peak):
        raise ArithmeticError("the loop does not follow")
    return run
