"""What Xu and Yao 2001 do not report and Table 1 needs: the plant, the adaptation's scale, what the ARC knew before."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from cogging._core import OutputFeedbackArc, OutputFeedbackArcParameters, Pid
from cogging.arrays import FloatArray
from cogging.logs.log import Log
from cogging.model.controller import ListedController
from cogging.papers.fitting import shipped_toml
from cogging.papers.xu2001.setup import (
    CONTROLLERS,
    SEED,
    SEEDS,
    SETS,
    Unknowns,
    arc_parameters,
    indexes_by_seed,
    pid_parameters,
    run,
)

#: Models of the plant: what each holds fixed; 0 takes an effect away. A model is nested in those that fix less.
LAWS: dict[str, dict[str, float]] = {
    "smooth_stribeck": {},
    "smooth_coulomb": {"static_excess": 0.0, "stribeck_velocity": 0.01},
    "smooth_coulomb_without_offset": {"static_excess": 0.0, "stribeck_velocity": 0.01, "offset": 0.0},
    "exact_stribeck": {"coulomb_width": 0.0},
    "exact_coulomb": {"coulomb_width": 0.0, "static_excess": 0.0, "stribeck_velocity": 0.01},
}
JOINT_LAW = "smooth_coulomb_without_offset"
#: What the fits vary: to the PID's numbers, and to all; earlier_runs is chosen among 0 to 3.
PID_FREE = tuple(Unknowns.__dataclass_fields__)
JOINT_FREE = (*(name for name in PID_FREE if name not in LAWS[JOINT_LAW]), "adaptation_factor", "earlier_runs")
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

    def controller(self, name: str) -> ListedController:
        """A controller of Table 1, as it begins the first of the runs."""
        return Pid(pid_parameters()) if name == "PID" else OutputFeedbackArc(self.arc_parameters())

    def logs(self, controller: str, seed: int = SEED) -> dict[str, Log]:
        """The recorded runs of a controller of Table 1, by set."""
        return run(self.unknowns, self.controller(controller), seed=seed, earlier_runs=self.earlier_runs)

    def by_seed(self, controller: str, sets: Sequence[str] = SETS, seeds: Sequence[int] = SEEDS) -> FloatArray:
        """The indexes of a controller of Table 1 by set, seed of the encoder noise and index, (sets, seeds, 6)."""
        made, runs = self.controller(controller), self.earlier_runs
        return indexes_by_seed(self.unknowns, made, seeds=seeds, sets=sets, earlier_runs=runs)

    def table(self) -> dict[str, FloatArray]:
        """The means of the indexes over SEEDS by controller, (3, 6)."""
        return {controller: self.by_seed(controller).mean(axis=1) for controller in CONTROLLERS}


def shipped_file() -> dict[str, Any]:
    """What plant.toml holds."""
    return shipped_toml("cogging.papers.xu2001", "plant.toml")


def conditions_of(part: Mapping[str, Any]) -> Conditions:
    """The conditions that a part of plant.toml states."""
    return Conditions(
        Unknowns(**part["unknowns"]),
        part.get("adaptation_factor", 1.0),
        part.get("earlier_runs", 0),
        part.get("changes", {}),
    )


def joint_conditions(law: str = JOINT_LAW) -> Conditions:
    """The conditions that are fitted to all numbers of Table 1, by friction law: those of the reproduced table."""
    return conditions_of(shipped_file()["joint"][law])
