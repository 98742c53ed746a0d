"""The result of identify: parameters with intervals, and warnings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cogging import plot
from cogging.arrays import FloatArray
from cogging.calls import entry_named
from cogging.identification.unmodelled import MISSING
from cogging.log_check.log_audit import Audit
from cogging.model.model import Model
from cogging.plot.canvas import plot_method
from cogging.tables import frame_of, html_table
from cogging.values import ByValue

CORRELATED = 0.8  # correlation above which two parameters are listed as correlated
EXPLAINED = 0.5  # share of the command's power below which the model is said to explain too little
CHECK = 5.0  # difference of the two estimators, in standard deviations, from which they contradict each other
WORSE = 1.05  # residual or replay error over that of the model as given, from which the fit is worse
SHOWN = 3  # parameters that one sentence names
#: Names in JSON.
RENAMED = {"difference": "difference_sigma", "spread": "spread_between_logs", "single_sigma": "sigma_of_single_logs"}
RENAMED |= {"replay": "replay_relative_error", "replay_before": "replay_relative_error_before"}


@dataclass(frozen=True)
class ParameterEstimate:
    """One parameter of the model, before and after; None where it has no such number."""

    path: str  # in the model
    unit: str  # in the labels of the model
    prior: float  # value before the fit
    value: float  # fitted; the prior if the logs do not determine it or unmodelled forces hide it
    ci95: tuple[float, float]  # 95 % interval; infinite if the logs do not determine it
    determined: bool  # whether they do
    inverse_dynamics: float | None  # value of each estimator; None if it does not depend on the parameter
    output_error: float | None
    difference: float | None  # of the two, over its standard deviation if they were independent
    spread: float | None  # standard deviation of the values of logs fitted one by one, if two or more determine it
    single_sigma: float | None  # rms of the standard deviations of those fits
    note: str  # how well it is determined, or why not
    elsewhere: Mapping[str, float]  # values beyond the interval that other ways of fitting give, by the way

    def to_dict(self) -> dict[str, Any]:
        """Return all but the path for JSON; an infinite interval is null."""
        fields = {RENAMED.get(name, name): value for name, value in vars(self).items() if name != "path"}
        return {**fields, "ci95": list(self.ci95) if self.determined else None, "elsewhere": dict(self.elsewhere)}


@dataclass(frozen=True)
class LogFit:
    """The fit on one log; forces are rms below the cut-off over the rows in motion, V."""

    name: str  # of the file, or the log's number
    rows: int  # that counted
    residual_before: float  # of the force balance
    residual_after: float
    residual_free: float  # the same if parameters that are not determined moved too
    floor: float  # what quantiser and stated encoder noise alone would leave
    noise: float | None  # that no force explains; None if the balance does not contain the whole model
    command: float
    #: Share of the command's power that the model explains, 1 - (residual_after / command)^2; below 0 if it is worse
    #: than no model. From the replay if the balance does not contain the whole model.
    explained: float
    replay_before: Mapping[str, float]  # as `replay`, of the model as it was given
    replay: Mapping[str, float]  # relative errors of position, velocity and command; empty without a controller
    instruments: bool  # whether a simulated run served as instruments; else plain least squares

    def to_dict(self) -> dict[str, Any]:
        """Return all of it for JSON."""
        fields = {RENAMED.get(name, name): value for name, value in vars(self).items()}
        return {name: dict(value) if isinstance(value, Mapping) else value for name, value in fields.items()}


@dataclass(frozen=True, eq=False, repr=False)
class Identification(ByValue):
    """The fit of a model to logs. Printed, it is its `text`.

    Attributes:
        model: with the fitted values and their intervals in `[bounds]`.
        parameters: one entry a free parameter.
        correlation: of the estimates, (p, p), in the order of `parameters`; 0 where not determined.
        covariance: of the determined ones, in the same order, 0 elsewhere.
        determinability: what the logs can and cannot determine, in words.
        logs: one entry a log.
        audits: of the logs, one a log.
        cutoff: of the inverse dynamics' filter, Hz.
        estimator: whose values are reported: "inverse_dynamics" or "output_error".
        controller: remarks on the stated controller, one line a log.
        notes: further remarks on the logs, such as rows that several of them share.
        explained: share of the command's power that the model explains, of all logs together.
        warnings: what speaks against the fit, a sentence each.
    """

    model: Model
    parameters: tuple[ParameterEstimate, ...]
    correlation: FloatArray
    covariance: FloatArray
    determinability: tuple[str, ...]
    logs: tuple[LogFit, ...]
    audits: tuple[Audit, ...]
    cutoff: float
    estimator: str
    controller: tuple[str, ...]
    notes: tuple[str, ...] = ()
    explained: float = 1.0
    warnings: tuple[str, ...] = ()

    def _brief(self) -> str:
        sure, logs = sum(p.determined for p in self.parameters), len(self.logs)
        which = f"{sure} of {len(self.parameters)} parameters determined by {logs} log{'s' * (logs != 1)}"
        return f"{which}, {self.estimator}"

    def __getitem__(self, path: str) -> ParameterEstimate:
        """The parameter at a path; KeyError: no such free parameter."""
        return entry_named(path, {parameter.path: parameter for parameter in self.parameters}, "free parameter")

    def text(self) -> str:
        """The fit for the screen: warnings, audit of each log, what they can determine, parameters, what is left."""
        lines = [f"warning: {warning}" for warning in self.warnings]
        lines += [""] if lines else []
        for log, audit in zip(self.logs, self.audits, strict=True):
            lines += [log.name, *(f"  {line}" for line in audit.text().splitlines())]
        lines += ["", "What the logs can determine (1 sigma):"]
        lines += [f"  {line}" for line in self.determinability]
        lines += ["", f"Fit ({self.estimator.replace('_', ' ')}, below {self.cutoff:g} Hz):", *self._table()]
        table = np.abs(np.tril(self.correlation, -1))
        worst = [divmod(int(k), len(table)) for k in np.argsort(-table, axis=None)[:4]]
        path = [p.path for p in self.parameters]
        pairs = [f"{path[j]} and {path[i]} {self.correlation[i, j]:+.2f}" for i, j in worst if table[i, j] > CORRELATED]
        lines += [f"  correlated: {', '.join(pairs)}"] * bool(pairs)
        lines += [f"  share of the command explained: {percent(self.explained)}", ""]
        v = self.model.units.command
        for log in self.logs:
            after = f"{log.residual_after:.4g} {v} after"
            if log.residual_after > 1.05 * log.residual_free:
                after += f" ({log.residual_free:.4g} {v} if what stays as given moved too)"
            floor = f"quantiser and encoder noise alone {log.floor:.2g} {v} ({log.rows} rows in motion)"
            lines.append(f"{log.name}: force balance {log.residual_before:.4g} {v} before, {after}, {floor}")
            noise = "" if log.noise is None else f"; all noise some {log.noise:.2g} {v}"
            lines.append(f"  explains {percent(log.explained)} of a command of {log.command:.4g} {v}{noise}")
            if log.replay:
                errors = ", ".join(f"{name} {100 * value:.3g} %" for name, value in log.replay.items())
                lines.append(f"  closed-loop replay, relative error: {errors}")
        return "\n".join([*lines, *self.controller, *(f"note: {note}" for note in self.notes)])

    def to_frame(self) -> Any:
        """The parameters as a pandas DataFrame (extra `frames`), a row each; an unknown interval is infinite."""
        rest, rows = ("prior", "unit", "determined", "note"), []
        for p in self.parameters:
            known = {"parameter": p.path, "value": p.value, "low": p.ci95[0], "high": p.ci95[1]}
            rows.append(known | {name: getattr(p, name) for name in rest})
        return frame_of(rows, {})

    def _repr_html_(self) -> str:
        ends = [p.ci95 if p.determined else (None, None) for p in self.parameters]
        rows = [[p.path, p.prior, p.value, *e, p.unit, p.note] for p, e in zip(self.parameters, ends, strict=True)]
        headers = ["parameter", "before", "fitted", "from", "to", "unit", ""]
        title = f"Identification: {percent(self.explained)} of the command explained"
        return html_table(title, headers, rows, [*self.warnings, *self.notes])

    plot = plot_method(plot.intervals, "Draw the parameters with their 95 % intervals, and the prior values.", "axes")

    def to_dict(self) -> dict[str, Any]:
        """All of it for JSON; an infinite interval is null."""
        pairs = zip(self.logs, self.audits, strict=True)
        return {
            "warnings": list(self.warnings),
            "explained": self.explained,
            "estimator": self.estimator,
            "cutoff": self.cutoff,
            "parameters": {p.path: p.to_dict() for p in self.parameters},
            "correlation": self.correlation.tolist(),
            "determinability": list(self.determinability),
            "logs": [{**log.to_dict(), "audit": audit.to_dict()} for log, audit in pairs],
            "controller": list(self.controller),
            "notes": list(self.notes),
        }

    def _table(self) -> list[str]:
        width = max(len("parameter"), *(len(p.path) for p in self.parameters))
        lines = [f"  {'parameter':<{width}} {'prior':>11} {'value':>11}   {'95 % interval':<26} {'check':<11} unit"]
        for p in self.parameters:
            interval = f"[{p.ci95[0]:.5g}, {p.ci95[1]:.5g}]" if p.determined else "not determined"
            check = "" if p.difference is None else f"{p.difference:+.1f} sigma"
            lines.append(f"  {p.path:<{width}} {p.prior:>11.5g} {p.value:>11.5g}   {interval:<26} {check:<11} {p.unit}")
            if p.spread is not None:
                lines[-1] += f"; logs one by one spread by {p.spread:.2g}, each +- {p.single_sigma:.2g}"
        return lines


def percent(share: float) -> str:
    """Format a share as a percentage, with more digits the closer it is to 1."""
    digits = int(np.clip(-np.floor(np.log10(max(abs(1.0 - share), 1e-6))) - 1, 0, 3))
    return f"{100.0 * share:.{digits}f} %"


def warnings_of(
    logs: Sequence[LogFit], parameters: Sequence[ParameterEstimate], held: Sequence[str], unit: str
) -> tuple[str, ...]:
    """Sentences that speak against a fit, the most important first; `held`: paths kept because of unmodelled forces."""
    warnings = []
    for log in logs:
        worse = f"{log.name}: the fit is worse than the model as given"
        missing = log.noise is not None and log.residual_free > MISSING * log.noise
        if missing:
            noise = max(log.noise or 0.0, 1e-300)
            leaves = f"{log.residual_free:.3g} {unit}, {log.residual_free / noise:.3g} times the noise"
            share = percent(1.0 - (log.residual_free / max(log.command, 1e-300)) ** 2)
            said = f"the model leaves {leaves} ({noise:.2g} {unit}), and explains {share} of the command"
            warnings.append(f"{log.name}: something is missing: {said}: run diagnose")
        if log.explained < EXPLAINED and not missing:
            warnings.append(f"{log.name}: the model explains only {percent(log.explained)} of the command")
        if log.residual_after > WORSE * log.residual_before:
            balance = f"{log.residual_before:.4g} {unit} before, {log.residual_after:.4g} {unit} after"
            warnings.append(f"{worse}: force balance {balance}")
        for name in ("position", "command"):
            before, after = log.replay_before.get(name), log.replay.get(name)
            if before is not None and after is not None and after > WORSE * before:
                errors = f"{100 * before:.3g} % before, by {100 * after:.3g} % after"
                warnings.append(f"{worse}: replayed {name} off by {errors}")
        if log.replay_before and not log.replay:
            warnings.append(f"{worse}: its replay diverges")
    if held:
        warnings.append(f"unmodelled forces are too strong to fit {_listed(held)}: kept as given")
    apart = [p for p in parameters if p.path not in held and abs(p.difference or 0.0) > CHECK]
    apart.sort(key=lambda p: -abs(p.difference or 0.0))
    if apart:
        said = "{0.path} ({0.inverse_dynamics:.4g} and {0.output_error:.4g} {0.unit}, {1:.2g} sigma)"
        shown = [said.format(p, abs(p.difference or 0.0)) for p in apart]
        warnings.append(f"inverse dynamics and output error contradict each other: {_listed(shown)}")
    ways: dict[str, list[str]] = {}
    for p in parameters:
        for way, value in p.elsewhere.items():
            ways.setdefault(way, []).append(f"{p.path} is {value:.4g} instead of {p.value:.4g} {p.unit}")
    return (*warnings, *(f"{way}, {_listed(entries)}" for way, entries in ways.items()))


def _listed(entries: Sequence[str]) -> str:
    """The first entries in words, and how many more there are."""
    more = len(entries) - SHOWN
    return ", ".join(entries[:SHOWN]) + (f" and {more} more" if more > 0 else "")
