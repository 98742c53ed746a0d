"""`cogging diagnose`: find, name and add the effect that a model lacks.

Re-tune the model to the logs, measure the gap that remains between model and logs, locate it, and name the effect that
explains it, with its parameters, the confidence and the alternatives. The first line is the verdict: no_gap, named,
ambiguous, unlisted, data_mismatch, controller_mismatch or insufficient_excitation; the exit status is 0 whichever it
is.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from cogging.cli.answer import OUTPUT_GROUP, add_answer_options, json_file, print_result
from cogging.cli.log_options import add_log_options, read_logs
from cogging.cli.next_command import after_diagnose
from cogging.files import read_text
from cogging.model.model import Model
from cogging.outputs import check_outputs, with_sidecars
from cogging.progress import steps
from cogging.shown import printable

EXAMPLES = """\
cogging diagnose log.csv --model model.toml
cogging diagnose log.csv --model model.toml --confirm other.csv --out patched.toml --report report.html
cogging diagnose log.csv --model model.toml --rows 0:3000 --json -"""


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options."""
    command.add_argument("logs", nargs="+", metavar="LOG", help="CSV, .mat, .mf4 or .parquet")
    command.add_argument("--model", required=True, metavar="MODEL.toml", help="model of the machine")
    others = "logs of other motion, to check the result"
    command.add_argument("--confirm", nargs="+", default=[], metavar="LOG", help=others)
    add_log_options(command)
    group = command.add_argument_group(OUTPUT_GROUP)
    group.add_argument("--report", metavar="OUT.html", help="write the report: one page with figures")
    group.add_argument("--out", metavar="MODEL.toml", help="write the model with the missing effect")
    unexplained = "add the unexplained force to that model, with any shape"
    group.add_argument("--empirical", action="store_true", help=unexplained)
    group.add_argument("--verbose", action="store_true", help="print the whole result, not only its conclusions")
    add_answer_options(group)


def run(arguments: argparse.Namespace) -> None:
    """Diagnose the logs, write what was asked for, print the verdict."""
    from cogging.diagnosis.diagnosis import diagnose

    outputs = {"--json": json_file(arguments), "--report": arguments.report, "--out": arguments.out}
    check_outputs(outputs, [arguments.model, *with_sidecars([*arguments.logs, *arguments.confirm])])
    model = Model.read(arguments.model)
    given, others = read_logs(arguments, arguments.logs), read_logs(arguments, arguments.confirm)
    names, confirm_names = ([printable(path) for path in logs] for logs in (arguments.logs, arguments.confirm))
    options = {"names": names, "confirm_names": confirm_names, "empirical": arguments.empirical}
    with steps(not arguments.quiet, "diagnose") as begin:
        result = diagnose(given, model, confirm=others, progress=begin, **options)
        files = {}
        following = after_diagnose(arguments, result)
        if arguments.report:
            begin("writing the report")
            title = ", ".join(printable(Path(path).name) for path in arguments.logs)
            files[arguments.report] = [result.html(title=title, step=following).encode()]
        if arguments.out:
            files[arguments.out] = [result.model.to_toml(read_text(arguments.model)).encode()]
    text, document = result.text(verbose=arguments.verbose), result.to_dict()
    print_result(arguments, text, document=document, files=files, next_command=following.line)
