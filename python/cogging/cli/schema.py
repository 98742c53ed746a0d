"""`cogging schema`: the JSON Schema of model, reference, limits and sweep files."""

from __future__ import annotations

import argparse

from cogging.cli.parser import Commands
from cogging.cli.screen import say
from cogging.outputs import to_json


def add_parser(commands: Commands) -> None:
    """Add the command, which takes no arguments."""
    command = commands.add_parser("schema", help="print the JSON Schema of model, reference, limits and sweep files")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Print the schema."""
    from cogging.file_schema import schema

    say(to_json(schema()).rstrip("\n"))
