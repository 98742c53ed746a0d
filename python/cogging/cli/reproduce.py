"""`cogging reproduce`: the published experiments beside the papers' numbers."""

from __future__ import annotations

import argparse

from cogging.cli.parser import Commands
from cogging.cli.screen import say
from cogging.files import InputError
from cogging.outputs import check_folder
from cogging.papers.reproduction import PAPERS, compare, reproduce
from cogging.papers.result import Reproduction
from cogging.shown import quoted


def add_parser(commands: Commands) -> None:
    """Add the command and its arguments."""
    command = commands.add_parser("reproduce", help="the published experiments beside the papers' numbers")
    command.add_argument("papers", nargs="*", metavar="PAPER", help=f"{', '.join(PAPERS)}; all when none is named")
    command.add_argument("--compare", action="store_true", help="all papers' controllers on one axis")
    command.add_argument("--out", default="results", metavar="DIR", help="folder of the results (default: results)")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Reproduce the papers, write tables and figures, print the tables."""
    for paper in arguments.papers:
        if paper not in PAPERS:
            raise InputError(f"PAPER: must be one of {', '.join(PAPERS)}, got {quoted(paper)}")
    check_folder(arguments.out)
    for paper in arguments.papers or (() if arguments.compare else PAPERS):
        _show(reproduce(paper, progress=True), arguments.out)
    if arguments.compare:
        _show(compare(progress=True), arguments.out)


def _show(result: Reproduction, folder: str) -> None:
    written = result.write(folder)
    say(f"{result.paper}\n\n{result.text()}\n\n{written[0]} and {len(written) - 1} figures written\n")
