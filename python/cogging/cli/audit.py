"""`cogging audit`: what a log is like, and whether a stated controller made it."""

from __future__ import annotations

import argparse

from cogging.cli.log_options import add_log_options, read_logs
from cogging.cli.parser import Commands
from cogging.cli.screen import say
from cogging.files import InputError
from cogging.outputs import check_outputs, to_json, with_sidecars, write_text
from cogging.shown import printable


def add_parser(commands: Commands) -> None:
    """Add the command and its arguments."""
    command = commands.add_parser("audit", help="what a log is like, and whether a stated controller made it")
    command.add_argument("logs", nargs="+", metavar="LOG")
    command.add_argument("--model", metavar="MODEL.toml", help="whose controller and travel are compared")
    command.add_argument("--json", metavar="OUT", help="where the figures are written, one object a log")
    add_log_options(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Audit each log, write and print what it is like."""
    from cogging.log_check.audit import audit
    from cogging.log_check.unit_check import check_against_model
    from cogging.model.model import Model

    inputs = [*with_sidecars(arguments.logs), *([arguments.model] if arguments.model else [])]
    check_outputs({"--json": arguments.json}, inputs)
    model = Model.read(arguments.model) if arguments.model else None
    told, texts = [], []
    for path, log in zip(arguments.logs, read_logs(arguments, arguments.logs), strict=True):
        if model is not None:
            check_against_model(log, model, path)
        try:
            found = audit(log, model)
        except ValueError as error:
            raise InputError(f"{path}: {error}") from None
        told.append({"log": path, **found.to_dict()})
        texts.append(f"{printable(path)}\n{found.text()}\n")
    if arguments.json:
        write_text(arguments.json, to_json(told))
    for text in texts:
        say(text)
