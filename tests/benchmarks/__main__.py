"""Every ratio as one table: one run and packs of runs beside hand-written code, many runs beside other libraries.

    python -m tests.benchmarks [--short]

Each part looks first at whether what it compares gives the same answer, and ends the command where it does not. Of the
parts there are modules of their own with more to ask for. `--short` takes few repeats and small sizes: it shows that
the parts run and agree; its times say little. What is being measured is written to standard error.
"""

import argparse
import os
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import lanes
import lu2008_loop
import own_controllers

from cogging import _core
from cogging_command import run_command
from tests.benchmarks import growth, million, peers, real_time

ROWS_OF_X = 192_001


def one_run(short):
    """Ratios of a run to hand-written code."""
    setup = lu2008_loop.SETUP | ({"repeats": 1.0} if short else {})
    rows, seconds = lu2008_loop.timed(3 if short else 15, setup)
    yield "one run, C3 on X", f"{1e9 * seconds['core'] / rows:.0f} ns a step", ""
    for name in ("hand-written", "hand-written, libm", "numba"):
        if name in seconds:
            yield "", f"{seconds['core'] / seconds[name]:.2f}", f"of {name}"


def packs(short):
    """Ratios of packs of runs to packs by hand, and of two threads."""
    rows, seconds = lanes.timed(3 if short else 15, 16 if short else 64)
    runs = 16 if short else 64
    yield f"{runs} runs in packs, C3 on X", "", ""
    for name, value in seconds.items():
        hand = lanes.by_hand_of(name, seconds)
        if name.startswith("core") and "threads" not in name:
            ratio = f"{value / hand:.2f} of by hand" if hand else "no pack"
            yield f"  {name[6:]}", f"{1e9 * value / rows / runs:.0f} ns a step", ratio
        elif "threads" in name:
            alone = seconds[name.replace(", 2 threads", "")]
            yield "  two threads", f"{alone / value:.2f}", "times as fast as one"


def libraries(short):
    """Ratios of other libraries to the core."""
    counts, rows, rounds = ([1, 20], 201, 1) if short else ([1, 100, 2000], 2001, 2)
    for one in peers.figures(counts, rows, rounds, repeats=2 if short else 3):
        beside = f"compiles {one.compile:.1f} s, {one.megabytes:.0f} MB"
        yield f"{one.runs} runs of a PID, {one.name}", f"{one.ratio:.2f} of cogging", beside


def many(short):
    """Time and memory of many runs of the X axis, and what a million take."""
    runs, rows = (10, 9601) if short else (200, ROWS_OF_X)
    for kind in ("batch", "sweep"):
        found = million.measured(kind, runs, rows)
        each = found["seconds"] / runs * ROWS_OF_X / rows
        beside = f"peak {found['peak']:.0f} MB; a million {1e6 * each / 3600:.1f} core hours"
        yield f"{kind} of {runs} runs, C3 on X", f"{1e3 * each:.1f} ms a run", beside


def own(short):
    """What a controller of one's own costs."""
    found = own_controllers.measure(3 if short else 9)
    for name in ("compiled", "Python"):
        if name in found:
            yield f"own controller, {name}", f"{found[name] / found['core']:.2f}", "of the core's"


def steps(short):
    """Each controller's step alone."""
    for name, row in real_time.rows(100_000 if short else 2_000_000).items():
        figures = f"{row['median']:.0f} ns median, {row['most']:.0f} ns 99.99 %"
        yield f"step of {name}", figures, f"{row['allocations']:.0f} allocations, own worst {row['own_worst']:.0f} ns"


def grown(short):
    """What the largest of each kind takes against the smallest."""
    for what, one in growth.measured(1 if short else 5, with_memory=False).items():
        ratio = one["seconds"][-1] / one["seconds"][0]
        yield f"{what}: {one['sizes'][0]} to {one['sizes'][-1]}", f"{ratio:.2f}", "times the time"


PARTS = (one_run, packs, libraries, many, own, steps, grown)


def main(short):
    """Prints the table, part by part."""
    sets = ", ".join(_core.instruction_sets()) or "none"
    print(f"{real_time.processor()}: instruction sets {sets}; {os.cpu_count()} cores", flush=True)
    begin, lines = time.monotonic(), []

    def progress(what):
        print(f"{time.monotonic() - begin:4.0f} s: {what}", file=sys.stderr, flush=True)

    for number, part in enumerate(PARTS, 1):
        progress(f"{number} of {len(PARTS)}, {part.__name__}")
        lines += [f"{what:40}{figure:>34}  {beside}".rstrip() for what, figure, beside in part(short)]
    print("\n".join(lines))
    progress("done")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--short", action="store_true", help="few repeats, small sizes: answers, no times")
    asked = parser.parse_args()
    sys.exit(run_command(lambda: main(asked.short)))
