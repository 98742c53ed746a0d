"""Next step after a diagnosis: advice and a command to paste, for the page, the screen and programs."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from cogging.diagnosis.places import empirical_term

if TYPE_CHECKING:
    from cogging.diagnosis.diagnosis_result import Diagnosis


@dataclass(frozen=True)
class GivenFiles:
    """File names for the next command; placeholders in capitals are for the user to fill in.

    Attributes:
        logs: diagnosed logs.
        model: model that was compared with them.
        confirm: confirm logs.
        result: JSON file of the result; empty if it was not written.
        patched: file of the patched model; empty if it was not written.
        empirical: whether an empirical term was requested.
    """

    logs: Sequence[str] = ("LOG.csv",)
    model: str = "MODEL.toml"
    confirm: Sequence[str] = ()
    result: str = ""
    patched: str = ""
    empirical: bool = False


@dataclass(frozen=True)
class NextStep:
    """The next step.

    Attributes:
        kind: `mend` (read a column differently), `audit`, `move` (record a motion that shows more), `write_result`,
            `tell_apart` (record a motion computed from the result), `write_model`, `confirm`, `confirm_by_last` (the
            last log confirms the others) or `use`.
        words: advice with its reason, one or two sentences.
        line: shell command; empty without one.
    """

    kind: str
    words: str
    line: str = ""


def next_step(result: Diagnosis, files: GivenFiles | None = None) -> NextStep:
    """Return the next step after a diagnosis.

    Args:
        result: result of `diagnose`.
        files: names of its logs and model; placeholders by default.

    Example:
        >>> from cogging.diagnosis.next_step import next_step
        >>> step = next_step(cogging.diagnose(log, model))
        >>> step.line
        'cogging predict MODEL.toml --reference REF.toml'
    """
    files = files or GivenFiles()
    confirmed = bool(files.confirm) or result.gap.confirm_before is not None
    if result.mismatch is not None:  # repeat the call with the column read correctly
        name, _, value = str(result.mismatch.get("option") or "").partition(" ")
        words = str(result.mismatch.get("advice") or "Correct that column and read the log again.")
        return NextStep("mend", words, _diagnose(files, name, value) if value else "")
    if result.verdict == "no_gap":
        words = "Keep the model and use it to predict the tracking error. Effects below the detection limits may "
        words += "exist: cogging experiment makes a motion that shows smaller ones."
        return NextStep("use", words, _predict(files.patched or files.model))
    if result.verdict == "named":
        return _adopt(files, confirmed, "Write the patched model")
    if result.verdict == "ambiguous":
        return _tell_apart(result, files)
    if result.verdict == "controller_mismatch":
        words = "State the gains and the sample rate of the controller that was running, or remove the controller from "
        words += "the model. The audit computes the gains that reproduce the logged command."
        return NextStep("audit", words, _line("audit", *files.logs, *files.confirm, "--model", files.model))
    if result.verdict == "insufficient_excitation":
        return _move_more(files)
    words = "Part of the gap is unexplained: see its location, and repeat the motion with only that coordinate changed"
    if result.unlisted is None or empirical_term(result.unlisted) is not None:
        words += ". Meanwhile, add an empirical force of that shape to the model"
        return _adopt(files, confirmed, words, empirical=True)
    if not result.effects:
        return _move_more(files, words + ". ")
    return _adopt(files, confirmed, words + ". To use the named effects, write the patched model")


def _adopt(files: GivenFiles, confirmed: bool, words: str, *, empirical: bool = False) -> NextStep:
    """Return the next of three steps: write a patched model, confirm it on other motion, use it."""
    more = ["--empirical"] if empirical else []
    if not confirmed and len(files.logs) > 1:
        *logs, last = files.logs
        one = replace(files, logs=logs, confirm=[last])
        words += ", and use the last of these logs to confirm it."
        return NextStep("confirm_by_last", words, _diagnose(one, *more, "--out", files.patched or "PATCHED.toml"))
    if not files.patched or (empirical and not files.empirical):
        words += ", and use it from now on." if confirmed else "; then check it on a log of other motion."
        return NextStep("write_model", words, _diagnose(files, *more, "--out", files.patched or "PATCHED.toml"))
    if not confirmed:
        words = "Check the patched model before you use it: record a second log with other speeds and strokes, and "
        words += "pass it as a confirm log."
        one = replace(files, confirm=[*files.confirm, "OTHER_LOG.csv"])
        return NextStep("confirm", words, _diagnose(one, *more, "--out", files.patched))
    words = "Use the patched model to predict the tracking error."
    return NextStep("use", words, _predict(files.patched))


def _tell_apart(result: Diagnosis, files: GivenFiles) -> NextStep:
    words = "No other effect fits as well, but the confidence is low: record a motion that shows more of this effect"
    if any(effect.alternatives for effect in result.effects):
        words = "Record a motion that distinguishes the candidates"
    if not files.result:
        words += ". Write the result to a file: cogging experiment makes a motion within the limits of the machine."
        return NextStep("write_result", words, _diagnose(files, "--json", "RESULT.json"))
    words += ", and diagnose both logs together."
    return NextStep("tell_apart", words, _experiment(files, "--result", files.result))


def _move_more(files: GivenFiles, words: str = "") -> NextStep:
    words += "Move the axis over its travel in both directions at several speeds for at least ten seconds. "
    words += "cogging experiment makes such a motion within the limits of the machine."
    return NextStep("move", words, _experiment(files))


def _line(*words: str) -> str:
    return shlex.join(("cogging", *words))


def _diagnose(files: GivenFiles, *more: str) -> str:
    """Return the call of `diagnose` with more arguments."""
    others = ("--confirm", *files.confirm) if files.confirm else ()
    return _line("diagnose", *files.logs, "--model", files.model, *others, *more)


def _experiment(files: GivenFiles, *more: str) -> str:
    return _line("experiment", "--model", files.model, *more, "--limits", "LIMITS.toml", "--out", "NEXT.toml")


def _predict(model: str) -> str:
    return _line("predict", model, "--reference", "REF.toml")
