"""Calls of the command with hostile options, models, references, names: one line and status 2, or a sound answer."""

from __future__ import annotations

import contextlib
import io
import os
import tempfile
from pathlib import Path
from unittest import mock

from cogging.papers.result import Reproduction
from tests.fixtures import hostile_calls
from tests.fixtures.hostile_answers import answered, faults, place

#: A paper takes longer than a call is to, whatever its options.
PAPERS = mock.patch("cogging.cli.reproduce.reproduce", return_value=Reproduction("paper", [], {}))
COMPARISON = mock.patch("cogging.cli.reproduce.compare", return_value=Reproduction("comparison", [], {}))


def run_case(seed: int, kinds: tuple[str, ...] = hostile_calls.KINDS) -> str | None:
    """Make one call; what is wrong with its answer, or None."""
    call = hostile_calls.draw(kinds[seed % len(kinds)], seed)
    with tempfile.TemporaryDirectory() as name:
        folder, here = Path(name), os.getcwd()
        before = place(call, folder)
        os.chdir(folder)
        out, err = io.StringIO(), io.StringIO()
        try:
            with PAPERS, COMPARISON, contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                answer = answered(call, folder, before, lambda: (out.getvalue(), err.getvalue()))
        finally:
            os.chdir(here)
        found = list(faults(answer, folder))
    return f"{call}: {'; '.join(found)}" if found else None
