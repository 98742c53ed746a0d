"""A first model and a first reference, with what was found and what could not be told."""

from __future__ import annotations

import json
import math
import os
import shlex
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cogging._core import Reference
from cogging.arrays import FloatArray
from cogging.files import InputError, parse_toml
from cogging.first_model.column_guess import ColumnGuesses
from cogging.first_model.model_text import MARGIN, model_lines, number
from cogging.first_model.moves import Motion
from cogging.first_model.pitch import Wave
from cogging.first_model.sizes import Sizes
from cogging.first_model.units import STATED
from cogging.identification.identify import FEWEST_ROWS
from cogging.log_check.audit import Audit
from cogging.log_check.recovery import RecoveredController
from cogging.logs.log import Log
from cogging.model.model import Model
from cogging.model.units import Units
from cogging.outputs import write_files
from cogging.shown import printable
from cogging.simulation.reference import reference_from
from cogging.values import ByValue

ROWS_OF_REFERENCE = 20_000  # of a sampled motion that are kept
SMOOTHED = 0.002  # of its length, over which readings make a reference


@dataclass(frozen=True, eq=False, repr=False)
class ModelDraft(ByValue):
    """What a log shows of the axis that made it, and a first model and reference of it.

    Attributes:
        source: what the log is called.
        log: in SI, as the options below have it read.
        columns: which column of the file is what, and how that is known; None of a log in memory.
        audit: of the log.
        motion: that the reference has, or else the position.
        seen_in: "reference" or "position".
        sizes: mass and friction of a first force balance.
        wave: over position that stands out of what they leave; None where none does.
        controller: of known kind that made the command; None where none did, or no reference is there.
        units: labels of command and position.
        scale: factors that `--scale` must give, the command's sign included.
        rows: data rows that were taken; None: all.
        likely: what was guessed with good reason, and may be checked.
        unsure: what could not be told, each with what to do.
        model: the model that `model_text` says.

    Example:
        >>> draft = cogging.draft_model(log)
        >>> print(f"{draft.model.axis.mass:.2f} V/(m/s^2), {draft.motion.kind}")
        0.12 V/(m/s^2), point_to_point
    """

    source: str
    log: Log
    columns: ColumnGuesses | None
    audit: Audit
    motion: Motion
    seen_in: str
    sizes: Sizes
    wave: Wave | None
    controller: RecoveredController | None
    units: Units
    scale: Mapping[str, float]
    rows: slice | None
    likely: tuple[str, ...]
    unsure: tuple[str, ...]

    @property
    def model(self) -> Model:
        """The model that the file will hold."""
        return Model.from_dict(parse_toml(self.model_text()))

    @property
    def reference(self) -> Reference:
        """The motion that the reference file will hold."""
        if self.motion.kind in ("sampled", "rest"):
            return reference_from({"type": "sampled", **self._samples()})[0]
        return reference_from({"type": self.motion.kind, **self.motion.fields, "duration": self._duration()})[0]

    def options(self) -> list[str]:
        """Words of the command line that have the log read as it was read here."""
        words: list[str] = []
        if self.columns is not None and self.columns.columns:
            words += ["--columns", ",".join(f"{name}={there}" for name, there in self.columns.columns.items())]
        if self.scale:
            words += ["--scale", ",".join(f"{name}={factor:.10g}" for name, factor in self.scale.items())]
        if self.rows is not None:
            words += ["--rows", f"{self.rows.start or 0}:{'' if self.rows.stop is None else self.rows.stop}"]
        return words

    def next_command(self, model: str | os.PathLike[str]) -> str:
        """The command to give next: a fit of the model, or where nothing moves an audit."""
        fits = self.sizes.explained is not None and len(self.log) >= FEWEST_ROWS
        words = ["cogging", "identify" if fits else "audit", self.source, "--model", os.fspath(model)]
        words += ["--out", "fitted.toml"] * fits
        return shlex.join([*words, *self.options()])

    def model_text(self) -> str:
        """The model file: TOML with a comment on each number."""
        told = ("not known: edit it", "not known: edit it")
        if self.columns is not None:
            told = (self.columns.used["command"].unit.told, self.columns.used["position"].unit.told)
        lines = model_lines(
            printable(Path(self.source).name),
            self.units,
            told,
            self.sizes,
            self._travel(),
            self.audit,
            self.controller,
            self.wave,
        )
        return "\n".join(lines) + "\n"

    def reference_text(self, samples: str = "reference.csv") -> str:
        """The reference file: TOML with a comment on each number.

        Args:
            samples: file of the samples where the motion is told by nothing less.
        """
        head = f"## The motion of {printable(Path(self.source).name)}, by `cogging init`, seen in its {self.seen_in}:"
        lines = [head, f"## {self.motion.told}", ""]
        if self.motion.kind in ("sampled", "rest"):
            lines += ['type = "sampled"', f"file = {_quoted(samples)}   # time (s), reference"]
            return "\n".join(lines) + "\n"
        if self.motion.kind == "sine":
            lines.insert(2, "## It begins at the center, moving forward: the log may begin elsewhere in the period.")
        lines.append(f'type = "{self.motion.kind}"')
        units = {"velocity": "m/s", "acceleration": "m/s^2", "jerk": "m/s^3", "dwell": "s", "frequency": "Hz"}
        told = {key: self.units.of(units.get(key, "m")) for key in self.motion.fields}
        told["repeats"] = "times there and back" if self.motion.moves > 1 else "the way there alone, in this duration"
        for key, value in self.motion.fields.items():
            text = str(value) if isinstance(value, int) else number(value, 8)
            lines.append(f"{f'{key} = {text}':<27} # {told[key]}; found")
        lines.append(f"{f'duration = {number(self._duration(), 8)}':<27} # s; of the log")
        return "\n".join(lines) + "\n"

    def write(self, model: str | os.PathLike[str], reference: str | os.PathLike[str]) -> list[str]:
        """Write both files, and the samples beside the reference where it needs them; nothing is replaced.

        Returns:
            The files that were written.

        Raises:
            InputError: one is there already, or cannot be written; nothing is left behind.
        """
        samples = Path(reference).with_suffix(".csv")
        content = {os.fspath(model): [self.model_text().encode()]}
        content[os.fspath(reference)] = [self.reference_text(samples.name).encode()]
        if self.motion.kind in ("sampled", "rest"):
            rows = zip(*(column.tolist() for column in self._samples().values()), strict=True)
            content[os.fspath(samples)] = [("time,reference\n" + "".join(f"{t!r},{x!r}\n" for t, x in rows)).encode()]
        require_new(content)
        write_files(content)
        return list(content)

    def text(self) -> str:
        """What was found, for a reader."""
        lines = [printable(self.source)]
        if self.columns is not None:
            lines += ["columns:", *(f"  {guess.text()}" for guess in self.columns.used.values())]
            if self.columns.unused:
                lines.append(f"  not used: {', '.join(repr(printable(label)) for label in self.columns.unused[:12])}")
        lines += ["rows:", *(f"  {line}" for line in self.audit.text().splitlines())]
        lines += [f"motion, seen in the {self.seen_in}: {self.motion.told}", "first force balance:"]
        for name, unit in (("mass", "V/(m/s^2)"), ("viscous", "V/(m/s)"), ("coulomb", "V")):
            size = self.sizes.sizes[name]
            value = f"{size.value:.4g} {self.units.of(unit)}, "
            sure = f"+- {100.0 * size.uncertainty:.0f} %, " if size.uncertainty is not None else ""
            lines.append(f"  {name} {value if size.value else ''}{sure}{size.told}")
        if self.sizes.explained is not None:
            lines.append(
                f"  together they explain {100.0 * self.sizes.explained:.3g} % of the command's power in motion"
            )
        if self.wave is not None:
            amplitude = math.hypot(self.wave.sine, self.wave.cosine)
            lines.append(
                f"over position a wave of {self.wave.period:.4g} {self.units.position} stands out, "
                f"{amplitude:.3g} {self.units.command}: cogging, or one of its harmonics"
            )
        if self.controller is not None:
            lines.append(f"a {self.controller.type} made the command: its gains stand in the model as comments")
        lines += ["guessed, to be checked:", *(f"  {entry}" for entry in self.likely)] * bool(self.likely)
        lines += ["cannot tell:", *(f"  {entry}" for entry in self.unsure)] * bool(self.unsure)
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """All of it as JSON can hold it."""
        columns = {} if self.columns is None else self.columns.used
        return {
            "source": self.source,
            "columns": {
                name: {
                    "in_file": guess.label,
                    "factor": self.scale.get(name, guess.unit.factor),
                    "unit": guess.unit.label,
                    "sure": guess.sure if guess.sure != STATED else guess.unit.sure,
                    "told": f"{guess.told}; {guess.unit.told}",
                }
                for name, guess in columns.items()
            },
            "audit": self.audit.to_dict(),
            "motion": {"type": self.motion.kind, **self.motion.fields, "seen_in": self.seen_in},
            "balance": {
                "explained": self.sizes.explained,
                **{name: vars(size) for name, size in self.sizes.sizes.items()},
            },
            "wave": None if self.wave is None else vars(self.wave),
            "units": self.units.to_dict(),
            "options": self.options(),
            "likely": list(self.likely),
            "cannot_tell": list(self.unsure),
        }

    def _brief(self) -> str:
        mass = f"mass {self.sizes.sizes['mass'].value:.4g} {self.units.of('V/(m/s^2)')}"
        return f"{self.source}, {mass}, {self.motion.kind}, {len(self.unsure)} open"

    def _travel(self) -> tuple[float, float]:
        low, high = self.audit.travel
        if self.log.reference is not None:
            low, high = min(low, float(self.log.reference.min())), max(high, float(self.log.reference.max()))
        margin = MARGIN * (high - low) or 1e-3
        return low - margin, high + margin

    def _duration(self) -> float:
        return float(f"{self.log.time[-1] - self.log.time[0]:.8g}")

    def _samples(self) -> dict[str, FloatArray]:
        every = -(-len(self.log) // ROWS_OF_REFERENCE)
        time = (self.log.time - self.log.time[0])[::every]
        if self.log.reference is not None:
            return {"time": time, "reference": self.log.reference[::every]}
        return {"time": time, "reference": _smoothed(self.log)[::every]}


def require_new(paths: Iterable[str | os.PathLike[str]]) -> None:
    """Refuse to replace files: what stands there may have been edited by hand.

    Raises:
        InputError: one is there.
    """
    for path in paths:
        if os.path.lexists(path):
            raise InputError(f"{path}: must not be there yet, a drafted file replaces none: name another, or remove it")


def _smoothed(log: Log) -> FloatArray:
    """The readings as a reference: freed of their noise by a parabola about each row."""
    from scipy.signal import savgol_filter

    window = 2 * max(2, round(0.5 * SMOOTHED * len(log))) + 1
    if len(log) <= window:
        return log.position
    return np.asarray(savgol_filter(log.position, window, 2))


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
