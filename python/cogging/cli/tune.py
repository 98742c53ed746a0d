"""`cogging tune`: the gains of a controller for an uncertain machine."""

from __future__ import annotations

import argparse

from cogging.cli.parser import Commands, require_whole
from cogging.cli.screen import say
from cogging.files import InputError
from cogging.outputs import check_outputs, to_json, write_text
from cogging.shown import printable

THREADS_MAX = 1024
EXAMPLE = """TUNE.toml:
  model = "gantry.toml"            # with [controller] and [bounds]
  reference = "move.toml"
  trials = 200
  [gains]                          # absent: the usual ones, a decade either side
  "controller.kp" = { from = 1e3, to = 5e4 }
  "controller.kd" = { from = 10, to = 200 }
  [limits]                         # on every machine
  command_max = 4.0                # V
  delay_margin = 1e-3              # s
  command_chatter = { present = 1.5 }
"""


def add_parser(commands: Commands) -> None:
    """Add the command and its arguments."""
    command = commands.add_parser(
        "tune",
        help="the gains of a controller for an uncertain machine",
        description="Find the gains with the smallest rms error over machines drawn from the model's intervals,\n"
        "within limits on command, chatter and robustness, and say what they cost. Ended before its time,\n"
        "it writes the best so far, and the same command goes on from there.",
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.add_argument("tune", metavar="TUNE.toml")
    command.add_argument(
        "--out", default="tuned.toml", metavar="MODEL.toml", help="the model with the tuned gains (default: tuned.toml)"
    )
    command.add_argument("--json", metavar="OUT", help="where the numbers are written")
    command.add_argument("--figure", metavar="OUT.png", help="where the trade-off is drawn")
    command.add_argument("--threads", type=int, default=0, metavar="N", help="default: all cores")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Tune, write the model, say what was found."""
    from cogging.design.tuning.trials import optuna
    from cogging.design.tuning.tune_file import files_of_tune, read_tune, run_tune

    require_whole("--threads", arguments.threads, 0, THREADS_MAX)
    asked = read_tune(arguments.tune)
    outputs = {"--out": arguments.out, "--json": arguments.json, "--figure": arguments.figure}
    check_outputs(outputs, files_of_tune(asked, arguments.tune))
    try:
        optuna()
    except ImportError as error:
        raise InputError(str(error)) from None
    tuning = run_tune(arguments.tune, asked, out=arguments.out, threads=arguments.threads, progress=True)
    if arguments.json:
        write_text(arguments.json, to_json(tuning.to_dict(), indent=2))
    if arguments.figure:
        tuning.write_figure(arguments.figure)
    say(tuning.text())
    written = [*([arguments.out] if tuning.model is not None else []), arguments.json, arguments.figure]
    say(f"{', '.join(printable(path) for path in written if path) or 'nothing'} written")
