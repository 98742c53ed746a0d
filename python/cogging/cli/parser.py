"""Parser and help of the command, and options that several commands share."""

from __future__ import annotations

import argparse
import contextlib
import shutil
import textwrap
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from cogging.cli.terminal import print_error, print_text
from cogging.files import InputError
from cogging.model.model import Model
from cogging.shown import LONGEST_LINE, nearest, not_one_of, printable, quoted, shortened

WIDEST = 100  # letters of a line of help: longer ones are hard to read
SEEDS = 1 << 64  # number of seeds
THREADS_MAX = 1024
EXAMPLES = "examples:\n"


class Formatter(argparse.RawDescriptionHelpFormatter):
    """Help as wide as the terminal, at most WIDEST; examples are not wrapped."""

    def __init__(self, prog: str, **options: Any) -> None:
        width = min(shutil.get_terminal_size().columns - 2, WIDEST)
        super().__init__(prog, **{"width": width, **options})

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        fill = super(argparse.RawDescriptionHelpFormatter, self)._fill_text
        return "\n\n".join(part if "\n  " in part else fill(part, width, "") for part in text.split("\n\n"))


class Parser(argparse.ArgumentParser):
    """Parser that reports a wrong call in one line, with the option that was probably meant."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.color = False  # of Python 3.14: its escape codes would be printed as text
        self.words: Sequence[str] = ()

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse as argparse does, and keep the words for messages."""
        if args is not None:
            self.words = list(args)
        return super().parse_known_args(args, namespace)

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse as argparse does; the subcommand reports unknown words."""
        found, rest = self.parse_known_args(args, namespace)
        if rest:
            getattr(found, "parser", self).error(f"does not take {' '.join(rest)}")
        return found

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            raise argparse.ArgumentError(action, not_one_of(value, action.choices))

    def error(self, message: str) -> None:  # type: ignore[override]
        """Print what is wrong with the call and exit with status 2."""
        known = [option for option in self._option_string_actions if option.startswith("--")]
        meant = ""
        for word in self.words:
            option = word.partition("=")[0]
            if word == "--":
                break
            if option.startswith("--") and not any(name.startswith(option) for name in known):
                meant = nearest(option, known)
                if meant and option not in message:
                    meant = f", got {quoted(option)}{meant}"
                break
        print_error(f"{self.prog}: {shortened(message, LONGEST_LINE // 2)}{meant}; see {self.prog} --help")
        raise SystemExit(2)

    def _print_message(self, message: str, file: Any = None) -> None:
        print_text(message.rstrip("\n"))  # help and version


def add_command(commands: argparse._SubParsersAction[Any], name: str, module: Any) -> None:
    """Add a command: a module with `run(arguments)` and, if it has options, `add_options(command)`.

    Its docstring is the help: the first line after the name, then the description. EXAMPLES are calls, below its
    options, all of which a test runs; EPILOG, if any, stands above them.
    """
    first, _, description = (module.__doc__ or "").partition("\n\n")
    help = first.partition(": ")[2].rstrip(".\n")
    epilog = f"{getattr(module, 'EPILOG', '')}\n\n{EXAMPLES}{textwrap.indent(module.EXAMPLES, '  ')}".lstrip("\n")
    command = commands.add_parser(name, help=help, description=description, epilog=epilog, formatter_class=Formatter)
    command.set_defaults(parser=command, run=module.run)
    if hasattr(module, "add_options"):
        module.add_options(command)


def example_file(name: str) -> str:
    """Return the example of an input file of this name, for the help: the one in example_files, in small letters."""
    text = (Path(__file__).parent / "example_files" / name.lower()).read_text(encoding="utf-8")
    return f"{name}:\n{textwrap.indent(text.rstrip(), '  ')}"


class PrintConstant(argparse.Action):
    """Option that prints the result of `const()` and ends the command."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        """Print it."""
        print_text(self.const())
        parser.exit()


def whole(least: int, most: int) -> Callable[[str], int]:
    """Return the type of an option that is a whole number within a range."""

    def convert(text: str) -> int:
        if not (text.removeprefix("-").isdecimal() and len(text) < 30 and least <= int(text) <= most):
            raise argparse.ArgumentTypeError(f"must be a whole number from {least} to {most}, got {quoted(text)}")
        return int(text)

    return convert


def refuse_unknown(kind: str, name: str, known: Sequence[str]) -> None:
    """Raise InputError for an unknown name, with the nearest one."""
    if name not in known:
        raise InputError(f"{kind}: {not_one_of(printable(name), known)}")


def add_run_files(command: argparse.ArgumentParser) -> None:
    """Add the model and the reference of a command that simulates."""
    command.add_argument("model", metavar="MODEL.toml", help="the machine and its controller")
    command.add_argument("--reference", required=True, metavar="REF.toml", help="the reference motion")
    command.add_argument("--controller", choices=("pid",), help="in place of the model's: a PID for its mass")


@contextlib.contextmanager
def run_model(arguments: argparse.Namespace) -> Iterator[tuple[Model, str]]:
    """Yield the model of add_run_files with its controller, and a line about that; a ValueError names both files."""
    from cogging.design.pid import ASSUMED, assumed_pid

    try:
        model, said = Model.read(arguments.model), ""
        if arguments.controller is not None:
            model = model.replace(controller=assumed_pid(model.axis), controller_type=arguments.controller)
            said = f"controller: {ASSUMED}, for the model's mass\n"
        yield model, said
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"{arguments.model} with {arguments.reference}: {error}") from None


def add_threads(command: argparse.ArgumentParser) -> None:
    """Add `--threads`."""
    command.add_argument("--threads", type=whole(0, THREADS_MAX), default=0, metavar="N", help="default: all cores")


def add_seed(command: argparse.ArgumentParser, of: str) -> None:
    """Add `--seed`; `of`: what is drawn with it."""
    command.add_argument("--seed", type=whole(0, SEEDS - 1), default=0, help=f"of {of} (default: 0)")
