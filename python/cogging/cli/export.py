"""`cogging export`: write a map for a drive, a controller or the axis as code.

Write a model, or a part of it, for another machine. The command prints what the machine uses, what it cannot represent,
and the assumptions.
"""

from __future__ import annotations

import argparse
from typing import Any

from cogging.cli.answer import OUTPUT_GROUP, add_answer_options, json_file, print_result
from cogging.cli.next_command import command_line, files, free_name, init, option
from cogging.export.forms import FORMS, Option, to
from cogging.outputs import check_outputs
from cogging.progress import steps

EXAMPLES = """\
cogging export motor.toml --to csv --out map.csv
cogging export motor.toml --to akd --scale 0.8 --out akd.csv
cogging export model.toml --to cpp --out controller.hpp --json export.json"""
EPILOG = "forms:\n" + "\n".join(f"  {form.name:10s} {form.writes}" for form in FORMS.values())


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options."""
    command.add_argument("model", metavar="MODEL.toml", help="for a map, also what `cogging map` wrote")
    command.add_argument("--to", required=True, choices=FORMS, metavar="FORM", help="one of the forms below")
    maps = [form.name for form in FORMS.values() if form.of_map]
    for name, (one, forms) in _options().items():
        help = f"{one.help} ({'all maps' if forms == maps else ', '.join(forms)})"
        how: dict[str, Any] = {"type": one.kind}
        how |= {"choices": one.choices} if one.choices else {"metavar": one.metavar}
        how = {"action": "store_true", "default": None} if one.kind is bool else how
        command.add_argument(f"--{name.replace('_', '-')}", help=help, **how)
    group = command.add_argument_group(OUTPUT_GROUP)
    group.add_argument("--out", required=True, metavar="FILE", help="write the file")
    add_answer_options(group, json="the printed text")


def run(arguments: argparse.Namespace) -> None:
    """Export the model, write the files, and print what the machine uses of it."""
    form = FORMS[arguments.to]
    options = {name: value for name in _options() if (value := getattr(arguments, name)) is not None}
    json = {"--json": json_file(arguments)}
    check_outputs({"--out": arguments.out, **json}, [arguments.model])
    with steps(not arguments.quiet, "export"):
        made = to(arguments.model, arguments.to, **options)
    content = made.files(arguments.out)
    check_outputs({**{name: name for name in content}, **json}, [arguments.model])
    document = {"form": form.name, "files": list(content), "said": made.text.splitlines()}
    following = init("NEW_LOG.csv")  # with the map in the drive
    if not form.of_map:  # compare the code with a simulation
        run = option("--out", free_name("run.csv"))
        following = command_line("simulate", files([arguments.model]), "--reference", "REF.toml", run)
    print_result(arguments, made.text, document=document, files=content, next_command=following)


def _options() -> dict[str, tuple[Option, list[str]]]:
    """Return the options of all forms by name, each with the forms that accept it."""
    found: dict[str, tuple[Option, list[str]]] = {}
    for form in FORMS.values():
        for one in form.options:
            found.setdefault(one.name, (one, []))[1].append(form.name)
    return found
