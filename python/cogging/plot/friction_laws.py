"""Friction over speed: measured points, the laws fitted to them, and the friction of a model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from cogging._core import smooth_sign
from cogging.arrays import FloatArray
from cogging.calls import described
from cogging.effects.effect import laws_of
from cogging.plot.canvas import drawn, legend, one_of
from cogging.plot.rows import numbers
from cogging.plot.scales import scale_of, units_of
from cogging.plot.series import look, marker, named

if TYPE_CHECKING:
    from matplotlib.axes import Axes

POINTS = 400
FASTEST = 0.5  # m/s: up to where the friction of a model is drawn, where nothing says


@drawn
def friction_curve(
    curve: Any,
    force: npt.ArrayLike | None = None,
    *,
    fastest: float = FASTEST,
    by_speed: bool = False,
    units: Any = None,
    ax: Any = None,
) -> Axes:
    """Draw friction over speed: points, and the laws that were fitted to them; or the friction of a model.

    Of a FrictionCurve: each law of the ladder, the best drawn through. Of a Model: what stops the axis at a steady
    speed: Coulomb, viscous, and what its effects add that depends on speed.

    Args:
        curve: a FrictionCurve or a Model; or velocities (m/s, (n,)) where `force` is given.
        force: V, (n,), positive forward.
        fastest: m/s, up to where the friction of a model is drawn.
        by_speed: draw both directions over the size of the speed, each force in the direction of motion.
        units: labels of command and position (cogging.Units); None: those of the model.
        ax: axes; None: a new figure.

    Returns:
        The axes.

    Raises:
        ValueError: arrays of other shapes; `fastest` is not above 0.
        TypeError: an argument is something else.

    Example:
        >>> ax = cogging.plot.friction_curve(model)
        >>> ax.get_xlabel(), ax.get_ylabel()
        ('velocity (m/s)', 'friction (V)')
    """
    points, lines = _drawn_of(curve, force, fastest)
    units = units or units_of(curve)
    axes = one_of(ax)
    along = scale_of("m/s", *(x for x, _ in (*points.values(), *lines.values())), units=units)
    up = scale_of("V", *(y for _, y in (*points.values(), *lines.values())), units=units)
    for place, (name, (x, y)) in enumerate(points.items()):
        way = np.where(by_speed, np.sign(x), 1.0)
        style = {"color": look(place)["color"], "marker": marker(place), "linestyle": "none"}
        axes.plot(along(way * x), up(way * y), label=name, **style)
    for place, (name, (x, y)) in enumerate(reversed(lines.items())):
        style = {**look(place + 2), "linestyle": "-" if place == 0 else look(place)["linestyle"]}
        for number, side in enumerate((x < 0.0, x > 0.0)):
            if side.any():
                turned = np.sign(x[side]) if by_speed else np.ones(int(side.sum()))
                axes.plot(along(turned * x[side]), up(turned * y[side]), label=named(name) if number else None, **style)
    axes.set(xlabel=along.label("speed" if by_speed else "velocity"), ylabel=up.label("friction"))
    legend(axes, columns=3)
    return axes


Drawn = dict[str, tuple[FloatArray, FloatArray]]


def _drawn_of(curve: Any, force: npt.ArrayLike | None, fastest: float) -> tuple[Drawn, Drawn]:
    """Points and lines by name; the last line is the one that counts."""
    if force is not None:
        v = numbers("curve", curve)
        return {"measured": (v, numbers("force", force, v.size))}, {}
    if not (isinstance(fastest, int | float | np.floating) and 0.0 < fastest < np.inf):
        raise ValueError(f"fastest: must be above 0 and finite, got {fastest!r}")
    if hasattr(curve, "models") and hasattr(curve, "best"):
        v, f = curve.velocity, curve.force
        points = {name: (v[kept], f[kept]) for name, kept in (("forward", v > 0), ("backward", v < 0)) if kept.any()}
        fine = np.linspace(0.5 * np.abs(v).min(), np.abs(v).max(), POINTS)
        grid = np.concatenate([side * fine[:: int(side)] for side in (-1.0, 1.0) if np.any(side * v > 0)])
        laws = sorted(curve.models, key=lambda law: law.name == curve.best.name)
        named_laws = {law.name.replace("_", " "): (grid, law.force(grid)) for law in laws}
        return points, named_laws
    if hasattr(curve, "axis") and hasattr(curve, "effects"):
        v = fastest * np.concatenate([-np.geomspace(1.0, 1e-4, POINTS), np.geomspace(1e-4, 1.0, POINTS)])
        return {}, {"model": (v, steady_friction(curve, v))}
    raise TypeError(f"curve: must be a FrictionCurve, a Model or velocities with a force, got {described(curve)}")


def steady_friction(model: Any, velocity: FloatArray) -> FloatArray:
    """What stops the axis of a model at a steady speed, V: of its axis and of its effects that depend on speed.

    A force that acts at rest too (a cable, a weight) is left out.
    """
    axis = model.axis
    sign = np.asarray(smooth_sign(velocity, axis.coulomb_width))
    friction: FloatArray = np.asarray(axis.coulomb * sign + axis.viscous * velocity, dtype=np.float64)
    for effect in model.effects:
        laws = laws_of(effect)
        if "friction_level" in effect.HOOKS:
            friction += np.asarray(laws.friction_level_at(velocity=velocity)) * sign
        if "force" in effect.HOOKS:
            moving, resting = laws.force_at(velocity=velocity), laws.force_at(velocity=np.zeros_like(velocity))
            friction -= np.asarray(moving) - np.asarray(resting)
    return friction
