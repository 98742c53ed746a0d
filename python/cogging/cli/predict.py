"""`cogging predict`: predict the tracking error of each controller.

Draw machines from the intervals of the model, simulate its controller and those that can be designed for it along the
reference, and print rms and largest error of each with its 95 % interval.
"""

from __future__ import annotations

import argparse

from cogging.cli.answer import OUTPUT_GROUP, add_answer_options, json_file, print_result
from cogging.cli.next_command import can_predict, command_line, experiment, free_name, option
from cogging.cli.parser import add_run_files, add_seed, run_model, whole
from cogging.outputs import check_outputs
from cogging.progress import steps
from cogging.simulation.reference import files_of_reference

MOST_SAMPLES = 1_000_000  # machines that a prediction draws

EXAMPLES = """\
cogging predict model.toml --reference ref.toml
cogging predict model.toml --reference ref.toml --samples 200 --json errors.json"""


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_run_files(command)
    drawn = "machines to draw (default: 40)"
    command.add_argument("--samples", type=whole(2, MOST_SAMPLES), default=40, metavar="N", help=drawn)
    add_seed(command, of="machines and noise")
    add_answer_options(command.add_argument_group(OUTPUT_GROUP), json="the errors")


def run(arguments: argparse.Namespace) -> None:
    """Predict the errors, write and print them."""
    from cogging.design.error_prediction import predict_error

    check_outputs({"--json": json_file(arguments)}, [arguments.model, *files_of_reference(arguments.reference)])
    with steps(not arguments.quiet, "predict"), run_model(arguments) as (model, controller):
        prediction = predict_error(model, arguments.reference, samples=arguments.samples, seed=arguments.seed)
    if can_predict(model):
        following = command_line("tune", "TUNE.toml", option("--out", free_name("tuned.toml")))
    else:  # a motion that determines what is not known
        following = experiment(arguments.model, "--goal", "fit")
    text, document = f"{controller}{prediction.text()}", prediction.to_dict()
    print_result(arguments, text, document=document, indent=2, next_command=following)
