"""Sweeps that are killed, and two of them at one file; at length: `python -m tests.attack.killed`."""

import os
import signal
import subprocess
import sys

import pytest

import cogging
from cogging.simulation import sweep as sweeps
from tests.attack.killed import attack
from tests.fixtures.sweeps import FEW, MANY, MOVE, SMALL, same

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals and locks of POSIX")


@pytest.mark.parametrize(("number", "kills"), [(signal.SIGKILL, 2), (signal.SIGINT, 1), (signal.SIGTERM, 1)])
def test_a_sweep_that_is_killed_loses_no_run_and_repeats_none(number, kills):
    found = attack("threads", kills, 3, number, runs=240)
    assert found.faults == []
    assert sum(found.kills.values()) == kills
    assert found.runs == 240 * found.done > 0


def ended_late(tmp_path, monkeypatch):
    """A sweep that was ended at its middle."""
    plain = sweeps.run_piece
    with monkeypatch.context() as patch:
        patch.setattr(sweeps, "run_piece", lambda piece: plain(piece) if piece.first < 160 else 1 / 0)
        with pytest.raises(ZeroDivisionError):
            cogging.sweep(SMALL, MOVE, MANY, out=tmp_path / "runs.csv", **FEW)
    return tmp_path / "runs.csv.pieces"


def test_pieces_that_a_kill_left_of_a_done_sweep_are_not_another_sweeps(tmp_path, monkeypatch):
    """`sweep.json` goes first: a kill behind that leaves pieces that are nobody's."""
    pieces = ended_late(tmp_path, monkeypatch)
    before = len(list(pieces.glob("*.npz")))
    (pieces / "sweep.json").unlink()
    made, plain = [], sweeps.run_piece
    monkeypatch.setattr(sweeps, "run_piece", lambda piece: made.append(piece.first) or plain(piece))
    other = {**FEW, "seed": 6}
    found = cogging.sweep(SMALL, MOVE, MANY, out=tmp_path / "runs.csv", **other)
    assert before == 20
    assert made == list(range(0, 320, 8)), "all are made"
    assert not pieces.exists()
    same(found, cogging.sweep(SMALL, MOVE, MANY, **other))


#: As a worker of a pool does, a fork of it lives on when it is killed.
HOLD = """
import fcntl, os, sys, time
with open(sys.argv[1], "r+b") as file:
    fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    if not (child := os.fork()):
        time.sleep(60)
    print(child, flush=True)
    sys.stdin.read()
"""


def test_a_sweep_that_another_process_makes_is_refused_and_goes_on_when_that_has_ended(tmp_path, monkeypatch):
    pieces = ended_late(tmp_path, monkeypatch)
    stood = sorted(path.name for path in pieces.iterdir())
    streams = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen([sys.executable, "-c", HOLD, pieces / "sweep.json"], **streams) as other:
        child = int(other.stdout.readline())
        with pytest.raises(cogging.InputError, match=r"runs\.csv\.pieces: another process is making this sweep"):
            cogging.sweep(SMALL, MOVE, MANY, out=tmp_path / "runs.csv", **FEW)
        assert sorted(path.name for path in pieces.iterdir()) == stood
        other.kill()
        other.wait()
        try:
            found = cogging.sweep(SMALL, MOVE, MANY, out=tmp_path / "runs.csv", **FEW)
        finally:
            os.kill(child, signal.SIGKILL)
    same(found, cogging.sweep(SMALL, MOVE, MANY, **FEW))
    assert [path.name for path in tmp_path.iterdir()] == ["runs.csv"]
