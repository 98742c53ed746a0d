"""`cogging help`: show the commands, or the help of one of them.

Print what `cogging --help` prints, or `cogging COMMAND --help`.
"""

from __future__ import annotations

import argparse

from cogging.cli.parser import refuse_unknown

EXAMPLES = """\
cogging help
cogging help diagnose"""


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options."""
    command.add_argument("command", nargs="?", metavar="COMMAND", help="one of the commands")


def run(arguments: argparse.Namespace) -> None:
    """Print the help."""
    if arguments.command is None:
        arguments.whole.print_help()
        return
    refuse_unknown("COMMAND", arguments.command, list(arguments.commands))
    arguments.commands[arguments.command].print_help()
