"""Cases run in watched processes: a crash or a hang is reported by its seed, and the rest goes on."""

from __future__ import annotations

import gc
import importlib
import multiprocessing
import os
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

HANG = 60.0  # s without an end of the case


@dataclass
class Tally:
    """Result of an attack: cases, seeds that ended the process or hung, faults by seed, counts of remarks ("~...")."""

    name: str
    cases: int = 0
    crashes: list[int] = field(default_factory=list)
    hangs: list[int] = field(default_factory=list)
    faults: dict[int, str] = field(default_factory=dict)
    remarks: dict[str, int] = field(default_factory=dict)

    @property
    def found(self) -> int:
        """How many cases did not end as they should."""
        return len(self.crashes) + len(self.hangs) + len(self.faults)

    def text(self) -> str:
        """One line, and one for each of the first faults."""
        lines = [
            f"{self.cases} cases, {len(self.crashes)} crashes, {len(self.hangs)} hangs over {HANG:.0f} s, "
            f"{len(self.faults)} tracebacks or nonsense accepted"
        ]
        lines[0] += "".join(f"; {count} {remark}" for remark, count in sorted(self.remarks.items()))
        lines += [f"    seed {seed}: the process ended" for seed in self.crashes[:10]]
        lines += [f"    seed {seed}: no end" for seed in self.hangs[:10]]
        lines += [f"    seed {seed}: {fault[:300]}" for seed, fault in list(self.faults.items())[:20]]
        return "\n".join(lines)


def attack(module: str, seeds: Sequence[int], arguments: Mapping[str, Any] | None = None, processes: int = 2) -> Tally:
    """Run `module.run_case(seed, **arguments)` for each seed in watched processes."""
    tally = Tally(module.rsplit(".", 1)[-1], cases=len(seeds))
    waiting = [list(seeds[i::processes]) for i in range(processes)]
    workers: list[_Worker | None] = [_Worker(module, dict(arguments or {}), part) if part else None for part in waiting]
    while any(workers):
        time.sleep(0.05)
        for place, worker in enumerate(workers):
            if worker is not None:
                workers[place] = worker.watched(tally)
    return tally


class _Worker:
    """A process that runs through its seeds and shares which it is at."""

    def __init__(self, module: str, arguments: dict[str, Any], seeds: list[int]) -> None:
        self.module, self.arguments, self.seeds = module, arguments, seeds
        context = multiprocessing.get_context("spawn")
        self.current = context.Value("q", -1, lock=False)
        self.began = context.Value("d", time.monotonic(), lock=False)
        self.queue: Any = context.SimpleQueue()
        self.process = context.Process(
            target=_go, args=(module, arguments, seeds, self.current, self.began, self.queue), daemon=True
        )
        self.process.start()

    def watched(self, tally: Tally) -> _Worker | None:
        """Collect what the process found; itself, one for the rest after a crash or hang, or None at the end."""
        while not self.queue.empty():
            seed, fault = self.queue.get()
            if fault.startswith("~"):
                tally.remarks[fault[1:]] = tally.remarks.get(fault[1:], 0) + 1
            else:
                tally.faults[seed] = fault
        alive = self.process.is_alive()
        at = self.current.value
        if alive and (at < 0 or time.monotonic() - self.began.value < HANG):
            return self
        if not alive and self.process.exitcode == 0:
            return None
        if alive:
            self.process.kill()
            self.process.join()
        (tally.hangs if alive else tally.crashes).append(at)
        rest = self.seeds[self.seeds.index(at) + 1 :] if at in self.seeds else []
        return _Worker(self.module, self.arguments, rest) if rest else None


def _go(module: str, arguments: dict[str, Any], seeds: list[int], current: Any, began: Any, queue: Any) -> None:
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # libraries say much about broken files
    run_case: Callable[..., str | None] = importlib.import_module(module).run_case
    gc.freeze()  # a case that collects looks at what cases have made, not at all libraries anew
    for seed in seeds:
        current.value, began.value = seed, time.monotonic()
        try:
            fault = run_case(seed, **arguments)
        except BaseException:
            fault = traceback.format_exc()
        if fault:
            queue.put((seed, fault))
