"""Sweeps that are killed at drawn moments and started again until they are done.

A sweep on one thread, on threads or in processes is ended some times by SIGKILL, SIGTERM or SIGINT. Its table is absent
or has the bytes of an undisturbed sweep, finished pieces are kept, no run is repeated but those in flight, and a signal
is answered in one line.
"""

from __future__ import annotations

import contextlib
import functools
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
import zlib
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from cogging.outputs import to_toml
from cogging_command import run_command
from tests.fixtures.sweeps import DOCUMENT, MANY, MOVE

RUNS, KILLS = 800, 5
#: Options of the command, and worker processes (0: the command's own threads).
WAYS = {"one thread": (("--threads", "1"), 0), "threads": (("--threads", "3"), 0), "processes": ((), 2)}
STATUS = {signal.SIGKILL: -9, signal.SIGTERM: 143, signal.SIGINT: 130}
CASES = [(way, number) for way in WAYS for number in STATUS if way != "processes" or number == signal.SIGKILL]
HANG = 50.0  # s


class Sweep:
    """A sweep in a folder of its own."""

    def __init__(self, folder: Path, way: str) -> None:
        self.out, self.log = folder / "runs.csv", folder / "begun"
        self.kept_file = folder / "runs.csv.kept"
        words, self.processes = WAYS[way]
        (folder / "model.toml").write_text(to_toml(DOCUMENT))
        (folder / "move.toml").write_text(to_toml({**MOVE, "duration": 1.0}))
        job = {"model": "model.toml", "reference": "move.toml", "method": "random", "runs": RUNS, "seed": 5}
        (folder / "sweep.toml").write_text(to_toml({**job, "vary": MANY}))
        self.words = ["sweep", f"{folder / 'sweep.toml'}", "--out", f"{self.out}", *words]

    def live(self, chance: random.Random, seconds: float, number: int) -> tuple[int, str]:
        """Start or continue it and end it at a drawn moment (number 0: do not); its status and standard error."""
        self.log.write_text("")
        command = [sys.executable, "-m", "tests.attack.killed", f"{self.log}", f"{self.processes}", *self.words]
        pipes = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
        process = subprocess.Popen(command, text=True, start_new_session=True, **pipes)
        if number:
            end = time.monotonic() + chance.uniform(0.0, seconds)
            # Before its first run the command may have no handlers yet: Python itself answers a signal then.
            while process.poll() is None and (
                time.monotonic() < end or (number != signal.SIGKILL and not self.begun())
            ):
                time.sleep(0.001)
            if process.poll() is None:
                process.send_signal(number)
        process.wait(HANG)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)  # workers that have lost their parent
        return process.returncode, process.communicate(timeout=HANG)[1]

    def pieces(self) -> set[bytes]:
        """Finished pieces: the whole lines of the file, as they were written."""
        lines = self.kept_file.read_bytes().split(b"\n")[1:] if self.kept_file.exists() else ()
        pairs = [line.partition(b" ")[::2] for line in lines]
        return {part for checksum, part in pairs if checksum == b"%08x" % zlib.crc32(part)}

    def kept(self) -> set[int]:
        """Runs of the finished pieces."""
        return {run for part in self.pieces() for run in json.loads(part)["run"]}

    def begun(self) -> list[int]:
        """Runs that this life has begun."""
        lines = [line.split() for line in self.log.read_text().splitlines()]
        return [run for first, count in lines for run in range(int(first), int(first) + int(count))]


@functools.cache
def undisturbed(way: str) -> tuple[bytes, float]:
    """The table of a sweep that nothing ends, and its seconds."""
    with tempfile.TemporaryDirectory() as folder:
        sweep, begin = Sweep(Path(folder), way), time.monotonic()
        status, said = sweep.live(random.Random(), 0.0, 0)
        assert not status, said
        assert sorted(sweep.begun()) == list(range(RUNS))
        return sweep.out.read_bytes(), time.monotonic() - begin


def run_case(seed: int) -> str | None:
    """End a sweep KILLS times and let it come to its end; what is wrong, or None."""
    (way, number), chance = CASES[seed % len(CASES)], random.Random(seed)
    whole, seconds = undisturbed(way)
    with tempfile.TemporaryDirectory() as folder:
        sweep, made, again = Sweep(Path(folder), way), Counter(), 0
        for life in range(KILLS + 1):
            before = sweep.pieces()
            status, said = sweep.live(chance, seconds, number if life < KILLS else 0)
            kept, begun, done = sweep.kept(), sweep.begun(), sweep.out.exists()
            status = 0 if done and status == -number else status  # Python gives up its handlers as it ends
            made.update(begun)
            if not done and before - sweep.pieces():
                return "a finished piece is gone"
            if status not in (0, STATUS[number]) or (not status and not done):
                return f"status {status}, table {done}, {said[:200]!r}"
            if number != signal.SIGKILL and status and (said.count("\n") != 1 or not said.startswith("cogging: ")):
                return f"not one line: {said[:200]!r}"
            if done and sweep.out.read_bytes() != whole:
                return "a table with other bytes"
            if done:
                break
            again += len(set(begun) - kept)
        if sorted(made) != list(range(RUNS)) or made.total() != RUNS + again:
            return f"{made.total()} runs made for {RUNS}, of which {again} were in flight at a kill"
    return None


def main(log: str, processes: str, *words: str) -> int:
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


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
