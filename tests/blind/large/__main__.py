"""Draw cases in the large, diagnose each, print: `python -m tests.blind.large --seed N --cases K [--only I ...]`."""

from __future__ import annotations

import argparse
import sys

from cogging_command import run_command

from .runner import answers
from .score import figures, line


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; exit status 0 whatever the answers."""
    parser = argparse.ArgumentParser(prog="python -m tests.blind.large", description=__doc__)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--cases", type=int, default=40)
    parser.add_argument("--only", type=int, nargs="+", help="these cases of the seed alone")
    parser.add_argument("--jobs", type=int, default=1, help="cases at a time")
    parser.add_argument("--limit", type=float, default=120.0, help="seconds a case; then it has no answer")
    options = parser.parse_args(arguments)
    indexes = options.only if options.only is not None else list(range(options.cases))
    found = []
    for answer in answers(options.seed, indexes, options.jobs, options.limit):
        found.append(answer)
        print(line(answer), flush=True)
    print(f"== in the large, seed {options.seed}, {len(found)} cases\n{figures(found)}")
    return 0


if __name__ == "__main__":
    sys.exit(run_command(main))
