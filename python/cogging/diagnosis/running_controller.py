"""The controller that was running when the logs were made, and whether its loop can be replayed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cogging.log_check.controller_check import ControllerCheck, check_controller
from cogging.log_check.controller_recovery import recover_controller
from cogging.logs.log import Log
from cogging.model.model import Model

MISSED = 1e-3  # of the rms command: a stated controller that misses more has its gains refitted


@dataclass(frozen=True)
class RunningController:
    """What the logs say of the controller.

    Attributes:
        model: the given model with the controller that the logs show.
        replay: whether the loop can be replayed.
        contradiction: sentence on how the logs contradict the stated controller, or None.
        notes: sentences on what was changed.
    """

    model: Model
    replay: bool
    contradiction: str | None = None
    notes: tuple[str, ...] = ()


def running_controller(logs: Sequence[Log], model: Model) -> RunningController:
    """The stated controller held against the logs; where none is stated, the one that they show."""
    if model.controller is None:
        return _recovered(logs, model)
    replay = all(log.reference is not None for log in logs)
    notes: list[str] = []
    for log in logs:
        check = check_controller(log, model)
        if check is None or check.reproduces is None:
            replay = False
            continue
        if check.reproduces is False:
            missed = 100 * (check.relative or 0.0)
            contradiction = f"the stated controller misses the logged command by {missed:.1f} % rms"
            return RunningController(model, False, contradiction, tuple(notes))
        fitted, note = _with_gains_that_fit(check, model)
        if note:
            model = fitted
            notes.append(note)
    return RunningController(model, replay, None, tuple(notes))


def _recovered(logs: Sequence[Log], model: Model) -> RunningController:
    """The controller that all logs show where the model states none."""
    found = [recover_controller(log) if log.reference is not None else None for log in logs]
    first = found[0]
    if first is None or any(one is None for one in found):
        return RunningController(model, False)
    note = f"no controller is stated; the log shows a {first.type}, which is replayed"
    recovered = model.replace(controller=first.parameters, controller_type=first.type)
    return RunningController(recovered, True, None, (note,))


def _with_gains_that_fit(check: ControllerCheck, model: Model) -> tuple[Model, str]:
    """The model with the gains that reproduce the command better, and a note; as it is where it is close enough."""
    valid = bool(check.fitted) and min(check.fitted.values()) >= 0.0  # a motion may leave a gain to chance
    if not ((check.relative or 0.0) > MISSED and valid and model.controller is not None):
        return model, ""
    fields = {k: v for k, v in check.fitted.items() if k in type(model.controller).FIELDS}
    note = (
        f"the stated controller reproduces the command to {100 * (check.relative or 0.0):.2g} %; the loop is "
        "replayed with the gains that fit: " + ", ".join(f"{k} {v:.5g}" for k, v in fields.items())
    )
    return model.replace(controller=model.controller.replace(**fields)), note


def obeys(log: Log, model: Model) -> bool:
    """Whether the command of a log is that of the model's controller."""
    check = check_controller(log, model) if log.reference is not None else None
    return check is not None and bool(check.reproduces)
