"""Sweeps that are killed at drawn moments and started again: `python -m tests.attack.killed`.

A sweep on one thread, on threads or in processes is ended by SIGKILL, SIGTERM or SIGINT at a drawn time and started
again until it is done. Its table is absent or has the bytes of an undisturbed sweep,
finished pieces are kept, no run is repeated but those in flight, and a signal is answered in one line.
Options: --cases N kills of each way (a third as many of each signal), --seed S, --runs N of the sweep.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from cogging.outputs import to_toml
from cogging_command import run_command
from tests.fixtures.sweeps import DOCUMENT, MANY, MOVE

#: Options of the command, and worker processes (0: the command's own threads).
WAYS = {"one thread": (("--threads", "1"), 0), "threads": (("--threads", "3"), 0), "processes": ((), 2)}
STATUS = {signal.SIGKILL: -9, signal.SIGTERM: 143, signal.SIGINT: 130}
HANG = 120.0  # s


class Sweep:
    """A sweep in a folder of its own."""

    def __init__(self, folder: Path, runs: int, way: str) -> None:
        self.runs, self.out, self.log = runs, folder / "runs.csv", folder / "begun"
        self.pieces_folder = folder / "runs.csv.pieces"
        words, self.processes = WAYS[way]
        (folder / "model.toml").write_text(to_toml(DOCUMENT))
        (folder / "move.toml").write_text(to_toml({**MOVE, "duration": 1.0}))
        job = {"model": "model.toml", "reference": "move.toml", "method": "random", "runs": runs, "seed": 5}
        (folder / "sweep.toml").write_text(to_toml({**job, "vary": MANY}))
        self.words = ["sweep", f"{folder / 'sweep.toml'}", "--out", f"{self.out}", *words]

    def start(self) -> subprocess.Popen[str]:
        """Start the sweep, or continue it."""
        self.log.write_text("")
        life = [f"{self.log}", f"{self.processes}", *self.words]
        command = [sys.executable, "-m", "tests.attack.killed", "--life", *life]
        pipes = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
        return subprocess.Popen(command, text=True, start_new_session=True, **pipes)

    def pieces(self) -> set[tuple[str, int, int]]:
        """Finished pieces: name, inode and time of writing."""
        found = {path.name: path.stat() for path in self.pieces_folder.glob("*.npz")}
        return {(name, status.st_ino, status.st_mtime_ns) for name, status in found.items()}

    def kept(self) -> set[int]:
        """Runs of the finished pieces."""
        found: set[int] = set()
        for name, *_ in self.pieces():
            with np.load(self.pieces_folder / name, allow_pickle=False) as piece:
                found.update(piece["run"].tolist())
        return found

    def begun(self) -> list[int]:
        """Runs that this life has begun."""
        lines = [line.split() for line in self.log.read_text().splitlines()]
        return [run for first, count in lines for run in range(int(first), int(first) + int(count))]


def live(log: str, processes: str, *words: str) -> int:
    """Run the sweep and write which runs it begins to `log`."""
    from cogging.cli.main import main as command
    from cogging.simulation import parameter_sweep as sweep

    plain, out = sweep.run_piece, words[words.index("--out") + 1]

    @functools.wraps(plain)
    def run_piece(piece):
        with open(log, "ab", buffering=0) as file:  # one write of a line, which no kill divides
            file.write(f"{piece.first} {len(piece.points)}\n".encode())
        return plain(piece)

    def run() -> int:
        sweep.run_piece = run_piece
        if processes == "0":
            return command(list(words))
        with ProcessPoolExecutor(int(processes)) as pool:
            sweep.sweep(**sweep.read_sweep(words[1]), out=out, executor=pool)
        return 0

    return run_command(run)


def end_life(sweep: Sweep, chance: random.Random, seconds: float, number: int) -> tuple[int, str]:
    """Status and standard error of a life that is ended at a drawn moment (number 0: not)."""
    process = sweep.start()
    if number:
        end = time.monotonic() + chance.uniform(0.0, seconds)
        # Before its first run the command may have no handlers yet: Python itself answers a signal then.
        while process.poll() is None and (time.monotonic() < end or (number != signal.SIGKILL and not sweep.begun())):
            time.sleep(0.001)
        if process.poll() is None:
            process.send_signal(number)
    process.wait(HANG)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)  # workers that have lost their parent
    return process.returncode, process.communicate(timeout=HANG)[1]


def attack(way: str, cases: int, seed: int, number: signal.Signals, runs: int) -> tuple[Counter[str], list[str]]:
    """Counts and faults of sweeps that are ended so many times."""
    counts, faults, chance = Counter(), [], random.Random(f"{way} {seed} {number}")
    with tempfile.TemporaryDirectory() as name:
        sweep, begin = Sweep(Path(name), runs, way), time.monotonic()
        status, said = end_life(sweep, chance, 0.0, 0)
        seconds = time.monotonic() - begin
        if status or sorted(sweep.begun()) != list(range(runs)):
            return counts, [f"{way}: an undisturbed sweep: status {status}, {said[:200]!r}"]
        whole = sweep.out.read_bytes()
        assert [int(line.split(b",")[0]) for line in whole.splitlines()[1:]] == list(range(runs))
        while counts["ended"] < cases and not faults:
            sweep.out.unlink()
            made, again, done = Counter(), 0, False
            while not done:
                before = sweep.pieces()
                status, said = end_life(sweep, chance, seconds, number if counts["ended"] < cases else 0)
                kept, begun, done = sweep.kept(), sweep.begun(), sweep.out.exists()
                status = 0 if done and status == -number else status  # Python gives up its handlers as it ends
                made.update(begun)
                counts.update({"lives": 1, "ended": bool(status)})
                if done and sweep.out.read_bytes() != whole:
                    faults.append("a table with other bytes")
                if not done and before - sweep.pieces():
                    faults.append("a finished piece is gone, or was written again")
                if status not in (0, STATUS[number]) or (not status and not done):
                    faults.append(f"status {status}, table {done}, {said[:200]!r}")
                if number != signal.SIGKILL and status and (said.count("\n") != 1 or not said.startswith("cogging: ")):
                    faults.append(f"not one line: {said[:200]!r}")
                done = done and not sweep.pieces()
                again += 0 if done or sweep.out.exists() else len(set(begun) - kept)
            if sorted(made) != list(range(runs)) or made.total() != runs + again:
                faults.append(f"{made.total()} runs made for {runs}, of which {again} were in flight at a kill")
            counts.update({"sweeps done": 1, "runs in flight": again, "folders left": sweep.pieces_folder.exists()})
    return counts, faults


def main() -> int:
    """End sweeps and print what happened; status 1 where anything was wrong."""
    parser = argparse.ArgumentParser(prog="python -m tests.attack.killed", description=__doc__)
    parser.add_argument("--cases", type=int, default=50, help="kills of each way")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--runs", type=int, default=800)
    options, wrong = parser.parse_args(), 0
    for way, (_, processes) in WAYS.items():
        for number in (signal.SIGKILL,) if processes else STATUS:
            cases = options.cases if number == signal.SIGKILL else -(-options.cases // 3)
            counts, faults = attack(way, cases, options.seed, signal.Signals(number), options.runs)
            shown = ", ".join(f"{count} {what}" for what, count in counts.items())
            print(f"{way}, {signal.Signals(number).name}: {shown}; {len(faults)} faults", *faults, sep="\n    ")
            wrong += len(faults)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(live(*sys.argv[2:]) if sys.argv[1:2] == ["--life"] else main())
