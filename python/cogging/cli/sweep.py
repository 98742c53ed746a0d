"""`cogging sweep`: many runs of a model, each with other numbers."""

from __future__ import annotations

import argparse

from cogging.cli.parser import Commands, require_whole
from cogging.cli.screen import say
from cogging.files import InputError
from cogging.outputs import check_outputs
from cogging.shown import printable

THREADS_MAX = 1024


def add_parser(commands: Commands) -> None:
    """Add the command and its arguments."""
    command = commands.add_parser("sweep", help="many runs of a model, each with other numbers")
    command.add_argument("sweep", metavar="SWEEP.toml")
    command.add_argument("--out", default="runs.csv", metavar="RUNS.parquet", help="or .csv (default: runs.csv)")
    command.add_argument("--threads", type=int, default=0, metavar="N", help="default: all cores")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Run the sweep, write its table, say how its runs ended."""
    from cogging.simulation.frames import is_parquet
    from cogging.simulation.sweep_file import files_of_sweep, read_sweep, run_sweep
    from cogging.tables import library

    require_whole("--threads", arguments.threads, 0, THREADS_MAX)
    asked = read_sweep(arguments.sweep)
    check_outputs({"--out": arguments.out}, files_of_sweep(asked, arguments.sweep))
    try:
        if is_parquet(arguments.out):
            library("pyarrow")
    except ImportError as error:
        raise InputError(f"--out: {error}") from None
    options = {"out": arguments.out, "threads": arguments.threads, "progress": True}
    runs = run_sweep(arguments.sweep, asked, **options)
    say(f"{printable(arguments.out)}: {runs!r}")
