"""`cogging audit`: check a log, and whether the stated controller produced it.

Report of each log the rows and their time steps, missing rows, the resolution of the encoder, travel, speed and
command, and outliers. With a model, also whether its controller produced the log.
"""

from __future__ import annotations

import argparse

from cogging.cli.answer import OUTPUT_GROUP, add_answer_options, json_file, print_result
from cogging.cli.log_options import add_log_options, read_logs
from cogging.cli.next_command import after_audit
from cogging.files import errors_of
from cogging.model.model import Model
from cogging.outputs import check_outputs, with_sidecars
from cogging.progress import steps
from cogging.shown import printable

EXAMPLES = """\
cogging audit log.csv
cogging audit log.csv --model model.toml --json audit.json
cogging audit drive.csv --columns position=qm,command=vir --scale command=2"""


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options."""
    command.add_argument("logs", nargs="+", metavar="LOG", help="CSV, .mat, .mf4 or .parquet")
    command.add_argument("--model", metavar="MODEL.toml", help="model with the controller and travel to compare")
    add_log_options(command)
    add_answer_options(command.add_argument_group(OUTPUT_GROUP), json="the findings, one object for each log,")


def run(arguments: argparse.Namespace) -> None:
    """Audit each log, write and print what it is like."""
    from cogging.log_check.log_audit import audit, check_against_model

    inputs = [*with_sidecars(arguments.logs), *([arguments.model] if arguments.model else [])]
    check_outputs({"--json": json_file(arguments)}, inputs)
    model = Model.read(arguments.model) if arguments.model else None
    documents, texts = [], []
    with steps(not arguments.quiet, "audit") as begin:
        for path, log in zip(arguments.logs, read_logs(arguments, arguments.logs), strict=True):
            begin(printable(path))
            if model is not None:
                check_against_model(log, model, path)
            with errors_of(path):
                found = audit(log, model)
            documents.append({"log": path, **found.to_dict()})
            texts.append(f"{printable(path)}\n{found.text()}\n")
    print_result(arguments, "\n".join(texts), document=documents, next_command=after_audit(arguments))
