"""What the header of a column says: what it holds, and in which unit."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from cogging.logs.readers.column_request import bracketed, split_unit

#: Words of a column's name by what it holds, the surer ones first; of English and German drives and loggers.
NAMES = {
    "reference_velocity": (
        "reference_velocity velocity_reference v_ref vref v_soll sollgeschwindigkeit "
        "velocity_demand velocity_setpoint target_velocity velocity_command"
    ),
    "reference_acceleration": (
        "reference_acceleration acceleration_reference a_ref aref a_soll sollbeschleunigung "
        "acceleration_demand target_acceleration"
    ),
    "reference": (
        "reference position_reference reference_position position_setpoint setpoint_position "
        "position_demand demand_position target_position position_target position_command pos_ref "
        "x_ref xref x_soll sollposition position_soll lagesollwert sollwert x_cmd pos_cmd setpoint "
        "target soll qg xd x_d q_ref qref ref r theta_ref"
    ),
    "velocity": (
        "velocity velocity_actual actual_velocity speed geschwindigkeit istgeschwindigkeit drehzahl "
        "v_ist v vel qd dq omega xdot dx"
    ),
    "acceleration": "acceleration beschleunigung acc a qdd ddx",
    "error": "error position_error following_error error_position schleppfehler lageabweichung err",
    "time": "time zeit timestamp time_stamp zeitstempel t sec elapsed clock ticks",
    "position": (
        "position actual_position position_actual istposition position_ist lageistwert lage pos "
        "encoder x_ist weg x q qm x_m y pos_act angle theta winkel phi displacement "
        "encoder_position encoder_counts x_meas x_act istwert"
    ),
    "command": (
        "command iq current motor_current strom motorstrom i_q current_command iq_ref force "
        "force_command kraft vir torque drehmoment moment u control control_output stellgrosse "
        "stellgröße stellgroesse voltage spannung dac output effort tau f i cmd thrust iq_cmd sollstrom "
        "stromsollwert iq_actual current_setpoint current_actual"
    ),
}
WORDS = {kind: tuple(words.split()) for kind, words in NAMES.items()}
#: Factors to SI of what a position, a time or a command may be written in, and the label that the command keeps.
LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "micron": 1e-6, "microns": 1e-6, "nm": 1e-9}
LENGTHS |= {
    "cm": 1e-2,
    "km": 1e3,
    "in": 0.0254,
    "inch": 0.0254,
    "meter": 1.0,
    "metre": 1.0,
    "meters": 1.0,
    "metres": 1.0,
}
ANGLES = {"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180.0, "°": math.pi / 180.0, "grad": math.pi / 180.0}
ANGLES |= {
    "rev": 2.0 * math.pi,
    "revs": 2.0 * math.pi,
    "turn": 2.0 * math.pi,
    "turns": 2.0 * math.pi,
    "u": 2.0 * math.pi,
}
COUNTS = ("counts", "count", "cnt", "cnts", "inc", "incs", "inkr", "inkremente", "ticks", "steps", "lsb")
TIMES = {"s": 1.0, "sec": 1.0, "second": 1.0, "seconds": 1.0, "sek": 1.0, "sekunden": 1.0, "ms": 1e-3, "msec": 1e-3}
TIMES |= {"us": 1e-6, "µs": 1e-6, "μs": 1e-6, "usec": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0}
COMMANDS = {"V": (1.0, "V"), "A": (1.0, "A"), "N": (1.0, "N"), "Nm": (1.0, "Nm"), "mV": (1e-3, "V"), "mA": (1e-3, "A")}
COMMANDS |= {"mN": (1e-3, "N"), "kN": (1e3, "N"), "kA": (1e3, "A"), "mNm": (1e-3, "Nm"), "%": (1.0, "%")}
COMMANDS |= {"volt": (1.0, "V"), "volts": (1.0, "V"), "ampere": (1.0, "A"), "amps": (1.0, "A"), "newton": (1.0, "N")}
COMMANDS |= {"Arms": (1.0, "Arms"), "Apk": (1.0, "Apk"), "amp": (1.0, "A"), "lbf": (4.4482216, "N")}
TORQUES = ("Nm", "mNm")
#: A unit that stands behind a name without brackets: `x_mm`, `x / mm`, `x, mm`, `x in mm`, `x mm`.
BEHIND = re.compile(r"(.+?)(?:\s*/\s*|\s*,\s*|\s+in\s+|[\s_.-]+)([^\s_/,()\[\]]+)")
LONGEST = 200  # characters of a name that is looked at for a unit behind it, in a time that grows as their square
#: Last parts of a column's name that say that an axis turns: what drives it, and where it is.
TORQUE, ANGLE = (
    re.compile(r"(?:(?:^|_)tau|torque|moment)\d*(?:_|$)"),
    re.compile(r"(?:(?:^|_)(?:theta|phi)|angle|winkel)\d*(?:_|$)"),
)
RATES = re.compile(r"(?:.+/(?:s|sec|min|s\^?2|s²)|rpm|1/min|U/min|Hz)", re.IGNORECASE)


@dataclass(frozen=True)
class Header:
    """What the text above a column says.

    Attributes:
        label: the whole text.
        bare: the name without its unit.
        unit: as it stands there, or "".
        kind: what the column holds, a key of WORDS, or "".
        rank: 0 where the name is the plainest one for that, more where it is less.
    """

    label: str
    bare: str
    unit: str
    kind: str
    rank: int

    @property
    def kind_of_unit(self) -> str:
        """What a column of no telling name holds by its unit: a position, a command, or nothing that is known."""
        if self.kind or not self.unit:
            return ""
        return "command" if self.unit in COMMANDS else "" if self.is_angle is None else "position"

    @property
    def is_torque(self) -> bool:
        """Whether it is one by its unit, or else by its name."""
        return self.unit in TORQUES or (not self.unit and TORQUE.search(_plain(self.bare)) is not None)

    @property
    def is_angle(self) -> bool | None:
        """Whether it is one by its unit, or else by its name; None where neither says so."""
        for known, angle in ((LENGTHS, False), (ANGLES, True)):
            if self.unit in known or self.unit.lower() in known:
                return angle
        return True if ANGLE.search(_plain(self.bare)) else None


def header_of(label: str, apart: str = "") -> Header:
    """What a column's name says, with a unit that the file states apart from it."""
    bare, unit = split_unit(label)
    unit = unit or apart.strip()
    if not unit:
        bare, unit = _behind(label)
    name, inside, _ = bracketed(label)
    if not unit and name and _is_unit(inside):
        bare, unit = name, inside
    kind, rank = _kind(bare)
    if kind in ("position", "reference") and RATES.fullmatch(unit):  # `x [mm/s]`
        kind = "velocity" if kind == "position" else "reference_velocity"
    return Header(label, bare.strip(), unit, kind, rank)


def _behind(label: str) -> tuple[str, str]:
    """A name and the unit that stands behind it without brackets, or no unit."""
    found = BEHIND.fullmatch(label.strip()) if len(label) <= LONGEST else None
    if found is None or not _is_unit(found.group(2)):
        return label, ""
    alone = found.group(2) in ("u", "h", "in", "f", "A", "V", "N", "m", "s", "U", "min")
    named = _kind(found.group(1))[0]
    lengths = {*LENGTHS, *ANGLES, *COUNTS}
    right = {"time": set(TIMES), "command": set(COMMANDS)}.get(named, lengths)
    if (alone and not named) or (named and found.group(2) not in right and not RATES.fullmatch(found.group(2))):
        return label, ""  # `joint u`, `x_A`: part of the name
    return found.group(1), found.group(2)


def _is_unit(text: str) -> bool:
    return any(text in known or text.lower() in known for known in (LENGTHS, ANGLES, COUNTS, TIMES)) or (
        text in COMMANDS or RATES.fullmatch(text) is not None
    )


def _plain(bare: str) -> str:
    """A name in small letters, its parts joined by underscores."""
    return "_".join(re.findall(r"[a-zäöüß0-9]+", re.sub(r"(?<=[a-z])(?=[A-Z])", "_", bare.strip()).lower()))


def _kind(bare: str) -> tuple[str, int]:
    """What a name says that a column holds, and how plainly."""
    plain = _plain(bare)
    for kind, words in WORDS.items():
        if plain in words or plain.replace("_", "") in words:
            place = words.index(plain) if plain in words else words.index(plain.replace("_", ""))
            return kind, place
    parts = set(plain.split("_"))
    best = ("", 0)
    for kind, words in WORDS.items():
        inside = [w for w in words if len(w) > 3 and (w in plain or set(w.split("_")) <= parts)]
        longest = max(map(len, inside), default=0)
        if longest > best[1]:
            best = (kind, longest)
    if best[0] and parts & {"ref", "reference", "soll", "setpoint", "demand", "target", "cmd", "sollwert"}:
        kind = {"position": "reference", "velocity": "reference_velocity"}.get(best[0], best[0])
        best = ({"acceleration": "reference_acceleration"}.get(kind, kind), best[1])
    if not best[0]:  # the first part of a short name: `x_axis1`, `iq_filtered`
        first = plain.split("_")[0]
        short = [(kind, words.index(first)) for kind, words in WORDS.items() if first in words]
        return (short[0][0], 60 + short[0][1]) if short and len(parts) > 1 else ("", 0)
    return best[0], 100 - best[1]
