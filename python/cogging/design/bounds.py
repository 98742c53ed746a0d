"""From a fitted model to controllers: the bounds of an axis and the parameters each controller needs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from cogging import _core
from cogging._core import AdaptiveRobustParameters, ObserverBasedParameters, SplineHarmonics
from cogging.arrays import FloatArray
from cogging.calls import check_constructor
from cogging.design.observer import ObserverDesign, ObserverProblem
from cogging.design.pid import pid_gains
from cogging.effects.effect import Effect, laws_of
from cogging.model.intervals import SIGMAS_95, Interval, Intervals, valid_end
from cogging.model.model import Model
from cogging.model.parameters import effect_paths, parameters_of, with_values
from cogging.values import ByValue, brief

PERIODS_IN_PITCH = 64  # largest ratio of the common pitch to the longest period


def pitch_and_harmonics(basis: SplineHarmonics) -> tuple[float, list[int]]:
    """Pitch (m) and harmonics of a cogging model; ValueError where the periods are no whole fractions of one pitch."""
    if basis.harmonics:
        return basis.pitch, list(basis.harmonics)
    periods = np.array(basis.periods)
    if basis.spline.control_points > 1:
        pitches = [basis.spline.pitch]
    else:
        pitches = [times * float(periods.max()) for times in range(1, PERIODS_IN_PITCH + 1)]
    for pitch in pitches:
        ratio = pitch / periods
        if (np.round(ratio) >= 1).all() and np.abs(ratio - np.round(ratio)).max() < 1e-6:
            return pitch, [int(n) for n in np.round(ratio)]
    raise ValueError(
        "cogging.periods: must be whole fractions of one pitch (with several control points: of the distance of the "
        f"knots) for arc and dcarc, got {periods.tolist()}"
    )


GRID = 201  # points along position, velocity and time
HORIZON = 10.0  # s, for effects that depend on time; longer if a field of theirs is
TRAVEL = 1.0  # m on either side, for an axis without ends


def disturbance_range(model: Model, intervals: Intervals, velocity_max: float) -> tuple[Interval, float, list[str]]:
    """Range of the summed force of effects and noise, V; its initial estimate; effects that it does not include.

    Each effect's force (or friction level, times S(v) in [-1, 1]) is evaluated over the travel, |v| <= velocity_max
    (m/s) and time; for each field with an interval come the largest changes from the value to the ends of it. Force
    noise adds 1.96 rms. The estimate is the force in mid-travel at rest at t = 0.
    """
    if not (np.isfinite(velocity_max) and velocity_max > 0):
        raise ValueError(f"velocity_max: must be finite and above 0, got {velocity_max!r}")
    low, high, guess, left_out = 0.0, 0.0, 0.0, []
    known = parameters_of(model)

    def is_valid(path: str, value: float) -> bool:
        try:
            with_values(model, {path: value})
        except ValueError:
            return False
        return True

    for place, (prefix, effect) in enumerate(effect_paths(model.effects)):
        if "force" not in effect.HOOKS and "friction_level" not in effect.HOOKS:
            left_out.append(f"{prefix}: acts on command or reading or has a state, not within the disturbance")
            continue
        points = _points(model, effect, velocity_max)
        forces = _forces(model, effect, points)
        low, high = low + forces.min(), high + forces.max()
        guess += float(forces[0])
        for path in (p for p in known if p.startswith(f"{prefix}.")):
            changes = [np.zeros(1)]
            for end in intervals.of(path) or ():
                value = valid_end(known[path].value, end, partial(is_valid, path))
                changes.append(_forces(model, with_values(model, {path: value}).effects[place], points) - forces)
            low, high = low + np.concatenate(changes).min(), high + np.concatenate(changes).max()
    noise = SIGMAS_95 * model.noise.force
    return (float(low - noise), float(high + noise)), guess, left_out


def _forces(model: Model, effect: Effect, points: FloatArray) -> FloatArray:
    """Force at (position, velocity, time) rows, V; of a friction level the largest force on either side."""
    effect = effect.resolved(model.axis, model.cogging)
    laws = laws_of(effect)
    if "force" in effect.HOOKS:
        return np.array([laws.force_at(position=x, velocity=v, time=t) for x, v, t in points])
    levels = [laws.friction_level_at(position=x, velocity=v, time=t) for x, v, t in points]
    return np.asarray(-np.sign(points[:, 1]) * np.array(levels, dtype=float))


def _points(model: Model, effect: Effect, velocity_max: float) -> FloatArray:
    """Positions, velocities and times at which an effect is evaluated, (n, 3); the first is mid-travel at rest at 0."""
    ends = zip(model.axis.travel, (-TRAVEL, TRAVEL), strict=True)
    start, stop = (end if np.isfinite(end) else stand_in for end, stand_in in ends)
    position = [np.linspace(start, stop, GRID)]
    speeds = np.geomspace(1e-5, 1.0, GRID // 2) * velocity_max
    time = [np.linspace(0.0, HORIZON, GRID)]
    for name, (unit, _) in effect.FIELDS.items():
        field = getattr(effect, name)
        for size in field if isinstance(field, list) else [field]:
            if not isinstance(size, float) or not np.isfinite(size) or size <= 0.0:
                continue
            if unit == "m":  # a period: its crests lie between the points of a coarse grid
                position.append(np.clip(start + np.linspace(0.0, size, 65), start, stop))
            elif unit == "s":  # a switch: either side of it
                time.append(size * np.array([1.0 - 1e-9, 1.0, 1.0 + 1e-9]))
            elif unit == "Hz":
                time.append(np.linspace(0.0, 1.0 / size, 65))
    axes = [np.concatenate(position), np.concatenate([-speeds, [0.0], speeds]), np.concatenate(time)]
    rest = np.array([0.5 * (start + stop), 0.0, 0.0])
    used = []
    for column, values in enumerate(axes):
        line = np.tile(np.array([rest[0], 0.37 * velocity_max, 0.0]), (len(values), 1))
        line[:, column] = values
        used.append(bool(np.ptp(_forces(model, effect, line)) > 0.0))
    # Two or three coordinates at once: fewer points of each.
    step = {0: 1, 1: 1, 2: 4, 3: 16}[sum(used)]
    chosen = [values[::step] if u else rest[i : i + 1] for i, (values, u) in enumerate(zip(axes, used, strict=True))]
    return np.vstack([rest, np.stack([mesh.ravel() for mesh in np.meshgrid(*chosen, indexing="ij")], axis=1)])


BANDWIDTH_MAX = 200.0  # 1/s: k_1 of the X axis of Lu et al. 2008, at 5 kHz
SAMPLES_A_RADIAN = 25.0  # its sample rate over its k_1
SPLINE = ("order", "origin", "control_points")
NO_DISTURBANCE = (
    "disturbance: no interval says how uncertain a constant force is; the largest Coulomb level counts, which friction "
    "at rest can hide (give default={'disturbance': (low, high)} otherwise)"
)


@check_constructor
@dataclass(frozen=True, eq=False, repr=False)
class Bounds(ByValue):
    """The bounds of an uncertain axis, and the controllers designed for them.

    The bounds are 95 % intervals of each parameter alone; the model's values, which lie within, are the initial
    estimates and the feedforward. The methods that design parameters take a `bandwidth` w, 1/s (None: the smaller of
    200 1/s, the k_1 of the X axis of Lu et al. 2008, and sample_rate / 25, its ratio), and any field of their struct as
    an override; they raise ValueError for a value that breaks its rule. The sample rate is the one of the model's
    controller, else the struct's default.

    Attributes:
        model: whose bounds they are.
        mass: V/(m/s^2).
        viscous: V/(m/s).
        coulomb: V.
        disturbance: d_n, V: summed force of effects and noise (see disturbance_range).
        cogging: V, from the smallest to the largest end of the intervals of all amplitudes; None without a cogging.
        disturbance_estimate: V, at rest in mid-travel.
        fallbacks: parameters whose intervals do not come from `[bounds]` of the model.
        notes: what the disturbance does not include, and where it is assumed.

    Example:
        >>> bounds = cogging.Bounds.of(model)
        >>> bounds
        Bounds(mass [0.112944, 0.127056] V/(m/s^2), ...)
        >>> cogging.Dcarc(bounds.adaptive_robust(bandwidth=100.0))
        Dcarc(sample_rate=5000 Hz, error_gain=100 1/s, ...)
    """

    model: Model = field(repr=False)
    mass: Interval
    viscous: Interval
    coulomb: Interval
    disturbance: Interval
    cogging: Interval | None
    disturbance_estimate: float
    fallbacks: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def _brief(self) -> str:
        units = {"mass": "V/(m/s^2)", "viscous": "V/(m/s)", "coulomb": "V", "disturbance": "V"}
        of = self.model.units.of
        return ", ".join(f"{name} {brief(getattr(self, name), of(unit))}" for name, unit in units.items())

    @classmethod
    def of(cls, model: Model, *, default: Mapping[str, Interval] | None = None, velocity_max: float = 1.0) -> Bounds:
        """Bounds of a model's axis, from which its controllers are designed.

        Args:
            model: with intervals in `[bounds]`, as `identify` writes them, or stated uncertainties.
            default: 95 % intervals by parameter path, or by its beginning (`"cogging"`), for parameters that have no
                finite one; `"disturbance"` (V) adds to what effects and noise make.
            velocity_max: speed up to which effects that depend on velocity count as disturbance, m/s.

        Raises:
            ValueError: mass, viscous, coulomb, a cogging amplitude or an effect's field has no finite interval and no
                default, an interval that does not hold the model's value, a path that the model has not.
        """
        intervals, axis = Intervals(model, default, beside=("disturbance",)), {}
        for name in ("mass", "viscous", "coulomb"):
            interval = intervals.of(f"axis.{name}")
            if interval is None:
                sources = "an interval in [bounds], a 1-sigma in [axis.uncertainty] (0 = exact) or a default"
                raise ValueError(f"axis.{name}: needs {sources}, got none of them")
            low, high = interval
            if name == "mass" and low <= 0.0:
                rule = "its interval must lie above 0 to design a controller"
                raise ValueError(f"axis.mass: {rule}, got [{low:g}, {high:g}]")
            axis[name] = max(low, 0.0), high
        disturbance, guess, notes = disturbance_range(model, intervals, velocity_max)
        amplitudes = [path for path in intervals.paths if path.startswith("cogging.")]
        ends = [intervals.of(path) or (intervals.value(path),) * 2 for path in amplitudes]
        if default and "disturbance" in default:
            disturbance = (disturbance[0] + default["disturbance"][0], disturbance[1] + default["disturbance"][1])
        elif disturbance[1] - disturbance[0] <= (1.0 + 1e-9) * 2.0 * SIGMAS_95 * model.noise.force:
            # A set of one point would leave a controller without integral action.
            disturbance = (disturbance[0] - axis["coulomb"][1], disturbance[1] + axis["coulomb"][1])
            notes.append(NO_DISTURBANCE)
        return cls(
            model,
            **axis,
            disturbance=disturbance,
            cogging=(min(end[0] for end in ends), max(end[1] for end in ends)) if ends else None,
            disturbance_estimate=guess,
            fallbacks=intervals.notes,
            notes=tuple(notes),
        )

    def adaptive_robust(self, *, bandwidth: float | None = None, **overrides: Any) -> AdaptiveRobustParameters:
        """Parameters of Arc and Dcarc: bounds, initial estimates, cogging and gains.

        k_1 = w and k_s1 = 2 w M, as on the X axis of Lu et al. 2008 (200 1/s, 400 M); more where the bounds are so wide
        that the matrix (29) of the paper would not be positive even without friction and cogging slopes (`condition`
        tells about those). Gamma of the disturbance is k_s1 w / 10, so that an offset is learnt ten times slower than
        w; of cogging a tenth, of Coulomb and viscous friction a hundredth and of mass a thousandth of it: the ratios of
        the paper (1000 to 100, 10, 10, 1 on the X axis). u_s2 is off, as its epsilon is not reported.

        Raises:
            ValueError: periods of the cogging that are no whole fractions of one pitch.
        """
        axis, (rate, w) = self.model.axis, self._speeds(AdaptiveRobustParameters, bandwidth, overrides)
        # k_s1 at which (29) without slopes turns positive everywhere: k_s1 - k M + B = B^2 / (2 k M).
        smallest = max(w * m - b + b * b / (2.0 * w * m) for m in self.mass for b in self.viscous)
        feedback = max(2.0 * w * axis.mass, 1.1 * smallest)
        adaptation = 0.1 * w * feedback
        fields: dict[str, Any] = {"sample_rate": rate, "error_gain": w, "feedback_gain": feedback}
        fields |= {**self._feedforward, "disturbance": self._disturbance_within}
        for name, share in (("mass", 1e-3), ("viscous", 1e-2), ("coulomb", 1e-2), ("disturbance", 1.0)):
            fields |= {f"{name}_bounds": list(getattr(self, name)), f"{name}_adaptation": share * adaptation}
        if self.model.cogging is not None and self.cogging is not None:
            pitch, harmonics = pitch_and_harmonics(self.model.cogging.basis)
            fields |= {f"cogging_{name}": getattr(self.model.cogging.basis.spline, name) for name in SPLINE}
            fields |= {"cogging_pitch": pitch, "cogging_harmonics": harmonics, "cogging_bounds": list(self.cogging)}
            fields["cogging_estimates"] = self.model.cogging.coefficients.tolist()
            fields["cogging_adaptation"] = 0.1 * adaptation
        return AdaptiveRobustParameters(**{**fields, **overrides})

    def condition(self, parameters: AdaptiveRobustParameters) -> tuple[float, float]:
        """desired_compensation_condition of Dcarc's gains with the steepest friction and cogging in the bounds.

        Above zero, convergence is proved. At or below it nothing is: the printed gains of Lu et al. 2008 are there too,
        through the slope of the friction at rest, and work.
        """
        amplitude, slope = max(map(abs, parameters.cogging_bounds)), 0.0
        if parameters.cogging_harmonics:
            names = ("pitch", "harmonics", *SPLINE)
            basis = SplineHarmonics(**{name: getattr(parameters, f"cogging_{name}") for name in names})
            slope = _core.cogging_slope_max(basis, amplitude)
        if parameters.coulomb_width == 0.0 and parameters.coulomb_bounds[1] > 0.0:
            return -math.inf, -math.inf  # sgn has no finite slope
        friction = _core.friction_slope_max(parameters.coulomb_width) if parameters.coulomb_width > 0.0 else 0.0
        return _core.desired_compensation_condition(parameters, friction_slope=friction, cogging_slope=slope)

    def observer_problem(
        self, velocity_min: float, velocity_max: float, *, bandwidth: float | None = None, **overrides: Any
    ) -> ObserverProblem:
        """The design problem of the observer of Malaize and Levine 2009 (`design_observer`, extra `design`).

        The periods of the cogging, mu = B/M, omega = w and a pole radius of 1.5 w, at least 2.4 times the fastest
        harmonic 2 pi velocity_max / P_n, which no smaller disk could hold: the ratios of the comparison of the papers
        (cogging.papers.comparison), where lambda* is 1.25 times the nominal acceleration as in Table I of the paper.

        Args:
            velocity_min: of the reference velocities at which the cogging is cancelled, m/s, above 0.
            velocity_max: their largest, m/s.

        Raises:
            ValueError: the model has no cogging, or a value breaks its rule.
        """
        if self.model.cogging is None:
            raise ValueError("cogging: must be in the model to design an observer for its periods, got none")
        _, w = self._speeds(ObserverBasedParameters, bandwidth, {})
        periods = [2.0 * math.pi / wavenumber for wavenumber in self.model.cogging.basis.wavenumbers]
        radius = max(1.5 * w, 2.4 * 2.0 * math.pi * velocity_max / min(periods))
        fields: dict[str, Any] = {"periods": periods, "omega": w, "pole_radius": radius}
        fields["viscous"] = self.model.axis.viscous / self.model.axis.mass
        return ObserverProblem(velocity_min=velocity_min, velocity_max=velocity_max, **{**fields, **overrides})

    def observer_based(
        self, problem: ObserverProblem, design: ObserverDesign, **overrides: Any
    ) -> ObserverBasedParameters:
        """Parameters of ObserverBased from a certified design; the harmonics freeze below velocity_max / 100.

        Args:
            problem: what was designed for.
            design: by design_observer.
        """
        rate, _ = self._speeds(ObserverBasedParameters, None, overrides)
        slope, mass = design.observer_gain_slope.tolist(), self.model.axis.mass
        fields: dict[str, Any] = {"sample_rate": rate, "observer_gain_slope": slope, "mass": mass, **overrides}
        return problem.controller_parameters(design.observer_gain.tolist(), **fields)

    def output_feedback(self, *, bandwidth: float | None = None, **overrides: Any) -> _core.OutputFeedbackArcParameters:
        """Parameters of OutputFeedbackArc: theta = [1/M, B/M, d_n/M] with its bounds, gains scaled from the paper's.

        Xu and Yao 2001, section 4.3, printed for w = 300 1/s (the poles of their PID) and 1/M = 30: the unit of each
        gain says how it goes with r = w / 300 and c = 1 / (30 M): observer 400 r, 4e4 r^2; g_1 = 600 r, g_2 = 850 r;
        Gamma 5e5 c^2, 3e5 r^2, 20e5 r^4; w_2 = 0.1 c^2 / r^2. Robust terms are off (see papers/xu2001/epoxy_motor.py).
        """
        axis, (rate, w) = self.model.axis, self._speeds(_core.OutputFeedbackArcParameters, bandwidth, overrides)
        r, c = w / 300.0, 1.0 / (30.0 * axis.mass)
        # Every quotient by a mass in the bounds lies between these.
        corners = np.array([[1.0, b, d] for b in self.viscous for d in self.disturbance])
        with np.errstate(over="ignore"):  # the controller refuses a bound that is infinite
            quotients = np.vstack([corners / mass for mass in self.mass])
        fields: dict[str, Any] = {name: getattr(axis, name) for name in ("coulomb", "coulomb_width")}
        fields |= {"sample_rate": rate, "gain_1": 600.0 * r, "gain_2": 850.0 * r}
        fields |= {"observer_gain_1": 400.0 * r, "observer_gain_2": 4e4 * r**2}
        fields["theta"] = [1.0 / axis.mass, axis.viscous / axis.mass, self._disturbance_within / axis.mass]
        fields |= {"theta_min": quotients.min(axis=0).tolist(), "theta_max": quotients.max(axis=0).tolist()}
        fields |= {"weight_1": 1.0, "weight_2": 0.1 * c**2 / r**2}
        fields["adaptation"] = [5e5 * c**2, 3e5 * r**2, 20e5 * r**4]
        return _core.OutputFeedbackArcParameters(**{**fields, **overrides})

    def pid(self, *, bandwidth: float | None = None, **overrides: Any) -> _core.PidParameters:
        """Parameters of Pid: three poles at -w for the smallest mass (Xu and Yao 2001, eq. 56), and feedforward."""
        rate, w = self._speeds(_core.PidParameters, bandwidth, overrides)
        kp, ki, kd = pid_gains([-w] * 3, self.mass[0])
        fields = {"sample_rate": rate, "kp": kp, "ki": ki, "kd": kd, **self._feedforward}
        return _core.PidParameters(**{**fields, **overrides})

    def cascade(self, *, bandwidth: float | None = None, **overrides: Any) -> _core.CascadeParameters:
        """Parameters of Cascade: a double pole at -w for the largest mass, kp = w / 2, kv = 2 w M, and feedforward.

        A smaller mass makes the velocity loop faster, so no mass in the bounds is underdamped. `viscous` is B + kv:
        with kv of it the velocity loop sees the error of velocity, without which the axis would lag by v / kp.
        """
        rate, w = self._speeds(_core.CascadeParameters, bandwidth, overrides)
        gain = 2.0 * w * self.mass[1]
        fields = {"sample_rate": rate, "kp": 0.5 * w, "kv": gain, **self._feedforward}
        fields["viscous"] += overrides.get("kv", gain)
        return _core.CascadeParameters(**{**fields, **overrides})

    @property
    def _feedforward(self) -> dict[str, float]:
        return {name: getattr(self.model.axis, name) for name in ("mass", "viscous", "coulomb", "coulomb_width")}

    @property
    def _disturbance_within(self) -> float:
        return min(max(self.disturbance_estimate, self.disturbance[0]), self.disturbance[1])

    def _speeds(self, struct: Any, bandwidth: float | None, overrides: Mapping[str, Any]) -> tuple[float, float]:
        """Sample rate, Hz, and bandwidth, 1/s, checked."""
        own = struct() if self.model.controller is None else self.model.controller
        rate = float(overrides.get("sample_rate", own.sample_rate))
        if bandwidth is None:
            return rate, min(BANDWIDTH_MAX, rate / SAMPLES_A_RADIAN)
        if not (math.isfinite(bandwidth) and bandwidth > 0):
            raise ValueError(f"bandwidth: must be finite and above 0, got {bandwidth!r}")
        return rate, float(bandwidth)
