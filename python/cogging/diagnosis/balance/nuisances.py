"""Nuisance parameters of a force balance: their columns and priors, and the instruments that the columns are made from.

Nuisance parameters are those that may change without an effect: mass, friction, the known cogging and the parameters of
accepted effects.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cogging._core import Predictor
from cogging.arrays import FloatArray
from cogging.diagnosis.balance.differenced_balance import DifferencedBalance
from cogging.effects.effect import Effect, Wave, Window, kind_of
from cogging.estimation.residuals import quiet_plant
from cogging.model.model import Model
from cogging.model.parameters import Parameter, effect_paths, parameters_of, with_values

TIMING = 0.25  # rows of a log: standard deviation of the timing error of friction
RATIO = 1.25  # of two adjacent widths in the mixture of Coulomb friction laws
WIDTH = "axis.coulomb_width"  # path of the width of the model's own law
KNEE = 0.6  # of the highest speed: largest width; a wider law is indistinguishable from viscous friction
EXACT = 1e-4  # relative uncertainty of what is stated without any: a change beyond it is an effect
UNSTATED = 1.0  # relative uncertainty of mass and friction where the model states none
ROUNDING = 1e-8  # relative: smaller sizes are rounding errors
LEAST_SHARE = 0.1  # of an effect's size: least uncertainty of one of its amplitudes
SECANT = 0.1  # of the deviation of a parameter: finite-difference step of its column
COGGING_STEP = 0.05  # relative, and rad: finite-difference steps of gain and phase of the known cogging
# Instruments: regression of the command on the model's force along the reference at several lags
LAGS = (-2, -1, 0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96)  # of LAG: a loop responds within some 40 ms
RINGING = tuple(range(112, 320, 16))  # of LAG, for the force on loads: they ring for some 0.1 s
LAG = 4e-4  # s
SHIFTS = {"command_delay", "lag"}  # hooks of effects that shift the command in time


class Instruments(NamedTuple):
    """What columns are made from in place of the measured command and acceleration.

    The loop feeds its own noise back into the command and into later rows, so that a column made of the command raises
    false alarms.
    """

    drive: FloatArray  # command regressed on the model's force along the reference at several lags, V, (n,)
    #: Command that the measured motion needs under the model, V, (n,): no part balances a force which the model lacks.
    needed: FloatArray
    force: FloatArray  # net force, with what the ringing of loads adds to the command, V, (n,)
    #: The one that the drive causes, m/s^2, (n,): with ringing, mass and the share of a load could replace each other.
    acceleration: FloatArray
    moves: FloatArray  # measured acceleration regressed like the drive, m/s^2, (n,): of a play, where drift would count

    def residual(self, b: DifferencedBalance, model: Model) -> FloatArray:
        """Return the unexplained force of a balance under a model, the loads of which move without noise, V, (n,)."""
        rigid: FloatArray = b.remembered("residual", model, DifferencedBalance.residual)
        return rigid - b.loads(model, self.force, self.moves)

    def change(self, b: DifferencedBalance, old: Model, new: Model) -> FloatArray:
        """Return the residual of a balance under a new model less that under an old one, without noise, V, (n,)."""
        own = [e for e in (*old.effects, *new.effects) if (e in old.effects) != (e in new.effects)]
        hooks = {hook for e in own for hook in e.HOOKS}
        if (old.axis, old.cogging) == (new.axis, new.cogging) and "reading" not in hooks:  # most forces cancel
            rubs = bool(hooks & {"friction_level", "state"})
            axis = old.axis if rubs else old.axis.replace(viscous=0.0, coulomb=0.0)
            apart = [
                e for e in old.effects if e.HOOKS == ("force",) or (hooks <= {"force"} and "reading" not in e.HOOKS)
            ]
            old, new = (
                m.replace(axis=axis, cogging=None, effects=[e for e in m.effects if e in own or e not in apart])
                for m in (old, new)
            )
        # without a reference, the acceleration that is known without noise lacks the fast motion
        a = None if b.reference is None else self.acceleration
        drive = b.command if "shape_command" in hooks else self.drive
        drive = b.timed(drive) if hooks & SHIFTS else drive
        loads = b.loads(new, self.force, self.moves) - b.loads(old, self.force, self.moves)
        known = b.cache.get("before")  # many laws are compared with the same model
        if known is None or known[0] is not drive or known[1] != old:
            b.cache["before"] = known = drive, old, b.residual(old, drive, a)
        return np.asarray(b.residual(new, drive, a) - known[2] - loads)


def instruments_of(b: DifferencedBalance, model: Model) -> Instruments:
    """Return the instruments of a log under a model."""
    only = model.replace(effects=tuple(e for e in model.effects if "force" in e.HOOKS or "friction_level" in e.HOOKS))
    plant = quiet_plant(only)
    forces = b.forces([plant])[0]
    if b.reference is None:
        slow = b.low_passed(b.command, 0.5 * b.corner)
        # below the crossover use the acceleration: the command also balances noise and forces that the model lacks
        quiet = slow + b.low_passed(model.axis.mass * b.acceleration - forces - slow, b.crossover)
        net = quiet + forces
        return Instruments(quiet, quiet, net, net / model.axis.mass, net / model.axis.mass)
    x, v, a = b.reference
    along = Predictor(b.time, x, np.zeros(len(x))).net_force([plant], x, v)[0]
    rows = np.arange(len(x))
    stride = max(1, round(LAG / b.step))
    columns = [np.ones(len(x)), x - x.mean(), v]
    for lag in (*LAGS, *RINGING):
        at = np.clip(rows - stride * lag, 0, len(x) - 1)
        columns += [a[at], along[at]]
    table = np.array(columns)
    table /= np.linalg.norm(table, axis=1)[:, None] + 1e-300
    gram, slope = table @ table.T + 1e-9 * np.eye(len(table)), table @ b.command
    # in periodic motion many lags reproduce every force, also one that the model lacks: of the drive only the loop's
    count = len(table) - 2 * len(RINGING)
    explained, ringing = (np.linalg.solve(gram[:k, :k], slope[:k]) @ table[:k] for k in (count, len(table)))
    moves = np.linalg.solve(gram[:count, :count], table[:count] @ b.acceleration) @ table[:count]
    needed = model.axis.mass * moves - forces
    return Instruments(explained, needed, ringing + along, (explained + along) / model.axis.mass, moves)


def nuisances_of(
    model: Model,
    given: Model,
    balances: Sequence[DifferencedBalance],
    instruments: Sequence[Instruments],
    free: Sequence[str],
) -> Nuisances:
    """Return columns and priors of the nuisance parameters of a model that is re-tuned; `given` sets the priors.

    The friction law is a positive mixture of ramps that saturate at one speed each, which spans every concave law.
    `free` are the paths of the axis without a prior, and that of the width of its friction law where it is fitted.
    """
    known = parameters_of(model, together=True)
    columns = Nuisances(balances)
    laws, widths = friction_laws(model, given, balances)
    # the residual is M a less the forces: more mass adds a
    axis = {
        "mass": [-one.acceleration for one in instruments],
        "viscous": [-b.velocity for b in balances],
        "coulomb": [-law[0] for law in laws],
    }
    for name, rows in axis.items():
        stated, path, u = getattr(given.axis, name), f"axis.{name}", given.uncertainty.get(name, UNSTATED)
        if stated or u:  # a force that is stated exactly as absent stays so
            sigma = np.inf if path in free or stated == 0.0 else max(u, EXACT) * abs(stated)
            columns.add(path, sigma, rows, stated - getattr(model.axis, name))
    # friction may lag the speed by a fraction of a row, as an elastic contact does
    own = model.axis.coulomb
    rubs = own > ROUNDING * columns.largest  # the shape of negligible friction is not identifiable
    late = [np.diff(law[0], prepend=law[0][0]) / b.thinning for law, b in zip(laws, balances, strict=True)]
    if rubs:
        columns.add("friction.late", TIMING * own, late)
    width, spread = model.axis.coulomb_width, given.uncertainty.get("coulomb_width", UNSTATED)
    if rubs and WIDTH in free and width > 0.0 and spread:
        columns.add(WIDTH, spread * width, [own * (law[0] - law[1]) / (SECANT * width) for law in laws])
    for k, w in enumerate(widths if rubs else [], 2):
        columns.add(f"width.{w:g}", own, [law[0] - law[k] for law in laws])
    add_cogging(columns, model, known)
    prefixes = [prefix for prefix, _ in effect_paths(model.effects)]
    for effect, prefix in list(zip(model.effects, prefixes, strict=True))[len(given.effects) :]:
        for path in [p for p in known if p.startswith(prefix + ".")]:
            add_parameter(columns, model, instruments, effect, path[len(prefix) + 1 :].split("[")[0], known[path])
    return columns


class Nuisances:
    """Columns of several logs with their parameter paths and normal priors.

    Attributes:
        paths: parameter of each column.
        sigma, offset: standard deviation and mean of its prior.
        tables: columns of each log, (n,) each.
        limits: bounds of shape parameters, by path.
    """

    def __init__(self, balances: Sequence[DifferencedBalance]) -> None:
        self.balances = balances
        self.largest = max(float(np.max(np.abs(b.command))) for b in balances)  # V
        self.paths: list[str] = []
        self.sigma: list[float] = []
        self.offset: list[float] = []
        self.tables: list[list[FloatArray]] = [[] for _ in balances]
        self.limits: dict[str, tuple[float, float]] = {}

    def add(self, path: str, sigma: float, rows: Sequence[FloatArray], offset: float = 0.0) -> None:
        """Append the column of a parameter whose change has the prior mean `offset` and deviation `sigma`."""
        self.paths.append(path)
        self.sigma.append(sigma)
        self.offset.append(offset)
        for table, row in zip(self.tables, rows, strict=True):
            table.append(row)


def friction_laws(
    model: Model, given: Model, balances: Sequence[DifferencedBalance]
) -> tuple[list[FloatArray], list[float]]:
    """Return friction laws of level 1, (2 + widths, n) of each log, and the widths (m/s).

    First stand the model's own law and the same wider by SECANT, the others are ramps that saturate at the widths.
    """
    width, widths = model.axis.coulomb_width, list[float]()
    if given.uncertainty.get("coulomb_width") != 0.0:
        slowest = 2.0 * min(b.speed_noise for b in balances)
        fastest = max(np.abs(b.velocity).max() for b in balances)
        last = max(12.0 * width, 4.0 * slowest, KNEE * fastest)
        # on one grid, so that a law is evaluated once for all logs and models
        least, first, end = np.log([0.1 * slowest, slowest, last]) / np.log(RATIO)
        widths = [float(RATIO**k) for k in (np.round(least), *np.arange(np.floor(first), np.ceil(end) + 1.0))]
    laws = []
    for b in balances:
        wanted = [width, (1.0 + SECANT) * width, *(-w for w in widths)]  # arctangents by width, ramps by minus width
        known = {w: law for w, law in b.cache.get("friction", {}).items() if w < 0.0 or w in wanted}
        if missing := [w for w in wanted if w not in known]:
            v = b.fine.velocity
            table = [
                np.arctan(v / w) * 2 / np.pi if w > 0.0 else np.clip(-v / w, -1.0, 1.0) if w else np.sign(v)
                for w in missing
            ]
            known |= zip(missing, b.averaged(np.array(table)), strict=True)
            b.cache["friction"] = known
        laws.append(np.array([known[w] for w in wanted]))
    return laws, widths


def add_cogging(columns: Nuisances, model: Model, known: dict[str, Parameter]) -> None:
    """Add columns for gain and phase of each known harmonic, or for sine and cosine if its amplitude is constant."""
    if model.cogging is None:
        return
    steps: dict[str, float] = {}
    for row in range(len(model.cogging.sine)):
        size = np.hypot(np.max(np.abs(model.cogging.sine[row])), np.max(np.abs(model.cogging.cosine[row])))
        if size > 0.0 and model.cogging.sine.shape[1] > 1:
            steps |= {f"cogging.{kind}[{row}]": COGGING_STEP for kind in ("gain", "phase")}
        else:
            steps |= {f"cogging.{kind}[{row}][*]": 1e-2 * columns.largest for kind in ("sine", "cosine")}
    changed = [with_values(model, {path: known[path].value + step}) for path, step in steps.items()]
    plants = [quiet_plant(m.replace(effects=())) for m in (model, *changed)]
    forces = [b.forces(plants) for b in columns.balances]
    for k, (path, step) in enumerate(steps.items(), 1):
        columns.add(path, np.inf, [(f[k] - f[0]) / step for f in forces])


def add_parameter(
    columns: Nuisances,
    model: Model,
    instruments: Sequence[Instruments],
    effect: Effect,
    name: str,
    parameter: Parameter,
) -> None:
    """Add the column of a field of an accepted effect by finite differences of the residual; skip settings.

    The prior of a shape parameter confines it to where the law is nearly linear in it.
    """
    balances, path, value = columns.balances, parameter.path, parameter.value
    wave, window = kind_of(effect, Wave), kind_of(effect, Window)
    role, quantity = effect.ROLES[name]["role"], effect.ROLES[name]["quantity"]
    if role == "setting" or (role == "shape" and isinstance(getattr(effect, name), list)):
        return
    if window is not None and name in (window.start, window.stop):  # the force is not linear in them
        return
    low, high = min(np.min(b.position) for b in balances), max(np.max(b.position) for b in balances)
    if role == "amplitude":
        same = effect.FIELDS[name][0]  # unit
        alike = [f for f, one in effect.ROLES.items() if one["role"] == role and effect.FIELDS[f][0] == same]
        size = float(np.linalg.norm(np.hstack([getattr(effect, f) for f in alike])))
        sigma = max(abs(value), LEAST_SHARE * size)
    elif wave is not None and name == wave.shape and quantity == "distance":
        sigma = 0.5 * value**2 / (high - low)
    elif wave is not None and quantity == "frequency":
        sigma = 0.3 / balances[0].time[-1]
    else:
        sigma = 0.1 * (high - low) if quantity == "position" else 0.3 * abs(value)
    if sigma == 0.0:
        return
    try:
        pair = [with_values(model, {path: value + q}) for q in (SECANT * sigma, -SECANT * sigma)]
        rows = []
        for b, one in zip(balances, instruments, strict=True):
            known = b.remembered("columns", model, lambda b, model: {})
            if (path, sigma) not in known:
                known[path, sigma] = one.change(b, *pair) / (2.0 * SECANT * sigma)
            rows.append(known[path, sigma])
    except ValueError:  # the effect rejects the value
        return
    columns.add(path, sigma, rows)
    if role != "amplitude":  # a wave that is longer than the travel is none
        longest = max(value, high - low) if wave is not None and name == wave.shape else np.inf
        columns.limits[path] = value - sigma, min(value + sigma, longest)
