"""What the tests share."""

import os
import signal
from pathlib import Path

# Before numpy is imported: threads of the linear algebra that spin on two busy cores cost more than they bring.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest

from cogging import outputs
from cogging.diagnosis.evidence.null import fit_null
from tests.fixtures.browser import browser  # noqa: F401 - a fixture, of which there can be one in a process
from tests.fixtures.moving_axis import machine, record

TESTS = Path(__file__).parent
outputs.synced = False  # thousands of files that no power failure matters to


def pytest_configure():
    """Answer signals: started in the background by a shell the tests would ignore them, with all that they start."""
    answers = {"SIGINT": signal.default_int_handler, "SIGTERM": signal.SIG_DFL, "SIGHUP": signal.SIG_DFL}
    for name, answer in answers.items():
        number = getattr(signal, name, None)  # not every system has all
        if number is not None and signal.getsignal(number) == signal.SIG_IGN:
            signal.signal(number, answer)


@pytest.fixture(scope="session")
def quiet_evidence():
    """Evidence of a log in which nothing is hidden."""
    nominal = machine()
    return fit_null([record(nominal, 3)], nominal)[1]


#: Folders and files that `-m "not slow"` leaves out: whole studies, processes, compilers, fits of many runs.
SLOW = (TESTS / "slow.txt").read_text().split()


def pytest_collection_modifyitems(items):
    """Mark what SLOW names."""
    for item in items:
        path = item.path.relative_to(TESTS).as_posix()
        apart = any(item.get_closest_marker(name) for name in ("study", "data", "pages", "root", "notebook"))
        if apart or path.partition("/")[0] in SLOW or path in SLOW:
            item.add_marker("slow")
