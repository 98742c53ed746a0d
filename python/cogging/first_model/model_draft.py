"""Draft a first model and a first reference from a log, with comments on every number."""

from __future__ import annotations

import json
import math
import os
import shlex
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cogging._core import Reference
from cogging.arrays import FloatArray
from cogging.calls import PATH, Kind, check_arguments
from cogging.files import InputError, errors_of, parse_toml
from cogging.first_model.axis_sizes import WIDTH, Sizes, Wave, sizes_of, strongest_wave
from cogging.first_model.column_guess import ColumnGuesses, guess_columns
from cogging.first_model.headers import LIKELY, STATED, UNKNOWN
from cogging.first_model.motion_kind import Motion, motion_of_log
from cogging.identification.identification import FEWEST_ROWS
from cogging.log_check.controller_recovery import RecoveredController, recover_controller
from cogging.log_check.controller_samples import on_its_clock
from cogging.log_check.log_audit import Audit, audit, hints
from cogging.logs.log import Log, read_log, require_sizes, units_beside
from cogging.model.model import Model
from cogging.model.units import UNIT_KEYS, Units
from cogging.outputs import write_files
from cogging.resources import on_one_blas_thread
from cogging.shown import printable
from cogging.simulation.reference import reference_from
from cogging.values import ByValue

MARGIN = 0.05  # of the logged travel, on either side
UNITS_OF_SIZES = {"mass": "V/(m/s^2)", "viscous": "V/(m/s)", "coulomb": "V"}
CROSSOVER = 0.01  # of the sample rate: closed-loop poles, rad/s over 2 pi, of the proposed gains


def _axis(units: Units, sizes: Sizes, travel: tuple[float, float], audit: Audit) -> list[str]:
    lines = ["[axis]                      # mass x'' = command - viscous x' - coulomb S(x') - cogging(x)"]
    for name, unit in UNITS_OF_SIZES.items():
        size = sizes.sizes[name]
        lines.append(_line(name, number(size.value), f"{units.of(unit)}; {size.reason}"))
    width, m = WIDTH * sizes.speed if sizes.speed > 0.0 else 1e-3, units.of("m")
    seen = f"found: {audit.travel[0]:.5g} to {audit.travel[1]:.5g} {m} in this log, and a margin; fill in the axis' own"
    lines += [
        _line("coulomb_width", number(width), f"{units.of('m/s')}; assumed: {100 * WIDTH:g} % of the top speed"),
        _line("travel", f"[{number(travel[0], 6)}, {number(travel[1], 6)}]", f"{m}; {seen}"),
        "",
        "[axis.uncertainty]          # relative, 1 sigma; 0 = exact; left out = unknown within a factor of three",
    ]
    for name, size in sizes.sizes.items():
        if size.uncertainty is None:
            lines.append(f"# {name} = 0.2              # not identifiable from this log: fill in what you know")
        else:
            lines.append(_line(name, number(size.uncertainty, 2), "of the first force balance"))
    return lines


def _cogging(units: Units, wave: Wave | None, travel: tuple[float, float]) -> list[str]:
    head, m, v = "# [cogging]                 # opposes the command", units.position, units.command
    if wave is None:
        return [
            head,
            "## no period over position stands out of this log: fill in the magnets' pitch",
            f"# pitch = {number(0.1 * (travel[1] - travel[0]), 2):<18} # {m}; to be filled in",
            "# harmonics = [1, 2]",
            f"# sine = [[0.0], [0.0]]     # {v}",
            "# cosine = [[0.0], [0.0]]",
        ]
    share = f"{100.0 * wave.share:.0f} % of what mass and friction leave"
    return [
        head,
        f"# pitch = {number(wave.period):<18} # {m}; found: the strongest wave over position, {share};",
        "##                           it may as well be a harmonic of the magnets' pitch: compare with the data sheet",
        "# harmonics = [1]",
        f"# sine = [[{number(wave.sine)}]]          # {v}; found",
        f"# cosine = [[{number(wave.cosine)}]]        # {v}; found",
    ]


def _controller(units: Units, sizes: Sizes, audit: Audit, found: RecoveredController | None) -> list[str]:
    lines = ["# [controller]              # simulate and predict need it"]
    if found is not None:
        fields = {"type": found.type, **found.parameters.to_dict()}
        reason = f"found: these gains leave {found.residual_rms:.2g} {units.of('V')} rms of the logged command"
        shown = {key: number(one, 6) if isinstance(one, float) else json.dumps(one) for key, one in fields.items()}
        return [*lines, f"## {reason}", *(f"# {key} = {text}" for key, text in shown.items())]
    rate, mass = float(f"{audit.rate:.3g}"), sizes.sizes["mass"].value
    w = 2.0 * math.pi * CROSSOVER * rate
    gains = {"kp": (3.0 * mass * w**2, "V/m"), "ki": (mass * w**3, "V/(m s)"), "kd": (3.0 * mass * w, "V/(m/s)")}
    return [
        *lines,
        "## not identifiable from this log: fill in yours. The gains below are a first proposal, from the mass alone:",
        f"## three poles at {CROSSOVER:g} of the sample rate.",
        '# type = "pid"',
        f"# sample_rate = {rate:g}",
        *(f"# {key} = {number(value, 3):<20} # {units.of(unit)}; assumed" for key, (value, unit) in gains.items()),
    ]


def number(value: float, digits: int = 4) -> str:
    """Format a number as a TOML float."""
    text = f"{value:.{digits}g}"
    return text if any(mark in text for mark in ".en") else f"{text}.0"


def _line(key: str, value: str, comment: str) -> str:
    return f"{f'{key} = {value}':<27} # {comment}"


ROWS_OF_REFERENCE = 20_000  # kept of a sampled motion
SMOOTHED = 0.002  # of the log: window over which readings are smoothed to a reference


@dataclass(frozen=True, eq=False, repr=False)
class ModelDraft(ByValue):
    """A first model and reference drafted from a log, with what was found and what is unknown.

    Attributes:
        source: name of the log.
        log: in SI, as read with the options below.
        columns: the identified columns of the file; None for a log in memory.
        audit: of the log.
        motion: of the reference, or else of the position.
        seen_in: "reference" or "position".
        sizes: mass and friction from a first force balance.
        wave: significant wave over position in its residual, or None.
        controller: that made the command, or None.
        units: labels of command and position.
        scale: factors for `--scale`, including the command's sign.
        rows: data rows used; None: all.
        likely: guesses to be checked.
        unsure: what is unknown, each with what to do.
        model: the drafted model.
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
        """The drafted model."""
        return Model.from_dict(parse_toml(self.model_text()))

    @property
    def reference(self) -> Reference:
        """The drafted reference."""
        if self.motion.kind in ("sampled", "rest"):
            return reference_from({"type": "sampled", **self._samples()})[0]
        return reference_from({"type": self.motion.kind, **self.motion.fields, "duration": self._duration})[0]

    def options(self) -> list[str]:
        """Command-line options that read the log as it was read here."""
        words: list[str] = []
        if self.columns is not None and self.columns.columns:
            words += ["--columns", ",".join(f"{name}={there}" for name, there in self.columns.columns.items())]
        if self.scale:
            words += ["--scale", ",".join(f"{name}={factor:.10g}" for name, factor in self.scale.items())]
        if self.rows is not None:
            words += ["--rows", f"{self.rows.start or 0}:{'' if self.rows.stop is None else self.rows.stop}"]
        return words

    def next_command(self, model: str | os.PathLike[str]) -> str:
        """The next command: a fit of the model, or an audit if nothing moves."""
        fits = self.sizes.explained is not None and len(self.log) >= FEWEST_ROWS
        words = [self.source, "--model", os.fspath(model), *(["--out", "fitted.toml"] if fits else [])]
        return shlex.join(["cogging", "identify" if fits else "audit", *words, *self.options()])

    def model_text(self) -> str:
        """The model file: TOML with a comment on each number."""
        used = {} if self.columns is None else self.columns.used
        known = {name: used[name].unit.reason if used else "not known: edit it" for name in UNIT_KEYS}
        units, quantum = self.units, self.audit.encoder_quantum
        both = np.append(self.audit.travel, [] if self.log.reference is None else self.log.reference)
        margin = MARGIN * float(np.ptp(both)) or 1e-3
        travel = float(both.min()) - margin, float(both.max()) + margin
        found = "found: the readings differ by multiples of it (the last digit of the file, if that is coarser)"
        step = found if quantum else "no step found in the readings; fill in"
        lines = [
            f"## A first model of the axis that made {printable(Path(self.source).name)}, by `cogging init`.",
            "## found: from the log. assumed: not measured, replace it where you know better.",
            "## A line behind a single # is a proposal: remove the # to use it.",
            "## Check each line, then fit it: cogging identify. (A fitted model keeps these comments.)",
            "",
            *_axis(units, self.sizes, travel, self.audit),
            "",
            "[encoder]",
            _line("resolution", number(quantum), f"{units.of('m')}; {step}"),
            "",
            "[units]                     # labels only: no number is converted by them",
            *(_line(name, json.dumps(getattr(units, name)), known[name]) for name in UNIT_KEYS),
        ]
        if units.command == "%":
            lines.append("## % of what? The scale of the drive makes newtons or amperes of it: --scale command=...")
        lines += ["", *_cogging(units, self.wave, travel)]
        return "\n".join([*lines, "", *_controller(units, self.sizes, self.audit, self.controller)]) + "\n"

    def reference_text(self, samples: str = "reference.csv") -> str:
        """The reference file: TOML with a comment on each number.

        Args:
            samples: file of the samples of a sampled motion.
        """
        head = f"## The motion of {printable(Path(self.source).name)}, by `cogging init`, seen in its {self.seen_in}:"
        lines = [head, f"## {self.motion.description}", ""]
        if self.motion.kind in ("sampled", "rest"):
            lines += ['type = "sampled"', f"file = {json.dumps(samples, ensure_ascii=False)}   # time (s), reference"]
            return "\n".join(lines) + "\n"
        if self.motion.kind == "sine":
            lines.insert(2, "## It begins at the center, moving forward: the log may begin elsewhere in the period.")
        lines.append(f'type = "{self.motion.kind}"')
        units = {"velocity": "m/s", "acceleration": "m/s^2", "jerk": "m/s^3", "dwell": "s", "frequency": "Hz"}
        meaning = {key: self.units.of(units.get(key, "m")) for key in self.motion.fields}
        both_ways = self.motion.moves > 1
        meaning["repeats"] = "times there and back" if both_ways else "the way there alone, in this duration"
        for key, value in self.motion.fields.items():
            text = str(value) if isinstance(value, int) else number(value, 8)
            lines.append(f"{f'{key} = {text}':<27} # {meaning[key]}; found")
        lines.append(f"{f'duration = {number(self._duration, 8)}':<27} # s; of the log")
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
        """The draft for the screen."""
        lines = [printable(self.source)]
        if self.columns is not None:
            lines += ["columns:", *(f"  {guess.text()}" for guess in self.columns.used.values())]
            if self.columns.unused:
                lines.append(f"  not used: {', '.join(repr(printable(label)) for label in self.columns.unused[:12])}")
        lines += ["rows:", *(f"  {line}" for line in self.audit.text().splitlines())]
        lines += [f"motion, seen in the {self.seen_in}: {self.motion.description}", "first force balance:"]
        for name, unit in UNITS_OF_SIZES.items():
            size = self.sizes.sizes[name]
            value = f"{size.value:.4g} {self.units.of(unit)}, "
            sure = f"+- {100.0 * size.uncertainty:.0f} %, " if size.uncertainty is not None else ""
            lines.append(f"  {name} {value if size.value else ''}{sure}{size.reason}")
        if self.sizes.explained is not None:
            share = f"{100.0 * self.sizes.explained:.3g} %"
            lines.append(f"  together they explain {share} of the command's power in motion")
        if self.wave is not None:
            force = f"{math.hypot(self.wave.sine, self.wave.cosine):.3g} {self.units.command}"
            period = f"{self.wave.period:.4g} {self.units.position}"
            lines.append(f"over position a wave of {period} stands out, {force}: cogging, or one of its harmonics")
        if self.controller is not None:
            lines.append(f"a {self.controller.type} made the command: its gains stand in the model as comments")
        lines += ["guessed, to be checked:", *(f"  {entry}" for entry in self.likely)] * bool(self.likely)
        lines += ["not identifiable:", *(f"  {entry}" for entry in self.unsure)] * bool(self.unsure)
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """All fields for JSON."""
        columns, sizes = {}, self.sizes.sizes.items()
        for name, one in ({} if self.columns is None else self.columns.used).items():
            factor, sure = self.scale.get(name, one.unit.factor), one.sure if one.sure != STATED else one.unit.sure
            told = f"{one.reason}; {one.unit.reason}"
            columns[name] = {"in_file": one.label, "factor": factor, "unit": one.unit.label, "sure": sure, "told": told}
        return {
            "source": self.source,
            "columns": columns,
            "audit": self.audit.to_dict(),
            "motion": {"type": self.motion.kind, **self.motion.fields, "seen_in": self.seen_in},
            "balance": {"explained": self.sizes.explained}
            | {n: {"value": s.value, "uncertainty": s.uncertainty, "told": s.reason} for n, s in sizes},
            "wave": None if self.wave is None else vars(self.wave),
            "units": self.units.to_dict(),
            "options": self.options(),
            "likely": list(self.likely),
            "cannot_tell": list(self.unsure),
        }

    def _brief(self) -> str:
        mass = f"mass {self.sizes.sizes['mass'].value:.4g} {self.units.of('V/(m/s^2)')}"
        return f"{self.source}, {mass}, {self.motion.kind}, {len(self.unsure)} open"

    @property
    def _duration(self) -> float:
        return float(f"{self.log.time[-1] - self.log.time[0]:.8g}")

    def _samples(self) -> dict[str, FloatArray]:
        every = -(-len(self.log) // ROWS_OF_REFERENCE)
        window = 2 * max(2, round(0.5 * SMOOTHED * len(self.log))) + 1
        path = self.log.position if self.log.reference is None else self.log.reference
        if self.log.reference is None and len(self.log) > window:
            from scipy.signal import savgol_filter  # local parabolas

            path = np.asarray(savgol_filter(path, window, 2))
        return {"time": (self.log.time - self.log.time[0])[::every], "reference": path[::every]}


def require_new(paths: Iterable[str | os.PathLike[str]]) -> None:
    """Refuse to replace files, which may have been edited by hand."""
    for path in paths:
        if os.path.lexists(path):
            raise InputError(f"{path}: must not exist yet: a draft does not replace files; name another, or remove it")


FILE = Kind((Log, *PATH), "a Log or the path of a log file")
ROWS_OF_CONTROLLER = 50_000  # used to recover the controller
FEWEST = 10  # rows


@check_arguments(log=FILE)
@np.errstate(all="ignore")  # extreme values lead to sizes that are not identifiable
@on_one_blas_thread(scipy=True)
def draft_model(
    log: Log | str | os.PathLike[str],
    *,
    columns: Mapping[str, str] | None = None,
    scale: Mapping[str, float] | None = None,
    rows: slice | None = None,
) -> ModelDraft:
    """Draft a model and a reference of the axis that made a log, in any of its user's formats.

    Columns are identified by their names in English or German, or by the behaviour of their numbers; units by the
    header or by plausible motion. Each guess is reported with its reason, and so is what is unknown.

    Args:
        log: a Log, or a file of any format that logs have (see read_log), with columns of any names.
        columns: known names in the file, by the names of a log: `{"position": "qm"}`.
        scale: known factors, by the names of a log.
        rows: the data rows to use, from 0.

    Returns:
        The draft; print its `text()`, and `write` it.

    Raises:
        InputError: the file cannot be read, or its time, position or command column cannot be identified.
        ValueError: a log in memory of fewer than ten rows, or with numbers outside the range of machines.

    Example:
        >>> log.write("run.csv")
        >>> draft = cogging.draft_model("run.csv")
        >>> draft.write("first.toml", "motion.toml")
        ['first.toml', 'motion.toml']
        >>> cogging.Model.read("first.toml").axis.mass == draft.model.axis.mass
        True
    """
    if isinstance(log, Log):
        return _drafted("log", log, None, rows)
    guesses = guess_columns(log, columns or {}, scale or {}, rows, units_beside(log))
    read = read_log(log, columns=guesses.columns, scale=guesses.scale, rows=rows)
    with errors_of(log):
        return _drafted(os.fspath(log), read, guesses, rows)


def _drafted(source: str, log: Log, guesses: ColumnGuesses | None, rows: slice | None) -> ModelDraft:
    """The draft of a log that was read."""
    if len(log) < FEWEST:
        raise ValueError(f"rows: must be at least {FEWEST} to draft a model from, got {len(log)}")
    require_sizes(log)
    known = guesses or ColumnGuesses({}, (), ())
    units = Units(**{name: known.used[name].unit.label for name in UNIT_KEYS}) if known.used else log.units
    stamps, (log, clock) = log.time, on_its_clock(log)
    sizes, scale = sizes_of(log, units), known.scale
    unsure = [*_guessed(known, UNKNOWN), *known.notes]
    if sizes.reversed:
        log = Log.of({**log.columns(), "command": -log.command}, log.metadata)
        scale = {**scale, "command": -scale.get("command", 1.0)}
        unsure.append("command or position has the wrong sign: the command is inverted here")
    found = audit(replace(log, time=stamps))
    seen, quantum = (log.position, found.encoder_quantum) if log.reference is None else (log.reference, 0.0)
    beginning = Log.of({name: column[:ROWS_OF_CONTROLLER] for name, column in log.columns().items()})
    controller = recover_controller(beginning)
    waves = (strongest_wave(*residual, found.command_rms) for residual in sizes.residuals)
    draft = ModelDraft(
        source=source,
        log=log,
        columns=guesses,
        audit=replace(found, units=units),
        motion=motion_of_log(log.time, seen, quantum, units),
        seen_in="position" if log.reference is None else "reference",
        sizes=sizes,
        wave=next(filter(None, waves), None),
        controller=controller and controller._replace(units=units),
        units=units,
        scale=scale,
        rows=rows,
        likely=(*_guessed(known, LIKELY), *([clock] if clock else ())),
        unsure=(),
    )
    unsure += [f"{name}: {size.reason}" for name, size in sizes.sizes.items() if size.uncertainty is None]
    unsure += hints(found, draft.model)
    return replace(draft, unsure=tuple(unsure))


def _guessed(guesses: ColumnGuesses, sure: str) -> list[str]:
    """Guesses of columns and units of this certainty."""
    said = [f"{g.name}: {g.unit.reason}" for g in guesses.used.values() if g.unit.sure == sure]
    return said + [f"{g.name}: it is {g.label!r}, {g.reason}" for g in guesses.used.values() if g.sure == sure]
