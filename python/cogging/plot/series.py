"""Colours, lines and markers of series, distinct in grey and to the colour-blind."""

from __future__ import annotations

from typing import Any

from cogging.shown import printable, shortened

#: Of Okabe and Ito (2008), ordered so that neighbours differ in lightness; the yellow is too light for a line on white.
COLOURS = ("#0072B2", "#E69F00", "#000000", "#56B4E9", "#D55E00", "#009E73", "#CC79A7")
LINES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (8, 2)), (0, (5, 1, 1, 1, 1, 1)), (0, (3, 1)))
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
MEASURED, FITTED, LIMIT = "#0072B2", "#000000", "#D55E00"
GREY = "#8c8c8c"
LONGEST = 40  # characters of a label


def look(place: int, dense: bool = False) -> dict[str, Any]:
    """Return colour and line style of the series at a place, from 0; dense: many rows to a pixel, the line is solid."""
    round_, colour = divmod(place, len(COLOURS))
    return {"color": COLOURS[colour], "linestyle": "-" if dense else LINES[(colour + round_) % len(LINES)]}


def marker(place: int) -> str:
    """Return the marker of the series at a place."""
    round_, kind = divmod(place, len(MARKERS))
    return MARKERS[(kind + round_) % len(MARKERS)]


def named(label: Any) -> str:
    """Return a user's name for a legend: escaped, shortened, and not hidden by a leading underscore."""
    text = shortened(printable(str(label)), LONGEST).replace("$", r"\$")
    return f" {text}" if text.startswith("_") else text
