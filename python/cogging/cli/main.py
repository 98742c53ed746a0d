"""The command `cogging`."""

from __future__ import annotations

import argparse
import importlib.metadata
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from cogging import _core
from cogging.cli.screen import complain, say, stand_in_for_closed_streams
from cogging.files import InputError, to_json, to_toml, write_files, write_text
from cogging.logs.columns import read_columns
from cogging.logs.log import Log, read_log
from cogging.model.model import STEPS_MAX
from cogging.outputs import check_folder, check_outputs, sidecar, with_sidecars
from cogging.papers.reproduction import PAPERS, compare, reproduce
from cogging.papers.result import Reproduction
from cogging.shown import LONGEST_LINE, printable, quoted, shortened
from cogging.simulation.reference import files_of_reference
from cogging.simulation.run import simulate
from cogging_command import run_command

SEEDS = 1 << 64  # that there are
MOST_SAMPLES = 1_000_000  # machines that a prediction draws


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is 0 when done, 2 when the input or the call cannot be used."""
    stand_in_for_closed_streams()
    try:
        options = _parser().parse_args(arguments)
        options.run(options)
    except InputError as error:
        complain(f"cogging: {error}")
        return 2
    except (ValueError, OSError, _core.DivergedError) as error:
        complain(f"cogging: {' '.join(str(error).split())}")
        return 2
    except MemoryError as error:
        complain(f"cogging: needs more memory than there is: {str(error) or 'a smaller file or fewer samples may do'}")
        return 2
    except (ArithmeticError, RecursionError) as error:  # the last resort: what no rule of a field has foreseen
        complain(f"cogging: these files lead to numbers that cannot be computed with: {error}")
        return 2
    return 0


class _Parser(argparse.ArgumentParser):
    """Answers a wrong call in one line, as every other wrong input."""

    def error(self, message: str) -> None:  # type: ignore[override]
        complain(f"{self.prog}: {shortened(message, LONGEST_LINE // 2)}; see {self.prog} --help")
        raise SystemExit(2)

    def _print_message(self, message: str, file: Any = None) -> None:
        say(message.rstrip("\n"))  # help and version


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="cogging", description="Simulate, control and identify axes with cogging linear motors.")
    parser.add_argument("--version", action="version", version=importlib.metadata.version("cogging"))
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    command = commands.add_parser("reproduce", help="the published experiments beside the papers' numbers")
    command.add_argument("papers", nargs="*", metavar="PAPER", help=f"{', '.join(PAPERS)}; all when none is named")
    command.add_argument("--compare", action="store_true", help="all papers' controllers on one axis")
    command.add_argument("--out", default="results", metavar="DIR", help="folder of the results (default: results)")
    command.set_defaults(run=_reproduce)

    command = commands.add_parser("simulate", help="one closed-loop run")
    command.add_argument("model", metavar="MODEL.toml")
    command.add_argument("--reference", required=True, metavar="REF.toml")
    command.add_argument("--out", required=True, metavar="LOG.csv")
    command.add_argument("--seed", type=int, default=0, help="of the noise (default: 0)")
    command.add_argument(
        "--steps-per-sample", type=int, metavar="N", help="fewest integration steps a sample (default: the model's)"
    )
    command.set_defaults(run=_simulate)

    command = commands.add_parser("predict", help="the tracking error of each controller, before the machine moves")
    command.add_argument("model", metavar="MODEL.toml")
    command.add_argument("--reference", required=True, metavar="REF.toml")
    command.add_argument("--samples", type=int, default=40, metavar="N", help="machines to draw (default: 40)")
    command.add_argument("--seed", type=int, default=0, help="of machines and noise (default: 0)")
    command.add_argument("--json", metavar="OUT", help="where the numbers are written")
    command.set_defaults(run=_predict)

    command = commands.add_parser("map", help="fit the cogging model to a force-against-position scan")
    command.add_argument("scan", metavar="SCAN")
    command.add_argument("--pitch", type=float, required=True, metavar="P", help="magnet pitch, m")
    command.add_argument(
        "--force-sign", type=int, default=1, metavar="S", help="-1: the sensor reads the motor's push (default: 1)"
    )
    command.add_argument("--out", metavar="MODEL.toml", help="where the [cogging] part is written; figure beside it")
    _add_log_options(command)
    command.set_defaults(run=_map)

    command = commands.add_parser("diagnose", help="find, name and add the effect that a model lacks")
    command.add_argument("logs", nargs="+", metavar="LOG")
    command.add_argument("--model", required=True, metavar="MODEL.toml")
    command.add_argument(
        "--confirm", nargs="+", default=[], metavar="LOG", help="logs of other motion, to check what was found"
    )
    command.add_argument("--json", metavar="OUT", help="where the result is written")
    command.add_argument("--report", metavar="OUT.html", help="where the report is written: one page, figures inside")
    command.add_argument("--out", metavar="MODEL.toml", help="where the model with the missing effect is written")
    command.add_argument(
        "--empirical", action="store_true", help="add what no effect explains to that model, as a force of any shape"
    )
    _add_log_options(command)
    command.set_defaults(run=_diagnose)

    command = commands.add_parser("audit", help="what a log is like, and whether a stated controller made it")
    command.add_argument("logs", nargs="+", metavar="LOG")
    command.add_argument("--model", metavar="MODEL.toml", help="whose controller and travel are compared")
    command.add_argument("--json", metavar="OUT", help="where the figures are written, one object a log")
    _add_log_options(command)
    command.set_defaults(run=_audit)

    command = commands.add_parser("identify", help="fit the parameters of a model to logs, with intervals")
    command.add_argument("logs", nargs="+", metavar="LOG")
    command.add_argument("--model", required=True, metavar="MODEL.toml", help="the prior; its controller is optional")
    command.add_argument("--out", metavar="MODEL.toml", help="where the fitted model is written, with [bounds]")
    command.add_argument("--json", metavar="OUT", help="where the fit is written")
    command.add_argument("--free", metavar="PATH,...", help="parameters to fit, as axis.mass (default: all)")
    command.add_argument("--cutoff", type=float, metavar="HZ", help="of the filter (default: found from the noise)")
    _add_log_options(command)
    command.set_defaults(run=_identify)

    command = commands.add_parser("schema", help="print the JSON Schema of model and reference files")
    command.set_defaults(run=_schema)
    return parser


def _add_log_options(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--columns", type=_pairs, default={}, metavar="NAME=IN_FILE,...", help="what columns are called in the file"
    )
    command.add_argument(
        "--scale", type=_factors, default={}, metavar="NAME=FACTOR,...", help="factors on columns of the file"
    )
    command.add_argument("--rows", type=_rows, default=None, metavar="FIRST:END", help="the data rows to take, from 0")


def _read_logs(options: argparse.Namespace, paths: Sequence[str]) -> list[Log]:
    """Read logs as _add_log_options says."""
    return [read_log(path, columns=options.columns, scale=options.scale, rows=options.rows) for path in paths]


def _require_whole(option: str, value: int, least: int, most: int) -> None:
    if not least <= value <= most:
        rule = f"at least {least}" if value < least else f"at most {most}"
        raise InputError(f"{option}: must be {rule}, got {quoted(value)}")


def _pairs(text: str) -> dict[str, str]:
    pairs = {}
    for entry in text.split(","):
        name, equals, value = entry.partition("=")
        if not (name and equals and value):
            raise argparse.ArgumentTypeError(f"must be NAME=VALUE,..., got {quoted(text)}")
        pairs[name.strip()] = value.strip()
    return pairs


def _factors(text: str) -> dict[str, float]:
    try:
        return {name: float(value) for name, value in _pairs(text).items()}
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be NAME=NUMBER,..., got {quoted(text)}") from None


def _rows(text: str) -> slice:
    try:
        first, last = text.split(":")
        rows = slice(int(first) if first else 0, int(last) if last else None)
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be FIRST:END, got {quoted(text)}") from None
    if (rows.start < 0) or (rows.stop is not None and rows.stop <= rows.start):
        raise argparse.ArgumentTypeError(f"needs 0 <= FIRST < END, got {quoted(text)}")
    return rows


def _reproduce(options: argparse.Namespace) -> None:
    for paper in options.papers:
        if paper not in PAPERS:
            raise InputError(f"PAPER: must be one of {', '.join(PAPERS)}, got {quoted(paper)}")
    check_folder(options.out)
    for paper in options.papers or (() if options.compare else PAPERS):
        _show(reproduce(paper, progress=True), options.out)
    if options.compare:
        _show(compare(progress=True), options.out)


def _show(result: Reproduction, folder: str) -> None:
    written = result.write(folder)
    say(f"{result.paper}\n\n{result.text()}\n\n{written[0]} and {len(written) - 1} figures written\n")


def _simulate(options: argparse.Namespace) -> None:
    _require_whole("--seed", options.seed, 0, SEEDS - 1)
    steps = options.steps_per_sample
    if steps is not None:
        _require_whole("--steps-per-sample", steps, 1, STEPS_MAX)
    outputs = {"--out": options.out, "its sidecar": sidecar(options.out)}
    check_outputs(outputs, [options.model, *files_of_reference(options.reference)])
    try:
        log = simulate(options.model, options.reference, seed=options.seed, steps_per_sample=steps)
    except InputError:
        raise
    except ValueError as error:  # what only the run itself can find wrong
        raise InputError(f"{options.model} with {options.reference}: {error}") from None
    log.write(options.out)
    say(f"{printable(options.out)}: {len(log)} rows, {log.time[-1]:g} s, max |error| {abs(log.error).max():.3g} m")


def _predict(options: argparse.Namespace) -> None:
    from cogging.design.error_prediction import predict_error

    _require_whole("--samples", options.samples, 2, MOST_SAMPLES)
    _require_whole("--seed", options.seed, 0, SEEDS - 1)
    check_outputs({"--json": options.json}, [options.model, *files_of_reference(options.reference)])
    try:
        prediction = predict_error(options.model, options.reference, samples=options.samples, seed=options.seed)
    except InputError:
        raise
    except ValueError as error:  # what only the draws and the runs can find wrong
        raise InputError(f"{options.model} with {options.reference}: {error}") from None
    if options.json:
        write_text(options.json, to_json(prediction.to_dict(), indent=2))
    say(prediction.text())
    if options.json:
        say(f"{printable(options.json)} written")


def _map(options: argparse.Namespace) -> None:
    from cogging.mapping.fit import fit_map

    figure = Path(options.out).with_suffix(".png") if Path(options.out or "").name else None
    check_outputs({"--out": options.out, "its figure": figure}, [options.scan])
    table = read_columns(
        options.scan, ("position", "force"), columns=options.columns, scale=options.scale, rows=options.rows
    )
    try:
        fit = fit_map(table["position"], table["force"], pitch=options.pitch, force_sign=options.force_sign)
    except ValueError as error:
        raise InputError(f"{options.scan}: {error}") from None
    if options.out:
        fit.write(options.out)
    say(fit.text())
    if options.out:
        say(f"{printable(options.out)} and {printable(str(Path(options.out).with_suffix('.png')))} written")


def _diagnose(options: argparse.Namespace) -> None:
    from tqdm import tqdm

    from cogging.diagnosis.diagnose import diagnose
    from cogging.model.model import Model

    outputs = {"--json": options.json, "--report": options.report, "--out": options.out}
    check_outputs(outputs, [options.model, *with_sidecars([*options.logs, *options.confirm])])
    model = Model.read(options.model)
    given, others = _read_logs(options, options.logs), _read_logs(options, options.confirm)
    with tqdm(desc="diagnose", bar_format="{desc} [{elapsed}]", leave=False, disable=None) as bar:
        result = diagnose(
            given,
            model,
            confirm=others,
            names=[printable(path) for path in options.logs],
            confirm_names=[printable(path) for path in options.confirm],
            empirical=options.empirical,
            progress=bar.set_description_str,
        )
        content = {}
        if options.json:
            content[options.json] = to_json(result.to_dict())
        if options.report:
            bar.set_description_str("writing the report")
            content[options.report] = result.html(title=", ".join(printable(Path(path).name) for path in options.logs))
        if options.out:
            content[options.out] = to_toml(result.model.to_dict())
    write_files({path: [text.encode()] for path, text in content.items()})
    say(result.text())
    if content:
        say(f"{', '.join(map(printable, content))} written")


def _audit(options: argparse.Namespace) -> None:
    from cogging.log_check.audit import audit, check_against_model
    from cogging.model.model import Model

    inputs = [*with_sidecars(options.logs), *([options.model] if options.model else [])]
    check_outputs({"--json": options.json}, inputs)
    model = Model.read(options.model) if options.model else None
    told, texts = [], []
    for path, log in zip(options.logs, _read_logs(options, options.logs), strict=True):
        if model is not None:
            check_against_model(log, model, path)
        try:
            found = audit(log, model)
        except ValueError as error:
            raise InputError(f"{path}: {error}") from None
        told.append({"log": path, **found.to_dict()})
        texts.append(f"{printable(path)}\n{found.text()}\n")
    if options.json:
        write_text(options.json, to_json(told))
    for text in texts:
        say(text)


def _identify(options: argparse.Namespace) -> None:
    from cogging.identification.identify import identify
    from cogging.model.model import Model

    outputs = {"--json": options.json, "--out": options.out}
    check_outputs(outputs, [options.model, *with_sidecars(options.logs)])
    model = Model.read(options.model)
    free = None if options.free is None else [path.strip() for path in options.free.split(",")]
    logs = _read_logs(options, options.logs)
    found = identify(
        logs, model, free=free, cutoff=options.cutoff, names=[printable(path) for path in options.logs], progress=True
    )
    content = {}
    if options.json:
        content[options.json] = to_json(found.to_dict())
    if options.out:
        content[options.out] = to_toml(found.model.to_dict())
    write_files({path: [text.encode()] for path, text in content.items()})
    say(found.text())


def _schema(options: argparse.Namespace) -> None:
    from cogging.file_schema import schema

    say(to_json(schema()).rstrip("\n"))


if __name__ == "__main__":
    sys.exit(run_command(main))
