"""The sensible next command after a diagnosis, by its verdict."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from cogging.cli.log_options import options_of
from cogging.cli.next_command import after_a_model, command_line, experiment, files, free_name, log_options, option
from cogging.shown import printable

if TYPE_CHECKING:
    from cogging.diagnosis.result import Diagnosis


def after_a_diagnosis(arguments: argparse.Namespace, result: Diagnosis) -> str:
    """The next command, by verdict.

    named, unlisted: the patched model is written, confirmed by other motion, then used. ambiguous: the motion that
    tells the alternatives apart. no_gap: the model is used. data_mismatch: the same call with what mends it.
    controller_mismatch: the audit, which says where controller and log part. insufficient_excitation: a motion.
    """
    if result.verdict == "data_mismatch":
        return _mended(arguments, result)
    if result.verdict == "controller_mismatch":
        return _audit(arguments)
    if result.verdict == "insufficient_excitation":
        return experiment(arguments.model)
    if result.verdict == "no_gap":
        return after_a_model(arguments.out or arguments.model, result.model, arguments.planned)
    if result.verdict == "ambiguous":
        if arguments.json:
            return experiment(arguments.model, *option("--result", arguments.json))
        return _again(arguments, json=free_name("result.json"))
    return _patched(arguments, result)


def _patched(arguments: argparse.Namespace, result: Diagnosis) -> str:
    """Write the patched model, confirm it, use it."""
    empirical = arguments.empirical or result.verdict == "unlisted"
    out = arguments.out or free_name(arguments.model, "patched")
    if not arguments.confirm and len(arguments.logs) > 1:  # one of them can
        *given, last = arguments.logs
        return _again(arguments, logs=given, confirm=[last], out=out, empirical=empirical)
    if not arguments.out or empirical != arguments.empirical:
        return _again(arguments, out=out, empirical=empirical)
    if not arguments.confirm:
        return _again(arguments, confirm=["OTHER_LOG.csv"])
    return after_a_model(out, result.model, arguments.planned)


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
        option("--planned", arguments.planned),
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
