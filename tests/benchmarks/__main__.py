"""Every ratio as one table: one run and packs of runs beside hand-written code, many runs beside other libraries.

    python -m tests.benchmarks [PART ...] [--short]

Each part first compares the answers of what it times, and ends the command where they differ. `--short` makes few
repeats and small sizes: it shows that the parts run and agree; its times mean little. Progress goes to standard error.
"""

import argparse
import os
import sys
import time

from cogging import _core
from cogging_command import run_command
from tests.benchmarks import child, growth, lu2008_loop, own_controllers, peers, real_time

ROWS_OF_X = 192_001


def one_run(options):
    motion = lu2008_loop.MOTION.replace(repeats=1 if options.short else 20)
    rows, seconds = lu2008_loop.time_one_run(3 if options.short else 15, motion)
    yield "one run, C3 on X", f"{1e9 * seconds['core'] / rows:.0f} ns a step", ""
    for name in ("hand-written", "hand-written, libm"):
        yield "", f"{seconds['core'] / seconds[name]:.2f}", f"of {name}"


def packs(options):
    """Ratios of packs of runs to packs by hand, and of two threads."""
    runs = 16 if options.short else 64
    rows, seconds = lu2008_loop.time_packs(3 if options.short else 15, runs)
    yield f"{runs} runs in packs, C3 on X", "", ""
    for name, value in seconds.items():
        kind, instructions, *rest = name.split(", ")
        if "2 threads" in rest:
            yield "  two threads", f"{seconds[f'core, {instructions}'] / value:.2f}", "times as fast as one"
        elif kind == "core":
            hand = seconds.get(f"by hand, {instructions}")
            ratio = f"{value / hand:.2f} of by hand" if hand else "no pack"
            yield f"  {name[6:]}", f"{1e9 * value / rows / runs:.0f} ns a step", ratio


def libraries(options):
    counts, rows, rounds = ([1, 20], 201, 1) if options.short else ([1, 100, 2000], 2001, 2)
    for runs, name, ratio, seconds, megabytes in peers.figures(counts, rows, rounds, repeats=2 if options.short else 3):
        beside = f"compiles {seconds:.1f} s, {megabytes:.0f} MB"
        yield f"{runs} runs of a PID, {name}", f"{ratio:.2f} of cogging", beside


def many(options):
    """Time and memory of many runs of the X axis, and the calculated cost of a million."""
    runs, rows = (10, 9601) if options.short else (options.runs, ROWS_OF_X)
    for kind in ("batch", "sweep"):
        found = child.call(growth.many, kind, runs, rows)
        each = found["seconds"] / runs * ROWS_OF_X / rows
        beside = f"peak {found['peak']:.0f} MB; a million {1e6 * each / 3600:.1f} core hours"
        yield f"{kind} of {runs} runs, C3 on X", f"{1e3 * each:.1f} ms a run", beside


def own(options):
    """What a controller of one's own costs."""
    found = own_controllers.measure(3 if options.short else 9)
    for name in ("compiled", "Python"):
        if name in found:
            yield f"own controller, {name}", f"{found[name] / found['core']:.2f}", "of the core's"
    calls = found["own calls"] - found["their loop"]
    above = found["Python"] - found["core"] - calls
    yield "  above its own two calls", f"{above:.0f} ns a row", f"{above / calls:.2f} of them"


def steps(options):
    """Each controller's step alone."""
    for name, row in real_time.rows(100_000 if options.short else 2_000_000).items():
        figures = f"{row['median']:.0f} ns median, {row['99.99 %']:.0f} ns 99.99 %"
        yield f"step of {name}", figures, f"{row['allocations']:.0f} allocations, own worst {row['own worst']:.0f} ns"


def grown(options):
    """What the largest of each kind takes against the smallest; with --figure, each size, memory and the figure."""
    found = growth.grown(1 if options.short else 5, with_memory=bool(options.figure))
    for what, one in found.items():
        ratio = one["seconds"][-1] / one["seconds"][0]
        yield f"{what}: {one['sizes'][0]} to {one['sizes'][-1]}", f"{ratio:.2f}", "times the time"
    if options.figure:
        for what, one in found.items():
            for size, seconds, indexes, logs in zip(*one.values(), strict=True):
                memory = f"{indexes:.1f} MB with indexes, {logs:.1f} with logs"
                yield f"  {what} {size}", f"{1e3 * seconds:.2f} ms", memory
        growth.draw(found, options.figure)


PARTS = {part.__name__: part for part in (one_run, packs, libraries, many, own, steps, grown)}


def main(options):
    sets = ", ".join(_core.instruction_sets()) or "none"
    print(f"{real_time.processor()}: instruction sets {sets}; {os.cpu_count()} cores", flush=True)
    begin, lines, parts = time.monotonic(), [], options.parts or list(PARTS)

    def progress(what):
        print(f"{time.monotonic() - begin:4.0f} s: {what}", file=sys.stderr, flush=True)

    for number, name in enumerate(parts, 1):
        progress(f"{number} of {len(parts)}, {name}")
        lines += [f"{what:40}{figure:>34}  {beside}".rstrip() for what, figure, beside in PARTS[name](options)]
    print("\n".join(lines))
    progress("done")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"{', '.join(PARTS)}; all when none is named")
    parser.add_argument("--short", action="store_true", help="few repeats, small sizes: answers, no times")
    parser.add_argument("--runs", type=int, default=200, help="of `many`")
    parser.add_argument("--figure", help="of `grown`: file for it; measures memory as well")
    options = parser.parse_args()
    if unknown := set(options.parts) - set(PARTS):
        parser.error(f"PART: must be one of {', '.join(PARTS)}, got {', '.join(sorted(unknown))}")
    sys.exit(run_command(lambda: main(options)))
