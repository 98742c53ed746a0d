"""`cogging simulate`: simulate one closed-loop run.

Simulate the model with its controller along the reference and write the log: time, reading, command, reference and the
true motion, with the model and the seed in LOG.csv.toml. The command prints rows, duration and the largest error.
"""

from __future__ import annotations

import argparse

from cogging.cli.answer import OUTPUT_GROUP, add_answer_options, json_file, print_result
from cogging.cli.next_command import command_line, files, option
from cogging.cli.parser import add_run_files, add_seed, run_model, whole
from cogging.logs.log import performance
from cogging.model.model import STEPS_MAX
from cogging.outputs import check_outputs, sidecar
from cogging.progress import steps
from cogging.shown import printable
from cogging.simulation.reductions import INDEXES
from cogging.simulation.reference import files_of_reference
from cogging.simulation.run import simulate

EXAMPLES = """\
cogging simulate model.toml --reference ref.toml --out run.csv
cogging simulate model.toml --reference ref.toml --seed 7 --out run.parquet --json run.json"""


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_run_files(command)
    add_seed(command, of="the noise")
    least = "least number of integration steps per sample (default: the model's)"
    command.add_argument("--steps-per-sample", type=whole(1, STEPS_MAX), metavar="N", help=least)
    group = command.add_argument_group(OUTPUT_GROUP)
    group.add_argument("--out", required=True, metavar="LOG.csv", help="also .mat and .parquet")
    add_answer_options(group, json="rows, seconds and the indexes of the error")


def run(arguments: argparse.Namespace) -> None:
    """Simulate the run, write its log, print its error."""
    outputs = {"--out": arguments.out, "its sidecar": sidecar(arguments.out), "--json": json_file(arguments)}
    check_outputs(outputs, [arguments.model, *files_of_reference(arguments.reference)])
    with steps(not arguments.quiet, "simulate") as begin:
        with run_model(arguments) as (model, controller):
            log = simulate(model, arguments.reference, seed=arguments.seed, steps_per_sample=arguments.steps_per_sample)
        begin("writing the log")
        log.write(arguments.out)
    document = {"log": arguments.out, "rows": len(log), "duration": log.time[-1], "seed": arguments.seed}
    indexes = performance(log)
    worst = f"{abs(log.error).max():.3g} {log.units.position}"
    text = f"{printable(arguments.out)}: {len(log)} rows, {log.time[-1]:g} s, max |error| {worst}"
    following = command_line("audit", files([arguments.out]), option("--model", arguments.model))
    document |= {name: getattr(indexes, name) for name in INDEXES}
    print_result(arguments, controller + text, document=document, next_command=following)
