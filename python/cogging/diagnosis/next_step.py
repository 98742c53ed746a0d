"""What to do next, by verdict: a sentence, and the command to paste. The page, the screen and a program ask here."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from cogging.diagnosis.places import empirical_term

if TYPE_CHECKING:
    from cogging.diagnosis.result import Diagnosis


@dataclass(frozen=True)
class GivenFiles:
    """The files of a diagnosis, by which the next command calls them; words in capitals are for the user to fill in.

    Attributes:
        logs: logs that were diagnosed.
        model: model that was held against them.
        confirm: logs of other motion; empty where there were none.
        result: where the result was written as JSON; empty where it was not.
        patched: where the patched model was written; empty where it was not.
        empirical: whether what no effect explains was to be added to it.
    """

    logs: Sequence[str] = ("LOG.csv",)
    model: str = "MODEL.toml"
    confirm: Sequence[str] = ()
    result: str = ""
    patched: str = ""
    empirical: bool = False


@dataclass(frozen=True)
class NextStep:
    """One thing to do next.

    Attributes:
        kind: what it is, a word: `mend` (a column is read otherwise), `audit`, `move` (a motion that shows more),
            `write_result`, `tell_apart` (a motion, computed from the result), `write_model`, `confirm`,
            `confirm_by_last` (the last of the logs confirms the others), `use`.
        words: what to do and why, a sentence or two.
        line: the command that does it, as a shell takes it; empty where none does.
    """

    kind: str
    words: str
    line: str = ""


def next_step(result: Diagnosis, files: GivenFiles | None = None) -> NextStep:
    """What to do next with a diagnosis.

    Args:
        result: of diagnose.
        files: what its logs and model are called; placeholders where nothing is said.

    Example:
        >>> from cogging.diagnosis.next_step import next_step
        >>> step = next_step(cogging.diagnose(log, model))
        >>> step.line
        'cogging predict MODEL.toml --reference REF.toml'
    """
    files = files or GivenFiles()
    if result.mismatch is not None:
        return _read_otherwise(result, files)
    steps = {
        "no_gap": _keep_the_model,
        "named": _take_the_model,
        "ambiguous": _tell_apart,
        "unlisted": _look_where_it_sits,
        "controller_mismatch": _state_the_controller,
        "insufficient_excitation": _move_more,
    }
    return steps[result.verdict](result, files)


def _read_otherwise(result: Diagnosis, files: GivenFiles) -> NextStep:
    """Of a column that was misread: the same call with it read as it fits."""
    told = result.mismatch or {}
    name, _, value = str(told.get("option") or "").partition(" ")
    words = str(told.get("advice") or "Read the log again, that column otherwise.")
    return NextStep("mend", words, _diagnose(files, name, value) if value else "")


def _keep_the_model(result: Diagnosis, files: GivenFiles) -> NextStep:
    words = "Keep the model, and use it: it foretells the error that the machine will have. What is smaller than the "
    words += "detection limits may be there all the same: cogging experiment computes a motion that shows it."
    return NextStep("use", words, _predict(files.patched or files.model))


def _take_the_model(result: Diagnosis, files: GivenFiles) -> NextStep:
    return _adopt(files, _is_confirmed(result, files), "Write the model with what was found in it")


def _look_where_it_sits(result: Diagnosis, files: GivenFiles) -> NextStep:
    words = "What is left has no name: look at where it sits, and repeat the motion with that alone changed"
    if result.unlisted is not None and empirical_term(result.unlisted) is None:
        if not result.effects:
            return _move_more(result, files, words + ". ")
        return _adopt(files, _is_confirmed(result, files), words + ". To work with what was found, write the model")
    words += ". To work with it meanwhile, let a force of that shape be added to the model"
    return _adopt(files, _is_confirmed(result, files), words, empirical=True)


def _is_confirmed(result: Diagnosis, files: GivenFiles) -> bool:
    return bool(files.confirm) or result.gap.confirm_before is not None


def _adopt(files: GivenFiles, confirmed: bool, words: str, *, empirical: bool = False) -> NextStep:
    """A patched model is written, checked on other motion, then used."""
    more = ["--empirical"] if empirical else []
    if not confirmed and len(files.logs) > 1:
        *logs, last = files.logs
        one = replace(files, logs=logs, confirm=[last])
        words += ", and let the last of these logs confirm what the others say."
        return NextStep("confirm_by_last", words, _diagnose(one, *more, "--out", files.patched or "PATCHED.toml"))
    if not files.patched or (empirical and not files.empirical):
        words += ", and use that from now on." if confirmed else "; then check it on a log of other motion."
        return NextStep("write_model", words, _diagnose(files, *more, "--out", files.patched or "PATCHED.toml"))
    if not confirmed:
        words = "Check the new model before you use it: record a second log with other motion (other speeds, other "
        words += "strokes), and give it as a confirm log."
        one = replace(files, confirm=[*files.confirm, "OTHER_LOG.csv"])
        return NextStep("confirm", words, _diagnose(one, *more, "--out", files.patched))
    words = "Use the model with what was found in it: it foretells the error that the machine will have."
    return NextStep("use", words, _predict(files.patched))


def _tell_apart(result: Diagnosis, files: GivenFiles) -> NextStep:
    words = "No other name fits as well, but these logs do not make it sure: a motion that shows more of it will"
    if any(effect.alternatives for effect in result.effects):
        words = "Measure what tells the candidates apart"
    if not files.result:
        words += ". Write the result as a file: cogging experiment computes the motion from it."
        return NextStep("write_result", words, _diagnose(files, "--json", "RESULT.json"))
    words += ": run this motion, and diagnose both logs together."
    return NextStep("tell_apart", words, _experiment(files, "--result", files.result))


def _state_the_controller(result: Diagnosis, files: GivenFiles) -> NextStep:
    words = "State the controller that was running, its gains and its sample rate; or none, to be judged without. The "
    words += "audit says which gains would have given the logged command."
    return NextStep("audit", words, _line("audit", *files.logs, *files.confirm, "--model", files.model))


def _move_more(result: Diagnosis, files: GivenFiles, words: str = "") -> NextStep:
    words += "Move the axis over its travel, in both directions, at several speeds, for ten seconds or more. "
    return NextStep("move", words + "A motion within the limits of the machine can be computed.", _experiment(files))


def _line(*words: str) -> str:
    return shlex.join(("cogging", *words))


def _diagnose(files: GivenFiles, *more: str) -> str:
    """The same call with more words."""
    others = ("--confirm", *files.confirm) if files.confirm else ()
    return _line("diagnose", *files.logs, "--model", files.model, *others, *more)


def _experiment(files: GivenFiles, *more: str) -> str:
    return _line("experiment", "--model", files.model, *more, "--limits", "LIMITS.toml", "--out", "NEXT.toml")


def _predict(model: str) -> str:
    return _line("predict", model, "--reference", "REF.toml")
