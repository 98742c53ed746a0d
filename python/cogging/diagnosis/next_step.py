"""What to do next, by verdict: a sentence, and the command to paste. The page, the screen and a program ask here."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cogging.diagnosis.result import Diagnosis


@dataclass(frozen=True)
class GivenFiles:
    """The files of a diagnosis, by which the next command calls them; words in capitals are for the user to fill in.

    Attributes:
        logs: logs that were diagnosed.
        model: model that was held against them.
        confirm: logs of other motion; empty where there were none.
        options: further words of the call, as how columns are read.
        result: where the result was written as JSON; empty where it was not.
        patched: where the patched model was written; empty where it was not.
    """

    logs: Sequence[str] = ("LOG.csv",)
    model: str = "MODEL.toml"
    confirm: Sequence[str] = ()
    options: Sequence[str] = ()
    result: str = ""
    patched: str = ""


@dataclass(frozen=True)
class NextStep:
    """One thing to do next.

    Attributes:
        words: what to do and why, a sentence or two.
        command: words of the command that does it, the program first; empty where none does.
    """

    words: str
    command: tuple[str, ...] = ()

    def line(self) -> str:
        """The command as a shell takes it; empty where none is."""
        return shlex.join(self.command)


def next_step(result: Diagnosis, files: GivenFiles | None = None) -> NextStep:
    """What to do next with a diagnosis.

    Args:
        result: of diagnose.
        files: what its logs and model are called; placeholders where nothing is said.

    Example:
        >>> from cogging.diagnosis.next_step import next_step
        >>> step = next_step(cogging.diagnose(log, model))
        >>> step.line()
        'cogging experiment --model MODEL.toml --limits LIMITS.toml --out NEXT.toml'
    """
    files = files or GivenFiles()
    if result.mismatch is not None:
        return _read_otherwise(result, files)
    steps = {
        "no_gap": _look_closer,
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
    return NextStep(words, _diagnose(files, name, value) if value else ())


def _look_closer(result: Diagnosis, files: GivenFiles) -> NextStep:
    words = (
        "Keep the model. What is smaller than the detection limits may be there all the same: a motion that is made "
    )
    return NextStep(words + "to show small effects finds more.", _experiment(files))


def _take_the_model(result: Diagnosis, files: GivenFiles) -> NextStep:
    if result.gap.confirm_before is None:
        words = "Check it before you use it: record a second log with other motion (other speeds, other strokes), and "
        return NextStep(words + "give it as a confirm log.", _diagnose(files, "--confirm", "OTHER_LOG.csv"))
    if not files.patched:
        words = "Other motion agrees: write the model with what was found in it, and use that from now on."
        return NextStep(words, _diagnose(files, "--out", "PATCHED.toml"))
    words = "Use the model with what was found in it: it foretells the error that the machine will have."
    return NextStep(words, ("cogging", "predict", files.patched, "--reference", "REF.toml"))


def _tell_apart(result: Diagnosis, files: GivenFiles) -> NextStep:
    if not any(effect.alternatives for effect in result.effects):
        if result.gap.confirm_before is None:
            words = "No other name fits as well, but one log is not enough to be sure: record a second one with other "
            return NextStep(words + "motion.", _diagnose(files, "--confirm", "OTHER_LOG.csv"))
        words = "No other name fits as well, but these logs do not make it sure: a motion that shows more of it will."
        return NextStep(words, _experiment(files))
    if not files.result:
        words = "Measure what tells the candidates apart: write the result as a file; cogging experiment computes the "
        return NextStep(words + "motion from it.", _diagnose(files, "--json", "RESULT.json"))
    words = "Measure what tells the candidates apart, with this motion, and diagnose both logs together."
    return NextStep(words, _experiment(files, "--result", files.result))


def _look_where_it_sits(result: Diagnosis, files: GivenFiles) -> NextStep:
    words = "What is left has no name: look at where it sits, and repeat the motion with that alone changed. "
    if files.patched:
        words += "A log of other motion says whether it comes back."
        return NextStep(words, _diagnose(files, "--confirm", "OTHER_LOG.csv"))
    words += "To work with it meanwhile, let a force of that shape be added to the model."
    return NextStep(words, _diagnose(files, "--empirical", "--out", "PATCHED.toml"))


def _state_the_controller(result: Diagnosis, files: GivenFiles) -> NextStep:
    words = "State the controller that was running, its gains and its sample rate; or none, to be judged without. The "
    words += "audit says which gains would have given the logged command."
    return NextStep(words, ("cogging", "audit", *files.logs, *files.options, "--model", files.model))


def _move_more(result: Diagnosis, files: GivenFiles) -> NextStep:
    words = "Move the axis over its travel, in both directions, at several speeds, for ten seconds or more. A motion "
    return NextStep(words + "within the limits of the machine can be computed.", _experiment(files))


def _diagnose(files: GivenFiles, *more: str) -> tuple[str, ...]:
    """The same call with more words; a further confirm log stands beside those that there are."""
    confirm, words = list(files.confirm), list(more)
    if words[:1] == ["--confirm"]:
        confirm, words = [*confirm, *words[1:]], []
    others = ("--confirm", *confirm) if confirm else ()
    return ("cogging", "diagnose", *files.logs, *files.options, "--model", files.model, *others, *words)


def _experiment(files: GivenFiles, *more: str) -> tuple[str, ...]:
    return ("cogging", "experiment", "--model", files.model, *more, "--limits", "LIMITS.toml", "--out", "NEXT.toml")
