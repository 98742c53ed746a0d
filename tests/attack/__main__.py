"""`python -m tests.attack NAME [--cases N] [--seed S]`: an attack and what it found; exit status 1 where it found any."""

import argparse
import sys

from tests.attack.watched import attack

ATTACKS = {"bindings": ("tests.attack.bindings", 20_000)}


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.attack", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(ATTACKS)}; all when none is named")
    parser.add_argument("--cases", type=int, default=0, help="how many; 0: each attack's own number")
    parser.add_argument("--seed", type=int, default=0, help="of the first case")
    parser.add_argument("--processes", type=int, default=2)
    arguments = parser.parse_args()
    found = 0
    for name in arguments.names or ATTACKS:
        module, cases = ATTACKS[name]
        seeds = range(arguments.seed, arguments.seed + (arguments.cases or cases))
        tally = attack(module, seeds, processes=arguments.processes)
        print(tally.text(), flush=True)
        found += tally.found
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
