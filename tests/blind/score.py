"""Scores of a blind suite: each result beside its key, rates with Wilson's 95 % bounds, the table of targets.

Rules: a null is a false alarm under any verdict but `no_gap` and `insufficient_excitation`. An effect is detected
under `named`, `ambiguous` and `unlisted`. It is named if an entry of `effects` bears its name, up to `alternatives`.
An entry of confidence >= 0.9 without alternatives whose name is not in the case is confident and wrong, whatever the
verdict; for effects outside the vocabulary all names are wrong but those of the same cause (`tolerated`).
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.stats import binomtest

CONFIDENT = 0.9
DETECTED = ("named", "ambiguous", "unlisted")
ALARMS = (*DETECTED, "controller_mismatch", "error")
BINS = (0.0, 0.5, 0.7, 0.9, 0.97, 1.0)
#: Pairs that shared/diagnosis.md lists as looking alike, of the vocabulary.
LOOK_ALIKE = (
    *({"constant_force", "coulomb_asymmetry"}, {"command_delay", "actuator_lag"}, {"cable_spring", "end_effect"}),
    *({"cogging_harmonic", "force_constant_ripple"}, {"cogging_harmonic", "encoder_periodic_error"}),
    *({"stribeck_friction", "presliding_friction"}, {"force_constant_drift", "disturbance_step"}),
    {"viscous_change", "quadratic_drag"},
)


@dataclass(frozen=True)
class Rate:
    """k of n, with Wilson's 95 % bounds."""

    hits: int
    count: int

    @classmethod
    def of(cls, flags: Iterable[bool]) -> Rate:
        flags = list(flags)
        return cls(sum(map(bool, flags)), len(flags))

    @property
    def value(self) -> float:
        """k / n; NaN of nothing."""
        return self.hits / self.count if self.count else math.nan

    @property
    def bounds(self) -> tuple[float, float]:
        if not self.count:
            return 0.0, 1.0
        interval = binomtest(self.hits, self.count).proportion_ci(method="wilson")
        return float(interval.low), float(interval.high)

    def __str__(self) -> str:
        if not self.count:
            return "-"
        low, high = self.bounds
        return f"{100 * self.value:5.1f} % ({self.hits}/{self.count}; {100 * low:.1f} to {100 * high:.1f})"


def judge(key: Mapping[str, Any], result: Mapping[str, Any], seconds: float = math.nan) -> SimpleNamespace:
    """Judge one result (the contract's JSON, or {"error": text}) by the case's key.

    Returns, beside what the key says of the case:
        truths: names hidden. verdict: as in the result, or `error`. detected: whether something was found.
        right: all truths are named, up to alternatives. names: how many names the result gave, alternatives included;
        apart: the same without the look-alikes of the truths.
        exact: `named` with exactly the truths. first: the first name.
        wrong: names that are confident and wrong.
        stated: (confidence, was right) of each entry without alternatives.
        closed: share of what the true model closes on the confirm log, of the truth's first-order prediction; None
            where nothing can be closed.
        worse: the confirm log got worse by more than 1 %; None without one.
        covered: whether each interval holds its truth; errors: error / Cramer-Rao deviation, one a parameter.
        largest: in the large, the first name, or an alternative of it, is the largest effect; None of misread logs.
        found: how many of the truths are named. said: of a misread log, whether it is said: "kind" with its kind and
            column, "verdict" without, "" not; None of others. A log that is refused with a message that says it counts.
        grows: a gap is larger than one that it should lie under by more than 1 %.
    """
    truths = {entry["name"]: entry for entry in key["effects"]}
    listed = {name for name, entry in truths.items() if entry["in_vocabulary"]}
    fine = listed | {name for entry in truths.values() for name in entry["tolerated"]}
    verdict = "error" if "error" in result else str(result["verdict"])
    effects = list(result.get("effects") or [])
    classes = [{entry["name"], *entry.get("alternatives", [])} for entry in effects]
    named = {name for one in classes for name in one}
    wrong, stated = [], []
    for entry, names in zip(effects, classes, strict=True):
        if len(names) == 1:
            good = entry["name"] in fine
            stated.append((float(entry["confidence"]), good))
            if entry["confidence"] >= CONFIDENT and not good:
                wrong.append(entry["name"])
    right = bool(listed) and listed == set(truths) and verdict in DETECTED and listed <= named
    exact = right and verdict == "named" and {entry["name"] for entry in effects} == listed
    covered, errors = [], []
    for entry in effects:
        for name, known in truths.get(entry["name"], {"parameters": {}})["parameters"].items():
            found = (entry.get("parameters") or {}).get(name)
            if found is None or found.get("value") is None:
                continue
            if found.get("ci95") and None not in found["ci95"]:
                low, high = found["ci95"]
                covered.append(bool(low <= known["value"] <= high))
            if known["deviation"]:
                errors.append((found["value"] - known["value"]) / known["deviation"])
    closed, worse = _gap(key, result.get("gap") or {})
    misreading, largest = key.get("misreading"), None
    if key["kind"] == "large" and not misreading:
        largest = bool(classes and classes[0] & set(key["largest"]))
    return SimpleNamespace(
        kind=key["kind"], family=key["family"], ratio=key["ratio"], truths=tuple(truths),
        verdict=verdict, detected=verdict in DETECTED, right=right, exact=exact,
        names=sum(map(len, classes)), apart=sum(len(_apart(one, listed)) for one in classes),
        first=effects[0]["name"] if effects else "", wrong=tuple(wrong), stated=stated,
        closed=closed, worse=worse, covered=covered, errors=errors, seconds=seconds,
        largest=largest, found=len(named & set(truths)), grows=_grows(result.get("gap") or {}),
        said=_said(misreading, verdict, f"{result.get('mismatch')} {result.get('error')}") if misreading else None,
    )  # fmt: skip


def _said(misreading: Mapping[str, Any], verdict: str, told: str) -> str:
    # an axis with the other sign of its command is one with the other sign of its position
    columns = ("command", "position") if misreading["kind"] == "sign" else misreading["columns"]
    if verdict not in ("error", "data_mismatch"):
        return ""
    if misreading["kind"] in told.lower() and any(column in told.lower() for column in columns):
        return "kind"  # an error says it that refuses the log at once, with the scale that would mend it
    return "verdict" if verdict == "data_mismatch" else ""


def _grows(gap: Mapping[str, Any]) -> bool:
    pairs = [("before", "given"), ("after", "given"), ("after", "before")]
    pairs += [(f"confirm_{one}", f"confirm_{other}") for one, other in pairs]
    return any(gap.get(a) is not None and gap.get(b) is not None and gap[a] > 1.01 * gap[b] for a, b in pairs)


def _apart(names: set[str], truths: set[str]) -> set[str]:
    """The names of a class less those that look like the truth among them."""
    alike = set().union(*(pair for pair in LOOK_ALIKE for truth in truths & names if truth in pair)) - truths
    return names - alike


def _gap(key: Mapping[str, Any], gap: Mapping[str, Any]) -> tuple[float | None, bool | None]:
    before, after = gap.get("confirm_before"), gap.get("confirm_after")
    if before is None or after is None:
        return None, None
    worse, closed = bool(after > 1.01 * before), None
    if key["stated_controller"] and "confirm_closable" in key and gap.get("floor") is not None:
        shows = 0.03 * key["confirm_floor"] < key["confirm_rest"] < 1.5 * key["confirm_effect"]
        if shows and key["confirm_closable"] > 0.25 * key["confirm_rest"] ** 2:
            closed = (before**2 - after**2) / key["confirm_closable"]
    return closed, worse


def table(outcomes: list[SimpleNamespace]) -> dict[str, Any]:
    """All figures of the suite, by name; rates are Rate objects."""
    nulls = [o for o in outcomes if o.kind == "null"]
    single = [o for o in outcomes if o.kind == "effect"]
    outside = [o for o in outcomes if o.kind == "outside"]
    many = [o for o in outcomes if o.kind in ("pair", "triple")]
    ratios = sorted({o.ratio for o in single + outside})

    def by_ratio(group: list[SimpleNamespace], flag: Callable[[SimpleNamespace], bool]) -> dict[str, Rate]:
        return {f"{ratio:g}": Rate.of(flag(o) for o in group if o.ratio == ratio) for ratio in ratios}

    found = [o for o in single if o.right]
    closed = [o.closed for o in single + many if o.ratio >= 300 and o.closed is not None]
    stated = [pair for o in outcomes for pair in o.stated]
    large_cases = [o for o in outcomes if o.kind == "large"]
    times = [o.seconds for o in outcomes if math.isfinite(o.seconds)]
    coverage = [flag for o in outcomes if o.right for flag in o.covered]
    errors = np.array([error for o in outcomes if o.right for error in o.errors])
    return {
        "cases": len(outcomes),
        "errors": Rate.of(o.verdict == "error" for o in outcomes),
        "false_alarm": Rate.of(o.verdict in ALARMS for o in nulls),
        "false_alarm_by_family": {
            family: Rate.of(o.verdict in ALARMS for o in nulls if o.family == family)
            for family in sorted({o.family for o in nulls})
        },
        "detected": by_ratio(single, lambda o: o.detected),
        "named": by_ratio(single, lambda o: o.right),
        "exact": by_ratio(single, lambda o: o.exact),
        "mean_names": float(np.mean([o.names for o in found])) if found else None,
        "mean_names_apart": float(np.mean([o.apart for o in found])) if found else None,
        "confident_wrong": by_ratio(single, lambda o: bool(o.wrong)),
        "confident_wrong_all": Rate.of(bool(o.wrong) for o in single),
        "confident_wrong_many": Rate.of(bool(o.wrong) for o in many),
        "outside_detected": by_ratio(outside, lambda o: o.detected),
        "outside_unlisted": by_ratio(outside, lambda o: o.verdict == "unlisted"),
        "outside_confident_wrong": by_ratio(outside, lambda o: bool(o.wrong)),
        "outside_confident_wrong_all": Rate.of(bool(o.wrong) for o in outside),
        "pairs_right": Rate.of(o.right for o in many if o.kind == "pair"),
        "triples_right": Rate.of(o.right for o in many if o.kind == "triple"),
        "gap_closed_median": float(np.median(closed)) if closed else None,
        "made_worse": Rate.of(bool(o.worse) for o in outcomes if o.worse is not None),
        "coverage": Rate.of(coverage),
        "error_to_bound_robust": float(np.median(np.abs(errors)) / 0.67449) if len(errors) else None,
        "calibration": {
            f"{low:g} to {high:g}": {
                "stated": float(np.mean(here)) if (here := [c for c, _ in stated if _within(c, low, high)]) else None,
                "right": Rate.of(good for c, good in stated if _within(c, low, high)),
            }
            for low, high in itertools.pairwise(BINS)
        },
        "power": {name: by_ratio([o for o in single + outside if o.truths == (name,)], lambda o: o.detected)
                  for name in sorted({o.truths[0] for o in single + outside})},
        "naming": {name: by_ratio([o for o in single if o.truths == (name,)], lambda o: o.right)
                   for name in sorted({o.truths[0] for o in single})},
        "confusion": confusion(outcomes),
        "large": in_the_large(large_cases) if large_cases else None,
        "seconds_median": float(np.median(times)) if times else None,
        "seconds_max": max(times) if times else None,
    }  # fmt: skip


def in_the_large(outcomes: list[SimpleNamespace]) -> dict[str, Rate]:
    """Figures of the large cases, by what stands in the table."""
    right = [o for o in outcomes if o.said is None]
    misread = [o for o in outcomes if o.said is not None]
    return {
        "right first name, up to alternatives": Rate.of(bool(o.largest) for o in right),
        "true effects named, up to alternatives": Rate(sum(o.found for o in right), sum(len(o.truths) for o in right)),
        "confident and wrong": Rate.of(bool(o.wrong) for o in outcomes),
        "a gap grows": Rate.of(o.grows for o in outcomes),
        "misreadings said": Rate.of(bool(o.said) for o in misread),
        "misreadings said with column and kind": Rate.of(o.said == "kind" for o in misread),
        "a misreading said of a log read rightly": Rate.of(o.verdict == "data_mismatch" for o in right),
    }


def _within(value: float, low: float, high: float) -> bool:
    return low <= value < high or (value == high == BINS[-1])


def confusion(outcomes: list[SimpleNamespace]) -> dict[str, dict[str, int]]:
    """Rows: what is hidden; columns: the verdict, or for `named` and `ambiguous` the first name (? if ambiguous)."""
    rows: dict[str, Counter[str]] = {}
    for o in outcomes:
        row = " + ".join(sorted(o.truths)) or "nothing"
        column = {"named": o.first, "ambiguous": f"{o.first or 'ambiguous'}?"}.get(o.verdict, o.verdict)
        rows.setdefault(row, Counter())[column] += 1
    return {row: dict(counts.most_common()) for row, counts in sorted(rows.items())}


def plain(value: Any) -> Any:
    """Make a table fit for JSON."""
    if isinstance(value, Rate):
        value = {"hits": value.hits, "count": value.count, "value": value.value, "wilson95": list(value.bounds)}
    if isinstance(value, Mapping):
        return {key: plain(entry) for key, entry in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value


TARGETS = {
    "false_alarm": "at most 1 %",
    "detected": "85 % at 30, 99 % at 100",
    "named": "95 % at 100, 98 % at 300",
    "mean_names_apart": "at most 1.3",
    "confident_wrong_all": "at most 1 %, at any lambda",
    "outside_confident_wrong_all": "at most 2 %, at any lambda",
    "outside_unlisted": "80 % at 100, 95 % at 300",
    "gap_closed_median": "95 % at 300",
    "coverage": "92 to 98 %",
    "error_to_bound_robust": "at most 1.3",
    "made_worse": "at most 1 %",
    "seconds_max": "10 s",
}


def format_table(figures: Mapping[str, Any], title: str = "") -> str:
    """Return the figures of score.table as text, a line each, with the target of each beside it."""
    lines = [title] if title else []
    for name, value in figures.items():
        if value is None:
            continue
        label, target = name.replace("_", " "), f"   [{TARGETS[name]}]" if name in TARGETS else ""
        if isinstance(value, Mapping):
            lines.append(f"{label}{target}")
            lines.extend(f"    {key:38s} {_cell(entry)}" for key, entry in value.items())
        else:
            lines.append(f"{label:42s} {_cell(value)}{target}")
    return "\n".join(lines)


def _cell(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(
            f"{key}: {one.hits}/{one.count}" if isinstance(one, Rate) else f"{key}: {_cell(one)}"
            for key, one in value.items()
            if not isinstance(one, Rate) or one.count
        )
    return f"{value:.3g}" if isinstance(value, float | int) else "-" if value is None else str(value)
