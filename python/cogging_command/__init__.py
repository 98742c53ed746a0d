"""The door to the command `cogging`: a signal that ends it is answered in one line from the first import on.

Apart from the package `cogging`, because to import anything of that takes a third of a second. Ctrl-C (SIGINT), SIGTERM
and SIGHUP end the command with status 130, 143 and 129. Where files are being written or a child reads, an exception
unwinds what runs, so that nothing half written and no child stays; anywhere else there is nothing to clear up and the
command leaves at once. An exception is not raised there, because libraries swallow it, print it, or abort.
"""

from __future__ import annotations

import _thread
import os
import sys
import time

TYPE_CHECKING = False
if TYPE_CHECKING:
    import signal
    from collections.abc import Callable
    from types import FrameType
else:
    import _signal as signal  # without the enumerations of `signal`, as long to import as all the rest of this

__all__ = ["Ended", "main", "run_command", "take_signals", "take_signals_of_module"]

WORDS = {int(signal.SIGINT): "interrupted", int(signal.SIGTERM): "terminated"}
if hasattr(signal, "SIGHUP"):  # not on Windows
    WORDS[int(signal.SIGHUP)] = "hung up"
#: Modules that have something to clear up while a function of theirs runs: part files, children, folders.
UNWINDING = ("cogging.outputs", "cogging.logs.readers", "cogging.design.tuning.tune", "subprocess")
STUCK = 0.2  # s: after which a library that does not let Python's handlers run is left where it is
CLEARING_UP = 1.0  # s: after which the command leaves all the same


class Ended(BaseException):
    """A signal other than Ctrl-C ends the command: raised where something must be cleared up first."""


class _Signals:
    """What the signals do to this process; Python runs handlers in its main thread alone."""

    def __init__(self) -> None:
        self.process = os.getpid()
        self.main_thread = _thread.get_ident()
        self.unwinds = False  # always, whatever runs
        self.number = 0  # of the signal that came
        self.first = 0.0  # s: when
        self.leaving = _thread.allocate_lock()
        self.leaver = 0  # the thread that holds it

    def handle(self, number: int, frame: FrameType | None) -> None:
        """End the command: the handler."""
        if os.getpid() != self.process:  # a forked worker, whose parent speaks
            os._exit(128 + number)
        if self.number:  # another signal while all is cleared up
            if time.monotonic() - self.first > CLEARING_UP:
                self.leave()
            return
        self.first, self.number = time.monotonic(), number
        if not self.must_unwind(frame):
            self.leave()
        if hasattr(signal, "setitimer"):
            signal.signal(signal.SIGALRM, lambda *_: self.leave())
            signal.setitimer(signal.ITIMER_REAL, CLEARING_UP)
        if number == signal.SIGINT:
            raise KeyboardInterrupt
        raise Ended

    def must_unwind(self, frame: FrameType | None) -> bool:
        """Whether something that must be cleared up is going on where the main thread is."""
        found = False
        while frame is not None:
            name = frame.f_globals.get("__name__") or ""
            if name == "importlib._bootstrap":  # what was found is only being imported
                found = False
            elif name.startswith(UNWINDING):
                found = True
            frame = frame.f_back
        return found or self.unwinds

    def watch(self, arrivals: int) -> None:
        """Leave when a signal came while the main thread is in a library that runs long: in a thread of its own."""
        while came := os.read(arrivals, 1):
            if came[0] not in WORDS:
                continue
            time.sleep(STUCK)
            if not self.number and not self.must_unwind(sys._current_frames().get(self.main_thread)):
                self.first, self.number = time.monotonic(), came[0]
                self.leave()

    def leave(self) -> None:
        """Say so in one line and end the process here."""
        if not self.leaving.acquire(blocking=False):
            if self.leaver != _thread.get_ident():  # the other thread is at it
                time.sleep(CLEARING_UP)
            os._exit(128 + self.number)  # in the midst of it, once more: what it waits for is left
        self.leaver = _thread.get_ident()
        try:  # noqa: SIM105 (contextlib takes 2 ms to import, in which no signal is answered)
            os.write(2, f"{_clear_bar()}cogging: {WORDS[self.number]}; no file was left half written\n".encode())
        except OSError:
            pass
        if "multiprocessing" in sys.modules:
            for child in sys.modules["multiprocessing"].active_children():
                child.kill()
        try:  # noqa: SIM105
            sys.stdout.flush()
        except Exception:  # closed, or in the midst of a print
            pass
        os._exit(128 + self.number)


def _clear_bar() -> str:
    """What takes a progress bar off the screen."""
    if "tqdm" not in sys.modules or not os.isatty(2):
        return ""
    return "\r" + " " * (os.get_terminal_size(2).columns - 1) + "\r"


_taken: _Signals | None = None


def take_signals(*, unwinds: bool = False) -> None:
    """From here on a signal ends this process in one line; one that is ignored (nohup) stays so.

    unwinds: always by an exception, for a program with more to clear up than the command has.
    """
    global _taken
    if _taken is None:
        _taken = _Signals()
        for number in WORDS:
            if signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, _taken.handle)
        if hasattr(os, "register_at_fork"):
            arrivals, announced = os.pipe()
            os.set_blocking(announced, False)
            signal.set_wakeup_fd(announced, warn_on_full_buffer=False)
            os.register_at_fork(after_in_child=lambda: signal.set_wakeup_fd(-1))
            _thread.start_new_thread(_taken.watch, (arrivals,))
    _taken.unwinds = _taken.unwinds or unwinds


def take_signals_of_module(package: str) -> None:
    """Take the signals if the process is `python -m PACKAGE...`: Python imports the package before the module."""
    if sys.argv[:1] != ["-m"]:  # what stands there until the module is found
        return
    started = sys.orig_argv[: len(sys.orig_argv) - len(sys.argv) + 1]
    name = started[-1] if started else ""
    if name.startswith("-"):  # -mPACKAGE
        name = name.partition("m")[2]
    if name == package or name.startswith(f"{package}."):
        take_signals()


def run_command(run: Callable[[], int | None], *, unwinds: bool = False) -> int:
    """Run a program to its end, or to a signal; gives the exit status. See take_signals."""
    take_signals(unwinds=unwinds)
    assert _taken is not None
    try:
        status = run()
        for number in WORDS:  # all is done and written
            signal.signal(number, signal.SIG_IGN)
    except (KeyboardInterrupt, Ended):
        if not _taken.number:
            raise
        _taken.leave()
    return status or 0


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
