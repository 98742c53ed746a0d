"""The next command after each command, in the user's own files and options, to be pasted into a shell.

Words in capitals, such as REF.toml, stand for files that only the user can have.
"""

from __future__ import annotations

import argparse
import math
import os
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cogging.cli.answer import json_file
from cogging.cli.log_options import OPTIONS, Given, options_of
from cogging.model.model import Model
from cogging.outputs import AnyPath
from cogging.shown import printable

if TYPE_CHECKING:
    from cogging.diagnosis.diagnosis_result import Diagnosis
    from cogging.diagnosis.next_step import NextStep
    from cogging.identification.identification_result import Identification

NOISE_LEVEL = 1.1  # times the noise: a residual below it counts as explained
MOSTLY = 0.9  # of the command's power


def command_line(*words: str | Sequence[str]) -> str:
    """Return a call of the command as a shell takes it; each argument is a word or a list of words."""
    flat = [word for entry in words for word in ([entry] if isinstance(entry, str) else entry)]
    return " ".join(["cogging", *map(shell_word, flat)])


def shell_word(word: str) -> str:
    """Return a word quoted for the shell."""
    if os.name == "nt":
        return f'"{word}"' if not word or any(letter in word for letter in " &()^;,'") else word
    return shlex.quote(word)


def files(paths: Sequence[AnyPath]) -> list[str]:
    """Return paths as words that are not mistaken for options."""
    return [f".{os.sep}{path}" if os.fspath(path).startswith("-") else os.fspath(path) for path in paths]


def option(name: str, *values: AnyPath | None) -> list[str]:
    """Return an option with its files; nothing if the first is None."""
    return [] if values[:1] == (None,) else [name, *files([value for value in values if value is not None])]


def log_options(arguments: argparse.Namespace) -> list[str]:
    """Return the options with which the logs were read, as given."""
    return [word for option in OPTIONS for word in _as_given(option, getattr(arguments, option))]


def _as_given(option: str, given: Sequence[Given]) -> list[str]:
    pairs = [(f"--{option}", text) for text, _ in given]
    return [word for name, text in pairs for word in ([f"{name}={text}"] if text.startswith("-") else [name, text])]


def again(arguments: argparse.Namespace, **changes: Any) -> str:
    """Return the same call, whose arguments are words, numbers or switches, with some of them changed."""
    words: list[str] = []
    for action in arguments.parser._actions:
        value = {**vars(arguments), **changes}.get(action.dest)
        if value in (None, action.default) or action.dest == "quiet":
            continue
        if action.dest in OPTIONS:
            words += _as_given(action.dest, value)
            continue
        entries = [] if value is True else value if isinstance(value, list) else [value]
        words += action.option_strings[-1:]
        words += [files([one])[0] if isinstance(one, str) else str(one) for one in entries]
    return command_line(arguments.parser.prog.split()[-1], words)


def free_name(path: AnyPath, ending: str = "") -> str:
    """Return an unused file name: the path, or `STEM_ending.toml` beside it, with a number if necessary."""
    wanted = Path(path)
    name = wanted.with_name(f"{wanted.stem}_{ending}.toml") if ending else wanted
    numbered = (name.with_name(f"{name.stem}_{number}{name.suffix}") for number in range(2, 1000))
    return str(next((one for one in (name, *numbered) if not os.path.lexists(one)), name))


# After a command that reads logs --------------------------------------------------------------------------------------


def after_audit(arguments: argparse.Namespace) -> str:
    """Fit the model to the logs; without a model, draft one first."""
    if arguments.model is not None:
        return _identify(arguments, arguments.model)
    return init(*files(arguments.logs[:1]), *log_options(arguments))


def init(*words: str) -> str:
    """Return the call that drafts a model."""
    names = {"--out": "model.toml", "--reference": "reference.toml"}  # existing ones are not replaced
    taken = [option(name, free_name(path)) for name, path in names.items() if os.path.lexists(path)]
    return command_line("init", list(words), *taken)


def _identify(arguments: argparse.Namespace, model: AnyPath) -> str:
    out = option("--out", free_name(model, "fitted"))
    return command_line("identify", files(arguments.logs), option("--model", model), log_options(arguments), out)


def after_identify(arguments: argparse.Namespace, found: Identification) -> str:
    """Diagnose what the fit leaves unexplained, or plan a longer log; if nothing is left, predict with the fit."""
    from cogging.diagnosis.preparation import ROWS_MIN

    explained = all(log.noise is not None and log.residual_after < NOISE_LEVEL * log.noise for log in found.logs)
    if not explained or found.warnings or not can_predict(found.model):
        use_fit = arguments.out and not found.warnings and found.explained > MOSTLY  # else the gap has biased the fit
        model = arguments.out if use_fit else arguments.model
        if min(audit.rows for audit in found.audits) < ROWS_MIN:
            return experiment(model)
        return command_line("diagnose", files(arguments.logs), option("--model", model), log_options(arguments))
    return with_model(arguments.out, found.model) if arguments.out else _identify(arguments, arguments.model)


def after_diagnose(arguments: argparse.Namespace, result: Diagnosis) -> NextStep:
    """Return what cogging.diagnosis.next_step recommends, with the command in the words of this call."""
    from cogging.diagnosis.next_step import GivenFiles, next_step

    given: dict[str, Any] = {name: getattr(arguments, name) for name in ("logs", "model", "confirm", "empirical")}
    step = next_step(result, GivenFiles(result=json_file(arguments) or "", patched=arguments.out or "", **given))
    empirical = arguments.empirical or "--empirical" in step.line.split()
    patched = {"out": arguments.out or free_name(arguments.model, "patched"), "empirical": empirical}
    # In "tell_apart" the motion of known logs is not proposed again.
    known = ["--logs", *files([*arguments.logs, *arguments.confirm]), *log_options(arguments)]
    *others, last = arguments.logs
    lines: dict[str, Callable[[], str]] = {
        "mend": lambda: _read_otherwise(arguments, result.mismatch or {}),
        "audit": lambda: _audit(arguments),
        "move": lambda: experiment(arguments.model),
        "write_result": lambda: again(arguments, json=free_name("result.json")),
        "tell_apart": lambda: experiment(arguments.model, *option("--result", arguments.json), *known),
        "write_model": lambda: again(arguments, **patched),
        "confirm": lambda: again(arguments, confirm=["OTHER_LOG.csv"], **patched),
        "confirm_by_last": lambda: again(arguments, logs=others, confirm=[last], **patched),
        "use": lambda: with_model(arguments.out or arguments.model, result.model),
    }
    return replace(step, line=lines[step.kind]())


def _audit(arguments: argparse.Namespace) -> str:
    logs = files([*arguments.logs, *arguments.confirm])
    return command_line("audit", logs, option("--model", arguments.model), log_options(arguments))


def _read_otherwise(arguments: argparse.Namespace, mismatch: Mapping[str, Any]) -> str:
    """Return the same call with the misread column read correctly; the audit if no option does that."""
    if mismatch.get("misreading") in ("derivative", "reference"):
        wanted: Given = ("position=NAME", {})  # the user names the encoder's column
        return again(arguments, columns=[*arguments.columns, wanted])
    name, _, pairs = str(mismatch.get("option", "")).partition(" ")
    kind, every = name.removeprefix("--"), [*arguments.logs, *arguments.confirm]
    wrong = [path for path in every if printable(path) in mismatch.get("logs", ())]
    if kind not in ("scale", "columns") or not wrong:
        return _audit(arguments)
    # An option with the file's name takes precedence over one without; a name with a comma cannot stand there.
    by_file = len(every) > 1 or any(any(entries) for _, entries in getattr(arguments, kind))
    if by_file and any("," in path or "=" in path for path in wrong):
        return _audit(arguments)
    for path in wrong:
        pairs = pairs.replace(f"{printable(path)}:", "")
    entries = []
    for path in wrong:
        given = options_of(arguments, path)[0][kind]
        for column, _, value in (pair.partition("=") for pair in dict.fromkeys(pairs.split(","))):
            new = repr(float(value) * given.get(column, 1.0)) if kind == "scale" else given.get(value, value)
            entries.append(f"{f'{path}:' if by_file else ''}{column}={new}")
    return again(arguments, **{kind: [*getattr(arguments, kind), (",".join(entries), {})]})


# After the other commands ---------------------------------------------------------------------------------------------


def after_many_runs(model_file: AnyPath, reference: AnyPath) -> str:
    """Predict the error of the model of a sweep or a tuning, or simulate one run."""
    call = [*files([model_file]), *option("--reference", reference)]
    if can_predict(Model.read(model_file)):
        return command_line("predict", call)
    return command_line("simulate", call, option("--out", free_name("log.csv")))


def can_predict(model: Model) -> bool:
    """Return whether `predict` applies to a model: it has a controller, and every interval is finite."""
    return model.controller is not None and all(math.isfinite(end) for ends in model.intervals.values() for end in ends)


def with_model(path: AnyPath, model: Model) -> str:
    """Predict the error of a model; if its intervals do not suffice, plan an experiment."""
    if can_predict(model):
        return command_line("predict", files([path]), ["--reference", "REF.toml"])
    return experiment(path)


def experiment(model: AnyPath, *words: str) -> str:
    """Return the call that computes a motion for a model."""
    out = option("--out", free_name("experiment.toml"))
    return command_line("experiment", option("--model", model), list(words), "--limits", "LIMITS.toml", out)
