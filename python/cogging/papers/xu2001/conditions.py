"""What Xu and Yao 2001 do not report and Table 1 needs: the plant, the adaptation's scale, what the ARC knew before."""

from __future__ import annotations

import importlib.resources
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from cogging._core import OutputFeedbackArc, OutputFeedbackArcParameters, Pid
from cogging.files import parse_toml
from cogging.logs.log import Log
from cogging.papers.xu2001.setup import (
    CONTROLLERS,
    SEED,
    SETS,
    Unknowns,
    arc_parameters,
    pid_parameters,
    run,
)

#: What the fits vary: to the PID's numbers, and to all; earlier_runs is chosen among 0 to 4.
PID_FREE = tuple(Unknowns.__dataclass_fields__)
JOINT_FREE = (*PID_FREE, "adaptation_factor", "earlier_runs")
#: Which numbers of Table 1 a fit takes: sets by controller.
PID: Mapping[str, Sequence[str]] = {"PID": SETS}
ALL: Mapping[str, Sequence[str]] = {"PID": SETS, "ARC": SETS}
#: Which numbers take part in a held-out fit; the others are predicted.
HELD_OUT: dict[str, Mapping[str, Sequence[str]]] = {
    "set_2": {"PID": ("1", "3"), "ARC": ("1", "3")},
    "arc_sets_2_3": {"PID": SETS, "ARC": ("1",)},
}


@dataclass(frozen=True)
class Conditions:
    """One set of unreported conditions.

    Attributes:
        unknowns: of the plant.
        adaptation_factor: on the printed rates Gamma (section 4.3); 1 = as printed.
        earlier_runs: of the same set, from which the ARC keeps theta_1 and theta_2 (setup.after_earlier_runs);
            0 = each set begins with the printed theta_hat(0).
        changes: further numbers of the ARC that are not as printed, by field.
    """

    unknowns: Unknowns
    adaptation_factor: float = 1.0
    earlier_runs: int = 0
    changes: Mapping[str, Any] = field(default_factory=dict)

    def arc_parameters(self) -> OutputFeedbackArcParameters:
        """The ARC of the first of the runs."""
        printed = arc_parameters()
        fields = {"adaptation": [self.adaptation_factor * rate for rate in printed.adaptation]}
        return printed.replace(**{**fields, **self.changes})

    def logs(self, controller: str, sets: Sequence[str] = SETS, seed: int = SEED) -> dict[str, Log]:
        """The recorded runs of a controller of Table 1, by set."""
        if controller == "PID":
            return run(self.unknowns, Pid(pid_parameters()), sets=sets, seed=seed)
        arc = OutputFeedbackArc(self.arc_parameters())
        return run(self.unknowns, arc, sets=sets, seed=seed, earlier_runs=self.earlier_runs)

    def all_logs(self, seed: int = SEED) -> dict[str, dict[str, Log]]:
        """Both controllers in all sets."""
        return {controller: self.logs(controller, seed=seed) for controller in CONTROLLERS}


def shipped_file() -> dict[str, Any]:
    """What plant.toml holds."""
    return parse_toml(
        importlib.resources.files("cogging.papers.xu2001").joinpath("plant.toml").read_text(encoding="utf-8")
    )


def conditions_of(part: Mapping[str, Any]) -> Conditions:
    """The conditions that a part of plant.toml states."""
    return Conditions(
        Unknowns(**part["unknowns"]),
        part.get("adaptation_factor", 1.0),
        part.get("earlier_runs", 0),
        part.get("changes", {}),
    )


def joint_conditions(law: str = "smooth_stribeck") -> Conditions:
    """The conditions that are fitted to all numbers of Table 1, by friction law: those of the reproduced table."""
    return conditions_of(shipped_file()["joint"][law])
