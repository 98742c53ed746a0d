"""The setup of Lu, Chen, Yao, Wang 2008: two axes of a gantry, their DCARC with a B-spline cogging model, the moves.

Sources are cited as (Table n), (eq. n), (section). Values that the paper does not report are assumed and marked as
such. It shows the cogging maps only as pictures (Figs. 5, 6): their amplitudes are fitted to the tables within the
printed bound (studies.lu2008.calibration).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cogging import _core
from cogging._core import AdaptiveRobustParameters, CoggingModel, Dcarc, Plant, PointToPoint, SplineHarmonics
from cogging.arrays import FloatArray
from cogging.files import shipped_toml
from cogging.logs.log import Log
from cogging.papers.result import with_tuples
from cogging.simulation.batch import Batch, closed_loop_batch

PITCH = 0.05  # m (section "System Identification": P = 50 mm)
TRAVEL = (0.0, 0.51)  # m (section "Experimental Setup")
RESOLUTION = 0.5e-6  # m (section "Experimental Setup")
SAMPLE_RATE = 5000.0  # Hz (sections "Comparative Experimental Results")
HARMONICS = (1, 2, 3, 6, 12)  # significant in the FFT of the measured maps (section "System Identification")
ORDER = 3  # third-order B-splines (same section)
CONTROL_POINTS = 13  # m for 0.51 m at one pitch and order 3: m - k + 1 >= 10.2 spans

# Not reported, assumed; studies.lu2008.study shows the effect of each.
COULOMB_WIDTH = 1.0 / 900.0  # m/s: S_f = (2/pi) atan(900 v), as in Xu and Yao 2001, of the same group
DWELL = 0.1  # s
START = 0.055  # m: centres the 0.4 m move in the travel
#: e' of p (15) is the difference of e. As the reading's difference minus x_d', which is half a sample younger, p is
#: wrong by a T / 2 on ramps: the largest errors on X are then there, and are no whole counts as the printed ones are.
ERROR_DIFFERENCE = True

CONTROLLERS = ("C1", "C2", "C3")
ESTIMATED = ("mass", "viscous", "coulomb", "disturbance")  # theta_1, theta_2, theta_3, theta_5
#: Fits that come with the package: that of the tables, and the same family with the other reading of e'.
PRESENT, LATE = "present", "late"
#: Periodic, modulated and uncompensated part of a map, V.
Amplitudes = tuple[float, float, float]


@dataclass(frozen=True)
class GantryAxis:
    """One axis of the gantry: printed numbers of motor, controllers and experiment, and assumed ones of the move."""

    name: str  # "X" or "Y"
    table: str  # id of its table
    mass: float  # V/(m/s^2) (section "System Identification")
    viscous: float  # V/(m/s) (same section)
    coulomb: float  # V (same section)
    bounds: tuple[tuple[float, float], ...]  # of M, B, A_f, d (sections "Comparative Experimental Results")
    cogging_bound: float  # V, of every coefficient of A_r (same sections)
    error_gain: float  # k_1, 1/s (same sections)
    feedback_gain: float  # k_s1, V/(m/s) (same sections)
    compensated: tuple[int, ...]  # harmonics in C3 (same sections); assumed in C2, whose are not reported
    velocity: float  # m/s, limit of the move (same sections)
    acceleration: float  # m/s^2 (same sections)
    jerk: float  # m/s^3, assumed
    repeats: int  # moves there and back, assumed; the indexes are of the last
    error_max: tuple[float, float, float]  # m, of C1, C2, C3 (Table 1 or 2)
    error_rms: tuple[float, float, float]  # m (Table 1 or 2)


#: The axes by name (axes.toml).
_STATED = with_tuples(shipped_toml("papers/lu2008/axes.toml"))
AXES = {name: GantryAxis(name=name, **fields) for name, fields in _STATED.items()}


def cogging_basis(harmonics: Sequence[int] = HARMONICS) -> SplineHarmonics:
    """Return the basis of a map: harmonics of the pitch with third-order B-splines over the travel."""
    return SplineHarmonics(
        pitch=PITCH, harmonics=list(harmonics), order=ORDER, origin=TRAVEL[0], control_points=CONTROL_POINTS
    )


@dataclass(frozen=True)
class MapShape:
    """What makes an assumed map beside its three amplitudes; none of it is reported.

    F(x) = sum_h f_h(x) sin(2 pi h (x / P + shift)), V. f_h = (periodic + modulated a(s)) / h^decay for a compensated
    harmonic, uncompensated (1 + a(s) / 2) / h^decay for another, with a(s) = cos(pi half_waves s + begin), where s runs
    from 0 at the first magnet to 1 at the last.
    """

    decay: float  # exponent by which harmonics fall with their number
    half_waves: float  # of the modulation, from the first magnet to the last
    begin: float  # rad, phase of the modulation at the first magnet
    shift: float  # pitches from a zero of all sines to the first magnet; 1/8 shares the fundamental with its cosine


def control_points(
    shape: MapShape, amplitudes: Amplitudes, harmonics: Sequence[int], compensated: Sequence[int], count: int
) -> tuple[FloatArray, FloatArray]:
    """Return the control points (V) of sines and cosines of a map, (harmonics, count) each, also outside the travel."""
    periodic, modulated, uncompensated = amplitudes
    number = np.array(harmonics, dtype=float)
    # s = 0 and 1 at the control points 1 and count - 1.
    along = np.cos(np.pi * shape.half_waves * (np.arange(count) - 1) / (count - 2) + shape.begin)
    known = np.isin(harmonics, compensated)[:, None]
    strength = np.where(known, periodic + modulated * along, uncompensated * (1 + along / 2))
    strength = strength / number[:, None] ** shape.decay
    phase = 2 * np.pi * number[:, None] * shape.shift
    return strength * np.cos(phase), strength * np.sin(phase)


def cogging_map(axis: GantryAxis, amplitudes: Amplitudes, shape: MapShape | None = None) -> CoggingModel:
    """Return the assumed map of an axis; shape: None for the shipped one."""
    points = control_points(shape or shipped_shape(), amplitudes, HARMONICS, axis.compensated, CONTROL_POINTS)
    return CoggingModel(cogging_basis(), *points)


def share_of_bound(axis: GantryAxis, cogging: CoggingModel) -> float:
    """Return the largest control point of a compensated harmonic over the printed bound of A_r."""
    compensated = np.isin(HARMONICS, axis.compensated)
    return float(np.abs([cogging.sine[compensated], cogging.cosine[compensated]]).max() / axis.cogging_bound)


def shipped_shape() -> MapShape:
    """Return the shape of both maps (maps.toml, by studies.lu2008.calibration)."""
    return MapShape(**shipped_toml("papers/lu2008/maps.toml")["shape"])


def shipped_amplitudes(axis: GantryAxis, fit: str = PRESENT) -> Amplitudes:
    """Return the calibrated amplitudes of a fit in maps.toml, V."""
    part = shipped_toml("papers/lu2008/maps.toml")[fit][axis.name]
    return part["periodic"], part["modulated"], part["uncompensated"]


def plant(axis: GantryAxis, cogging: CoggingModel | None, effects: Sequence[Any] = (), **axis_changes: Any) -> Plant:
    """Return the machine (eq. 1, 2): nominal mass and friction, a cogging map, further effects, the 0.5 um encoder."""
    friction = {"viscous": axis.viscous, "coulomb": axis.coulomb, "coulomb_width": COULOMB_WIDTH}
    nominal = _core.AxisParameters(mass=axis.mass, travel=list(TRAVEL), **friction)
    encoder = _core.EncoderParameters(resolution=RESOLUTION)
    return Plant(nominal.replace(**axis_changes), cogging=cogging, effects=list(effects), encoder=encoder)


def controller_parameters(
    axis: GantryAxis, name: str, *, periodic: Sequence[int] = (), **changes: Any
) -> AdaptiveRobustParameters:
    """Return the parameters of C1 (no cogging compensation), C2 (periodic) or C3 (B-spline), all printed numbers.

    Not reported, assumed: k_s1 alone (no u_s2), nominal initial estimates, harmonics of C2 as of C3 unless `periodic`.
    """
    fields: dict[str, Any] = {name: getattr(axis, name) for name in ("error_gain", "feedback_gain", *ESTIMATED[:3])}
    for estimate, bound, rate in zip(ESTIMATED, axis.bounds, (1.0, 10.0, 10.0, 1000.0), strict=True):
        fields |= {f"{estimate}_bounds": list(bound), f"{estimate}_adaptation": rate}
    if name != "C1":
        harmonics, points = (name == "C2" and periodic) or axis.compensated, CONTROL_POINTS if name == "C3" else 1
        fields |= {"cogging_pitch": PITCH, "cogging_harmonics": list(harmonics), "cogging_origin": TRAVEL[0]}
        fields |= {"cogging_order": ORDER, "cogging_control_points": points, "cogging_adaptation": 100.0}
        fields["cogging_bounds"] = [-axis.cogging_bound, axis.cogging_bound]
    own = {"sample_rate": SAMPLE_RATE, "coulomb_width": COULOMB_WIDTH, "error_difference": ERROR_DIFFERENCE}
    return AdaptiveRobustParameters(**{**own, **fields, **changes})


def reference(axis: GantryAxis, **changes: Any) -> PointToPoint:
    """Return the moves of 0.4 m there and back (sections "Comparative Experimental Results")."""
    limits = {"velocity": axis.velocity, "acceleration": axis.acceleration, "jerk": axis.jerk}
    moves = _core.PointToPointParameters(start=START, distance=0.4, dwell=DWELL, repeats=axis.repeats, **limits)
    return PointToPoint(moves.replace(**changes))


def run(
    axis: GantryAxis, machine: Plant, motion: PointToPoint | None = None, *, steps_per_sample: int = 1, **changes: Any
) -> dict[str, Log]:
    """Return the logs of C1, C2 and C3 on the same machine; changes: of the controllers."""
    controllers = [Dcarc(controller_parameters(axis, name, **changes)) for name in CONTROLLERS]
    machines, options = [machine] * len(controllers), dict[str, Any](steps_per_sample=steps_per_sample, logs=True)
    batch = closed_loop_batch(machines, controllers, motion or reference(axis), **options)
    return dict(zip(CONTROLLERS, batch, strict=True))


def last_move(controllers: Sequence[Any], machines: Sequence[Plant], motion: PointToPoint) -> Batch:
    """Run controllers on machines, pair by pair; return the indexes of the last move, or raise DivergedError."""
    start, seeds = motion.end - motion.period, [0] * len(machines)
    batch = closed_loop_batch(list(machines), list(controllers), motion, seeds=seeds, start=start)
    for failure in batch.failures:
        raise _core.DivergedError(failure.reason)
    return batch


def last_errors(
    axis: GantryAxis, machines: Sequence[Plant], motion: PointToPoint | None = None, **changes: Any
) -> FloatArray:
    """Return e_inf and e_2 (m) of C1, C2 and C3 on each machine, (machines, 3, 2); changes: of the controllers."""
    controllers = [Dcarc(controller_parameters(axis, name, **changes)) for name in CONTROLLERS]
    every = [controller for controller in controllers for _ in machines]
    batch = last_move(every, [*machines] * len(controllers), motion or reference(axis))
    found = [batch.indexes[name].reshape(len(controllers), len(machines)) for name in ("error_max", "error_rms")]
    return np.array(found).transpose(2, 1, 0)


def last_performance(log: Log, motion: PointToPoint) -> _core.Performance:
    """Return the indexes of the last move there and back."""
    return _core.performance(log.time, log.error, log.command, start=motion.end - motion.period)


def indexes(log: Log, motion: PointToPoint) -> tuple[float, float]:
    """Return e_inf and e_2 (m): maximum and rms of reading minus reference over the last move there and back."""
    found = last_performance(log, motion)
    return found.error_max, found.error_rms
