"""Lu, Chen, Yao, Wang 2008: DCARC with a B-spline cogging model on the two axes of a gantry (Tables 1 and 2).

Sources are cited as (Table n), (eq. n), (section). What the paper does not report is assumed and says so; the three
amplitudes of each cogging map are calibrated on the three rms values (lu2008_calibration.py), the maxima then follow.
"""

from __future__ import annotations

import importlib.resources
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging._core import (
    AdaptiveRobustParameters,
    AxisParameters,
    BSpline,
    CoggingModel,
    Dcarc,
    EncoderParameters,
    Plant,
    PointToPoint,
    PointToPointParameters,
    SplineHarmonics,
    closed_loop_batch,
    performance,
)
from cogging.arrays import FloatArray
from cogging.files import parse_toml
from cogging.logs.log import Log
from cogging.mapping.fit import fit_map
from cogging.papers.result import Reproduction, Row, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PITCH = 0.05  # m (section "System Identification": P = 50 mm)
TRAVEL = (0.0, 0.51)  # m (section "Experimental Setup")
RESOLUTION = 0.5e-6  # m (section "Experimental Setup")
SAMPLE_RATE = 5000.0  # Hz (sections "Comparative Experimental Results")
HARMONICS = (1, 2, 3, 6, 12)  # those that the FFT of the measured maps shows (section "System Identification")
ORDER = 3  # third-order B-splines (same section)
CONTROL_POINTS = 13  # m for 0.51 m at one pitch and order 3: m - k + 1 >= 10.2 spans
SCAN_STEP = 0.001  # m: the maps were measured at 1 mm (same section)

# Not reported, assumed: which knob does what is shown by lu2008_study.py.
COULOMB_WIDTH = 1.0 / 900.0  # m/s: S_f = (2/pi) atan(900 v), as in Xu and Yao 2001, of the same group
DWELL = 0.1  # s
START = 0.055  # m: centres the 0.4 m move in the travel
SCAN_NOISE = 0.003  # V rms of the force sensor in Figs. 5 and 6

CONTROLLERS = ("C1", "C2", "C3")


@dataclass(frozen=True)
class GantryAxis:
    """One axis of the gantry: what is printed of its motor, its controllers and its experiment.

    Attributes:
        name: "X" or "Y".
        table: id of its table.
        mass, viscous, coulomb: V/(m/s^2), V/(m/s), V (section "System Identification").
        bounds: of M, B, A_f, d (sections "Comparative Experimental Results").
        cogging_bound: V, of every coefficient of A_r (same sections).
        error_gain, feedback_gain: k_1 (1/s), k_s1 (V/(m/s)) (same sections).
        compensated: harmonics in C3 (same sections); C2's are not reported, the same are assumed.
        velocity, acceleration: limits of the move, m/s, m/s^2 (same sections).
        jerk: m/s^3, assumed.
        repeats: moves there and back, assumed; the indexes are of the last.
        error_max, error_rms: m, of C1, C2, C3 (Table 1 or 2).
    """

    name: str
    table: str
    mass: float
    viscous: float
    coulomb: float
    bounds: tuple[tuple[float, float], ...]
    cogging_bound: float
    error_gain: float
    feedback_gain: float
    compensated: tuple[int, ...]
    velocity: float
    acceleration: float
    jerk: float
    repeats: int
    error_max: tuple[float, float, float]
    error_rms: tuple[float, float, float]


AXES = {
    "X": GantryAxis(
        name="X",
        table="table1",
        mass=0.12,
        viscous=0.166,
        coulomb=0.15,
        bounds=((0.1, 0.2), (0.15, 0.35), (0.1, 0.3), (-0.5, 0.5)),
        cogging_bound=0.1,
        error_gain=200.0,
        feedback_gain=400 * 0.12,
        compensated=(1, 2, 3),
        velocity=0.5,
        acceleration=10.0,
        jerk=1000.0,
        repeats=20,
        error_max=(1.6500e-5, 1.1000e-5, 6.9996e-6),
        error_rms=(8.3408e-6, 3.1064e-6, 2.3043e-6),
    ),
    "Y": GantryAxis(
        name="Y",
        table="table2",
        mass=0.64,
        viscous=0.24,
        coulomb=0.66,
        bounds=((0.5, 0.75), (0.1, 0.3), (0.3, 0.8), (-0.8, 0.8)),
        cogging_bound=0.2,
        error_gain=100.0,
        feedback_gain=150 * 0.64,
        compensated=(1, 6, 12),
        velocity=0.1,
        acceleration=1.0,
        jerk=50.0,
        repeats=8,
        error_max=(8.0002e-6, 9.0003e-6, 4.5002e-6),
        error_rms=(3.0642e-6, 2.5790e-6, 1.5096e-6),
    ),
}

Amplitudes = tuple[float, float, float]


def cogging_basis() -> SplineHarmonics:
    """The structure of both maps: harmonics 1, 2, 3, 6, 12 with third-order B-splines over the travel."""
    return SplineHarmonics(
        pitch=PITCH, harmonics=list(HARMONICS), order=ORDER, origin=TRAVEL[0], control_points=CONTROL_POINTS
    )


def cogging_map(axis: GantryAxis, amplitudes: Amplitudes) -> CoggingModel:
    """The assumed map of an axis: F(x) = sum_h f_h(x) sin(2 pi h x / P), V.

    Assumed shape: harmonic h falls as 1/h, all sines in phase at the first magnet. A compensated harmonic has
    f_h = (periodic + modulated cos(pi s)) / h, one that is not compensated uncompensated (1 + cos(pi s) / 2) / h,
    where s runs from 0 at the first magnet to 1 at the last: amplitudes that differ from end to end.

    Args:
        axis: tells which harmonics are compensated.
        amplitudes: periodic, modulated and uncompensated part, V.
    """
    periodic, modulated, uncompensated = amplitudes
    # Control points outside the travel continue the cosine: s = 0 and 1 at control points 1 and 12.
    along = np.cos(np.pi * (np.arange(CONTROL_POINTS) - 1) / (CONTROL_POINTS - 2))
    rows = [
        (periodic + modulated * along if h in axis.compensated else uncompensated * (1 + along / 2)) / h
        for h in HARMONICS
    ]
    sine = np.array(rows)
    return CoggingModel(cogging_basis(), sine, np.zeros_like(sine))


def shipped_amplitudes(axis: GantryAxis) -> Amplitudes:
    """The calibrated amplitudes that come with the package, V (written by lu2008_calibration.py)."""
    text = importlib.resources.files("cogging.papers.lu2008").joinpath("maps.toml").read_text()
    part = parse_toml(text)[axis.name]
    return part["periodic"], part["modulated"], part["uncompensated"]


def plant(axis: GantryAxis, cogging: CoggingModel | None, **axis_changes: Any) -> Plant:
    """The machine (eq. 1, 2): nominal mass and friction of the axis, the given cogging, the 0.5 um encoder."""
    fields = {
        "mass": axis.mass,
        "viscous": axis.viscous,
        "coulomb": axis.coulomb,
        "coulomb_width": COULOMB_WIDTH,
        "travel": list(TRAVEL),
    }
    return Plant(
        AxisParameters(**{**fields, **axis_changes}),
        cogging=cogging,
        encoder=EncoderParameters(resolution=RESOLUTION),
    )


def controller_parameters(axis: GantryAxis, name: str, **changes: Any) -> AdaptiveRobustParameters:
    """C1 (no cogging compensation), C2 (periodic) or C3 (B-spline) with everything that is printed.

    The gains are k_s1 alone: epsilon and u_s2 are not reported. Initial estimates are not reported: nominal, and
    zero for cogging and disturbance.
    """
    mass_bounds, viscous_bounds, coulomb_bounds, disturbance_bounds = map(list, axis.bounds)
    fields: dict[str, Any] = {
        "sample_rate": SAMPLE_RATE,
        "error_gain": axis.error_gain,
        "feedback_gain": axis.feedback_gain,
        "mass": axis.mass,
        "mass_bounds": mass_bounds,
        "mass_adaptation": 1.0,
        "viscous": axis.viscous,
        "viscous_bounds": viscous_bounds,
        "viscous_adaptation": 10.0,
        "coulomb": axis.coulomb,
        "coulomb_bounds": coulomb_bounds,
        "coulomb_adaptation": 10.0,
        "coulomb_width": COULOMB_WIDTH,
        "disturbance_bounds": disturbance_bounds,
        "disturbance_adaptation": 1000.0,
    }
    if name != "C1":
        fields |= {
            "cogging_pitch": PITCH,
            "cogging_harmonics": list(axis.compensated),
            "cogging_order": ORDER,
            "cogging_origin": TRAVEL[0],
            "cogging_control_points": CONTROL_POINTS if name == "C3" else 1,
            "cogging_bounds": [-axis.cogging_bound, axis.cogging_bound],
            "cogging_adaptation": 100.0,
        }
    return AdaptiveRobustParameters(**{**fields, **changes})


def reference(axis: GantryAxis, **changes: Any) -> PointToPoint:
    """The moves of 0.4 m there and back (sections "Comparative Experimental Results")."""
    fields = {
        "start": START,
        "distance": 0.4,
        "velocity": axis.velocity,
        "acceleration": axis.acceleration,
        "jerk": axis.jerk,
        "dwell": DWELL,
        "repeats": axis.repeats,
    }
    return PointToPoint(PointToPointParameters(**{**fields, **changes}))


def run(
    axis: GantryAxis,
    machine: Plant,
    motion: PointToPoint | None = None,
    *,
    steps_per_sample: int = 1,
    seed: int = 0,
    **controller_changes: Any,
) -> dict[str, Log]:
    """Run C1, C2 and C3 on the same machine."""
    controllers = [Dcarc(controller_parameters(axis, name, **controller_changes)) for name in CONTROLLERS]
    logs = closed_loop_batch(
        [machine] * len(controllers),
        controllers,
        motion or reference(axis),
        seeds=[seed] * len(controllers),
        steps_per_sample=steps_per_sample,
    )
    return {name: Log.of(columns) for name, columns in zip(CONTROLLERS, logs, strict=True)}


def indexes(log: Log, motion: PointToPoint) -> tuple[float, float]:
    """e_inf and e_2 (m): maximum and rms of reading minus reference over the last there and back."""
    result = performance(log.time, log.error, log.command, start=motion.end - motion.period)
    return result.error_max, result.error_rms


def table(axis: GantryAxis, logs: dict[str, Log]) -> Table:
    """Table 1 (X) or 2 (Y): the rms values are calibrated, the maxima predicted."""
    rows = []
    for i, name in enumerate(CONTROLLERS):
        error_max, error_rms = indexes(logs[name], reference(axis))
        rows.append(Row(name, "e_inf", "m", axis.error_max[i], error_max, "predicted"))
        rows.append(Row(name, "e_2", "m", axis.error_rms[i], error_rms, "calibrated"))
    number = axis.table.removeprefix("table")
    return Table(axis.table, f"Table {number}: performance indexes, {axis.name} axis", rows)


def reproduce(progress: Callable[[str], None] = lambda step: None) -> Reproduction:
    """Tables 1 and 2 and Figs. 2, 3, 5 to 10. `progress` is told each of STEPS as it is done."""
    tables, figures = [], {}
    for order, number in ((1, 2), (3, 3)):
        figures[f"lu2008_fig{number}"] = figure_spline(order, number)
    progress("figures 2, 3")
    for axis, map_number, error_number in ((AXES["X"], 5, 7), (AXES["Y"], 6, 9)):
        cogging = cogging_map(axis, shipped_amplitudes(axis))
        figures[f"lu2008_fig{map_number}"] = figure_map(axis, cogging, map_number)
        progress(f"figure {map_number}")
        logs = run(axis, plant(axis, cogging))
        tables.append(table(axis, logs))
        progress(f"{tables[-1].id}")
        figures[f"lu2008_fig{error_number}"] = figure_errors(axis, logs, error_number)
        figures[f"lu2008_fig{error_number + 1}"] = figure_errors(axis, logs, error_number + 1, last_period=True)
        progress(f"figures {error_number}, {error_number + 1}")
    note = (
        "The cogging maps are not published: three amplitudes an axis are calibrated on the three rms values "
        "(e_2),\nthe maxima (e_inf) are predicted. Assumed, not reported: shape of the maps, dwell, jerk, "
        "smoothing of the friction."
    )
    return Reproduction("lu2008", tables, figures, [note])


#: What reproduce() tells its progress.
STEPS = ("figures 2, 3", "figure 5", "table1", "figures 7, 8", "figure 6", "table2", "figures 9, 10")


def _figure(title: str, panels: int) -> tuple[Figure, list[Any]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 1.6 + 1.9 * panels), layout="constrained")
    axes = figure.subplots(panels, 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    figure.suptitle(title)
    return figure, list(axes)


def figure_spline(order: int, number: int) -> Figure:
    """Figs. 2, 3: f_S(x) of order 1 and 3 over five magnets; the control points are of our choice."""
    magnets = 5
    points = np.array([0.6, 1.0, 0.4, 0.8, 0.5, 0.9, 0.7])[: magnets + order - 1]
    spline = BSpline(order=order, origin=0.0, pitch=PITCH, control_points=len(points))
    x = np.linspace(0.0, spline.end, 1001)[:-1]
    figure, (axes,) = _figure(f"Fig. {number}: B-spline of order {order}", 1)
    axes.plot(x, spline.design_matrix(x) @ points)
    middles = (np.arange(len(points)) + 1 - order / 2) * PITCH  # of each control point's support
    axes.plot(middles, points, "go", label="control points")
    axes.set(xlabel="position (m)", ylabel="f_S (V)")
    axes.legend()
    return figure


def figure_map(axis: GantryAxis, cogging: CoggingModel, number: int) -> Figure:
    """Figs. 5, 6: a scan of the assumed map at 1 mm with an assumed sensor noise, and its fit by `cogging map`."""
    x = np.arange(START, START + 0.4 + SCAN_STEP / 2, SCAN_STEP)
    measured = cogging.force(x) + np.random.default_rng(2008).normal(0.0, SCAN_NOISE, x.size)
    fit = fit_map(x, measured, pitch=PITCH, harmonics=list(HARMONICS), order=ORDER, origin=TRAVEL[0])
    figure, (axes,) = _figure(f"Fig. {number}: cogging force of the {axis.name} axis (assumed) and its fit", 1)
    axes.plot(x, measured, ".", markersize=3, label="scan at 1 mm")
    axes.plot(x, fit.cogging.force(x) + fit.offset, label="fitted, order 3")
    axes.set(xlabel="position (m)", ylabel="force (V)")
    axes.legend()
    return figure


def figure_errors(axis: GantryAxis, logs: dict[str, Log], number: int, last_period: bool = False) -> Figure:
    """Figs. 7 and 9: the tracking errors of C1 to C3 over the whole run; 8 and 10: over the last period."""
    motion = reference(axis)
    title = f"Fig. {number}: tracking errors, {axis.name} axis" + (", one period" if last_period else "")
    figure, panels = _figure(title, 3)
    for axes, (name, time, error) in zip(panels, _errors(logs), strict=True):
        shown = time >= motion.end - motion.period if last_period else slice(None)
        axes.plot(time[shown], 1e6 * error[shown], linewidth=0.6)
        axes.set(ylabel=f"{name} (um)")
        axes.grid(alpha=0.3)
    panels[-1].set(xlabel="time (s)")
    return figure


def _errors(
    logs: dict[str, Log],
) -> Iterator[tuple[str, FloatArray, FloatArray]]:
    for name, log in logs.items():
        yield name, log.time, log.error
