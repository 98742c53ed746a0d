"""What a plan expects of its motion: one entry a pair of rivals, a detection limit, or an interval."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cogging.diagnosis.thresholds import EXPERIMENT
from cogging.files import FieldError
from cogging.model.model import is_number
from cogging.shown import quoted

#: What a plan may be for.
GOALS = ("separate", "detect", "fit")


@dataclass(frozen=True)
class Expectation:
    """What is expected of one thing that a plan is for.

    Attributes:
        name: of the effect; of a fit, the path of the parameter.
        alternative: the other name that it is held against; empty where there is none.
        parameter: field whose smallest visible size is told; empty where there is none.
        unit: of the numbers; "sigma" of rivals.
        expected: standard deviations between rivals, smallest size that would be seen with 95 % chance, or half of a
            95 % interval; None where the motion cannot tell.
        today: the same of what is known before the motion; None where that is not known.
    """

    name: str
    alternative: str
    parameter: str
    unit: str
    expected: float | None
    today: float | None

    def text(self) -> str:
        """One line."""
        today = "" if self.today is None else f"; today {self.today:.2g}"
        if self.alternative:
            if self.expected is None:
                return f"{self.name} and {self.alternative}: this motion could not be simulated for them"
            text = f"{self.name} and {self.alternative} will stand {self.expected:.2g} sigma apart{today}"
            return (
                text
                if self.expected >= EXPERIMENT.tells_nothing
                else f"{text}: no motion that was tried tells them apart"
            )
        unit = f" {self.unit}" if self.unit != "1" else ""
        today += unit if today else ""
        if self.parameter:
            if self.expected is None:
                return f"{self.name}: cannot be seen in this motion{today}"
            return f"{self.name}: {self.parameter} from {self.expected:.3g}{unit} on would be seen{today}"
        if self.expected is None:
            return f"{self.name}: not determined by this motion{today}"
        return f"{self.name}: to +- {self.expected:.3g}{unit}{today}"

    @classmethod
    def from_dict(cls, entry: Any, place: str) -> Expectation:
        """Read an entry of a plan.

        Raises:
            FieldError: a ValueError that names field, rule and value.
        """
        if not isinstance(entry, Mapping):
            raise FieldError("", place, f"must be a table, got {quoted(entry)}")
        words = {name: entry.get(name) for name in ("name", "alternative", "parameter", "unit")}
        for name, word in words.items():
            if not isinstance(word, str):
                raise FieldError(place, name, f"must be a text, got {quoted(word)}")
        numbers = {name: entry.get(name) for name in ("expected", "today")}
        for name, number in numbers.items():
            if number is not None and not is_number(number):
                raise FieldError(place, name, f"must be a number or null, got {quoted(number)}")
        return cls(**words, **numbers)  # type: ignore[arg-type]
