"""The speed ripple of a motor that cogs, predicted: three logs, the closed loop that follows, and variants of it.

In radians and amperes, so mass is J/Kt in A/(rad/s^2).
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cogging import effects
from cogging._core import AxisParameters, CoggingModel, SplineHarmonics
from cogging._core.controllers import SpeedParameters
from cogging._core.references import Sampled
from cogging.arrays import FloatArray
from cogging.datasets import laas
from cogging.datasets.laas import SPEED_LOOP, TURN, RotaryLog
from cogging.mapping.fit_map import MapFit, fit_map
from cogging.model.model import Model
from cogging.simulation.run import simulate
from studies.laas import motor

SHOWN = 0.2  # s: what a run shows before is its start
LEVELS = np.linspace(0.01, 0.99, 99)


@dataclass(frozen=True)
class Loop:
    """The closed loop: cogging, axis and the velocity loop as its two delays see it."""

    cogging_map: CoggingModel | None
    mass: float
    viscous: float
    coulomb: float
    gain: float = SPEED_LOOP["gain"]  # A/(rad/s)
    reference: float = SPEED_LOOP["reference"]  # rad/s
    delay: float = SPEED_LOOP["delay"]  # s, from a speed to its current, on top of a difference over one sample
    lag: float = 0.0  # s, first order
    effects: tuple[Any, ...] = ()

    def model(self, sample_rate: float = 1000.0) -> Model:
        """The loop as a model."""
        lag = (effects.ActuatorLag(time_constant=self.lag),) if self.lag > 0 else ()
        return Model(
            axis=AxisParameters(mass=self.mass, viscous=self.viscous, coulomb=self.coulomb),
            cogging=self.cogging_map,
            effects=(*self.effects, *lag),
            controller=SpeedParameters(sample_rate=sample_rate, kp=self.gain, delay=self.delay),
            controller_type="speed",
        )

    def run(self, rows: RotaryLog, window: tuple[float, float], duration: float | None = None) -> RotaryLog:
        """The speed over `duration` (s; that of the rows), from the first row on, with the drive's own speed."""
        duration = rows.time[-1] - rows.time[0] if duration is None else duration
        ends = np.array([0.0, 0.5, 1.0]) * (duration + 1.0)
        log = simulate(
            self.model(),
            Sampled(time=ends, position=self.reference * ends, velocity=np.full(3, self.reference)),
            duration=duration,
            steps_per_sample=4,
            initial_position=rows.position[0],
            initial_velocity=rows.velocity[0],
        )
        assert log.true_position is not None  # a simulated log has it
        speed = motor.mean_velocity(log.time, log.true_position, *window)
        return RotaryLog(log.time, log.true_position, speed, log.command)


def effective_delay(window: tuple[float, float], law_delay: float, lateness: float) -> tuple[float, float]:
    """Delay and lag (s) of Loop that stand for the drive's: the mean over `window` and two waiting times.

    A mean over a width has the delay start + width/2 and the spread width/sqrt(12), which a first-order lag of that
    time constant has too. The loop's own difference over a sample and the hold take one sample between them.
    """
    start, width = window
    lag = width / np.sqrt(12.0)
    return start + 0.5 * width + law_delay - lateness - lag - 1e-3, lag


@dataclass(frozen=True)
class Ripple:
    """A speed in a few numbers (rad/s): mean, standard deviation, share of reversed rows, quantiles at LEVELS and the
    amplitude and phase (rad) of the part that repeats 72 times a turn."""

    mean: float
    deviation: float
    reversed: float
    quantiles: FloatArray
    detent: complex

    @classmethod
    def of(cls, rows: RotaryLog, kept: Any = slice(None)) -> Ripple:
        """Of the rows of a run that are kept."""
        x, v = rows.position[kept], rows.velocity[kept]
        waves = [part(h * x) for h in (12, 18, 24, 36, 72, 144) for part in (np.cos, np.sin)]
        c = np.linalg.lstsq(np.stack([np.ones_like(x), *waves], axis=1), v, rcond=None)[0]
        return cls(v.mean(), v.std(), (v < 0).mean(), np.quantile(v, LEVELS), complex(c[9], c[10]))

    def distance(self, other: Ripple) -> float:
        """The mean difference of the quantiles, rad/s (Wasserstein distance of order 1)."""
        return float(np.abs(self.quantiles - other.quantiles).mean())


@dataclass(frozen=True)
class Study:
    """Everything fitted (on the first half of the speed test and on the other two logs), and the variants to run."""

    speed_test: RotaryLog
    half: float  # s: rows before are fitted, rows after are predicted
    map_fit: MapFit
    axis: dict[str, motor.Estimate]
    window: tuple[float, float]
    law: tuple[float, float, float, float]
    lateness: tuple[float, float, float, float]

    @classmethod
    def make(cls, folder: str | os.PathLike[str] | None = None) -> Study:
        """Of the logs in `folder`, or where COGGING_DATA says."""
        scan, speed_test = laas.read("stopped_data", folder), laas.read("speed_test1", folder)
        half = 0.5 * speed_test.time[-1]
        fitted = speed_test.between(0.0, half)
        start, width, _ = motor.velocity_window(fitted)
        map_fit = fit_map(scan.position, scan.current, pitch=TURN)
        return cls(
            speed_test,
            half,
            map_fit,
            motor.axis_from_acceleration(laas.read("acc_current", folder)),
            (start, width),
            motor.speed_law(fitted),
            motor.current_lateness(fitted, map_fit.cogging),
        )

    @property
    def held_out(self) -> RotaryLog:
        """The second half of the speed test."""
        return self.speed_test.between(self.half, np.inf)

    @property
    def scan_coulomb(self) -> float:
        """Coulomb level of the slow scan, A."""
        assert self.map_fit.coulomb is not None  # it goes both ways
        return self.map_fit.coulomb

    def variants(self) -> dict[str, Loop]:
        """Loops by name: from the description of the data to everything that the logs say, one change at a time.

        All but the last are predictions from the scan, the acceleration log and the first half of the speed test's
        rows, in which no speed was simulated; the last one's delay is chosen by simulating the first half.
        """
        gain, reference, law_delay, _ = self.law
        delay, lag = effective_delay(self.window, law_delay, self.lateness[0])
        still, scale = self.map_fit.cogging, self.lateness[2]
        moving = CoggingModel(still.basis, scale * still.sine, scale * still.cosine)
        changes: dict[str, dict[str, Any]] = {
            "no cogging": {"cogging_map": None},
            "+ cogging of the static map": {"cogging_map": still},
            "+ Coulomb level in motion": {"coulomb": self.axis["coulomb"].value},
            "+ gain and reference as logged": {"gain": gain, "reference": reference},
            "+ delay of the measured speed": {"delay": delay + lag},
            "+ its form, a mean over 3 ms": {"delay": delay, "lag": lag},
            "+ map as large as in motion": {"cogging_map": moving},
        }
        loop = Loop(None, self.axis["mass"].value, self.axis["viscous"].value, self.scan_coulomb)
        loops: dict[str, Loop] = {}
        for name, change in changes.items():
            loop = loops[name] = replace(loop, **change)
        loops["+ delay tuned on the first half"] = self.tuned(loop)
        return loops

    def tuned(self, loop: Loop) -> Loop:
        """The loop with the delay, within 0.3 ms, whose speed comes closest to that of the first half."""
        rows = self.speed_test.between(0.0, self.half)
        measured = Ripple.of(rows, motor.settled(rows))
        candidates = [replace(loop, delay=loop.delay + more) for more in np.arange(-0.3, 0.31, 0.05) * 1e-3]
        runs = [candidate.run(rows, self.window) for candidate in candidates]
        return candidates[int(np.argmin([Ripple.of(run, run.time > SHOWN).distance(measured) for run in runs]))]

    def alternatives(self) -> dict[str, Loop]:
        """The loop predicted from the logs with one thing changed: what else could have closed the distance."""
        full = self.variants()["+ map as large as in motion"]
        assert full.cogging_map is not None
        leading = self.map_fit.cogging.basis.harmonics.index(72)
        parts = (full.cogging_map.sine[[leading]], full.cogging_map.cosine[[leading]])
        only = CoggingModel(SplineHarmonics(pitch=TURN, harmonics=[72]), *parts)
        rise = effects.StribeckFriction(static_excess=self.scan_coulomb - full.coulomb, velocity=2.0)
        return {
            "as predicted": full,
            "Coulomb level of the static scan": replace(full, coulomb=self.scan_coulomb),
            "that at rest, the other in motion": replace(full, effects=(rise,)),
            "Coulomb level 0.03 A asymmetric": replace(full, effects=(effects.CoulombAsymmetry(difference=0.03),)),
            "Stribeck excess of 0.03 A": replace(full, effects=(rise.replace(static_excess=0.03),)),
            "delay of the description, 2 ms": replace(full, delay=SPEED_LOOP["delay"], lag=0.0),
            "delay 0.1 ms shorter": replace(full, delay=full.delay - 1e-4),
            "delay 0.1 ms longer": replace(full, delay=full.delay + 1e-4),
            "gain 0.09": replace(full, gain=SPEED_LOOP["gain"]),
            "only the 72nd harmonic": replace(full, cogging_map=only),
            "J of the speed test": replace(full, mass=self.lateness[3]),
        }

    def table(self, loops: Mapping[str, Loop]) -> tuple[str, dict[str, Ripple]]:
        """A line a loop beside the held-out half of the log, and Ripple by name."""
        measured = Ripple.of(self.held_out, motor.settled(self.held_out))
        ripples = {"measured (held out)": Ripple.of(self.held_out), "  without lost packets": measured}
        for name, loop in loops.items():
            run = loop.run(self.held_out, self.window)
            ripples[name] = Ripple.of(run, run.time > SHOWN)
        lines = ["                                    mean  deviation  reversed  detent  distance (rad/s)"]
        for name, r in ripples.items():
            lines.append(
                f"{name:33s} {r.mean:6.2f} {r.deviation:10.2f} {r.reversed:9.1%} {abs(r.detent):7.2f}"
                f" {r.distance(measured):9.2f}"
            )
        return "\n".join(lines), ripples
