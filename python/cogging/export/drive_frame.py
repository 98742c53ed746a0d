"""How a drive sees the axis: where its zero lies, which way it counts, and what it takes in place of the command."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cogging._core import CoggingModel, effects
from cogging.arrays import FloatArray
from cogging.design.linear_plant import OF_SPEED
from cogging.effects.effect import Effect, laws_of
from cogging.model.model import Model
from cogging.shown import quoted

CoggingEffect = effects.CoggingHarmonic | effects.CoggingModulation
CLOSES = 0.01  # of a period: by how much a whole number of them may miss a turn, 4 degrees of phase
MANY_SPANS = 20  # that are looked at where neither travel nor turn says how far the axis moves
POSITIONS = 100_000  # at which law and map are compared
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)  # a step whose multiples fall evenly, and on no grid


@dataclass(frozen=True)
class Frame:
    """The map as a drive sees it, at its own position p = direction (x - zero), in its own quantity.

    The drive adds to its command c(p) = direction sign scale F_cogging(x), x = zero + direction p. A drive that counts
    the other way also pushes the other way: hence the direction in front.

    Attributes:
        cogging: F_cogging(x), in the command unit of the model; None where all stands in `waves`.
        waves: effects of the model that are cogging, too: periods or changing amplitudes that a diagnosis has added.
        left_out: names of effects that push with the place and are no cogging.
        direction: 1, or -1 where the drive counts down as x rises.
        sign: 1, or -1 where the drive subtracts its table, or the map has the sign of the motor's push.
        scale: units of the drive per command unit of the model.
        zero: x at the drive's position 0.
        low, high: ends of the motion, x; infinite where they are not known.
        turn: x of one mechanical revolution; 0 = a linear axis.
        scale_said: whether somebody said the scale, by number or by the model's units.
    """

    cogging: CoggingModel | None
    waves: tuple[CoggingEffect, ...]
    left_out: tuple[str, ...]
    direction: int
    sign: int
    scale: float
    zero: float
    low: float
    high: float
    turn: float
    scale_said: bool

    @property
    def bounded(self) -> bool:
        """Whether both ends of the motion are known."""
        return math.isfinite(self.low) and math.isfinite(self.high)

    @property
    def periods(self) -> FloatArray:
        """The spatial periods of the map, (terms,)."""
        known = [] if self.cogging is None else [2.0 * math.pi / k for k in self.cogging.basis.wavenumbers]
        return np.array([*known, *(one.period for one in self.waves)], dtype=np.float64)

    @property
    def pitch(self) -> float:
        """That of the map; 0 where it has none."""
        return 0.0 if self.cogging is None else float(self.cogging.basis.pitch)

    @property
    def modulated(self) -> bool:
        """Whether amplitudes change along the travel."""
        known = self.cogging is not None and self.cogging.basis.spline.control_points > 1
        return known or any(isinstance(one, effects.CoggingModulation) for one in self.waves)

    def force(self, position: FloatArray) -> FloatArray:
        """F_cogging at x with those effects, in the command unit of the model."""
        total = np.zeros(position.shape)
        if self.cogging is not None:
            total += self.cogging.force(position)
        for one in self.waves:
            total -= laws_of(one).force_at(position=position)
        return total

    def place(self, position: FloatArray) -> FloatArray:
        """The drive's position p where the axis is at x."""
        return self.direction * (position - self.zero)

    def axis_position(self, place: FloatArray) -> FloatArray:
        """The other way round."""
        return self.zero + self.direction * place

    def wanted(self, position: FloatArray) -> FloatArray:
        """What the drive should add to its command at x, in its unit."""
        return self.gain * self.force(position)

    @property
    def gain(self) -> float:
        """Units of the drive per command unit of the model, with both signs."""
        return self.direction * self.sign * self.scale


def frame_of(
    model: Model,
    unit: str,
    *,
    scale: float | None = None,
    sign: int = 1,
    zero: float = 0.0,
    reverse: bool = False,
    turn: float | None = None,
) -> Frame:
    """See the map of a model as a drive does.

    Args:
        model: with `[cogging]`, or effects that are cogging.
        unit: what the drive takes.
        scale: units of the drive per command unit of the model; None where they are the same.
        sign: 1 or -1.
        zero: x at the drive's position 0.
        reverse: whether the drive counts and pushes the other way.
        turn: x of one revolution; None: 2 pi where the model's position is in rad, else a linear axis.
    """
    known = [one.resolved(model.axis, model.cogging) for one in model.effects]
    waves = tuple(one for one in known if isinstance(one, CoggingEffect))
    if model.cogging is None and not waves:
        raise ValueError("cogging: must be given to export a map, got a model without [cogging]")
    sizes = [] if model.cogging is None else [model.cogging.coefficients]
    if not any(np.any(size) for size in (*sizes, *(value for one in waves for value in (one.sine, one.cosine)))):
        raise ValueError("cogging: must have an amplitude other than 0, got a map without any: nothing to compensate")
    if sign not in (1, -1):
        raise ValueError(f"sign: must be 1 or -1, got {quoted(sign)}")
    if not math.isfinite(zero):
        raise ValueError(f"zero: must be finite, got {quoted(zero)}")
    if turn is None:
        turn = 2.0 * math.pi if model.units.position == "rad" else 0.0
    if turn < 0.0 or not math.isfinite(turn):
        raise ValueError(f"turn: must be finite and at least 0, got {quoted(turn)}")
    low, high = model.axis.travel
    said = scale is not None or model.units.command == unit
    factor = _scale(model, unit, scale)
    left_out = tuple(one.NAME for one in known if _pushes(one))
    frame = Frame(model.cogging, waves, left_out, -1 if reverse else 1, sign, factor, zero, low, high, turn, said)
    require_closed(frame)
    return frame


def _pushes(effect: Effect) -> bool:
    """Whether an effect that is no cogging acts by its place."""
    if isinstance(effect, (*OF_SPEED, CoggingEffect, effects.DisturbanceStep, effects.DisturbanceTone)):
        return False
    return bool({"force", "command_gain"} & set(effect.HOOKS))


def _scale(model: Model, unit: str, scale: float | None) -> float:
    stated = model.units.command
    if scale is None:
        if stated not in ("V", unit):  # V stands for whatever the amplifier takes
            rule = f"must be given, {unit} per {stated}: the drive takes {unit}"
            raise ValueError(f"scale: {rule}, got a model in {stated}")
        return 1.0
    if not (math.isfinite(scale) and scale > 0.0):
        raise ValueError(f"scale: must be finite and above 0 (see sign), got {quoted(scale)}")
    return scale


def require_closed(frame: Frame) -> None:
    """Refuse a map that is not the same after a turn of a rotary axis."""
    if frame.turn == 0.0:
        return
    for period in frame.periods:
        times = frame.turn / period
        if times < 0.5 or abs(times - round(times)) > CLOSES:
            rule = f"must be a whole number of times each period of the map, here {period:.6g}"
            raise ValueError(f"turn: {rule}, got {frame.turn:.6g}: {times:.4g} times")


def ends(frame: Frame, span: float) -> tuple[float, float]:
    """The motion over which law and map are compared, x: one turn, the travel, or as many spans as show what differs.

    Args:
        frame: of the drive.
        span: that the table covers.
    """
    if frame.turn > 0.0:
        return frame.zero, frame.zero + frame.turn
    if frame.bounded:
        return frame.low, frame.high
    return frame.zero, frame.zero + MANY_SPANS * span


def looked_at(frame: Frame, span: float) -> FloatArray:
    """Positions x of that motion, spread so that they fall evenly on every part of an entry, (n,)."""
    low, high = ends(frame, span)
    share = np.mod(GOLDEN * np.arange(1, POSITIONS + 1), 1.0)
    return np.asarray(low + (high - low) * share, dtype=np.float64)
