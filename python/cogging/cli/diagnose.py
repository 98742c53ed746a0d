"""`cogging diagnose`: the effect that a model lacks, found, named and added."""

from __future__ import annotations

import argparse
from pathlib import Path

from cogging.cli.log_options import OPTIONS, add_log_options, read_logs
from cogging.cli.parser import Commands
from cogging.cli.screen import say
from cogging.diagnosis.next_step import GivenFiles
from cogging.outputs import check_outputs, to_json, to_toml, with_sidecars, write_files
from cogging.shown import printable


def add_parser(commands: Commands) -> None:
    """Add the command and its arguments."""
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
    command.add_argument(
        "--planned", metavar="REF.toml", help="the planned experiment that a log is of: what became of what it expected"
    )
    add_log_options(command)
    command.set_defaults(run=run)


def _given(arguments: argparse.Namespace) -> GivenFiles:
    """The files of the call and how they were read, for the command that the report says is next."""
    words = []
    for option in OPTIONS:
        for file, entries in getattr(arguments, option).items():
            prefix = f"{file}:" if file else ""
            for name, value in entries.items():
                if isinstance(value, slice):
                    told = f"{value.start}:{'' if value.stop is None else value.stop}"
                else:
                    told = f"{name}={value}"
                words += [f"--{option}", prefix + told]
    return GivenFiles(
        arguments.logs, arguments.model, arguments.confirm, words, arguments.json or "", arguments.out or ""
    )


def run(arguments: argparse.Namespace) -> None:
    """Diagnose the logs, write what was asked for, print the verdict."""
    from tqdm import tqdm

    from cogging.diagnosis.diagnose import diagnose
    from cogging.diagnosis.experiment.experiment_plan import plan_path
    from cogging.model.model import Model

    outputs = {"--json": arguments.json, "--report": arguments.report, "--out": arguments.out}
    inputs = [arguments.model, *with_sidecars([*arguments.logs, *arguments.confirm])]
    if arguments.planned is not None:
        inputs += [arguments.planned, plan_path(arguments.planned)]
    check_outputs(outputs, inputs)
    model = Model.read(arguments.model)
    given, others = read_logs(arguments, arguments.logs), read_logs(arguments, arguments.confirm)
    with tqdm(desc="diagnose", bar_format="{desc} [{elapsed}]", leave=False, disable=None) as bar:
        result = diagnose(
            given,
            model,
            confirm=others,
            names=[printable(path) for path in arguments.logs],
            confirm_names=[printable(path) for path in arguments.confirm],
            empirical=arguments.empirical,
            planned=arguments.planned,
            progress=bar.set_description_str,
        )
        content = {}
        if arguments.json:
            content[arguments.json] = to_json(result.to_dict())
        if arguments.report:
            bar.set_description_str("writing the report")
            title = ", ".join(printable(Path(path).name) for path in arguments.logs)
            content[arguments.report] = result.html(title=title, files=_given(arguments))
        if arguments.out:
            content[arguments.out] = to_toml(result.model.to_dict())
    write_files({path: [text.encode()] for path, text in content.items()})
    say(result.text())
    if content:
        say(f"{', '.join(map(printable, content))} written")
