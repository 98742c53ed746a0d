"""The table of a blind suite as text, beside the targets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .score import Rate

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


def format_table(figures: Mapping[str, Any], title: str = "", *, details: bool = True) -> str:
    """Text of a table of score.table."""
    lines = [title] if title else []

    def one(label: str, name: str) -> None:
        value = figures[name]
        text = f"{value:.3g}" if isinstance(value, float | int) else ("-" if value is None else str(value))
        target = f"   [{TARGETS[name]}]" if name in TARGETS else ""
        lines.append(f"{label:42s} {text}{target}")

    def many(label: str, name: str) -> None:
        target = f"   [{TARGETS[name]}]" if name in TARGETS else ""
        lines.append(f"{label}{target}")
        lines.extend(f"    {key:38s} {value}" for key, value in figures[name].items())

    one("cases", "cases")
    one("errors", "errors")
    one("false alarm on nulls", "false_alarm")
    many("false alarm by family", "false_alarm_by_family")
    many("false alarm by lambda of the friction law itself", "false_alarm_by_law_ratio")
    one("confident name on a null", "null_confident")
    many("detected, by lambda", "detected")
    many("named up to alternatives, by lambda", "named")
    many("exactly named, by lambda", "exact")
    one("mean number of names where right", "mean_names")
    one("the same, without listed look-alikes", "mean_names_apart")
    many("confident and wrong, by lambda", "confident_wrong")
    one("confident and wrong, in the list", "confident_wrong_all")
    one("confident and wrong, pairs and triples", "confident_wrong_many")
    many("outside: detected, by lambda", "outside_detected")
    many("outside: unlisted, by lambda", "outside_unlisted")
    many("outside: confident and wrong, by lambda", "outside_confident_wrong")
    one("confident and wrong, outside the list", "outside_confident_wrong_all")
    one("pairs: both named", "pairs_right")
    one("triples: all named", "triples_right")
    one("named where the controller is not stated", "unknown_controller_named")
    one("gap closed of the closable, median >= 300", "gap_closed_median")
    one("gap closed to the truth's floor, median", "gap_closed_to_floor_median")
    one("confirm log made worse by over 1 %", "made_worse")
    one("95 % intervals that cover", "coverage")
    one("error / Cramer-Rao, rms", "error_to_bound")
    one("error / Cramer-Rao, robust", "error_to_bound_robust")
    one("1-sigma that is stated / Cramer-Rao, median", "width_to_bound_median")
    one("sqrt(lambda / T), median: re-tuned beside it", "information_median")
    one("parameters compared", "error_count")
    lines.append("stated confidence: mean stated, share right")
    for key, entry in figures["calibration"].items():
        stated = "-" if entry["stated"] is None else f"{entry['stated']:.3f}"
        lines.append(f"    {key:38s} {stated}  {entry['right']}")
    one("seconds a case, median", "seconds_median")
    one("seconds a case, largest", "seconds_max")
    if figures["large"]:
        many("in the large", "large")
    if details:
        lines.append("power: detected / named of drawn, by lambda")
        for name, rates in figures["power"].items():
            naming = figures["naming"].get(name)
            cells = []
            for ratio, rate in rates.items():
                if rate.count:
                    second = f"/{naming[ratio].hits}" if naming else ""
                    cells.append(f"{ratio}: {rate.hits}{second} of {rate.count}")
            lines.append(f"    {name:38s} {', '.join(cells)}")
        lines.append("confusion: hidden | verdict or first name (? = ambiguous)")
        for row, counts in figures["confusion"].items():
            lines.append(f"    {row:60s} | " + ", ".join(f"{name} {count}" for name, count in counts.items()))
    return "\n".join(lines)


__all__ = ["TARGETS", "Rate", "format_table"]
