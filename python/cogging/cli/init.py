"""`cogging init`: a commented model and reference from what a log shows."""

from __future__ import annotations

import argparse

from cogging.cli.log_options import add_log_options, options_of, require_known
from cogging.cli.parser import Commands
from cogging.cli.screen import say
from cogging.files import InputError
from cogging.outputs import check_outputs, to_json, with_sidecars, write_text
from cogging.shown import printable


def add_parser(commands: Commands) -> None:
    """Add the command and its arguments."""
    command = commands.add_parser("init", help="a commented model and reference from what a log shows")
    command.add_argument("log", metavar="LOG", help="as you have it: columns of any names and units")
    command.add_argument(
        "--out", metavar="MODEL.toml", default="model.toml", help="where the model is written (default: model.toml)"
    )
    command.add_argument(
        "--reference",
        metavar="REF.toml",
        default="reference.toml",
        help="where its motion is written (default: reference.toml)",
    )
    command.add_argument("--json", metavar="OUT", help="where all that was found is written")
    add_log_options(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Draft model and reference, write and print what was found, and the command to give next."""
    from cogging.first_model.draft import draft_model
    from cogging.first_model.model_draft import require_new

    outputs = {"--out": arguments.out, "--reference": arguments.reference, "--json": arguments.json}
    check_outputs(outputs, with_sidecars([arguments.log]))
    require_new([arguments.out, arguments.reference])
    require_known(arguments, [arguments.log])
    how, zero = options_of(arguments, arguments.log)
    if zero:
        raise InputError("--zero: must not be given to init: a model's travel may begin anywhere")
    draft = draft_model(arguments.log, **how)
    written = draft.write(arguments.out, arguments.reference)
    if arguments.json:
        write_text(arguments.json, to_json(draft.to_dict()))
    say(draft.text())
    say(f"written: {', '.join(map(printable, written))}: read their comments, and fill in what you know better")
    say(f"next: {draft.next_command(arguments.out)}")
