"""Why the robust terms that Xu and Yao 2001 print cannot run, and which of them can. Exploratory.

The command due to one encoder count, the sampling rate that the terms need, and each of them alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from cogging._core import AxisParameters, DivergedError, EncoderParameters, OutputFeedbackArc, Plant, closed_loop
from cogging.logs.log import Log
from cogging.papers.compared import PRINTED
from cogging.papers.result import Row, Table, explored
from cogging.papers.xu2001 import epoxy_motor
from cogging.papers.xu2001.backstepping import backstepping, steps
from cogging.papers.xu2001.epoxy_motor import INDEXES, RESOLUTION, TABLE_1, Unknowns, arc_parameters, reference
from cogging.plot.canvas import drawn, legend, new_figure
from cogging.plot.scales import scale_of
from cogging.plot.series import look, marker
from cogging.simulation.batch import closed_loop_batch

TERMS = ("alpha_1s2", "alpha_1s3", "c_phi_1", "c_theta_2", "c_phi_2", "u_s2", "u_s3")
ROBUST_TERMS = tuple(f"use_{term}" for term in TERMS)
ALL_TERMS = dict.fromkeys(ROBUST_TERMS, True)
#: Sampling rate (Hz) and resolution (m) at which the robust terms are tried.
HARDWARE = ((2500.0, 1e-6), (20_000.0, 1e-8), (200_000.0, 1e-10))
FACTORS = (0.0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0)
SETTLED = 500  # samples at rest after which the filters have settled: 0.2 s, 40 time constants of their poles at -200
RATES = (1e5, 1e6, 1e7, 1e8)  # Hz
FINE = 100_000.0  # Hz: at which the gains along a run are computed
SHORT = 0.02  # s: all of RATES have diverged by then
START = 0.1  # s, examined part of the run: the largest K_2 of a whole period is at 0.055 s
STABLE = 2.0  # z_2[k+1] = (1 - K_2 T) z_2[k] decays below this K_2 T


def rigid(resolution: float) -> Plant:
    """Return set 1 without delay, friction or noise: only the quantiser is left."""
    axis = AxisParameters(mass=epoxy_motor.MASSES["1"], viscous=epoxy_motor.VISCOUS, travel=[-0.3, 0.3])
    return Plant(axis, encoder=EncoderParameters(resolution=resolution))


def increment(factor: float, sample_rate: float, resolution: float) -> float:
    """Return the rms command increment (V) over 1 s with all robust terms times a factor; infinite if it diverges."""
    controller = OutputFeedbackArc(arc_parameters(sample_rate=sample_rate, robust_factor=factor, **ALL_TERMS))
    substeps = max(1, round(20_000 / sample_rate))
    try:
        found = closed_loop(rigid(resolution), controller, reference(), duration=1.0, steps_per_sample=substeps)
    except DivergedError:
        return float("inf")
    return epoxy_motor.indexes(Log.of(found))["du_rms"]


def one_count(resolution: float, held: int = SETTLED) -> float:
    """Return the command (V) due to one encoder count (m) with all printed robust terms after samples at rest."""
    controller = OutputFeedbackArc(arc_parameters(**ALL_TERMS))
    for _ in range(held):
        controller.update(controller.command(reference=0.0, reading=0.0))
    return controller.command(reference=0.0, reading=resolution)


def by_hand(resolution: float) -> float:
    """Return the command (V) of a settled count (m), -K_2 K_1 / theta_1min times it, by (28), (37), (38), (43)."""
    p = arc_parameters(**ALL_TERMS)
    none, psi = np.zeros((1, 2)), np.array([[1.0, p.observer_gain_1]]) / p.observer_gain_2
    zero = np.zeros(1)
    found = steps(p, zero, zero, zero, none, none, psi, np.array([p.theta]), zero)
    return -float(found.gain_1[0]) * float(found.gain_2[0]) / p.theta_min[0] * resolution


class Lasting(NamedTuple):
    """How long a run lasted."""

    time: float  # s
    error: float  # m, the largest; NaN if it diverged
    end: str  # how it ended


def time_to_divergence(sample_rate: float, duration: float) -> Lasting:
    """Run all printed robust terms with an ideal encoder at a sampling rate (Hz), at most for a duration (s)."""
    controller = OutputFeedbackArc(arc_parameters(sample_rate=sample_rate, **ALL_TERMS))
    batch = closed_loop_batch([rigid(0.0)], [controller], reference(), duration=duration)
    if batch.failures:
        return Lasting(batch.failures[0].time, float("nan"), batch.failures[0].reason)
    return Lasting(duration, float(batch.indexes["error_max"][0]), "ran to its end")


def one_count_table() -> Table:
    """Tabulate the command due to one count of 1 um, and how long all robust terms last at a sampling rate.

    unstable_from: where K_2 along a run without them exceeds its limit.
    """
    name = "ARC, all terms"
    counts = {
        "one sample after the start": one_count(RESOLUTION, held=1),
        f"settled, {SETTLED} samples": one_count(RESOLUTION),
        "settled, by hand": by_hand(RESOLUTION),
    }
    rows = [explored(name, "one_count", "V", abs(value), count=said) for said, value in counts.items()]
    law = OutputFeedbackArc(arc_parameters(sample_rate=FINE))
    log = Log.of(closed_loop(rigid(0.0), law, reference(), duration=START, record_estimates=True))
    gain = backstepping(log, arc_parameters(sample_rate=FINE, **ALL_TERMS)).gain_2
    for rate in RATES:
        label, unstable = f"{rate:.0e} Hz", log.time[np.argmax(gain > STABLE * rate)]
        rows.append(explored(name, "diverges_at", "s", time_to_divergence(rate, SHORT).time, rate=label))
        rows.append(explored(name, "unstable_from", "s", unstable, rate=label))
    rows.append(explored(name, "rate_needed", "Hz", gain.max() / STABLE))
    return Table("robust_terms", "The printed robust terms: one encoder count, and the sampling rate they need", rows)


def subsets() -> list[tuple[str, ...]]:
    """Return all 128 choices among the seven terms."""
    return [chosen for count in range(len(ROBUST_TERMS) + 1) for chosen in combinations(ROBUST_TERMS, count)]


def which_run(chosen: Sequence[tuple[str, ...]], machine: Plant) -> dict[tuple[str, ...], dict[str, float]]:
    """Run choices of terms in case 1 at 2.5 kHz; return e_M, e_rms (m), du_rms (V), or `diverges_at` (s) of each."""
    made = [OutputFeedbackArc(arc_parameters(**dict.fromkeys(one, True))) for one in chosen]
    machines, seeds = [machine] * len(made), [epoxy_motor.SEED] * len(made)
    batch = closed_loop_batch(machines, made, reference(), duration=epoxy_motor.DURATION, seeds=seeds)
    ends = {failure.run: failure.time for failure in batch.failures}
    names = (("e_M", "error_max"), ("e_rms", "error_rms"), ("du_rms", "command_change_rms"))
    return {
        one: {"diverges_at": ends[run]}
        if run in ends
        else {index: float(batch.indexes[name][run]) for index, name in names}
        for run, one in enumerate(chosen)
    }


def subsets_table(unknowns: Unknowns) -> Table:
    """Tabulate none, each of the terms alone and all other choices that run: rigid, and on the calibrated set 1."""
    on_rigid = which_run(subsets(), rigid(RESOLUTION))
    running = [one for one, values in on_rigid.items() if "diverges_at" not in values]
    singles = {one: values for one, values in on_rigid.items() if len(one) < 2 or one in running}
    units, rows = {"diverges_at": "s", "du_rms": "V"}, []
    for on, found in (("rigid", singles), ("calibrated", which_run(running, epoxy_motor.plant(unknowns, "1")))):
        for one, values in found.items():
            labels = {"terms": " + ".join(one).replace("use_", "") or "none", "plant": on}
            for index, value in values.items():
                printed = TABLE_1["ARC"]["1"][INDEXES.index(index)] if on == "calibrated" and index in INDEXES else None
                rows.append(Row("ARC", index, units.get(index, "m"), printed, value, "exploratory", labels))
    rows.append(explored("ARC", "choices_that_run", "1", len(running), of="128"))
    return Table("robust_subsets", "The seven robust terms: none, each alone, and the others that run at 2.5 kHz", rows)


@drawn
def figure_increment() -> Figure:
    """Draw the rms command increment against a common factor on the printed robust terms."""
    figure = new_figure((7.2, 4.2))
    figure.suptitle("The printed robust terms times a factor; a line ends where the run diverges")
    axes = figure.subplots()
    for place, (rate, resolution) in enumerate(HARDWARE):
        values = [increment(factor, rate, resolution) for factor in FACTORS[1:]]
        length = scale_of("m", resolution)
        label = f"{rate / 1000:g} kHz, {length(resolution):g} {length.unit}"
        axes.loglog(FACTORS[1:], values, marker=marker(place), label=label, **look(place))
    printed = TABLE_1["ARC"]["1"][4]
    axes.axhline(printed, **PRINTED, label=f"paper: {printed:g} V")
    axes.set(xlabel="factor on the printed robust terms", ylabel="rms command increment (V)", xlim=(5e-8, 2.0))
    legend(axes)
    return figure
