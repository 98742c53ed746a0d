"""Where the gap of a diagnosis goes: what re-tuning and each effect take of its power, and what remains."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.calls import described
from cogging.plot.canvas import drawn, one_of
from cogging.plot.series import FITTED, GREY, LIMIT, MEASURED, named

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SMALL = 0.005  # of the whole: a rest that is smaller is not drawn
#: Colour and hatching of a bar by its kind.
KINDS = {"retuned": (GREY, "//"), "effect": (MEASURED, ""), "rest": (LIMIT, "xx"), "floor": ("#e8e8e8", "..")}


def shares(diagnosis: Any) -> list[tuple[str, str, float]]:
    """Where the power of the gap goes: name, kind and share of each part; together 1.

    Args:
        diagnosis: a Diagnosis. The whole is the power of the gap as the model was read where that is known and larger
            than as re-tuned, else as re-tuned.

    Returns:
        Parts in the order in which they were found: `retuned`, one `effect` each, the `rest` that nothing explains, and
        the `floor` that noise and quantiser leave. A share below 0 made the gap larger.
    """
    gap, steps = getattr(diagnosis, "gap", None), getattr(diagnosis, "ledger", None)
    if gap is None or steps is None:
        raise TypeError(f"diagnosis: must be a Diagnosis, got {described(diagnosis)}")
    if not gap.before > 0.0 or not np.isfinite(gap.before):
        raise ValueError(f"plot: needs a gap that was measured, got the verdict {diagnosis.verdict}")
    given = gap.given if gap.given is not None and gap.given > gap.before else gap.before
    whole = given**2
    parts = [("re-tuning", "retuned", (given**2 - gap.before**2) / whole)] * bool(given > gap.before)
    left = gap.before**2
    for step in steps:
        if step.accepted and step.gap_before is not None and step.gap_after is not None:
            taken = step.gap_before**2 - step.gap_after**2
            parts.append((step.name.replace("_", " "), "effect", taken / whole))
            left -= taken
    together = left - gap.after**2  # of the parameters of all, fitted anew at the end
    if abs(together) > SMALL * whole:
        parts.append(("fitted together", "retuned", together / whole))
    floor = min(gap.floor, gap.after) ** 2
    rest = 1.0 - sum(share for *_, share in parts) - floor / whole
    parts.append(("not explained", "rest", rest))
    return [*parts, ("noise and quantiser", "floor", floor / whole)]


def _percent(share: float) -> str:
    return f"{share:.1f} %" if abs(share) >= 0.1 or share == 0.0 else f"{'' if share > 0.0 else '-'}< 0.1 %"


@drawn
def ledger(diagnosis: Any, *, ax: Any = None) -> Axes:
    """Draw where the gap of a diagnosis goes: a bar for each effect and for what remains, in shares of its power.

    Args:
        diagnosis: a Diagnosis.
        ax: axes; None: a new figure.

    Returns:
        The axes: bars from the top down, in the order in which they were found.

    Raises:
        ValueError: no gap was measured.
        TypeError: an argument is something else.

    Example:
        >>> lean = model.replace(effects=[], intervals={})
        >>> ax = cogging.plot.ledger(cogging.diagnose(log, lean))
        >>> ax.get_xlabel()
        "share of the gap's power (%)"
    """
    parts = shares(diagnosis)
    axes = one_of(ax, size=(7.2, 0.9 + 0.36 * len(parts)))
    place = np.arange(len(parts))
    percent = 100.0 * np.array([share for _, _, share in parts])
    start = 0.0
    for row, (_, kind, _), width in zip(place, parts, percent, strict=True):
        colour, hatch = KINDS[kind]
        axes.barh(row, width, left=start, color=colour, hatch=hatch, edgecolor=FITTED, linewidth=0.6, height=0.7)
        end = max(start, start + width)
        axes.annotate(_percent(width), (end, row), xytext=(4, 0), textcoords="offset points", va="center")
        start += width
    axes.set_yticks(place, [named(name) for name, _, _ in parts])
    axes.invert_yaxis()
    axes.margins(x=0.12)
    axes.grid(visible=False, axis="y")
    axes.axvline(0.0, color=FITTED, linewidth=0.6)
    axes.set_xlabel("share of the gap's power (%)")
    return axes
