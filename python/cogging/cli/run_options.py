"""What the commands share that run a model along a reference: the two files, the seed, and whose fault a run names."""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Iterator

from cogging.cli.parser import require_whole
from cogging.files import InputError

SEEDS = 1 << 64  # that there are


def add_files(command: argparse.ArgumentParser) -> None:
    """Give a command the model and the reference that it runs."""
    command.add_argument("model", metavar="MODEL.toml", help="the machine and its controller")
    command.add_argument("--reference", required=True, metavar="REF.toml", help="the motion that is asked for")


def add_seed(command: argparse.ArgumentParser, of: str) -> None:
    """Give a command the option `--seed`; of: what is drawn from it."""
    command.add_argument("--seed", type=int, default=0, help=f"of {of} (default: 0)")


def require_seed(arguments: argparse.Namespace) -> None:
    """Refuse a seed that the generator cannot take."""
    require_whole("--seed", arguments.seed, 0, SEEDS - 1)


@contextlib.contextmanager
def naming_files(arguments: argparse.Namespace) -> Iterator[None]:
    """Let an error that only the run itself can find name both files."""
    try:
        yield
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"{arguments.model} with {arguments.reference}: {error}") from None
