"""One case in the large: a machine, a log and one of other motion, the model of its user, and what is true."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import truth
from ..hidden import Hidden
from ..motions import Motion
from ..truth import Plan, Run
from .effects import COUPLED, EFFECTS, SMOOTH_LAWS, TURNING, Scene
from .machines import STATEMENTS, LargeMachine, draw_machine
from .misreadings import KINDS as MISREADINGS
from .misreadings import Columns, Misreading, draw_misreading
from .motions import KINDS, draw_motion

SHARES = (0.3, 0.95)  # of the command's power that the effects make together
ATTEMPTS = 200
MISREAD = 0.2  # share of cases
COUNTS = (0.4, 0.3, 0.2, 0.1)  # chances of one to four effects


@dataclass(frozen=True)
class Truth:
    """What is true of a case.

    Attributes:
        names: of the effects, in the order of their size in the gap.
        sizes: rms of the gap that each makes alone, command unit.
        share: of the power of the command that they make together, in motion.
        parameters: of each effect, by field: value, unit.
        misreading: of the logs, or None.
        machine, kind: what it is, and how it moves.
    """

    names: tuple[str, ...]
    sizes: tuple[float, ...]
    share: float
    parameters: tuple[dict[str, Any], ...]
    misreading: Misreading | None
    machine: LargeMachine
    kind: str


@dataclass(frozen=True)
class Case:
    """What a user has, model as the content of its file, log and confirm by column; and the truth.

    `plan`, `base` are those of the log, with and without the effects.
    """

    model: dict[str, Any]
    log: Columns
    confirm: Columns
    truth: Truth
    plan: Plan
    base: Plan


class NotPhysical(ArithmeticError):
    """A draw that no machine in use would show."""


def draw_case(seed: int, index: int) -> Case:
    """Draw case `index` of a seed: the same whenever, and whatever else is drawn.

    Raises:
        NotPhysical: no draw of ATTEMPTS is one that a machine in use would show.
    """
    rng = np.random.default_rng([seed, index, 0x1A26E])
    cycle = [*EFFECTS, "cogging_harmonic", "cogging_harmonic"]  # what such machines lack most often
    first = cycle[np.random.default_rng([seed, 0x1A26E]).permutation(len(cycle))[index % len(cycle)]]
    misread = str(rng.choice(list(MISREADINGS))) if rng.random() < MISREAD else None
    count = 1 + int(rng.choice(len(COUNTS), p=COUNTS))
    if misread:
        count = int(rng.random() < 0.4)
    for attempt in range(ATTEMPTS):
        draws = np.random.default_rng([seed, index, 0x1A26E, attempt])
        try:
            # what alone cannot make as much on any machine of some dozens gets another beside it
            return _try_case(draws, first, min(count + attempt // 30 * bool(count), len(COUNTS)), misread)
        except ArithmeticError:
            continue
    raise NotPhysical(f"seed {seed}, case {index}: no machine in {ATTEMPTS} draws shows {first} in the large")


def gap(plan: Plan, machine: LargeMachine) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What the machine without effects would not explain, without noise: command, gap, and the rows in motion.

    Raises NotPhysical where none is.

    gap = command - (M a + B v + Fc S(v) - known cogging), from the true states.
    """
    silent = plan.silent()
    run, step = silent.run(), np.diff(silent.instants)
    s = machine.scalars
    acceleration = np.diff(run.velocity) / step
    v = 0.5 * (run.velocity[1:] + run.velocity[:-1])
    x = 0.5 * (run.position[1:] + run.position[:-1])
    needed = s["mass"] * acceleration + s["viscous"] * v + s["coulomb"] * _sign(machine, v) - machine.known_force(x)
    command = run.command[:-1]
    moving = np.abs(v) > 0.05 * np.sqrt(np.mean(v**2))
    if not moving.any():
        raise NotPhysical("the axis never moves")
    return command, command - needed, moving


def _sign(machine: LargeMachine, v: np.ndarray) -> np.ndarray:
    """The friction law of the machine as a function of speed."""
    width = machine.scalars["width"]
    if machine.law == "tanh":
        return np.tanh(v / width)
    if machine.law == "algebraic":
        return v / np.hypot(v, width)
    if machine.law == "arctangent":
        return 2 / np.pi * np.arctan(v / width)
    return np.sign(v)


def power_ratio(plan: Plan, machine: LargeMachine, power: float | None = None) -> float:
    """Power of the gap over that of the command of this run, or over `power`, in motion."""
    command, missing, moving = gap(plan, machine)
    return float(np.mean(missing[moving] ** 2) / (np.mean(command[moving] ** 2) if power is None else power))


def _try_case(rng: np.random.Generator, first: str, count: int, misread: str | None) -> Case:
    kind = str(rng.choice(list(EFFECTS[first][1] if count else KINDS[:4])))
    names = _names(rng, first, kind, count)
    machine = _machine(rng, names, kind)
    closed = kind != "open"
    motion = draw_motion(rng, kind, machine.room, machine.time)
    base = machine.plan(rng, motion, driven=not closed)
    command, _, moving = gap(base, machine)
    speed = float(np.abs(motion.velocity).max()) if closed else float(np.abs(base.silent().run().velocity).max())
    scene = Scene(machine, (float(np.sqrt(np.mean(command[moving] ** 2))), float(np.abs(command).max())), speed)
    hidden = _sized(rng, [EFFECTS[name][0](rng, scene) for name in names], base, scene, 0.5 if misread else SHARES[1])
    plan = _with(base, hidden)
    share = power_ratio(plan, machine) if hidden else 0.0
    if hidden and not SHARES[0] <= share <= SHARES[1]:
        raise NotPhysical(f"{names} make {share:.2f} of the command")
    run = plan.run()
    _require_sane(run, motion, scene, closed=closed)
    other_kind = _other_kind(rng, kind)
    other = draw_motion(rng, other_kind, machine.room, machine.time)
    confirm = _with(machine.plan(rng, other, driven=not closed), hidden)
    confirm_run = confirm.run()
    _require_sane(confirm_run, other, scene, closed=closed)
    sizes = [np.sqrt(power_ratio(_with(base, [one]), machine, 1.0)) for one in hidden]
    largest = np.argsort(sizes)[::-1]
    if hidden and min(sizes) < 0.15 * max(sizes):
        raise NotPhysical("an effect beside which another is nothing")
    reading = draw_misreading(rng, machine, misread) if misread else None
    told = Truth(
        names=tuple(hidden[i][0].name for i in largest),
        sizes=tuple(float(sizes[i]) for i in largest),
        share=share,
        parameters=tuple(_told(*hidden[i]) for i in largest),
        misreading=reading,
        machine=machine,
        kind=kind,
    )
    logs = [_columns(machine, p, r, closed=closed) for p, r in ((plan, run), (confirm, confirm_run))]
    if reading:
        logs = [reading.apply(log) for log in logs]
    return Case(machine.model, logs[0], logs[1], told, plan, base)


def _names(rng: np.random.Generator, first: str, kind: str, count: int) -> list[str]:
    """The first effect and others that the motion shows beside it; a second pitch of cogging is another effect."""
    names = [first] if count else []
    coupled = first in COUPLED
    while len(names) < count:
        name = str(rng.choice([name for name, (_, kinds) in EFFECTS.items() if kind in kinds]))
        again = name in names and (name != "cogging_harmonic" or names.count(name) > 1)
        if again or (name in COUPLED and coupled):
            continue
        coupled = coupled or name in COUPLED
        names.append(name)
    return names


def _machine(rng: np.random.Generator, names: list[str], kind: str) -> LargeMachine:
    statement = str(rng.choice(["tight", "exact"] if "mass_change" in names else list(STATEMENTS)))
    shaken = kind in ("multisine", "open")
    machine = draw_machine(
        rng,
        statement=statement,
        friction=0.15 if shaken else 1.0,
        laws=SMOOTH_LAWS if set(names) & set(COUPLED) else truth.LAWS,
        turning=bool(set(names) & set(TURNING)),
    )
    if kind == "open":
        machine.controller_stated = machine.reference_columns = False
        machine.model.pop("controller", None)
    return machine


def _sized(
    rng: np.random.Generator, drawn: list[Hidden], base: Plan, scene: Scene, most: float
) -> list[tuple[Hidden, float]]:
    """Give each effect the amplitude at which it alone makes its part of the power that is drawn for all."""
    share = rng.uniform(SHARES[0], most)
    parts = rng.dirichlet(np.full(len(drawn), 2.0)) * share / (1 - share) if drawn else []
    power = scene.command[0] ** 2
    return [(one, _amplitude(one, base, scene, power, part)) for one, part in zip(drawn, parts, strict=True)]


def _amplitude(effect: Hidden, base: Plan, scene: Scene, power: float, part: float) -> float:
    """Bisect the logarithm of the amplitude; the most that is physical where that does not suffice."""
    low, high = np.log(effect.low), np.log(effect.high)
    for _ in range(12):
        middle = 0.5 * (low + high)
        try:
            enough = power_ratio(_with(base, [(effect, np.exp(middle))]), scene.machine, power) > part
        except ArithmeticError:
            enough = True
        low, high = (low, middle) if enough else (middle, high)
    return float(np.exp(low))


def _with(base: Plan, hidden: list[tuple[Hidden, float]]) -> Plan:
    plan = base.copy()
    for effect, amplitude in hidden:
        effect.apply(plan, amplitude)
    return plan


def _other_kind(rng: np.random.Generator, kind: str) -> str:
    """Of the confirm log."""
    if kind in ("multisine", "open"):
        return kind
    return str(rng.choice([kind, *KINDS[:4]]))


def _told(effect: Hidden, amplitude: float) -> dict[str, Any]:
    return {name: (value, unit) for name, (value, unit, _) in effect.parameters(amplitude).items()}


def _columns(machine: LargeMachine, plan: Plan, run: Run, *, closed: bool) -> Columns:
    log = {"time": plan.stamps, "position": run.reading, "command": run.command}
    if closed and machine.reference_columns:
        log |= {"reference": plan.rows[:, truth.R_POSITION], "reference_velocity": plan.rows[:, truth.R_VELOCITY]}
        log["reference_acceleration"] = plan.rows[:, truth.R_ACCELERATION]
    return log


def _require_sane(run: Run, motion: Motion, scene: Scene, *, closed: bool) -> None:
    """The axis moves, and a loop follows its reference, as a machine that is in use does."""
    room, resolution = scene.machine.room, scene.machine.scalars["resolution"]
    if np.ptp(run.position) < max(300 * resolution, (0.02 if closed else 1e-4) * room.length):
        raise NotPhysical("the axis hardly moves")
    if np.mean(np.abs(run.velocity) > 0.05 * np.abs(run.velocity).max()) < 0.2:
        raise NotPhysical("the axis moves hardly ever")
    if closed and np.abs(run.reading - motion.position).max() > 0.1 * room.length:
        raise NotPhysical("the loop does not follow")
    if np.abs(run.command).max() > 60 * scene.command[0]:
        raise NotPhysical("the loop rings")


__all__ = ["SHARES", "Case", "NotPhysical", "Truth", "draw_case", "gap", "power_ratio"]
