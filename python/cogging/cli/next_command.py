"""The sensible next command after one that is done, in the user's own files and options, to be pasted into a shell.

Words in capitals, such as REF.toml, stand for files that only the user can have (PLACEHOLDERS).
"""

from __future__ import annotations

import argparse
import math
import os
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cogging.outputs import AnyPath

if TYPE_CHECKING:
    from cogging.identification.identification_result import Identification
    from cogging.model.model import Model

#: Files of the user's that a next command may need, and what each is.
PLACEHOLDERS = {
    "LOG.csv": "a log of the machine",
    "OTHER_LOG.csv": "a log of other motion, which took no part in the diagnosis",
    "NEW_LOG.csv": "the log of the motion that was computed",
    "MODEL.toml": "a model of the machine",
    "REF.toml": "a motion of the machine",
    "LIMITS.toml": "what the machine may do",
    "TUNE.toml": "which gains are tuned, within which limits",
}
NOTHING_LEFT = 1.1  # of what no force can explain
MOSTLY = 0.9  # of the command's power


def command_line(*words: str | Sequence[str]) -> str:
    """A call of the command as a shell takes it.

    Args:
        words: each a word, or several in a list.
    """
    flat = [word for entry in words for word in ([entry] if isinstance(entry, str) else entry)]
    return " ".join(["cogging", *map(shell_word, flat)])


def shell_word(word: str) -> str:
    """A word quoted for the shell, in letters that a terminal shows: others as $'...' of bash and zsh."""
    if os.name == "nt":
        return f'"{word}"' if not word or any(letter in word for letter in " &()^;,'") else word
    encoding = getattr(sys.stdout, "encoding", None) or "utf-8"
    try:
        word.encode(encoding)
        shown = word.isprintable()
    except UnicodeError:
        shown = False
    if shown:
        return shlex.quote(word)
    letters = []
    for byte in word.encode("utf-8", "surrogateescape" if not _paired(word) else "surrogatepass"):
        letter = chr(byte)
        letters.append(letter if 0x20 <= byte < 0x7F and letter not in "'\\" else f"\\x{byte:02x}")
    return f"$'{''.join(letters)}'"


def _paired(word: str) -> bool:
    """Whether there are surrogates that stand for no byte, which no file name has."""
    return any("\ud800" <= letter < "\udc80" or "\udcff" < letter <= "\udfff" for letter in word)


def files(paths: Sequence[AnyPath]) -> list[str]:
    """Paths as words that no option is mistaken for."""
    return [f".{os.sep}{path}" if os.fspath(path).startswith("-") else os.fspath(path) for path in paths]


def option(name: str, *values: AnyPath | None) -> list[str]:
    """An option with its files; nothing where the first is None."""
    return [] if values[:1] == (None,) else [name, *files([value for value in values if value is not None])]


def log_options(arguments: argparse.Namespace) -> list[str]:
    """How the logs were read, in the words of the call."""
    words = []
    for name, text in getattr(arguments, "log_words", ()):
        words += [f"{name}={text}"] if text.startswith("-") else [name, text]
    return words


def free_name(path: AnyPath, ending: str = "") -> str:
    """A file name that is not taken: `PATH`, or `STEM_ending.toml` beside it, with a number where need be."""
    wanted = Path(path)
    name = wanted.with_name(f"{wanted.stem}_{ending}.toml") if ending else wanted
    numbered = (name.with_name(f"{name.stem}_{number}{name.suffix}") for number in range(2, 1000))
    return str(next((one for one in (name, *numbered) if not os.path.lexists(one)), name))


def after_an_audit(arguments: argparse.Namespace) -> str:
    """A log that was looked at is fitted; without a model that comes first."""
    if arguments.model is not None:
        return _fit(arguments, arguments.model)
    return _init(*files(arguments.logs[:1]), *log_options(arguments))


def _init(*words: str) -> str:
    names = {"--out": "model.toml", "--reference": "reference.toml"}  # which it does not replace
    taken = [option(name, free_name(path)) for name, path in names.items() if os.path.lexists(path)]
    return command_line("init", list(words), *taken)


def _fit(arguments: argparse.Namespace, model: AnyPath) -> str:
    out = option("--out", free_name(model, "fitted"))
    return command_line("identify", files(arguments.logs), option("--model", model), log_options(arguments), out)


def after_a_fit(arguments: argparse.Namespace, found: Identification) -> str:
    """A fit is kept; what it leaves unexplained is diagnosed, and where nothing is left it predicts."""
    explained = all(log.noise is not None and log.residual_after < NOTHING_LEFT * log.noise for log in found.logs)
    if not explained or found.warnings or not can_predict(found.model):
        kept = arguments.out and not found.warnings and found.explained > MOSTLY  # else the gap has spoilt the fit
        believed = arguments.out if kept else arguments.model
        return command_line("diagnose", files(arguments.logs), option("--model", believed), log_options(arguments))
    return after_a_model(arguments.out, found.model) if arguments.out else _fit(arguments, arguments.model)


def after_a_map(arguments: argparse.Namespace) -> str:
    """A map is kept, and put into a model that is fitted to logs."""
    if arguments.out:
        return command_line("identify", "LOG.csv", "--model", "MODEL.toml", option("--out", free_name("fitted.toml")))
    sign = ["--force-sign", str(arguments.force_sign)] if arguments.force_sign != 1 else []
    again = [*files([arguments.scan]), "--pitch", repr(arguments.pitch), *sign, *log_options(arguments)]
    return command_line("map", again, option("--out", free_name(arguments.scan, "map")))


def after_an_export(arguments: argparse.Namespace, *, of_map: bool) -> str:
    """With the map in its drive the axis is logged again; code is held against a run of its model."""
    if of_map:
        return _init("NEW_LOG.csv")
    out = option("--out", free_name("run.csv"))
    return command_line("simulate", files([arguments.model]), "--reference", "REF.toml", out)


def after_a_paper(arguments: argparse.Namespace) -> str:
    """Papers are compared on one axis; after that comes a machine of one's own."""
    if arguments.compare:
        return _init("LOG.csv")
    return command_line("reproduce", "--compare", option("--out", arguments.out))


def after_many_runs(model_file: AnyPath, reference: AnyPath) -> str:
    """What a model that many runs were made of will do, or one of its runs."""
    from cogging.model.model import Model

    call = [*files([model_file]), *option("--reference", reference)]
    if can_predict(Model.read(model_file)):
        return command_line("predict", call)
    return command_line("simulate", call, option("--out", free_name("log.csv")))


def can_predict(model: Model) -> bool:
    """Whether `predict` can say how well a model's own controller will do: every interval has two ends."""
    return model.controller is not None and all(math.isfinite(end) for ends in model.intervals.values() for end in ends)


def after_a_model(path: AnyPath, model: Model, reference: AnyPath | None = None) -> str:
    """What is next with a model that is believed: what its controllers will do, or what would make it surer."""
    if can_predict(model):
        return command_line("predict", files([path]), option("--reference", reference or "REF.toml"))
    return experiment(path)


def experiment(model: AnyPath, *words: str) -> str:
    """The call that computes a motion for a model."""
    out = option("--out", free_name("experiment.toml"))
    return command_line("experiment", option("--model", model), list(words), "--limits", "LIMITS.toml", out)
