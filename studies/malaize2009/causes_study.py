"""What would explain Table I of Malaize and Levine 2009: `python -m studies.malaize2009.causes_study [DIR]`.

Prints the map of causes, what else each does, what it gives to the other motor, how much a draw counts, the verdicts
with their reasons, and on how many draws of unmodelled lines the spectrum proposes the printed periods first. With DIR
the curves are computed, some minutes, and drawn there.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

from cogging.outputs import write_bytes
from cogging.papers.malaize2009.causes import CAUSES, explained
from cogging.papers.malaize2009.causes_figures import figure_causes
from cogging.papers.malaize2009.causes_tables import held_out, spread_over_draws, what_else, what_explains
from cogging.papers.malaize2009.setup import MOTORS
from cogging.papers.malaize2009.spectra import all_propose
from cogging.papers.malaize2009.tables import accuracies_of_table_1
from cogging.papers.result import png
from cogging_command import run_command
from studies.malaize2009.causes_calibration import curve


def main(folder: str | None = None, show: Callable[[str], None] = print) -> None:
    """Print the study; draw the curves into a folder where one is given."""
    found = explained()
    for table in (
        what_explains(found),
        held_out(found),
        what_else(found),
        spread_over_draws(found, accuracies_of_table_1()),
    ):
        show(f"{table.text()}\n")
    for cause in CAUSES:
        show(f"{cause.name}: {cause.verdict}; {cause.reason}.")
    show(all_propose())
    if folder is not None:
        curves = {(cause.name, motor.name): curve(cause, motor) for cause in CAUSES for motor in MOTORS.values()}
        path = Path(folder) / "malaize2009_causes_curves.png"
        write_bytes(path, png(figure_causes(curves)))
        show(f"{path} written")


if __name__ == "__main__":
    sys.exit(run_command(lambda: main(sys.argv[1] if len(sys.argv) > 1 else None)))
