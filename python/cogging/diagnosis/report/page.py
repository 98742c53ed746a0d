"""Report of a diagnosis as one HTML file with embedded figures, which opens offline and prints on paper."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cogging.diagnosis.next_step import NextStep, next_step
from cogging.diagnosis.report.pictures import STYLE, curve_picture, pictures_of
from cogging.diagnosis.report.sentences import capital, certainty_text, explained_text, headline, meaning, standing_text
from cogging.diagnosis.report.words import (
    law,
    numbers,
    other_shape_text,
    plain,
    shape_words,
    term_text,
    unlisted_advice,
    where_words,
)
from cogging.model.model import Model
from cogging.model.parameters import parameters_of
from cogging.model.units import Units
from cogging.outputs import to_toml

if TYPE_CHECKING:
    from cogging.diagnosis.diagnosis_result import Diagnosis
    from cogging.diagnosis.entries import NamedEffect, Value

TEMPLATE = Path(__file__).with_name("page.html.j2")
MAIN = 10  # parameters of the first screen


def html(result: Diagnosis, *, title: str = "", step: NextStep | None = None) -> str:
    """Return the report as a string.

    Args:
        result: result to show.
        title: title of the report, such as the names of the logs.
        step: next step with the user's own files; by default with placeholders.

    Raises:
        ValueError: Jinja2, of the extra `report`, is not installed.
    """
    try:
        from jinja2 import Environment, StrictUndefined
    except ImportError as error:
        raise ValueError(f"a report needs {error.name}: pip install 'cogging[report]'") from None
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = environment.from_string(TEMPLATE.read_text(encoding="utf-8"))
    texts = {"style": STYLE.read_text(encoding="utf-8"), "plain": plain, "numbers": numbers, "shape_words": shape_words}
    return str(template.render(**texts, **_content(result, title, step)))


def _content(result: Diagnosis, title: str, step: NextStep | None) -> dict[str, Any]:
    units, unlisted = result.model.units, result.unlisted or {}
    return {
        "title": title,
        "version": importlib.metadata.version("cogging"),
        "result": result,
        "headline": headline(result),
        "meaning": meaning(result),
        "step": step or next_step(result),
        "bars": _bars(result),
        "micro": units.of("µm"),
        "command_unit": units.command,
        "default_units": units == Units(),
        "explained": explained_text(result.gap) if result.effects else "",
        "effects": [_effect(result, effect) for effect in result.effects],
        "term": term_text(unlisted["added"], result.gap.unit) if "added" in unlisted else "",
        "unlisted_text": "" if result.unlisted is None else f"{capital(str(result.unlisted['shape']))}.",
        "where": result.location.lines() if result.location is not None else list(result.where_text),
        "further": _further(result),
        "shown": {name: limit for name, limit in result.limits.items() if not limit.why},
        "unseen": {name: limit for name, limit in result.limits.items() if limit.why},
        "axis": result.axis_lines(),
        "parameters": (rows := _parameters(result)),
        "main": [row for row in rows if row["path"].startswith(("axis.", "effects."))][:MAIN],
        "model": to_toml(result.model.to_dict()),
        "pictures": pictures_of(result),
        "measured": "gap_before" in result.series,
    }


def _bars(result: Diagnosis) -> list[dict[str, Any]]:
    """Return label, size, share of the largest and colour of each gap."""
    gap = result.gap
    sizes = [
        ("before: as given", gap.given, "before"),
        ("before: re-tuned", gap.before, "before"),
        ("after: patched", gap.after if result.effects else None, "after"),
        ("noise floor", gap.floor, "floor"),
        ("confirm logs, re-tuned", gap.confirm_before, "before"),
        ("confirm logs, patched", gap.confirm_after if result.effects else None, "after"),
    ]
    largest = max([size for _, size, _ in sizes if size is not None and size > 0.0], default=1.0)
    return [
        {"label": label, "size": f"{size:.3g} {gap.unit}", "share": f"{100.0 * size / largest:.1f}", "kind": kind}
        for label, size, kind in sizes
        if size is not None
    ]


def _effect(result: Diagnosis, effect: NamedEffect) -> dict[str, Any]:
    names, terms = [effect.name, *effect.alternatives], [effect.parameters, *effect.further]
    meanings = {"change": ("1", "new / old - 1")}
    if effect.name in result.vocabulary:
        meanings = dict(result.vocabulary[effect.name].FIELDS)
    return {
        "words": " or ".join(map(plain, names)),
        "law": law(result.vocabulary, effect.name),
        "name": plain(effect.name),
        "standing": standing_text(effect),
        "certainty": certainty_text(effect, result.vocabulary),
        "reasons": list(dict.fromkeys(s.reason for s in result.ledger if s.accepted and s.name == effect.name)),
        "where": where_words(effect.where, result.model.units),
        "shape": other_shape_text(effect, result.model.units),
        "picture": curve_picture(effect, result.model.units),
        "alternatives": [{"words": plain(name), "law": law(result.vocabulary, name)} for name in effect.alternatives],
        "fields": _fields(meanings, terms),
        "tables": _tables(meanings, terms),
    }


Meanings = Mapping[str, tuple[str, str]]  # unit and meaning of each field


def _fields(meanings: Meanings, terms: Sequence[Mapping[str, Value]]) -> list[dict[str, Any]]:
    """Return one row per scalar parameter; several terms of one name are numbered."""
    return [
        {
            "field": field if len(terms) == 1 else f"{field} ({i + 1})",
            "meaning": meanings[field][1] if field in meanings else "",
            "value": numbers(value.value, value.ci95),
            "unit": "" if value.unit == "1" else value.unit,
            "interval": _interval(*value.ci95),
        }
        for i, term in enumerate(terms)
        for field, value in term.items()
        if not isinstance(value.value, list)
    ]


def _tables(meanings: Meanings, terms: Sequence[Mapping[str, Value]]) -> list[dict[str, Any]]:
    """Return a table for the list parameters of each term and length: one row per entry, one column per parameter."""
    tables = []
    for i, term in enumerate(terms):
        lists = [(field, value, value.value) for field, value in term.items() if isinstance(value.value, list)]
        number = "" if len(terms) == 1 else f" ({i + 1})"
        for length in dict.fromkeys(len(entries) for _, _, entries in lists):
            heads, columns, notes = [], [], []
            for field, value, entries in lists:
                if len(entries) != length:
                    continue
                low, high = (list(end) if isinstance(end, Sequence) else [end] * length for end in value.ci95)
                column = [(numbers(x, e), _interval(*e)) for x, *e in zip(entries, low, high, strict=True)]
                columns.append(column)
                has_interval = any(interval != "–" for _, interval in column)
                heads.append((f"{field}{number}{f', {value.unit}' if value.unit != '1' else ''}", has_interval))
                notes += [f"{field}: {meanings[field][1]}"] if field in meanings else []
            rows = [[column[k] for column in columns] for k in range(length)]
            tables.append({"heads": heads, "rows": rows, "meanings": notes})
    return tables


def _interval(low: float | None, high: float | None) -> str:
    if low is None and high is None:
        return "–"
    return " … ".join(numbers(end, (low, high)) for end in (low, high))


def _further(result: Diagnosis) -> list[str]:
    """Return advice on further measurements."""
    advice = []
    if result.separating_experiment:
        advice.append(f"To distinguish the candidates: {result.separating_experiment}.")
    if result.unlisted is not None:
        advice.append(unlisted_advice(result.unlisted["coordinate"]))
    if "gap_before" in result.series and result.gap.confirm_before is None and result.verdict != "named":
        advice.append("Record a second log with other speeds and strokes, and pass it with --confirm.")
    return advice


def _parameters(result: Diagnosis) -> list[dict[str, Any]]:
    """Return one row per parameter: as given, re-tuned and patched, with the interval of the last."""
    given: Model | None = result.series.get("given")
    before = {path: p.value for path, p in parameters_of(given).items()} if given is not None else {}
    nominal = {path: p.value for path, p in parameters_of(result.nominal).items()}
    return [
        {
            "path": path,
            "unit": "" if parameter.unit == "1" else parameter.unit,
            "given": numbers(before.get(path)),
            "nominal": numbers(nominal.get(path)),
            "final": numbers(parameter.value, ends := result.model.intervals.get(path, (None, None))),
            "interval": _interval(*ends),
            "new": path.startswith("effects.") and path not in nominal,
        }
        for path, parameter in parameters_of(result.model).items()
    ]
