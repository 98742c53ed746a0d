"""`cogging export`: a map in the form that a drive takes, a controller or the axis as code.

The forms and their options stand in cogging.export.forms, which says how one is added: nothing here names a form.
"""

from __future__ import annotations

import argparse
from typing import Any

from cogging.calls import did_you_mean
from cogging.cli.parser import Commands
from cogging.cli.screen import say
from cogging.export.forms import FORMS, Form, Option, option_of, shown_forms, to
from cogging.files import InputError
from cogging.outputs import check_outputs, write_files
from cogging.shown import printable, quoted


def add_parser(commands: Commands) -> None:
    """Add the command, its arguments, and the options of all forms."""
    command = commands.add_parser(
        "export",
        help="write a map as a drive takes it, a controller or the axis as code",
        description="Write a model, or a part of it, in a form that another machine takes, and say what it will take "
        "of it and what it cannot.",
        epilog=f"forms:\n{shown_forms()}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.add_argument("model", metavar="MODEL.toml", help="for a map, also what `cogging map` wrote")
    command.add_argument("--to", required=True, metavar="FORM", help="one of the forms below")
    command.add_argument("--out", required=True, metavar="FILE", help="where it is written")
    maps = [form.name for form in FORMS.values() if form.of_map]
    for option, forms in _options():
        taken = f"{option.help} ({'all maps' if forms == maps else ', '.join(forms)})"
        if option.kind is bool:
            command.add_argument(option_of(option.name), action="store_true", default=None, help=taken)
        else:
            how: dict[str, Any] = {"choices": option.choices} if option.choices else {"metavar": option.metavar}
            command.add_argument(option_of(option.name), help=taken, type=option.kind, **how)
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Make the form, write it, and print what the machine takes of it."""
    if arguments.to not in FORMS:
        raise InputError(
            f"--to: must be one of {', '.join(FORMS)}, got {quoted(arguments.to)}: {did_you_mean(arguments.to, FORMS)}"
        )
    form = FORMS[arguments.to]
    options = _given(arguments, form)
    read = [options[option.name] for option in form.options if option.reads and option.name in options]
    check_outputs({"--out": arguments.out}, [arguments.model, *read])
    made = to(arguments.model, arguments.to, **options)
    files = made.files(arguments.out)
    check_outputs({name: name for name in files}, [arguments.model, *read])
    write_files(files)
    say(made.text)
    say(f"{', '.join(map(printable, files))} written")


def _options() -> list[tuple[Option, list[str]]]:
    """The options of all forms by name, each with the forms that take it."""
    found: dict[str, tuple[Option, list[str]]] = {}
    for form in FORMS.values():
        for option in form.options:
            found.setdefault(option.name, (option, []))[1].append(form.name)
    return list(found.values())


def _given(arguments: argparse.Namespace, form: Form) -> dict[str, Any]:
    """The options that were given.

    Raises:
        InputError: one that the form does not take.
    """
    taken = {option.name for option in form.options}
    given = {option.name: getattr(arguments, option.name) for option, _ in _options()}
    given = {name: value for name, value in given.items() if value is not None}
    for name in given:
        if name not in taken:
            rest = ", ".join(option_of(other) for other in sorted(taken)) or "no option"
            raise InputError(
                f"{option_of(name)}: must be one that the form {form.name} takes ({rest}), got one that is not"
            )
    return given
