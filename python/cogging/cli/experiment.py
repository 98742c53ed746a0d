"""`cogging experiment`: make a motion that shows every effect within the machine's limits.

Make a motion within the machine's limits that shows every effect, and compute the detection limits or intervals that it
is expected to give. It writes the reference (for `simulate` and the machine), its samples (.csv) and the plan
(.plan.json) beside it.
"""

from __future__ import annotations

import argparse
import os

from cogging.cli.answer import OUTPUT_GROUP, add_answer_options, json_file, print_result
from cogging.cli.log_options import add_log_options, read_logs
from cogging.cli.next_command import again, command_line, files, log_options, option
from cogging.cli.parser import add_seed, example_file
from cogging.files import FieldError, InputError, errors_of, parse_toml, read_text
from cogging.model.model import Model
from cogging.outputs import check_outputs, with_sidecars
from cogging.progress import steps
from cogging.shown import printable

GOAL = """separate: detection limits and how the alternatives differ; detect: detection limits; fit: intervals \
(default: separate where the result has alternatives, else detect)"""
EPILOG = example_file("LIMITS.toml")

EXAMPLES = """\
cogging experiment --model model.toml --result result.json --limits limits.toml --out next.toml
cogging experiment --model model.toml --limits limits.toml --goal fit --out next.toml"""


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options."""
    command.add_argument("--model", required=True, metavar="MODEL.toml", help="model that the result is of")
    command.add_argument("--result", metavar="RESULT.json", help="what `diagnose --json` wrote")
    logs = "logs of the result: each changes the random moves"
    command.add_argument("--logs", nargs="+", default=[], metavar="LOG", help=logs)
    add_log_options(command)
    limits = "limits of the machine, as below; drafted if it is not there"
    command.add_argument("--limits", required=True, metavar="LIMITS.toml", help=limits)
    command.add_argument("--goal", choices=("separate", "detect", "fit"), help=GOAL)
    add_seed(command, of="the simulated noise and the random moves")
    group = command.add_argument_group(OUTPUT_GROUP)
    group.add_argument("--out", required=True, metavar="REF.toml", help="write the reference")
    add_answer_options(group, json="the plan")


def run(arguments: argparse.Namespace) -> None:
    """Make the motion, write its files, print what is to be expected."""
    from cogging.design.experiment_plan import NoMotion, beside, plan_experiment, read_result
    from cogging.design.motion_limits import MotionLimits, draft_limits
    from cogging.file_schema import LIMITS

    outputs = {"--out": arguments.out, "--json": json_file(arguments)}
    outputs |= {"its samples": beside(arguments.out, ".csv"), "its plan": beside(arguments.out, ".plan.json")}
    inputs = [arguments.model, arguments.limits, *([arguments.result] if arguments.result is not None else [])]
    inputs += with_sidecars(arguments.logs)
    check_outputs(outputs, inputs)
    model = Model.read(arguments.model)
    logs = read_logs(arguments, arguments.logs)
    if not os.path.lexists(arguments.limits):
        with errors_of(arguments.model):
            draft = draft_limits(model, logs)
        said = f"{printable(arguments.limits)} was not there: drafted. Check each line, then give the command again"
        document, content = MotionLimits.from_dict(parse_toml(draft)).to_dict(), {arguments.limits: [draft.encode()]}
        print_result(arguments, said, document=document, files=content, next_command=again(arguments))
        return
    limits = MotionLimits.read(arguments.limits)
    result = None if arguments.result is None else read_result(arguments.result)
    options = {"result": result, "logs": logs, "goal": arguments.goal, "seed": arguments.seed}
    with steps(not arguments.quiet, "experiment") as begin:
        try:
            plan = plan_experiment(model, limits, progress=begin, **options)
        except FieldError as error:  # of the limits beside the model, or of the result
            if error.key in LIMITS and not error.section:
                raise error.in_file(arguments.limits, read_text(arguments.limits)) from None
            raise InputError(f"{arguments.result}: {error}") from None
        except NoMotion as error:
            raise InputError(f"{arguments.limits} with {arguments.model}: {error}") from None
    content = {path: [text.encode()] for path, text in plan.files(arguments.out).items()}
    logs_then = [*files(arguments.logs), "NEW_LOG.csv"]
    following = command_line("diagnose", logs_then, option("--model", arguments.model), log_options(arguments))
    text = f"{plan.text()}\nrun this motion on the machine, and log it"
    print_result(arguments, text, document=plan.to_dict(), files=content, next_command=following)
