"""`cogging reproduce`: the published experiments compared with the papers.

Run the experiments of a paper and print its tables beside the simulated ones, each number marked as calibrated or
predicted. Tables (PAPER.json) and figures (PNG) are written into a folder.
"""

from __future__ import annotations

import argparse
from typing import Any

from cogging.cli.answer import OUTPUT_GROUP, add_answer_options, json_file, print_part, print_result
from cogging.cli.next_command import command_line, init, option
from cogging.cli.parser import refuse_unknown
from cogging.outputs import check_folder, check_outputs
from cogging.papers.reproduction import PAPERS, compare, reproduce

EXAMPLES = """\
cogging reproduce lu2008
cogging reproduce malaize2009 xu2001 --out results
cogging reproduce xu2001 --all --out results
cogging reproduce --compare --out comparison"""


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options."""
    command.add_argument("papers", nargs="*", metavar="PAPER", help=f"{', '.join(PAPERS)}; all when none is named")
    command.add_argument("--compare", action="store_true", help="all papers' controllers on one axis")
    group = command.add_argument_group(OUTPUT_GROUP)
    group.add_argument("--all", action="store_true", help="also show tables that are in no paper")
    group.add_argument("--out", default="results", metavar="DIR", help="folder of the results (default: results)")
    add_answer_options(group, json="the tables, one object a paper,")


def run(arguments: argparse.Namespace) -> None:
    """Reproduce the papers, write tables and figures, print the tables."""
    for paper in arguments.papers:
        refuse_unknown("PAPER", paper, PAPERS)
    check_folder(arguments.out)
    names = [*(arguments.papers or (() if arguments.compare else PAPERS)), *(["comparison"] * arguments.compare)]
    check_outputs({"--json": json_file(arguments)}, [f"{arguments.out}/{name}.json" for name in names])
    documents: list[dict[str, Any]] = []
    for name in names:
        shown = not arguments.quiet
        result = compare(progress=shown) if name == "comparison" else reproduce(name, progress=shown)
        written = result.write(arguments.out)
        documents.append(result.to_dict())
        files = f"{written[0]} and {len(written) - 1} figures written"
        print_part(arguments, f"{result.paper}\n\n{result.text(arguments.all)}\n\n{files}\n")
    # After the papers the comparison, after that a model of the user's machine.
    comparison = command_line("reproduce", "--compare", option("--out", arguments.out))
    print_result(arguments, "", document=documents, next_command=init("LOG.csv") if arguments.compare else comparison)
