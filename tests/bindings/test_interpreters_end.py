"""The core when Python ends under its daemon threads, and in an interpreter beside the first."""

import subprocess
import sys

from tests.fixtures.files import MODEL

PROGRAM = """
import os, sys, threading, time
import cogging

model = cogging.Model.read("model.toml")
motion = cogging.Sine(cogging.SineParameters(center=0.2, amplitude=0.01, frequency=10))
controller = model.make_controller()
log = cogging.simulate(model, motion, duration=0.2)
block = b"0.1,0.2,0.3\\n" * 20_000
drag = cogging.effects.Custom("drag", force=lambda velocity: -0.1 * velocity)
own_law = model.replace(effects=[drag])
columns = {"time": log.time, "reference": log.reference, "position": log.position}

class Own:
    sample_rate = 5000.0

    def command(self, reference, reading):
        return 100.0 * (reference.position - reading)

calls = {
    "simulate": lambda: cogging.simulate(model, motion, duration=1),
    "sweep": lambda: cogging.sweep(model, motion, {"controller.kp": [9e3, 9.5e3, 1e4, 1.1e4]}, duration=1),
    "replay_controller": lambda: cogging.replay_controller(controller, **columns),
    "reader": lambda: cogging._core.NumberReader(separator=",", fields=3, wanted=[0], labels=["a"]).feed(block),
    "own law": lambda: cogging.simulate(own_law, motion, duration=1),
    "own controller": lambda: cogging.simulate(model, motion, controller=Own(), duration=1),
    "refused": lambda: cogging.PidParameters(kp="a"),
}

def work(call, begun):
    begun.set()
    while True:
        try:
            call()
        except TypeError:
            pass

for call in [*calls.values()] * 2:
    begun = threading.Event()
    threading.Thread(target=work, args=(call, begun), daemon=True).start()
    begun.wait()
time.sleep(0.2)
"""


def run(script, folder):
    return subprocess.run([sys.executable, "-c", script], cwd=folder, capture_output=True, text=True, timeout=100)


def test_python_ends_while_daemon_threads_are_in_the_core(tmp_path):
    """Python ends such a thread by pthread_exit where it asks for the lock: on the way out destructors aborted."""
    (tmp_path / "model.toml").write_text(MODEL)
    done = run(PROGRAM, tmp_path)
    assert (done.returncode, done.stderr) == (0, "")


def test_import_in_a_subinterpreter_is_one_error(tmp_path):
    """It waited for ever for a lock that it held itself, and heard no signal."""
    inner = "try:\n    import cogging\nexcept ImportError as error:\n    print(error, flush=True)"
    done = run(
        "try:\n    import _interpreters as beside\nexcept ImportError:\n    import _xxsubinterpreters as beside\n"
        f"beside.run_string(beside.create(), {inner!r})",
        tmp_path,
    )
    assert done.stdout == "cogging: must be imported by the main interpreter of the process, got another\n"
