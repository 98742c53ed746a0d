"""How large the forces are that no controller of the library has a term for: effects beyond axis and cogging."""

from __future__ import annotations

import numpy as np

from cogging.arrays import FloatArray
from cogging.effects.effect import Effect, laws_of
from cogging.model.intervals import SIGMAS_95, Interval, Intervals, valid_end
from cogging.model.model import Model
from cogging.model.parameters import effect_paths, parameters_of, with_values

GRID = 201  # points along position, velocity and time
HORIZON = 10.0  # s, of effects that depend on time; longer where a field of theirs says so
TRAVEL = 1.0  # m on either side, of an axis without ends


def disturbance_range(model: Model, intervals: Intervals, velocity_max: float) -> tuple[Interval, float, list[str]]:
    """The range of the summed force of effects and noise, V; its middle guess; what is not in it, in words.

    Each effect's force (or friction level, times S(v) in [-1, 1]) is evaluated over the travel, |v| <= velocity_max
    and time. To the range at the model's values come, for each field with an interval, the largest changes of force
    down and up from the value to the ends of it: exact for one amplitude, on the safe side for several. Force
    noise adds 1.96 rms. The guess is the force in mid-travel at rest at t = 0.

    Args:
        model: whose effects and noise.
        intervals: of its parameters.
        velocity_max: m/s.

    Raises:
        ValueError: velocity_max is not above 0, a field's interval is infinite without a default.
    """
    if not (np.isfinite(velocity_max) and velocity_max > 0):
        raise ValueError(f"velocity_max: must be finite and above 0, got {velocity_max!r}")
    low, high, guess, left_out = 0.0, 0.0, 0.0, []
    for place, (prefix, effect) in enumerate(effect_paths(model.effects)):
        if not _pushes(effect):
            left_out.append(f"{prefix}: acts on command or reading or has a state, not within the disturbance")
            continue
        points = _points(model, effect, velocity_max)
        forces = _forces(_filled(model, effect), points)
        low, high = low + forces.min(), high + forces.max()
        guess += float(forces[0])
        for path in (p for p in parameters_of(model) if p.startswith(f"{prefix}.")):
            interval = intervals.of(path)
            if interval is not None:
                changes = [0.0, *(c for end in interval for c in _changes(model, place, path, end, points, forces))]
                low, high = low + min(changes), high + max(changes)
    noise = SIGMAS_95 * model.noise.force
    return (float(low - noise), float(high + noise)), guess, left_out


def _pushes(effect: Effect) -> bool:
    return "force" in effect.HOOKS or "friction_level" in effect.HOOKS


def _filled(model: Model, effect: Effect) -> Effect:
    """The effect with the fields that stand for those of the axis filled in."""
    return effect.resolved(model.axis, model.cogging)


def _changes(
    model: Model, place: int, path: str, end: float, points: FloatArray, forces: FloatArray
) -> tuple[float, float]:
    """The smallest and largest change of force that the end of a field's interval makes, V."""

    def allowed(value: float) -> bool:
        try:
            with_values(model, {path: value})
        except ValueError:
            return False
        return True

    value = valid_end(parameters_of(model)[path].value, end, allowed)
    effect = with_values(model, {path: value}).effects[place]
    change = _forces(_filled(model, effect), points) - forces
    return float(change.min()), float(change.max())


def _forces(effect: Effect, points: FloatArray) -> FloatArray:
    """Force at (position, velocity, time) rows, V; of a friction level the largest force on either side."""
    laws = laws_of(effect)
    if "force" in effect.HOOKS:
        return np.array([laws.force_at(position=x, velocity=v, time=t) for x, v, t in points])
    levels = [laws.friction_level_at(position=x, velocity=v, time=t) for x, v, t in points]
    moving = np.sign(points[:, 1])
    largest: FloatArray = -moving * np.array(levels, dtype=float)
    return largest


def _points(model: Model, effect: Effect, velocity_max: float) -> FloatArray:
    """Positions, velocities and times at which an effect is looked at, (n, 3); the first is mid-travel at rest at 0.

    A product grid over those coordinates that the effect depends on, as found by moving one at a time.
    """
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
    probe, used = _filled(model, effect), []
    for column, values in enumerate(axes):
        line = np.tile(np.array([rest[0], 0.37 * velocity_max, 0.0]), (len(values), 1))
        line[:, column] = values
        used.append(bool(np.ptp(_forces(probe, line)) > 0.0))
    # Two or three coordinates at once: fewer points of each.
    step = {0: 1, 1: 1, 2: 4, 3: 16}[sum(used)]
    chosen = [values[::step] if u else rest[i : i + 1] for i, (values, u) in enumerate(zip(axes, used, strict=True))]
    grid = np.stack([mesh.ravel() for mesh in np.meshgrid(*chosen, indexing="ij")], axis=1)
    return np.vstack([rest, grid])
