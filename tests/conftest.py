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


#: What `-m "not slow"` leaves out: whole studies, processes, compilers, fits of many runs. Folders, files and tests.
SLOW = """
benchmarks blind cpp diagnosis first_model golden identification papers site
bindings/test_counts.py bindings/test_interpreters_end.py bindings/test_found_by_attack.py bindings/test_stubs.py
cli/test_answers.py cli/test_cli.py cli/test_colour.py cli/test_completion.py cli/test_experiment.py cli/test_help.py
cli/test_hostile_words.py cli/test_interrupt.py cli/test_next_command.py cli/test_one_line.py cli/test_progress.py
cli/test_sweep.py cli/test_wild_input.py
datasets/test_odrive.py design/test_bounds.py design/test_error_prediction.py design/test_tune.py
export/test_control.py export/test_cpp_header.py export/test_drives_on_axis.py export/test_export_document.py
export/test_fmi.py export/test_drives.py friction/test_curve.py
log_check/test_audit.py log_check/test_controller_faults.py log_check/test_hints.py
logs/test_hostile_files.py logs/test_limits.py logs/test_malformed.py logs/test_pauses.py logs/test_logs.py
mapping/test_directions.py mapping/test_fit.py plot/test_pictures.py
simulation/test_digests.py simulation/test_own_controllers.py simulation/test_sweep.py simulation/test_sweep_dask.py
simulation/test_sweep_executors.py simulation/test_sweep_killed.py simulation/test_sweep_pieces.py
simulation/test_memory.py simulation/test_threads.py
test_allowed_versions.py test_blas_threads.py test_docstrings.py test_first_page.py test_guides.py test_licences.py
test_mistyped_names.py test_notebooks.py test_packaging.py test_same_bits.py test_text_files.py test_types.py
test_units_of_output.py test_written_files.py
""".split()


def pytest_collection_modifyitems(items):
    """Mark what SLOW names."""
    for item in items:
        path = item.path.relative_to(TESTS).as_posix()
        if path.partition("/")[0] in SLOW or path in SLOW:
            item.add_marker("slow")
