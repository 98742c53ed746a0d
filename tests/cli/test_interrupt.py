"""Ctrl-C and SIGTERM: the caller gets its KeyboardInterrupt out of the core's loops; the command ends in one line.

docs/evidence.md promises half a second; on a busy machine these tests allow three times that, in the best of three.
"""

import contextlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import cogging
from cogging import _core
from cogging.outputs import to_toml
from tests.fixtures import command_files
from tests.fixtures.files import MODEL, REFERENCE

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")

WITHIN, TRIES = 1.5, 3  # s, from the signal to the exception or the exit
AXIS = cogging.AxisParameters(mass=0.12, viscous=0.166, coulomb=0.15, coulomb_width=0.0, travel=[0.0, 0.51])
PLANT = cogging.Plant(AXIS)
PID = cogging.PidParameters(sample_rate=5000.0, kp=9600.0, ki=1e5, kd=48.0, mass=0.12, viscous=0.166)
SINE = cogging.Sine(cogging.SineParameters(center=0.25, amplitude=0.1, frequency=1.0))
TIME = np.arange(300_000) * 2e-4


LONG = {"duration": 40.0, "steps_per_sample": 200}


def batch(count, threads=1, width=0.0):
    plants = [cogging.Plant(AXIS.replace(coulomb_width=width))] * count
    cogging.closed_loop_batch(plants, [cogging.Pid(PID)] * count, SINE, threads=threads, **LONG)


def sweep_on_threads():
    model = cogging.Model(axis=AXIS, controller=PID, controller_type="pid", steps_per_sample=200)
    with ThreadPoolExecutor(2) as pool:
        cogging.sweep(model, SINE, {"axis.mass": {"from": 0.11, "to": 0.13, "points": 8}}, duration=40.0, executor=pool)


#: Each runs for seconds if nothing ends it.
LOOPS = {
    "one run": lambda: cogging.closed_loop(PLANT, cogging.Pid(PID), SINE, **LONG),
    "a batch whose first thread ends first": lambda: batch(3, 2),
    "a batch in lanes": lambda: batch(16, width=0.01),
    "a sweep on the threads of an executor": sweep_on_threads,
    "one prediction": lambda: _core.Predictor(TIME, 0.1 * np.sin(TIME), TIME, steps_per_sample=200).predict(PLANT),
    "an autoregression": lambda: _core.autoregression(np.cos(TIME), np.ones(TIME.size), order=74_000),
    "a filter": lambda: _core.whiten(np.cos(TIME)[None, :], list(np.full(100_000, 1e-9))),
}


def threads_alive():
    tasks = Path("/proc/self/task")
    return len(list(tasks.iterdir())) if tasks.exists() else threading.active_count()


@pytest.mark.parametrize("name", LOOPS)
def test_an_interrupt_reaches_the_caller_of_a_loop(name):
    delays, before = random.Random(name), threads_alive()
    for _ in range(TRIES):
        sent = []
        timer = threading.Timer(
            delays.uniform(0.1, 0.3),
            lambda sent=sent: sent.append(time.perf_counter()) or os.kill(os.getpid(), signal.SIGINT),
        )
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            LOOPS[name]()
        took = time.perf_counter() - sent[0]
        timer.join()
        for _ in range(200):  # a joined thread ends a moment later
            if threads_alive() <= before:
                break
            time.sleep(0.01)
        assert threads_alive() <= before
        if took < WITHIN:
            break
    assert took < WITHIN


def test_a_reader_stops_within_its_block_and_accepts_no_other():
    block = b"0.12345,0.23456,0.34567\n" * 4_000_000
    before, stopped = signal.signal(signal.SIGALRM, signal.default_int_handler), 0
    for _ in range(TRIES):
        reader = _core.NumberReader(separator=",", fields=3, wanted=[0, 1, 2], labels=["a", "b", "c"])
        signal.setitimer(signal.ITIMER_REAL, 0.02)
        with contextlib.suppress(KeyboardInterrupt):
            reader.feed(block)
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        if 0 < (stopped := reader.rows) < 4_000_000:
            break
    signal.signal(signal.SIGALRM, before)
    assert 0 < stopped < 4_000_000
    with pytest.raises(ValueError, match=r"^NumberReader: may not go on behind a call that failed, got line \d+$"):
        reader.feed(b"1,2,3\n")


CONSOLE = ["-c", "import sys; from cogging_command import main; sys.exit(main())"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("interrupt")
    (folder / "model.toml").write_text(MODEL)
    (folder / "ref.toml").write_text(REFERENCE + "dwell = 0.1\nrepeats = 120\n")
    (folder / "temporary").mkdir()
    return folder


def start(folder, call):
    environment = os.environ | {"TMPDIR": str(folder / "temporary")}
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen([sys.executable, *call], cwd=folder, env=environment, **streams)


def end(process, number):
    """Send a signal; return the status, standard error and the seconds until the end."""
    sent = time.perf_counter()
    process.send_signal(number)
    process.answer, error = process.communicate(timeout=60)
    return process.returncode, error, time.perf_counter() - sent


SWEEP = to_toml(command_files.SWEEP | {"runs": 40_000, "duration": 5.0})
#: Command, signal, and when it is sent: while a log is written, and after the first pieces of a sweep.
SHOTS = [
    ("simulate model.toml --reference ref.toml --out out/log.csv", "SIGTERM", lambda out: list(out.iterdir())),
    ("sweep sweep.toml --out out/runs.csv", "SIGINT", lambda out: list(out.glob("*.kept"))),
]


@pytest.mark.parametrize(("call", "name", "is_ready"), SHOTS)
def test_the_command_answers_a_signal_in_one_line_and_leaves_whole_files(call, name, is_ready, folder):
    """Nothing, or finished pieces of a sweep."""
    number, out = getattr(signal, name), folder / "out"
    (folder / "sweep.toml").write_text(SWEEP)
    for _ in range(TRIES):
        out.mkdir()
        process = start(folder, [*CONSOLE, *call.split()])
        while process.poll() is None and not is_ready(out):
            time.sleep(0.001)
        status, error, took = end(process, number)
        # done in that moment; after its answer Python restores its handlers as it ends
        is_done = status == 0 or (status == -number and process.answer and not error)
        left = [] if is_done else [path for path in out.rglob("*") if path.is_file()]
        for path in left:
            assert path.suffix == ".kept", "no result, and no part of one"
            for line in path.read_bytes().split(b"\n")[1:]:
                assert len(set(map(len, json.loads(line.partition(b" ")[2]).values()))) == 1
        shutil.rmtree(out)
        assert list((folder / "temporary").iterdir()) == []
        assert is_done or (status, error[:9], error.count("\n")) == (128 + number, "cogging: ", 1), error
        if not is_done and took < WITHIN:
            break
    assert took < WITHIN


PROGRAM = "import sys, time\nfrom cogging_command import run_command\n"
CLEARS_UP = f"""{PROGRAM}
def run():
    try:
        print("begun", flush=True)
        time.sleep(60)
    finally:
        time.sleep(0.3)
        print("cleared up")
sys.exit(run_command(run))
"""

#: The exception of a signal within a callback is swallowed.
SWALLOWS = f"""{PROGRAM}import os, signal, weakref
class Thing: pass
def run():
    thing = Thing()
    gone = weakref.ref(thing, lambda _: os.kill(os.getpid(), signal.SIGTERM))
    del thing
    time.sleep(60)
sys.exit(run_command(run))
"""


def test_a_signal_whose_exception_is_swallowed_still_ends_the_command(folder):
    process = start(folder, ["-c", SWALLOWS])
    error = process.communicate(timeout=60)[1]
    assert (process.returncode, error.count("\n")) == (143, 1), error


def test_what_is_cleared_up_is_waited_for_but_a_second_signal_kills(folder):
    for second, status, printed in ((None, 130, "cleared up\n"), (signal.SIGTERM, -signal.SIGTERM, "")):
        process = start(folder, ["-c", CLEARS_UP])
        assert process.stdout.readline() == "begun\n"
        process.send_signal(signal.SIGINT)
        if second:
            time.sleep(0.1)
            process.send_signal(second)
        assert process.communicate(timeout=60)[0] == printed
        assert process.returncode == status


def test_an_ignored_signal_stays_ignored(folder):
    """As under nohup, and for commands that a shell runs behind a script."""
    program = PROGRAM + "print('begun', flush=True)\nsys.exit(run_command(lambda: time.sleep(0.3)))"
    ignore = "import os, signal, sys; signal.signal(signal.SIGINT, signal.SIG_IGN); "
    process = start(folder, ["-c", ignore + "os.execv(sys.executable, [sys.executable, '-c', sys.argv[1]])", program])
    assert process.stdout.readline() == "begun\n"
    assert end(process, signal.SIGINT)[:2] == (0, "")
