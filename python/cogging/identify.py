"""From measured logs to a fitted model: parameters with intervals, and what the logs cannot tell."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging._core import DivergedError
from cogging.estimation import fit
from cogging.inverse_dynamics import BalanceEstimate, ForceBalance, InverseDynamics, fit_force_balance
from cogging.logs import Log, read_log
from cogging.model import Model
from cogging.parameters import Parameter, Scales, parameters_of, with_values
from cogging.residuals import Innovations, Replay, Residuals

FloatArray = npt.NDArray[np.float64]

UNDETERMINED = 0.5  # 1-sigma, relative to the parameter's size, above which a log does not determine it
TRADE = 0.95  # correlation above which two parameters are said to trade against each other
CUTOFFS = (80.0, 40.0, 20.0, 10.0)  # Hz, of the inverse dynamics' filter: the first at which ...
READING_SHARE = 0.5  # ... quantiser and encoder noise alone make less than this share of the residual's rms


@dataclass(frozen=True)
class ParameterEstimate:
    """One parameter of the model, before and after.

    Attributes:
        path: where it stands in the model.
        unit: SI and V.
        prior: as the model had it.
        value: as fitted; the prior where the logs do not determine it.
        ci95: 95 % interval; infinite where the logs do not determine it.
        determined: whether they do.
        inverse_dynamics, output_error: what each estimator says; None where it cannot see the parameter.
        difference: of the two, in units of its standard deviation were they independent; None likewise.
        spread: standard deviation of the mean over logs fitted one by one, or None for a single log.
        note: in words, how well or why not.
    """

    path: str
    unit: str
    prior: float
    value: float
    ci95: tuple[float, float]
    determined: bool
    inverse_dynamics: float | None
    output_error: float | None
    difference: float | None
    spread: float | None
    note: str


@dataclass(frozen=True)
class LogFit:
    """What one log says of the fit.

    Attributes:
        name: of the file, or the log's number.
        rows: that counted.
        residual_before, residual_after: rms of the force balance below the cut-off, V, of the rows in motion.
        floor: what quantiser and stated encoder noise alone would leave, V.
        replay: relative errors of the closed-loop replay, norm of the difference over norm, of position, velocity and
            command; empty without a controller.
    """

    name: str
    rows: int
    residual_before: float
    residual_after: float
    floor: float
    replay: Mapping[str, float]


@dataclass(frozen=True)
class Identification:
    """The fit of a model to logs.

    Attributes:
        model: with the fitted values and their intervals in `[bounds]`.
        parameters: one entry a free parameter.
        correlation: of the estimates, (p, p), in the order of `parameters`; 0 where not determined.
        covariance: of the determined ones, in the same order, 0 elsewhere.
        determinability: what the logs can and cannot determine, in words, known before the fit.
        logs: one entry a log.
        cutoff: of the inverse dynamics' filter, Hz.
        estimator: whose values are reported: "inverse_dynamics" or "output_error".
        controller: what the audit says of a stated controller, one line a log.
    """

    model: Model
    parameters: tuple[ParameterEstimate, ...]
    correlation: FloatArray
    covariance: FloatArray
    determinability: tuple[str, ...]
    logs: tuple[LogFit, ...]
    cutoff: float
    estimator: str
    controller: tuple[str, ...] = ()

    def __getitem__(self, path: str) -> ParameterEstimate:
        """The parameter at a path.

        Raises:
            KeyError: no such free parameter.
        """
        for parameter in self.parameters:
            if parameter.path == path:
                return parameter
        raise KeyError(path)

    def text(self) -> str:
        """The fit for the screen."""
        lines = ["What the logs can determine:"]
        lines += [f"  {line}" for line in self.determinability]
        lines += ["", f"Fit ({self.estimator.replace('_', ' ')}, below {self.cutoff:g} Hz):"]
        width = max(len(p.path) for p in self.parameters)
        lines.append(
            f"  {'parameter':<{width}} {'prior':>11} {'value':>11}   95 % interval              check      unit"
        )
        for p in self.parameters:
            interval = f"[{p.ci95[0]:.5g}, {p.ci95[1]:.5g}]" if p.determined else "not determined"
            check = "" if p.difference is None else f"{p.difference:+.1f} sigma"
            lines.append(f"  {p.path:<{width}} {p.prior:>11.5g} {p.value:>11.5g}   {interval:<26} {check:<10} {p.unit}")
            if p.spread is not None:
                lines[-1] += f"; spread between logs {p.spread:.2g}"
        pairs = [
            (abs(self.correlation[i, j]), i, j)
            for i in range(len(self.parameters))
            for j in range(i)
            if abs(self.correlation[i, j]) > 0.8
        ]
        if pairs:
            lines.append("  correlated: ")
            lines[-1] += ", ".join(
                f"{self.parameters[j].path} and {self.parameters[i].path} {self.correlation[i, j]:+.2f}"
                for _, i, j in sorted(pairs, reverse=True)[:4]
            )
        lines.append("")
        for log in self.logs:
            lines.append(
                f"{log.name}: force balance {log.residual_before:.4g} V before, {log.residual_after:.4g} V after, "
                f"quantiser and encoder noise alone {log.floor:.2g} V ({log.rows} rows in motion)"
            )
            if log.replay:
                errors = ", ".join(f"{name} {100 * value:.3g} %" for name, value in log.replay.items())
                lines.append(f"  closed-loop replay, relative error: {errors}")
        lines += list(self.controller)
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """All of it for JSON."""
        return {
            "estimator": self.estimator,
            "cutoff": self.cutoff,
            "parameters": {
                p.path: {
                    "unit": p.unit,
                    "prior": p.prior,
                    "value": p.value,
                    "ci95": list(p.ci95) if p.determined else None,
                    "determined": p.determined,
                    "inverse_dynamics": p.inverse_dynamics,
                    "output_error": p.output_error,
                    "difference_sigma": p.difference,
                    "spread_between_logs": p.spread,
                    "note": p.note,
                }
                for p in self.parameters
            },
            "correlation": self.correlation.tolist(),
            "determinability": list(self.determinability),
            "logs": [
                {
                    "name": log.name,
                    "rows": log.rows,
                    "residual_before": log.residual_before,
                    "residual_after": log.residual_after,
                    "floor": log.floor,
                    "replay_relative_error": dict(log.replay),
                }
                for log in self.logs
            ],
            "controller": list(self.controller),
        }


def identify(
    logs: Log | str | os.PathLike[str] | Sequence[Log | str | os.PathLike[str]],
    model: Model | str | os.PathLike[str],
    *,
    free: Sequence[str] | None = None,
    cutoff: float | None = None,
    rest: float | None = None,
    added_commands: Sequence[npt.ArrayLike | None] | None = None,
    names: Sequence[str] | None = None,
) -> Identification:
    """Fit the parameters of a model to one or several logs together.

    Two estimators: inverse dynamics with instruments from a simulated run (reported, since it weighs all motion below
    the cut-off alike, and so bears a model that is not quite true), and the whitened output error of the closed-loop
    replay (where the controller is known, else the whitened one-step prediction), as a check. Parameters that the
    force balance does not show (of the encoder, of a second mass) are reported from the output error.

    Args:
        logs: one or several, or their files.
        model: the prior, or its file.
        free: paths of the parameters to fit; None: all, but for `axis.coulomb_width` where it is 0 or said to be exact.
        cutoff: of the inverse dynamics' filter, Hz; None: the highest of 80, 40, 20 and 10 Hz at which encoder noise
            does not rule the residual.
        rest: rows slower than this do not count, m/s; None: 2 % of the largest speed.
        added_commands: for each log, what was added to its controller's command, V, (n,), or None.
        names: of the logs, for the text.

    Raises:
        ValueError: a free parameter that the model has not; no logs; a log too short to fit.
    """
    if not isinstance(model, Model):
        model = Model.read(model)
    if isinstance(logs, Log | str | os.PathLike):
        logs = [logs]
    if not logs:
        raise ValueError("logs: must be at least 1, got 0")
    names = list(names or [])
    if not names:
        names = [f"log {i + 1}" if isinstance(log, Log) else os.fspath(log) for i, log in enumerate(logs)]
    read = [log if isinstance(log, Log) else read_log(log) for log in logs]
    return _Fit(model, read, names, free, cutoff, rest, added_commands).run()


class _Fit:
    def __init__(
        self,
        model: Model,
        logs: Sequence[Log],
        names: Sequence[str],
        free: Sequence[str] | None,
        cutoff: float | None,
        rest: float | None,
        added_commands: Sequence[npt.ArrayLike | None] | None,
    ) -> None:
        self.model, self.logs, self.names, self.rest = model, logs, names, rest
        self.added = list(added_commands or [None] * len(logs))
        if len(self.added) != len(logs):
            raise ValueError(f"added_commands: must be one for each log, got {len(self.added)} for {len(logs)}")
        for name, log in zip(names, logs, strict=True):
            if len(log) < 200:
                raise ValueError(f"{name}: rows: must be at least 200 to fit a model, got {len(log)}")
        known = parameters_of(model)
        self.paths = _free_paths(model, known) if free is None else list(free)
        for path in self.paths:
            if path not in known:
                raise ValueError(f"free: {path}: must be one of {', '.join(known)}")
        if not self.paths:
            raise ValueError("free: must name at least one parameter, got none")
        rate = 1.0 / max(float(np.median(np.diff(log.time))) for log in logs)
        self.cutoffs = [cutoff] if cutoff is not None else [c for c in CUTOFFS if c <= 0.1 * rate] or [0.1 * rate]
        self.replays = [self._replay(log, added) for log, added in zip(logs, self.added, strict=True)]

    def _replay(self, log: Log, added: npt.ArrayLike | None) -> Replay | None:
        try:
            return Replay(log, self.model, added_command=added)
        except ValueError:
            return None

    def _simulators(self, balances: Sequence[ForceBalance]) -> list[Callable[[Model], FloatArray] | None]:
        def simulator(replay: Replay) -> Callable[[Model], FloatArray]:
            return lambda model: replay.run(model)["true_position"]

        return [simulator(replay) if replay else None for replay in self.replays]

    def run(self) -> Identification:
        for cutoff in self.cutoffs:
            balances = [ForceBalance.of(log, cutoff=cutoff, rest=self.rest) for log in self.logs]
            if min(int(b.counts.sum()) for b in balances) < 4 * len(self.paths) + 50:
                raise ValueError("logs: must have rows in motion to fit to, got an axis at rest")
            scales = _combined([b.scales for b in balances])
            undetermined, frozen, notes = self._determine(balances, scales)
            paths = [path for path in self.paths if path not in frozen]
            if not paths:
                raise ValueError("logs: must determine at least one free parameter, got motion that shows none of them")
            try:
                estimate = fit_force_balance(self.model, paths, balances, scales, self._simulators(balances))
            except DivergedError:
                estimate = fit_force_balance(self.model, paths, balances, scales, [None] * len(balances))
            floor = max(
                noise_floor(balance, estimate.model) / rms
                for balance, rms in zip(balances, estimate.residual_rms, strict=True)
            )
            if floor < READING_SHARE:
                break
        return self._report(estimate, balances, undetermined, frozen, notes)

    def _determine(
        self, balances: Sequence[ForceBalance], scales: Scales
    ) -> tuple[list[str], list[str], dict[str, str]]:
        """Paths that the logs do not determine, those of them to freeze, and a sentence for each path."""
        known = parameters_of(self.model)
        left, undetermined, notes = list(self.paths), [], {}
        frozen: list[str] = []
        while left:
            parameters = [known[path] for path in left]
            deviation, correlation = _foreseen(self.model, parameters, balances, scales)
            relative = deviation / np.array([_size(p, scales) for p in parameters])
            if not frozen:
                for i, p in enumerate(parameters):
                    partner = int(np.argmax(np.abs(correlation[i]) - np.eye(len(parameters))[i]))
                    trades = len(parameters) > 1 and abs(correlation[i, partner]) > TRADE
                    notes[p.path] = _sentence(p, relative[i], parameters[partner].path if trades else None, balances)
                    if not relative[i] < UNDETERMINED:
                        undetermined.append(p.path)
            worst = int(np.argmax(np.nan_to_num(relative, nan=np.inf)))
            if relative[worst] < UNDETERMINED:
                break
            frozen.append(left.pop(worst))
        return undetermined, frozen, notes

    def _report(
        self,
        estimate: BalanceEstimate,
        balances: list[ForceBalance],
        undetermined: list[str],
        frozen: list[str],
        notes: dict[str, str],
    ) -> Identification:
        prior = parameters_of(self.model)
        paths = [path for path in self.paths if path not in frozen]
        scales = _combined([b.scales for b in balances])
        check = self._output_error(estimate.model, paths)
        seen = _visible(self.model, [prior[path] for path in paths], balances, scales)
        use_check = check is not None and not all(seen)
        values, covariance = (check[0], check[1]) if use_check and check else (estimate.values, estimate.covariance)
        fitted = with_values(self.model, dict(zip(paths, map(float, values), strict=True)))
        quantile = _student(estimate.blocks - len(paths))
        spread = self._spread(fitted, paths, balances, scales)
        entries, everything = [], np.zeros((len(self.paths), len(self.paths)))
        for row, path in enumerate(self.paths):
            determined = path in paths and path not in undetermined
            value, interval = prior[path].value, (-np.inf, np.inf)
            inverse = output = difference = None
            if path in paths:
                i = paths.index(path)
                value = float(values[i])
                inverse = float(estimate.values[i]) if seen[i] else None
                if check is not None:
                    output = float(check[0][i])
                if inverse is not None and output is not None and check is not None:
                    sigma = float(np.sqrt(estimate.covariance[i, i] + check[1][i, i]))
                    difference = (output - inverse) / sigma if sigma > 0 else None
            if determined:
                half = quantile * float(np.sqrt(covariance[i, i]))
                interval = (value - half, value + half)
                for column, other in enumerate(self.paths):
                    if other in paths and other not in undetermined:
                        everything[row, column] = covariance[i, paths.index(other)]
            entries.append(
                ParameterEstimate(
                    path=path,
                    unit=prior[path].unit,
                    prior=prior[path].value,
                    value=value,
                    ci95=interval,
                    determined=determined,
                    inverse_dynamics=inverse,
                    output_error=output,
                    difference=difference,
                    spread=None if spread is None or path not in paths else float(spread[paths.index(path)]),
                    note=notes[path],
                )
            )
        size = np.sqrt(np.diag(everything))
        size[size == 0.0] = 1.0
        intervals = {**self.model.intervals, **{entry.path: entry.ci95 for entry in entries}}
        return Identification(
            model=fitted.replace(intervals=intervals),
            parameters=tuple(entries),
            correlation=everything / np.outer(size, size),
            covariance=everything,
            determinability=tuple(notes[path] for path in self.paths),
            logs=tuple(self._log_fit(i, fitted, balances[i]) for i in range(len(self.logs))),
            cutoff=balances[0].motion.cutoff,
            estimator="output_error" if use_check else "inverse_dynamics",
        )

    def _output_error(self, start: Model, paths: list[str]) -> tuple[FloatArray, FloatArray] | None:
        """Values and covariance of the whitened output error, from the better of two starts."""
        sources: list[Residuals] = []
        for log, replay in zip(self.logs, self.replays, strict=True):
            source: Residuals = replay or Innovations(log, start, rest=self.rest)
            sources.append(source)
        found = []
        for model in (start, self.model):
            try:
                result = fit(model, paths, sources)
            except (DivergedError, ValueError):
                continue
            found.append(result)
        if not found:
            return None
        best = min(found, key=lambda result: result.cost)
        return best.values, best.covariance

    def _spread(
        self, model: Model, paths: list[str], balances: list[ForceBalance], scales: Scales
    ) -> FloatArray | None:
        """Standard deviation of the mean of the values over logs fitted one by one."""
        if len(self.logs) < 2:
            return None
        simulators = self._simulators(balances)
        single = []
        for balance, simulator in zip(balances, simulators, strict=True):
            try:
                single.append(fit_force_balance(model, paths, [balance], scales, [simulator], iterations=3).values)
            except DivergedError:
                return None
        return np.asarray(np.std(single, axis=0, ddof=1) / np.sqrt(len(single)))

    def _log_fit(self, i: int, fitted: Model, balance: ForceBalance) -> LogFit:
        rows, replay = balance.counts, self.replays[i]
        before, after = (np.sqrt(np.mean(r[rows] ** 2)) for r in balance.motion.of([self.model, fitted]))
        errors: dict[str, float] = {}
        if replay is not None:
            try:
                errors = relative_errors(self.logs[i], replay.run(fitted))
            except DivergedError:
                errors = {}
        return LogFit(self.names[i], int(rows.sum()), float(before), float(after), noise_floor(balance, fitted), errors)


def relative_errors(log: Log, run: Mapping[str, FloatArray]) -> dict[str, float]:
    """Norm of measured less simulated over norm of measured: position, velocity and command.

    Both velocities by the same second-order differences of positions that were low-pass filtered at 80 Hz.
    """
    rate = 1.0 / float(np.median(np.diff(log.time)))
    cutoff = min(80.0, 0.1 * rate)
    measured = InverseDynamics(log, cutoff=cutoff)
    simulated = InverseDynamics(log, cutoff=cutoff, along=run["true_position"])

    def ratio(a: FloatArray, b: FloatArray) -> float:
        return float(np.linalg.norm(a - b) / np.linalg.norm(a))

    return {
        "position": ratio(log.position, run["true_position"]),
        "velocity": ratio(measured.middle_velocity, simulated.middle_velocity),
        "command": ratio(log.command, run["command"]),
    }


def noise_floor(balance: ForceBalance, model: Model) -> float:
    """What the quantiser, as the readings show it, and the stated encoder noise leave in the force balance, V."""
    step = np.diff(np.unique(balance.log.position[: 200 * 1000]))
    quantum = float(step[step > 0].min()) if (step > 0).any() else 0.0
    quantum = max(model.encoder.resolution, min(quantum, 1e-3 * balance.scales.position))
    random = np.random.default_rng(0)
    n = len(balance.log)
    noise = quantum * (random.random(n) - 0.5) + model.encoder.noise * random.standard_normal(n)
    shaken = InverseDynamics(balance.log, cutoff=balance.motion.cutoff, along=noise)
    row = model.axis.mass * shaken.acceleration + model.axis.viscous * shaken.middle_velocity
    return float(np.sqrt(np.mean(shaken.filtered(row[None, :])[0, balance.counts] ** 2)))


def _free_paths(model: Model, known: Mapping[str, Parameter]) -> list[str]:
    exact = [f"axis.{name}" for name, sigma in model.uncertainty.items() if sigma == 0.0]
    if model.axis.coulomb_width == 0.0:
        exact.append("axis.coulomb_width")
    return [path for path, p in known.items() if path not in exact and np.isfinite(p.value)]


def _size(parameter: Parameter, scales: Scales) -> float:
    """Against which an error of the parameter is judged."""
    if parameter.positive and parameter.value > 0.0:
        return parameter.value
    return max(abs(parameter.value), scales.of(parameter.unit))


def _combined(scales: Sequence[Scales]) -> Scales:
    names = ("force", "position", "velocity", "acceleration", "time")
    return Scales(
        **{name: max(getattr(s, name) for s in scales) for name in names},
        sample_time=min(s.sample_time for s in scales),
    )


def _foreseen(
    model: Model, parameters: Sequence[Parameter], balances: Sequence[ForceBalance], scales: Scales
) -> tuple[FloatArray, FloatArray]:
    """1-sigma and correlation that a linear fit from the prior foresees."""
    p = len(parameters)
    curvature, parts = np.zeros((p, p)), []
    right = np.zeros(p)
    for balance in balances:
        residual, columns = balance.columns(model, parameters, scales)
        rows = balance.counts
        parts.append((columns[:, rows], residual[rows], balance.block[rows]))
        curvature += parts[-1][0] @ parts[-1][0].T
        right += parts[-1][0] @ parts[-1][1]
    size = np.sqrt(np.diag(curvature))
    dead = size < 1e-12 * np.array([scales.force / scales.of(q.unit) for q in parameters])
    size[dead] = 1.0
    scaled = curvature / np.outer(size, size) + np.diag(np.where(dead, 1.0, 0.0))
    values, vectors = np.linalg.eigh(scaled)
    values = np.maximum(values, 1e-13)  # what rounding leaves of a direction that no row shows
    inverse = (vectors / values) @ vectors.T
    step = -inverse @ (right / size)
    meat, blocks = np.zeros((p, p)), 0
    for columns, residual, block in parts:
        starts = np.flatnonzero(np.diff(block, prepend=-1))
        scores = np.add.reduceat(columns / size[:, None] * (residual + (step / size) @ columns), starts, axis=1)
        meat += scores @ scores.T
        blocks += len(starts)
    covariance = inverse @ meat @ inverse * blocks / max(blocks - p, 1)
    deviation = np.sqrt(np.maximum(np.diag(covariance), 0.0)) / size
    deviation[dead] = np.inf
    spread = np.sqrt(np.diag(inverse))
    correlation = inverse / np.outer(spread, spread)
    return deviation, correlation


def _visible(
    model: Model, parameters: Sequence[Parameter], balances: Sequence[ForceBalance], scales: Scales
) -> list[bool]:
    """Which parameters move the force balance at all."""
    power = np.zeros(len(parameters))
    for balance in balances:
        power += (balance.columns(model, parameters, scales)[1] ** 2).sum(axis=1)
    return [bool(value > 0.0) for value in power]


def _sentence(parameter: Parameter, relative: float, partner: str | None, balances: Sequence[ForceBalance]) -> str:
    name = parameter.path.removeprefix("axis.").removeprefix("effects.")
    if relative < UNDETERMINED:
        text = f"{name}: determined to {100 * relative:.2g} %"
        if not (parameter.positive and parameter.value > 0.0):
            text += " of what would matter" if parameter.value == 0.0 else ""
        return text + (f", in exchange with {partner}" if partner else "")
    if partner is None:
        return f"{name}: not determined, this motion hardly shows it"
    speed = np.concatenate([np.abs(b.motion.middle_velocity[b.counts]) for b in balances])
    travel = max(float(np.ptp(b.log.position)) for b in balances)
    low, high = np.quantile(speed, [0.05, 0.95])
    return (
        f"{name}: not determined, it trades against {partner}: speeds span a factor {high / max(low, 1e-12):.2g}, "
        f"positions {travel:.3g} m"
    )


def _student(freedom: int) -> float:
    """97.5 % quantile of Student's distribution, by Cornish and Fisher's expansion about the normal one."""
    z, f = 1.959963985, float(max(freedom, 3))
    return z + (z**3 + z) / (4 * f) + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * f**2)
