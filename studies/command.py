"""The command line that all studies share: `python -m studies.NAME [--help] [TARGET]`."""

from __future__ import annotations

import argparse
import importlib.resources
import sys
from collections.abc import Callable

from cogging.outputs import write_text
from cogging_command import run_command


def run_study(document: str | None, run: Callable[[str], None], default: str = "", target: str = "") -> int:
    """Run a study under the rules of `cogging`'s own commands; --help prints its docstring.

    Args:
        document: the module's docstring.
        run: the study; it gets TARGET.
        default: TARGET where none is given.
        target: what TARGET is; empty: the study takes none.
    """
    parser = argparse.ArgumentParser(
        prog=f"python -m {sys.modules['__main__'].__spec__.name}",
        description=document,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    if target:
        parser.add_argument(
            "target", metavar="TARGET", nargs="?", default=default, help=f"{target} (default: %(default)s)"
        )
    given = parser.parse_args()
    return run_command(lambda: run(getattr(given, "target", default)))


def run_calibration(document: str | None, text: Callable[[], str], package: str, name: str) -> int:
    """Run a calibration and write its text, into the shipped file where no TARGET is given.

    Args:
        document: the module's docstring.
        text: returns the content of the file.
        package: that ships the file.
        name: of the file.
    """

    def write(target: str) -> None:
        write_text(target, text())
        print(f"{target} written")

    return run_study(document, write, str(importlib.resources.files(package).joinpath(name)), "file to write")
