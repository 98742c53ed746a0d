"""Calls of the command with hostile options, models, references, names: one line and status 2, or a sound answer."""

import io
import json
import os
import tempfile
import time
import warnings
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout, suppress
from pathlib import Path
from unittest import mock

from cogging.cli.main import main
from cogging.model.model import Model
from cogging.papers.result import Reproduction
from tests.fixtures import hostile_calls

#: A paper takes longer than a call is to, whatever its options.
PAPERS = mock.patch("cogging.cli.reproduce.reproduce", return_value=Reproduction("paper", [], {}))
COMPARISON = mock.patch("cogging.cli.reproduce.compare", return_value=Reproduction("comparison", [], {}))
SECONDS = 30.0  # of processor time, which grows where the machine is busy: a diagnosis from four starts takes 14 there
LONGEST = 4000  # characters of an answer
NOT_SHOWN = (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning)  # by Python itself


def run_case(seed: int, kinds: tuple[str, ...] = hostile_calls.KINDS) -> str | None:
    """Make one call in a folder of its own; what is wrong with its answer, or None."""
    call = hostile_calls.draw(kinds[seed % len(kinds)], seed)
    with tempfile.TemporaryDirectory() as name:
        place(call, Path(name))
        here = os.getcwd()
        os.chdir(name)
        try:
            with PAPERS, COMPARISON:
                found = list(faults(call, Path(name)))
        finally:
            os.chdir(here)
    return f"{call}: {'; '.join(found)}" if found else None


def place(call: hostile_calls.Call, folder: Path) -> None:
    """Write the files of a call into a folder, but those that the file system refuses."""
    (folder / "folder").mkdir()
    for name, content in call.files.items():
        with suppress(OSError, ValueError):
            path = os.path.join(folder, name)
            if content is None:
                os.mkdir(path)
            elif not name.startswith("/"):
                Path(path).write_bytes(content)


def everything(folder: Path) -> dict[str, bytes]:
    """The contents of the files below a folder by their paths."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def faults(call: hostile_calls.Call, folder: Path) -> Iterator[str]:
    """Make a call in its folder, which is the current one; what is wrong with its answer, a few words each."""
    before, begin, status = everything(folder), time.process_time(), None
    out, err = io.StringIO(), io.StringIO()
    with warnings.catch_warnings(record=True) as warned, redirect_stdout(out), redirect_stderr(err):
        warnings.resetwarnings()
        for kind in NOT_SHOWN:
            warnings.simplefilter("ignore", kind)
        try:
            status = main(call.arguments)
        except SystemExit as end:
            status = end.code
        except BaseException as error:
            yield f"traceback {type(error).__name__}: {error}"[:300]
            return
    seconds, after = time.process_time() - begin, everything(folder)
    error = err.getvalue() + "".join(f"{one.category.__name__}: {one.message}\n" for one in warned)
    left = sorted(name for name in after.keys() | before.keys() if after.get(name) != before.get(name))
    if status not in (0, 2):
        yield f"status {status!r}"
    if status == 2:
        if len(error.splitlines()) != 1 or not error.endswith("\n") or not error.startswith("cogging"):
            yield f"not one line: {error[:300]!r}"
        if len(error) > LONGEST:
            yield f"too long a line: {len(error)}"
        if left:
            yield f"left behind {left}"
    elif error:
        yield f"something on standard error: {error[:300]!r}"
    if odd := sorted({mark for mark in error + out.getvalue() if not mark.isprintable() and mark != "\n"}):
        yield f"control characters: {''.join(odd)!r}"
    if seconds > SECONDS:
        yield f"too slow: {seconds:.1f} s"
    for name in left if status == 0 else ():
        try:
            if name.endswith("json"):
                json.loads(after[name], parse_constant=lambda word: json.loads(f"no number: {word}"))
            elif name == "out.toml" and b"[axis]" in after[name]:
                Model.read(folder / name)
        except ValueError as invalid:
            yield f"{name}: {invalid}"[:300]
