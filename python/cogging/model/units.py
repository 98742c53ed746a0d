"""Unit labels of a model: V and m, or the machine's own."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cogging.calls import Kind, check_constructor
from cogging.files import errors_of_section, refuse_unknown_keys
from cogging.shown import quoted
from cogging.values import ByValue

UNIT_KEYS = ("command", "position")
#: A label: a letter, then letters, digits and operators of units; or per cent.
LABEL = re.compile(r"[^\W\d_][\w^*/.()%-]{0,11}|%")
#: V or m in a unit, alone or with a prefix.
WORD = re.compile(r"(?<![A-Za-z*·])([kmunµ]?)([Vm])(?![A-Za-z])")


@check_constructor
@dataclass(frozen=True, eq=False, repr=False)
class Units(ByValue):
    """Labels of the units of command and position, `[units]` of a model file; numbers do not change.

    In this package V stands for the unit of the command and m for that of the position. The labels of a model appear in
    all output: a mass in N/(m/s^2), a friction in A/(rad/s).

    Attributes:
        command: "V", or "A", "N", "Nm".
        position: "m", or "rad".

    Example:
        >>> units = cogging.Units(command="A", position="rad")
        >>> units.of("V/(m/s)"), units.of("um"), units.of("Hz")
        ('A/(rad/s)', 'urad', 'Hz')
    """

    command: str = "V"
    position: str = "m"

    def __post_init__(self) -> None:
        for key in UNIT_KEYS:
            value = getattr(self, key)
            if not isinstance(value, str) or not LABEL.fullmatch(value):
                rule = 'must be the label of a unit of at most 12 characters, as "A" or "Nm"'
                raise ValueError(f"{key}: {rule}, got {quoted(value)}")

    def of(self, unit: str) -> str:
        """Return a unit in V and m with these labels; `um` of a position in rad is `urad`.

        Args:
            unit: as "V/(m/s^2)", "mV", "1/m".
        """
        if self.command == "V" and self.position == "m":
            return unit
        return WORD.sub(lambda word: word[1] + (self.command if word[2] == "V" else self.position), unit)

    @classmethod
    def from_dict(cls, section: Mapping[str, Any]) -> Units:
        """Return the labels in `[units]` of a model file.

        Raises:
            FieldError: an unknown key, or a value that is no label.
        """
        refuse_unknown_keys(section, UNIT_KEYS, "units")
        with errors_of_section("units"):
            return cls(**section)

    def to_dict(self) -> dict[str, str]:
        """Return the section `[units]`, which from_dict reads."""
        return {key: getattr(self, key) for key in UNIT_KEYS}


UNITS = Kind((Units, type(None)), "Units(command=..., position=...)")
