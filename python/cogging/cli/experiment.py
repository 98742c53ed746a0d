"""`cogging experiment`: the motion that would tell most, computed."""

from __future__ import annotations

import argparse

from cogging.cli.parser import Commands
from cogging.cli.run_options import add_seed, require_seed
from cogging.cli.screen import say
from cogging.files import FieldError, InputError, read_text
from cogging.outputs import check_outputs, write_files
from cogging.shown import printable

PURPOSES = "separate: alternatives of the result stand apart; detect: small effects are seen; fit: intervals narrow"


def add_parser(commands: Commands) -> None:
    """Add the command and its arguments."""
    command = commands.add_parser(
        "experiment",
        help="compute the motion that would tell alternatives apart",
        description="Compute a motion within the machine's limits that best tells apart the alternatives of a result, "
        "shows small effects, or narrows the intervals of a fit, and say what is to be expected of it. It writes the "
        "reference (for `simulate` and the machine), its samples (.csv) and the plan (.plan.json) beside it; "
        "`diagnose --planned` says whether it came true.",
    )
    command.add_argument("--model", required=True, metavar="MODEL.toml", help="model that the result is of")
    command.add_argument("--result", metavar="RESULT.json", help="what `diagnose --json` wrote")
    command.add_argument(
        "--limits",
        required=True,
        metavar="LIMITS.toml",
        help="what the machine may do: velocity (m/s), acceleration (m/s^2), duration (s), and where the model does "
        "not say so travel (m, two numbers), jerk (m/s^3), command (its unit)",
    )
    command.add_argument("--out", required=True, metavar="REF.toml", help="where the reference is written")
    command.add_argument(
        "--goal",
        choices=("separate", "detect", "fit"),
        help=f"{PURPOSES} (default: separate where the result has alternatives, else detect)",
    )
    add_seed(command, of="the simulated noise")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Compute the motion, write its files, print what is to be expected."""
    from tqdm import tqdm

    from cogging.diagnosis.experiment.experiment_plan import plan_path, samples_path
    from cogging.diagnosis.experiment.limits import MotionLimits
    from cogging.diagnosis.experiment.plan import NoMotion, plan_experiment
    from cogging.diagnosis.experiment.result_file import read_result
    from cogging.file_schema import LIMITS
    from cogging.model.model import Model

    require_seed(arguments)
    outputs = {"--out": arguments.out}
    outputs |= {"its samples": samples_path(arguments.out), "its plan": plan_path(arguments.out)}
    inputs = [arguments.model, arguments.limits, *([arguments.result] if arguments.result is not None else [])]
    check_outputs(outputs, inputs)
    model = Model.read(arguments.model)
    limits = MotionLimits.read(arguments.limits)
    result = None if arguments.result is None else read_result(arguments.result)
    with tqdm(desc="experiment", bar_format="{desc} [{elapsed}]", leave=False, disable=None) as bar:
        try:
            plan = plan_experiment(
                model,
                limits,
                result=result,
                goal=arguments.goal,
                seed=arguments.seed,
                progress=bar.set_description_str,
            )
        except FieldError as error:  # of the limits beside the model, or of the result
            if error.key in LIMITS and not error.section:
                raise error.in_file(arguments.limits, read_text(arguments.limits)) from None
            raise InputError(f"{arguments.result}: {error}") from None
        except NoMotion as error:
            raise InputError(f"{arguments.limits} with {arguments.model}: {error.why}") from None
    files = plan.files(arguments.out)
    write_files({path: [text.encode()] for path, text in files.items()})
    say(plan.text())
    say(f"{', '.join(map(printable, files))} written")
