"""A diagnosis as one HTML file that a machine's owner understands: figures inside, opens offline, prints on paper."""

from __future__ import annotations

import base64
import importlib.metadata
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging._core import EFFECTS
from cogging.diagnosis.report.figures import coordinates_figure, folded_figure, shapes_figure, time_figure
from cogging.diagnosis.report.words import term_text
from cogging.diagnosis.residual.events import FRICTION_INTERVALS, JUMPS, MOMENTS
from cogging.estimation.statistics import moving_average
from cogging.model.model import Model
from cogging.model.parameters import parameters_of
from cogging.outputs import to_toml

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cogging.diagnosis.location import Location
    from cogging.diagnosis.result import Diagnosis, NamedEffect, Value

TEMPLATE = Path(__file__).with_name("page.html.j2")

HEADLINES = {
    "no_gap": "Nothing is missing: the model explains these logs",
    "named": "The model lacks {names}",
    "ambiguous": "The model lacks something; the likeliest is {names}",
    "unlisted": "The model and the machine disagree in a way that no known effect explains",
    "controller_mismatch": "The stated controller did not make this log",
    "insufficient_excitation": "These logs move too little to tell",
}
MEANINGS = {
    "no_gap": (
        "Whatever is left after re-tuning looks like noise in every coordinate. This does not prove that the model is "
        "right everywhere: only that this motion shows nothing wrong with it."
    ),
    "named": (
        "What was found stands out of the noise, fits better than every other effect that was tried, and nothing "
        "significant is left once it is in the model."
    ),
    "ambiguous": (
        "Something is missing beyond doubt, but this motion cannot tell with nine chances in ten which effect it is. "
        "The motion that would decide is described below."
    ),
    "unlisted": (
        "Something significant remains that none of the known effects explains. Effects named beside it stand; "
        "what remains is described by where it sits."
    ),
    "controller_mismatch": (
        "The command that the stated controller would have given differs from the logged one. Until its law, gains or "
        "timing are right, no model of the machine can be judged."
    ),
    "insufficient_excitation": (
        "At rest, friction takes up any force and nothing can be seen. Give a log in which the axis moves."
    ),
}


def html(result: Diagnosis, location: Location | None, *, title: str = "") -> str:
    """The report as a text.

    Args:
        result: what was found.
        location: where the gap sits, or None before anything was measured.
        title: what was diagnosed, such as the names of the logs.

    Raises:
        ValueError: Jinja2, of the extra `report`, is not installed.
    """
    try:
        from jinja2 import Environment, StrictUndefined
    except ImportError as error:
        raise ValueError(f"a report needs {error.name}: pip install 'cogging[report]'") from None
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    page: str = environment.from_string(TEMPLATE.read_text(encoding="utf-8")).render(
        **_content(result, location, title)
    )
    return page


def _content(result: Diagnosis, location: Location | None, title: str) -> dict[str, Any]:
    names = " and ".join(plain(effect.name) for effect in result.effects) or "something"
    return {
        "title": title,
        "version": importlib.metadata.version("cogging"),
        "verdict": result.verdict,
        "headline": HEADLINES[result.verdict].format(names=names),
        "meaning": MEANINGS[result.verdict],
        "gap": result.gap,
        "closed": closed(result),
        "confirmed": confirmed(result),
        "effects": [_effect(result, effect) for effect in result.effects],
        "unlisted": result.unlisted,
        "term": _term(result),
        "at_moments": result.unlisted is not None and result.unlisted["coordinate"] in MOMENTS,
        "where": location.lines() if location is not None else list(result.where_text),
        "next": _next(result),
        "ledger": result.ledger,
        "placebo": result.placebo,
        "notes": result.notes,
        "parameters": _parameters(result),
        "model": to_toml(result.model.to_dict()),
        "figures": {"time": "", "coordinates": "", "shapes": "", "folded": "", **_figures(result, location)},
        "measured": "gap_before" in result.series,
    }


def _term(result: Diagnosis) -> str:
    """What an empirical term makes of the gap; empty where none was added."""
    if result.unlisted is None or "added" not in result.unlisted:
        return ""
    return term_text(result.unlisted["added"], result.gap.unit)


def closed(result: Diagnosis) -> float | None:
    """The part of the gap above the noise that the found effects take away, in power; None where there is none."""
    gap = result.gap
    return _closed(gap.before, gap.after, gap.floor)


def _closed(before: float, after: float, floor: float) -> float | None:
    above = before**2 - floor**2
    return (before**2 - after**2) / above if above > 1e-3 * before**2 and before > 0.0 else None


def confirmed(result: Diagnosis) -> float | None:
    """Gap after over before on the logs that took no part; None without any."""
    gap = result.gap
    return gap.confirm_after / gap.confirm_before if gap.confirm_before and gap.confirm_after is not None else None


def plain(name: str) -> str:
    """A name of the vocabulary as words."""
    return name.replace("_", " ")


def law(name: str) -> str:
    """The formula of an effect as the core states it; of a change, what changed."""
    if name in EFFECTS:
        return str(EFFECTS[name].LAW)
    return f"{plain(name.removesuffix('_change'))} of the axis differs from what the model states"


def chance_text(log_p_value: float) -> str:
    """A chance given as its logarithm, in words."""
    exponent = -log_p_value / np.log(10.0)
    if exponent < 2.0:
        return f"in {100.0 * np.exp(log_p_value):.0f} of 100 logs"
    if exponent < 6.0:
        return f"in 1 of {10 ** int(exponent):,} logs"
    return "practically never, in less than 1 of a million logs"


def _effect(result: Diagnosis, effect: NamedEffect) -> dict[str, Any]:
    reasons = [step.reason for step in result.ledger if step.accepted and step.name == effect.name]
    return {
        "name": effect.name,
        "words": plain(effect.name),
        "law": law(effect.name),
        "confidence": effect.confidence,
        "deviations": float(np.sqrt(max(effect.statistic, 0.0))),
        "statistic": effect.statistic,
        "chance": chance_text(effect.log_p_value),
        "reasons": reasons,
        "where": where_words(effect.where),
        "alternatives": [{"name": name, "words": plain(name), "law": law(name)} for name in effect.alternatives],
        "parameters": _fields(effect.name, [effect.parameters, *effect.further]),
    }


def _fields(name: str, terms: Sequence[Mapping[str, Value]]) -> list[dict[str, Any]]:
    meanings = EFFECTS[name].FIELDS if name in EFFECTS else {}
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


def numbers(value: Any) -> str:
    """A number, or a list of numbers, for a table; a dash where it is not known."""
    if value is None:
        return "–"
    if isinstance(value, int | float):
        return f"{value:.4g}" if np.isfinite(value) else "–"
    return ", ".join(numbers(one) for one in value)


def where_words(where: Mapping[str, Any]) -> str:
    """Coordinate and range as words."""
    span = where.get("range")
    unit = {"position": "m", "velocity": "m/s", "time": "s", "command": "V", "frequency": "Hz"}.get(
        where.get("coordinate", ""), ""
    )
    if not span:
        return f"over {where.get('coordinate', 'all')}"
    return f"in {where['coordinate']}, from {span[0]:.3g} to {span[1]:.3g} {unit}"


def _next(result: Diagnosis) -> list[str]:
    advice = []
    if result.separating_experiment:
        advice.append(f"To tell the candidates apart: {result.separating_experiment}.")
    if result.verdict == "controller_mismatch":
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
        advice.append(_of_unlisted(result.unlisted["coordinate"]))
    return advice


def _of_unlisted(coordinate: str) -> str:
    if coordinate == JUMPS:
        return "Readings jump at the moments told: look at the scale, at the encoder's cable, and at the log's clock."
    if coordinate == FRICTION_INTERVALS:
        return "Friction comes and goes: repeat the motion, and see whether it comes back at the same places or times."
    return (
        f"What no known effect explains depends on {coordinate}: repeat the motion with that alone changed, and see "
        "whether the gap follows."
    )


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
    shared = {name: series[name] for name in ("time", "position", "velocity", "mask")}
    # A replayed gap is part of the logged command: against that, noise alone would look like a gain.
    replayed = result.gap.signal.startswith("command")
    shared["command"] = [
        log.command - (gap if replayed else 0.0) for log, gap in zip(series["logs"], series["gap_before"], strict=True)
    ]
    shared["acceleration"] = [
        np.gradient(moving_average(np.asarray(velocity), round(0.02 / float(np.median(np.diff(time))))), time)
        for velocity, time in zip(series["velocity"], series["time"], strict=True)
    ]
    labels = {"before: re-tuned model": "gap_before"}
    if result.effects:
        labels["after: with what was found"] = "gap_after"
    return {label: {**shared, "gap": series[name]} for label, name in labels.items()}


def overview(result: Diagnosis) -> Figure:
    """What `Diagnosis.plot` shows: the gap before and after against every coordinate.

    Raises:
        ValueError: nothing was measured.
    """
    gaps = gaps_of(result)
    if not gaps:
        raise ValueError(f"plot: needs a gap that was measured, got the verdict {result.verdict}")
    return coordinates_figure(gaps)


def _figures(result: Diagnosis, location: Location | None) -> dict[str, str]:
    gaps = gaps_of(result)
    if not gaps:
        return {}
    figures = {"time": time_figure(gaps), "coordinates": coordinates_figure(gaps)}
    if location is not None:
        told = location.significant[:6]
        if told:
            figures["shapes"] = shapes_figure(told)
        periods = [wave.value for wave in location.waves if wave.coordinate == "spatial period"][:3]
        if periods:
            figures["folded"] = folded_figure(gaps, periods)
    return {name: picture(figure) for name, figure in figures.items()}


def picture(figure: Figure) -> str:
    """A figure as a data address of a PNG."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=140)
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode()
