"""`cogging identify`: the parameters of a model fitted to logs, with intervals."""

from __future__ import annotations

import argparse

from cogging.cli.log_options import add_log_options, read_logs
from cogging.cli.parser import Commands
from cogging.cli.screen import say
from cogging.outputs import check_outputs, to_json, to_toml, with_sidecars, write_files
from cogging.shown import printable


def add_parser(commands: Commands) -> None:
    """Add the command and its arguments."""
    command = commands.add_parser("identify", help="fit the parameters of a model to logs, with intervals")
    command.add_argument("logs", nargs="+", metavar="LOG")
    command.add_argument("--model", required=True, metavar="MODEL.toml", help="the prior; its controller is optional")
    command.add_argument("--out", metavar="MODEL.toml", help="where the fitted model is written, with [bounds]")
    command.add_argument("--json", metavar="OUT", help="where the fit is written")
    command.add_argument("--free", metavar="PATH,...", help="parameters to fit, as axis.mass (default: all)")
    command.add_argument("--cutoff", type=float, metavar="HZ", help="of the filter (default: found from the noise)")
    add_log_options(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Fit the model, write what was asked for, print the fit."""
    from cogging.identification.identify import identify
    from cogging.model.model import Model

    outputs = {"--json": arguments.json, "--out": arguments.out}
    check_outputs(outputs, [arguments.model, *with_sidecars(arguments.logs)])
    model = Model.read(arguments.model)
    free = None if arguments.free is None else [path.strip() for path in arguments.free.split(",")]
    names = [printable(path) for path in arguments.logs]
    logs = read_logs(arguments, arguments.logs)
    found = identify(logs, model, free=free, cutoff=arguments.cutoff, names=names, progress=True)
    content = {}
    if arguments.json:
        content[arguments.json] = to_json(found.to_dict())
    if arguments.out:
        content[arguments.out] = to_toml(found.model.to_dict())
    write_files({path: [text.encode()] for path, text in content.items()})
    say(found.text())
