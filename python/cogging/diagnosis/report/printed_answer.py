"""The printed answer: at most 15 lines including those of the command, or with `verbose` the complete result.

It has the verdict, the headline, the gap, the parameters old and new, and the alternatives. The command adds the
written files and the next command.
"""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.diagnosis.report.sentences import headline, percent, shared_text
from cogging.diagnosis.report.words import harmonic_text, limit_lines, other_shape_text, step_text, term_text

if TYPE_CHECKING:
    from cogging.diagnosis.diagnosis_result import Diagnosis
    from cogging.diagnosis.entries import NamedEffect

LINES, WIDTH = 13, 100  # of the printed answer; written files and the next command take two more lines


def short_text(result: Diagnosis) -> str:
    """Return the printed answer."""
    head = [f"verdict: {result.verdict}", *_wrap(f"{headline(result)}.")]
    if result.mismatch is not None:
        return "\n".join([*head, *_wrap(str(result.mismatch["text"]))])
    if "gap_before" not in result.series:
        return "\n".join([*head, *[line for note in result.notes[-2:] for line in _wrap(note)]][:LINES])
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
    tail.append(f"--verbose adds: location of the gap, tested effects, detection limits{notes}")
    rows = [*result.axis_lines(), *(_effect_line(result, effect) for effect in result.effects)]
    room = LINES - len(head) - len(tail)
    if len(rows) > room:
        rows = [*rows[: room - 1], f"  and {len(rows) - room + 1} more"]
    lines = [*head, *rows, *tail]
    return "\n".join(x if len(x) <= WIDTH else f"{x[: WIDTH - 4].rpartition(' ')[0]} ..." for x in lines)


def apart_text(effect: NamedEffect) -> str:
    """Return the names that these logs cannot distinguish; empty for a single name."""
    if not effect.alternatives:
        return ""
    return f"{effect.name} or {', '.join(effect.alternatives)}: these logs cannot distinguish them"


def _gap_lines(result: Diagnosis) -> list[str]:
    gap = result.gap
    share = "" if gap.share is None else f" ({percent(gap.share)} of the rms command)"
    lines = [f"gap: {gap.before:.4g} -> {gap.after:.4g} {gap.unit} rms{share}, noise floor {gap.floor:.4g} {gap.unit}"]
    if gap.confirm_before is not None and gap.confirm_after is not None:
        more = "" if gap.predictable is None else f"; a generic force predicts {percent(gap.predictable)} of the rest"
        lines.append(f"  confirm logs: {gap.confirm_before:.4g} -> {gap.confirm_after:.4g} {gap.unit} rms{more}")
    return lines


def _effect_line(result: Diagnosis, effect: NamedEffect) -> str:
    """Return an effect with its parameters in one line."""
    parameters = []
    for name, quantity in effect.parameters.items():
        unit = "" if quantity.unit == "1" else f" {quantity.unit}"
        if isinstance(quantity.value, list):
            parameters.append(f"{name} {len(quantity.value)} values")
        else:
            parameters.append(f"{name} {quantity.value:.4g}{unit}{_interval(*quantity.ci95)}")
    more = f" (and {len(effect.further)} more)" if effect.further else ""
    name = f"{effect.name}{harmonic_text(effect, result.series.get('given', result.model))}"
    return f"  {name}: {', '.join(parameters) or 'a curve, in the report'}{more}"


def _interval(low: Any, high: Any) -> str:
    return "" if low is None or high is None or not np.isfinite(high - low) else f" [{low:.4g}, {high:.4g}]"


def _wrap(text: str) -> list[str]:
    return textwrap.wrap(text, WIDTH, break_on_hyphens=False)


# Complete result ------------------------------------------------------------------------------------------------------


def full_text(result: Diagnosis) -> str:
    """Return the result with location, ledger, limits and notes."""
    lines = [f"verdict: {result.verdict}", *([headline(result)] if result.effects else []), *result.axis_lines()]
    if result.mismatch is not None:
        lines.append(f"  {result.mismatch['text']}")
    for effect in result.effects:
        names, share = effect.name, "" if effect.share is None else f", {percent(effect.share)} of the gap"
        if effect.alternatives:
            names += f" or {', '.join(effect.alternatives)}"
        lines.append(f"  {names}: confidence {effect.confidence:.2f}{share}")
        if effect.alternatives:
            shared = shared_text(effect, result.vocabulary)
            lines.append(f"    confidence that it is {effect.name}: {percent(effect.confidence)}; {shared}")
            lines.append(f"    {apart_text(effect)}")
        if effect.shape:
            lines.append(f"    {other_shape_text(effect, result.model.units)}")
        for quantity, p in effect.parameters.items():
            low, high = map(_number, p.ci95)
            lines.append(f"    {quantity} = {_number(p.value)} {p.unit}, 95 % interval {low} to {high}")
    if result.unlisted is not None:
        lines.append(f"  unlisted: {result.unlisted['shape']}")
        if "added" in result.unlisted:
            lines.append(f"    {term_text(result.unlisted['added'], result.gap.unit)}")
    g = result.gap
    as_read = "" if g.given is None else f"{g.given:.4g} {g.unit} as given, "
    lines.append(f"gap ({g.signal}): {as_read}{g.before:.4g} re-tuned, {g.after:.4g} after, floor {g.floor:.4g}")
    lines += _gap_lines(result) if "gap_before" in result.series else []
    ledger = [step_text(step, g.unit) for step in result.ledger]
    for title, more in (("location of the gap:", result.where_text), ("ledger:", ledger)):
        lines += [title, *(f"  {line}" for line in more)] if more else []
    if result.separating_experiment:
        lines.append(f"motion that distinguishes them: {result.separating_experiment}")
        lines.append("  (cogging experiment makes a motion within the limits of your machine)")
    lines += limit_lines(result.limits)
    lines += [f"note: {note}" for note in result.notes]
    return "\n".join(lines)


def axis_line(path: str, entry: Mapping[str, Any], interval: tuple[float, float] | None) -> str:
    """Return mass or friction in one line: stated and new value, 95 % interval, stated uncertainty."""
    sigma, ends = entry["uncertainty"], interval or (None, None)
    stated = "exact" if sigma == 0.0 else "no uncertainty" if sigma is None else f"+- {100 * sigma:.3g} %"
    name = path.removeprefix("axis.")
    return (
        f"  {name}: {entry['stated']:.4g} -> {entry['value']:.4g} {entry['unit']}{_interval(*ends)} (stated {stated})"
    )


def _number(value: float | Sequence[float | None] | None) -> str:
    if value is None:
        return "unknown"
    if isinstance(value, int | float):
        return f"{value:.4g}"
    return "[" + ", ".join("?" if v is None else f"{v:.3g}" for v in value) + "]"
