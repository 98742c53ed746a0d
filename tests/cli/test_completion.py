"""The TAB key: what `cogging completion` prints, tried in the shells themselves."""

import contextlib
import os
import select
import shlex
import shutil
import subprocess
import sys
import time

import pytest

from cogging.cli.completion import SHELLS
from cogging.cli.main import COMMANDS, main
from cogging.papers.reproduction import PAPERS
from tests.fixtures.commands import of

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="shells of POSIX")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with files to complete, and the scripts as a user writes them."""
    folder = tmp_path_factory.mktemp("completion")
    (folder / "runs").mkdir()
    for name in ("first run.csv", "second.csv", "model.toml", "runs/third.csv"):
        (folder / name).touch()
    for shell in SHELLS:
        with open(folder / f"script.{shell}", "w") as file, contextlib.redirect_stdout(file):
            assert main(["completion", shell]) == 0
    (folder / "zfunc").mkdir()
    shutil.copy(folder / "script.zsh", folder / "zfunc" / "_cogging")
    return folder


ASK = """
source script.bash
while IFS= read -r line; do
  eval "set -- $line"
  COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMP_LINE="$*"; COMP_POINT=${#COMP_LINE}; COMPREPLY=()
  _shtab_cogging cogging "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD-1]}"
  printf '%s\\t' "${COMPREPLY[@]}"; echo
done
"""


def bash(folder, *calls):
    """What bash offers for the last word of each call."""
    if shutil.which("bash") is None:
        pytest.skip("no bash")
    lines = "".join(shlex.join(["cogging", *words]) + "\n" for words in calls)
    done = subprocess.run(
        ["bash", "--norc", "-c", ASK], input=lines, cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.stderr.replace("compopt: not currently executing completion function", "").count("error") == 0
    return [{word.strip() for word in line.split("\t") if word.strip()} for line in done.stdout.splitlines()]


@POSIX
def test_bash_offers_every_option_of_a_command_and_no_other(folder):
    for command, offered in zip(COMMANDS, bash(folder, *([command, "--"] for command in COMMANDS)), strict=True):
        own = {name for action in of(command)._actions for name in action.option_strings if name.startswith("--")}
        assert offered == own


@POSIX
def test_bash_offers_commands_values_and_files(folder):
    files = {"first run.csv", "second.csv", "model.toml", "runs"}
    offered = {
        (): set(COMMANDS),
        ("experiment", "--goal"): {"separate", "detect", "fit"},
        ("completion",): set(SHELLS),
        ("reproduce",): set(PAPERS),
        ("audit",): files,
        ("diagnose", "second.csv", "--model"): files,
    }
    for wanted, found in zip(offered.values(), bash(folder, *([*words, ""] for words in offered)), strict=True):
        assert wanted <= found
    exact = [["dia"], ["reproduce", "--out", ""], ["audit", "fi"]]
    assert bash(folder, *exact) == [{"diagnose"}, {"runs", "zfunc"}, {"first run.csv"}]


def type_into(shell, setup, typed, shown, folder):
    """Type some keys into an interactive shell, and wait until it shows a text."""
    import pty

    settings = {"PATH": os.environ["PATH"], "HOME": str(folder), "TERM": "xterm", "PS1": "> ", "LC_ALL": "C.UTF-8"}
    leader, follower = pty.openpty()
    with subprocess.Popen(
        shell, cwd=folder, env=settings, stdin=follower, stdout=follower, stderr=follower, start_new_session=True
    ) as process:
        os.close(follower)
        try:
            os.write(leader, f"{setup}; echo rea''dy\n".encode())
            wait_for("ready", leader)
            os.write(leader, typed.encode())
            wait_for(shown, leader)
        finally:
            process.kill()
    os.close(leader)


def wait_for(text, terminal):
    """Read what a terminal shows until it holds a text, at most a minute."""
    seen, last = "", time.monotonic() + 60.0
    while text not in seen and time.monotonic() < last and select.select([terminal], [], [], 60.0)[0]:
        seen += os.read(terminal, 65536).decode()
    assert text in seen, seen


#: A shell without its user's files, and how it takes the script.
INTERACTIVE = {
    "bash": (["bash", "--norc", "--noprofile", "-i"], "source script.bash"),
    "zsh": (["zsh", "-f", "-i"], "fpath=($PWD/zfunc $fpath); autoload -Uz compinit; compinit -u -D"),
}


@POSIX
@pytest.mark.parametrize("shell", list(filter(shutil.which, INTERACTIVE)))
def test_the_tab_key_completes(shell, folder):
    call, setup = INTERACTIVE[shell]
    type_into(call, setup, "cogging audit --sc\t", "--scale", folder)


@POSIX
def test_scripts_are_right_in_their_own_language(folder):
    """Every shell that is here reads its script without a word; they hold every command."""
    for shell, call in {
        "bash": ["bash", "-n"],
        "zsh": ["zsh", "-n"],
        "fish": ["fish", "-n"],
        "tcsh": ["tcsh", "-n"],
    }.items():
        text = (folder / f"script.{shell}").read_text()
        assert all(command in text for command in COMMANDS)
        if shutil.which(call[0]) is not None:
            done = subprocess.run([*call, f"script.{shell}"], cwd=folder, capture_output=True, text=True, check=False)
            assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_without_its_library_the_extra_is_named(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert main(["completion", "bash"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err == ("cogging: the completion needs shtab: pip install 'cogging[completion]'\n")
