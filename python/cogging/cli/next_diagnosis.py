"""The sensible next command after a diagnosis, by its verdict."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from cogging.cli.answer import json_file
from cogging.cli.log_options import options_of
from cogging.cli.next_command import after_a_model, command_line, experiment, files, free_name, log_options, option
from cogging.diagnosis.next_step import GivenFiles, NextStep, next_step
from cogging.shown import printable

if TYPE_CHECKING:
    from cogging.diagnosis.result import Diagnosis


def after_a_diagnosis(arguments: argparse.Namespace, result: Diagnosis) -> NextStep:
    """What is next, as cogging.diagnosis.next_step decides, with the command in the words of this call."""
    given = GivenFiles(
        logs=arguments.logs,
        model=arguments.model,
        confirm=arguments.confirm,
        result=json_file(arguments) or "",
        patched=arguments.out or "",
        empirical=arguments.empirical,
    )
    step = next_step(result, given)
    return replace(step, line=_lines(arguments, result, step)[step.kind]())


def _lines(arguments: argparse.Namespace, result: Diagnosis, step: NextStep) -> dict[str, Callable[[], str]]:
    """The command of each kind of next step."""
    out = arguments.out or free_name(arguments.model, "patched")
    written: dict[str, Any] = {"out": out, "empirical": "--empirical" in step.line.split()}
    *given, last = arguments.logs
    return {
        "mend": lambda: _mended(arguments, result),
        "audit": lambda: _audit(arguments),
        "move": lambda: experiment(arguments.model),
        "write_result": lambda: _again(arguments, json=free_name("result.json")),
        "tell_apart": lambda: experiment(arguments.model, *option("--result", arguments.json), *_followed(arguments)),
        "write_model": lambda: _again(arguments, **written),
        "confirm": lambda: _again(arguments, confirm=["OTHER_LOG.csv"], **written),
        "confirm_by_last": lambda: _again(arguments, logs=given, confirm=[last], **written),
        "use": lambda: after_a_model(arguments.out or arguments.model, result.model),
    }


def _followed(arguments: argparse.Namespace) -> list[str]:
    """The logs whose motion is not to be proposed again."""
    return ["--logs", *files([*arguments.logs, *arguments.confirm]), *log_options(arguments)]


def _audit(arguments: argparse.Namespace) -> str:
    logs = files([*arguments.logs, *arguments.confirm])
    return command_line("audit", logs, option("--model", arguments.model), log_options(arguments))


def _again(
    arguments: argparse.Namespace,
    *,
    logs: Sequence[str] | None = None,
    confirm: Sequence[str] | None = None,
    out: str | None = None,
    json: str | None = None,
    empirical: bool = False,
    more: Sequence[str] = (),
) -> str:
    """The same call with something changed or added."""
    others = arguments.confirm if confirm is None else confirm
    return command_line(
        "diagnose",
        files(arguments.logs if logs is None else logs),
        option("--model", arguments.model),
        option("--confirm", *others) if others else [],
        log_options(arguments),
        list(more),
        option("--json", json or arguments.json),
        option("--report", arguments.report),
        option("--out", out or arguments.out),
        ["--empirical"] if empirical or arguments.empirical else [],
    )


def _mended(arguments: argparse.Namespace, result: Diagnosis) -> str:
    """The same call with the column read as what it is; the audit where no option does that."""
    mismatch = result.mismatch or {}
    name, _, pairs = str(mismatch.get("option", "")).partition(" ")
    if mismatch.get("misreading") in ("derivative", "reference"):
        return _again(arguments, more=["--columns", "position=NAME"])  # of the column of the encoder
    every = [*arguments.logs, *arguments.confirm]
    wrong = [path for path in every if printable(path) in mismatch.get("logs", ())]
    if name not in ("--scale", "--columns") or not wrong:
        return _audit(arguments)
    told, kind = [], name.removeprefix("--")
    for prefix in (f"{path}:" for path in map(printable, wrong)):
        pairs = pairs.replace(prefix, "")
    for path in wrong:
        given = options_of(arguments, path)[0][kind]
        # One that names the file comes before one that names none, so that it holds whatever else was given.
        before = "" if len(every) == 1 and set(getattr(arguments, kind)) <= {""} else f"{path}:"
        for column, _, value in (pair.partition("=") for pair in dict.fromkeys(pairs.split(","))):
            new = repr(float(value) * given.get(column, 1.0)) if name == "--scale" else given.get(value, value)
            told.append(f"{before}{column}={new}")
        if "," in before or "=" in before:  # a name that no option can bear
            return _audit(arguments)
    return _again(arguments, more=[name, ",".join(told)])
