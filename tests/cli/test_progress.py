"""Progress: on a terminal, of whatever takes long; nothing of it in a pipe, with --quiet, or in the end."""

import importlib
import io
import os
import re
import select
import signal
import struct
import subprocess
import sys
import time

import pytest

from cogging.cli import terminal
from cogging.cli.main import main
from cogging.papers import malaize2009 as paper
from cogging.papers.result import Reproduction
from tests.fixtures import command_files
from tests.fixtures.commands import Terminal, examples_of

#: A function that each command calls where it computes: the tests slow it down.
COMPUTES = {
    "audit": "cogging.log_check.log_audit.audit",
    "diagnose": "cogging.diagnosis.diagnose.diagnose",
    "experiment": "cogging.design.experiment_plan.plan_experiment",
    "map": "cogging.mapping.fit_map.fit_map",
    "predict": "cogging.design.error_prediction.predict_error",
    "simulate": "cogging.cli.simulate.simulate",
}
BARS = ("identify", "reproduce", "sweep", "tune")  # which know how many steps there are, and show them at once


def call(command):
    words = examples_of(command)[0]
    if command == "diagnose":  # on a log too short to measure: it is the waiting that is looked at
        words = ["diagnose", "log.csv", "--model", "model.toml", "--rows", "0:500"]
    return words if command != "reproduce" else ["reproduce", "malaize2009"]


@pytest.fixture
def answer(tmp_path, monkeypatch, capsys):
    """Run a call whose computation takes 0.2 s, which counts as long; status, standard output and standard error."""
    monkeypatch.chdir(tmp_path)
    command_files.write(tmp_path)
    monkeypatch.setattr(paper, "reproduce", lambda done: [*map(done, paper.STEPS)] and Reproduction("a", [], {}))

    def run(words, stream, patience=0.05):
        monkeypatch.setattr(terminal, "PATIENCE", patience)
        monkeypatch.setattr(terminal, "BETWEEN", 0.03)
        monkeypatch.setattr(sys, "stderr", stream)
        if words[0] in COMPUTES:
            where, name = COMPUTES[words[0]].rsplit(".", 1)
            module = importlib.import_module(where)
            plain = getattr(module, name)
            monkeypatch.setattr(module, name, lambda *given, **options: time.sleep(0.2) or plain(*given, **options))
        status = main(words)
        return status, capsys.readouterr().out, stream.getvalue()

    return run


def left_on_the_screen(seen):
    """What stands on a terminal in the end: each line as the last writing left it."""
    lines = []
    for line in seen.replace("\r\n", "\n").split("\n"):
        shown = ""
        for part in re.sub(r"\x1b\[[0-9;]*[A-Za-z]", "", line).split("\r"):
            shown = part + shown[len(part) :]
        lines.append(shown.rstrip())
    return "\n".join(lines).strip()


@pytest.mark.parametrize("command", [*COMPUTES, *BARS])
def test_what_takes_long_says_so_on_a_terminal(command, answer):
    status, out, seen = answer(call(command), Terminal())
    assert status == 0, seen
    assert command in seen or call(command)[1] in seen
    if command in COMPUTES:
        assert len(re.findall(rf"{command}[^\r]*\[00:0[01]\]", seen)) >= 3, "it moves while the core computes"
    else:
        assert re.search(r"\d+%.*\d+/\d+", seen), "how much of it is done"
    assert left_on_the_screen(seen) == "", "and it is gone when it is done"
    assert "next: cogging " in out
    assert "\r" not in out


@pytest.mark.parametrize("command", ["map", "sweep"])
def test_there_is_none_with_quiet_nor_in_a_pipe_nor_of_what_takes_a_moment(command, answer):
    assert answer([*call(command), "--quiet"], Terminal()) == (0, "", "")
    assert answer(call(command), io.StringIO())[2] == ""
    assert answer(call("simulate"), Terminal(), patience=10.0)[2] == ""


def test_a_terminal_gets_progress_beside_json_that_is_piped(answer):
    status, out, seen = answer([*call("audit"), "--json", "-"], Terminal())
    assert (status, out[:2]) == (0, "[\n")
    assert "audit: log.csv [00:0" in seen
    assert left_on_the_screen(seen) == ""


def test_an_error_takes_the_progress_off(answer, monkeypatch):
    """One line stands there, nothing before it."""
    monkeypatch.setenv("NO_COLOR", "1")
    status, _, seen = answer(["map", "scan.csv", "--pitch", "5"], Terminal())
    assert status == 2
    assert "map [00:0" in seen
    assert re.fullmatch(r"cogging: scan.csv: [^\n]+", left_on_the_screen(seen))


PROGRAM = """
import sys, time
import cogging.cli.terminal
import cogging.mapping.fit_map as module
from cogging.cli.main import main
from cogging_command import run_command
cogging.cli.terminal.PATIENCE = cogging.cli.terminal.BETWEEN = 0.05
module.fit_map = lambda *given, **options: time.sleep(30)
sys.exit(run_command(lambda: main(["map", "scan.csv", "--pitch", "0.05"])))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="terminals of POSIX")
def test_ctrl_c_leaves_one_line_on_the_terminal(tmp_path):
    import fcntl
    import pty
    import termios

    command_files.write(tmp_path)
    leader, follower = pty.openpty()
    fcntl.ioctl(follower, termios.TIOCSWINSZ, struct.pack("HHHH", 30, 100, 0, 0))
    with subprocess.Popen([sys.executable, "-c", PROGRAM], cwd=tmp_path, stderr=follower) as process:
        os.close(follower)
        seen = part = read(leader)
        while part and b"map [00:0" not in seen:
            seen += (part := read(leader))
        process.send_signal(signal.SIGINT)
        while part := read(leader):
            seen += part
        assert process.wait(60) == 130
    os.close(leader)
    assert left_on_the_screen(seen.decode()) == "cogging: interrupted; no file was left half written"


def read(terminal, most=65536):
    """What a terminal got; nothing at its end."""
    try:
        return os.read(terminal, most) if select.select([terminal], [], [], 60)[0] else b""
    except OSError:  # the other end is closed
        return b""
