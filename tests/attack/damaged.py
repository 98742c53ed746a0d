"""A sweep that resumes from a file of which one bit was flipped gives the table of an undisturbed one, or one line."""

from __future__ import annotations

import contextlib
import functools
import random
import tempfile
from pathlib import Path
from unittest import mock

import cogging
from cogging import outputs
from cogging.simulation import parameter_sweep as sweeps
from tests.fixtures.sweeps import MANY, MOVE, SMALL

OPTIONS = {"method": "random", "runs": 40, "seed": 5, "threads": 1, "duration": 0.02}
DONE = 24  # runs, in three pieces
outputs.synced = False


class Interrupted(Exception):
    """Interrupts a sweep at its middle."""


def run(out: Path, until: int) -> bytes:
    """Run the sweep, interrupted before run number `until`; the bytes of its table."""
    plain = sweeps.run_piece

    def run_piece(piece):
        if piece.first >= until:
            raise Interrupted
        return plain(piece)

    with mock.patch.object(sweeps, "run_piece", run_piece):
        cogging.sweep(SMALL, MOVE, MANY, out=out, **OPTIONS)
    return out.read_bytes()


@functools.cache
def sound() -> tuple[bytes, bytes]:
    """The table of an undisturbed sweep, and the file that an interrupted one leaves."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "runs.csv"
        whole = run(out, OPTIONS["runs"])
        out.unlink()
        with contextlib.suppress(Interrupted):
            run(out, DONE)
        return whole, out.with_name("runs.csv.kept").read_bytes()


def run_case(seed: int) -> str | None:
    """Flip one bit and resume; what is wrong, "~..." for what is no fault, or None."""
    (whole, left), chance = sound(), random.Random(seed)
    content = bytearray(left)
    content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    with tempfile.TemporaryDirectory() as folder:
        out, kept = Path(folder) / "runs.csv", Path(folder) / "runs.csv.kept"
        kept.write_bytes(content)
        try:
            table = run(out, OPTIONS["runs"])
        except cogging.InputError as error:
            return f"{error}" if "\n" in str(error) or out.exists() else "~refused in one line"
        if table != whole:
            return "another table"
        return "the file of pieces remains" if kept.exists() else None
