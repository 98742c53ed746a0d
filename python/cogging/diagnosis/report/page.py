"""A diagnosis as one HTML file that a machine's owner understands: figures inside, opens offline, prints on paper."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cogging.diagnosis.next_step import NextStep, next_step
from cogging.diagnosis.report.pictures import curve_picture, pictures_of
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
    from cogging.diagnosis.entries import NamedEffect, Value
    from cogging.diagnosis.result import Diagnosis

TEMPLATE = Path(__file__).with_name("page.html.j2")
STYLE = Path(__file__).with_name("page.css")


def html(result: Diagnosis, *, title: str = "", step: NextStep | None = None) -> str:
    """The report as a text.

    Args:
        result: result that is shown.
        title: name of what was diagnosed, such as those of the logs.
        step: what to do next, in the user's own files; by default with placeholders.

    Raises:
        ValueError: Jinja2, of the extra `report`, is not installed.
    """
    try:
        from jinja2 import Environment, StrictUndefined
    except ImportError as error:
        raise ValueError(f"a report needs {error.name}: pip install 'cogging[report]'") from None
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = environment.from_string(TEMPLATE.read_text(encoding="utf-8"))
    page: str = template.render(style=STYLE.read_text(encoding="utf-8"), **_content(result, title, step))
    return page


def _content(result: Diagnosis, title: str, step: NextStep | None) -> dict[str, Any]:
    units = result.model.units
    return {
        "title": title,
        "version": importlib.metadata.version("cogging"),
        "verdict": result.verdict,
        "headline": headline(result),
        "meaning": meaning(result),
        "step": step or next_step(result),
        "gap": result.gap,
        "bars": _bars(result),
        "micro": units.of("µm"),
        "command_unit": units.command,
        "default_units": units == Units(),
        "explained": explained_text(result.gap) if result.effects else "",
        "confirmed": result.gap.confirmed,
        "effects": [_effect(result, effect) for effect in result.effects],
        "mismatch": result.mismatch,
        "unlisted": result.unlisted,
        "term": _term(result),
        "unlisted_text": "" if result.unlisted is None else f"{capital(str(result.unlisted['shape']))}.",
        "where": result.location.lines() if result.location is not None else list(result.where_text),
        "further": _further(result),
        "ledger": result.ledger,
        "limits": _limits(result),
        "axis": result.axis_lines(),
        "notes": result.notes,
        "parameters": _parameters(result),
        "model": to_toml(result.model.to_dict()),
        "pictures": pictures_of(result),
        "measured": "gap_before" in result.series,
    }


def _bars(result: Diagnosis) -> list[dict[str, Any]]:
    """The sizes of the gap: what each is of, its share of the largest, and its colour."""
    gap = result.gap
    told = [
        ("as given", gap.given, "before"),
        ("re-tuned", gap.before, "before"),
        ("with what was found", gap.after if result.effects else None, "after"),
        ("noise floor", gap.floor, "floor"),
        ("other motion, re-tuned", gap.confirm_before, "before"),
        ("other motion, with what was found", gap.confirm_after if result.effects else None, "after"),
    ]
    largest = max([size for _, size, _ in told if size is not None and size > 0.0], default=1.0)
    return [
        {"label": label, "size": f"{size:.3g} {gap.unit}", "share": f"{100.0 * size / largest:.1f}", "kind": kind}
        for label, size, kind in told
        if size is not None
    ]


def _term(result: Diagnosis) -> str:
    """What an empirical term makes of the gap; empty where none was added."""
    if result.unlisted is None or "added" not in result.unlisted:
        return ""
    return term_text(result.unlisted["added"], result.gap.unit)


def _limits(result: Diagnosis) -> dict[str, list[dict[str, Any]]]:
    """Rows of the detection limits, and what has none."""
    rows = [
        {
            "words": plain(name),
            "size": limit.meaning or limit.parameter,
            "value": numbers(limit.value),
            "unit": "" if limit.unit == "1" else limit.unit,
            "smaller_shows": limit.smaller_shows,
            "shape": shape_words(limit),
            "why": limit.why,
        }
        for name, limit in result.limits.items()
    ]
    return {"shown": [row for row in rows if not row["why"]], "unseen": [row for row in rows if row["why"]]}


def _effect(result: Diagnosis, effect: NamedEffect) -> dict[str, Any]:
    names = [effect.name, *effect.alternatives]
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
        "fields": _fields(result, effect.name, [effect.parameters, *effect.further]),
        "tables": _tables(result, effect.name, [effect.parameters, *effect.further]),
    }


def _meanings(result: Diagnosis, name: str) -> Mapping[str, tuple[str, str]]:
    return result.vocabulary[name].FIELDS if name in result.vocabulary else {"change": ("1", "new over old, less 1")}


def _fields(result: Diagnosis, name: str, terms: Sequence[Mapping[str, Value]]) -> list[dict[str, Any]]:
    """A row a single quantity; several terms of one name are numbered."""
    meanings = _meanings(result, name)
    return [
        {
            "field": field if len(terms) == 1 else f"{field} ({i + 1})",
            "meaning": meanings[field][1] if field in meanings else "",
            "value": numbers(value.value),
            "unit": "" if value.unit == "1" else value.unit,
            "interval": _interval(*value.ci95),
        }
        for i, term in enumerate(terms)
        for field, value in term.items()
        if not isinstance(value.value, list)
    ]


def _tables(result: Diagnosis, name: str, terms: Sequence[Mapping[str, Value]]) -> list[dict[str, Any]]:
    """Quantities that are lists, as tables of their own: a row an entry, lists of one length beside each other."""
    meanings = _meanings(result, name)
    tables = []
    for i, term in enumerate(terms):
        lists = {field: value for field, value in term.items() if isinstance(value.value, list)}
        for length in dict.fromkeys(len(list_of(value)) for value in lists.values()):
            mine = {field: value for field, value in lists.items() if len(list_of(value)) == length}
            number = "" if len(terms) == 1 else f" ({i + 1})"
            heads = [
                f"{field}{number}{f', {value.unit}' if value.unit != '1' else ''}" for field, value in mine.items()
            ]
            columns = [_entries(value, length) for value in mine.values()]
            shown = [any(interval != "–" for _, interval in column) for column in columns]
            tables.append(
                {
                    "heads": list(zip(heads, shown, strict=True)),
                    "rows": [[column[k] for column in columns] for k in range(length)],
                    "meanings": [f"{field}: {meanings[field][1]}" for field in mine if field in meanings],
                }
            )
    return tables


def list_of(value: Value) -> list[float]:
    """The entries of a quantity that is a list."""
    return value.value if isinstance(value.value, list) else [value.value]


def _entries(value: Value, length: int) -> list[tuple[str, str]]:
    low, high = (list(end) if isinstance(end, Sequence) else [end] * length for end in value.ci95)
    return [(numbers(one), _interval(low[k], high[k])) for k, one in enumerate(list_of(value))]


def _interval(low: float | None, high: float | None) -> str:
    return "–" if low is None and high is None else f"{numbers(low)} … {numbers(high)}"


def _further(result: Diagnosis) -> list[str]:
    """What else to measure, beside the next step."""
    advice = []
    if result.separating_experiment:
        advice.append(f"To tell the candidates apart: {result.separating_experiment}.")
    if result.unlisted is not None:
        advice.append(unlisted_advice(result.unlisted["coordinate"]))
    if "gap_before" in result.series and result.gap.confirm_before is None and result.verdict != "named":
        advice.append("Record a second log with other motion (other speeds, other strokes) and give it with --confirm.")
    return advice


def _parameters(result: Diagnosis) -> list[dict[str, Any]]:
    """One row a parameter: as given, re-tuned without and with what was found, with the interval of the last."""
    given: Model | None = result.series.get("given")
    before = {path: p.value for path, p in parameters_of(given).items()} if given is not None else {}
    nominal = {path: p.value for path, p in parameters_of(result.nominal).items()}
    return [
        {
            "path": path,
            "unit": "" if parameter.unit == "1" else parameter.unit,
            "given": numbers(before.get(path)),
            "nominal": numbers(nominal.get(path)),
            "final": numbers(parameter.value),
            "interval": _interval(*result.model.intervals.get(path, (None, None))),
            "new": path.startswith("effects.") and path not in nominal,
        }
        for path, parameter in parameters_of(result.model).items()
    ]
