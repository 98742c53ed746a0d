"""`cogging schema`: print the JSON Schema of model, reference, limits and sweep files.

Print the JSON Schema with which an editor completes and checks model, reference, limits and sweep files.
"""

from __future__ import annotations

import argparse

from cogging.cli.terminal import print_text
from cogging.outputs import to_json

EXAMPLES = """\
cogging schema"""


def run(arguments: argparse.Namespace) -> None:
    """Print the schema."""
    from cogging.file_schema import schema

    print_text(to_json(schema()).rstrip("\n"), plain=True)
