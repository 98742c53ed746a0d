"""Calls of the command with hostile options, models, references, names: one line and status 2, or a sound answer."""

from __future__ import annotations

import contextlib
import io
import logging
import os
import tempfile
import time
import warnings
from pathlib import Path
from unittest import mock

from cogging.cli.main import main
from cogging.papers.result import Reproduction
from tests.fixtures import hostile_calls
from tests.fixtures.hostile_answers import Answer, everything, faults, place

SHOWN_BY_PYTHON = (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning)  # not shown, that is
FIRST = 100_000  # the tests make calls of smaller seeds


def run_case(seed: int, kinds: tuple[str, ...] = hostile_calls.KINDS) -> str | None:
    """Make one call; what is wrong with its answer, or None."""
    call = hostile_calls.draw(kinds[seed % len(kinds)], FIRST + seed)
    with tempfile.TemporaryDirectory() as name:
        folder, here = Path(name), os.getcwd()
        before = place(call, folder)
        os.chdir(folder)
        try:
            answer = _answer(call, folder, before)
        finally:
            os.chdir(here)
        found = list(faults(answer, folder))
    return f"{call}: {'; '.join(found)}" if found else None


def _answer(call: hostile_calls.Call, folder: Path, before: dict[str, bytes]) -> Answer:
    out, err, raised, status = io.StringIO(), io.StringIO(), "", None
    started = time.process_time()
    papers = mock.patch("cogging.cli.reproduce.reproduce", lambda paper, progress: Reproduction(paper, [], {}))
    with (
        papers,
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        warnings.catch_warnings(record=True) as told,
    ):
        warnings.resetwarnings()
        for kind in SHOWN_BY_PYTHON:
            warnings.simplefilter("ignore", kind)
        try:
            status = main(call.arguments)
        except SystemExit as end:
            status = end.code
        except BaseException as error:
            raised = f"{type(error).__name__}: {error}"[:300]
    logging.disable(logging.NOTSET)
    after = everything(folder)
    left = sorted(name for name in after if after[name] != before.get(name))
    left += sorted(f"{name} (gone)" for name in before if name not in after)
    said = err.getvalue() + "".join(f"{one.category.__name__}: {one.message}\n" for one in told)
    model = b"[axis]" in after.get("out.toml", b"")
    return Answer(status, out.getvalue(), said, time.process_time() - started, left, raised, model)
