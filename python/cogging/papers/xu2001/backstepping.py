"""Theorem 1 of Xu and Yao 2001 and its Remark 3 in numbers: conditions, bound (51), the vanishing error.

z_1, z_2, phi_1, phi_2 and the gains (12) to (48) along a run are computed a second time, with numpy over all rows of a
log, because the core's controller does not expose its gains while it runs.

Also why the robust terms that the paper prints cannot run, and which of them can: the command due to one encoder count,
the sampling rate that the terms need, and each of them alone. Exploratory.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from cogging import _core, effects
from cogging._core import AxisParameters, OutputFeedbackArc, OutputFeedbackArcParameters, Plant
from cogging.arrays import FloatArray
from cogging.logs.log import Log
from cogging.papers.compared import PRINTED
from cogging.papers.result import Row, Table, explored, known
from cogging.papers.xu2001 import epoxy_motor
from cogging.papers.xu2001.epoxy_motor import INDEXES, RESOLUTION, TABLE_1, Unknowns, arc_parameters, reference
from cogging.plot.canvas import drawn, legend, titled_panels
from cogging.plot.scales import scale_of
from cogging.plot.series import look, marker
from cogging.simulation.batch import closed_loop_batch
from cogging.simulation.run import closed_loop

WATCHED = (5.0, 50.0, 500.0)  # s: how long the error of B is watched
FACTORS = (1.0, 1.4, 2.0)  # on the gains g_i, and under the epsilons, of Remark 3
#: The machine (1/M, B/M, d_n/M), tone (m/s^2) and start (m) that show B and Remark 3; assumed.
THETA, TONE, OFF = np.array([20.0, 5.0, 2.0]), 2.0, 5e-3


@dataclass(frozen=True)
class Backstepping:
    """The two steps of the design along a run; one entry, or three, a row."""

    z_1: FloatArray  # m, of step 1 (after 22)
    z_2: FloatArray  # V s, of step 2 (25)
    phi_1: FloatArray  # of the adaptation law (26), (n, 3)
    phi_2: FloatArray  # (45), (n, 3)
    by_theta: FloatArray  # d alpha_1 / d theta_hat, (n, 3)
    gain_1: FloatArray  # of -z_1 in theta_1min alpha_1s: k_1s with (37), (38)
    gain_2: FloatArray  # of -z_2 in u*_s: k_2s with (47)

    def lyapunov(self, p: OutputFeedbackArcParameters) -> FloatArray:
        """Return V_2 of (30), (41)."""
        return 0.5 * (p.weight_1 * self.z_1**2 + p.weight_2 * self.z_2**2)


def backstepping(log: Log, p: OutputFeedbackArcParameters) -> Backstepping:
    """Return the steps of an ARC along its log, which has reference and estimates."""
    y, velocity = log.position - log.position[0], known(log.reference_velocity)
    compensation = p.coulomb * np.asarray(_core.smooth_sign(velocity, p.coulomb_width))
    eta, lam, psi = (filtered(p, driven) for driven in (y, log.command - compensation, np.ones_like(y)))
    return steps(p, log.error, y, eta, lam, psi, known(log.estimates), velocity)


def filtered(p: OutputFeedbackArcParameters, driven: FloatArray) -> FloatArray:
    """Return x of x' = A_0 x + e_2 input from rest (12), (18), exact for an input held from row to row, (n, 2)."""
    from scipy.linalg import expm

    block = np.zeros((3, 3))
    block[:2] = [[-p.observer_gain_1, 1.0, 0.0], [-p.observer_gain_2, 0.0, 1.0]]
    (a, b, into_1), (c, d, into_2), _ = expm(block / p.sample_rate).tolist()
    found, x_1, x_2 = [], 0.0, 0.0
    for value in driven.tolist():
        found.append((x_1, x_2))
        x_1, x_2 = a * x_1 + b * x_2 + into_1 * value, c * x_1 + d * x_2 + into_2 * value
    return np.array(found)


def steps(
    p: OutputFeedbackArcParameters,
    z_1: FloatArray,
    y: FloatArray,
    eta: FloatArray,
    lam: FloatArray,
    psi: FloatArray,
    theta: FloatArray,
    velocity: FloatArray,
) -> Backstepping:
    """Return the steps; eta, lam, psi: filter states, (n, 2); theta: estimates, (n, 3); velocity: the reference's."""
    k_1, k_2 = p.observer_gain_1, p.observer_gain_2
    xi_12, xi_22 = -k_2 * eta[:, 0], k_2 * (eta[:, 1] - k_1 * eta[:, 0])  # (17)
    model = -(xi_22 - theta[:, 1] * (xi_12 + y) + theta[:, 2] * psi[:, 1] - velocity) / theta[:, 0]  # (25)
    phi_1 = np.stack([model, -(xi_12 + y), psi[:, 1]], axis=1)  # (26)
    omega = np.stack([lam[:, 1], -(xi_12 + y), psi[:, 1]], axis=1)  # (39)
    rates = np.array(p.adaptation)
    # Weights of phi_1^2 in the gain of step 1: (28), and (37) with h_1 = ||theta_M||^2 ||phi_1||^2.
    weights = p.use_c_phi_1 * (np.array(p.c_phi_1) * rates) ** 2
    weights = p.robust_factor * (weights + p.use_alpha_1s2 * theta_range_square(p) / (4.0 * p.epsilon_11))
    gain_1 = p.gain_1 + (phi_1**2) @ weights + p.use_alpha_1s3 * p.robust_factor / (4.0 * p.epsilon_12)  # (38)
    z_2 = lam[:, 1] - (model - gain_1 * z_1 / p.theta_min[0])

    # d alpha_1: that of alpha_1a, and of the gain where it depends on phi_1.
    slope = theta[:, 1] / theta[:, 0]
    of_gain = 2.0 * z_1 * weights[:, None] * phi_1.T / p.theta_min[0]  # (3, n)
    by_position = slope * (1.0 - of_gain[0]) + of_gain[1] - gain_1 / p.theta_min[0]
    by_theta = -phi_1 / theta[:, :1] * (1.0 - of_gain[0])[:, None]
    phi_2 = -by_position[:, None] * omega  # (45)
    phi_2[:, 0] += p.weight_1 / p.weight_2 * z_1
    # (43), and (47) with h_2 = ||theta_M||^2 ||phi_2||^2.
    robust = p.use_c_theta_2 * np.sum((by_theta * np.array(p.c_theta_2)) ** 2, axis=1)
    robust += p.use_c_phi_2 * np.sum((phi_2 * np.array(p.c_phi_2) * rates) ** 2, axis=1)
    robust += p.use_u_s2 * theta_range_square(p) * np.sum(phi_2**2, axis=1) / (4.0 * p.epsilon_21)
    robust += p.use_u_s3 * by_position**2 / (4.0 * p.epsilon_22)
    gain_2 = p.gain_2 + p.robust_factor * robust
    return Backstepping(z_1, z_2, phi_1, phi_2, by_theta, gain_1, gain_2)


def theta_range_square(p: OutputFeedbackArcParameters) -> float:
    """Return ||theta_M||^2 of (32)."""
    return float(np.sum((np.array(p.theta_max) - np.array(p.theta_min)) ** 2))


class Bound(NamedTuple):
    """(51): V_2(t) <= exp(-rate t) V_2(0) + final (1 - exp(-rate t))."""

    rate: float  # lambda_v = 2 min(g_1, g_2), 1/s
    final: float  # (epsilon_21 + epsilon_22 delta_1^2) / lambda_v, the bound of V_2 in the end

    def at(self, time: FloatArray, start: float) -> FloatArray:
        """Return the bound over time (s) from V_2(0)."""
        decay = np.exp(-self.rate * (time - time[0]))
        return np.asarray(decay * start + self.final * (1.0 - decay))


def bound(p: OutputFeedbackArcParameters, delta_1: float) -> Bound:
    """Return (51) for an estimation error |Delta_1| <= delta_1."""
    rate = 2.0 * min(p.gain_1, p.gain_2)
    epsilon_1 = p.weight_1 * p.epsilon_11 + p.weight_2 * p.epsilon_21
    epsilon_2 = p.weight_1 * p.epsilon_12 + p.weight_2 * p.epsilon_22
    return Bound(rate, (epsilon_1 + epsilon_2 * delta_1**2) / rate)


def estimation_bound(p: OutputFeedbackArcParameters, size: float) -> float:
    """Return the largest |eps_u2| of (15), (16) under |d~| <= size: size k_1 / k_2 for real poles of A_0, as here."""
    return size * p.observer_gain_1 / p.observer_gain_2


def condition_margin(p: OutputFeedbackArcParameters) -> tuple[float, float]:
    """Return the smallest c_phikr^2 over w_k w_2 / (2 c_theta2r^2) for k = 1, 2; Theorem 1 requires at least 1."""
    first, second = (
        min(c_phi**2 * 2.0 * c_theta**2 / (weight * p.weight_2) for c_phi, c_theta in zip(c, p.c_theta_2, strict=True))
        for weight, c in ((p.weight_1, p.c_phi_1), (p.weight_2, p.c_phi_2))
    )
    return first, second


def design_model(theta: FloatArray, size: float = 0.0) -> Plant:
    """Return the plant (6) of 1/M, B/M, d_n/M, with d~ a tone of 30 Hz of a size (m/s^2), and an ideal encoder."""
    mass = 1.0 / theta[0]
    pushes: list[Any] = [effects.ConstantForce(force=theta[2] * mass)]
    if size > 0.0:
        pushes.append(effects.DisturbanceTone(frequency=30.0, sine=size * mass))
    return Plant(AxisParameters(mass=mass, viscous=theta[1] * mass, travel=[-1.0, 1.0]), effects=pushes)


def run(
    p: OutputFeedbackArcParameters, machine: Plant, duration: float, start: float = 0.0, seed: int = 0
) -> tuple[Log, Backstepping]:
    """Run case 1 from a start off the reference (m); return the log and the steps of the design along it."""
    options: dict[str, Any] = {"duration": duration, "seed": seed, "initial_position": start, "record_estimates": True}
    log = closed_loop(machine, OutputFeedbackArc(p), reference(), **options)
    return log, backstepping(log, p)


def deterministic_law(factor: float = 1.0, **changes: Any) -> OutputFeedbackArcParameters:
    """Return a law without adaptation that meets (33), (35), (46) and can run at 200 kHz, as in Remark 3.

    Bounds and epsilons are assumed, milder than the printed; g_i times the factor, the epsilons over it.
    """
    fields: dict[str, Any] = {"sample_rate": 200_000.0, "coulomb": 0.0, "adaptation": [0.0] * 3}
    fields |= {"theta": [25.0, 6.0, 0.0], "theta_min": [15.0, 4.0, -3.0], "theta_max": [30.0, 8.0, 3.0]}
    fields |= {"gain_1": factor * 60.0, "gain_2": factor * 80.0}
    fields |= dict.fromkeys(("epsilon_11", "epsilon_12"), 1e-3 / factor)
    fields |= dict.fromkeys(("epsilon_21", "epsilon_22"), 0.1 / factor)
    fields |= dict.fromkeys(("use_alpha_1s2", "use_alpha_1s3", "use_u_s2", "use_u_s3"), True)
    return arc_parameters(**{**fields, **changes})


class Kept(NamedTuple):
    """How a run keeps to (51)."""

    share: float  # largest V_2(t) over the bound at t, after the start, where it is 1
    final: float  # largest V_2 of the last half
    rise: float  # largest of V_2' + lambda_v V_2 over the limit of (A.5)


def kept(p: OutputFeedbackArcParameters, theta: FloatArray, size: float, start: float) -> Kept:
    """Compare V_2 along 0.1 s with (51) and (A.5), from a start (m) off the reference, with a tone (m/s^2)."""
    log, found = run(p, design_model(theta, size), 0.1, start)
    v_2, limit = found.lyapunov(p), bound(p, estimation_bound(p, size))
    share = float(np.max((v_2 / limit.at(log.time, v_2[0]))[1:]))
    slope = np.diff(v_2) * p.sample_rate + limit.rate * v_2[:-1]
    return Kept(share, float(v_2[v_2.size // 2 :].max()), float(slope.max() / (limit.rate * limit.final)))


def adaptive_lyapunov(p: OutputFeedbackArcParameters, theta: FloatArray, duration: float) -> FloatArray:
    """Return V_theta of (A.7) along a run with parametric uncertainty only; epsilon is zero from rest."""
    log, found = run(p, design_model(theta), duration)
    off = known(log.estimates) - theta
    return np.asarray(found.lyapunov(p) + 0.5 * np.sum(off**2 / np.array(p.adaptation), axis=1))


def conditions(unknowns: Unknowns, set_name: str) -> dict[str, float]:
    """Return how the executable gains g_1, g_2 meet the design's conditions along a run.

    k_is_over_needed: the smallest over (28), (43); condition_33, _46: the largest left side over its epsilon, met at or
    below 1; v_2_over_bound: the largest V_2 over the limit of (51).
    """
    p, full = arc_parameters(), arc_parameters(use_c_phi_1=True, use_c_theta_2=True, use_c_phi_2=True)
    log, found = run(p, epoxy_motor.plant(unknowns, set_name), epoxy_motor.DURATION, seed=epoxy_motor.SEED)
    needed = backstepping(log, full)
    off = known(log.estimates) - np.array([1.0, epoxy_motor.VISCOUS, unknowns.offset]) / epoxy_motor.MASSES[set_name]
    first, second = (
        float(np.max(-z * np.sum(off * phi, axis=1))) for z, phi in ((found.z_1, found.phi_1), (found.z_2, found.phi_2))
    )
    met = {"k_1s_over_needed": p.gain_1 / float(needed.gain_1.max())}
    met["k_2s_over_needed"] = p.gain_2 / float(needed.gain_2.max())
    met |= {"condition_33": first / p.epsilon_11, "condition_46": second / p.epsilon_21}
    return {**met, "v_2_over_bound": float(found.lyapunov(p).max()) / bound(p, 0.0).final}


def theorem_1_table(unknowns: Unknowns) -> Table:
    """Tabulate the conditions of Theorem 1 with the printed and the executable gains, Remark 3 and B."""
    rows = [
        explored("printed gains", "c_phi_margin", "1", margin, k=str(step))
        for step, margin in enumerate(condition_margin(arc_parameters()), start=1)
    ]
    for set_name in ("1", "2"):
        for index, value in conditions(unknowns, set_name).items():
            rows.append(explored("ARC", index, "1", value, set=set_name))
    for factor in FACTORS:
        p, label = deterministic_law(factor), f"{factor:g}"
        limit = bound(p, estimation_bound(p, TONE)).final
        rows.append(explored("deterministic", "v_2_bound", "m^2", limit, factor=label))
        rows.append(explored("deterministic", "v_2_final", "m^2", kept(p, THETA, TONE, OFF).final, factor=label))
    for name, changes in (("ARC", {}), ("ARC, no adaptation", {"adaptation": [0.0] * 3})):
        law, machine = OutputFeedbackArc(arc_parameters(coulomb=0.0, **changes)), design_model(THETA)
        for duration in WATCHED:  # the largest error in the last 2 s, with the printed gains g_i
            batch = closed_loop_batch([machine], [law], reference(), duration=duration)
            rows.append(explored(name, "e_F", "m", batch.indexes["error_final_max"][0], after=f"{duration:g} s"))
    return Table("theorem_1", "Theorem 1 and Remark 3: conditions, bound (51), the error that vanishes", rows)


# The printed robust terms ---------------------------------------------------------------------------------------------

ROBUST_TERMS = ("use_alpha_1s2", "use_alpha_1s3", "use_c_phi_1", "use_c_theta_2", "use_c_phi_2", "use_u_s2", "use_u_s3")
ALL_TERMS = dict.fromkeys(ROBUST_TERMS, True)
#: Sampling rate (Hz) and resolution (m) at which the robust terms are tried.
HARDWARE = ((2500.0, 1e-6), (20_000.0, 1e-8), (200_000.0, 1e-10))
TERM_FACTORS = (0.0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0)
SETTLED = 500  # samples at rest after which the filters have settled: 0.2 s, 40 time constants of their poles at -200
RATES = (1e5, 1e6, 1e7, 1e8)  # Hz
FINE = 100_000.0  # Hz: at which the gains along a run are computed
SHORT = 0.02  # s: all of RATES have diverged by then
START = 0.1  # s, examined part of the run: the largest K_2 of a whole period is at 0.055 s
STABLE = 2.0  # z_2[k+1] = (1 - K_2 T) z_2[k] decays below this K_2 T


def rigid(resolution: float) -> Plant:
    """Return set 1 without delay, friction or noise: only the quantiser is left."""
    axis = AxisParameters(mass=epoxy_motor.MASSES["1"], viscous=epoxy_motor.VISCOUS, travel=[-0.3, 0.3])
    return Plant(axis, encoder=_core.EncoderParameters(resolution=resolution))


def increment(factor: float, sample_rate: float, resolution: float) -> float:
    """Return the rms command increment (V) over 1 s with all robust terms times a factor; infinite if it diverges."""
    controller = OutputFeedbackArc(arc_parameters(sample_rate=sample_rate, robust_factor=factor, **ALL_TERMS))
    options: dict[str, Any] = {"duration": 1.0, "steps_per_sample": max(1, round(20_000 / sample_rate))}
    batch = closed_loop_batch([rigid(resolution)], [controller], reference(), **options)
    return float(np.nan_to_num(batch.indexes["command_change_rms"][0], nan=np.inf))


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
    found = steps(p, zero, zero, none, none, psi, np.array([p.theta]), zero)
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
    counts = {"one sample after the start": one_count(RESOLUTION, held=1)}
    counts |= {f"settled, {SETTLED} samples": one_count(RESOLUTION), "settled, by hand": by_hand(RESOLUTION)}
    rows = [explored(name, "one_count", "V", abs(value), count=said) for said, value in counts.items()]
    law = OutputFeedbackArc(arc_parameters(sample_rate=FINE))
    log = closed_loop(rigid(0.0), law, reference(), duration=START, record_estimates=True)
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
    names = {"e_M": "error_max", "e_rms": "error_rms", "du_rms": "command_change_rms"}
    ends = {chosen[failure.run]: {"diverges_at": failure.time} for failure in batch.failures}
    found = {index: batch.indexes[name] for index, name in names.items()}
    return {one: {index: float(row[run]) for index, row in found.items()} for run, one in enumerate(chosen)} | ends


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
    title = "The printed robust terms times a factor; a line ends where the run diverges"
    figure, axes = titled_panels(title, (7.2, 4.2))
    for place, (rate, resolution) in enumerate(HARDWARE):
        values = [increment(factor, rate, resolution) for factor in TERM_FACTORS[1:]]
        length = scale_of("m", resolution)
        label = f"{rate / 1000:g} kHz, {length(resolution):g} {length.unit}"
        axes.loglog(TERM_FACTORS[1:], values, marker=marker(place), label=label, **look(place))
    printed = TABLE_1["ARC"]["1"][4]
    axes.axhline(printed, **PRINTED, label=f"paper: {printed:g} V")
    axes.set(xlabel="factor on the printed robust terms", ylabel="rms command increment (V)", xlim=(5e-8, 2.0))
    legend(axes)
    return figure
