"""`cogging identify`: fit the parameters of a model to logs, with intervals.

Fit mass, friction and the other parameters of a model to logs, by two methods that check each other. The command prints
a check of each log, what the logs can determine, each parameter with its 95 % interval, and what the fitted model
leaves unexplained.
"""

from __future__ import annotations

import argparse

from cogging.cli.answer import OUTPUT_GROUP, add_answer_options, json_file, print_result
from cogging.cli.log_options import add_log_options, read_logs
from cogging.cli.next_command import after_identify
from cogging.files import read_text
from cogging.model.model import Model
from cogging.outputs import check_outputs, with_sidecars
from cogging.shown import printable

EXAMPLES = """\
cogging identify log.csv --model model.toml --out fitted.toml
cogging identify log.csv other.csv --model model.toml --free axis.mass,axis.viscous --json fit.json
cogging identify drive.csv --columns position=qm,command=vir --scale command=2 --model model.toml"""


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options."""
    command.add_argument("logs", nargs="+", metavar="LOG", help="CSV, .mat, .mf4 or .parquet")
    command.add_argument("--model", required=True, metavar="MODEL.toml", help="the prior; its controller is optional")
    command.add_argument("--free", metavar="PATH,...", help="parameters to fit, as axis.mass (default: all)")
    command.add_argument("--cutoff", type=float, metavar="HZ", help="of the filter (default: found from the noise)")
    add_log_options(command)
    group = command.add_argument_group(OUTPUT_GROUP)
    group.add_argument("--out", metavar="MODEL.toml", help="write the fitted model with [bounds]")
    add_answer_options(group, json="the fit")


def run(arguments: argparse.Namespace) -> None:
    """Fit the model, write what was asked for, print the fit."""
    from cogging.identification.identification import identify

    outputs = {"--json": json_file(arguments), "--out": arguments.out}
    check_outputs(outputs, [arguments.model, *with_sidecars(arguments.logs)])
    model = Model.read(arguments.model)
    free = None if arguments.free is None else [path.strip() for path in arguments.free.split(",")]
    names = [printable(path) for path in arguments.logs]
    logs = read_logs(arguments, arguments.logs)
    found = identify(logs, model, free=free, cutoff=arguments.cutoff, names=names, progress=not arguments.quiet)
    files = {arguments.out: [found.model.to_toml(read_text(arguments.model)).encode()]} if arguments.out else {}
    following = after_identify(arguments, found)
    print_result(arguments, found.text(), document=found.to_dict(), files=files, next_command=following)
