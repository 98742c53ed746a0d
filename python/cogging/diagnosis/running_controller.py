"""The controller that was running when the logs were recorded, and whether its loop can be replayed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cogging.log_check.controller_check import check_controller
from cogging.log_check.controller_recovery import recover_controller
from cogging.logs.log import Log
from cogging.model.model import Model

MISSED = 1e-3  # of the rms command: error of the stated controller above which its gains are re-fitted


@dataclass(frozen=True)
class RunningController:
    """Controller of the logs."""

    model: Model  # given model with that controller
    replay: bool  # whether the loop can be replayed
    contradiction: str | None = None  # how the logs contradict the stated controller
    notes: tuple[str, ...] = ()  # on changes of the controller


def running_controller(logs: Sequence[Log], model: Model) -> RunningController:
    """Check the stated controller against the logs, or recover one from them if none is stated."""
    if model.controller is None:
        found = [recover_controller(log) if log.reference is not None else None for log in logs]
        first = found[0]
        if first is None or any(one is None for one in found):
            return RunningController(model, False)
        note = f"no controller is stated; the logs show a {first.type} controller, which is replayed"
        recovered = model.replace(controller=first.parameters, controller_type=first.type)
        return RunningController(recovered, True, None, (note,))
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
        valid = bool(check.fitted) and min(check.fitted.values()) >= 0.0  # a gain may not be identifiable
        if (check.relative or 0.0) > MISSED and valid and model.controller is not None:
            fields = {k: v for k, v in check.fitted.items() if k in type(model.controller).FIELDS}
            gains = ", ".join(f"{k} {v:.5g}" for k, v in fields.items())
            notes.append(
                f"the stated controller reproduces the command to {100 * (check.relative or 0.0):.2g} %; the loop is "
                f"replayed with re-fitted gains: {gains}"
            )
            model = model.replace(controller=model.controller.replace(**fields))
    return RunningController(model, replay, None, tuple(notes))


def obeys(log: Log, model: Model) -> bool:
    """Return whether the model's controller reproduces the command of a log."""
    check = check_controller(log, model) if log.reference is not None else None
    return check is not None and bool(check.reproduces)
