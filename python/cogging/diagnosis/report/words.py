"""Lines of a result in words, for the screen and the page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cogging.diagnosis.result import Step


def term_text(term: Mapping[str, Any], unit: str) -> str:
    """What an empirical term makes of the gap, in words."""
    text = f"added to the model as {term['name']}, which is empirical and names no cause: gap (innovations of an "
    text += f"observer) {term['gap_before']:.4g} to {term['gap_after']:.4g} {unit}"
    if term["confirm_after"] is not None:
        text += f", on the confirm logs {term['confirm_before']:.4g} to {term['confirm_after']:.4g} {unit}"
    return text


def step_text(step: Step, unit: str) -> str:
    """A line of the ledger in words."""
    if not step.accepted:
        return f"refused {step.name}: T = {step.statistic:.0f}, {step.reason}"
    gap = f"gap {step.gap_before:.4g} to {step.gap_after:.4g} {unit}"
    if step.confirm_after is not None:
        gap += f", on the confirm logs {step.confirm_before:.4g} to {step.confirm_after:.4g} {unit}"
    return f"added   {step.name}: T = {step.statistic:.0f}, {gap}; {step.reason}"
