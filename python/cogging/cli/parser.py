"""What reads the command's words: a wrong call gets one line, as every other wrong input."""

from __future__ import annotations

import argparse
from typing import Any, TypeAlias

from cogging.cli.screen import complain, say
from cogging.files import InputError
from cogging.shown import LONGEST_LINE, quoted, shortened


class Parser(argparse.ArgumentParser):
    """Answers a wrong call in one line, as every other wrong input."""

    def error(self, message: str) -> None:  # type: ignore[override]
        """Say what is wrong with the call and end the command with status 2."""
        complain(f"{self.prog}: {shortened(message, LONGEST_LINE // 2)}; see {self.prog} --help")
        raise SystemExit(2)

    def _print_message(self, message: str, file: Any = None) -> None:
        say(message.rstrip("\n"))  # help and version


class Tell(argparse.Action):
    """Says what `const` gives, and ends the command."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        """Say it."""
        say(self.const())
        parser.exit()


#: What a command adds its own parser to.
Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"


def require_whole(option: str, value: int, least: int, most: int) -> None:
    """Refuse a whole number outside its range.

    Raises:
        InputError: names the option, the bound and the value.
    """
    if not least <= value <= most:
        rule = f"at least {least}" if value < least else f"at most {most}"
        raise InputError(f"{option}: must be {rule}, got {quoted(value)}")
