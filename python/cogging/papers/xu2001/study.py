"""What the printed numbers of Xu and Yao 2001 explain and what not: `python -m cogging.papers.xu2001.study [DIR]`.

Exploratory, never mixed with Table 1: which change of the controller's numbers brings the ARC columns near the
printed ones, why the printed robust terms cannot run, and where ARC is better than the PID and where not. With DIR, a
figure of the command increment against the robust terms is written there.
"""

from __future__ import annotations

import io
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging import effects
from cogging._core import (
    AxisParameters,
    DivergedError,
    EncoderParameters,
    OutputFeedbackArc,
    Pid,
    Plant,
    PointToPoint,
    PointToPointParameters,
    closed_loop,
)
from cogging.arrays import FloatArray
from cogging.logs.log import Log
from cogging.model.model import Controller
from cogging.outputs import write_bytes
from cogging.papers.xu2001.setup import (
    DURATION,
    INDEXES,
    MASSES,
    SETS,
    TABLE_1,
    VISCOUS,
    Unknowns,
    arc_parameters,
    fast_reference,
    indexes,
    pid_parameters,
    plant,
    reference,
    run,
    shipped_unknowns,
)
from cogging_command import run_command

if TYPE_CHECKING:
    from matplotlib.figure import Figure

JUDGED = ("e_M", "e_F", "e_rms", "u_rms", "c_u")
ROBUST_TERMS = (
    "use_alpha_1s2",
    "use_alpha_1s3",
    "use_c_phi_1",
    "use_c_theta_2",
    "use_c_phi_2",
    "use_u_s2",
    "use_u_s3",
)


def columns(controller: Controller, unknowns: Unknowns, seed: int = 2001) -> FloatArray:
    """The judged indexes of a controller in the three sets, (3, 5).

    Raises:
        DivergedError: a run diverged.
    """
    logs = run(unknowns, controller, seed=seed)
    return np.array([[indexes(logs[name])[index] for index in JUDGED] for name in SETS])


def printed(controller: str) -> FloatArray:
    """The same of Table 1, (3, 5)."""
    return np.array([[TABLE_1[controller][name][INDEXES.index(index)] for index in JUDGED] for name in SETS])


def gap(found: FloatArray, controller: str = "ARC") -> float:
    """The rms log-ratio to the printed column."""
    return float(np.sqrt(np.mean(np.log(found / printed(controller)) ** 2)))


def changes() -> dict[str, dict[str, Any]]:
    """The changes of the ARC's numbers that are tried, each alone and some together."""
    base = arc_parameters()

    def adaptation(factor: float) -> dict[str, Any]:
        return {"adaptation": [factor * rate for rate in base.adaptation]}

    def gains(factor: float) -> dict[str, Any]:
        return {"gain_1": factor * base.gain_1, "gain_2": factor * base.gain_2}

    observer = {"observer_gain_1": 2 * base.observer_gain_1, "observer_gain_2": 4 * base.observer_gain_2}
    together = {
        "adaptation x 3.5": adaptation(3.5),
        "gains x 1.2": gains(1.2),
        "theta_1(0) = 37": {"theta": [37.0, 10.0, 0.0]},
        "theta_1(0) = 20": {"theta": [20.0, 10.0, 0.0]},
    }
    return {
        "as printed, g only": {},
        "adaptation x 2": adaptation(2.0),
        **together,
        "adaptation x 5": adaptation(5.0),
        "gains x 0.8": gains(0.8),
        "observer poles at -400": observer,
        "with the C_phi1 term": {"use_c_phi_1": True},
        "Euler steps of the filters": {"filter_steps": "euler"},
        "no friction compensation": {"coulomb": 0.0},
        "adaptation x 3.5, gains x 1.2": {**adaptation(3.5), **gains(1.2)},
        "adaptation x 3.5, theta_1(0) = 20": {**adaptation(3.5), "theta": [20.0, 10.0, 0.0]},
        "all three": {**adaptation(3.5), **gains(1.2), "theta": [20.0, 10.0, 0.0]},
    }


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


def explore(unknowns: Unknowns) -> dict[str, float]:
    """The gap of the ARC columns for each of the changes; infinite where a run diverges."""
    found = {}
    for name, change in changes().items():
        try:
            found[name] = gap(columns(OutputFeedbackArc(arc_parameters(**change)), unknowns))
        except DivergedError:
            found[name] = float("inf")
    return found


#: Sampling rate (Hz) and resolution (m) at which the robust terms are tried.
HARDWARE = ((2500.0, 1e-6), (20_000.0, 1e-8), (200_000.0, 1e-10))
FACTORS = (0.0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0)


def figure_increment() -> Figure:
    """The rms command increment against a common factor on the printed robust terms."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 4.0), layout="constrained")
    axes = figure.subplots()
    for rate, resolution in HARDWARE:
        values = [increment(factor, rate, resolution) for factor in FACTORS[1:]]
        axes.loglog(FACTORS[1:], values, "o-", label=f"{rate / 1000:g} kHz, {1e9 * resolution:g} nm")
    axes.axhline(TABLE_1["ARC"]["1"][4], color="black", linestyle=":", label="paper: 0.06 V")
    axes.set(xlabel="factor on the printed robust terms", ylabel="rms command increment (V)")
    axes.set_title("A line ends where the run diverges")
    axes.legend()
    return figure


def loses_stability(make: Callable[[], Controller], mass: float) -> tuple[float, float]:
    """The delay (s) from which a small oscillation grows, and its frequency (Hz), on a rigid axis without friction."""

    def grows(delay: float) -> tuple[bool, float]:
        machine = Plant(
            AxisParameters(mass=mass, viscous=VISCOUS, travel=[-1.0, 1.0]),
            effects=[effects.CommandDelay(delay=delay)],
        )
        rest = PointToPoint(PointToPointParameters(distance=1e-9, velocity=1.0, acceleration=1.0))
        try:
            log = closed_loop(machine, make(), rest, duration=1.0, initial_position=1e-6)
        except DivergedError:
            return True, float("nan")
        error = log["position"] - log["reference"]
        early, late = error[500:1500], error[1500:2500]
        spectrum = np.abs(np.fft.rfft(late * np.hanning(late.size)))
        frequency = float(np.argmax(spectrum[2:]) + 2) * 2500.0 / late.size
        return bool(np.std(late) > np.std(early)), frequency

    low, high = 0.0, 4e-3
    for _ in range(14):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if grows(middle)[0] else (middle, high)
    return low, grows(low)[1]


def integral_stiffness(controller: Controller, mass: float) -> float:
    """Force over the time integral of the error that it leaves, V/(m s), on a rigid axis without friction."""
    force = 0.05
    machine = Plant(
        AxisParameters(mass=mass, viscous=VISCOUS, travel=[-1.0, 1.0]),
        effects=[effects.DisturbanceStep(force=force, start=0.1)],
    )
    rest = PointToPoint(PointToPointParameters(distance=1e-9, velocity=1.0, acceleration=1.0))
    log = closed_loop(machine, controller, rest, duration=20.0)
    error = log["position"] - log["reference"]
    return force / float(error.sum() / 2500.0)


def sensitivities(unknowns: Unknowns) -> dict[str, tuple[Unknowns, Mapping[str, Any]]]:
    """The plants on which both controllers are compared."""
    mass = MASSES["1"]
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


def _compare(unknowns: Unknowns, show: Callable[[str], None]) -> None:
    show("Where ARC is better and where not: e_M and e_rms (um) in set 1")
    show(f"{'':4}{'plant':<22}{'PID e_M':>10}{'ARC e_M':>10}{'PID e_rms':>11}{'ARC e_rms':>11}")
    for name, (machine, axis) in sensitivities(unknowns).items():
        cells = []
        for controller in (Pid(pid_parameters()), OutputFeedbackArc(arc_parameters())):
            truth = plant(machine, "1", **axis)
            try:
                found = indexes(Log.of(closed_loop(truth, controller, reference(), duration=DURATION, seed=1)))
                cells.append((1e6 * found["e_M"], 1e6 * found["e_rms"]))
            except DivergedError:
                cells.append((np.inf, np.inf))
        (pid_max, pid_rms), (arc_max, arc_rms) = cells
        show(f"{'':4}{name:<22}{pid_max:10.1f}{arc_max:10.1f}{pid_rms:11.2f}{arc_rms:11.2f}")


def _limits(unknowns: Unknowns, show: Callable[[str], None]) -> None:
    show("Limits on a rigid axis without friction (frozen estimates for the ARC's delay)")
    for mass in (MASSES["1"], MASSES["2"]):
        for name, make in (
            ("PID", lambda: Pid(pid_parameters(coulomb=0.0))),
            ("PID at -320", lambda: Pid(pid_parameters(pole=-320.0, coulomb=0.0))),
            ("ARC", lambda mass=mass: OutputFeedbackArc(arc_parameters(coulomb=0.0, adaptation=[0.0] * 3))),
        ):
            delay, frequency = loses_stability(make, mass)
            show(f"{'':4}mass {mass:.3f}: {name:<12} unstable from {1e3 * delay:.3f} ms delay, at {frequency:.0f} Hz")
    for name, controller in (
        ("PID", Pid(pid_parameters(coulomb=0.0))),
        ("ARC", OutputFeedbackArc(arc_parameters(coulomb=0.0))),
    ):
        show(f"{'':4}integral stiffness of {name}: {integral_stiffness(controller, MASSES['1']):.3g} V/(m s)")
    for pole in (-300.0, -320.0):
        log = run(unknowns, Pid(pid_parameters(pole=pole)))["1"]
        show(
            f"{'':4}PID at {pole:g} on the calibrated plant ({1e3 * unknowns.delay:.2f} ms delay): stable, "
            f"e_M {1e6 * indexes(log)['e_M']:.1f} um"
        )


def _fast_motion(unknowns: Unknowns, show: Callable[[str], None]) -> None:
    show(
        "Case 2, fast point-to-point motion without load: largest error (um) moving and in the last 0.2 s of each rest"
    )
    motion = fast_reference()
    for name, controller in (("PID", Pid(pid_parameters())), ("ARC", OutputFeedbackArc(arc_parameters()))):
        log = Log.of(closed_loop(plant(unknowns, "1"), controller, motion, seed=1))
        since = np.mod(log.time, motion.period / 2.0)
        error, moving = 1e6 * np.abs(log.error), since < motion.move_time
        resting = since > motion.move_time + 0.3
        show(
            f"{'':4}{name}: moving {error[moving].max():.1f}, at rest {error[resting].max():.1f} (paper: ARC within 1)"
        )


def main(folder: str | None = None, show: Callable[[str], None] = print) -> None:
    """Print the study; write its figure into a folder where one is given."""
    unknowns = shipped_unknowns()
    show("ARC columns against the paper's, on the plant calibrated on the PID columns (exploratory)")
    show(f"{'':4}{'change':<36}{'rms log gap':>12}{'closed':>8}   e_M of sets 1, 2, 3 (um); paper 14.4, 113, 55.9")
    explored = explore(unknowns)
    for name, change in changes().items():
        size = explored[name]
        if np.isinf(size):
            show(f"{'':4}{name:<36}{'diverges':>12}")
            continue
        found = columns(OutputFeedbackArc(arc_parameters(**change)), unknowns)
        closed = 1.0 - size / explored["as printed, g only"]
        show(f"{'':4}{name:<36}{size:12.3f}{closed:8.0%}{_numbers(1e6 * found[:, 0])}")
    for law in ("smooth_stribeck", "smooth_coulomb", "exact_stribeck", "exact_coulomb"):
        found = columns(OutputFeedbackArc(arc_parameters()), shipped_unknowns(law))
        show(f"{'':4}{'friction law ' + law:<36}{gap(found):12.3f}{'':8}{_numbers(1e6 * found[:, 0])}")
    seeds = [columns(OutputFeedbackArc(arc_parameters()), unknowns, seed=seed)[:, 0] for seed in range(10)]
    show(f"{'':4}spread of e_M over ten seeds of the encoder noise (um){_numbers(1e6 * np.std(seeds, axis=0))}")

    show("Rms command increment (V) with the printed robust terms times a factor; inf = diverges")
    show(f"{'':4}{'hardware':<24}" + _numbers(FACTORS))
    for rate, resolution in HARDWARE:
        values = [increment(factor, rate, resolution) for factor in FACTORS]
        show(f"{'':4}{f'{rate / 1000:g} kHz, {1e9 * resolution:g} nm':<24}" + _numbers(values))

    show("The printed robust terms in full, ideal encoder, first 2 ms: rms increment (V) by sampling rate (Hz)")
    rates = (1e6, 1e7, 1e8, 1e9)
    show(f"{'':4}" + _numbers(rates))
    show(f"{'':4}" + _numbers([increment(1.0, rate, 0.0, duration=0.002) for rate in rates]))
    jumps = ", ".join(f"{abs(one_count(resolution)):.3g} V by {1e9 * resolution:g} nm" for resolution in (1e-6, 1e-10))
    show(f"{'':4}one encoder count moves the command, at rest: {jumps}")

    _compare(unknowns, show)
    _limits(unknowns, show)
    _fast_motion(unknowns, show)
    if folder is not None:
        path = Path(folder) / "xu2001_increment.png"
        picture = io.BytesIO()
        figure_increment().savefig(picture, format="png", dpi=120)
        write_bytes(path, picture.getvalue())
        show(f"{path} written")


if __name__ == "__main__":
    sys.exit(run_command(lambda: main(sys.argv[1] if len(sys.argv) > 1 else None)))
