"""What would explain Table I of Malaize and Levine 2009: `python -m studies.malaize2009.causes_study [DIR]`.

Prints the map of causes, what else each does, what it gives to the other motor, how much a draw counts, the verdicts
with their reasons, and on how many draws of unmodelled lines the spectrum proposes the printed periods first. With DIR
the curves are computed, some minutes, and drawn there.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cogging.mapping.error_spectrum import TrackingSpectrum, tracking_spectrum
from cogging.outputs import write_bytes
from cogging.papers.malaize2009 import accuracies
from cogging.papers.malaize2009.causes import CAUSES, DRAWS, LINE_PERIODS, explained, machine, shipped_table_1
from cogging.papers.malaize2009.linear_motors import MOTORS, Motor, pid, reference
from cogging.plot.canvas import drawn, legend, new_figure, png
from cogging.plot.series import GREY, look, marker
from cogging.simulation.run import closed_loop
from studies.command import run_study
from studies.malaize2009.causes_calibration import curve

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN = {"1": (100.0, "%"), "s": (1e6, "µs"), "m": (1e6, "µm"), "m/s": (1e3, "mm/s")}  # factor and label by unit
#: Reasons of the verdicts, in the order of CAUSES.
REASONS = (
    "section V calls the ironcore's spectrum much more chaotic; one share nearly serves both motors",
    "whole millimetres, from a transform over a stroke; but 7 and 24 % of the PID's lines would be left, where section V sees none",
    "nine times less on the ironless, 0.04 %, and no motor's constant is known that well",
    "seven times less on the ironless, 4 us, where like drives would have like delays",
    "three and four counts of the assumed encoders, most of it at rest too, where Table I has the same accuracy",
    "two and four times the printed accuracy, which such an encoder cannot show",
    "one value serves both motors, but under assumed levels of friction, with errors where the motion turns alone, and section II calls friction a lesser limitation",
)
SAME = 0.02  # relative: how near a proposed period is to a printed one


@drawn
def figure_causes(curves: Mapping[tuple[str, str], Sequence[tuple[float, float]]]) -> Figure:
    """The observer's accuracy over the printed one against the size of each cause, the PID's calibrated at each size.

    Args:
        curves: size and ratio by name of cause and motor, those of causes_calibration.curve.
    """
    figure = new_figure((8.0, 10.0))
    figure.suptitle("What alone would explain the observer's accuracy; the PID's is calibrated at every size")
    panels = figure.subplots(4, 2, sharey=True).ravel()
    for axes, cause in zip(panels, CAUSES, strict=False):
        factor, unit = SHOWN[cause.unit]
        for place, motor in enumerate(MOTORS.values()):
            sizes, ratios = np.transpose(curves[cause.name, motor.name])
            axes.loglog(factor * sizes, ratios, label=motor.name, marker=marker(place), markersize=4, **look(place))
        axes.axhline(1.0, color=GREY, linewidth=0.8)
        axes.set_xlabel(f"{cause.name} ({unit})")
        low, high = axes.get_xlim()
        ticks = [digit * 10.0**power for power in range(-4, 4) for digit in (1, 2, 5)]
        inside = [tick for tick in ticks if low <= tick <= high]
        axes.set_xticks(inside, [f"{tick:g}" for tick in inside])
        axes.set_xticks([], minor=True)
        axes.set_yticks(accuracies.RATIOS, [f"{ratio:g}" for ratio in accuracies.RATIOS])
        axes.set_yticks([], minor=True)
    for axes in panels[::2]:
        axes.set_ylabel("over the printed one")
    legend(panels[0])
    panels[-1].remove()
    return figure


def proposes_first(found: TrackingSpectrum, motor: Motor) -> bool:
    """Whether the strongest periods that a spectrum proposes are the printed ones, in any order."""
    first = sorted(found.periods[: len(motor.periods)])
    return len(first) == len(motor.periods) and bool(np.allclose(first, sorted(motor.periods), rtol=SAME, atol=0.0))


def draws_that_propose(motor: Motor, draws: int = DRAWS) -> int:
    """In how many draws of lines and phases the PID's error, there and back, proposes the printed periods first."""
    gains, conditions = shipped_table_1(motor)
    count = 0
    for draw in range(draws):
        plant = machine(motor, gains.amplitude, conditions, draw)
        log = closed_loop(plant, pid(), reference(motor), duration=reference(motor).period)
        count += proposes_first(tracking_spectrum(log, shortest_period=LINE_PERIODS[0]), motor)
    return count


def main(folder: str = "", show: Callable[[str], None] = print) -> None:
    """Print the study; draw the curves into a folder where one is given."""
    found = explained()
    spread = accuracies.spread_over_draws(found, accuracies.accuracies_of_table_1())
    for table in (accuracies.what_explains(found), accuracies.held_out(found), accuracies.what_else(found), spread):
        show(f"{table.text()}\n")
    for cause, reason in zip(CAUSES, REASONS, strict=True):
        show(f"{cause.name}: {cause.verdict}; {reason}.")
    counts = ", ".join(f"{motor.name} {draws_that_propose(motor)} of {DRAWS}" for motor in MOTORS.values())
    show(f"Draws of the lines in which the spectrum proposes the printed periods first: {counts}.")
    if folder:
        curves = {(cause.name, motor.name): curve(cause, motor) for cause in CAUSES for motor in MOTORS.values()}
        path = Path(folder) / "malaize2009_causes_curves.png"
        write_bytes(path, png(figure_causes(curves)))
        show(f"{path} written")


if __name__ == "__main__":
    sys.exit(run_study(__doc__, main, "", "folder of the curves, which take minutes; without it none are drawn"))
