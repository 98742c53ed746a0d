"""How two recorded states differ: every number, label and sentence by its path.

Two numbers agree when they differ by at most 1e-9 of the larger, or by 1e-15 where both are below 1e-6 (SI: a
femtometre, far below any quantum or fit). Labels are texts of up to three words (verdicts, names, units) and must be
equal; longer texts are sentences, only listed. What is new in a later state is only listed; what is missing, and a
list of another length, is a failure.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

RELATIVE = 1e-9
SMALLEST = 1e-6  # a smaller number's difference is taken relative to this: 1e-15 is agreement
SHOWN = 10
LABEL_WORDS = 3


def leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Every number and text with its path, and the length of every list that is not made of sentences."""
    if isinstance(value, dict):
        for key, entry in value.items():
            yield from leaves(entry, f"{path}/{key}")
    elif isinstance(value, list):
        if not all(is_sentence(entry) for entry in value):
            yield f"{path}/length", len(value)
        for index, entry in enumerate(value):
            yield from leaves(entry, f"{path}/{index}")
    else:
        yield path, value


def is_sentence(value: Any) -> bool:
    """Whether a value is a text that may be put in other words."""
    return isinstance(value, str) and len(value.split()) > LABEL_WORDS


def is_number(value: Any) -> bool:
    """Whether a value is compared by size."""
    return isinstance(value, int | float) and not isinstance(value, bool)


@dataclass
class Comparison:
    """How a part differs from what was recorded.

    Attributes:
        values: numbers, hashes and labels that were compared.
        differ: of these, not the same in every bit.
        largest: relative difference of numbers, of those below SMALLEST relative to it.
        first: the first paths that differ, with both values.
        failures: numbers beyond the tolerance, labels that differ, what is missing.
        sentences: that differ.
        new: paths that were not recorded.
    """

    values: int = 0
    differ: int = 0
    largest: float = 0.0
    first: list[str] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    sentences: list[str] = field(default_factory=list)
    new: list[str] = field(default_factory=list)

    def number(self, line: str, was: float, now: float) -> None:
        """Take in two numbers that differ."""
        relative = abs(was - now) / max(abs(was), abs(now), SMALLEST)
        self.differ += 1
        self.first.append(line)
        self.largest = max(self.largest, relative)
        if not relative <= RELATIVE:
            self.failures.append(f"{line} (relative {relative:.2g})")

    def text(self) -> str:
        """What was found, in lines."""
        lines = [
            f"{self.values} values, {self.differ} differ in some bit, largest relative difference {self.largest:.3g}, "
            f"{len(self.failures)} failures, {len(self.sentences)} sentences differ, {len(self.new)} new values"
        ]
        parts = (("differs", self.first), ("FAILS", self.failures), ("sentence", self.sentences), ("new", self.new))
        for word, found in parts:
            lines += [f"  {word} {line}" for line in found[:SHOWN]]
            if len(found) > SHOWN:
                lines.append(f"  ... {len(found) - SHOWN} more of: {word}")
        return "\n".join(lines)


def compare(was: Any, now: Any) -> Comparison:
    """Compare what was recorded with what is."""
    found, after = Comparison(), dict(leaves(now))
    before = dict(leaves(was))
    for path, old in before.items():
        sentence = is_sentence(old)
        found.values += not sentence
        if path not in after:
            (found.sentences if sentence else found.failures).append(f"{path}: {old!r} is missing")
            continue
        new = after[path]
        if same(old, new):
            continue
        line = f"{path}: {old!r} -> {new!r}"
        if is_number(old) and is_number(new):
            found.number(line, old, new)
        elif sentence and isinstance(new, str):
            found.sentences.append(line)
        else:
            found.differ += 1
            found.first.append(line)
            if not path.endswith("/sha256"):  # the numbers beside a hash say how far its bytes are off
                found.failures.append(line)
    found.new = [f"{path}: {after[path]!r}" for path in after if path not in before]
    return found


def same(old: Any, new: Any) -> bool:
    """Equal in every bit; a whole number may be written as a float."""
    if is_number(old) and is_number(new):
        return old == new and math.copysign(1.0, old) == math.copysign(1.0, new)
    return bool(old == new)
