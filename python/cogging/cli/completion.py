"""`cogging completion`: print a completion script for a shell.

Print a script with which a shell completes commands, options, their values and files. Print it again after an update.
"""

from __future__ import annotations

import argparse

from cogging.cli.terminal import print_text
from cogging.papers.reproduction import PAPERS
from cogging.tables import library

SHELLS = ("bash", "zsh", "fish", "tcsh", "powershell")
EPILOG = """permanently:
  bash         cogging completion bash > ~/.local/share/bash-completion/completions/cogging
  zsh          cogging completion zsh > ~/.zfunc/_cogging      (with fpath+=~/.zfunc before compinit)
  fish         cogging completion fish > ~/.config/fish/completions/cogging.fish
for this shell:
  bash         eval "$(cogging completion bash)\""""

EXAMPLES = """\
cogging completion bash
cogging completion zsh"""


def add_options(command: argparse.ArgumentParser) -> None:
    """Add the options."""
    command.add_argument("shell", choices=SHELLS, metavar="SHELL", help=", ".join(SHELLS))


def run(arguments: argparse.Namespace) -> None:
    """Print the script."""
    shtab = library("shtab")
    whole, commands = arguments.whole, arguments.commands
    for parser in (whole, *commands.values()):
        for action in parser._actions:
            metavar = action.metavar if isinstance(action.metavar, str) else ""
            if metavar == "DIR":
                action.complete = shtab.DIRECTORY
            elif metavar in ("LOG", "SCAN", "OUT", "FILE") or "." in metavar.removesuffix("..."):
                action.complete = shtab.FILE
            elif metavar == "PAPER":
                action.choices = PAPERS
            elif metavar == "COMMAND" and parser is not whole:
                action.choices = list(commands)
    print_text(shtab.complete(whole, shell=arguments.shell), plain=True)
