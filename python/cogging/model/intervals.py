"""95 % intervals of a model's parameters, and their sources."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from cogging.arrays import SIGMAS_95 as SIGMAS_95
from cogging.model.model import Model
from cogging.model.parameters import parameters_of
from cogging.shown import nearest

Interval = tuple[float, float]

#: What identifies a parameter, by the beginning of its path.
MEASUREMENTS = {
    "axis.mass": "a log with larger accelerations",
    "axis.viscous": "a log at several speeds",
    "axis.coulomb_width": "a log with slow reversals",
    "axis.coulomb": "a log with reversals and slow travel",
    "cogging": "a log or a scan that passes slowly over the whole travel",
    "effects": "a log in which this effect acts",
}


class Intervals:
    """The 95 % intervals of a model's parameters, each from the first source that has one.

    The sources are `[bounds]` of the model (written by `identify`), `default`, and `[axis.uncertainty]` as +-1.96
    sigma; a parameter without a source counts as exact. An infinite interval in `[bounds]` means that the logs do not
    determine the parameter: it needs a `default`.

    `notes`: which intervals did not come from `[bounds]`, in words; extended by each call of `of`.
    """

    def __init__(
        self, model: Model, default: Mapping[str, Interval] | None = None, *, beside: tuple[str, ...] = ()
    ) -> None:
        """Check intervals and defaults, by parameter path or its beginning, of which the longest match counts.

        `beside`: keys of `default` that are not parameters.
        """
        self.model = model
        self._parameters = parameters_of(model)
        self._default = dict(default or {})
        for path in model.intervals:
            if path not in self._parameters:
                known = f"{', '.join(self.paths)}{nearest(path, self.paths)}"
                raise ValueError(f"bounds.{path}: must be a parameter of the model; known: {known}")
        for key, interval in self._default.items():
            if len(interval) != 2 or not np.all(np.isfinite(interval)) or interval[0] > interval[1]:
                raise ValueError(f"default[{key!r}]: must be (lower, upper), finite and in order, got {interval!r}")
            if key not in beside and not any(_begins(path, key) for path in self._parameters):
                raise ValueError(f"default[{key!r}]: must be a parameter of the model or the beginning of one")
        self._notes: dict[str, str] = {}

    @property
    def paths(self) -> tuple[str, ...]:
        """Paths of all parameters."""
        return tuple(self._parameters)

    @property
    def notes(self) -> tuple[str, ...]:
        """Which intervals were not in `[bounds]`, one line for each reason."""
        lines = []
        for reason in dict.fromkeys(self._notes.values()):
            paths = [path for path, other in self._notes.items() if other == reason]
            cogging = [path for path in paths if path.startswith("cogging.")]
            subjects = [path for path in paths if path not in cogging]
            subjects += cogging if len(cogging) < 3 else [f"{len(cogging)} amplitudes of the cogging"]
            lines.append(f"{', '.join(subjects)}: {reason}")
        return tuple(lines)

    def value(self, path: str) -> float:
        """Return the value in the model."""
        return self._parameters[path].value

    def of(self, path: str) -> Interval | None:
        """Return the finite 95 % interval of a parameter, or None if it counts as exact.

        Raises:
            ValueError: the interval is infinite without a default, or does not contain the model's value.
        """
        keys = [key for key in self._default if _begins(path, key)]
        fallback = self._default[max(keys, key=len)] if keys else None
        value = self.value(path)
        if path in self.model.intervals:
            low, high = self.model.intervals[path]
            if not np.isfinite([low, high]).all():
                if fallback is None:
                    better = next(words for key, words in MEASUREMENTS.items() if path.startswith(key))
                    raise ValueError(
                        f"{path}: the logs do not determine it, its interval is [{low:g}, {high:g}]; measure it with "
                        f"{better}, or give [bounds] (default={{{path!r}: (low, high)}})"
                    )
                self._notes[path] = "not determined by the logs, the given default counts"
                low, high = fallback
        elif fallback is not None:
            self._notes[path] = "no interval in [bounds], the given default counts"
            low, high = fallback
        elif self._parameters[path].uncertainty is not None:
            sigma = float(self._parameters[path].uncertainty or 0.0)
            self._notes[path] = f"no interval in [bounds], 1.96 of its {100 * sigma:g} % in [axis.uncertainty] counts"
            low, high = value - SIGMAS_95 * sigma * value, value + SIGMAS_95 * sigma * value
        else:
            self._notes[path] = "no interval in [bounds], taken as exact"
            return None
        slack = 1e-9 * max(abs(low), abs(high))  # a file may hold fewer digits
        if not low - slack <= value <= high + slack:
            raise ValueError(f"{path}: its interval [{low:g}, {high:g}] must hold the model's value, got {value:g}")
        return min(low, value), max(high, value)


def valid_end(value: float, end: float, valid: Callable[[float], bool]) -> float:
    """Return the end of an interval, or the nearest value to it that a field's rule allows."""
    if valid(end):
        return end
    inside, outside = value, end
    for _ in range(50):
        middle = 0.5 * (inside + outside)
        inside, outside = (middle, outside) if valid(middle) else (inside, middle)
    return inside


def _begins(path: str, key: str) -> bool:
    return path == key or path.startswith((f"{key}.", f"{key}["))
