"""Beckhoff AX8000: the ten coefficients of object 0x32CB, the synchronous motor's cogging compensation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cogging.arrays import FloatArray
from cogging.export.drives.form import require_turn, single
from cogging.export.drives.frame import Frame, frame_of, looked_at
from cogging.export.drives.sheet import Sheet
from cogging.export.drives.table import Rest
from cogging.export.drives.told import SHOWN, assumed_lines, frame_line, left_out_lines, rest_lines
from cogging.export.forms import Exported
from cogging.model.model import Model
from cogging.shown import quoted

COEFFICIENTS, MOST_A_TURN = 10, 200
FIRST = 0x07  # subindex of coefficient 0's n, followed by its phi and r
OBJECTS = {"A": 0x32CB, "B": 0x36CB}
POINTS = 1 << 14  # at which a turn of the map is analysed
SMALLEST = 1e-6  # of the largest wave: what is below is the analysis' own
WAVES = ("cosine", "sine")
SHEET = Sheet(
    drive="Beckhoff AX8000, object 0x32CB (channel B: 0x36CB)",
    quantity="torque, Nm",
    entries="10 coefficients: n waves a turn (0 to 200), phi (0 to 360 degrees), r (Nm, at least 0)",
    quantum="n whole; phi and r 32-bit floating point numbers",
    between="waves, no entries",
    sign="a torque beside the controller's own (3241:0C shows it), times the gain 32CB:02",
    zero="assumed: angle 0 at the mechanical zero of the feedback; angles go with the drive's count",
    loading="startup list: the file's objects (index:subindex, type, value), 32CB:01 = 3 "
    "(Use_startuplist_cogging_comp_para)",
    source="Beckhoff Information System, AX8xxx objects: 32CB:x SynchronousMotor cogging compensation, 32CB:01, :02, "
    ":07 to :24 (infosys.beckhoff.com/content/1033/ax8xxx_object/18801490571.html). For linear motors 32D3:x "
    "(content/1031/ax8xxx_object/18801882123.html) shows a switch and a connected TcCOM object, no coefficients",
    assumed=(
        "torque = gain sum r cos(n angle + phi) (--wave sine)",
        "a positive torque turns the way the drive counts up (--sign)",
        "the angle is the mechanical one, 0 at the feedback's zero (--zero, --reverse)",
    ),
)


@dataclass(frozen=True)
class Wave:
    """One coefficient: r cos(n angle + phi), or sin.

    Attributes:
        times: n, a turn.
        phase: phi, degrees, 0 to 360.
        size: r, Nm.
    """

    times: int
    phase: float
    size: float


def make(
    model: Model,
    *,
    scale: float | None = None,
    sign: int = 1,
    zero: float = 0.0,
    reverse: bool = False,
    turn: float | None = None,
    wave: str = "cosine",
    channel: str = "A",
) -> Exported:
    """Make the list of objects.

    Args:
        model: with `[cogging]`, rotary.
        scale, sign, zero, reverse, turn: see frame_of.
        wave: "cosine" or "sine".
        channel: "A" or "B".

    Raises:
        ValueError: what cannot be used; a linear axis.
    """
    for name, value, words in (("wave", wave, WAVES), ("channel", channel, tuple(OBJECTS))):
        if value not in words:
            raise ValueError(f"{name}: must be one of {', '.join(words)}, got {quoted(value)}")
    frame = frame_of(model, "Nm", scale=scale, sign=sign, zero=zero, reverse=reverse, turn=turn)
    require_turn(frame, "an AX8000 has coefficients for rotary motors alone (0x32D3 has none) and")
    found = waves_of(frame, wave)
    kept = [*found[:COEFFICIENTS], *[Wave(0, 0.0, 0.0)] * (COEFFICIENTS - len(found))]
    index = OBJECTS[channel]
    lines = ["object,type,value", f"{index:04X}:01,INT16,3", f"{index:04X}:02,REAL32,1.0"]
    for number, one in enumerate(kept):
        values = (("UINT32", str(one.times)), ("REAL32", single(one.phase)), ("REAL32", single(one.size)))
        lines += [f"{index:04X}:{FIRST + 3 * number + k:02X},{kind},{value}" for k, (kind, value) in enumerate(values)]
    said = _told(model, frame, found, wave)
    beside = "\n".join([SHEET.text(), "", "This file:", said, ""])
    return Exported(("\n".join(lines) + "\n").encode(), said, {".txt": beside.encode()})


def waves_of(frame: Frame, wave: str) -> list[Wave]:
    """The waves of the map a turn, largest first, as the drive keeps them."""
    angle = np.arange(POINTS) / POINTS
    wanted = frame.wanted(frame.axis_position(frame.turn * angle))
    lines = np.fft.rfft(wanted)[: MOST_A_TURN + 1] * (2.0 / POINTS)
    sizes = np.abs(lines)
    order = [int(n) for n in np.argsort(sizes)[::-1] if n > 0 and sizes[n] > SMALLEST * sizes.max()]
    turned = np.degrees(np.angle(lines)) + (90.0 if wave == "sine" else 0.0)
    return [Wave(n, _single(float(turned[n]) % 360.0) % 360.0, _single(float(sizes[n]))) for n in order]


def torque_of(waves: list[Wave], wave: str, angle: FloatArray) -> FloatArray:
    """What the drive adds, Nm, at angles in turns."""
    shape = np.sin if wave == "sine" else np.cos
    parts = [one.size * shape(2.0 * np.pi * one.times * angle + np.radians(one.phase)) for one in waves]
    return np.sum(parts, axis=0) if parts else np.zeros(angle.shape)


def _single(value: float) -> float:
    return float(np.float32(value))


def _told(model: Model, frame: Frame, found: list[Wave], wave: str) -> str:
    """What the drive takes of the map and what it cannot, in lines for the screen."""
    x, unit = looked_at(frame, frame.turn), model.units.command
    wanted = frame.wanted(x)
    kept = found[:COEFFICIENTS]
    left = wanted - torque_of(kept, wave, frame.place(x) / frame.turn)
    size, gain = np.sqrt(np.mean(wanted**2)), abs(frame.gain)
    rest = Rest(float(size) / gain, float(np.sqrt(np.mean(left**2))) / gain, 0.0, 0.0)
    waves = ", ".join(f"{one.times}" for one in kept) or "none"
    lines = [
        f"{SHEET.drive}: {len(kept)} of {COEFFICIENTS} coefficients, waves a turn: {waves}; "
        f"{frame_line(frame, model.units, 'Nm')}",
        *rest_lines(rest, unit),
    ]
    more = found[COEFFICIENTS:]
    if more:
        power = float(np.sqrt(0.5 * sum(one.size**2 for one in more))) / gain
        listed = ", ".join(str(one.times) for one in more[:SHOWN]) + ", ..." * (len(more) > SHOWN)
        lines.append(f"cannot hold {power:.3g} {unit} rms: more than {COEFFICIENTS} waves: {listed}")
    beyond = [period for period in frame.periods if round(frame.turn / period) > MOST_A_TURN]
    if beyond:
        listed = ", ".join(f"{frame.turn / period:.0f}" for period in beyond[:SHOWN])
        lines.append(f"cannot hold waves of more than {MOST_A_TURN} a turn: {listed}")
    mean = float(wanted.mean()) / gain
    if abs(mean) > 1e-3 * rest.cogging:
        lines.append(f"cannot hold the mean, {mean:.3g} {unit}")
    return "\n".join([*lines, *left_out_lines(frame), *assumed_lines(frame, model.units, "Nm", SHEET.assumed)])
