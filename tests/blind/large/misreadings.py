"""Logs that are read wrongly: a column with the wrong sign or in another unit, time in milliseconds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..machines import log_uniform
from .machines import LargeMachine

Columns = dict[str, np.ndarray]
POSITIONS = ("position", "reference", "reference_velocity", "reference_acceleration")
#: What may be wrong: sign or scale of command or position, scale of time.
KINDS = ("command sign", "position sign", "position scale", "command scale", "time scale")


@dataclass(frozen=True)
class Misreading:
    """What is wrong with a log: each of `columns` stands multiplied by `factor`; kind is "sign" or "scale"."""

    kind: str
    columns: tuple[str, ...]
    factor: float
    cause: str

    def apply(self, log: Mapping[str, np.ndarray]) -> Columns:
        """The log as it is read."""
        return {name: self.factor * column if name in self.columns else column for name, column in log.items()}


def draw_misreading(rng: np.random.Generator, machine: LargeMachine, kind: str) -> Misreading:
    """Draw how a column of this machine's logs is misread; references are with the position in half of the logs."""
    subject, what = kind.split()
    columns = POSITIONS if rng.random() < 0.5 else POSITIONS[:1]
    if subject == "time":
        return Misreading("scale", ("time",), 1e3, "ms")
    if subject == "command":
        if what == "sign":
            return Misreading("sign", ("command",), -1.0, "reversed")
        factor = log_uniform(rng, 12.0, 100.0) if rng.random() < 0.6 else 1e3
        return Misreading("scale", ("command",), float(factor ** rng.choice([-1.0, 1.0])), "force constant")
    if what == "sign":
        return Misreading("sign", columns, -1.0, "reversed")
    causes = {"mm": 1e3} if not machine.rotary else {"deg": 180 / np.pi, "turns": 1 / (2 * np.pi)}
    if machine.scalars["resolution"]:
        causes["counts"] = 1 / machine.scalars["resolution"]
    cause = str(rng.choice(list(causes)))
    return Misreading("scale", columns, float(causes[cause]), cause)
