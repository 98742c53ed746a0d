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
