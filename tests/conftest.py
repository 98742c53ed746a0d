"""What the tests share."""

import gc
import os
import signal
from pathlib import Path

import pytest

# Before numpy is imported: threads of the linear algebra that spin on two busy cores cost more than they bring.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from cogging import outputs
from tests.fixtures.browser import browser  # noqa: F401 - a fixture, of which there can be one in a process

TESTS = Path(__file__).parent
outputs.synced = False  # thousands of files that no power failure matters to


def pytest_configure():
    """Answer signals: started in the background by a shell the tests would ignore them, with all that they start."""
    answers = {"SIGINT": signal.default_int_handler, "SIGTERM": signal.SIG_DFL, "SIGHUP": signal.SIG_DFL}
    for name, answer in answers.items():
        number = getattr(signal, name, None)  # not every system has all
        if number is not None and signal.getsignal(number) == signal.SIG_IGN:
            signal.signal(number, answer)


#: Folders and files that `-m "not slow"` leaves out: whole studies, processes, compilers, fits of many runs.
SLOW = (TESTS / "slow.txt").read_text().split()


#: Folders and files by what they share: a build, the reproductions of the papers, examples of all results.
TOGETHER = {"cpp": "cpp", "papers": "papers", "plot": "examples"}
TOGETHER |= {f"test_{name}.py": "examples" for name in ("docstrings", "face", "mistakes", "tables")}


def is_slow(path):
    """Whether SLOW names a file or its folder."""
    name = path.relative_to(TESTS).as_posix()
    return name.partition("/")[0] in SLOW or name in SLOW


def pytest_ignore_collect(collection_path, config):
    """Do not even import what `-m "not slow"` leaves out."""
    return True if config.option.markexpr == "not slow" and is_slow(collection_path) else None


def pytest_collection_modifyitems(config, items):
    """Mark what SLOW names; with `-n` that comes first, so that no process is left with a long file at the end."""
    for item in items:
        apart = any(item.get_closest_marker(name) for name in ("study", "data", "pages", "notebook"))
        if apart or is_slow(item.path):
            item.add_marker("slow")
    if hasattr(config, "workerinput"):
        items.sort(key=lambda item: item.get_closest_marker("slow") is None)


def pytest_collection_finish():
    """Leave all that was imported and collected out of the passes of the garbage collector, and have fewer of them."""
    gc.freeze()
    gc.set_threshold(50_000, 20, 100)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Give each file to one process, and what TOGETHER names: what its tests share is built or fitted once."""
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            file = nodeid.partition("::")[0]
            return TOGETHER.get(Path(file).parent.name) or TOGETHER.get(Path(file).name, file)

    config.option.loadscopereorder = False  # else by number of tests
    return ByFile(config, log)
