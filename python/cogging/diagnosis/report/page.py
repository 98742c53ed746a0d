"""A diagnosis as one HTML file that a machine's owner understands: figures inside, opens offline, prints on paper."""

from __future__ import annotations

import base64
import importlib.metadata
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging.diagnosis.report.figures import (
    coordinates_figure,
    folded_figure,
    shape_term_figure,
    shapes_figure,
    time_figure,
)
from cogging.diagnosis.report.words import (
    HEADLINES,
    MEANINGS,
    chance_text,
    law,
    numbers,
    other_shape_text,
    plain,
    shape_words,
    term_text,
    unlisted_advice,
    where_words,
)
from cogging.diagnosis.residual.shape import MOMENTS
from cogging.diagnosis.thresholds import REPORT
from cogging.model.model import Model
from cogging.model.parameters import parameters_of
from cogging.outputs import to_toml

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cogging.diagnosis.entries import NamedEffect, Value
    from cogging.diagnosis.result import Diagnosis

TEMPLATE = Path(__file__).with_name("page.html.j2")


def html(result: Diagnosis, *, title: str = "") -> str:
    """The report as a text.

    Args:
        result: result that is shown.
        title: name of what was diagnosed, such as those of the logs.

    Raises:
        ValueError: Jinja2, of the extra `report`, is not installed.
    """
    try:
        from jinja2 import Environment, StrictUndefined
    except ImportError as error:
        raise ValueError(f"a report needs {error.name}: pip install 'cogging[report]'") from None
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    page: str = environment.from_string(TEMPLATE.read_text(encoding="utf-8")).render(**_content(result, title))
    return page


def _content(result: Diagnosis, title: str) -> dict[str, Any]:
    names = " and ".join(_headline_name(effect) for effect in result.effects) or "something"
    return {
        "title": title,
        "version": importlib.metadata.version("cogging"),
        "verdict": result.verdict,
        "headline": HEADLINES[result.verdict].format(names=names),
        "meaning": MEANINGS[result.verdict],
        "gap": result.gap,
        "closed": result.gap.closed,
        "confirmed": result.gap.confirmed,
        "effects": [_effect(result, effect) for effect in result.effects],
        "mismatch": result.mismatch,
        "unlisted": result.unlisted,
        "near_rest": _near_rest(result),
        "term": _term(result),
        "at_moments": result.unlisted is not None and result.unlisted["coordinate"] in MOMENTS,
        "where": result.location.lines() if result.location is not None else list(result.where_text),
        "next": _next(result),
        "ledger": result.ledger,
        "placebo": result.placebo,
        "limits": _limits(result),
        "retuned": result.retuned_text(),
        "notes": result.notes,
        "parameters": _parameters(result),
        "model": to_toml(result.model.to_dict()),
        "figures": {"time": "", "coordinates": "", "shapes": "", "folded": "", **_figures(result)},
        "measured": "gap_before" in result.series,
    }


def _headline_name(effect: NamedEffect) -> str:
    return plain(effect.name) if effect.shape_term is None else f"{plain(effect.name)} of a shape of its own"


def _near_rest(result: Diagnosis) -> dict[str, str] | None:
    """What is said of friction near rest; None where it is the model's, or has a name."""
    told = result.near_rest
    if told is None:
        return None
    sentence = told.text()
    return {
        "sentence": sentence[0].upper() + sentence[1:],
        "candidates": " or ".join(plain(name) for name in told.candidates),
    }


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
    reasons = [step.reason for step in result.ledger if step.accepted and step.name == effect.name]
    return {
        "name": effect.name,
        "words": plain(effect.name),
        "law": law(result.vocabulary, effect.name),
        "confidence": effect.confidence,
        "deviations": float(np.sqrt(max(effect.statistic, 0.0))),
        "statistic": effect.statistic,
        "chance": chance_text(effect.log_p_value),
        "reasons": reasons,
        "where": where_words(effect.where),
        "shape": "" if effect.shape_term is None else other_shape_text(effect.shape_term),
        "shape_figure": "" if effect.shape_term is None else picture(shape_term_figure(effect.shape_term)),
        "alternatives": [
            {"name": name, "words": plain(name), "law": law(result.vocabulary, name)} for name in effect.alternatives
        ],
        "parameters": _fields(result, effect.name, [effect.parameters, *effect.further]),
    }


def _fields(result: Diagnosis, name: str, terms: Sequence[Mapping[str, Value]]) -> list[dict[str, Any]]:
    meanings = result.vocabulary[name].FIELDS if name in result.vocabulary else {}
    rows = []
    for i, term in enumerate(terms):
        for field, value in term.items():
            rows.append(
                {
                    "field": field if len(terms) == 1 else f"{field} ({i + 1})",
                    "meaning": meanings[field][1] if field in meanings else "",
                    "value": numbers(value.value),
                    "unit": "" if value.unit == "1" else value.unit,
                    "low": numbers(value.ci95[0]),
                    "high": numbers(value.ci95[1]),
                }
            )
    return rows


def _next(result: Diagnosis) -> list[str]:
    advice = []
    if result.separating_experiment:
        advice.append(f"To tell the candidates apart: {result.separating_experiment}.")
    if result.near_rest is not None:
        advice.append(f"To tell the friction near rest: {result.near_rest.experiment}.")
    if result.mismatch is not None:
        advice.append(result.mismatch["advice"])
    elif result.verdict == "controller_mismatch":
        advice.append(
            "State the controller that was running, its gains and its sample rate; or none, to be judged without."
        )
    elif result.verdict == "insufficient_excitation":
        advice.append("Move the axis over its travel, in both directions, at several speeds, for ten seconds or more.")
    elif result.gap.confirm_before is None:
        advice.append(
            "Record a second log with other motion (other speeds, other strokes) and give it as a confirm log."
        )
    if result.unlisted is not None and result.verdict != "controller_mismatch":
        advice.append(unlisted_advice(result.unlisted["coordinate"]))
    return advice


def _parameters(result: Diagnosis) -> list[dict[str, Any]]:
    """One row a parameter: as given, re-tuned without and with what was found, with the interval of the last."""
    given: Model | None = result.series.get("given")
    before = {path: p.value for path, p in parameters_of(given).items()} if given is not None else {}
    nominal = {path: p.value for path, p in parameters_of(result.nominal).items()}
    rows = []
    for path, parameter in parameters_of(result.model).items():
        low, high = result.model.intervals.get(path, (None, None))
        rows.append(
            {
                "path": path,
                "unit": parameter.unit,
                "given": numbers(before.get(path)),
                "nominal": numbers(nominal.get(path)),
                "final": numbers(parameter.value),
                "low": numbers(low),
                "high": numbers(high),
                "new": path.startswith("effects.") and path not in nominal,
            }
        )
    return rows


# Figures --------------------------------------------------------------------------------------------------------------


def gaps_of(result: Diagnosis) -> dict[str, dict[str, Any]]:
    """Rows of the logs by name, with the gap before and after; empty where nothing was measured."""
    series = result.series
    if "gap_before" not in series:
        return {}
    shared = {name: series[name] for name in ("time", "position", "velocity", "acceleration", "command", "mask")}
    labels = {"before: re-tuned model": "gap_before"}
    if result.effects:
        labels["after: with what was found"] = "gap_after"
    return {label: {**shared, "gap": series[name]} for label, name in labels.items()}


def _figures(result: Diagnosis) -> dict[str, str]:
    gaps = gaps_of(result)
    if not gaps:
        return {}
    figures = {"time": time_figure(gaps), "coordinates": coordinates_figure(gaps)}
    if result.location is not None:
        told = result.location.significant[: REPORT.shapes_drawn]
        if told:
            figures["shapes"] = shapes_figure(told)
        periods = [wave.value for wave in result.location.waves if wave.coordinate == "spatial period"][
            : REPORT.periods_drawn
        ]
        if periods:
            figures["folded"] = folded_figure(gaps, periods)
    return {name: picture(figure) for name, figure in figures.items()}


def picture(figure: Figure) -> str:
    """A figure as a data address of a PNG."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=140)
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode()
