"""The command `cogging`: parses its arguments, runs a command and reports errors."""

from __future__ import annotations

import importlib
import importlib.metadata
import os
import sys
from collections.abc import Sequence

from numpy.linalg import LinAlgError

from cogging import _core
from cogging.cli.parser import Formatter, Parser, PrintConstant, add_command
from cogging.cli.terminal import print_error
from cogging.cpp_library import get_cmake_dir, get_include
from cogging.files import InputError
from cogging.outputs import require_folder
from cogging_command import run_command

#: Commands in the order of the help, each a module of `cogging.cli`: see add_command.
COMMANDS = (
    *("init", "audit", "identify", "diagnose", "experiment", "map", "predict", "tune", "export", "simulate"),
    *("sweep", "reproduce", "schema", "completion", "help"),
)
STORY = """from a log to a better model: init drafts a model, identify fits it, diagnose finds what it lacks, and a \
log of other motion confirms that. Every command ends with the next one, as a line that can be pasted; words in \
capitals there, such as REF.toml, are files that only you have.

cogging help COMMAND says what a command takes, with examples."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0 when it is done, 2 if the input or the call is invalid."""
    for name in ("stdout", "stderr"):  # closed by the caller: libraries print without checking
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 (until the end of the process)
    try:
        parser = _parser()
        parsed = parser.parse_args(arguments)
        if not hasattr(parsed, "run"):
            parser.print_help()
            parser.error("a command must be given, got none")
        require_folder()
        parsed.run(parsed)
        return 0
    except InputError as error:
        message = str(error)
    except (ArithmeticError, RecursionError, LinAlgError) as error:  # the last resort, where no rule applies
        message = f"these files lead to a numerical error: {error}"
    except (ValueError, OSError, _core.DivergedError, ImportError) as error:
        message = " ".join(str(error).split())
    except MemoryError as error:
        reason = "" if "std::" in str(error) else str(error)  # of another library's C++
        message = f"not enough memory: {reason or 'a smaller file or fewer samples may do'}"
    print_error(f"cogging: {message}")
    return 2


def _parser() -> Parser:
    purpose = "Simulate, control and identify axes with cogging linear motors."
    parser = Parser(prog="cogging", description=purpose, epilog=STORY, formatter_class=Formatter)
    parser.add_argument("--version", action="version", version=importlib.metadata.version("cogging"))
    for name, path, help in (
        ("--include-dir", get_include, "folder of the C++ headers"),
        ("--cmake-dir", get_cmake_dir, "cogging_DIR of a CMake project"),
    ):
        parser.add_argument(name, action=PrintConstant, nargs=0, const=path, help=help)
    commands = parser.add_subparsers(metavar="COMMAND")
    for name in COMMANDS:
        add_command(commands, name, importlib.import_module(f"cogging.cli.{name}"))
    parser.set_defaults(whole=parser, commands=commands.choices)
    return parser


if __name__ == "__main__":
    sys.exit(run_command(main))
