"""The controllers that a model states or that its bounds give, by name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from cogging._core import (
    Arc,
    Cascade,
    Dcarc,
    ObserverBased,
    OutputFeedbackArc,
    Pid,
    Reference,
)
from cogging.design.bounds import Bounds
from cogging.design.observer import design_observer
from cogging.model.controller import AnyController, ListedController
from cogging.model.intervals import Interval
from cogging.model.model import Model
from cogging.shown import nearest

#: The controllers that are designed from the bounds of a model.
DESIGNED = ("pid", "cascade", "arc", "dcarc", "output_feedback_arc", "observer_based")
#: Name of the model's own controller in a prediction.
OWN = "own"
VELOCITY_RATIO = 0.25  # smallest over largest reference speed at which an observer cancels (cogging.papers.comparison)


def chosen_controllers(
    model: Model,
    motion: Reference,
    duration: float,
    controllers: Mapping[str, AnyController] | Sequence[str] | None,
    bandwidth: float | None,
    default: Mapping[str, Interval] | None,
) -> tuple[dict[str, AnyController], list[str]]:
    """The controllers to run on a motion, and which were left out and why.

    Raises:
        ValueError: the names are no list of different known ones, one that was named cannot be had, none is left.
    """
    if isinstance(controllers, Mapping):
        if not controllers:
            raise ValueError("controllers: must be at least one, got none")
        return dict(controllers), []
    if controllers is not None and not isinstance(controllers, Iterable):
        raise TypeError(f"controllers: must be names, or controllers by name, got {type(controllers).__name__}")
    wanted = _wanted(controllers)
    velocity = float(np.abs(motion.sample(np.linspace(0.0, duration, 4001))[1]).max())
    chosen: dict[str, AnyController] = {}
    notes: list[str] = []
    bounds: Bounds | None = None
    for name in wanted:
        try:
            if name == OWN:
                chosen[name] = model.make_controller()
                continue
            if bounds is None:
                bounds = Bounds.of(model, default=default, velocity_max=velocity or 1.0)
                notes += bounds.notes
            chosen[name] = _designed(name, bounds, velocity, bandwidth)
        except (ValueError, ImportError) as error:
            if controllers is not None:
                raise ValueError(f"{name}: {error}") from None
            if bounds is None and name != OWN:
                notes.append(f"controllers from the bounds left out: {error}")
                break
            notes.append(f"{name} left out: {error}")
    if not chosen:
        raise ValueError("; ".join(notes))
    return chosen, notes


def _wanted(controllers: Sequence[str] | None) -> list[str]:
    """The names that are asked for; all where none is."""
    wanted = list(controllers) if controllers is not None else [OWN, *DESIGNED]
    if isinstance(controllers, str) or not wanted or len(set(wanted)) != len(wanted):
        raise ValueError(f"controllers: must be a list of different names, got {controllers!r}")
    for name in wanted:
        if name not in (OWN, *DESIGNED):
            known = (OWN, *DESIGNED)
            rule = f"each must be one of {', '.join(known)}"
            raise ValueError(f"controllers: {rule}, got {name!r}{nearest(str(name), known)}")
    return wanted


def _designed(name: str, bounds: Bounds, velocity: float, bandwidth: float | None) -> ListedController:
    if name == "pid":
        return Pid(bounds.pid(bandwidth=bandwidth))
    if name == "cascade":
        return Cascade(bounds.cascade(bandwidth=bandwidth))
    if name == "arc":
        return Arc(bounds.adaptive_robust(bandwidth=bandwidth))
    if name == "dcarc":
        return Dcarc(bounds.adaptive_robust(bandwidth=bandwidth))
    if name == "output_feedback_arc":
        return OutputFeedbackArc(bounds.output_feedback(bandwidth=bandwidth))
    problem = bounds.observer_problem(VELOCITY_RATIO * velocity, velocity, bandwidth=bandwidth)
    return ObserverBased(bounds.observer_based(problem, design_observer(problem)))
