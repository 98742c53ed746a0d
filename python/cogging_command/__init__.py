"""The door to the command `cogging`: Ctrl-C, SIGTERM and SIGHUP end it with one line and status 130, 143 or 129.

Each signal raises KeyboardInterrupt in the main thread, out of the loops of the core too, which poll for signals. The
exception unwinds what runs, so that no half-written file and no child process stays. A second signal kills at once.

This module stands apart from the package `cogging`, whose import takes long: signals are handled before it begins.
"""

from __future__ import annotations

import os
import signal

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType

__all__ = ["main", "run_command"]

WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}
if hasattr(signal, "SIGHUP"):  # not on Windows
    WORDS[signal.SIGHUP] = "hung up"


def run_command(run: Callable[[], int | None]) -> int:
    """Run a program and return its exit status: its own, or 128 + the number of the signal that ended it.

    A signal that is ignored when the program starts (nohup) stays ignored.
    """
    received: list[int] = []

    def interrupt(number: int, frame: FrameType | None) -> None:
        received.append(number)
        for handled in WORDS:
            signal.signal(handled, signal.SIG_DFL)
        raise KeyboardInterrupt

    for number in WORDS:
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, interrupt)
    try:
        status = run() or 0
        if status == 0 or not received:  # a library may turn the exception into an error of its own
            return status
    except BaseException:
        if not received:
            raise
    os.write(2, f"cogging: {WORDS[signal.Signals(received[0])]}; no file was left half written\n".encode())
    return 128 + received[0]


def main() -> int:
    """The console script `cogging`."""

    def run() -> int:
        try:
            from cogging.cli.main import main as command
        except (MemoryError, ImportError) as error:
            said = " ".join(str(error).split())
            os.write(2, f"cogging: cannot begin: {said or 'there is no memory left'}\n".encode(errors="replace"))
            return 2
        return command()

    return run_command(run)
