"""What the printed numbers of Xu and Yao 2001 explain and what not: `python -m studies.xu2001.study`.

Exploratory, beside the tables of `cogging reproduce xu2001 --all`: the ARC columns by friction law and seed, all printed
robust terms at sampling rates up to what they need, the 128 choices among them, where ARC is better than the PID and
where not, and how much delay each loop tolerates.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

import cogging
from cogging.arrays import FloatArray
from cogging.model.controller import ListedController
from cogging.papers.xu2001 import backstepping
from cogging.papers.xu2001 import epoxy_motor as xu2001
from cogging.papers.xu2001.motion_cases import columns, gap
from cogging.papers.xu2001.pid_poles import FREQUENCIES, just_below, load_limit, simulated
from studies.command import run_study

#: Hz: below and above what the printed robust terms need. The last takes minutes.
LONG_RATES = (1e8, 2e8, 3e8, 3.2e8, 3.35e8)


def pid(**changes: Any) -> cogging.Pid:
    """The PID with the printed gains but for changes."""
    return cogging.Pid(xu2001.pid_parameters(**changes))


def arc(**changes: Any) -> cogging.OutputFeedbackArc:
    """The ARC likewise."""
    return cogging.OutputFeedbackArc(xu2001.arc_parameters(**changes))


def error_at_rest(controller: ListedController, mass: float, effect: Any, duration: float, **start: Any) -> FloatArray:
    """The error (m) of a rigid axis without friction that is held at rest while an effect acts."""
    axis = cogging.AxisParameters(mass=mass, viscous=xu2001.VISCOUS, travel=[-1.0, 1.0])
    plant = cogging.Plant(axis, effects=[effect])
    rest = cogging.PointToPoint(cogging.PointToPointParameters(distance=1e-9, velocity=1.0, acceleration=1.0))
    return cogging.closed_loop(plant, controller, rest, duration=duration, **start).error


def loses_stability(make: Callable[[], ListedController], mass: float) -> tuple[float, float]:
    """The delay (s) from which a small oscillation grows, and its frequency (Hz), on a rigid axis without friction."""

    def grows(delay: float) -> tuple[bool, float]:
        try:
            error = error_at_rest(make(), mass, cogging.effects.CommandDelay(delay=delay), 1.0, initial_position=1e-6)
        except cogging.DivergedError:
            return True, float("nan")
        early, late = error[500:1500], error[1500:2500]
        spectrum = np.abs(np.fft.rfft(late * np.hanning(late.size)))
        frequency = float(np.argmax(spectrum[2:]) + 2) * 2500.0 / late.size
        return bool(np.std(late) > np.std(early)), frequency

    low, high = 0.0, 4e-3
    for _ in range(14):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if grows(middle)[0] else (middle, high)
    return low, grows(low)[1]


def integral_stiffness(controller: ListedController, mass: float) -> float:
    """Force over the time integral of the error that it leaves, V/(m s), on a rigid axis without friction."""
    force = 0.05
    error = error_at_rest(controller, mass, cogging.effects.DisturbanceStep(force=force, start=0.1), 20.0)
    return force / float(error.sum() / 2500.0)


def sensitivities(unknowns: xu2001.Unknowns) -> dict[str, tuple[xu2001.Unknowns, Mapping[str, Any]]]:
    """The plants on which both controllers are compared."""
    mass = xu2001.MASSES["1"]
    return {
        "as calibrated": (unknowns, {}),
        "mass x 0.8": (unknowns, {"mass": 0.8 * mass}),
        "mass x 1.5": (unknowns, {"mass": 1.5 * mass}),
        "mass x 3": (unknowns, {"mass": 3.0 * mass}),
        "friction x 0.5": (replace(unknowns, coulomb=0.5 * unknowns.coulomb), {}),
        "friction x 1.5": (replace(unknowns, coulomb=1.5 * unknowns.coulomb), {}),
        "no delay": (replace(unknowns, delay=0.0), {}),
        "delay + 0.4 ms": (replace(unknowns, delay=unknowns.delay + 4e-4), {}),
        "no encoder noise": (replace(unknowns, encoder_noise=0.0), {}),
        "encoder noise x 3": (replace(unknowns, encoder_noise=3.0 * unknowns.encoder_noise), {}),
    }


def _numbers(values: Iterable[float]) -> str:
    return "".join(f"{value:9.3g}" for value in values)


def _compare(unknowns: xu2001.Unknowns, show: Callable[[str], None]) -> None:
    show("Where ARC is better and where not: e_M and e_rms (um) in set 1")
    show(f"{'':4}{'plant':<22}{'PID e_M':>10}{'ARC e_M':>10}{'PID e_rms':>11}{'ARC e_rms':>11}")
    for name, (machine, axis) in sensitivities(unknowns).items():
        cells = []
        for controller in (pid(), arc()):
            truth, motion = xu2001.plant(machine, "1", **axis), xu2001.reference()
            try:
                found = xu2001.indexes(cogging.closed_loop(truth, controller, motion, duration=xu2001.DURATION, seed=1))
                cells.append((1e6 * found["e_M"], 1e6 * found["e_rms"]))
            except cogging.DivergedError:
                cells.append((np.inf, np.inf))
        (pid_max, pid_rms), (arc_max, arc_rms) = cells
        show(f"{'':4}{name:<22}{pid_max:10.1f}{arc_max:10.1f}{pid_rms:11.2f}{arc_rms:11.2f}")


def _limits(unknowns: xu2001.Unknowns, show: Callable[[str], None]) -> None:
    show("Limits on a rigid axis without friction (frozen estimates for the ARC's delay)")
    for mass in (xu2001.MASSES["1"], xu2001.MASSES["2"]):
        for name, make in (
            ("PID", lambda: pid(coulomb=0.0)),
            ("PID at -320", lambda: pid(pole=-320.0, coulomb=0.0)),
            ("ARC", lambda: arc(coulomb=0.0, adaptation=[0.0] * 3)),
        ):
            delay, frequency = loses_stability(make, mass)
            show(f"{'':4}mass {mass:.3f}: {name:<12} unstable from {1e3 * delay:.3f} ms delay, at {frequency:.0f} Hz")
    for name, controller in (("PID", pid(coulomb=0.0)), ("ARC", arc(coulomb=0.0))):
        show(f"{'':4}integral stiffness of {name}: {integral_stiffness(controller, xu2001.MASSES['1']):.3g} V/(m s)")
    show("A mode just below the load that makes the PID at -300 unstable, on the calibrated plant for 30 s")
    for frequency in FREQUENCIES:
        mode = just_below(unknowns, frequency, load_limit(-300.0, xu2001.MASSES["1"], unknowns.delay, frequency))
        found = simulated(unknowns, mode, 30.0).items()
        cells = ", ".join(f"{name} {index} {value:.3g} {unit}" for name, (index, unit, value) in found)
        show(f"{'':4}{frequency:g} Hz, load {100 * mode.mass_ratio:.1f} %: {cells}")


def _robust_terms(show: Callable[[str], None]) -> None:
    show("Rms command increment (V) with the printed robust terms times a factor; inf = diverges")
    show(f"{'':4}{'hardware':<24}" + _numbers(backstepping.TERM_FACTORS))
    for rate, resolution in backstepping.HARDWARE:
        values = [backstepping.increment(factor, rate, resolution) for factor in backstepping.TERM_FACTORS]
        show(f"{'':4}{f'{rate / 1000:g} kHz, {1e9 * resolution:g} nm':<24}" + _numbers(values))
    show("All printed robust terms with an ideal encoder, for one period of the sine at most, by sampling rate")
    for rate in LONG_RATES:
        lasting = backstepping.time_to_divergence(rate, xu2001.PERIOD)
        error = "" if np.isnan(lasting.error) else f", e_M {1e6 * lasting.error:.3g} um"
        show(f"{'':4}{rate / 1e6:g} MHz: {lasting.time:.4g} s{error}, {lasting.end}")
    show("Choices among the seven robust terms that run for 10 s at 2.5 kHz on a 1 um encoder, of 128")
    choices = backstepping.which_run(backstepping.subsets(), backstepping.rigid(xu2001.RESOLUTION))
    for terms, found in choices.items():
        if "diverges_at" not in found:
            show(f"{'':4}{' + '.join(terms) or 'none':<36}{found['du_rms']:9.3g} V a sample")


def main(_: str = "", show: Callable[[str], None] = print) -> None:
    """Print the study."""
    unknowns = xu2001.shipped_unknowns()
    show("ARC columns against the paper's, with all as printed (exploratory)")
    show(f"{'':4}{'plant':<36}{'rms log gap':>12}{'':8}   e_M of sets 1, 2, 3 (um); paper 14.4, 113, 55.9")
    for law in ("smooth_stribeck", "smooth_coulomb", "exact_stribeck", "exact_coulomb"):
        found = columns(xu2001.run(xu2001.shipped_unknowns(law), arc()))
        show(f"{'':4}{'friction law ' + law:<36}{gap(found):12.3f}{'':8}{_numbers(1e6 * found[:, 0])}")
    seeds = [columns(xu2001.run(unknowns, arc(), seed=seed))[:, 0] for seed in range(10)]
    show(f"{'':4}spread of e_M over ten seeds of the encoder noise (um){_numbers(1e6 * np.std(seeds, axis=0))}")
    _robust_terms(show)
    _compare(unknowns, show)
    _limits(unknowns, show)


if __name__ == "__main__":
    sys.exit(run_study(__doc__, main))
