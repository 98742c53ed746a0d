"""`cogging init`: draft a commented model and reference from a log.

Find the columns, units, rate, resolution, travel and moves of a log, and write a model and a reference with comments on
the origin of each number and on what to fill in. Existing files are not replaced.
"""

from __future__ import annotations

import argparse
import shlex

from cogging.cli.answer import OUTPUT_GROUP, add_answer_options, json_file, print_result
from cogging.cli.log_options import add_log_options, options_of, require_known
from cogging.cli.next_command import command_line
from cogging.files import InputError
from cogging.outputs import check_outputs, with_sidecars
from cogging.progress import steps
from cogging.shown import printable

EXAMPLES = """\
cogging init log.csv --out first.toml --reference moves.toml
cogging init drive.csv --columns position=qm,command=vir --out drive.toml --reference drive_moves.toml"""


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options."""
    command.add_argument("log", metavar="LOG", help="with columns of any names and units")
    add_log_options(command)
    group = command.add_argument_group(OUTPUT_GROUP)
    model, motion = "write the model (default: model.toml)", "write its motion (default: reference.toml)"
    group.add_argument("--out", metavar="MODEL.toml", default="model.toml", help=model)
    group.add_argument("--reference", metavar="REF.toml", default="reference.toml", help=motion)
    add_answer_options(group, json="all findings")


def run(arguments: argparse.Namespace) -> None:
    """Draft model and reference, write and print what was found, and the next command."""
    from cogging.first_model.model_draft import draft_model, require_new

    outputs = {"--out": arguments.out, "--reference": arguments.reference, "--json": json_file(arguments)}
    check_outputs(outputs, with_sidecars([arguments.log]))
    require_new([arguments.out, arguments.reference])
    require_known(arguments, [arguments.log])
    how, zero = options_of(arguments, arguments.log)
    if zero:
        raise InputError("--zero: must not be given to init: a model's travel may begin anywhere")
    with steps(not arguments.quiet, "init"):
        draft = draft_model(arguments.log, **how)
    written = ", ".join(map(printable, draft.write(arguments.out, arguments.reference)))
    text = f"{draft.text()}\nwritten: {written}: read their comments, and fill in what you know better"
    following = command_line(shlex.split(draft.next_command(arguments.out))[1:])
    print_result(arguments, text, document=draft.to_dict(), next_command=following)
