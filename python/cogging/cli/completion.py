"""`cogging completion`: what lets a shell complete the command's words.

The script is made by shtab from the same parser that reads the words. It holds all that can be completed, so that the
TAB key starts no Python: to import this package takes a third of a second.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import Any

from cogging.cli.parser import Commands, add_command
from cogging.cli.screen import say
from cogging.files import InputError
from cogging.papers.reproduction import PAPERS

SHELLS = ("bash", "zsh", "fish", "tcsh", "powershell")
EXTRA = "the completion needs shtab, which the extra `completion` brings: pip install 'cogging[completion]'"
INSTALLED = """once and for all:
  bash         cogging completion bash > ~/.local/share/bash-completion/completions/cogging
  zsh          cogging completion zsh > ~/.zfunc/_cogging      (with fpath+=~/.zfunc before compinit)
  fish         cogging completion fish > ~/.config/fish/completions/cogging.fish
for this shell alone:
  bash         eval "$(cogging completion bash)\""""


def add_parser(commands: Commands) -> None:
    """Add the command and its arguments."""
    command = add_command(
        commands,
        "completion",
        help="print what lets a shell complete these commands",
        description="Print a script for a shell that completes commands, options, their values and files with the TAB "
        "key. It must be printed anew after an update.",
        epilog=INSTALLED,
        examples=("cogging completion bash", "cogging completion zsh"),
    )
    command.add_argument("shell", choices=SHELLS, metavar="SHELL", help=", ".join(SHELLS))
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Print the script."""
    try:
        import shtab
    except ImportError:
        raise InputError(EXTRA) from None
    whole = arguments.whole
    for action in _actions(whole):
        complete = _completed(action, shtab)
        if complete:
            action.complete = complete  # type: ignore[attr-defined]
        elif action.metavar == "PAPER":
            action.choices = PAPERS
        elif action.metavar == "COMMAND" and not isinstance(action, argparse._SubParsersAction):
            action.choices = list(_commands(whole).choices)
    say(shtab.complete(whole, shell=arguments.shell), plain=True)


def _commands(parser: argparse.ArgumentParser) -> argparse._SubParsersAction[Any]:
    return next(action for action in parser._actions if isinstance(action, argparse._SubParsersAction))


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """All words of the command and of its commands."""
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for other in action.choices.values():
                yield from _actions(other)


def _completed(action: argparse.Action, shtab: Any) -> dict[str, str]:
    """What shtab calls the completion of a file or folder; nothing for other words."""
    named = action.metavar if isinstance(action.metavar, str) else ""
    if named == "DIR":
        return dict(shtab.DIRECTORY)
    if named in ("LOG", "SCAN", "OUT", "FILE") or "." in named.removesuffix("..."):
        return dict(shtab.FILE)
    return {}
