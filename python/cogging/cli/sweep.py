"""`cogging sweep`: simulate a model many times with other numbers.

Simulate the model along the reference for each set of numbers, and write a table: one row a run, with its numbers,
errors and command. If it is interrupted, finished runs are kept, and the same command continues from there.
"""

from __future__ import annotations

import argparse

import numpy as np

from cogging.cli.answer import OUTPUT_GROUP, add_answer_options, json_file, print_result
from cogging.cli.next_command import after_many_runs
from cogging.cli.parser import add_threads, example_file
from cogging.files import errors_of
from cogging.outputs import check_outputs
from cogging.shown import printable
from cogging.simulation.reductions import INDEXES

EPILOG = example_file("SWEEP.toml")

EXAMPLES = """\
cogging sweep sweep.toml --out runs.csv
cogging sweep sweep.toml --out runs.parquet --threads 2 --figure runs.png"""


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options."""
    command.add_argument("sweep", metavar="SWEEP.toml", help="the runs, as below")
    add_threads(command)
    group = command.add_argument_group(OUTPUT_GROUP)
    group.add_argument("--out", default="runs.csv", metavar="RUNS.parquet", help="or .csv (default: runs.csv)")
    group.add_argument("--figure", metavar="OUT.png", help="plot the rms error over the most influential input")
    add_answer_options(group, json="a summary of the runs")


def run(arguments: argparse.Namespace) -> None:
    """Run the sweep, write its table, say how its runs ended."""
    from cogging.plot.shown_figure import picture
    from cogging.simulation.parameter_sweep import files_of_job, read_sweep, sweep

    asked = read_sweep(arguments.sweep)
    outputs = {"--out": arguments.out, "--json": json_file(arguments), "--figure": arguments.figure}
    check_outputs(outputs, files_of_job(asked, arguments.sweep))
    options = {"out": arguments.out, "threads": arguments.threads, "progress": not arguments.quiet}
    with errors_of(arguments.sweep):
        runs = sweep(**asked, **options)
    indexes = {}
    for name in INDEXES:
        values = runs.table[name][np.isfinite(runs.table[name])]
        ends = np.quantile(values, (0.0, 0.5, 1.0)) if values.size else (np.nan,) * 3
        indexes[name] = dict(zip(("smallest", "median", "largest"), ends, strict=True))
    document = {"out": arguments.out, "runs": len(runs), "failed": runs.failed, "varied": dict(runs.units)}
    document |= {"indexes": indexes, "influence": runs.influence()}
    following = after_many_runs(asked["model"], asked["reference"])
    files = {arguments.figure: [picture(runs.plot())]} if arguments.figure else {}
    text = f"{printable(arguments.out)}: {runs.text()}"
    print_result(arguments, text, document=document, indent=2, files=files, next_command=following)
