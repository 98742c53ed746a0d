"""The catalogue of effects as pages: one for each effect of the core's list, and one that shows them all."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomli_w
from effect_figures import profile, save
from effect_signatures import SEPARATES, Signature, signature
from law_formula import formula
from small_machine import MOTIONS

import cogging
from cogging.diagnosis.detection_limits import is_sought
from cogging.effects.effect import VOCABULARY, Effect

#: What each hook of the core acts on, in words, and what its law gives.
ACTS_ON = {
    "force": "the axis, as a force",
    "friction_level": "the friction, as an addition to the Coulomb level",
    "command_gain": "the command, as a gain",
    "shape_command": "the command, as a curve that it passes through",
    "command_delay": "the command, as a delay",
    "lag": "the command, as a lag",
    "reading": "the encoder, as an error of the reading",
    "state": "the axis, with states of its own",
}
TELLING = 0.1  # share from which a look-alike is named
NAMED = 6  # look-alikes at most
#: What a search measures a field against, in words; of what is not here, the bare number.
MEASURED_AGAINST = {
    "force": "largest command",
    "command": "largest command",
    "friction": "Coulomb level",
    "position": "travel",
    "distance": "travel",
    "velocity": "largest speed",
    "time": "duration",
    "sample_time": "sample time",
    "frequency": "half the sample rate",
    "force_per_position": "largest command / travel",
    "force_per_velocity": "largest command / largest speed",
    "force_per_velocity_squared": "largest command / largest speed²",
    "stiffness": "Coulomb level / travel",
}


def title(effect: Effect) -> str:
    """The name of an effect as a heading."""
    return effect.NAME.replace("_", " ").capitalize()


def write(folder: Path) -> list[Path]:
    """All pages and figures, unless those that stand there were made from the same core by the same code."""
    stamp = folder / "made_from.txt"
    made_from = _made_from()
    if stamp.exists() and stamp.read_text(encoding="utf-8") == made_from:
        return sorted(folder.glob("*.md"))
    folder.mkdir(parents=True, exist_ok=True)
    for old in (*folder.glob("*.md"), *folder.glob("*.svg")):
        old.unlink()
    known = {}
    for name, law in VOCABULARY.items():
        known[name] = signature(law)
        save(known[name], folder)
        (folder / f"{name}.md").write_text(page(known[name]), encoding="utf-8")
    (folder / "cards.md").write_text(cards(known), encoding="utf-8")
    stamp.write_text(made_from, encoding="utf-8")
    return sorted(folder.glob("*.md"))


def _made_from() -> str:
    """A digest of all that decides what stands on the pages."""
    package = Path(cogging.__file__).parent
    rooms = [package / "diagnosis", package / "estimation", package / "identification", package / "simulation"]
    own = ("coordinates", "effect_figures", "effect_pages", "effect_signatures", "law_formula", "small_machine")
    files = [Path(str(cogging._core.__file__)), *(Path(__file__).parent / f"{name}.py" for name in own)]
    files += [file for room in rooms for file in sorted(room.rglob("*.py"))]
    digest = hashlib.sha256()
    for file in files:
        digest.update(file.read_bytes())
    return digest.hexdigest()


def page(found: Signature) -> str:
    """The page of one effect."""
    effect = VOCABULARY[found.effect.NAME]
    acts = ", and on ".join(ACTS_ON[hook] for hook in effect.HOOKS)
    parts = [
        f"# {title(effect)}\n\n`{effect.NAME}` acts on {acts}.",
        f"$$\n{formula(effect.LAW, effect.FIELDS)}\n$$",
        _fields(effect),
        "## What it looks like\n\n" + picture(found) + "\n\n" + _told(found),
        "## What it is confused with\n\n" + _confusions(found),
        "## In a model file\n\nThe effect of the figure:\n\n```toml\n" + _toml(found.effect) + "```",
        "## In Python\n\n```{eval-rst}\n.. autoclass:: cogging.effects."
        + type(effect).__name__
        + "\n   :no-index-entry:\n```",
    ]
    return "\n\n".join(parts) + "\n"


def _fields(effect: Effect) -> str:
    """Fields with unit, meaning, neutral value and where a search looks."""
    lines = ["| field | unit | what it is | does nothing at | looked for |", "|---|---|---|---|---|"]
    for name, (unit, meaning) in effect.FIELDS.items():
        role = effect.ROLES[name]
        neutral = role["neutral"]
        at = (
            ""
            if neutral is None
            else "no entries"
            if neutral == []
            else "infinity"
            if neutral == float("inf")
            else f"{neutral:g}"
        )
        told = meaning.replace("|", "\\|")
        lines.append(f"| `{name}` | {'' if unit == '1' else unit} | {told} | {at} | {_range(role)} |")
    return "\n".join(lines)


def _range(role: Mapping[str, Any]) -> str:
    """Where a search looks for a field: multiples of a quantity of the log."""
    if role["role"] == "setting":
        return "not"
    against = MEASURED_AGAINST.get(role["quantity"])
    return f"{role['low']:g} to {role['high']:g}" + (f" × {against}" if against else "")


def picture(found: Signature, thumbnail: bool = False) -> str:
    """The figure, in the colours of either scheme, with what it shows as its alternative text."""
    name, text = found.effect.NAME, alternative(found)
    kind = "thumbnail" if thumbnail else "signature"
    return "\n".join(
        f"```{{image}} {name}_{scheme}.svg\n:class: only-{scheme} {kind}\n:alt: {text}\n```"
        for scheme in ("light", "dark")
    )


def alternative(found: Signature) -> str:
    """What the figure shows, in a sentence."""
    subject = f"What a model without {found.effect.NAME.replace('_', ' ')} leaves unexplained"
    if found.place.explained < SEPARATES:
        largest = float(abs(found.residual).max())
        return f"{subject}, over time about its largest value of {largest:.2g} V, with the command below it."
    told = []
    for way, (places, means) in profile(found).items():
        high, low = means.argmax(), means.argmin()
        moving = f"moving {way} " if way else ""
        told.append(
            f"{moving}from {means[low]:.2g} V at {places[low]:.2g} {found.place.unit} "
            f"to {means[high]:.2g} V at {places[high]:.2g} {found.place.unit}"
        )
    return f"{subject}, against {found.place.name}: {'; '.join(told)}."


def _told(found: Signature) -> str:
    """How the figure came about."""
    rms = float((found.residual**2).mean() ** 0.5)
    best = (
        f"The {found.place.name} tells {percent(found.place.explained)} of it, more than any other coordinate."
        if found.place.explained >= SEPARATES
        else "No single coordinate tells half of it, so it is drawn over time, close up."
    )
    return (
        f"What a model without the effect does not foresee ({rms:.2g} V rms) while the [small machine]"
        f"(../../effects.md#the-small-machine) makes random moves, without noise. {best}"
    )


def _confusions(found: Signature) -> str:
    """What re-tuning and the other effects would make of it, by motion."""
    told = []
    for motion, confusion in found.confusion.items():
        alike = [(name, share) for name, share in confusion.explained if share >= TELLING][:NAMED]
        names = ", ".join(f"[`{name}`]({name}.md) {percent(share)}" for name, share in alike)
        told.append(f"| {motion} | {percent(confusion.retuned)} | {names or f'none explains {percent(TELLING)}'} |")
    asked = (
        ""
        if is_sought(found.effect)
        else ("\n\nA search never looks for this one: its amplitudes stand at places of the user's own choice.")
    )
    return (
        "Of what it leaves, re-tuning the axis and the map takes a share away; of the rest, another effect at its best "
        "shape and size explains a share. What comes close to 100 % cannot be told from it by that motion.\n\n"
        "| motion | re-tuning takes | of the rest, explained by |\n|---|---|---|\n" + "\n".join(told) + asked
    )


def _toml(effect: Effect) -> str:
    """The effect as it stands in a model file."""
    fields = {name: _rounded(value) for name, value in effect.to_dict().items()}
    return "[[effects]]\n" + tomli_w.dumps({"name": effect.NAME, **fields})


def _rounded(value: Any) -> Any:
    if isinstance(value, list):
        return [_rounded(one) for one in value]
    return float(f"{value:.3g}") if isinstance(value, float) else value


def cards(known: Mapping[str, Signature]) -> str:
    """All effects side by side, each with its figure, law and what it looks most like."""
    made = ["``````{grid} 1 2 2 3\n:gutter: 3\n:class-container: effect-cards"]
    for name, found in known.items():
        rival, share = found.confusion[list(MOTIONS)[-1]].explained[0]
        alike = f"Taken for `{rival}`: {percent(share)}" if share >= TELLING else "Taken for no other"
        picture_ = picture(found, thumbnail=True).replace("{image} ", "{image} _generated/effects/")
        made.append(
            f"`````{{grid-item-card}} {title(found.effect)}\n:link: _generated/effects/{name}\n:link-type: doc\n\n"
            f"{picture_}\n\n{alike}\n`````"
        )
    made.append("``````")
    return "\n\n".join(made) + "\n"


def percent(share: float) -> str:
    """A share in percent, not parted at the end of a line."""
    return f"{100.0 * share:.0f}\u00a0%"
