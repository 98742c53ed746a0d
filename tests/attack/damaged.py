"""Sweeps that resume from pieces of which one bit was flipped: `python -m tests.attack.damaged`.

Each case flips one bit of the files that an ended sweep has left. The same call must then give the table of an
undisturbed sweep, or, where the bit is one of `sweep.json`, refuse in one line.
Options: --cases N, --seed S.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
import traceback
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import cogging
from cogging import outputs
from cogging.simulation import sweep as sweeps
from tests.fixtures.sweeps import MANY, MOVE, SMALL

ASKED = {"method": "random", "runs": 40, "seed": 5, "threads": 1, "duration": 0.02}
DONE = 24  # runs, in three pieces


@dataclass
class Found:
    """Number of cases by outcome, and what was wrong: an error that is no answer, or another table."""

    counts: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)


class Ended(Exception):
    """A sweep is ended at its middle."""


def run(out: Path, until: int) -> None:
    """Make the sweep, ended before run number `until`."""
    plain = sweeps.run_piece

    def run_piece(piece):
        if piece.first >= until:
            raise Ended
        return plain(piece)

    sweeps.run_piece = run_piece
    try:
        cogging.sweep(SMALL, MOVE, MANY, out=out, **ASKED)
    finally:
        sweeps.run_piece = plain


def ended(out: Path) -> dict[str, bytes]:
    """Files that a sweep leaves which was ended at its middle, by name."""
    try:
        run(out, DONE)
    except Ended:
        folder = out.with_name(f"{out.name}.pieces")
        return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}
    raise AssertionError("the sweep was not ended")


def attack(cases: int, seed: int) -> Found:
    """Flip a bit and resume, so many times."""
    found, chance = Found(), random.Random(seed)
    synced, outputs.synced = outputs.synced, False
    try:
        with tempfile.TemporaryDirectory() as name:
            out = Path(name) / "runs.csv"
            run(out, ASKED["runs"])
            whole = out.read_bytes()
            out.unlink()
            files = ended(out)
            for _ in range(cases):
                name = chance.choices(list(files), [len(content) for content in files.values()])[0]
                content = bytearray(files[name])
                place, bit = chance.randrange(len(content)), chance.randrange(8)
                content[place] ^= 1 << bit
                outcome = resumed(out, {**files, name: bytes(content)}, whole)
                found.counts[outcome.partition(":")[0]] += 1
                if outcome.startswith(("escapes", "wrong table")):
                    found.faults.append(f"bit {bit} of byte {place} of {name}: {outcome}")
    finally:
        outputs.synced = synced
    return found


def resumed(out: Path, files: dict[str, bytes], whole: bytes) -> str:
    """The outcome of a sweep that finds these files."""
    folder = out.with_name(f"{out.name}.pieces")
    folder.mkdir(exist_ok=True)
    for path in folder.iterdir():
        path.unlink()
    for name, content in files.items():
        (folder / name).write_bytes(content)
    out.unlink(missing_ok=True)
    try:
        run(out, ASKED["runs"])
    except cogging.InputError as error:
        return "refused in one line" if "\n" not in str(error) and not out.exists() else f"escapes: {error}"
    except Exception:
        return f"escapes: {traceback.format_exc(limit=-1)}"
    if out.read_bytes() != whole:
        return "wrong table"
    return "made anew, the same table" if not folder.exists() else "escapes: the folder remains"


def main() -> int:
    """Flip bits and print the outcomes; status 1 where anything was wrong."""
    parser = argparse.ArgumentParser(prog="python -m tests.attack.damaged", description=__doc__)
    parser.add_argument("--cases", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    found = attack(options.cases, options.seed)
    outcomes = ", ".join(f"{count} {outcome}" for outcome, count in sorted(found.counts.items()))
    print(f"{options.cases} bits flipped: {outcomes}; {len(found.faults)} faults", *found.faults[:20], sep="\n    ")
    return 1 if found.faults else 0


if __name__ == "__main__":
    sys.exit(main())
