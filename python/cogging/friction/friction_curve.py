"""Friction laws fitted to forces at steady speeds, and which of them predicts unseen speeds best."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging import plot
from cogging._core import EFFECTS, AxisParameters, smooth_sign
from cogging._core.effects import CoulombAsymmetry, StribeckFriction, ViscousAsymmetry
from cogging.arrays import FloatArray, IntArray, least_squares
from cogging.calls import check_arguments, entry_named
from cogging.effects.effect import Effect, steady_friction
from cogging.estimation.statistics import student
from cogging.mapping.scan import finite_column, is_number, require
from cogging.model.units import UNITS, Units
from cogging.plot.canvas import plot_method
from cogging.resources import on_one_blas_thread
from cogging.tables import frame_of, html_table
from cogging.values import ByValue

PARAMETER_UNITS = {name: AxisParameters.FIELDS[name][0] for name in ("coulomb", "viscous")}
for _law in (CoulombAsymmetry, ViscousAsymmetry, StribeckFriction):
    PARAMETER_UNITS |= {f"{_law.NAME}.{name}": unit for name, (unit, _) in _law.FIELDS.items()}
EXPONENTS = (0.5, 4.0)  # range searched
STARTS = 24  # of the search, speeds on a logarithmic scale


@dataclass(frozen=True, eq=False, repr=False)
class FrictionParameter(ByValue):
    """A fitted value with its interval; the bounds are infinite if the points do not determine it.

    Attributes:
        value: as fitted.
        low, high: ends of the interval.
        unit: in the requested labels.
    """

    value: float
    low: float
    high: float
    unit: str

    def _brief(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{self.value:.6g}{unit}, [{self.low:.6g}, {self.high:.6g}]"


#: Parameters of a law: those that are linear in the force, and vs and exponent (none without the Stribeck term).
Fit = tuple[FloatArray, FloatArray]


@dataclass(frozen=True)
class Law:
    """One law: which terms it has, and its exponent where that is given."""

    direction: bool
    bow: bool
    exponent: float | None

    @property
    def name(self) -> str:
        """The name of its model."""
        return "_".join(["direction"] * self.direction + ["stribeck"] * self.bow) or "coulomb_viscous"

    @property
    def paths(self) -> list[str]:
        """Linear parameters in the order of the design's columns, then those of the shape."""
        names = list(PARAMETER_UNITS)
        return names[:2] + (names[2:4] if self.direction else []) + (names[4:] if self.bow else [])

    @property
    def count(self) -> int:
        """How many parameters are fitted."""
        return len(self.paths) - (self.bow and self.exponent is not None)

    def design(self, v: FloatArray, shape: FloatArray) -> FloatArray:
        """The columns of the linear parameters at this shape, (n, terms)."""
        effects: list[Effect] = []
        if self.direction:
            effects += [CoulombAsymmetry(difference=1.0), ViscousAsymmetry(difference=1.0)]
        if self.bow:
            effects.append(StribeckFriction(static_excess=1.0, velocity=shape[0], exponent=shape[1]))
        return np.stack([smooth_sign(v, 0.0), v, *(steady_friction([effect], v) for effect in effects)], axis=1)

    def predict(self, fit: Fit, v: FloatArray) -> FloatArray:
        """The force at these speeds, V."""
        return self.design(v, fit[1]) @ fit[0]

    def solve(self, v: FloatArray, f: FloatArray, shape: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The linear parameters at this shape, and the residual."""
        design = self.design(v, shape)
        linear = least_squares(design.T, f, rcond=1e-14)
        if self.bow and linear[-1] < 0.0:  # friction that rises from zero speed is no Stribeck effect
            linear[-1] = 0.0
            linear[:-1] = least_squares(design.T[:-1], f, rcond=1e-14)
        return linear, f - design @ linear

    def limits(self, v: FloatArray) -> FloatArray:
        """Lower and upper ends of the logarithms of the shape parameters that are fitted, (2, 1 or 2)."""
        speeds = np.abs(v).min(), max(0.5 * np.abs(v).max(), 1.01 * np.abs(v).min())
        return np.log([speeds, EXPONENTS] if self.exponent is None else [speeds]).T

    def shape(self, logarithms: FloatArray) -> FloatArray:
        """vs and exponent of what limits() is about."""
        shape = np.exp(logarithms)
        return shape if self.exponent is None else np.append(shape, self.exponent)

    def fit(self, v: FloatArray, f: FloatArray) -> Fit:
        """Least squares on the points."""
        if not self.bow:
            return self.solve(v, f, np.empty(0))[0], np.empty(0)
        from scipy import optimize

        low, high = self.limits(v)

        def residual(logarithms: FloatArray) -> FloatArray:
            return self.solve(v, f, self.shape(logarithms))[1]

        axes = [np.linspace(a, b, n) for a, b, n in zip(low, high, (STARTS, 6), strict=False)]
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, low.size)
        cost = np.array([np.sum(residual(point) ** 2) for point in grid])
        options = {"bounds": (low, high), "method": "dogbox", "xtol": 1e-11, "ftol": 1e-15, "gtol": 1e-15}
        refined = [optimize.least_squares(residual, grid[i], **options) for i in np.argsort(cost)[:4]]
        best = min(refined, key=lambda found: float(found.cost)).x
        return self.solve(v, f, self.shape(best))[0], self.shape(best)

    def intervals(
        self, fit: Fit, v: FloatArray, f: FloatArray, confidence: float, units: Units
    ) -> tuple[dict[str, FrictionParameter], list[str]]:
        """Parameters by path with HC3 intervals; those of the shape in the logarithm. And what to note."""
        (linear, shape), design, residual = fit, self.design(v, fit[1]), f - self.predict(fit, v)
        values = np.concatenate(fit)
        free, notes, columns = list(range(linear.size)), [], [design]
        if self.bow and linear[-1] == 0.0:
            columns, free = [design[:, :-1]], free[:-1]
            notes.append("friction does not fall as speed rises from zero: the Stribeck term vanishes")
        elif self.bow:
            low, high = self.limits(v)
            place = np.log(shape[: low.size])
            for i, step in enumerate(1e-5 * np.eye(low.size)):
                if min(place[i] - low[i], high[i] - place[i]) < 1e-6:
                    path = self.paths[linear.size + i]
                    notes.append(f"{path} is at the end of its range, {shape[i]:.4g}: no interval")
                    continue
                change = self.design(v, self.shape(place + step)) - self.design(v, self.shape(place - step))
                columns.append((change @ linear / 2e-5)[:, None])
                free.append(linear.size + i)
        jacobian = np.concatenate(columns, axis=1)
        half = np.full(values.size, np.inf)
        half[free] = robust_errors(jacobian, residual) * student(v.size - jacobian.shape[1], confidence)
        if self.bow and self.exponent is not None:
            half[-1] = 0.0  # given
        with np.errstate(over="ignore"):
            factors = np.exp(half[linear.size :])
        low = np.append(linear - half[: linear.size], shape / factors)
        high = np.append(linear + half[: linear.size], shape * factors)
        rows = zip(self.paths, values.tolist(), low.tolist(), high.tolist(), strict=True)
        return {path: FrictionParameter(p, a, b, units.of(PARAMETER_UNITS[path])) for path, p, a, b in rows}, notes


def robust_errors(jacobian: FloatArray, residual: FloatArray) -> FloatArray:
    """Roots of the diagonal of (J'J)^-1 J' diag(r^2 / (1 - h)^2) J (J'J)^-1, h the leverages; infinite if singular."""
    size = np.linalg.norm(jacobian, axis=0)
    if np.any(size == 0.0) or np.linalg.cond(jacobian / size) > 1e10:
        return np.full(jacobian.shape[1], np.inf)
    inverse = np.linalg.pinv(jacobian / size)
    leverage = np.sum((jacobian / size) * inverse.T, axis=1)
    errors = residual / np.maximum(1.0 - leverage, 1e-9)
    return np.asarray(np.sqrt(np.sum((inverse * errors) ** 2, axis=1)) / size, dtype=np.float64)


SPARE = 2  # points beyond the number of parameters that a model needs


@dataclass(frozen=True, eq=False, repr=False)
class FrictionModel(ByValue):
    """One law of the ladder, fitted to all points.

    Attributes:
        name: coulomb_viscous, direction, stribeck or direction_stribeck.
        parameters: by path: coulomb, viscous, then <effect>.<field> as in a model file.
        residual_rms: V, of the points.
        held_out_rms: V, of the errors at speeds that were left out of the fit, each in turn.
        held_out_standard_error: V, of that rms, from its scatter between speeds.
        gain: 1 - held_out_rms over that of Coulomb + viscous.
    """

    name: str
    parameters: dict[str, FrictionParameter]
    residual_rms: float
    held_out_rms: float
    held_out_standard_error: float
    gain: float

    def _brief(self) -> str:
        found, force = self.parameters.items(), self.parameters["coulomb"].unit
        values = ", ".join(f"{path} {p.value:.4g}{'' if p.unit == '1' else ' ' + p.unit}" for path, p in found)
        return f"{self.name}: {values}; {self.held_out_rms:.3g} {force} rms at speeds left out"

    def force(self, velocity: npt.ArrayLike) -> FloatArray:
        """The friction force (V) at these speeds (m/s), of either sign; any shape."""
        v = np.asarray(velocity, dtype=np.float64)
        line = self.parameters["coulomb"].value * smooth_sign(v, 0.0) + self.parameters["viscous"].value * v
        return np.asarray(sum((steady_friction([effect], v) for effect in self.effects), line), dtype=np.float64)

    @property
    def effects(self) -> tuple[Any, ...]:
        """What a plant takes beside `coulomb` and `viscous` of its axis."""
        fields: dict[str, dict[str, float]] = {}
        for path, parameter in self.parameters.items():
            effect, _, field = path.rpartition(".")
            if effect:
                fields.setdefault(effect, {})[field] = parameter.value
        return tuple(EFFECTS[effect](**values) for effect, values in fields.items())


@dataclass(frozen=True, eq=False, repr=False)
class FrictionCurve(ByValue):
    """The result of fit_friction_curve.

    Attributes:
        models: the laws that the points suffice for, simplest first.
        best: the law of fewest parameters whose squared errors at speeds left out exceed, speed by speed, those of the
            best law by no more than two standard errors.
        velocity, force: the points: means of the rows of one speed and direction; m/s, V, (n,).
        speed: number of the speed that a point belongs to, (n,); points of one number are left out together.
        confidence: of the intervals.
        notes: remarks on the fit.
        units: labels of force and position.
    """

    models: tuple[FrictionModel, ...]
    best: FrictionModel
    velocity: FloatArray
    force: FloatArray
    speed: IntArray
    confidence: float
    notes: tuple[str, ...]
    units: Units = field(default_factory=Units)

    def _brief(self) -> str:
        left = f"{self.best.held_out_rms:.3g} {self.units.command} rms"
        return f"{self.best.name} of {len(self.models)} laws, {left} at speeds left out"

    def __getitem__(self, name: str) -> FrictionModel:
        """The model of this name; KeyError: it was not fitted."""
        return entry_named(name, {model.name: model for model in self.models}, "model")

    def to_frame(self, what: str = "parameters") -> Any:
        """The `parameters` of all laws, a row each, or the `points`, as a pandas DataFrame (extra `frames`).

        Raises:
            ValueError: `what` is neither.
        """
        if what == "points":
            points = {"velocity": self.velocity, "force": self.force, "speed": self.speed}
            return frame_of(points, {"velocity": self.units.of("m/s"), "force": self.units.command})
        if what != "parameters":
            raise ValueError(f"what: must be parameters or points, got {what!r}")
        rows = [
            {"law": law.name, "best": law.name == self.best.name, "parameter": path, **vars(parameter)}
            for law in self.models
            for path, parameter in law.parameters.items()
        ]
        return frame_of(rows, {})

    def _repr_html_(self) -> str:
        found = self.best.parameters.items()
        rows = [[path, p.value, p.low, p.high, "" if p.unit == "1" else p.unit] for path, p in found]
        headers = ["parameter", "value", "from", "to", "unit"]
        return html_table(f"FrictionCurve: {self._brief()}", headers, rows, self.notes)

    plot = plot_method(plot.friction_curve, "Draw the points and the laws over speed.", "axes")

    def text(self) -> str:
        """The fits in a few lines for the screen."""
        v = self.units.command
        lines = [
            f"friction curve: {len(self.velocity)} points at {self.speed.max() + 1} speeds from "
            f"{np.abs(self.velocity).min():.4g} to {np.abs(self.velocity).max():.4g} {self.units.of('m/s')}",
            f"law                 parameters{f'residual ({v})':>14}{f'held out ({v})':>14}{f'+- ({v})':>11}   gain",
        ]
        for model in self.models:
            lines.append(
                f"{model.name:18s}  {len(model.parameters):10d}  {model.residual_rms:12.5g}  {model.held_out_rms:12.5g}"
                f"  {model.held_out_standard_error:9.2g}  {model.gain:5.1%}{'  <- best' if model is self.best else ''}"
            )
        for path, p in self.best.parameters.items():
            unit = "" if p.unit == "1" else f"  {p.unit}"
            lines.append(f"{path:32s} {p.value:11.5g}  [{p.low:.5g}, {p.high:.5g}]{unit}")
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])


@check_arguments(units=UNITS)
@on_one_blas_thread(scipy=True)
def fit_friction_curve(
    velocity: npt.ArrayLike,
    force: npt.ArrayLike,
    *,
    exponent: float | None = None,
    same_speed: float = 0.05,
    confidence: float = 0.95,
    units: Units | None = None,
) -> FrictionCurve:
    """Fit friction laws to forces at steady speeds, and select the one that predicts unseen speeds best.

    force = (Fc + dC/2 s + static_excess exp(-|v/vs|^exponent)) s + (B + dB/2 s) v, s = sgn(v). The ladder: Coulomb +
    viscous; with Fc and B that differ with direction; with the Stribeck term; with both. The force is the mean command
    at a steady speed, without acceleration; average over whole periods to remove cogging.

    Rows of one speed and direction are averaged to a point. The two shape parameters of the Stribeck term are fitted by
    variable projection from many starts: vs between the lowest and half of the highest speed, the exponent between 0.5
    and 4; static_excess is at least 0. Intervals are robust to noise that differs between speeds (HC3 covariance,
    MacKinnon and White 1985, Student's t). Each speed, both directions together, is left out of the fit in turn and
    predicted. A model needs at least two points more than parameters, also with the fullest speed left out.

    Args:
        velocity: m/s, (n,), of either sign, not zero.
        force: V, (n,), that keeps this speed: positive forward.
        exponent: of the Stribeck term; fitted when None.
        same_speed: |v| this close (relative to the lowest of them) are one speed.
        confidence: of the intervals.
        units: labels of force and position for the result.

    Returns:
        The laws that the points suffice for, and the best of them.

    Raises:
        ValueError: names the field, the rule and the value.

    Example:
        >>> v = np.concatenate([-np.linspace(0.05, 1.0, 12), np.linspace(0.05, 1.0, 12)])
        >>> curve = cogging.fit_friction_curve(v, 0.15 * np.sign(v) + 0.2 * v)
        >>> print(f"{curve.models[0].name}: {curve.models[0].parameters['viscous'].value:.3f} V/(m/s)")
        coulomb_viscous: 0.200 V/(m/s)
    """
    require(is_number(confidence) and 0.0 < confidence < 1.0, "confidence", "must lie between 0 and 1", confidence)
    require(is_number(same_speed) and 0.0 <= same_speed < 1.0, "same_speed", "must lie from 0 to below 1", same_speed)
    is_valid = exponent is None or (is_number(exponent) and exponent > 0.0)
    require(is_valid, "exponent", "must be finite and above 0", exponent)
    v, f, speed = _points(finite_column("velocity", velocity), finite_column("force", force), same_speed)
    both_ways, least = bool(np.any(v > 0.0) and np.any(v < 0.0)), v.size - int(np.bincount(speed).max())
    notes = [] if both_ways else ["the points go one way only: laws that differ with direction are not tried"]
    laws = [Law(way, bow, exponent) for bow in (False, True) for way in (False, True) if both_ways or not way]
    tried = [law for law in laws if least >= law.count + SPARE]
    needed = laws[0].count + SPARE + v.size - least
    rule = f"must hold at least {needed} points, with any speed left out {SPARE} more than parameters"
    require(bool(tried), "velocity", rule, v.size)
    notes += [f"{law.name} not tried: {law.count} parameters for {v.size} points" for law in laws if law not in tried]
    fits = [law.fit(v, f) for law in tried]
    errors = np.empty((len(tried), f.size))  # of the points, each predicted by a fit without its speed
    for row, law in zip(errors, tried, strict=True):
        for out in (speed == number for number in np.unique(speed)):
            row[out] = f[out] - law.predict(law.fit(v[~out], f[~out]), v[out])
    squares = np.stack([np.bincount(speed, e**2) / np.bincount(speed) for e in errors])
    counts = np.bincount(speed) / v.size
    rms = np.sqrt(np.mean(errors**2, axis=1))
    models = []
    for law, fit, e, by_speed in zip(tried, fits, rms, squares, strict=True):
        parameters, remarks = law.intervals(fit, v, f, confidence, units or Units())
        notes += [f"{law.name}: {note}" for note in remarks]
        spread = _standard_error(by_speed, counts) / max(2.0 * e, np.finfo(float).tiny)
        left = float(np.sqrt(np.mean((f - law.predict(fit, v)) ** 2)))
        gain = 1.0 - float(e / rms[0]) if rms[0] > 0.0 else 0.0
        models.append(FrictionModel(law.name, parameters, left, float(e), float(spread), gain))
    # The law of fewest parameters whose squared errors are within two standard errors of those of the best.
    worse = squares - squares[int(np.argmin(rms))]
    good = [i for i, row in enumerate(worse) if counts @ row <= 2.0 * _standard_error(row, counts)]
    chosen = min(good, key=lambda i: tried[i].count)
    if "coulomb_asymmetry.difference" in models[chosen].parameters:
        notes.append("at steady speeds coulomb_asymmetry is indistinguishable from a constant force of -difference/2")
    return FrictionCurve(tuple(models), models[chosen], v, f, speed, confidence, tuple(notes), units or Units())


def _standard_error(values: FloatArray, weights: FloatArray) -> float:
    """Of the weighted mean of values of different speeds; the weights sum to one."""
    deviation = values - weights @ values
    return float(np.sqrt(np.sum((weights * deviation) ** 2) * values.size / max(values.size - 1, 1)))


def _points(velocity: FloatArray, force: FloatArray, same_speed: float) -> tuple[FloatArray, FloatArray, IntArray]:
    """Means of the rows of each speed and direction, by rising speed, and the number of the speed."""
    rule = f"must have one value for each of the {velocity.size} speeds"
    require(force.size == velocity.size, "force", rule, force.size)
    still = np.flatnonzero(velocity == 0.0)
    require(not still.size, "velocity", "must not be 0 (friction at rest is no curve), row", still[:1].tolist())
    number, first, count = np.empty(velocity.size, dtype=np.intp), 0.0, -1
    for row in np.argsort(np.abs(velocity), kind="stable"):
        if abs(velocity[row]) > first * (1.0 + same_speed):
            count, first = count + 1, abs(velocity[row])
        number[row] = count
    keys, members = np.unique(2 * number + (velocity > 0.0), return_inverse=True)
    rows = np.bincount(members.ravel())
    v, f = (np.bincount(members.ravel(), values) / rows for values in (velocity, force))
    return v, f, keys // 2
