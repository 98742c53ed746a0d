"""Compensation maps in the formats of drives. drives.toml documents each drive; a function here writes its file.

The options `scale`, `sign`, `zero`, `reverse` and `turn` are those of `drive_table.frame_of`. Invalid options raise
ValueError.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from cogging.export.drive_table import NEGLIGIBLE, Frame, Law, Rest, Table, frame_of, table_of
from cogging.export.forms import Exported, require_positive
from cogging.files import shipped_toml
from cogging.model.model import Model
from cogging.shown import quoted

MOST_ENTRIES = 1 << 20
SHOWN = 5  # periods in a list
#: Titles of the entries of drives.toml, in the order of the text, with their keys.
QUESTIONS = {"takes": "quantity", "entries": "entries", "one entry": "quantum", "between entries": "between"}
QUESTIONS |= {"sign": "sign", "zero and direction": "zero", "loaded by": "loading", "source": "source"}
SHEETS: dict[str, dict[str, Any]] = shipped_toml("export/drives.toml")

# The drives -----------------------------------------------------------------------------------------------------------


def csv(
    model: Model, *, entries: int = 1000, over: str | None = None, between: str = "linear", **view: Any
) -> Exported:
    """Make a table of position and force, over the "travel", the "turn" or one "period"."""
    unit = model.units.command
    frame = frame_of(model, unit, **view)
    if over is None:
        over = "turn" if frame.turn > 0.0 else "travel" if frame.bounded else "period"
    _require_entries(entries)
    if over == "travel":
        low, high = _travel_of(frame)
        law = Law(entries, low, high - low, False, between)
    else:
        span = _turn_of(frame, "this range") if over == "turn" else frame.pitch or float(frame.periods.max())
        law = Law(entries, 0.0, span, True, between)
    table = table_of(frame, law, quantum=None)
    rows = [f"{place!r},{value!r}" for place, value in zip(law.places.tolist(), table.values.tolist(), strict=True)]
    return _exported(model, "csv", table, unit, ["position,force", *rows])


def akd(model: Model, *, entries: int = 8192, between: str = "linear", quantum: float = 0.001, **view: Any) -> Exported:
    """Make the csv of Kollmorgen AKD's compensation table; on a linear axis it covers the travel."""
    frame = frame_of(model, "A", **view)
    _require_entries(entries, 8192)
    notes = []
    if frame.turn > 0.0:
        law = Law(entries, 0.0, frame.turn, True, between)
    else:
        low, high = _travel_of(frame)
        law, ends = Law(entries, low, high - low, False, between), {"LOW": low, "HIGH": high}
        words = [f"COGCOMP.RANGE{name} to {end:.9g} {model.units.position}" for name, end in ends.items()]
        notes.append(f"set {' and '.join(words)}, in the drive's own unit")
    table = table_of(frame, law, quantum=require_positive("quantum", quantum))
    return _exported(model, "akd", table, "A", [f"{value:.9g}" for value in table.values.tolist()], notes)


def sinamics(model: Model, *, between: str = "hold", pole_pair_width: float | None = None, **view: Any) -> Exported:
    """Make the parameters of Siemens SINAMICS; on a linear axis they cover the travel."""
    turn, entries = view.get("turn"), 4096
    rotary = turn > 0.0 if turn is not None else model.units.position == "rad"
    unit = "Nm" if rotary else "N"
    frame = frame_of(model, unit, **view)
    if frame.turn > 0.0:
        span, factor = frame.turn, 1.0
    else:
        low, high = _travel_of(frame)
        width = pole_pair_width if pole_pair_width is not None else frame.pitch or high - low
        # The table repeats, and index 0 may be anywhere: two entries outside the travel separate its ends.
        span = (high - low) * entries / (entries - 2)
        factor = span / require_positive("pole_pair_width", width)
    table = table_of(frame, Law(entries, 0.0, span, True, between))
    rows = [f"p5260,{index},{_single(value)}" for index, value in enumerate(table.values.tolist())]
    return _exported(model, "sinamics", table, unit, ["parameter,index,value", *rows], [f"set p5253 to {factor:.9g}"])


def novanta(
    model: Model,
    *,
    entries: int | None = None,
    pole_pairs: int | None = None,
    pole_pair_width: float | None = None,
    between: str = "linear",
    **view: Any,
) -> Exported:
    """Make the list of index and value of a Novanta Summit, over one electrical period."""
    if entries is None:
        raise ValueError("entries: must be given: as many as register 0x2307 of the drive has, got nothing")
    frame = frame_of(model, "A", **view)
    if frame.turn > 0.0:
        if not isinstance(pole_pairs, int) or pole_pairs < 1:
            rule = "must be a whole number of at least 1 on a rotary axis"
            raise ValueError(f"pole_pairs: {rule}, got {pole_pairs or 'nothing'}")
        span = frame.turn / pole_pairs
    else:
        width = frame.pitch if pole_pair_width is None else pole_pair_width
        if width == 0.0 and pole_pair_width is None:
            raise ValueError("pole_pair_width: must be given for a map of periods without a pitch, got nothing")
        span = require_positive("pole_pair_width", width)
    table = table_of(frame, Law(_require_entries(entries), 0.0, span, True, between))
    rows = [f"{index},{_single(value)}" for index, value in enumerate(table.values.tolist())]
    return _exported(model, "novanta", table, "A", ["index,value", *rows], ["set 0x2306 to 1, then store all"])


def odrive(model: Model, *, quantity: str = "torque", **view: Any) -> Exported:
    """Make the array of an ODrive's map, of "torque" or "current"."""
    unit, entries = "Nm" if quantity == "torque" else "A", 3600
    frame = frame_of(model, unit, **view)
    table = table_of(frame, Law(entries, 0.0, _turn_of(frame, "the map of an ODrive"), True, "hold"))
    head = [f"// ODrive 0.5 anticogging map, {unit}, entry i from i/{entries} of a turn on", "{"]
    rows = [f"    {_single(value)}f," for value in table.values.tolist()]
    return _exported(model, "odrive", table, unit, [*head, *rows, "}"])


def moteus(model: Model, **view: Any) -> Exported:
    """Make the lines that set the table of a moteus: whole numbers from -127 to 127 and their factor."""
    frame = frame_of(model, "A", **view)
    table = table_of(frame, Law(1024, 0.0, _turn_of(frame, "the table of a moteus"), True, "linear"), steps=127)
    quantum = table.quantum or 1.0
    whole = np.round(table.values / quantum).astype(int).tolist()
    rows = [f"conf set motor.cogging_dq_comp.{index} {value}" for index, value in enumerate(whole)]
    lines = [f"conf set motor.cogging_dq_scale {_single(quantum)}", *rows, "conf write"]
    return _exported(model, "moteus", table, "A", lines)


COEFFICIENTS, MOST_A_TURN = 10, 200  # of an AX8000
POINTS = 1 << 14  # at which a turn of the map is analysed
SMALLEST = 1e-6  # of the largest wave: smaller ones are numerical


def ax8000(model: Model, *, wave: str = "cosine", channel: str = "A", **view: Any) -> Exported:
    """Make the objects of a Beckhoff AX8000: up to ten waves a turn, with "cosine" or "sine" phase, channel A or B."""
    frame = frame_of(model, "Nm", **view)
    _turn_of(frame, "an AX8000 has coefficients for rotary motors alone (0x32D3 has none) and")
    wanted = frame.wanted(frame.axis_position(frame.turn * (np.arange(POINTS) / POINTS)))
    waves = np.fft.rfft(wanted)[: MOST_A_TURN + 1] * (2.0 / POINTS)
    sizes, phases = np.abs(waves), np.degrees(np.angle(waves)) + (90.0 if wave == "sine" else 0.0)
    order = [int(n) for n in np.argsort(sizes)[::-1] if n > 0 and sizes[n] > SMALLEST * sizes.max()]
    # n, phi (degrees, 0 to 360) and r (Nm) of each coefficient, r cos(n angle + phi) or sin.
    found = [(n, float(np.float32(float(phases[n]) % 360.0)) % 360.0, float(np.float32(sizes[n]))) for n in order]
    kept, more = found[:COEFFICIENTS], found[COEFFICIENTS:]
    held = [*kept, *[(0, 0.0, 0.0)] * (COEFFICIENTS - len(kept))]
    index = "32CB" if channel == "A" else "36CB"
    lines = ["object,type,value", f"{index}:01,INT16,3", f"{index}:02,REAL32,1.0"]
    for number, (n, phase, size) in enumerate(held):  # from subindex 7 on
        values = (("UINT32", str(n)), ("REAL32", _single(phase)), ("REAL32", _single(size)))
        lines += [f"{index}:{7 + 3 * number + k:02X},{kind},{value}" for k, (kind, value) in enumerate(values)]
    x, unit, gain = frame.compared(frame.turn), model.units.command, abs(frame.gain)
    shape, angle = np.sin if wave == "sine" else np.cos, frame.place(x) / frame.turn
    parts = [size * shape(2.0 * np.pi * n * angle + np.radians(phase)) for n, phase, size in kept]
    wanted = frame.wanted(x)
    left = wanted - (np.sum(parts, axis=0) if parts else 0.0)
    rest = Rest(float(np.sqrt(np.mean(wanted**2))) / gain, float(np.sqrt(np.mean(left**2))) / gain)
    cannot = []
    if more:
        power = float(np.sqrt(0.5 * sum(size**2 for *_, size in more))) / gain
        listed = _listed([str(n) for n, *_ in more])
        cannot.append(f"cannot hold {power:.3g} {unit} rms: more than {COEFFICIENTS} waves: {listed}")
    beyond = [f"{frame.turn / period:.0f}" for period in frame.periods if round(frame.turn / period) > MOST_A_TURN]
    if beyond:
        cannot.append(f"cannot hold waves of more than {MOST_A_TURN} a turn: {', '.join(beyond[:SHOWN])}")
    mean = float(wanted.mean()) / gain
    if abs(mean) > 1e-3 * rest.cogging:
        cannot.append(f"cannot hold the mean, {mean:.3g} {unit}")
    listed = ", ".join(str(n) for n, *_ in kept) or "none"
    what = f"{len(kept)} of {COEFFICIENTS} coefficients, waves a turn: {listed}; "
    return _written(model, "ax8000", frame, "Nm", lines, what, rest, cannot)


# The writer -----------------------------------------------------------------------------------------------------------


def _exported(
    model: Model, name: str, table: Table, unit: str, lines: Iterable[str], notes: Iterable[str] = ()
) -> Exported:
    """Return the file of a table from its lines, with text and summary; notes: what to set in the drive."""
    law, frame, units, rest = table.law, table.frame, model.units, table.rest
    bits = f"{53 if table.quantum is None else 24}-bit numbers in {unit}"
    entry = f"steps of {table.quantum:.6g} {unit}" if table.quantum else bits
    size = max(abs(float(table.values.max())), abs(float(table.values.min())))
    what = (
        f"{law.entries} entries, {entry}, largest {size:.6g} {unit}\n"
        f"over {law.span:.6g} {units.position} of the drive's own position, from {law.start:.6g}, "
        f"{'repeated' if law.wraps else 'nothing outside'}; "
    )
    cannot = []
    if rest.span > NEGLIGIBLE * rest.cogging and law.wraps:
        why = []
        if found := frame.misfits(law.span):
            periods = _listed([f"{period:.5g}" for period in found])
            why.append(f"periods that do not go into {law.span:.5g} {units.position}: {periods}")
        if frame.modulated:
            why.append("amplitudes that change along the travel")
        cannot.append(f"cannot hold {rest.span:.3g} {units.command} rms: {'; '.join(why) or 'other spans differ'}")
    if rest.entries > NEGLIGIBLE * rest.cogging:
        cannot.append(f"leaves {rest.entries:.3g} {units.command} rms between its entries and in their last digit")
    return _written(model, name, frame, unit, lines, what, rest, cannot, notes)


def _written(
    model: Model,
    name: str,
    frame: Frame,
    unit: str,
    lines: Iterable[str],
    what: str,
    rest: Rest,
    cannot: Iterable[str],
    notes: Iterable[str] = (),
) -> Exported:
    """Return a file from its lines with its summary: what it holds, what it leaves, what is assumed."""
    units = model.units
    way = "counts as the model does" if frame.direction > 0 else "counts and pushes the other way"
    sign = "adds the entry to its command" if frame.sign > 0 else "takes the entry off its command"
    scaled = frame.scale != 1.0 or unit != units.command
    scale = f", {frame.scale:.6g} {unit} per {units.command}" if scaled else ""
    said = [
        f"{SHEETS[name]['drive']}: {what}its zero at {frame.zero:.6g} {units.position}, it {way} and {sign}{scale}",
        f"removes {100.0 * rest.removed:.5g} % of the cogging's rms, {rest.cogging:.4g} {units.command} to "
        f"{rest.left:.3g} {units.command}, if the drive reads it so",
        *cannot,
    ]
    if frame.left_out:
        said.append(f"not in it, as no cogging: {', '.join(frame.left_out)}")
    if not frame.scale_said:
        said.append(f"assumed: 1 {units.command} of the model is 1 {unit} (--scale, or [units] of the model)")
    sheet = SHEETS[name]
    said += [f"assumed: {one}" for one in sheet["assumed"]]
    known = [f"{title + ':':20s}{sheet[key]}" for title, key in QUESTIONS.items()]
    known += [f"{'assumed:':20s}{one}" for one in sheet["assumed"]]
    beside = "\n".join([sheet["drive"], *known, "", "This file:", *notes, *said, ""])
    return Exported(("\n".join(lines) + "\n").encode(), "\n".join([*said, *notes]), {".txt": beside.encode()})


def _listed(words: list[str]) -> str:
    return ", ".join(words[:SHOWN]) + ", ..." * (len(words) > SHOWN)


def _single(value: float) -> str:
    """Return a number of 24 bits in as few digits as restore it."""
    return str(np.float32(value))


def _require_entries(entries: int, most: int = MOST_ENTRIES) -> int:
    if not isinstance(entries, int) or not 2 <= entries <= most:
        raise ValueError(f"entries: must be a whole number from 2 to {most}, got {quoted(entries)}")
    return entries


def _turn_of(frame: Frame, drive: str) -> float:
    """Return the turn, for a drive whose table covers a revolution."""
    if frame.turn == 0.0:
        raise ValueError(f"turn: must be given: {drive} covers one revolution, got a linear axis")
    return frame.turn


def _travel_of(frame: Frame) -> tuple[float, float]:
    """Return the ends of the motion at the drive's own position."""
    if not frame.bounded:
        rule = "must have two finite ends where a table covers the travel of a linear axis (or give turn)"
        raise ValueError(f"axis.travel: {rule}, got [{frame.low:g}, {frame.high:g}]")
    low, high = np.sort(frame.place(np.array([frame.low, frame.high])))
    return float(low), float(high)
