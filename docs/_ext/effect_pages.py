"""The catalogue of effects as pages: one for each effect of the core's list, and one that shows them all."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from api_pages import put

import cogging
from cogging.arrays import FloatArray
from cogging.diagnosis.places import COORDINATE_UNITS
from cogging.diagnosis.report.pictures import in_schemes, picture
from cogging.diagnosis.report.sentences import along_of
from cogging.effects.effect import VOCABULARY, Effect

sys.path.insert(0, str(Path(__file__).parents[2]))
from tests.fixtures.plants_by_hand import example  # the examples that the tests hold to their laws

#: What each hook of the core acts on.
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
MASS, VISCOUS, COULOMB, WIDTH = 0.3, 2.0, 0.4, 5e-3  # of the axis of the figures
MOTION = {"type": "point_to_point", "start": -0.1, "distance": 0.62, "velocity": 0.5, "acceleration": 4.0}
MOTION |= {"jerk": 80.0, "dwell": 0.1, "repeats": 2}


def write(folder: Path) -> None:
    """Write all pages and figures."""
    folder.mkdir(parents=True, exist_ok=True)
    cards = ["``````{grid} 1 2 2 3\n:gutter: 3\n:class-container: effect-cards"]
    for name in VOCABULARY:
        effect = example(name)
        shown = figure(effect)
        for scheme, svg in in_schemes(shown.svg).items():
            put(folder / f"{name}_{scheme}.svg", svg)
        put(folder / f"{name}.md", page(effect, shown.finding))
        drawn = images(name, shown.finding, "_generated/effects/", "thumbnail")
        link = f":link: _generated/effects/{name}\n:link-type: doc"
        cards.append(f"`````{{grid-item-card}} {title(effect)}\n{link}\n\n{drawn}\n`````")
    put(folder / "cards.md", "\n\n".join([*cards, "``````"]) + "\n")


def title(effect: Effect) -> str:
    """Return the name of an effect as a heading."""
    return effect.NAME.replace("_", " ").capitalize()


def page(effect: Effect, finding: str) -> str:
    """Return the page of one effect."""
    acts = ", and on ".join(ACTS_ON[hook] for hook in effect.HOOKS)
    fields = tomli_w.dumps({"name": effect.NAME, **effect.to_dict()})
    parts = [
        f"# {title(effect)}\n\n`{effect.NAME}` acts on {acts}.\n\n    {effect.LAW}",
        fields_table(effect),
        f"{images(effect.NAME, finding)}\n\n{finding} An axis of {MASS} V/(m/s²) moves under a PID; without noise.",
        f"The effect of the figure in a model file:\n\n```toml\n[[effects]]\n{fields}```",
        f"```{{eval-rst}}\n.. autoclass:: cogging.effects.{type(effect).__name__}\n   :no-index-entry:\n```",
    ]
    return "\n\n".join(parts) + "\n"


def fields_table(effect: Effect) -> str:
    """Return the fields with unit, meaning and neutral value."""
    lines = ["| field | unit | meaning | no effect at |", "|---|---|---|---|"]
    for name, (unit, meaning) in effect.FIELDS.items():
        neutral = effect.ROLES[name]["neutral"]
        words = {"None": "", "[]": "no entries", "inf": "infinity"}
        shown = f"{neutral:g}" if isinstance(neutral, float) and neutral != np.inf else words[str(neutral)]
        text = meaning.replace("|", "\\|")
        lines.append(f"| `{name}` | {'' if unit == '1' else unit} | {text} | {shown} |")
    return "\n".join(lines)


def images(name: str, finding: str, folder: str = "", kind: str = "signature") -> str:
    """Return the figure for light and dark."""
    return "\n".join(
        f"```{{image}} {folder}{name}_{scheme}.svg\n:class: only-{scheme} {kind}\n:alt: {finding}\n```"
        for scheme in ("light", "dark")
    )


def figure(effect: Effect) -> Any:
    """Return the figure of the force that a model without the effect lacks, along the coordinate of the effect."""
    rows = lacking(effect)
    along = along_of(effect.NAME, VOCABULARY)
    along = along if along in rows else "time"
    finding = f"Force that a model without {effect.NAME.replace('_', ' ')} lacks, against {along}."

    def draw(axes: Any) -> None:
        axes.plot(rows[along], rows["lacking"])
        axes.set(xlabel=f"{along} ({COORDINATE_UNITS[along]})", ylabel="missing force (V)")

    return picture(draw, finding)


def lacking(effect: Effect) -> dict[str, FloatArray]:
    """Return the rows of a run with the effect, and the force that mass and friction of its readings leave, V."""
    kp, ki, kd = cogging.pid_gains([-10.0] * 3, MASS)
    friction: dict[str, float] = {"mass": MASS, "viscous": VISCOUS, "coulomb": COULOMB, "coulomb_width": WIDTH}
    pid = cogging.PidParameters(sample_rate=1000.0, kp=kp, ki=ki, kd=kd, **friction)
    axis = cogging.AxisParameters(**friction)
    model = cogging.Model(axis, effects=[effect], controller=pid, controller_type="pid")
    log = cogging.simulate(model, MOTION, seed=1)
    velocity = np.gradient(log.position, log.time)
    rubbed = VISCOUS * velocity + COULOMB * 2.0 / np.pi * np.arctan(velocity / WIDTH)
    applied = 0.5 * (log.command + np.roll(log.command, 1))  # a command acts from its row on
    missing = applied - MASS * np.gradient(velocity, log.time) - rubbed
    rows = {"time": log.time, "position": log.position, "velocity": velocity, "command": log.command}
    return {name: values[2:-2] for name, values in {**rows, "lacking": -missing}.items()}
