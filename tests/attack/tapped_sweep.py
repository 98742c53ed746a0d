"""`cogging sweep` that writes which runs it begins and may be ended at a file operation: one life of `killed`.

    python -m tests.attack.tapped_sweep TOLD SIGNAL WHERE NUMBER PROCESSES ARGUMENT ...

TOLD gets the first run and the number of runs of each piece that is begun. Before the NUMBER-th operation of the
sweep's files (WHERE "any"), or from the first on the table's own on ("end"), SIGNAL is sent; 0: never. PROCESSES: 0 is
the command; more are workers of a pool, which only Python can be told.
"""

from __future__ import annotations

import functools
import os
import sys
from concurrent.futures import ProcessPoolExecutor

from cogging_command import run_command
from tests.attack.operations import at_operation


def tapped(told: str) -> None:
    """Let each piece be told of when it is begun, in whatever process: one write of a line, which no kill parts."""
    from cogging.simulation import sweep

    plain = sweep.run_piece

    @functools.wraps(plain)
    def run_piece(piece):
        line = os.open(told, os.O_WRONLY | os.O_APPEND)
        os.write(line, f"{piece.first} {len(piece.points)}\n".encode())
        os.close(line)
        return plain(piece)

    sweep.run_piece = run_piece


def main() -> int:
    told, signal, where, number, processes, *words = sys.argv[1:]
    out = os.path.basename(words[words.index("--out") + 1])
    at_end = []

    def concerns(event: str, path: str) -> bool:
        if path.endswith(out) or (event == "os.remove" and path.endswith("sweep.json")):
            at_end.append(event)  # the table takes its place, its pieces go
        return ".cogging-" in path or out in path if where == "any" else bool(at_end)

    def run() -> int:
        tapped(told)
        at_operation(int(number), concerns, lambda *_: os.kill(os.getpid(), int(signal)))
        if processes == "0":
            from cogging.cli.main import main as command

            return command(words)
        from cogging.simulation.sweep import read_sweep, run_sweep

        with ProcessPoolExecutor(int(processes)) as pool:
            run_sweep(words[1], read_sweep(words[1]), out=words[words.index("--out") + 1], executor=pool)
        return 0

    return run_command(run)


if __name__ == "__main__":
    sys.exit(main())
