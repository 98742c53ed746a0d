"""Friction laws of steady speed: their terms, least squares on points, and robust intervals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cogging._core import smooth_sign
from cogging._core.effects import CoulombAsymmetry, StribeckFriction, ViscousAsymmetry
from cogging.arrays import FloatArray, least_squares
from cogging.effects.effect import Effect, laws_of
from cogging.estimation.statistics import student
from cogging.model.units import Units
from cogging.values import ByValue

UNITS = {
    "coulomb": "V",
    "viscous": "V/(m/s)",
    "coulomb_asymmetry.difference": "V",
    "viscous_asymmetry.difference": "V/(m/s)",
    "stribeck_friction.static_excess": "V",
    "stribeck_friction.velocity": "m/s",
    "stribeck_friction.exponent": "1",
}
EXPONENTS = (0.5, 4.0)  # between which it is looked for
STARTS = 24  # of the search, speeds on a logarithmic scale


@dataclass(frozen=True, eq=False, repr=False)
class FrictionParameter(ByValue):
    """A fitted value with its interval, in its unit; the bounds are infinite where the points do not tell.

    Attributes:
        value: as fitted.
        low, high: ends of the interval.
        unit: in the labels that were asked for.
    """

    value: float
    low: float
    high: float
    unit: str

    def _brief(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{self.value:.6g}{unit}, [{self.low:.6g}, {self.high:.6g}]"


@dataclass(frozen=True)
class Fit:
    """Parameters of a law: those that are linear in the force, then the shape of the Stribeck term."""

    linear: FloatArray
    shape: FloatArray  # vs and exponent; empty without the Stribeck term


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
        names = list(UNITS)
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
        return np.stack([smooth_sign(v, 0.0), v, *(steady_friction(effect, v) for effect in effects)], axis=1)

    def predict(self, fit: Fit, v: FloatArray) -> FloatArray:
        """The force at these speeds, V."""
        return self.design(v, fit.shape) @ fit.linear

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
        ends = [(np.abs(v).min(), max(0.5 * np.abs(v).max(), 1.01 * np.abs(v).min()))] + (
            [EXPONENTS] if self.exponent is None else []
        )
        return np.log(np.array(ends)).T

    def shape(self, logarithms: FloatArray) -> FloatArray:
        """vs and exponent of what limits() is about."""
        shape = np.exp(logarithms)
        return shape if self.exponent is None else np.append(shape, self.exponent)

    def fit(self, v: FloatArray, f: FloatArray) -> Fit:
        """Least squares on the points."""
        if not self.bow:
            return Fit(self.solve(v, f, np.empty(0))[0], np.empty(0))
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
        return Fit(self.solve(v, f, self.shape(best))[0], self.shape(best))

    def intervals(
        self, fit: Fit, v: FloatArray, f: FloatArray, confidence: float, units: Units
    ) -> tuple[dict[str, FrictionParameter], list[str]]:
        """Parameters by path with HC3 intervals; those of the shape in the logarithm. And what to note."""
        design, residual = self.design(v, fit.shape), f - self.predict(fit, v)
        values = np.concatenate([fit.linear, fit.shape])
        free, notes, columns = list(range(fit.linear.size)), [], [design]
        if self.bow and fit.linear[-1] == 0.0:
            columns, free = [design[:, :-1]], free[:-1]
            notes.append("friction does not fall as speed rises from zero: the Stribeck term vanishes")
        elif self.bow:
            low, high = self.limits(v)
            for i in range(low.size):
                place, step = np.log(fit.shape[: low.size]), np.zeros(low.size)
                if min(place[i] - low[i], high[i] - place[i]) < 1e-6:
                    path = self.paths[fit.linear.size + i]
                    notes.append(f"{path} stands at the end of its range, {fit.shape[i]:.4g}: no interval")
                    continue
                step[i] = 1e-5
                change = self.design(v, self.shape(place + step)) - self.design(v, self.shape(place - step))
                columns.append((change @ fit.linear / 2e-5)[:, None])
                free.append(fit.linear.size + i)
        jacobian = np.concatenate(columns, axis=1)
        half = np.full(values.size, np.inf)
        half[free] = robust_errors(jacobian, residual) * student(v.size - jacobian.shape[1], confidence)
        if self.bow and self.exponent is not None:
            half[-1] = 0.0  # given
        parameters = {}
        for i, path in enumerate(self.paths):
            value = float(values[i])
            if i < fit.linear.size:
                low_end, high_end = value - half[i], value + half[i]
            else:
                factor = float(np.exp(half[i])) if half[i] < 700.0 else np.inf
                low_end, high_end = value / factor, value * factor
            parameters[path] = FrictionParameter(value, float(low_end), float(high_end), units.of(UNITS[path]))
        return parameters, notes


def steady_friction(effect: Effect, velocity: FloatArray) -> FloatArray:
    """What an effect adds to friction at steady speeds, V: its level times sgn(v), less its force."""
    friction = np.zeros_like(velocity)
    if "friction_level" in effect.HOOKS:
        friction += laws_of(effect).friction_level_at(velocity=velocity) * smooth_sign(velocity, 0.0)
    if "force" in effect.HOOKS:
        friction -= laws_of(effect).force_at(velocity=velocity)
    return friction


def robust_errors(jacobian: FloatArray, residual: FloatArray) -> FloatArray:
    """Roots of the diagonal of (J'J)^-1 J' diag(r^2 / (1 - h)^2) J (J'J)^-1, h the leverages; infinite if singular."""
    size = np.linalg.norm(jacobian, axis=0)
    if np.any(size == 0.0) or np.linalg.cond(jacobian / size) > 1e10:
        return np.full(jacobian.shape[1], np.inf)
    inverse = np.linalg.pinv(jacobian / size)
    leverage = np.sum((jacobian / size) * inverse.T, axis=1)
    errors = residual / np.maximum(1.0 - leverage, 1e-9)
    return np.asarray(np.sqrt(np.sum((inverse * errors) ** 2, axis=1)) / size, dtype=np.float64)
