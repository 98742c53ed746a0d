"""`cogging simulate`: one closed-loop run."""

from __future__ import annotations

import argparse

from cogging.cli.parser import Commands, require_whole
from cogging.cli.run_options import add_files, add_seed, naming_files, require_seed
from cogging.cli.screen import say
from cogging.model.model import STEPS_MAX
from cogging.outputs import check_outputs, sidecar
from cogging.shown import printable
from cogging.simulation.reference import files_of_reference
from cogging.simulation.run import simulate


def add_parser(commands: Commands) -> None:
    """Add the command and its arguments."""
    command = commands.add_parser("simulate", help="one closed-loop run")
    add_files(command)
    command.add_argument("--out", required=True, metavar="LOG.csv")
    add_seed(command, of="the noise")
    command.add_argument(
        "--steps-per-sample", type=int, metavar="N", help="fewest integration steps a sample (default: the model's)"
    )
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Simulate the run, write its log, print its error."""
    require_seed(arguments)
    steps = arguments.steps_per_sample
    if steps is not None:
        require_whole("--steps-per-sample", steps, 1, STEPS_MAX)
    outputs = {"--out": arguments.out, "its sidecar": sidecar(arguments.out)}
    check_outputs(outputs, [arguments.model, *files_of_reference(arguments.reference)])
    with naming_files(arguments):
        log = simulate(arguments.model, arguments.reference, seed=arguments.seed, steps_per_sample=steps)
    log.write(arguments.out)
    worst = f"{abs(log.error).max():.3g} {log.units.position}"
    say(f"{printable(arguments.out)}: {len(log)} rows, {log.time[-1]:g} s, max |error| {worst}")
