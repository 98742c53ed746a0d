"""`cogging map`: fit the cogging model to a force-against-position scan.

Find the harmonics of the magnet pitch in a scan of the force that holds the axis at each position, fit their
amplitudes, constant or varying along the travel, and report what the map explains. The scan has the columns position (m
or rad) and force (the command's unit).
"""

from __future__ import annotations

import argparse
from pathlib import Path

from cogging.cli.answer import OUTPUT_GROUP, add_answer_options, json_file, print_result
from cogging.cli.log_options import add_log_options, options_of, require_known, without_zero
from cogging.cli.next_command import again, command_line, free_name, option
from cogging.files import FieldError, errors_of
from cogging.logs.columns import read_columns
from cogging.model.units import Units
from cogging.outputs import check_outputs
from cogging.progress import steps
from cogging.shown import printable

EXAMPLES = """\
cogging map scan.csv --pitch 0.05 --out map.toml
cogging map sensor.csv --pitch 0.05 --columns position=mm --scale position=0.001 --force-sign -1"""


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options."""
    command.add_argument("scan", metavar="SCAN", help="CSV, .mat, .mf4 or .parquet")
    command.add_argument("--pitch", type=float, required=True, metavar="P", help="magnet pitch, m or rad")
    sign = "-1: the sensor reads the force of the motor (default: 1)"
    command.add_argument("--force-sign", type=int, default=1, metavar="S", help=sign)
    units = "labels of the units of force and position"
    command.add_argument("--units", type=_units, metavar="command=N,...", help=units)
    add_log_options(command)
    group = command.add_argument_group(OUTPUT_GROUP)
    group.add_argument("--out", metavar="MODEL.toml", help="write the [cogging] section, and a figure beside it")
    add_answer_options(group, json="the fit")


def run(arguments: argparse.Namespace) -> None:
    """Fit the map, write it with its figure, print what it explains."""
    from cogging.mapping.fit_map import fit_map

    figure = Path(arguments.out).with_suffix(".png") if Path(arguments.out or "").name else None
    outputs = {"--out": arguments.out, "its figure": figure, "--json": json_file(arguments)}
    check_outputs(outputs, [arguments.scan])
    require_known(arguments, [arguments.scan])
    how, zero = options_of(arguments, arguments.scan)
    table = without_zero(read_columns(arguments.scan, ("position", "force"), **how), zero, arguments.scan)
    with steps(not arguments.quiet, "map"):
        options = {name: getattr(arguments, name) for name in ("pitch", "force_sign", "units")}
        with errors_of(arguments.scan):
            fit = fit_map(table["position"], table["force"], **options)
        if arguments.out:
            fit.write(arguments.out)
    text, written = fit.text(), []
    if arguments.out:
        text += f"\nreplace the [cogging] section of a model by that of {printable(arguments.out)}"
        written = [arguments.out, str(figure)]
        fitted = option("--out", free_name("fitted.toml"))
        following = command_line("identify", "LOG.csv", "--model", "MODEL.toml", fitted)
    else:
        labels = arguments.units and ",".join(f"{key}={label}" for key, label in arguments.units.to_dict().items())
        following = again(arguments, units=labels, out=free_name(arguments.scan, "map"))
    print_result(arguments, text, document=fit.to_dict(), written=written, next_command=following)


def _units(text: str) -> Units:
    """Labels as `command=N,position=rad`."""
    pairs = dict(entry.partition("=")[::2] for entry in text.split(","))
    try:
        return Units.from_dict(pairs)
    except FieldError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
