"""Cases in the large: what the model lacks makes 30 to 95 % of the command; in units of any size, some misread.

A machine of the suite, with more friction, gets one to four effects as large as its command. Its user states mass and
friction loosely, tightly or not at all, has a controller in half of the cases, and may read a column with the wrong
sign or in another unit. A machine of another size is the same one in other units of command, position and time.
"""

from functools import partial
from typing import Any

import numpy as np

from . import truth
from .cases import Case, Specification, Unreachable, key_entry, with_hidden
from .hidden import Hidden, add_map
from .machines import Machine, draw_machine, log_uniform, rounded
from .motions import Motion
from .truth import Plan
from .vocabulary import VOCABULARY

SHARES = (0.3, 0.95)  # of the command's power that the effects make together
ATTEMPTS = 200
MISREAD = 0.2  # share of cases
COUNTS = (0.4, 0.3, 0.2, 0.1)  # chances of one to four effects
SMALLEST = 0.15  # of the largest effect: what is smaller is not hidden beside it
AS_LARGE = 0.8  # of the largest: these may be named first too
FACTOR = 3.0  # of mass and friction where nothing is stated
DEVIATIONS = {"unstated": (), "loose": (0.2, 0.5), "tight": (0.02, 0.08), "exact": (0.0, 0.0)}
#: How much larger than in the usual cases an effect may be, of what is larger at all.
LARGER = dict.fromkeys(("constant_force", "cable_spring", "end_effect", "local_force", "cogging_harmonic"), 20.0)
LARGER |= dict.fromkeys(("disturbance_step", "disturbance_tone", "quadratic_drag", "command_dead_zone"), 20.0)
LARGER |= {"cogging_modulation": 20.0, "force_constant_ripple": 2.0, "force_constant_drift": 2.5, "backlash": 10.0}
SHAKEN = ("flexible_mode", "command_delay", "actuator_lag")  # what a multisine shows
COUPLED = ("flexible_mode", "backlash")  # no two of them on one axis; they need smooth friction
#: What cannot be as large, or is an effect only of a small size.
LEFT_OUT = ("presliding_friction", "encoder_periodic_error", "encoder_scale_error")
LAWS = ("tanh", "algebraic", "arctangent", "bristle", "stick")
POSITIONS = ("position", "reference", "reference_velocity", "reference_acceleration")
#: Powers of the units of command, position and time, by the key of a model file and by the unit of a parameter.
OF_KEYS = {"mass": (1, -1, 2), "viscous": (1, -1, 1), "coulomb": (1, 0, 0), "coulomb_width": (0, 1, -1)}
OF_KEYS |= dict.fromkeys(("travel", "pitch", "periods", "origin", "resolution", "noise"), (0, 1, 0))
OF_KEYS |= dict.fromkeys(("sine", "cosine", "force", "command_limit"), (1, 0, 0))
OF_KEYS |= {"kp": (1, -1, 0), "ki": (1, -1, -1), "kd": (1, -1, 1), "kv": (1, -1, 1)}
OF_KEYS |= dict.fromkeys(("sample_rate", "bandwidth"), (0, 0, -1))
OF_UNITS = {"": (0, 0, 0), "rad": (0, 0, 0), "V": (1, 0, 0), "m": (0, 1, 0), "s": (0, 0, 1), "Hz": (0, 0, -1)}
OF_UNITS |= {"V/m": (1, -1, 0), "m/s": (0, 1, -1), "V/(m/s)": (1, -1, 1), "V/(m/s)^2": (1, -2, 2)}


def gravity(rng: np.random.Generator, machine: Machine, motion: Motion, turn: float) -> Hidden:
    """An unbalanced mass on an axis that turns once in `turn` metres of the drawn machine."""
    angle, peak = rng.uniform(-np.pi, np.pi), machine.peak
    push = add_map("force", lambda plan: -np.sin(2 * np.pi * plan.positions / turn - angle))
    fields = {"moment": (lambda a: a, "V", None), "angle": (angle, "rad", None)}
    return Hidden(peak, 1e-3 * peak, 20 * peak, push, fields, name="gravity")


def mass_change(rng: np.random.Generator, machine: Machine, motion: Motion) -> Hidden:
    """A payload beyond what the model states of its mass."""
    bare, nominal = machine.scalars["mass"], machine.model["axis"]["mass"]
    fields = {"change": (lambda a: bare * (1 + a) / nominal - 1, "", None)}
    return Hidden(1.0, 0.5, 6.0, lambda plan, a: plan.set(mass=bare * (1 + a)), fields, name="mass_change")


NAMES = (*(name for name in VOCABULARY if name not in LEFT_OUT), "gravity", "mass_change")


def draw_large(seed: list[int], specification: Specification) -> Case:
    """Draw a case whose first effect is that of the specification, with others beside it.

    Raises:
        Unreachable: no draw of ATTEMPTS is one that a machine in use would show.
    """
    first = np.random.default_rng([*seed, 0x1A26E])
    misread = bool(first.random() < MISREAD)
    count = 1 + int(first.choice(len(COUNTS), p=COUNTS))
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng([*seed, attempt, 0x1A26E])
        try:
            # what alone cannot make as much on any machine of some dozens gets another beside it
            return _try_case(rng, specification, min(count + attempt // 30, len(COUNTS)), misread=misread)
        except ArithmeticError:
            continue
    raise Unreachable(f"{specification}: no machine in {ATTEMPTS} draws shows it in the large")


def gap(plan: Plan, base: Plan) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Command, what the machine without effects would not explain of it, and the rows in motion, all without noise."""
    silent = plan.silent()
    run = silent.run()
    v = 0.5 * (run.velocity[1:] + run.velocity[:-1])
    x = 0.5 * (run.position[1:] + run.position[:-1])
    law = int(base["law"])
    rigid = law in (truth.STICK, truth.BRISTLES)
    sign = np.sign(v) if rigid else np.vectorize(truth._smooth_sign)(law, v, base["width"], base["share"])
    known = np.interp(x, base.positions, base.maps[truth.M_FORCE])
    needed = base["mass"] * np.diff(run.velocity) / np.diff(silent.instants) + base["viscous"] * v
    needed += base["coulomb"] * sign - known
    moving = np.abs(v) > 0.05 * np.sqrt(np.mean(v**2))
    if not moving.any():
        raise Unreachable("the axis never moves")
    return run.command[:-1], run.command[:-1] - needed, moving


def power_ratio(plan: Plan, base: Plan, power: float | None = None) -> float:
    """Power of the gap over that of the command of this run, or over `power`, in motion."""
    command, missing, moving = gap(plan, base)
    return float(np.mean(missing[moving] ** 2) / (np.mean(command[moving] ** 2) if power is None else power))


def multisine(rng: np.random.Generator, machine: Machine, time: np.ndarray, *, closed: bool) -> Motion:
    """Tones of random phase, even in acceleration, that swell and fade; in open loop the command over the mass."""
    span = float(time[-1])
    lowest, highest = max(0.5, 0.3 * machine.bandwidth / (2 * np.pi)), min(150.0, machine.rate / 6)
    lines = 2 * np.pi * np.unique(np.round(np.geomspace(lowest, max(highest, 3 * lowest), 60) * span)) / span
    size = 0.5 * machine.acceleration * np.sqrt(2 / len(lines))
    angle = np.outer(time, lines) + rng.uniform(0, 2 * np.pi, len(lines))
    inside = np.clip(np.minimum(time, span - time) / (0.04 * span), 0.0, 1.0)
    x = np.zeros_like(time) if not closed else (-size / lines**2 * np.cos(angle)).sum(axis=1)
    x *= inside**3 * (10 - 15 * inside + 6 * inside**2)
    a = (size * np.cos(angle)).sum(axis=1) * inside**2 * (3 - 2 * inside)
    if closed:
        a = np.gradient(np.gradient(x, time), time)
    return Motion(0.5 * sum(machine.travel) + x, np.gradient(x, time), a)


def _stated(rng: np.random.Generator, machine: Machine, statement: str, *, closed: bool) -> None:
    """Let the model be as wrong as it says, and leave out what its user does not have."""
    axis, limits = machine.model["axis"], DEVIATIONS[statement]
    machine.uncertainty = {}
    for name in ("mass", "viscous", "coulomb"):
        wrong = log_uniform(rng, 1 / FACTOR, FACTOR)
        if limits:
            machine.uncertainty[name] = rounded(rng.uniform(*limits), 2)
            wrong = max(1 + machine.uncertainty[name] * float(np.clip(rng.standard_normal(), -1.8, 1.8)), 1 / FACTOR)
        axis[name] = float(machine.scalars[name] / wrong)
    axis["uncertainty"] = machine.uncertainty
    if not limits:
        del axis["uncertainty"]
    machine.stated_controller = closed and bool(rng.random() < 0.5)
    machine.reference_columns = closed and bool(rng.random() < 0.65)
    chances = {"cogging": 0.25, "encoder": 0.6, "noise": 0.4, "controller": machine.stated_controller}
    for name, chance in chances.items():
        if rng.random() >= chance:
            machine.model.pop(name, None)
    if "cogging" not in machine.model:
        machine.sine, machine.cosine = 0.0 * machine.sine, 0.0 * machine.cosine
    if rng.random() < 0.4:
        del axis["travel"]


def _try_case(rng: np.random.Generator, specification: Specification, count: int, *, misread: bool) -> Case:
    names = list(specification.names)
    while len(names) < count:
        name = str(rng.choice(NAMES))
        if name not in names and not (name in COUPLED and set(names) & set(COUPLED)):
            names.append(name)
    shaken = bool(set(names) & set(SHAKEN)) or rng.random() < 0.15
    closed = not (shaken and rng.random() < 0.5)
    laws = LAWS[:3] if set(names) & set(COUPLED) else LAWS
    machine = draw_machine(rng, law=str(rng.choice(laws)), friction=0.5 if shaken else log_uniform(rng, 0.5, 8.0))
    statement = str(rng.choice([key for key in DEVIATIONS if DEVIATIONS[key] or "mass_change" not in names]))
    _stated(rng, machine, statement, closed=closed)
    machine.jitter, length = 0.0, machine.length
    turns = "gravity" in names or rng.random() < 0.5
    units = (log_uniform(rng, 1e-3, 1e2), 2 * np.pi * rng.uniform(0.8, 4.5) / length, log_uniform(rng, 0.5, 5.0))
    if not turns:
        units = units[0], log_uniform(rng, 0.2, 30.0), units[2]

    def planned() -> tuple[Motion, Plan]:
        time, motion = machine.draw_motion(rng)
        motion = multisine(rng, machine, time, closed=closed) if shaken else motion
        plan = machine.plan(rng, motion, time)
        if not closed:  # the command is the mass times the motion's acceleration
            off = dict.fromkeys(("kp", "ki", "kd", "kv", "ff_viscous", "ff_coulomb", "limit"), 0.0)
            plan.set(**off, controller=truth.PID, ff_mass=machine.scalars["mass"])
        return motion, plan

    motion, base = planned()
    command, _, moving = gap(base, base)
    draws = VOCABULARY | {"gravity": partial(gravity, turn=2 * np.pi / units[1]), "mass_change": mass_change}
    hidden = [draws[name](rng, machine, motion) for name in names]
    power = float(np.mean(command[moving] ** 2))
    share = rng.uniform(SHARES[0], 0.5 if misread else SHARES[1])
    parts = rng.dirichlet(np.full(len(hidden), 2.0)) * share / (1 - share)
    sized = [(one, _amplitude(one, base, power, part)) for one, part in zip(hidden, parts, strict=True)]
    main = with_hidden(base, sized)
    made = power_ratio(main, base)
    sizes = [np.sqrt(power_ratio(with_hidden(base, [one]), base, 1.0)) for one in sized]
    if not SHARES[0] <= made <= SHARES[1] or min(sizes) < SMALLEST * max(sizes):
        raise Unreachable(f"{names} make {made:.2f} of the command")
    other, confirm = planned()
    confirm = with_hidden(confirm, sized)
    runs = [main.run(), confirm.run()]
    for run, wanted in zip(runs, (motion, other), strict=True):
        if closed and np.abs(run.reading - wanted.position).max() > 0.1 * length:
            raise Unreachable("the loop does not follow")
        if np.abs(run.command).max() > 60 * np.sqrt(power) or np.ptp(run.position) < 300 * base["resolution"]:
            raise Unreachable("the loop rings, or the axis hardly moves")
    misreading = _misreading(rng, base["resolution"] * units[1], turns=turns) if misread else None
    key = {
        "kind": "large", "family": statement, "ratio": 0.0, "share": made,
        "stated_controller": machine.stated_controller,
        "effects": [_truth(one, amplitude, size, units) for (one, amplitude), size in zip(sized, sizes, strict=True)],
        "largest": [one.name for (one, _), size in zip(sized, sizes, strict=True) if size >= AS_LARGE * max(sizes)],
        "misreading": misreading, "units": units, "law": machine.law, "closed": closed,
    }  # fmt: skip
    machine.model = in_units(machine.model, units, turns=turns)
    u, x, t = units
    factors = {"time": t, "position": x, "command": u, "reference": x, "reference_velocity": x / t}
    factors["reference_acceleration"] = x / t**2
    for name in (misreading or {"columns": ()})["columns"]:
        factors[name] *= misreading["factor"]
    return Case(machine, main, runs[0], confirm, runs[1], base, sized, key, factors)


def _amplitude(effect: Hidden, base: Plan, power: float, part: float) -> float:
    """Bisect the logarithm of the amplitude; the most that is physical where that does not suffice."""
    low, high = np.log(effect.low), np.log(LARGER.get(effect.name, 1.0) * effect.high)
    for _ in range(12):
        middle = 0.5 * (low + high)
        try:
            enough = power_ratio(with_hidden(base, [(effect, np.exp(middle))]), base, power) > part
        except ArithmeticError:
            enough = True
        low, high = (low, middle) if enough else (middle, high)
    return float(np.exp(low))


def _misreading(rng: np.random.Generator, resolution: float, *, turns: bool) -> dict[str, Any]:
    """What is wrong with the logs: each of `columns` stands multiplied by `factor`."""
    kind, columns = "scale", POSITIONS if rng.random() < 0.5 else POSITIONS[:1]
    what = str(rng.choice(["command sign", "position sign", "position scale", "command scale", "time scale"]))
    if what.endswith("sign"):
        kind, factor = "sign", -1.0
    elif what == "command scale":
        factor = float((log_uniform(rng, 12.0, 100.0) if rng.random() < 0.6 else 1e3) ** rng.choice([-1.0, 1.0]))
    else:
        causes = [1e3] if what == "time scale" or not turns else [180 / np.pi, 1 / (2 * np.pi)]
        factor = float(rng.choice(causes + [1 / resolution] * (what == "position scale" and resolution > 0)))
    subject = what.split()[0]
    return {"kind": kind, "columns": list(columns) if subject == "position" else [subject], "factor": factor}


def in_units(model: dict[str, Any], units: tuple[float, float, float], *, turns: bool) -> dict[str, Any]:
    """A model file in other units of command, position and time: so many of the new in one of the old."""

    def section(values: dict[str, Any]) -> dict[str, Any]:
        powers = OF_KEYS | ({"kp": (0, 0, -1)} if values.get("type") == "cascade" else {})
        return {
            name: np.multiply(value, np.prod(np.power(units, powers[name]))).tolist() if name in powers else value
            for name, value in values.items()
        }

    return {name: section(values) for name, values in model.items()} | {"units": {"position": "rad" if turns else "m"}}


def _truth(effect: Hidden, amplitude: float, size: float, units: tuple[float, float, float]) -> dict[str, Any]:
    truth = key_entry(effect, amplitude, 0.0, size=float(size * units[0]))
    for parameter in truth["parameters"].values():
        parameter["value"] *= float(np.prod(np.power(units, OF_UNITS[parameter["unit"]])))
    return truth
