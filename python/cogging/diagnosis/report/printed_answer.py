"""The printed answer: at most 15 lines with what the command adds, and with `verbose` all that a result holds.

Verdict, what the gap is made of, what is left of it, the parameters old and new, and what cannot be told apart. The
command adds the files that it has written and the next command.
"""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.diagnosis.report.sentences import headline, percent, shared_text
from cogging.diagnosis.report.words import limit_lines, other_shape_text, step_text, term_text

if TYPE_CHECKING:
    from cogging.diagnosis.entries import NamedEffect
    from cogging.diagnosis.result import Diagnosis

LINES, WIDTH = 13, 100  # of the printed answer; files written and what is next take two lines more


def short_text(result: Diagnosis) -> str:
    """What a person acts on."""
    head = [f"verdict: {result.verdict}", *_wrapped(f"{headline(result)}.")]
    if result.mismatch is not None:
        return "\n".join([*head, *_wrapped(str(result.mismatch["text"]))])
    if "gap_before" not in result.series:
        return "\n".join([*head, *[line for note in result.notes[-2:] for line in _wrapped(note)]][:LINES])
    head += _gap_lines(result)
    tail = [line for effect in result.effects if (line := apart_text(effect))]
    tail = tail[: 2 if result.unlisted is None else 1]
    if result.unlisted is not None:
        tail.append(f"unlisted: {result.unlisted['shape']}")
        if "added" in result.unlisted:
            tail.append(f"  {term_text(result.unlisted['added'], result.gap.unit)}")
        if "not_added" in result.unlisted:
            tail.append(f"  {result.unlisted['not_added']}")
    notes = f", notes ({len(result.notes)})" if result.notes else ""
    tail.append(f"more with --verbose: where the gap sits, what was tried, detection limits{notes}")
    rows = [*result.axis_lines(), *(_effect_line(result, effect) for effect in result.effects)]
    room = LINES - len(head) - len(tail)
    if len(rows) > room:
        rows = [*rows[: room - 1], f"  and {len(rows) - room + 1} more"]
    return "\n".join(map(_cut, [*head, *rows, *tail]))


def apart_text(effect: NamedEffect) -> str:
    """Which names these logs cannot tell apart, and whether that matters; empty where there is one name only."""
    if not effect.alternatives:
        return ""
    return f"{effect.name} or {', '.join(effect.alternatives)}: not told apart by these logs"


def _gap_lines(result: Diagnosis) -> list[str]:
    gap = result.gap
    left = "" if gap.share is None else f", {percent(gap.share)} of the command's rms"
    lines = [f"gap: {gap.before:.4g} -> {gap.after:.4g} {gap.unit} rms{left}; noise alone leaves {gap.floor:.4g}"]
    if gap.confirm_before is not None and gap.confirm_after is not None:
        line = f"  other motion: {gap.confirm_before:.4g} -> {gap.confirm_after:.4g} {gap.unit}"
        more = "" if gap.predictable is None else f"; of the rest a generic force predicts {percent(gap.predictable)}"
        lines.append(line + more)
    return lines


def _effect_line(result: Diagnosis, effect: NamedEffect) -> str:
    """An effect with its quantities, in a line."""
    told = []
    for name, quantity in effect.parameters.items():
        unit = "" if quantity.unit == "1" else f" {quantity.unit}"
        if isinstance(quantity.value, list):
            told.append(f"{name} {len(quantity.value)} values")
        else:
            told.append(f"{name} {quantity.value:.4g}{unit}{_interval(*quantity.ci95)}")
    more = f" (and {len(effect.further)} more terms)" if effect.further else ""
    return f"  {effect.name}: {', '.join(told)}{more}"


def _interval(low: Any, high: Any) -> str:
    return "" if low is None or high is None or not np.isfinite(high - low) else f" [{low:.4g}, {high:.4g}]"


def _cut(line: str) -> str:
    return line if len(line) <= WIDTH else f"{line[: WIDTH - 4].rpartition(' ')[0]} ..."


def _wrapped(text: str) -> list[str]:
    return textwrap.wrap(text, WIDTH, break_on_hyphens=False)


# All that a result holds ----------------------------------------------------------------------------------------------


def full_text(result: Diagnosis) -> str:
    """The result with its ledger, limits and notes."""
    lines = [f"verdict: {result.verdict}", *([headline(result)] if result.effects else []), *result.axis_lines()]
    if result.mismatch is not None:
        lines.append(f"  {result.mismatch['text']}")
    for effect in result.effects:
        lines += _effect_lines(result, effect)
    if result.unlisted is not None:
        lines.append(f"  unlisted: {result.unlisted['shape']}")
        if "added" in result.unlisted:
            lines.append(f"    {term_text(result.unlisted['added'], result.gap.unit)}")
    g = result.gap
    as_read = "" if g.given is None else f"{g.given:.4g} {g.unit} as given, "
    lines.append(f"gap ({g.signal}): {as_read}{g.before:.4g} re-tuned, {g.after:.4g} after, floor {g.floor:.4g}")
    lines += _gap_lines(result) if "gap_before" in result.series else []
    lines += _under("where the gap sits:", result.where_text)
    lines += _under("ledger:", [step_text(step, g.unit) for step in result.ledger])
    if result.separating_experiment:
        lines.append(f"what would tell them apart: {result.separating_experiment}")
        lines.append("  (cogging experiment computes a motion for the limits of your machine)")
    lines += limit_lines(result.limits)
    lines += [f"note: {note}" for note in result.notes]
    return "\n".join(lines)


def _under(title: str, lines: Sequence[str]) -> list[str]:
    return [title, *(f"  {line}" for line in lines)] if lines else []


def _effect_lines(result: Diagnosis, effect: NamedEffect) -> list[str]:
    name, others = effect.name, effect.alternatives
    share = "" if effect.share is None else f", {percent(effect.share)} of the gap"
    lines = [f"  {name}: confidence {effect.confidence:.2f}{share}"]
    if others:
        shared = f"{percent(effect.confidence)} that it is {name}; {shared_text(effect, result.vocabulary)}"
        lines = [f"  {name} or {', '.join(others)}: confidence {effect.confidence:.2f}{share}", f"    {shared}"]
        lines.append(f"    {apart_text(effect)}")
    if effect.shape:
        lines.append(f"    {other_shape_text(effect, result.model.units)}")
    for quantity, p in effect.parameters.items():
        low, high = map(_number, p.ci95)
        lines.append(f"    {quantity} = {_number(p.value)} {p.unit}, 95 % {low} to {high}")
    return lines


def axis_line(path: str, told: Mapping[str, Any], interval: tuple[float, float] | None) -> str:
    """What became of mass or friction, beside what was stated of it."""
    sure, ends = told["uncertainty"], interval or (None, None)
    known = (
        "no uncertainty stated" if sure is None else "stated exact" if sure == 0.0 else f"stated +- {100 * sure:.3g} %"
    )
    name = path.removeprefix("axis.")
    return f"  {name}: {told['stated']:.4g} -> {told['value']:.4g} {told['unit']}{_interval(*ends)} ({known})"


def _number(value: float | Sequence[float | None] | None) -> str:
    if value is None:
        return "not known"
    if isinstance(value, int | float):
        return f"{value:.4g}"
    return "[" + ", ".join("?" if v is None else f"{v:.3g}" for v in value) + "]"
