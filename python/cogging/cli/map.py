"""`cogging map`: the cogging model of a force-against-position scan."""

from __future__ import annotations

import argparse
from pathlib import Path

from cogging.cli.log_options import add_log_options, options_of, require_known, without_zero
from cogging.cli.parser import Commands
from cogging.cli.screen import say
from cogging.files import FieldError, InputError
from cogging.logs.columns import read_columns
from cogging.model.units import Units
from cogging.outputs import check_outputs
from cogging.shown import printable


def add_parser(commands: Commands) -> None:
    """Add the command and its arguments."""
    command = commands.add_parser("map", help="fit the cogging model to a force-against-position scan")
    command.add_argument("scan", metavar="SCAN")
    command.add_argument("--pitch", type=float, required=True, metavar="P", help="magnet pitch, m")
    command.add_argument(
        "--force-sign", type=int, default=1, metavar="S", help="-1: the sensor reads the motor's push (default: 1)"
    )
    command.add_argument("--out", metavar="MODEL.toml", help="where the [cogging] part is written; figure beside it")
    command.add_argument(
        "--units",
        type=_units,
        metavar="command=N,...",
        help="labels of the units of force and position",
    )
    add_log_options(command)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Fit the map, write it with its figure, print what it explains."""
    from cogging.mapping.fit import fit_map

    figure = Path(arguments.out).with_suffix(".png") if Path(arguments.out or "").name else None
    check_outputs({"--out": arguments.out, "its figure": figure}, [arguments.scan])
    require_known(arguments, [arguments.scan])
    how, zero = options_of(arguments, arguments.scan)
    table = without_zero(read_columns(arguments.scan, ("position", "force"), **how), zero, arguments.scan)
    told = {"units": arguments.units}
    try:
        fit = fit_map(table["position"], table["force"], pitch=arguments.pitch, force_sign=arguments.force_sign, **told)
    except ValueError as error:
        raise InputError(f"{arguments.scan}: {error}") from None
    if arguments.out:
        fit.write(arguments.out)
    say(fit.text())
    if arguments.out:
        say(f"{printable(arguments.out)} and {printable(str(Path(arguments.out).with_suffix('.png')))} written")


def _units(text: str) -> Units:
    """Labels as `command=N,position=rad`."""
    pairs = dict(entry.partition("=")[::2] for entry in text.split(","))
    try:
        return Units.from_dict(pairs)
    except FieldError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
