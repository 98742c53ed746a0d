"""Sweeps that are killed at drawn moments of their whole life and begun again: `python -m tests.attack.killed`.

Each way of making a sweep (one thread, threads and lanes, processes) is killed and started again until it is done, then
anew, until enough kills are made: while Python starts, at any time, before any operation of its files, and at its end.
SIGINT and SIGTERM likewise, which must be answered in one line. Whatever comes, the table is not there or has the bytes
of one that nothing has disturbed, every piece that stood stands, and no run is made twice but those in flight.
Options: --cases N kills (and a third as many of each signal), --seed S, --runs N of the sweep.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from cogging.outputs import to_toml
from tests.fixtures.sweeps import DOCUMENT, MANY, MOVE

#: Ways of making a sweep: options of the command, and processes of a pool (0: the command's own threads).
WAYS = {"one thread": (("--threads", "1"), 0), "threads": (("--threads", "3"), 0), "processes": ((), 2)}
MOMENTS = ("start", "any time", "an operation", "the end")
STATUS = {signal.SIGKILL: -9, signal.SIGTERM: 143, signal.SIGINT: 130}
HANG = 120.0  # s


@dataclass
class Found:
    """Kills by moment, lives of processes, sweeps done and their runs, runs in flight at a kill, leftovers, faults."""

    kills: Counter[str] = field(default_factory=Counter)
    lives: int = 0
    done: int = 0
    runs: int = 0
    in_flight: int = 0
    leftover: int = 0
    faults: list[str] = field(default_factory=list)

    def text(self) -> str:
        """One line, and one for each fault."""
        moments = ", ".join(f"{count} at {moment}" for moment, count in sorted(self.kills.items()))
        line = f"{sum(self.kills.values())} ended ({moments}), {self.lives} lives, {self.done} sweeps done, "
        line += f"{self.runs} runs each once with the same bits, {self.in_flight} in flight made again, "
        line += f"{self.leftover} folders left beside a whole table, {len(self.faults)} faults"
        return "\n    ".join([line, *self.faults[:20]])


class Sweep:
    """A sweep in a folder of its own."""

    def __init__(self, folder: Path, runs: int, way: str) -> None:
        self.folder, self.runs = folder, runs
        words, self.processes = WAYS[way]
        (folder / "model.toml").write_text(to_toml(DOCUMENT))
        (folder / "move.toml").write_text(to_toml({**MOVE, "duration": 1.0}))
        asked = {"model": "model.toml", "reference": "move.toml", "method": "random", "runs": runs, "seed": 5}
        (folder / "sweep.toml").write_text(to_toml({**asked, "vary": MANY}))
        self.out, self.told = folder / "runs.csv", folder / "told"
        self.words = ["sweep", f"{folder / 'sweep.toml'}", "--out", f"{self.out}", *words]

    def start(self, number: int = 0, where: str = "any", sent: int = 0) -> subprocess.Popen[str]:
        """Begin a life; `sent` ends it before the n-th operation."""
        self.told.write_text("")
        module = [sys.executable, "-m", "tests.attack.tapped_sweep"]
        told = [f"{self.told}", f"{int(sent)}", where, f"{number}", f"{self.processes}", *self.words]
        return subprocess.Popen(
            [*module, *told], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True
        )

    def pieces(self) -> dict[str, tuple[int, int]]:
        """The pieces by name, with what changes when one is written again; none without `sweep.json`."""
        folder = self.out.with_name("runs.csv.pieces")
        if not (folder / "sweep.json").exists() or not (folder / "sweep.json").stat().st_size:
            return {}
        found = {path.name: path.stat() for path in folder.glob("[0-9]*.npz")}
        return {name: (status.st_ino, status.st_mtime_ns) for name, status in found.items()}

    def kept(self) -> list[int]:
        """The runs of these pieces."""
        kept: list[int] = []
        for name in self.pieces():
            with np.load(self.out.with_name("runs.csv.pieces") / name, allow_pickle=False) as piece:
                kept += piece["run"].tolist()
        return kept

    def begun(self) -> list[int]:
        """The runs that this life has begun."""
        lines = [line.split() for line in self.told.read_text().splitlines()]
        return [run for first, count in lines for run in range(int(first), int(first) + int(count))]


def attack(way: str, cases: int, seed: int, number: signal.Signals, runs: int) -> Found:
    """End sweeps made in a way so many times by a signal, at moments that are drawn."""
    found, chance = Found(), random.Random(f"{way} {seed} {number}")
    with tempfile.TemporaryDirectory() as name:
        sweep = Sweep(Path(name), runs, way)
        began = time.monotonic()
        process = sweep.start()
        while not sweep.begun() and process.poll() is None:
            time.sleep(0.005)
        start = time.monotonic() - began
        _, said = process.communicate(timeout=HANG)
        if process.returncode or sorted(sweep.begun()) != list(range(runs)):
            found.faults.append(f"{way}: a sweep that nothing disturbs: status {process.returncode}, {said[:200]!r}")
            return found
        whole, life = sweep.out.read_bytes(), time.monotonic() - began
        numbers = [int(line.split(b",")[0]) for line in whole.splitlines()[1:]]
        if numbers != list(range(runs)):
            raise AssertionError("the table of an undisturbed sweep does not hold every run once")
        sweep.out.unlink()
        times = start, life
        while sum(found.kills.values()) < cases and not found.faults:
            found.faults += one_sweep(sweep, chance, times, number, cases, whole, found)
    return found


def one_sweep(
    sweep: Sweep,
    chance: random.Random,
    times: tuple[float, float],
    number: signal.Signals,
    cases: int,
    whole: bytes,
    found: Found,
) -> Iterator[str]:
    """End and start again until it is done; what is wrong."""
    made: Counter[int] = Counter()
    again = 0
    stood = sweep.pieces()
    while True:
        moment = chance.choice(MOMENTS) if sum(found.kills.values()) < cases else "none"
        status, said = ended_life(sweep, chance, moment, times, number)
        found.lives += 1
        kept, begun, done = set(sweep.kept()), sweep.begun(), sweep.out.exists()
        told = (sweep.out.parent / "runs.csv.pieces" / "sweep.json").exists()
        made.update(begun)
        if done and sweep.out.read_bytes() != whole:
            yield f"{moment}: a table with other bytes"
        if not done and set(stood.items()) - set(sweep.pieces().items()):
            yield f"{moment}: a piece that stood is gone, or was written again"
        if status not in (0, STATUS[number]):
            yield f"{moment}: status {status}, {said[:200]!r}"
        if number != signal.SIGKILL and status and (said.count("\n") != 1 or not said.startswith("cogging: ")):
            yield f"{moment}: not one line: {said[:200]!r}"
        if not status and not done:
            yield f"{moment}: status 0 and no table"
        if status:
            found.kills[moment] += 1
        if done and not told:
            break
        stood = sweep.pieces()
        again += 0 if done else len(set(begun) - kept)
    if sorted(made) != list(range(sweep.runs)) or sum(made.values()) != sweep.runs + again:
        yield f"{sum(made.values())} runs made for {sweep.runs}, of which {again} were in flight at a kill"
    found.leftover += sweep.out.with_name("runs.csv.pieces").exists()
    found.done, found.runs, found.in_flight = found.done + 1, found.runs + sweep.runs, found.in_flight + again
    sweep.out.unlink()


def ended_life(
    sweep: Sweep, chance: random.Random, moment: str, times: tuple[float, float], number: signal.Signals
) -> tuple[int, str]:
    """A life that is ended at a moment, or comes to its end before; its status and what it said."""
    start, life = times
    if moment in ("an operation", "the end"):
        most = 40 if moment == "an operation" else 12
        process = sweep.start(chance.randint(1, most), "any" if moment == "an operation" else "end", number)
    else:
        process = sweep.start()
        if moment != "none":
            end = time.monotonic() + chance.uniform(0.0, start if moment == "start" else life)
            while process.poll() is None and time.monotonic() < end:
                time.sleep(0.001)
            if process.poll() is None and (number == signal.SIGKILL or takes_signals(process)):
                process.send_signal(number)
    said = communicated(process)
    return process.returncode, said


def takes_signals(process: subprocess.Popen[str]) -> bool:
    """Wait until Python has given the command its handlers: what ends it before is Python's own answer."""
    while process.poll() is None:
        lines = Path(f"/proc/{process.pid}/status").read_text().splitlines()
        caught = int(next(line for line in lines if line.startswith("SigCgt")).split()[1], 16)
        if caught >> (signal.SIGTERM - 1) & 1:
            return True
        time.sleep(0.001)
    return False


def communicated(process: subprocess.Popen[str]) -> str:
    """Wait for the end of a life, and end the workers of a pool that have lost their parent."""
    process.wait(HANG)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    return process.communicate(timeout=HANG)[1]


def main() -> int:
    """End sweeps and tell what came of it; status 1 where anything was wrong."""
    parser = argparse.ArgumentParser(prog="python -m tests.attack.killed", description=__doc__)
    parser.add_argument("--cases", type=int, default=50, help="kills of each way")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--runs", type=int, default=800)
    arguments = parser.parse_args()
    faults = 0
    for way, (_, processes) in WAYS.items():
        for number in (signal.SIGKILL,) if processes else STATUS:
            cases = arguments.cases if number == signal.SIGKILL else -(-arguments.cases // 3)
            found = attack(way, cases, arguments.seed, signal.Signals(number), arguments.runs)
            print(f"sweep, {way}, {signal.Signals(number).name}: {found.text()}", flush=True)
            faults += len(found.faults)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
