"""Theorem 1 of Lu, Chen, Yao, Wang 2008 on machines drawn at random: A, the bound with u_s2 on; B, the vanishing error.

ARC: M p' = u_s - phi^T theta~ + d~ (18), so with (19) and (20) the function (22), V = M p^2 / 2, has
V' <= -k_s1 p^2 + epsilon <= -lambda V + epsilon with lambda = 2 k_s1 / theta_1max, and (23) follows.

DCARC: its regressor stands on the reference, so that by (24) and (25), with F = theta_2 + theta_3 g_f,
s = theta_4b^T g_r and e' = p - k_1 e,

    M p' = M k_1 e' - k_s1 p - F e' - s e + u_s2 - phi_d^T theta~ + d~.

V = M p^2 / 2 alone does not do, because of the terms in e. With M k_1^2 e^2 / 2 beside it, whose derivative is
M k_1^2 e p - M k_1^3 e^2, the mixed terms of M cancel:

    V' = -(k_s1 - M k_1 + F) p^2 + (k_1 F - s) p e - M k_1^3 e^2 + p (u_s2 - phi_d^T theta~ + d~) <= -z^T Q z + epsilon

with z = (p, e), where Q is (29) with M k_1^3 in the lower corner: (29) keeps half of it in hand. Where Q is positive,
z^T Q z >= lambda V, lambda being its smallest eigenvalue relative to diag(M, M k_1^2) / 2, and (23) holds for this V.
The estimates appear in neither bound: they only have to stay within theirs, which (14) sees to.

The paper proves this in continuous time. Here the controllers run at 20 kHz on an ideal encoder, with e' as the
reading's difference minus the velocity of x_d; epsilon and delta_d are not reported, ours are assumed.

Theorem 1 B: with d~ = 0 and u_s2 left out, V + theta~^T Gamma^-1 theta~ / 2 has the derivative -z^T Q z at most, so
that p and e go to zero whatever is excited. The theorem says nothing about the estimates or the time this takes. In
sampled time an error of the order of the sample time remains, since the command is held and the velocity is a backward
difference.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging._core import (
    AdaptiveRobustParameters,
    Arc,
    AxisParameters,
    CoggingModel,
    Dcarc,
    DivergedError,
    Plant,
    Reference,
    Sampled,
    desired_compensation_condition,
    friction_slope_max,
    smooth_sign,
)
from cogging.arrays import FloatArray
from cogging.effects import ConstantForce, DisturbanceStep, DisturbanceTone
from cogging.logs.log import Log
from cogging.papers.lu2008.gantry import (
    AXES,
    COULOMB_WIDTH,
    ESTIMATED,
    START,
    TRAVEL,
    GantryAxis,
    cogging_basis,
    controller_parameters,
    known,
    last_move,
    reference,
)
from cogging.papers.lu2008.stability_matrix import least_width, steepest, sufficient_gains
from cogging.papers.result import Row, Table, explored
from cogging.plot.canvas import drawn, legend, new_figure
from cogging.plot.scales import scale_of
from cogging.plot.series import LIMIT, look, marker
from cogging.simulation.batch import closed_loop_batch
from cogging.simulation.run import closed_loop

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHOWN = 24  # the machine of Theorem 1 A that is drawn: one that breaks both bounds without u_s2
SHOWN_FOR = 0.12  # s of it
EPSILON = 0.002  # V m/s, of (20) and (30), not reported
DISTURBANCE = 0.3  # V, delta_d of (12), not reported
SAMPLE_RATE = 20000.0  # Hz, ours, in place of continuous time
DURATION = 0.5  # s, of a run
SETTLED = 10.0  # time constants 1 / lambda after which exp(-lambda t) counts for nothing
Law = type[Arc] | type[Dcarc]
MACHINES = 4  # an axis and controller in `reproduce`
EPSILONS = (1.0, 0.1, 0.01)  # V m/s, with which the printed gains run beside the tables' machine
SMOOTHER = 1.01  # times the least width of S_f with which the printed gains satisfy (29)
BEYOND = 30.0  # times delta_d: a d~ beyond the bound that the controller assumes
FASTER = 30.0  # times the printed adaptation rates, which take hundreds of periods; the theorem leaves Gamma open
PERIODS = {"X": 8, "Y": 4}  # moves there and back in `reproduce`
RATES = (5000.0, 10000.0, 20000.0)  # Hz
KEPT = 1000.0  # rows of the error a second


@drawn
def figure_theorem(decays: Mapping[str, Mapping[str, FloatArray]]) -> Figure:
    """Theorem 1: above V with u_s2 on and off and its bound, of ARC and DCARC; below the error of each period.

    Args:
        decays: of each axis by name, as theorem_b.decays gives them.
    """
    figure = new_figure((8.4, 6.6))
    panels = figure.subplots(2, 2)
    axis = AXES["X"]
    _draw_bound(panels[0][0], axis, Arc, {}, "A, ARC, printed gains")
    _draw_bound(panels[0][1], axis, Dcarc, sufficient_gains(axis), "A, DCARC, sufficient gains")
    for axes, (name, found) in zip(panels[1], decays.items(), strict=True):
        scale = scale_of("m", *found.values())
        for place, (case, errors) in enumerate(found.items()):
            axes.plot(1 + np.arange(len(errors)), scale(errors), label=case, marker=marker(place), **look(place))
        axes.set_yscale("log")
        axes.set(xlabel="move there and back", ylabel=scale.label("rms error"))
        axes.set_title(f"B, {name} axis", loc="left", pad=36.0)
        axes.xaxis.get_major_locator().set_params(integer=True)
        _label_decades(axes)
        legend(axes, 2)
    figure.suptitle("Theorem 1: V and its bound (X axis, one drawn machine), and the error without d~")
    return figure


def _draw_bound(axes: Axes, axis: GantryAxis, law: Law, gains: dict[str, float], said: str) -> None:
    trial = draw(axis, SHOWN, law, **gains)
    on, off = trial.run(), trial.run(epsilon=0.0)
    shown = on.time <= SHOWN_FOR
    time = 1e3 * on.time[shown]
    curves = {
        "u_s2 on": trial.lyapunov(on),
        "u_s2 off": trial.lyapunov(off),
        "bound (23)": trial.bound(on, float(trial.lyapunov(on)[0])),
    }
    looks = (look(0), look(2), {"color": LIMIT, "linestyle": (0, (6, 3)), "linewidth": 2.0})
    for (name, values), style in zip(curves.items(), looks, strict=True):
        axes.plot(time, values[shown], label=name, **style)
    axes.set_yscale("log")
    axes.set_ylim(1e-4 * float(curves["bound (23)"][shown].max()), None)
    axes.set(xlabel="time (ms)", ylabel="V (V m)")
    axes.set_title(said, loc="left", pad=22.0)
    legend(axes, 3)


def _label_decades(axes: Axes) -> None:
    from matplotlib.ticker import LogLocator

    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter("")


@dataclass(frozen=True)
class Trial:
    """A machine within the printed bounds, a controller, and how they start.

    Attributes:
        law: Arc or Dcarc.
        plant: of ideal encoder.
        parameters: of the controller, u_s2 on.
        theta: what the machine is, in the order of the controller's estimates, (4 + coefficients,).
        motion: the reference.
        start: m and m/s.
        rate: lambda, 1/s.
    """

    law: Law
    plant: Plant
    parameters: AdaptiveRobustParameters
    theta: FloatArray
    motion: Reference
    start: tuple[float, float]
    rate: float

    def run(self, **changes: Any) -> Log:
        """The run with its estimates; `changes` are of the controller, such as epsilon=0 to leave u_s2 out."""
        return closed_loop(
            self.plant,
            self.law(self.parameters.replace(**changes)),
            self.motion,
            duration=DURATION,
            initial_position=self.start[0],
            initial_velocity=self.start[1],
            record_estimates=True,
        )

    def lyapunov(self, log: Log) -> FloatArray:
        """V of the true state, W s: of (22), for Dcarc with the term in e^2."""
        e = known(log.true_position) - known(log.reference)
        k, mass = self.parameters.error_gain, self.plant.axis.mass
        p = known(log.true_velocity) - known(log.reference_velocity) + k * e
        return 0.5 * mass * (p**2 + ((k * e) ** 2 if self.law is Dcarc else 0.0))

    def bound(self, log: Log, first: float) -> FloatArray:
        """The right side of (23) from a first V on."""
        gone = np.exp(-self.rate * (log.time - log.time[0]))
        return np.asarray(gone * first + EPSILON / self.rate * (1.0 - gone))

    def holds(self, log: Log) -> bool:
        """Whether V stays below the bound at every sample."""
        found = self.lyapunov(log)
        return bool((found <= self.bound(log, float(found[0])) * (1.0 + 1e-12)).all())

    def settled(self, log: Log) -> float:
        """The largest V, over epsilon / lambda, once the start is forgotten."""
        late = log.time > SETTLED / self.rate
        return float(self.lyapunov(log)[late].max() * self.rate / EPSILON)

    def settled_error(self, log: Log) -> float:
        """The largest true |e| in the second half of the run, m."""
        late = log.time > 0.5 * DURATION
        return float(np.abs(known(log.true_position) - known(log.reference))[late].max())

    def error_bound(self) -> float:
        """What (23) leaves of |e| in the end, m.

        V <= epsilon / lambda bounds p, and e' = p - k_1 e has |e| <= max |p| / k_1; the term in e^2 of V says the same.
        """
        return float(np.sqrt(2.0 * EPSILON / (self.rate * self.plant.axis.mass)) / self.parameters.error_gain)

    def robust_term(self, log: Log) -> tuple[float, float]:
        """The largest p (u_s2 - phi^T theta~ + d~) / epsilon and p u_s2 / epsilon of any sample.

        Both as the controller has them, from its readings, and the former with the worst d~ of the sample.
        """
        q = self.parameters
        velocity = np.diff(log.position, prepend=log.position[0]) * q.sample_rate
        error = log.position - known(log.reference)
        error_rate = velocity - known(log.reference_velocity)
        p = error_rate + q.error_gain * error
        x, v, a = known(log.reference), known(log.reference_velocity), known(log.reference_acceleration)
        if self.law is Arc:
            x, v, a = log.position, velocity, a - q.error_gain * error_rate
        friction = smooth_sign(v, q.coulomb_width)
        assert self.plant.cogging is not None
        phi = -np.column_stack([a, v, friction, -np.ones_like(a), self.plant.cogging.basis.regressor(x)])
        assert log.estimates is not None
        u_s2 = log.command + q.feedback_gain * p + np.sum(phi * log.estimates, axis=1)
        rest = np.abs(p) * q.disturbance_bound - p * np.sum(phi * (log.estimates - self.theta), axis=1)
        return float(np.max(p * u_s2 + rest)) / EPSILON, float(np.max(p * u_s2)) / EPSILON


def draw(axis: GantryAxis, seed: int, law: Law, *, width: float = COULOMB_WIDTH, **gains: Any) -> Trial:
    """A machine inside the printed bounds or at their corners, estimates anywhere within, d~ within delta_d.

    Args:
        axis: gives bounds, motion and, where none are given, the printed gains.
        seed: of the machine.
        law: of the controller.
        width: of S_f, in machine and controller, m/s.
        gains: error_gain (1/s), feedback_gain (V/(m/s)).
    """
    rng = np.random.default_rng([2008, 1, seed])
    truth = [float(rng.choice([rng.uniform(*bound), *bound])) for bound in axis.bounds]
    estimates: dict[str, Any] = {
        name: float(rng.uniform(*bound)) for name, bound in zip(ESTIMATED, axis.bounds, strict=True)
    }
    basis, largest = cogging_basis(axis.compensated), axis.cogging_bound
    sine, cosine = rng.uniform(-largest, largest, (2, len(axis.compensated), basis.spline.control_points))
    cogging = CoggingModel(basis, sine, cosine)
    share, phase, side = rng.uniform(), rng.uniform(0.0, 2.0 * np.pi), rng.choice([-1.0, 1.0])
    size = DISTURBANCE * share
    effects: list[Any] = [
        ConstantForce(force=truth[3]),
        DisturbanceTone(
            frequency=float(10 ** rng.uniform(0.0, 2.0)), sine=size * np.cos(phase), cosine=size * np.sin(phase)
        ),
        DisturbanceStep(force=side * (DISTURBANCE - size), start=rng.uniform(0.0, 0.2), stop=rng.uniform(0.3, 0.6)),
    ]
    mass, viscous, coulomb, _ = truth
    body = AxisParameters(mass=mass, viscous=viscous, coulomb=coulomb, coulomb_width=width, travel=list(TRAVEL))
    changes: dict[str, Any] = {"sample_rate": SAMPLE_RATE, "coulomb_width": width, "error_difference": False}
    changes |= {"epsilon": EPSILON, "disturbance_bound": DISTURBANCE}
    parameters = controller_parameters(axis, "C3", **changes, **estimates, **gains)
    start = START + float(rng.uniform(-1.0, 1.0) * rng.choice([0.0, 1e-4, 1e-3]))
    theta = np.array([*truth, *cogging.coefficients])
    plant = Plant(body, cogging=cogging, effects=effects)
    return Trial(
        law, plant, parameters, theta, reference(axis, repeats=1), (start, 0.0), rate_of(axis, law, parameters)
    )


def rate_of(axis: GantryAxis, law: Law, parameters: AdaptiveRobustParameters) -> float:
    """lambda of (23), 1/s, over the printed bounds; not above zero where Dcarc's gains do not satisfy (29)."""
    if law is Arc:
        return 2.0 * parameters.feedback_gain / axis.bounds[0][1]
    friction, cogging = friction_slope_max(parameters.coulomb_width), steepest(axis)[1]
    return desired_compensation_condition(parameters, friction_slope=friction, cogging_slope=cogging)[1]


def with_disturbance_times(trial: Trial, factor: float) -> Trial:
    """The same trial, with a constant d~ of `factor` times delta_d and no other."""
    offset = trial.plant.effects[0].force
    push = ConstantForce(force=offset + factor * DISTURBANCE)
    return replace(trial, plant=Plant(trial.plant.axis, cogging=trial.plant.cogging, effects=[push]))


def growth_at_rest(axis: GantryAxis, **gains: Any) -> float:
    """The largest V of DCARC over its first one, held at rest by exact parameters: nothing is uncertain, no d~.

    The machine has the smallest mass and the largest frictions of the bounds and no cogging, and starts at the (p, e)
    that Q likes least, at 0.1 mm/s. Where (29) is positive, V only falls.
    """
    masses, viscous, coulomb, _ = axis.bounds
    values: dict[str, Any] = {"mass": masses[0], "viscous": viscous[1], "coulomb": coulomb[1]}
    held: dict[str, Any] = {f"{name}_adaptation": 0.0 for name in (*ESTIMATED, "cogging")}
    parameters = controller_parameters(axis, "C3", sample_rate=SAMPLE_RATE, **values, **held, **gains)
    k, mass = parameters.error_gain, values["mass"]
    friction = values["viscous"] + values["coulomb"] * friction_slope_max(COULOMB_WIDTH)
    corner, mixed = parameters.feedback_gain - mass * k + friction, -0.5 * k * friction
    # Of Q relative to diag(M, M k_1^2) / 2, in the terms p and k_1 e.
    relative = np.array([[corner, mixed / k], [mixed / k, mass * k]])
    p, ke = np.linalg.eigh(relative)[1][:, 0]
    scale = 1e-4 / abs(p - ke)
    t = np.arange(0.0, 0.02, 1.0 / SAMPLE_RATE)
    motion = Sampled(t, np.full_like(t, START), np.zeros_like(t), np.zeros_like(t))
    plant = Plant(AxisParameters(**values, coulomb_width=COULOMB_WIDTH, travel=list(TRAVEL)))
    start = (START + scale * ke / k, scale * (p - ke))
    trial = Trial(Dcarc, plant, parameters, np.zeros(0), motion, start, 0.0)
    log = closed_loop(plant, Dcarc(parameters), motion, initial_position=start[0], initial_velocity=start[1])
    found = trial.lyapunov(log)
    return float(found.max() / found[0])


def groups(axis: GantryAxis) -> tuple[tuple[Law, str, dict[str, float]], ...]:
    """Controllers that meet the conditions: law, name of the gains, and gains and width of S_f as `draw` takes them.

    ARC asks nothing of its gains. DCARC meets (29) with the printed gains where S_f is smooth enough, and with our S_f
    where the gains are large enough.
    """
    smooth = {"width": SMOOTHER * least_width(axis)}
    return (
        (Arc, "printed", {}),
        (Dcarc, "printed, smooth S_f", smooth),
        (Dcarc, "sufficient", sufficient_gains(axis)),
    )


def theorem_table(axis: GantryAxis, machine: Plant, machines: int = MACHINES) -> Table:
    """Theorem 1 A on drawn machines, for each of `groups`, and what DCARC does with the printed gains and our S_f.

    Args:
        axis: gives bounds and motion.
        machine: on which C3 runs with its printed gains and rate and u_s2 beside them.
        machines: how many are drawn.

    Returns:
        For each: the share of machines whose V stays below its bound (held), the largest V over epsilon / lambda once
        the start is forgotten (v_settled), what (23) says of |e| then and what it is, the two conditions of (30), and
        the same with a condition dropped.
    """
    enough = sufficient_gains(axis)
    rows = []
    for law, said, conditions in groups(axis):
        trials = [draw(axis, seed, law, **conditions) for seed in range(machines)]
        logs = [trial.run() for trial in trials]
        terms = np.max([trial.robust_term(log) for trial, log in zip(trials, logs, strict=True)], axis=0)
        beyond = [with_disturbance_times(trials[0], BEYOND)]
        found = [
            ("decay_rate", "1/s", trials[0].rate, "u_s2 on"),
            *_against_the_bound(trials, logs, "u_s2 on"),
            ("e_bound", "m", max(trial.error_bound() for trial in trials), "u_s2 on"),
            ("e_inf", "m", _largest_settled(trials, logs), "u_s2 on"),
            ("condition_1", "1", terms[0], "(20) or (30), over epsilon"),
            ("condition_2", "1", terms[1], "(20) or (30), over epsilon"),
            *_against_the_bound(trials, [trial.run(epsilon=0.0) for trial in trials], "u_s2 off"),
            *_against_the_bound(beyond, [beyond[0].run()], f"{BEYOND:.0f} delta_d, machine 0"),
        ]
        rows += [_row(law, said, *one) for one in found]
    trials = [draw(axis, seed, Dcarc) for seed in range(machines)]
    erred = _largest_settled(trials, [trial.run() for trial in trials])
    rows += [
        _row(Dcarc, "printed", "decay_rate", "1/s", trials[0].rate, "u_s2 on"),
        _row(Dcarc, "printed", "e_inf", "m", erred, "u_s2 on"),
        _row(Dcarc, "printed", "v_growth", "1", growth_at_rest(axis), "at rest"),
        _row(Dcarc, "sufficient", "v_growth", "1", growth_at_rest(axis, **enough), "at rest"),
    ]
    rows += _with_robust_term(axis, machine)
    title = f"Theorem 1 A on {machines} drawn machines, {axis.name} axis: V, and its bound {EPSILON:g} V m/s / lambda"
    return Table(f"theorem1a_{axis.name}", title, rows)


def _with_robust_term(axis: GantryAxis, machine: Plant) -> list[Row]:
    parameters = [
        controller_parameters(axis, "C3", epsilon=epsilon, disturbance_bound=DISTURBANCE) for epsilon in EPSILONS
    ]
    errors = last_move(list(map(Dcarc, parameters)), [machine] * len(parameters), reference(axis)).indexes["error_rms"]
    return [
        Row("C3", "e_2", "m", axis.error_rms[2], float(found), "exploratory", {"case": f"5 kHz, epsilon {epsilon:g}"})
        for epsilon, found in zip(EPSILONS, errors, strict=True)
    ]


def _largest_settled(trials: Sequence[Trial], logs: Sequence[Log]) -> float:
    return max(trial.settled_error(log) for trial, log in zip(trials, logs, strict=True))


def _against_the_bound(trials: Sequence[Trial], logs: Sequence[Log], case: str) -> list[tuple[str, str, float, str]]:
    pairs = list(zip(trials, logs, strict=True))
    held = float(np.mean([trial.holds(log) for trial, log in pairs]))
    settled = max(trial.settled(log) for trial, log in pairs)
    return [("held", "1", held, case), ("v_settled", "1", settled, case)]


def _row(law: Law, gains: str, index: str, unit: str, value: float, case: str) -> Row:
    return explored(law.__name__.upper(), index, unit, value, {"gains": gains, "case": case})


def errors_by_period(
    axis: GantryAxis,
    sample_rate: float,
    periods: int,
    *,
    faster: float = 1.0,
    seed: int = 0,
    gains: Mapping[str, float] = MappingProxyType({}),
) -> FloatArray:
    """The rms error (m) of DCARC in each move there and back on a drawn machine with d~ = 0, (periods,).

    Cogging of C3's harmonics, parameters and initial estimates within the bounds, an ideal encoder, no u_s2.

    Args:
        axis: gives bounds, motion and, where none are given, the printed gains.
        sample_rate: Hz.
        periods: moves there and back.
        faster: factor on all printed adaptation rates.
        seed: of the machine.
        gains: error_gain (1/s), feedback_gain (V/(m/s)).

    Raises:
        DivergedError: the run diverged.
    """
    trial, motion = draw(axis, seed, Dcarc), reference(axis, repeats=periods)
    printed = controller_parameters(axis, "C3")
    names = [f"{name}_adaptation" for name in (*ESTIMATED, "cogging")]
    changes: dict[str, Any] = {name: faster * getattr(printed, name) for name in names}
    changes |= {name: getattr(trial.parameters, name) for name in ESTIMATED}
    parameters = printed.replace(sample_rate=sample_rate, **changes, **gains)
    batch = closed_loop_batch(
        [with_disturbance_times(trial, 0.0).plant],
        [Dcarc(parameters)],
        motion,
        columns=("true_position", "reference"),
        every=round(sample_rate / KEPT),
    )
    for failure in batch.failures:
        raise DivergedError(failure.reason)
    error = batch.columns["true_position"][0] - batch.columns["reference"][0]
    rows = round(motion.period * KEPT)
    return np.asarray(np.sqrt(np.mean(error[: periods * rows].reshape(periods, rows) ** 2, axis=1)))


def decays(axis: GantryAxis) -> dict[str, FloatArray]:
    """errors_by_period as printed at 5 kHz, and at each of RATES with gains that satisfy (29) and FASTER adaptation."""
    gains, periods = sufficient_gains(axis), PERIODS[axis.name]
    found = {"printed, 5 kHz": errors_by_period(axis, RATES[0], periods)}
    for rate in RATES:
        said = f"sufficient, {rate / 1000:g} kHz"
        found[said] = errors_by_period(axis, rate, periods, faster=FASTER, gains=gains)
    return found


def convergence_table(found: Mapping[str, Mapping[str, FloatArray]]) -> Table:
    """The error of the first and the last period.

    Args:
        found: of each axis by name, as `decays` gives them.
    """
    rows = []
    for axis, by_case in found.items():
        for case, errors in by_case.items():
            for period in (1, len(errors)):
                labels = {"axis": axis, "case": case, "period": str(period)}
                rows.append(explored("DCARC", "e_2", "m", errors[period - 1], labels))
    faster = f"gains sufficient for (29) and adaptation {FASTER:.0f} times faster, or both as printed"
    return Table("theorem1b", f"Theorem 1 B: the rms error where only parameters are uncertain; {faster}", rows)
