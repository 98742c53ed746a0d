"""The part of the golden comparison that stays as a test: seconds in all, its values in values.json."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cogging
from tests.fixtures.reproduced import reproduced
from tests.golden import logs as golden_logs

FILE = Path(__file__).parent / "values.json"
PAPERS = ("lu2008", "xu2001")  # tests/papers/numbers.json holds every table within 2 %
NOMINAL = {"mass": 0.3, "viscous": 2.0, "coulomb": 0.6, "coulomb_width": 4e-3, "travel": [-0.15, 0.55]}
UNCERTAINTY = {"mass": 0.03, "viscous": 0.2, "coulomb": 0.2}
MOTION = {"type": "sine", "center": 0.1, "amplitude": 0.09, "frequency": 0.7, "duration": 3.0}
#: What the axis has and the model lacks: fields of [axis], and effects.
HIDDEN: dict[str, tuple[dict[str, float], list[str]]] = {
    "payload": ({"mass": 0.4}, []),
    "cogging": ({}, ["cogging_harmonic"]),
    "drag": ({}, ["quadratic_drag"]),
}


def logs() -> dict[str, Any]:
    """Rms and last value of a log of every controller and every effect, sticking and smooth in turn."""
    found = {}
    for turn, (kind, name) in enumerate(
        [("controller", name) for name in golden_logs.CONTROLLERS] + [("effect", name) for name in golden_logs.EFFECTS]
    ):
        friction = tuple(golden_logs.WIDTHS)[turn % 2]
        if kind == "controller":
            log = golden_logs.controller_log(name, friction)
        else:
            log = golden_logs.effect_log([name], friction)
        found[f"{kind} {name}, {friction}"] = golden_logs.summary(log)
    return found


def paper(name: str) -> Any:
    """The first table of a paper."""
    return reproduced(name).to_dict()["tables"][0]


def axis(fields: dict[str, float], effects: list[str]) -> cogging.Model:
    """The axis of the cases, under a soft PID at 500 Hz."""
    document = golden_logs.LOOP | {
        "axis": NOMINAL | fields | {"uncertainty": UNCERTAINTY},
        "effects": [{"name": name, **golden_logs.EFFECTS[name]} for name in effects],
        "controller": {"type": "pid", "sample_rate": 500.0, "kp": 1000.0, "ki": 1e4, "kd": 30.0},
    }
    return cogging.Model.from_dict(document)


def verdict(hidden: str) -> dict[str, Any]:
    """What `diagnose` says of a log in which something is hidden: verdict, names and alternatives."""
    result = cogging.diagnose(cogging.simulate(axis(*HIDDEN[hidden]), MOTION, seed=3), axis({}, [])).to_dict()
    names = [{"name": effect["name"], "alternatives": effect["alternatives"]} for effect in result["effects"]]
    return {"verdict": result["verdict"], "effects": names}


def write() -> None:
    """Write the values of today."""
    found = {
        "logs": logs(),
        "papers": {name: paper(name) for name in PAPERS},
        "verdicts": {hidden: verdict(hidden) for hidden in HIDDEN},
    }
    FILE.write_text(json.dumps(found, indent=1) + "\n")
    print(f"{FILE} written")


if __name__ == "__main__":
    write()
