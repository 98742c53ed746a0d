"""Progress: on a terminal, of whatever takes long; nothing of it in a pipe, with --quiet, or in the end."""

import os
import random
import re
import select
import signal
import struct
import subprocess
import sys
import time

import pytest

from tests.fixtures import command_files
from tests.fixtures.commands import examples_of

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="terminals of POSIX")

#: What makes each command wait where it computes, so that it takes long on any machine: a function that it calls.
WAITS = {
    "audit": "cogging.log_check.log_audit.audit",
    "diagnose": "cogging.diagnosis.diagnose.diagnose",
    "experiment": "cogging.design.experiment_plan.plan_experiment",
    "map": "cogging.mapping.fit_map.fit_map",
    "predict": "cogging.design.error_prediction.predict_error",
    "simulate": "cogging.cli.simulate.simulate",
}
SLOW_SWEEP = "cogging.simulation.sweep.run_sweep"
BARS = ("identify", "reproduce", "sweep", "tune")  # which know how many steps there are, and show them at once
#: A command that waits there for half a second, which counts as long; papers are done at once, and tell their steps.
PROGRAM = """
import importlib, sys, time
from cogging_command import run_command

def run():
    sys.stderr.isatty() and print("ready", end="", file=sys.stderr, flush=True)
    import cogging.cli.terminal
    from cogging.cli.main import main
    import cogging.papers.malaize2009 as paper
    from cogging.papers.result import Reproduction

    paper.reproduce = lambda progress: [*map(progress, paper.STEPS)] and Reproduction("malaize2009", [], {})
    where, name = sys.argv[1].rpartition(".")[::2]
    if where:
        cogging.cli.terminal.PATIENCE, cogging.cli.terminal.BETWEEN = 0.05, 0.05
        module = importlib.import_module(where)
        plain = getattr(module, name)
        def slow(*arguments, **options):
            time.sleep(float(sys.argv[2]))
            return plain(*arguments, **options)
        setattr(module, name, slow)
    return main(sys.argv[3:])

sys.exit(run_command(run))
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("progress")
    command_files.write(folder)
    return folder


def call(command):
    words = examples_of(command)[0]
    if command == "diagnose":  # on a log too short to measure: it is the waiting that is looked at
        words = ["diagnose", "log.csv", "--model", "model.toml", "--rows", "0:500"]
    return words if command != "reproduce" else ["reproduce", "malaize2009"]


def on_a_terminal(words, folder, slow="", interrupted=None, seconds="0.5", **environment):
    """Run with a terminal as standard error; status, standard output, and what the terminal got.

    interrupted: s from when signals are taken to SIGINT.
    """
    import fcntl
    import pty
    import termios

    leader, follower = pty.openpty()
    fcntl.ioctl(follower, termios.TIOCSWINSZ, struct.pack("HHHH", 30, 100, 0, 0))
    settings = {**os.environ, "TERM": "xterm", **environment}
    words = [sys.executable, "-c", PROGRAM, slow, seconds, *words]
    seen = b""
    with subprocess.Popen(words, cwd=folder, env=settings, stdout=subprocess.PIPE, stderr=follower) as process:
        os.close(follower)
        assert read(leader, 5) == b"ready"
        if interrupted is not None:
            time.sleep(interrupted)
            process.send_signal(signal.SIGINT)
        while part := read(leader):
            seen += part
        text = process.stdout.read().decode()
        status = process.wait(60)
    os.close(leader)
    return status, text, seen.decode()


def read(terminal, most=65536):
    """What a terminal got; nothing at its end."""
    try:
        return os.read(terminal, most) if select.select([terminal], [], [], 60)[0] else b""
    except OSError:  # the other end is closed
        return b""


def left_on_the_screen(seen):
    """What stands on a terminal in the end: each line as the last writing left it."""
    lines = []
    for line in seen.replace("\r\n", "\n").split("\n"):
        shown = ""
        for part in re.sub(r"\x1b\[[0-9;]*[A-Za-z]", "", line).split("\r"):
            shown = part + shown[len(part) :]
        lines.append(shown.rstrip())
    return "\n".join(lines).strip()


@pytest.mark.parametrize("command", [*WAITS, *BARS])
def test_what_takes_long_says_so_on_a_terminal(command, folder):
    status, out, seen = on_a_terminal(call(command), folder, WAITS.get(command, ""))
    assert status == 0, seen
    assert command in seen or call(command)[1] in seen
    if command in WAITS:
        assert len(re.findall(rf"{command}[^\r]*\[00:0[01]\]", seen)) >= 3, "it moves while the core computes"
    else:
        assert re.search(r"\d+%.*\d+/\d+", seen), "how much of it is done"
    assert left_on_the_screen(seen) == "", "and it is gone when it is done"
    assert "next: cogging " in out
    assert "\r" not in out


@pytest.mark.parametrize("command", ["diagnose", "sweep"])
def test_quiet_is_quiet_on_a_terminal(command, folder):
    assert on_a_terminal([*call(command), "--quiet"], folder, WAITS.get(command, "")) == (0, "", "")


def test_a_terminal_gets_progress_beside_json_that_is_piped(folder):
    status, out, seen = on_a_terminal([*call("audit"), "--json", "-"], folder, WAITS["audit"])
    assert (status, out[:2]) == (0, "[\n")
    assert "audit: log.csv [00:0" in seen
    assert left_on_the_screen(seen) == ""


def test_what_takes_a_moment_shows_nothing(folder):
    words = call("simulate")
    assert on_a_terminal(words, folder)[2] == ""


@pytest.mark.parametrize("command", ["map", "sweep"])
def test_a_pipe_gets_none(command, folder):
    words = [sys.executable, "-c", PROGRAM, WAITS.get(command, ""), "0.5", *call(command)]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert "\r" not in done.stdout
    assert "[00:0" not in done.stdout


def test_an_error_takes_the_progress_off(folder):
    """One line stands there, nothing before it."""
    status, _, seen = on_a_terminal(["map", "scan.csv", "--pitch", "5"], folder, WAITS["map"], NO_COLOR="1")
    assert status == 2
    assert "map [00:0" in seen
    assert re.fullmatch(r"cogging: scan.csv: [^\n]+", left_on_the_screen(seen))


@pytest.mark.parametrize("seed", range(2))
def test_ctrl_c_leaves_one_line_on_the_terminal(seed, folder):
    """At any time: while it imports, while the line is shown, while it moves."""
    draw = random.Random(seed)
    command = draw.choice([*WAITS, "sweep"])
    status, out, seen = on_a_terminal(
        call(command), folder, WAITS.get(command, SLOW_SWEEP), interrupted=draw.uniform(0.0, 0.5), seconds="30"
    )
    assert (status, out) == (130, "")
    assert left_on_the_screen(seen) == "cogging: interrupted; no file was left half written"
    assert not list(folder.glob(".*.part"))
