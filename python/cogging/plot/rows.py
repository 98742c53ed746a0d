"""What a picture is of: columns of logs and of tables by name, arrays, and several logs under their names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from cogging.arrays import FloatArray
from cogging.calls import described, did_you_mean

#: Columns of a log, with their units.
UNITS = {
    "position": "m",
    "reference": "m",
    "error": "m",
    "command": "V",
    "reference_velocity": "m/s",
    "reference_acceleration": "m/s^2",
    "true_position": "m",
    "true_velocity": "m/s",
}


def numbers(name: str, values: npt.ArrayLike, length: int | None = None) -> FloatArray:
    """Values as an array of real numbers; nan is drawn as a gap.

    Args:
        name: of the argument.
        values: (n,).
        length: n, or None.
    """
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: must be an array of real numbers, got {described(values)}") from None
    if array.ndim != 1 or not array.size:
        raise ValueError(f"{name}: must have the shape (n,) with at least 1 entry, got {array.shape}")
    if length is not None and array.size != length:
        raise ValueError(f"{name}: must be as long as what it is drawn over ({length}), got {array.size}")
    return array


def is_table(value: Any) -> bool:
    """Whether a value has columns by name, `time` among them: a log, a mapping of arrays, a DataFrame."""
    if hasattr(value, "time") and hasattr(value, "position"):
        return True
    return hasattr(value, "keys") and "time" in value and not hasattr(value["time"], "position")


def names_of(log: Any) -> list[str]:
    """Columns over time that can be drawn, by name."""
    if hasattr(log, "keys"):
        names = [str(name) for name in log if name != "time"]
    else:
        names = [name for name in UNITS if name != "error" and getattr(log, name, None) is not None]
    return names + ["error"] * ("reference" in names and "position" in names and "error" not in names)


def column(log: Any, name: str, argument: str = "columns") -> FloatArray:
    """A column by name; `error` is position minus reference."""
    known = names_of(log)
    if name != "time" and name not in known:
        raise ValueError(f"{argument}: must be columns of the log, got {name!r}: {did_you_mean(name, known)}")
    if name == "error" and not (hasattr(log, "keys") and "error" in log):
        return column(log, "position") - column(log, "reference")
    values = log[name] if hasattr(log, "keys") else getattr(log, name)
    time = log["time"] if hasattr(log, "keys") else log.time
    return numbers(name, values, None if name == "time" else len(time))


def require_table(log: Any, argument: str = "log") -> None:
    """Refuse what has no columns over time."""
    if not is_table(log):
        raise TypeError(f"{argument}: must be a Log, or columns by name with `time`, got {described(log)}")


def several(logs: Any) -> dict[str, Any]:
    """Logs by name: of one log, of several in a row, or of a mapping from names to logs."""
    if is_table(logs):
        return {"": logs}
    if isinstance(logs, Mapping):
        found = {str(name): log for name, log in logs.items()}
    elif isinstance(logs, Sequence) and not isinstance(logs, str):
        found = {f"run {place}": log for place, log in enumerate(logs)}
    else:
        raise TypeError(f"log: must be a Log, several, or columns by name with `time`, got {described(logs)}")
    for log in found.values():
        require_table(log)
    if not found:
        raise ValueError("log: must be at least one, got none")
    return found
