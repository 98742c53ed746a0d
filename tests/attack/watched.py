"""Cases run in watched processes: a crash or a hang is reported by its seed, and the rest goes on."""

import gc
import importlib
import multiprocessing
import os
import traceback
from collections import Counter
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from typing import Any

HANG = 60.0  # s for one case


@dataclass
class Tally:
    """Result of an attack: cases, seeds that ended the process or hung, faults by seed, counts of remarks ("~...")."""

    cases: int
    crashes: list[int] = field(default_factory=list)
    hangs: list[int] = field(default_factory=list)
    faults: dict[int, str] = field(default_factory=dict)
    remarks: Counter[str] = field(default_factory=Counter)

    @property
    def found(self) -> int:
        """How many cases did not end as they should."""
        return len(self.crashes) + len(self.hangs) + len(self.faults)

    def text(self) -> str:
        """One line, and one for each of the first faults."""
        line = f"{self.cases} cases, {len(self.crashes)} crashes, {len(self.hangs)} hangs over {HANG:.0f} s, "
        line += f"{len(self.faults)} faults"
        line += "".join(f"; {count} {remark}" for remark, count in sorted(self.remarks.items()))
        shown = [f"    seed {seed}: the process ended" for seed in self.crashes[:10]]
        shown += [f"    seed {seed}: no end" for seed in self.hangs[:10]]
        shown += [f"    seed {seed}: {fault[:300]}" for seed, fault in list(self.faults.items())[:20]]
        return "\n".join([line, *shown])


def attack(module: str, seeds: Sequence[int], arguments: Mapping[str, Any] | None = None, processes: int = 2) -> Tally:
    """Run `module.run_case(seed, **arguments)` for each seed in processes."""
    tally = Tally(len(seeds))
    shares = [seeds[i::processes] for i in range(processes)]
    with ThreadPoolExecutor(processes) as pool:
        list(pool.map(lambda share: watch(module, dict(arguments or {}), share, tally), shares))
    return tally


def watch(module: str, arguments: dict[str, Any], seeds: Sequence[int], tally: Tally) -> None:
    """Run seeds in a process, and in a new one after each crash or hang."""
    process = None
    for seed in seeds:
        if process is None:
            context = multiprocessing.get_context("spawn")
            here, there = context.Pipe()
            process = context.Process(target=serve, args=(module, arguments, there), daemon=True)
            process.start()
            there.close()
            here.recv()  # it is ready
        here.send(seed)
        try:
            if here.poll(HANG):
                fault = here.recv()
                if fault and fault.startswith("~"):
                    tally.remarks[fault[1:]] += 1
                elif fault:
                    tally.faults[seed] = fault
                continue
            tally.hangs.append(seed)
        except EOFError:
            tally.crashes.append(seed)
        process.kill()
        process.join()
        process = None
    if process is not None:
        here.send(None)
        process.join()


def serve(module: str, arguments: dict[str, Any], pipe: Connection) -> None:
    """Answer each seed with the fault that its case found, in the process."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # libraries say much about broken files
    run_case = importlib.import_module(module).run_case
    gc.freeze()  # a case that collects looks at what cases have made, not at all libraries anew
    pipe.send(None)
    while (seed := pipe.recv()) is not None:
        try:
            fault = run_case(seed, **arguments)
        except BaseException:
            fault = traceback.format_exc()
        pipe.send(fault)
