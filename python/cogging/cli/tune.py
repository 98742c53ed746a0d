"""`cogging tune`: tune the gains of a controller for an uncertain machine.

Find the gains with the smallest rms error over machines drawn from the model's intervals, within limits on command,
chatter and robustness, and report what they cost. If it is interrupted, it writes the best gains so far, and the same
command continues from there.
"""

from __future__ import annotations

import argparse

from cogging.cli.answer import OUTPUT_GROUP, add_answer_options, json_file, print_result
from cogging.cli.next_command import after_many_runs
from cogging.cli.parser import add_threads, example_file
from cogging.files import errors_of
from cogging.outputs import check_outputs

EPILOG = example_file("TUNE.toml")

EXAMPLES = """\
cogging tune tune.toml --out tuned.toml
cogging tune tune.toml --figure tuned.png --json tuned.json"""


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options."""
    command.add_argument("tune", metavar="TUNE.toml", help="the tuning, as below")
    add_threads(command)
    group = command.add_argument_group(OUTPUT_GROUP)
    tuned = "the model with the tuned gains (default: tuned.toml)"
    group.add_argument("--out", default="tuned.toml", metavar="MODEL.toml", help=tuned)
    group.add_argument("--figure", metavar="OUT.png", help="plot the trade-off")
    add_answer_options(group, json="the tuning")


def run(arguments: argparse.Namespace) -> None:
    """Tune, write the model, say what was found."""
    from cogging.design.tuning import tune
    from cogging.simulation.parameter_sweep import files_of_job, read_job

    asked = read_job(arguments.tune, "tune")
    outputs = {"--out": arguments.out, "--json": json_file(arguments), "--figure": arguments.figure}
    check_outputs(outputs, files_of_job(asked, arguments.tune))
    options = {"out": arguments.out, "threads": arguments.threads, "progress": not arguments.quiet}
    with errors_of(arguments.tune):
        tuning = tune(**asked, **options)
    written = [arguments.out] if tuning.model is not None else []
    if arguments.figure:
        tuning.write_figure(arguments.figure)
        written.append(arguments.figure)
    text = tuning.text() if written or arguments.json else f"{tuning.text()}\nnothing written"
    following = after_many_runs(arguments.out if tuning.model is not None else asked["model"], asked["reference"])
    print_result(arguments, text, document=tuning.to_dict(), indent=2, written=written, next_command=following)
