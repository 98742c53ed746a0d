"""What a hostile call left behind, and what is wrong with it."""

import json
import os
from dataclasses import dataclass

import pytest

from cogging.model import Model

SECONDS = 10.0  # of processor time: the machine may be busy with something else
LONGEST = 4000  # characters of an answer


@dataclass(frozen=True)
class Answer:
    """What a call did."""

    status: object
    out: str
    err: str
    seconds: float
    left: list
    raised: str = ""
    model: bool = False  # whether out.toml is a whole model


def place(call, folder):
    """Write the files of a call into a folder; those that the file system refuses are not there."""
    (folder / "folder").mkdir()
    for name, content in call.files.items():
        try:
            path = os.path.join(folder, name)
            if content is None:
                os.mkdir(path)
            elif not name.startswith("/"):
                with open(path, "wb") as file:
                    file.write(content)
        except (OSError, ValueError):
            continue
    return everything(folder)


def everything(folder):
    """The files below a folder with their contents."""
    found = {}
    for where, _, names in os.walk(folder):
        for name in names:
            with open(os.path.join(where, name), "rb") as file:
                found[os.path.relpath(os.path.join(where, name), folder)] = file.read()
    return found


def faults(answer, folder):
    """What is wrong with an answer: a few words each."""
    if answer.raised:
        yield f"traceback {answer.raised}"
        return
    if answer.status not in (0, 2):
        yield f"status {answer.status!r}"
    if answer.status == 2:
        if len(answer.err.splitlines()) != 1 or not answer.err.endswith("\n") or not answer.err.startswith("cogging"):
            yield f"not one line: {answer.err[:300]!r}"
        if len(answer.err) > LONGEST:
            yield f"too long a line: {len(answer.err)}"
        if answer.left:
            yield f"left behind {answer.left}"
    elif answer.err:
        yield f"something on standard error: {answer.err[:300]!r}"
    for where, text in (("err", answer.err), ("out", answer.out)):
        odd = sorted({character for character in text if not character.isprintable() and character != "\n"})
        if odd:
            yield f"control characters on std{where}: {''.join(odd)!r}"
    if answer.seconds > SECONDS:
        yield f"too slow: {answer.seconds:.1f} s"
    if answer.status == 0:
        yield from wrong_files(answer, folder)


def wrong_files(answer, folder):
    """JSON that is not strict, models that cannot be read."""
    for name in answer.left:
        path = os.path.join(folder, name)
        try:
            if name.endswith("json"):
                with open(path, encoding="utf-8") as file:
                    json.load(file, parse_constant=lambda word: pytest.fail(f"{word} in JSON"))
            elif name == "out.toml" and answer.model:
                Model.read(path)
        except (ValueError, pytest.fail.Exception) as error:
            yield f"{name}: {error}"[:300]
