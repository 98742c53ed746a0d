"""Why the robust terms that Xu and Yao 2001 print cannot run: what one encoder count makes of them. Exploratory."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cogging._core import AxisParameters, DivergedError, EncoderParameters, OutputFeedbackArc, Plant, closed_loop
from cogging.logs.log import Log
from cogging.papers.xu2001.setup import MASSES, TABLE_1, VISCOUS, arc_parameters, indexes, reference
from cogging.plot.canvas import drawn, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROBUST_TERMS = (
    "use_alpha_1s2",
    "use_alpha_1s3",
    "use_c_phi_1",
    "use_c_theta_2",
    "use_c_phi_2",
    "use_u_s2",
    "use_u_s3",
)
#: Sampling rate (Hz) and resolution (m) at which the robust terms are tried.
HARDWARE = ((2500.0, 1e-6), (20_000.0, 1e-8), (200_000.0, 1e-10))
FACTORS = (0.0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0)


def increment(factor: float, sample_rate: float, resolution: float, duration: float = 1.0) -> float:
    """The rms command increment (V) with all printed robust terms times a factor; infinite where the run diverges.

    Set 1 of case 1 on a plant without delay, friction or noise: what is left is the quantiser.
    """
    switches = dict.fromkeys(ROBUST_TERMS, True)
    controller = OutputFeedbackArc(arc_parameters(sample_rate=sample_rate, robust_factor=factor, **switches))
    machine = Plant(
        AxisParameters(mass=MASSES["1"], viscous=VISCOUS, travel=[-0.3, 0.3]),
        encoder=EncoderParameters(resolution=resolution),
    )
    steps = max(1, round(20_000 / sample_rate))
    try:
        log = Log.of(closed_loop(machine, controller, reference(), duration=duration, steps_per_sample=steps))
    except DivergedError:
        return float("inf")
    return indexes(log)["du_rms"]


def one_count(resolution: float) -> float:
    """The command (V) that one encoder count (m) makes at rest, with all printed robust terms."""
    switches = dict.fromkeys(ROBUST_TERMS, True)

    def command(reading: float) -> float:
        controller = OutputFeedbackArc(arc_parameters(**switches))
        controller.command(reference=0.0, reading=0.0)
        controller.update(0.0)
        return controller.command(reference=0.0, reading=reading)

    return command(resolution) - command(0.0)


@drawn
def figure_increment() -> Figure:
    """The rms command increment against a common factor on the printed robust terms."""
    figure = new_figure((7.0, 4.0))
    axes = figure.subplots()
    for rate, resolution in HARDWARE:
        values = [increment(factor, rate, resolution) for factor in FACTORS[1:]]
        axes.loglog(FACTORS[1:], values, "o-", label=f"{rate / 1000:g} kHz, {1e9 * resolution:g} nm")
    axes.axhline(TABLE_1["ARC"]["1"][4], color="black", linestyle=":", label="paper: 0.06 V")
    axes.set(xlabel="factor on the printed robust terms", ylabel="rms command increment (V)")
    axes.set_title("A line ends where the run diverges")
    axes.legend()
    return figure
