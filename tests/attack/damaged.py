"""Sweeps that resume from files of which one bit was flipped: `python -m tests.attack.damaged`.

Each case flips one bit of the files that an interrupted sweep has left. The same call must then give the table of an
undisturbed sweep. Options: --cases N, --seed S.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
import traceback
from collections import Counter
from pathlib import Path
from unittest import mock

import cogging
from cogging import outputs
from cogging.simulation import parameter_sweep as sweeps
from tests.fixtures.sweeps import MANY, MOVE, SMALL

OPTIONS = {"method": "random", "runs": 40, "seed": 5, "threads": 1, "duration": 0.02}
DONE = 24  # runs, in three pieces


class Interrupted(Exception):
    """Interrupts a sweep at its middle."""


def run(out: Path, until: int) -> None:
    """Run the sweep, interrupted before run number `until`."""
    plain = sweeps.run_piece

    def run_piece(piece):
        if piece.first >= until:
            raise Interrupted
        return plain(piece)

    with mock.patch.object(sweeps, "run_piece", run_piece):
        cogging.sweep(SMALL, MOVE, MANY, out=out, **OPTIONS)


def resume(out: Path, files: dict[str, bytes], whole: bytes) -> str:
    """Outcome of a sweep that finds these files."""
    folder = out.with_name(f"{out.name}.pieces")
    folder.mkdir(exist_ok=True)
    for path in (*folder.iterdir(), out):
        path.unlink(missing_ok=True)
    for name, content in files.items():
        (folder / name).write_bytes(content)
    try:
        run(out, OPTIONS["runs"])
    except cogging.InputError as error:
        return "refused in one line" if "\n" not in str(error) and not out.exists() else f"fault: {error}"
    except Exception:
        return f"fault: {traceback.format_exc(limit=-1)}"
    if out.read_bytes() != whole:
        return "fault: another table"
    return "fault: the folder remains" if folder.exists() else "the same table"


def main() -> int:
    """Flip bits and print the outcomes; status 1 where anything was wrong."""
    parser = argparse.ArgumentParser(prog="python -m tests.attack.damaged", description=__doc__)
    parser.add_argument("--cases", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    outcomes, chance = Counter(), random.Random(options.seed)
    outputs.synced = False
    with tempfile.TemporaryDirectory() as name:
        out = Path(name) / "runs.csv"
        run(out, OPTIONS["runs"])
        whole = out.read_bytes()
        out.unlink()
        try:
            run(out, DONE)
        except Interrupted:
            files = {path.name: path.read_bytes() for path in sorted(out.with_name("runs.csv.pieces").iterdir())}
        for _ in range(options.cases):
            name = chance.choices(list(files), [len(content) for content in files.values()])[0]
            content = bytearray(files[name])
            place, bit = chance.randrange(len(content)), chance.randrange(8)
            content[place] ^= 1 << bit
            outcome = resume(out, {**files, name: bytes(content)}, whole)
            outcomes[f"{outcome} (bit {bit} of byte {place} of {name})" if "fault" in outcome else outcome] += 1
    print(f"{options.cases} bits flipped", *(f"{count} {outcome}" for outcome, count in outcomes.items()), sep="\n    ")
    return int(any("fault" in outcome for outcome in outcomes))


if __name__ == "__main__":
    sys.exit(main())
