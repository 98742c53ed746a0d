"""`python -m tests.attack [NAME ...] [--cases N] [--seed S]`: runs attacks; status 1 where any found something."""

import argparse
import sys
import time

from tests.attack.logs import FORMATS
from tests.attack.watched import attack

#: Attacks by name: their module, its options, and how many cases the default run makes.
ATTACKS = {
    "bindings": ("tests.attack.bindings", {}, 20_000),
    **{kind: ("tests.attack.logs", {"kind": kind}, 5_000) for kind in FORMATS},
    "model": ("tests.attack.commands", {"kinds": ("model", "sidecar", "document")}, 1_000),
    "reference": ("tests.attack.commands", {"kinds": ("reference",)}, 1_000),
    "options": ("tests.attack.commands", {"kinds": ("option", "name", "signal")}, 1_000),
}


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.attack", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(ATTACKS)}; all when none is named")
    parser.add_argument("--cases", type=int, default=0, help="how many each; 0: its own number")
    parser.add_argument("--seed", type=int, default=0, help="of the first case")
    parser.add_argument("--processes", type=int, default=2)
    arguments = parser.parse_args()
    found = 0
    for name in arguments.names or ATTACKS:
        module, options, cases = ATTACKS[name]
        started = time.monotonic()
        seeds = range(arguments.seed, arguments.seed + (arguments.cases or cases))
        tally = attack(module, seeds, options, processes=arguments.processes)
        if name in FORMATS and name != "csv":  # what ends a reader is tried as a user meets it, in a process of its own
            ended = [*tally.crashes, *tally.hangs]
            again = attack(module, ended, options | {"whole": True}, processes=arguments.processes)
            tally.crashes, tally.hangs, tally.faults = again.crashes, again.hangs, tally.faults | again.faults
        print(f"{name}: {tally.text()} ({time.monotonic() - started:.0f} s)", flush=True)
        found += tally.found
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
