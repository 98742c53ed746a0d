"""The part of the golden comparison that stays as a test: seconds in all, its values in values.json."""

import json
from pathlib import Path
from typing import Any

import cogging
from tests.golden import logs as golden_logs

FILE = Path(__file__).parent / "values.json"
NOMINAL = {"mass": 0.3, "viscous": 2.0, "coulomb": 0.6, "coulomb_width": 4e-3, "travel": [-0.15, 0.55]}
UNCERTAINTY = {"mass": 0.03, "viscous": 0.2, "coulomb": 0.2}
MOTION = {"type": "sine", "center": 0.1, "amplitude": 0.09, "frequency": 0.7, "duration": 3.0}
#: What the axis has and the model lacks: fields of [axis], and effects.
HIDDEN: dict[str, tuple[dict[str, float], list[str]]] = {
    "payload": ({"mass": 0.4}, []),
    "cogging": ({}, ["cogging_harmonic"]),
    "drag": ({}, ["quadratic_drag"]),
}


def logs() -> dict[str, list[float]]:
    """Summaries of a log of every controller and every effect, sticking and smooth in turn."""
    found = {}
    for turn, name in enumerate([*golden_logs.CONTROLLERS, *golden_logs.EFFECTS]):
        friction = tuple(golden_logs.WIDTHS)[turn % 2]
        if name in golden_logs.CONTROLLERS:
            found[f"controller {name}, {friction}"] = golden_logs.summary(golden_logs.controller_log(name, friction))
        else:
            found[f"effect {name}, {friction}"] = golden_logs.summary(golden_logs.effect_log([name], friction))
    return found


def axis(fields: dict[str, float], effects: list[str]) -> cogging.Model:
    """The axis of the cases, under a soft PID at 500 Hz."""
    document = golden_logs.LOOP | {
        "axis": NOMINAL | fields | {"uncertainty": UNCERTAINTY},
        "effects": [{"name": name, **golden_logs.EFFECTS[name]} for name in effects],
        "controller": {"type": "pid", "sample_rate": 500.0, "kp": 1000.0, "ki": 1e4, "kd": 30.0},
    }
    return cogging.Model.from_dict(document)


def verdict(hidden: str) -> list[Any]:
    """What `diagnose` says of a log in which something is hidden: verdict, names, and alternatives where there are."""
    result = cogging.diagnose(cogging.simulate(axis(*HIDDEN[hidden]), MOTION, seed=3), axis({}, [])).to_dict()
    effects = result["effects"]
    names = [effect["name"] for effect in effects]
    return [result["verdict"], *names, *(effect["alternatives"] for effect in effects if effect["alternatives"])]


def text(document: dict[str, dict[str, list[Any]]]) -> str:
    """JSON with one line an entry."""
    parts = [
        f' "{part}": {{\n' + ",\n".join(f'  "{name}": {json.dumps(values)}' for name, values in found.items()) + "\n }"
        for part, found in document.items()
    ]
    return "{\n" + ",\n".join(parts) + "\n}\n"


if __name__ == "__main__":
    FILE.write_text(text({"logs": logs(), "verdicts": {hidden: verdict(hidden) for hidden in HIDDEN}}))
    print(f"{FILE} written")
