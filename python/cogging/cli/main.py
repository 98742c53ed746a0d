"""The command `cogging`: lists its commands, reads the words, runs one and answers errors."""

from __future__ import annotations

import importlib
import importlib.metadata
import sys
from collections.abc import Sequence

from numpy.linalg import LinAlgError

from cogging import _core
from cogging.cli.parser import Formatter, Parser, Tell
from cogging.cli.screen import complain, stand_in_for_closed_streams
from cogging.cpp_library import get_cmake_dir, get_include
from cogging.files import InputError
from cogging.outputs import require_folder
from cogging_command import run_command

#: The commands in the order of the help: each a module of `cogging.cli` with `add_parser(commands)`, `run(arguments)`.
COMMANDS = (
    "init",
    "audit",
    "identify",
    "diagnose",
    "experiment",
    "map",
    "predict",
    "tune",
    "export",
    "simulate",
    "sweep",
    "reproduce",
    "schema",
    "completion",
    "help",
)
NO_COMMAND = "a command must be given, got none"
STORY = """from a log to a better model: init drafts a model, identify fits it, diagnose finds what it lacks, and a \
log of other motion confirms that. Every command ends with the next one, as a line that can be pasted; words in \
capitals there, such as REF.toml, are files that only you have.

cogging help COMMAND says what a command takes, with examples."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is 0 when done, 2 when the input or the call cannot be used."""
    stand_in_for_closed_streams()
    try:
        parser = _parser()
        parsed = parser.parse_args(arguments)
        if not hasattr(parsed, "run"):
            parser.print_help()
            parser.error(NO_COMMAND)
        require_folder()
        parsed.run(parsed)
    except InputError as error:
        complain(f"cogging: {error}")
        return 2
    except (ArithmeticError, RecursionError, LinAlgError) as error:  # the last resort: what no rule has foreseen
        complain(f"cogging: these files lead to numbers that cannot be computed with: {error}")
        return 2
    except (ValueError, OSError, _core.DivergedError) as error:
        complain(f"cogging: {' '.join(str(error).split())}")
        return 2
    except MemoryError as error:
        said = "" if "std::" in str(error) else str(error)  # of another library's C++
        complain(f"cogging: needs more memory than there is: {said or 'a smaller file or fewer samples may do'}")
        return 2
    except ImportError as error:  # a library that is not there, or for whose code no memory is left
        complain(f"cogging: {' '.join(str(error).split())}")
        return 2
    return 0


def _parser() -> Parser:
    described = "Simulate, control and identify axes with cogging linear motors."
    parser = Parser(prog="cogging", description=described, epilog=STORY, formatter_class=Formatter)
    parser.add_argument("--version", action="version", version=importlib.metadata.version("cogging"))
    parser.add_argument("--include-dir", action=Tell, nargs=0, const=get_include, help="folder of the C++ headers")
    parser.add_argument("--cmake-dir", action=Tell, nargs=0, const=get_cmake_dir, help="cogging_DIR of a CMake project")
    parser.set_defaults(whole=parser)
    commands = parser.add_subparsers(metavar="COMMAND")
    for name in COMMANDS:
        importlib.import_module(f"cogging.cli.{name}").add_parser(commands)
    return parser


if __name__ == "__main__":
    sys.exit(run_command(main))
