"""What robustness costs in Malaize and Levine 2009: `python -m studies.malaize2009.study [DIR]`.

Prints lambda* over decay rate, pole radius and velocity range, the largest decay rates, what a gain that grows with
the velocity adds, the decay of random machines inside the certificate, and the multiple of lambda* at which a
trajectory really diverges. Needs the extra `design`. With DIR, the sweep is drawn there.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import cogging
from cogging.design.observer import ObserverDesign, design_observer, largest_decay_rate
from cogging.outputs import write_bytes
from cogging.papers.malaize2009.linear_motors import MOTORS, SAMPLE_RATE, VISCOUS, Motor, problem, true_error
from cogging.plot.canvas import drawn, new_figure, png
from studies.command import run_study

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RADII = (350.0, 420.0, 500.0, 700.0)
DECAY_RATES = (0.0, 1.0, 3.0)
RATIOS = (0.1, 0.25, 0.5)
SHARE = 0.95  # of the certified bound, that a random machine takes


def certified(motor: Motor, alpha: float, ratio: float, radius: float) -> float:
    """lambda* (m/s^2, all equal) by decay rate (1/s), velocity ratio and pole radius (1/s); NaN where not certified."""
    try:
        task = problem(motor, radius, decay_rate=alpha, velocity_min=ratio * motor.velocity)
        return design_observer(task).lambda_equal
    except ValueError:
        return float("nan")


def long_stroke(motor: Motor, amplitudes: np.ndarray, phases: np.ndarray, design: ObserverDesign) -> cogging.Log:
    """Run along 4 m in one direction without friction, quantiser and delay: what the certificate speaks of."""
    parameters = cogging.ObserverBasedParameters(
        sample_rate=SAMPLE_RATE,
        periods=list(motor.periods),
        observer_gain=list(design.observer_gain),
        observer_gain_slope=list(design.observer_gain_slope),
        position_gain=design.position_gain,
        velocity_gain=design.velocity_gain,
        viscous=VISCOUS,
        velocity_min=0.01 * motor.velocity,
    )
    sine, cosine = -(amplitudes * np.cos(phases))[:, None], -(amplitudes * np.sin(phases))[:, None]
    machine = cogging.Plant(
        cogging.AxisParameters(mass=1.0, viscous=VISCOUS, travel=[-1.0, 5.0]),
        cogging=cogging.CoggingModel(cogging.SplineHarmonics(periods=list(motor.periods)), sine, cosine),
    )
    motion = cogging.PointToPoint(
        cogging.PointToPointParameters(distance=4.0, velocity=motor.velocity, acceleration=motor.acceleration)
    )
    return cogging.closed_loop(machine, cogging.ObserverBased(parameters), motion, duration=4.0 / motor.velocity)


def decay(motor: Motor, design: ObserverDesign, seed: int) -> float:
    """The rate (1/s) at which the error of a random machine inside the certificate decays at speed.

    Its sqrt(sum (lambda_n / P_n)^2) is SHARE of the design's gamma_n; `seed` is that of amplitudes and phases.
    """
    random = np.random.default_rng([2009, seed])
    amplitudes = random.uniform(0.1, 1.0, len(motor.periods))
    amplitudes *= SHARE * design.gamma_n / np.sqrt(np.sum((amplitudes / np.array(motor.periods)) ** 2))
    phases = random.uniform(0, 2 * np.pi, amplitudes.size)
    log = long_stroke(motor, amplitudes, phases, design)
    # The envelope from 0.3 s (at speed) to where the error has fallen a thousandfold or reached the sampling's floor.
    error, window = np.abs(true_error(log)), round(0.1 * SAMPLE_RATE)
    envelope = error[: error.size // window * window].reshape(-1, window).max(axis=1)[3:]
    floor = max(1e-3 * envelope[0], 3.0 * float(np.median(envelope[-10:])))
    last = int(np.argmax(envelope < floor)) if (envelope < floor).any() else envelope.size - 1
    return float(np.log(envelope[0] / envelope[max(last, 1)]) / (0.1 * max(last, 1)))


def divergence_multiple(motor: Motor, design: ObserverDesign) -> float:
    """The multiple of lambda* (all equal) from which a cold trajectory leaves its travel or no longer settles."""

    def settles(multiple: float) -> bool:
        amplitudes = np.full(len(motor.periods), multiple * design.lambda_equal)
        try:
            log = long_stroke(motor, amplitudes, np.arange(amplitudes.size) * 1.0, design)
        except cogging.DivergedError:
            return False
        error = np.abs(true_error(log))
        third = error.size // 3
        return bool(error[-third:].max() < 0.5 * error[:third].max())

    low, high = 1.0, 2.0
    while settles(high) and high < 1000.0:
        low, high = high, 2.0 * high
    for _ in range(6):
        middle = np.sqrt(low * high)
        low, high = (middle, high) if settles(middle) else (low, middle)
    return low


@drawn
def figure_sweep() -> Figure:
    """lambda* against the pole radius, by decay rate and velocity ratio."""
    figure = new_figure((8.0, 6.0))
    figure.suptitle("What the robustness costs: certified lambda* (m/s^2) against the bound on the poles")
    for axes, motor in zip(figure.subplots(2, 1), MOTORS.values(), strict=True):
        for place, alpha in enumerate(DECAY_RATES):
            for ratio, style in zip(RATIOS, (":", "--", "-"), strict=True):
                values = [certified(motor, alpha, ratio, radius) for radius in RADII]
                label = f"alpha {alpha:g} 1/s, ratio {ratio:g}"
                axes.loglog(RADII, values, f"o{style}", color=f"C{place}", markersize=3, label=label)
        axes.set(ylabel=motor.name, xlabel="pole radius (1/s)")
    figure.axes[0].legend(fontsize="x-small", ncols=3)
    return figure


def main(folder: str = "", show: Callable[[str], None] = print) -> None:
    """Print the study; draw the sweep into a folder where one is given."""
    for motor in MOTORS.values():
        base = problem(motor, 500.0)
        show(f"{motor.name}: lambda* (mm/s^2, all equal) at alpha 3 1/s, velocity ratio 0.25")
        for radius in RADII:
            constant = design_observer(replace(base, pole_radius=radius))
            affine = design_observer(replace(base, pole_radius=radius, affine=True))
            gained = affine.lambda_equal / constant.lambda_equal - 1.0
            show(
                f"    r {radius:6g} 1/s: {1e3 * constant.lambda_equal:8.0f}, one period alone "
                f"{1e3 * constant.lambda_alone:8.0f}, K affine in nu* {gained:+.0%}; "
                f"condition {constant.condition:.0f}, slowest pole {constant.slowest_pole:.1f}, "
                f"at rest {constant.slowest_pole_at_rest:.1f} 1/s"
            )
        rates = ", ".join(
            f"{largest_decay_rate(replace(base, velocity_min=ratio * motor.velocity)):.2g} at {ratio:g}"
            for ratio in (0.05, *RATIOS)
        )
        show(f"    largest certified decay rate (1/s) by velocity ratio, r 500 1/s: {rates}")
        design = design_observer(base)
        slowest = min(decay(motor, design, seed) for seed in range(10))
        show(f"    slowest decay of 10 random machines at 95 % of gamma_N*: {slowest:.1f} 1/s (certified 3)")
        show(f"    a cold trajectory fails from {divergence_multiple(motor, design):.0f} times lambda*")
    if folder:
        path = Path(folder) / "malaize2009_sweep.png"
        write_bytes(path, png(figure_sweep()))
        show(f"{path} written")


if __name__ == "__main__":
    sys.exit(run_study(__doc__, main, "", "folder of the sweep's figure; without it none is drawn"))
