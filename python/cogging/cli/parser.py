"""What reads the command's words and shows its help: a wrong call gets one line, as every other wrong input."""

from __future__ import annotations

import argparse
import shutil
from collections.abc import Sequence
from typing import Any, TypeAlias

from cogging.cli.screen import complain, say
from cogging.files import InputError
from cogging.shown import LONGEST_LINE, nearest, printable, quoted, shortened

WIDEST = 100  # letters of a line of help: longer ones are hard to read

#: What a command adds its own parser to.
Commands: TypeAlias = "argparse._SubParsersAction[Any]"


class Formatter(argparse.RawDescriptionHelpFormatter):
    """Help as wide as the terminal, but no wider than can be read; examples stay as they are."""

    def __init__(self, prog: str, **options: Any) -> None:
        width = min(shutil.get_terminal_size().columns - 2, WIDEST)
        super().__init__(prog, **{"width": width, **options})

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        fill = super(argparse.RawDescriptionHelpFormatter, self)._fill_text
        return "\n\n".join(part if "\n  " in part else fill(part, width, "") for part in text.split("\n\n"))


class Parser(argparse.ArgumentParser):
    """Answers a wrong call in one line, as every other wrong input, and says what was probably meant."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.color = False  # of Python 3.14: what is printed here is escaped
        self.words: Sequence[str] = ()

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse does; the words are kept for what is said of them."""
        if args is not None:
            self.words = list(args)
        return super().parse_known_args(args, namespace)

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse does; what is left over is told by the command that has left it."""
        found, rest = self.parse_known_args(args, namespace)
        if rest:
            getattr(found, "parser", self).error(f"does not take {' '.join(rest)}")
        return found

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            known = list(action.choices)
            told = f"must be one of {', '.join(known)}, got {quoted(value)}{nearest(str(value), known)}"
            raise argparse.ArgumentError(action, told)

    def error(self, message: str) -> None:  # type: ignore[override]
        """Say what is wrong with the call and end the command with status 2."""
        told = f"{self.prog}: {shortened(message, LONGEST_LINE // 2)}{self._meant(message)}; see {self.prog} --help"
        complain(told)
        raise SystemExit(2)

    def _meant(self, message: str) -> str:
        """What the first option that is not known probably is."""
        known = [option for option in self._option_string_actions if option.startswith("--")]
        for word in self.words:
            option = word.partition("=")[0]
            if word == "--":
                break
            if option.startswith("--") and not any(name.startswith(option) for name in known):
                found = nearest(option, known)
                return f", got {quoted(option)}{found}" if found and option not in message else found
        return ""

    def _print_message(self, message: str, file: Any = None) -> None:
        say(message.rstrip("\n"))  # help and version


EXAMPLES = "examples:\n"


def add_command(
    commands: Commands, name: str, *, help: str, description: str, examples: Sequence[str] = (), epilog: str = ""
) -> argparse.ArgumentParser:
    """Add a command of that name.

    Args:
        commands: what it is added to.
        name: of the command.
        help: what it does, in the list of all commands.
        description: what goes in and what comes out, above its options.
        examples: real calls, below its options; each begins with `cogging`. A test runs them all.
        epilog: what else stands below, such as a file that it takes.
    """
    parts = [epilog] if epilog else []
    if examples:
        parts.append(EXAMPLES + "\n".join(f"  {line}" for line in examples))
    command: argparse.ArgumentParser = commands.add_parser(
        name, help=help, description=description, epilog="\n\n".join(parts) or None, formatter_class=Formatter
    )
    command.set_defaults(parser=command)
    return command


class Tell(argparse.Action):
    """Says what `const` gives, and ends the command."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        """Say it."""
        say(self.const())
        parser.exit()


def require_whole(option: str, value: int, least: int, most: int) -> None:
    """Refuse a whole number outside its range."""
    if not least <= value <= most:
        rule = f"at least {least}" if value < least else f"at most {most}"
        raise InputError(f"{option}: must be {rule}, got {quoted(value)}")


def refuse_unknown(kind: str, name: str, known: Sequence[str]) -> None:
    """Refuse a name that is none of those that are known."""
    if name not in known:
        told = quoted(printable(name))
        raise InputError(f"{kind}: must be one of {', '.join(known)}, got {told}{nearest(name, known)}")
