"""The TAB key: what `cogging completion` prints, tried in the shells themselves."""

import contextlib
import os
import random
import select
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
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMP_LINE="$*"; COMP_POINT=${#COMP_LINE}
_shtab_cogging cogging "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD-1]}"
[ ${#COMPREPLY[@]} = 0 ] || printf '%s\\n' "${COMPREPLY[@]}"
"""


def bash(folder, *words):
    """What bash offers for the last of some words."""
    if shutil.which("bash") is None:
        pytest.skip("no bash")
    call = ["bash", "--norc", "-c", ASK, "ask", "cogging", *words]
    done = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=False)
    assert done.stderr.replace("compopt: not currently executing completion function", "").count("error") == 0
    return {line.strip() for line in done.stdout.splitlines()}


@POSIX
def test_bash_offers_every_command(folder):
    assert bash(folder, "") >= set(COMMANDS)
    assert bash(folder, "dia") == {"diagnose"}


@POSIX
@pytest.mark.parametrize("command", COMMANDS)
def test_bash_offers_every_option_of_a_command_and_no_other(command, folder):
    own = {name for action in of(command)._actions for name in action.option_strings if name.startswith("--")}
    assert bash(folder, command, "--") == own


@POSIX
def test_bash_offers_values_and_files(folder):
    assert bash(folder, "experiment", "--goal", "") == {"separate", "detect", "fit"}
    assert bash(folder, "completion", "") == set(SHELLS)
    assert bash(folder, "help", "") == set(COMMANDS)
    assert bash(folder, "reproduce", "") >= set(PAPERS)
    assert bash(folder, "reproduce", "--out", "") == {"runs", "zfunc"}
    files = {"first run.csv", "second.csv", "model.toml", "runs"}
    for words in (["audit", ""], ["diagnose", "second.csv", "--model", ""], ["identify", "a", "--json", ""]):
        assert files <= bash(folder, *words)
    assert bash(folder, "audit", "fi") == {"first run.csv"}


def type_into(shell, setup, typed, folder):
    """What an interactive shell shows after some keys, until it comes to rest."""
    import pty

    settings = {"PATH": os.environ["PATH"], "HOME": str(folder), "TERM": "xterm", "PS1": "> ", "LC_ALL": "C.UTF-8"}
    leader, follower = pty.openpty()
    with subprocess.Popen(
        shell, cwd=folder, env=settings, stdin=follower, stdout=follower, stderr=follower, start_new_session=True
    ) as process:
        os.close(follower)
        os.write(leader, f"{setup}; echo rea''dy\n".encode())
        until(leader, "ready")
        os.write(leader, typed.encode())
        seen = until(leader, None)
        process.kill()
    os.close(leader)
    return seen


def until(terminal, mark):
    """What a terminal shows until there is a mark; without one, until it is quiet for a second."""
    seen, last = "", time.monotonic() + 10.0
    while time.monotonic() < last and (mark is None or mark not in seen):
        if not select.select([terminal], [], [], 10.0 if mark else 1.0)[0]:
            break
        seen += os.read(terminal, 65536).decode()
    assert mark is None or mark in seen, seen
    return seen


#: A shell without its user's files, and how it takes the script.
INTERACTIVE = {
    "bash": (["bash", "--norc", "--noprofile", "-i"], "source script.bash"),
    "zsh": (["zsh", "-f", "-i"], "fpath=($PWD/zfunc $fpath); autoload -Uz compinit; compinit -u -D"),
}


@POSIX
@pytest.mark.parametrize("shell", list(filter(shutil.which, INTERACTIVE)))
@pytest.mark.parametrize(
    ("typed", "shown"),
    [("cogging dia\t", "cogging diagnose"), ("cogging audit --sc\t", "--scale"), ("cogging audit sec\t", "second.csv")],
)
def test_the_tab_key_completes(shell, typed, shown, folder):
    call, setup = INTERACTIVE[shell]
    assert shown in type_into(call, setup, typed, folder)


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


def test_a_shell_that_is_none_is_answered_with_the_nearest(capsys):
    chance = random.Random(1)
    for shell in SHELLS:
        wrong = shell.replace(chance.choice(shell[1:]), "x", 1)
        with pytest.raises(SystemExit):
            main(["completion", wrong])
        assert f"got '{wrong}'" in capsys.readouterr().err
