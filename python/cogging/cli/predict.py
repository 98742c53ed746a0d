"""`cogging predict`: the tracking error of each controller, before the machine moves."""

from __future__ import annotations

import argparse

from cogging.cli.parser import Commands, require_whole
from cogging.cli.run_options import add_files, add_seed, naming_files, require_seed
from cogging.cli.screen import say
from cogging.outputs import check_outputs, to_json, write_text
from cogging.shown import printable
from cogging.simulation.reference import files_of_reference

MOST_SAMPLES = 1_000_000  # machines that a prediction draws


def add_parser(commands: Commands) -> None:
    """Add the command and its arguments."""
    command = commands.add_parser("predict", help="the tracking error of each controller, before the machine moves")
    add_files(command)
    command.add_argument("--samples", type=int, default=40, metavar="N", help="machines to draw (default: 40)")
    add_seed(command, of="machines and noise")
    command.add_argument("--json", metavar="OUT", help="where the numbers are written")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Predict the errors, write and print them."""
    from cogging.design.error_prediction import predict_error

    require_whole("--samples", arguments.samples, 2, MOST_SAMPLES)
    require_seed(arguments)
    check_outputs({"--json": arguments.json}, [arguments.model, *files_of_reference(arguments.reference)])
    with naming_files(arguments):
        prediction = predict_error(arguments.model, arguments.reference, samples=arguments.samples, seed=arguments.seed)
    if arguments.json:
        write_text(arguments.json, to_json(prediction.to_dict(), indent=2))
    say(prediction.text())
    if arguments.json:
        say(f"{printable(arguments.json)} written")
