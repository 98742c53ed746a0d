"""The door to the command `cogging`: Ctrl-C, SIGTERM and SIGHUP end it with one line and status 130, 143 or 129.

Each signal raises KeyboardInterrupt in the main thread, out of the loops of the core too, which poll for signals. The
exception unwinds what runs, so that no half-written file and no child process stays. A second signal kills at once.

This module is not part of the package `cogging`, whose import is slow: signals are handled before it begins.
"""

from __future__ import annotations

import _thread
import os
import signal
import sys
import threading

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from sys import UnraisableHookArgs
    from types import FrameType

__all__ = ["main", "run_command"]

AGAIN = 0.01  # s until an exception that was swallowed is raised again
WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}
if hasattr(signal, "SIGHUP"):  # not on Windows
    WORDS[signal.SIGHUP] = "hung up"


def run_command(run: Callable[[], int | None]) -> int:
    """Run a program and return its exit status: its own, or 128 + the number of the signal that ended it.

    A signal that is ignored when the program starts (nohup) stays ignored.
    """
    received: list[int] = []
    handled = [number for number in WORDS if signal.getsignal(number) != signal.SIG_IGN]

    def interrupt(number: int, frame: FrameType | None) -> None:
        received.append(number)
        for other in handled:
            signal.signal(other, signal.SIG_DFL)
        raise KeyboardInterrupt

    def swallowed(unraisable: UnraisableHookArgs) -> None:
        # Callbacks of the garbage collector and of imports swallow exceptions: it is raised again where it can unwind.
        if not received or not isinstance(unraisable.exc_value, KeyboardInterrupt):
            sys.__unraisablehook__(unraisable)
            return
        for other in handled:
            signal.signal(other, interrupt)
        later = threading.Timer(AGAIN, _again, (received.pop(),))
        later.daemon = True
        later.start()

    for number in handled:
        signal.signal(number, interrupt)
    before, sys.unraisablehook = sys.unraisablehook, swallowed
    try:
        status = run() or 0
        if status == 0 or not received:  # a library may turn the exception into an error of its own
            return status
    except BaseException:
        if not received:
            raise
    finally:
        sys.unraisablehook = before
    # `python -m` ends by SIGINT itself where the exception once left an exec() of text, as when a dataclass is made;
    # CPython's flag for that is cleared by the next exec().
    exec("")
    os.write(2, f"cogging: {WORDS[signal.Signals(received[0])]}; no file was left half written\n".encode())
    return 128 + received[0]


def _again(number: int) -> None:
    if os.name == "nt":  # where os.kill ends the process
        _thread.interrupt_main(signal.Signals(number))
    else:
        os.kill(os.getpid(), number)


def main() -> int:
    """The console script `cogging`."""
    failed: list[str] = []

    def run() -> int:
        try:
            from cogging.cli.main import main as command
        except (MemoryError, ImportError) as error:  # or what a library makes of a signal while it is imported
            failed.append(" ".join(str(error).split()) or "there is no memory left")
            return 2
        return command()

    status = run_command(run)
    if failed and status == 2:
        os.write(2, f"cogging: cannot begin: {failed[0]}\n".encode(errors="replace"))
    return status
