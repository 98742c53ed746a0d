"""`cogging help`: show the commands, or the help of one of them."""

from __future__ import annotations

import argparse

from cogging.cli.parser import Commands, add_command, refuse_unknown


def add_parser(commands: Commands) -> None:
    """Add the command."""
    command = add_command(
        commands,
        "help",
        help="show the commands, or the help of one of them",
        description="Print what `cogging --help` prints, or `cogging COMMAND --help`.",
        examples=("cogging help", "cogging help diagnose"),
    )
    command.add_argument("command", nargs="?", metavar="COMMAND", help="one of the commands")
    command.set_defaults(commands=commands)


def run(arguments: argparse.Namespace) -> None:
    """Print the help."""
    known = arguments.commands.choices
    if arguments.command is None:
        arguments.whole.print_help()
        return
    refuse_unknown("COMMAND", arguments.command, list(known))
    known[arguments.command].print_help()
