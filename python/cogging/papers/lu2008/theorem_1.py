"""Theorem 1 of Lu, Chen, Yao, Wang 2008 and matrix (29), which must be positive definite for it.

Matrix (29): the paper requires a k_s1 that makes it positive, and does not report the slope of its S_f. That of
(2/pi) atan(900 v) is 573 s/m at rest. Mass, viscous and Coulomb friction take all values within the printed bounds,
the entries of A_r likewise.

The theorem on random machines: A, the bound with u_s2; B, the vanishing error. docs/papers/lu2008.md has the derivation
for DCARC. The proof is in continuous time. Here the controllers run at 20 kHz on an ideal encoder, with e' as the
reading's difference minus the velocity of x_d; epsilon and delta_d are assumed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.optimize import brentq

from cogging import _core
from cogging._core import AdaptiveRobustParameters, Arc, AxisParameters, CoggingModel, Dcarc, Plant, friction_slope_max
from cogging.arrays import FloatArray
from cogging.effects import ConstantForce, DisturbanceStep, DisturbanceTone
from cogging.logs.log import Log
from cogging.papers.compared import PRINTED
from cogging.papers.lu2008 import gantry
from cogging.papers.lu2008.gantry import AXES, COULOMB_WIDTH, ESTIMATED, START, GantryAxis, controller_parameters
from cogging.papers.result import Row, Table, explored, known
from cogging.plot.canvas import drawn, legend, titled_panels
from cogging.plot.scales import scale_of
from cogging.plot.series import look, marker
from cogging.simulation.batch import closed_loop_batch
from cogging.simulation.run import closed_loop

# Matrix (29) ----------------------------------------------------------------------------------------------------------

MARGIN = 1.3  # of k_s1 over the least that makes (29) positive, in `sufficient_gains`
ERROR_GAINS = np.geomspace(10.0, 5000.0, 1001)  # 1/s: candidates for k_1


def steepest(axis: GantryAxis) -> tuple[float, float]:
    """Return the largest g_f of (24), 1/(m/s), and |theta_4b^T g_r| of (25), V/m, within the bounds."""
    basis = gantry.cogging_basis(axis.compensated)
    return friction_slope_max(COULOMB_WIDTH), _core.cogging_slope_max(basis, axis.cogging_bound)


def matrix_condition(axis: GantryAxis, friction_slope: float, share: float = 1.0, **gains: Any) -> tuple[float, float]:
    """Return the smallest eigenvalue of (29) over the printed bounds, in SI units, and its decay rate, 1/s.

    friction_slope: the largest g_f, 1/(m/s); share: of the largest |theta_4b^T g_r|; gains: in place of the printed.
    """
    parameters, slope = controller_parameters(axis, "C3", **gains), share * steepest(axis)[1]
    return _core.desired_compensation_condition(parameters, friction_slope=friction_slope, cogging_slope=slope)


def least_feedback_gain(axis: GantryAxis, error_gain: Any, friction_slope: float, cogging_slope: float) -> FloatArray:
    """Return the k_s1 above which (29) is positive definite over the printed bounds, V/(m/s), for each k_1 (1/s).

    With F = theta_2 + theta_3 g_f and s = theta_4b^T g_r the determinant is positive if
    k_s1 > M k_1 - F + (k_1 F - s)^2 / (2 M k_1^3): convex in each of M, F and s, so that the largest value is at a
    corner of the box. The slopes are the largest g_f (1/(m/s)) and |s| (V/m).
    """
    k = np.asarray(error_gain, dtype=np.float64)
    masses, viscous, coulomb, _ = axis.bounds
    found = [
        mass * k - friction + (k * friction - slope) ** 2 / (2.0 * mass * k**3)
        for mass in masses
        for friction in (viscous[0], viscous[1] + coulomb[1] * friction_slope)
        for slope in (-cogging_slope, cogging_slope)
    ]
    return np.asarray(np.max(found, axis=0))


def sufficient_gains(axis: GantryAxis) -> dict[str, float]:
    """Return the k_1 (1/s) that needs the least k_s1 (V/(m/s)) at the steepest slopes, and MARGIN times that k_s1."""
    least = least_feedback_gain(axis, ERROR_GAINS, *steepest(axis))
    place = int(np.argmin(least))
    return {"error_gain": float(ERROR_GAINS[place]), "feedback_gain": MARGIN * float(least[place])}


def largest_friction_slope(axis: GantryAxis) -> float:
    """Return the largest g_f (1/(m/s)) at which the printed gains make (29) positive, with the steepest cogging."""
    steep = steepest(axis)[0]
    return float(brentq(lambda slope: matrix_condition(axis, slope)[0], 0.0, steep, xtol=1e-9))


def largest_cogging_share(axis: GantryAxis) -> float:
    """Return the same for the cogging slope without any of friction, over the largest within the bounds."""
    return float(brentq(lambda share: matrix_condition(axis, 0.0, share)[0], 0.0, 1e4, xtol=1e-9))


def speed_of_slope(slope: float) -> float:
    """Return the speed (m/s) above which S_f(v) = (2/pi) atan(v / width) is less steep than a slope (1/(m/s))."""
    return COULOMB_WIDTH * float(np.sqrt(max(friction_slope_max(COULOMB_WIDTH) / slope - 1.0, 0.0)))


def least_width(axis: GantryAxis) -> float:
    """Return the least width (m/s) of S_f(v) = (2/pi) atan(v / width) that the printed gains allow."""
    return 2.0 / (np.pi * largest_friction_slope(axis))


def positive_share(axis: GantryAxis, machine: Plant, log: Log) -> float:
    """Return the share of the last move's samples at which (29) is positive with the quotients (24), (25) there."""
    parameters, motion = controller_parameters(axis, "C3"), gantry.reference(axis)
    cogging, width = machine.cogging, machine.axis.coulomb_width
    assert isinstance(cogging, CoggingModel)
    late = log.time >= motion.end - motion.period
    columns = (log.true_position, log.true_velocity, log.reference, log.reference_velocity)
    x, v, x_d, v_d = (known(column)[late] for column in columns)

    def quotient(change: FloatArray, distance: FloatArray, at_rest: FloatArray) -> FloatArray:
        near = np.abs(distance) < 1e-12  # nothing but rounding
        return np.where(near, at_rest, change / np.where(near, 1.0, distance))

    sign_change = _core.smooth_sign(v, width) - _core.smooth_sign(v_d, width)
    at_rest = 2.0 * width / (np.pi * (width**2 + v_d**2))
    friction = machine.axis.viscous + machine.axis.coulomb * quotient(sign_change, v - v_d, at_rest)
    slope = quotient(cogging.force(x) - cogging.force(x_d), x - x_d, cogging.slope(x_d))
    mass, k = machine.axis.mass, parameters.error_gain
    corner = parameters.feedback_gain - mass * k + friction
    determinant = corner * 0.5 * mass * k**3 - 0.25 * (k * friction - slope) ** 2
    return float(np.mean((corner > 0.0) & (determinant > 0.0)))


def condition_table(axis: GantryAxis, machine: Plant, log: Log) -> Table:
    """Tabulate (29) with the printed gains on a machine and its log of C3, the slopes and the gains that it allows."""
    steep, rough = steepest(axis)
    rows = []

    def row(case: str, index: str, unit: str, value: float, paper: float | None = None) -> None:
        rows.append(Row("C3", index, unit, paper, value, "exploratory", {"case": case}))

    def rms(on: Plant, **changes: Any) -> float:
        controller = Dcarc(controller_parameters(axis, "C3", **changes))
        return float(gantry.last_move([controller], [on], gantry.reference(axis)).indexes["error_rms"][0])

    for case, slope, share in (("all slopes", steep, 1.0), ("no friction slope", 0.0, 1.0), ("no slopes", 0.0, 0.0)):
        eigenvalue, rate = matrix_condition(axis, slope, share)
        row(case, "eigenvalue", "SI", eigenvalue)
        row(case, "decay_rate", "1/s", rate)
    largest, gains, width = largest_friction_slope(axis), sufficient_gains(axis), least_width(axis)
    smooth = Plant(machine.axis.replace(coulomb_width=width), cogging=machine.cogging, encoder=machine.encoder)
    least = float(least_feedback_gain(axis, axis.error_gain, steep, rough))
    row("largest friction slope", "g_f", "s/m", largest)
    row("at the largest friction slope", "speed", "m/s", speed_of_slope(largest))
    row("least of S_f", "width", "m/s", width)
    row("with that S_f", "e_2", "m", rms(smooth, coulomb_width=width), axis.error_rms[2])
    row("largest without friction slope", "slope_share", "1", largest_cogging_share(axis))
    row("positive in the run", "sample_share", "1", positive_share(axis, machine, log))
    row("least at the printed k_1", "k_s1", "V/(m/s)", least, axis.feedback_gain)
    row("sufficient gains", "k_1", "1/s", gains["error_gain"], axis.error_gain)
    row("sufficient gains", "k_s1", "V/(m/s)", gains["feedback_gain"], axis.feedback_gain)
    row("sufficient gains", "e_2", "m", rms(machine, **gains), axis.error_rms[2])
    return Table(f"matrix29_{axis.name}", f"Matrix (29) of C3, {axis.name} axis", rows)


# The theorem on random machines ---------------------------------------------------------------------------------------

SHOWN = 24  # number of the random machine in the figure: one that breaks both bounds without u_s2
SHOWN_FOR = 0.12  # s of it
EPSILON = 0.002  # V m/s, of (20) and (30), not reported
DISTURBANCE = 0.3  # V, delta_d of (12), not reported
SAMPLE_RATE = 20000.0  # Hz, in place of continuous time
DURATION = 0.5  # s, of a run
SETTLED = 10.0  # time constants 1 / lambda after which exp(-lambda t) is negligible
Law = type[Arc] | type[Dcarc]
MACHINES = 4  # of each axis and controller in `reproduce`
EPSILONS = (1.0, 0.1, 0.01)  # V m/s, with which the printed gains run on the tables' machine
SMOOTHER = 1.01  # times the least width of S_f with which the printed gains satisfy (29)
BEYOND = 30.0  # times delta_d: a d~ beyond the bound that the controller assumes
FASTER = 30.0  # times the printed adaptation rates, which need hundreds of periods; the theorem leaves Gamma open
PERIODS = {"X": 8, "Y": 4}  # moves there and back in `reproduce`
RATES = (5000.0, 10000.0, 20000.0)  # Hz
KEPT = 1000.0  # rows of the error a second


@dataclass(frozen=True)
class Trial:
    """A machine within the printed bounds, a controller and its start."""

    law: Law
    plant: Plant  # with an ideal encoder
    parameters: AdaptiveRobustParameters  # with u_s2
    theta: FloatArray  # true parameters in the order of the controller's estimates, (4 + coefficients,)
    motion: _core.Reference
    start: float  # m
    rate: float  # lambda, 1/s

    def run(self, **changes: Any) -> Log:
        """Return the log with estimates; changes: of the controller, such as epsilon=0 to leave u_s2 out."""
        law, options = self.law(self.parameters.replace(**changes)), {"record_estimates": True}
        return closed_loop(self.plant, law, self.motion, duration=DURATION, initial_position=self.start, **options)

    def lyapunov(self, log: Log) -> FloatArray:
        """Return V of the true state, W s: (22), for Dcarc with the term in e^2."""
        k, mass = self.parameters.error_gain, self.plant.axis.mass
        e = known(log.true_position) - known(log.reference)
        p = known(log.true_velocity) - known(log.reference_velocity) + k * e
        return 0.5 * mass * (p**2 + ((k * e) ** 2 if self.law is Dcarc else 0.0))

    def bound(self, log: Log, first: float) -> FloatArray:
        """Return the right side of (23) from a first V on."""
        gone = np.exp(-self.rate * (log.time - log.time[0]))
        return np.asarray(gone * first + EPSILON / self.rate * (1.0 - gone))

    def holds(self, log: Log) -> bool:
        """Return whether V stays below the bound at every sample."""
        found = self.lyapunov(log)
        return bool((found <= self.bound(log, float(found[0])) * (1.0 + 1e-12)).all())

    def settled(self, log: Log) -> float:
        """Return the largest V, over epsilon / lambda, after the start is forgotten."""
        return float(self.lyapunov(log)[log.time > SETTLED / self.rate].max() * self.rate / EPSILON)

    def settled_error(self, log: Log) -> float:
        """Return the largest true |e| in the second half of the run, m."""
        late = log.time > 0.5 * DURATION
        return float(np.abs(known(log.true_position) - known(log.reference))[late].max())

    def error_bound(self) -> float:
        """Return the bound of |e| in the end, m: by (23) V <= epsilon / lambda bounds p, and |e| <= max |p| / k_1."""
        return float(np.sqrt(2.0 * EPSILON / (self.rate * self.plant.axis.mass)) / self.parameters.error_gain)

    def robust_term(self, log: Log) -> tuple[float, float]:
        """Return the largest p (u_s2 - phi^T theta~ + d~) / epsilon, d~ the worst, and p u_s2 / epsilon of a run."""
        q = self.parameters
        velocity = np.diff(log.position, prepend=log.position[0]) * q.sample_rate
        error_rate = velocity - known(log.reference_velocity)
        p = error_rate + q.error_gain * log.error
        x, v, a = known(log.reference), known(log.reference_velocity), known(log.reference_acceleration)
        if self.law is Arc:
            x, v, a = log.position, velocity, a - q.error_gain * error_rate
        assert self.plant.cogging is not None
        friction, cogging = _core.smooth_sign(v, q.coulomb_width), self.plant.cogging.basis.regressor(x)
        phi, estimates = -np.column_stack([a, v, friction, -np.ones_like(a), cogging]), known(log.estimates)
        u_s2 = log.command + q.feedback_gain * p + np.sum(phi * estimates, axis=1)
        rest = np.abs(p) * q.disturbance_bound - p * np.sum(phi * (estimates - self.theta), axis=1)
        return float(np.max(p * u_s2 + rest)) / EPSILON, float(np.max(p * u_s2)) / EPSILON

    def with_disturbance(self, factor: float) -> Trial:
        """Return the same trial with a constant d~ of `factor` times delta_d and no other."""
        push = ConstantForce(force=self.plant.effects[0].force + factor * DISTURBANCE)
        return replace(self, plant=Plant(self.plant.axis, cogging=self.plant.cogging, effects=[push]))


def draw(axis: GantryAxis, seed: int, law: Law, *, width: float = COULOMB_WIDTH, **gains: Any) -> Trial:
    """Draw a machine inside the printed bounds or at their corners, estimates within them, d~ within delta_d.

    width: of S_f, in machine and controller, m/s; gains: error_gain (1/s), feedback_gain (V/(m/s)) for the printed.
    """
    rng = np.random.default_rng([2008, 1, seed])
    truth = [float(rng.choice([rng.uniform(*bound), *bound])) for bound in axis.bounds]
    estimates: dict[str, Any] = dict(zip(ESTIMATED, [rng.uniform(*bound) for bound in axis.bounds], strict=True))
    basis, largest = gantry.cogging_basis(axis.compensated), axis.cogging_bound
    shape = (2, len(axis.compensated), basis.spline.control_points)
    cogging = CoggingModel(basis, *rng.uniform(-largest, largest, shape))
    share, phase, side = rng.uniform(), rng.uniform(0.0, 2.0 * np.pi), rng.choice([-1.0, 1.0])
    size, frequency = DISTURBANCE * share, float(10 ** rng.uniform(0.0, 2.0))
    effects: list[Any] = [
        ConstantForce(force=truth[3]),
        DisturbanceTone(frequency=frequency, sine=size * np.cos(phase), cosine=size * np.sin(phase)),
        DisturbanceStep(force=side * (DISTURBANCE - size), start=rng.uniform(0.0, 0.2), stop=rng.uniform(0.3, 0.6)),
    ]
    mass, viscous, coulomb, _ = truth
    body = AxisParameters(mass=mass, viscous=viscous, coulomb=coulomb, coulomb_width=width, travel=list(gantry.TRAVEL))
    changes: dict[str, Any] = {"sample_rate": SAMPLE_RATE, "coulomb_width": width, "error_difference": False}
    changes |= {"epsilon": EPSILON, "disturbance_bound": DISTURBANCE}
    parameters = controller_parameters(axis, "C3", **changes, **estimates, **gains)
    start = START + float(rng.uniform(-1.0, 1.0) * rng.choice([0.0, 1e-4, 1e-3]))
    plant, theta = Plant(body, cogging=cogging, effects=effects), np.array([*truth, *cogging.coefficients])
    motion = gantry.reference(axis, repeats=1)
    return Trial(law, plant, parameters, theta, motion, start, rate_of(axis, law, parameters))


def rate_of(axis: GantryAxis, law: Law, parameters: AdaptiveRobustParameters) -> float:
    """Return lambda of (23), 1/s, over the printed bounds; at most zero if Dcarc's gains do not satisfy (29)."""
    if law is Arc:
        return 2.0 * parameters.feedback_gain / axis.bounds[0][1]
    slopes = {"friction_slope": friction_slope_max(parameters.coulomb_width), "cogging_slope": steepest(axis)[1]}
    return _core.desired_compensation_condition(parameters, **slopes)[1]


def growth_at_rest(axis: GantryAxis, **gains: Any) -> float:
    """Return the largest V of DCARC over its first one at rest with exact parameters and no d~.

    The start is the (p, e) with the smallest z^T Q z at 0.1 mm/s; where (29) is positive, V only falls.
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
    motion = _core.Sampled(t, np.full_like(t, START), np.zeros_like(t), np.zeros_like(t))
    plant = Plant(AxisParameters(**values, coulomb_width=COULOMB_WIDTH, travel=list(gantry.TRAVEL)))
    trial = Trial(Dcarc, plant, parameters, np.zeros(0), motion, START + scale * ke / k, 0.0)
    log = closed_loop(plant, Dcarc(parameters), motion, initial_position=trial.start, initial_velocity=scale * (p - ke))
    found = trial.lyapunov(log)
    return float(found.max() / found[0])


def groups(axis: GantryAxis) -> tuple[tuple[Law, str, dict[str, float]], ...]:
    """Return law, name of the gains and keywords of `draw` of the controllers that meet the conditions."""
    smooth = {"width": SMOOTHER * least_width(axis)}
    return ((Arc, "printed", {}), (Dcarc, "printed, smooth S_f", smooth), (Dcarc, "sufficient", sufficient_gains(axis)))


def theorem_table(axis: GantryAxis, machine: Plant) -> Table:
    """Tabulate Theorem 1 A on random machines for each of `groups`, and DCARC with the printed gains.

    held: share of machines whose V stays below its bound; v_settled: largest V over epsilon / lambda after the start;
    e_bound, e_inf: what (23) says of |e| then, and |e|. The last rows: C3 on `machine` with its printed gains and u_s2.
    """
    rows: list[Row] = []

    def row(law: Law, gains: str, case: str, index: str, unit: str, value: float) -> None:
        rows.append(explored(law.__name__.upper(), index, unit, value, gains=gains, case=case))

    def against_the_bound(law: Law, gains: str, case: str, runs: Sequence[tuple[Trial, Log]]) -> None:
        row(law, gains, case, "held", "1", float(np.mean([trial.holds(log) for trial, log in runs])))
        row(law, gains, case, "v_settled", "1", max(trial.settled(log) for trial, log in runs))

    def error(law: Law, gains: str, runs: Sequence[tuple[Trial, Log]]) -> None:
        row(law, gains, "u_s2 on", "e_inf", "m", max(trial.settled_error(log) for trial, log in runs))

    for law, gains, conditions in groups(axis):
        trials = [draw(axis, seed, law, **conditions) for seed in range(MACHINES)]
        runs = [(trial, trial.run()) for trial in trials]
        row(law, gains, "u_s2 on", "decay_rate", "1/s", trials[0].rate)
        against_the_bound(law, gains, "u_s2 on", runs)
        row(law, gains, "u_s2 on", "e_bound", "m", max(trial.error_bound() for trial in trials))
        error(law, gains, runs)
        for number, term in enumerate(np.max([trial.robust_term(log) for trial, log in runs], axis=0), start=1):
            row(law, gains, "(20) or (30), over epsilon", f"condition_{number}", "1", term)
        against_the_bound(law, gains, "u_s2 off", [(trial, trial.run(epsilon=0.0)) for trial in trials])
        beyond = trials[0].with_disturbance(BEYOND)
        against_the_bound(law, gains, f"{BEYOND:.0f} delta_d, machine 0", [(beyond, beyond.run())])
    trials = [draw(axis, seed, Dcarc) for seed in range(MACHINES)]
    row(Dcarc, "printed", "u_s2 on", "decay_rate", "1/s", trials[0].rate)
    error(Dcarc, "printed", [(trial, trial.run()) for trial in trials])
    row(Dcarc, "printed", "at rest", "v_growth", "1", growth_at_rest(axis))
    row(Dcarc, "sufficient", "at rest", "v_growth", "1", growth_at_rest(axis, **sufficient_gains(axis)))
    bounded = [dict[str, Any](epsilon=epsilon, disturbance_bound=DISTURBANCE) for epsilon in EPSILONS]
    with_u_s2 = [Dcarc(controller_parameters(axis, "C3", **changes)) for changes in bounded]
    errors = gantry.last_move(with_u_s2, [machine] * len(with_u_s2), gantry.reference(axis)).indexes["error_rms"]
    for epsilon, found in zip(EPSILONS, errors, strict=True):
        case = {"case": f"5 kHz, epsilon {epsilon:g}"}
        rows.append(Row("C3", "e_2", "m", axis.error_rms[2], float(found), "exploratory", case))
    title = f"Theorem 1 A on {MACHINES} drawn machines, {axis.name} axis: V, and its bound {EPSILON:g} V m/s / lambda"
    return Table(f"theorem1a_{axis.name}", title, rows)


def errors_by_period(
    axis: GantryAxis, sample_rate: float, periods: int, *, faster: float = 1.0, **gains: float
) -> FloatArray:
    """Return the rms error (m) of DCARC in each move there and back on a random machine with d~ = 0, (periods,).

    faster: factor on all printed adaptation rates; gains: as of `draw`.
    """
    trial, motion = draw(axis, 0, Dcarc), gantry.reference(axis, repeats=periods)
    printed = controller_parameters(axis, "C3")
    names = [f"{name}_adaptation" for name in (*ESTIMATED, "cogging")]
    changes: dict[str, Any] = {name: faster * getattr(printed, name) for name in names}
    changes |= {name: getattr(trial.parameters, name) for name in ESTIMATED}
    law, columns = Dcarc(printed.replace(sample_rate=sample_rate, **changes, **gains)), ("true_position", "reference")
    machine, every = trial.with_disturbance(0.0).plant, round(sample_rate / KEPT)
    batch = closed_loop_batch([machine], [law], motion, columns=columns, every=every)
    for failure in batch.failures:
        raise _core.DivergedError(failure.reason)
    error = batch.columns["true_position"][0] - batch.columns["reference"][0]
    rows = round(motion.period * KEPT)
    return np.asarray(np.sqrt(np.mean(error[: periods * rows].reshape(periods, rows) ** 2, axis=1)))


def decays(axis: GantryAxis) -> dict[str, FloatArray]:
    """Return errors_by_period as printed at 5 kHz, and at RATES with sufficient gains and FASTER adaptation."""
    gains, periods = sufficient_gains(axis), PERIODS[axis.name]
    found = {"printed, 5 kHz": errors_by_period(axis, RATES[0], periods)}
    for rate in RATES:
        found[f"sufficient, {rate / 1000:g} kHz"] = errors_by_period(axis, rate, periods, faster=FASTER, **gains)
    return found


def convergence_table(found: Mapping[str, Mapping[str, FloatArray]]) -> Table:
    """Tabulate the error of the first and the last period of `decays`, by axis."""
    rows = [
        explored("DCARC", "e_2", "m", errors[period - 1], axis=axis, case=case, period=str(period))
        for axis, by_case in found.items()
        for case, errors in by_case.items()
        for period in (1, len(errors))
    ]
    faster = f"gains sufficient for (29) and adaptation {FASTER:.0f} times faster, or both as printed"
    return Table("theorem1b", f"Theorem 1 B: the rms error where only parameters are uncertain; {faster}", rows)


@drawn
def figure_theorem(found: Mapping[str, Mapping[str, FloatArray]]) -> Figure:
    """Draw Theorem 1: V with and without u_s2 and its bound, of ARC and DCARC; below the errors of `decays` by axis."""
    from matplotlib.ticker import LogLocator

    title = "Theorem 1: V and its bound (X axis, one drawn machine), and the error without d~"
    figure, panels = titled_panels(title, (8.4, 6.6), 2, 2)
    _draw_bound(panels[0][0], Arc, {}, "A, ARC, printed gains")
    _draw_bound(panels[0][1], Dcarc, sufficient_gains(AXES["X"]), "A, DCARC, sufficient gains")
    for axes, (name, by_case) in zip(panels[1], found.items(), strict=True):
        scale = scale_of("m", *by_case.values())
        for place, (case, errors) in enumerate(by_case.items()):
            axes.plot(1 + np.arange(len(errors)), scale(errors), label=case, marker=marker(place), **look(place))
        axes.set(xlabel="move there and back", ylabel=scale.label("rms error"), yscale="log")
        axes.set_title(f"B, {name} axis", loc="left", pad=36.0)
        axes.xaxis.get_major_locator().set_params(integer=True)
        axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter("")
        legend(axes, 2)
    return figure


def _draw_bound(axes: Axes, law: Law, gains: dict[str, float], said: str) -> None:
    """Draw V and its bound of the machine SHOWN of the X axis."""
    trial = draw(AXES["X"], SHOWN, law, **gains)
    on, off = trial.run(), trial.run(epsilon=0.0)
    bound = trial.bound(on, float(trial.lyapunov(on)[0]))
    shown = on.time <= SHOWN_FOR
    axes.plot(1e3 * on.time[shown], trial.lyapunov(on)[shown], label="u_s2 on", **look(0))
    axes.plot(1e3 * on.time[shown], trial.lyapunov(off)[shown], label="u_s2 off", **look(2))
    axes.plot(1e3 * on.time[shown], bound[shown], label="bound (23)", **{**PRINTED, "linewidth": 2.0})
    axes.set(xlabel="time (ms)", ylabel="V (V m)", yscale="log")
    axes.set_ylim(1e-4 * float(bound[shown].max()), None)
    axes.set_title(said, loc="left", pad=22.0)
    legend(axes, 3)
