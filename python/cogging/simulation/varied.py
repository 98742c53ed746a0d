"""The numbers of a run by path, and how a sweep varies them: grids, sequences and distributions."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from cogging._core import Reference
from cogging.arrays import FloatArray
from cogging.calls import did_you_mean
from cogging.files import LARGEST, FieldError, refuse_unknown_keys
from cogging.model.intervals import SIGMAS_95, Intervals
from cogging.model.model import CONTROLLERS, Model, is_number
from cogging.model.parameters import parameters_of, with_values
from cogging.model.units import Units
from cogging.resources import require_table
from cogging.shown import nearest, quoted
from cogging.simulation.reductions import unit_of
from cogging.simulation.reference import REFERENCES

SEED = "seed"
#: Sections of the model, beside those of parameters_of, whose numbers have a path.
SECTIONS = ("encoder", "noise", "controller")


class Setup(NamedTuple):
    """What a run is made of, but for its noise."""

    model: Model
    reference: Reference


def numbers_of(setup: Setup) -> dict[str, float | None]:
    """Every number that can be varied, by path: those of parameters_of, and `encoder.noise`, `controller.kp`,
    `controller.cogging_harmonics[0]`, `reference.velocity`, `seed` (None: it has no value of its own)."""
    numbers: dict[str, float | None] = {
        path: parameter.value for path, parameter in parameters_of(setup.model, together=True).items()
    }
    parts = [(name, getattr(setup.model, name)) for name in SECTIONS]
    parts.append(("reference", getattr(setup.reference, "parameters", None)))
    for name, struct in parts:
        for field, value in ({} if struct is None else struct.to_dict()).items():
            entries = enumerate(value) if isinstance(value, list | tuple) else [(-1, value)]
            for place, entry in entries:
                if isinstance(entry, int | float) and not isinstance(entry, bool):
                    numbers[f"{name}.{field}" + f"[{place}]" * (place >= 0)] = float(entry)
    numbers[SEED] = None
    return numbers


def units_of(setup: Setup, paths: Iterable[str], indexes: Iterable[str] = ()) -> dict[str, str]:
    """The units of numbers by path, none of the seed; of indexes too where the model has labels of its own."""
    labels, parameters = setup.model.units, parameters_of(setup.model, together=True)
    structs = {name: getattr(setup.model, name) for name in SECTIONS}
    structs["reference"] = getattr(setup.reference, "parameters", None)
    units = {}
    for path in paths:
        section, _, rest = path.partition(".")
        if section in structs:
            units[path] = labels.of(structs[section].FIELDS[rest.partition("[")[0]][0] or "")
        elif path != SEED:
            units[path] = parameters[path].unit
    if labels != Units():
        units |= {name: labels.of(unit) for name in indexes if (unit := unit_of(name))}
    return units


def refuse_unknown_paths(setup: Setup, paths: Iterable[str]) -> None:
    """Refuse a path that the run has not, with the nearest that it has."""
    known = numbers_of(setup)
    for path in paths:
        if path not in known:
            section = [name for name in known if name.split(".")[0] == path.split(".")[0]]
            raise FieldError("vary", path, f"is no number of this run; {did_you_mean(path, section or known)}")


def with_numbers(setup: Setup, values: Mapping[str, float]) -> Setup:
    """The setup with the numbers at these paths changed, but for the seed."""
    model, reference = setup
    inside = {path: value for path, value in values.items() if path.split(".")[0] not in (*SECTIONS, "reference", SEED)}
    if inside:
        model = with_values(model, inside)
    for name in SECTIONS:
        changes = _changes(getattr(model, name), name, values)
        if changes:
            model = model.replace(**{name: getattr(model, name).replace(**changes)})
    changes = _changes(getattr(reference, "parameters", None), "reference", values)
    if changes:
        made = next(motion for _, motion in REFERENCES.values() if isinstance(reference, motion))
        reference = made(reference.parameters.replace(**changes))  # type: ignore[attr-defined]
    return Setup(model, reference)


def make_controller(model: Model) -> Any:
    """The model's controller."""
    if model.controller is None or model.controller_type not in CONTROLLERS:
        raise ValueError("controller: must be given to run the model, got none")
    return model.make_controller()


def _changes(struct: Any, name: str, values: Mapping[str, float]) -> dict[str, Any]:
    """The fields of a struct that the values at paths `name.field` or `name.field[i]` change."""
    changes: dict[str, Any] = {}
    before = {} if struct is None else struct.to_dict()
    for path, value in values.items():
        section, _, rest = path.partition(".")
        if section != name:
            continue
        field, _, place = rest.partition("[")
        old = before[field]
        if not place:
            changes[field] = _like(old, value, path)
            continue
        entries = changes.setdefault(field, list(old))
        entries[int(place.rstrip("]"))] = _like(entries[int(place.rstrip("]"))], value, path)
    return changes


def _like(old: Any, value: float, path: str) -> float | int:
    if not isinstance(old, int):
        return float(value)
    if value != int(value):
        raise ValueError(f"{path}: must be a whole number, got {value:g}")
    return int(value)


METHODS = ("grid", "random", "latin_hypercube", "sobol")
BOUNDS = "bounds"  # in place of a variation, or of all of them: the model's own
KEYS = ("values", "from", "to", "points", "scale", "mean", "deviation")
RUNS_MAX = 10**8
SEED_EXACT = 2**53  # up to which a list of numbers holds every whole one
THREADS_MOST = 1024
SEED_MOST = 2**62  # that of run i is no more than 2^63 - 1, which a column of whole numbers can hold
TABLE = 12  # columns of a sweep's table beside the varied numbers
TINY = 1e-12  # from the ends of (0, 1), where a normal number is infinite


@dataclass(frozen=True)
class Variation:
    """How one number is varied.

    Attributes:
        path: of the number.
        values: to choose from, or none.
        ends: from and to, or none.
        points: of a grid between the ends.
        logarithmic: whether the points, or the density, are even in the logarithm.
        middle, sides: of a normal number: its median and its deviation below and above, or none.
    """

    path: str
    values: tuple[float, ...] = ()
    ends: tuple[float, float] | None = None
    points: int = 0
    logarithmic: bool = False
    middle: float = 0.0
    sides: tuple[float, float] | None = None

    def grid(self) -> FloatArray:
        """Its values on a grid."""
        if self.values:
            return np.array(self.values)
        if self.ends is None or not self.points:
            drawn = ", ".join(METHODS[1:])
            raise FieldError(
                "vary", self.path, f"must have values, or from, to and points, on a grid; the methods {drawn} draw it"
            )
        space = np.geomspace if self.logarithmic else np.linspace
        return np.asarray(space(*self.ends, self.points), dtype=float)

    def of_shares(self, shares: FloatArray) -> FloatArray:
        """Its values by the share (0 to 1) of the distribution that lies below each."""
        from scipy.special import ndtri

        if self.values:
            places = np.minimum((shares * len(self.values)).astype(int), len(self.values) - 1)
            chosen: FloatArray = np.asarray(self.values, dtype=float)[places]
            return chosen
        if self.sides is not None:
            normal = ndtri(np.clip(shares, TINY, 1.0 - TINY))
            return np.asarray(self.middle + normal * np.where(normal > 0, self.sides[1], self.sides[0]))
        low, high = self.ends or (0.0, 1.0)
        if self.logarithmic:
            return np.asarray(low * (high / low) ** shares)
        return np.asarray(low + (high - low) * shares)


def variation_of(path: str, told: Any, model: Model) -> Variation:
    """How a number is varied, as a sweep file says it: a list of values, a table of KEYS, or "bounds"."""
    if told == BOUNDS:
        return _bounds(path, model)
    table: Mapping[str, Any] = {"values": told} if isinstance(told, list | tuple) else told
    if not isinstance(table, Mapping):
        raise FieldError("vary", path, f'must be a list, a table or "bounds", got {quoted(told)}')
    refuse_unknown_keys(table, KEYS, f"vary.{path}")
    _require_finite(path, table)
    if path == SEED:
        _require_seeds(table)
    kinds = [kind for kind in (("values",), ("from", "to"), ("mean", "deviation")) if set(kind) <= set(table)]
    if len(kinds) != 1 or set(table) - set(kinds[0]) - ({"points", "scale"} if "from" in table else set()):
        raise FieldError(
            "vary", path, f"must be values, or from and to, or mean and deviation, got {quoted(dict(table))}"
        )
    if "values" in table:
        if not table["values"]:
            raise FieldError("vary", path, "values: must hold at least one number, got none")
        return Variation(path, tuple(map(float, table["values"])))
    if "mean" in table:
        if table["deviation"] < 0:
            raise FieldError("vary", path, f"deviation: must be at least 0, got {table['deviation']!r}")
        return Variation(path, middle=float(table["mean"]), sides=(float(table["deviation"]),) * 2)
    return _between(path, table)


def require_numbers(seed: Any, runs: Any, duration: Any, window: tuple[Any, Any, Any], threads: Any = 0) -> None:
    """Refuse numbers that no run of a sweep could have, before any is made.

    Args:
        seed: of draws and noise.
        runs: how many.
        duration: s; 0 = the motion's own end.
        window: start, stop and final window, s.
        threads: 0 = all.
    """
    start, stop, final_window = window
    for name, value, least, most in (
        ("seed", seed, 0, SEED_MOST),
        ("runs", runs, 1, RUNS_MAX),
        ("threads", threads, 0, THREADS_MOST),
    ):
        if isinstance(value, bool) or not isinstance(value, int | np.integer):
            raise FieldError("", name, f"must be a whole number, got {quoted(value)}")
        if not least <= value <= most:
            raise FieldError("", name, f"must be from {least} to {most}, got {value}")
    for name, value in (("duration", duration), ("start", start), ("stop", stop), ("final_window", final_window)):
        if not is_number(value) or math.isnan(value):
            raise FieldError("", name, f"must be a number, got {quoted(value)}")
    if not 0.0 <= duration < math.inf:
        raise FieldError("", "duration", f"must be finite and at least 0, got {duration!r}")
    if not start < stop:
        raise FieldError("", "start", f"must be below stop = {stop!r}, got {start!r}")
    if not final_window > 0.0:
        raise FieldError("", "final_window", f"must be above 0, got {final_window!r}")


def points_of(variations: list[Variation], method: str, runs: int, seed: int) -> FloatArray:
    """The values of each run, (runs, variations). The same arguments give the same points."""
    if method == "grid":
        axes = [variation.grid() for variation in variations]
        total = math.prod(len(axis) for axis in axes)
        _require_runs(total, len(variations))
        places = np.unravel_index(np.arange(total), [len(axis) for axis in axes])
        return np.stack([axis[place] for axis, place in zip(axes, places, strict=True)], axis=1)
    if method not in METHODS:
        near = nearest(str(method), METHODS)
        raise FieldError("", "method", f"must be one of {', '.join(METHODS)}, got {quoted(method)}{near}")
    _require_runs(runs, len(variations))
    shares = _shares(method, runs, len(variations), seed)
    return np.stack([variation.of_shares(shares[:, i]) for i, variation in enumerate(variations)], axis=1)


def _shares(method: str, runs: int, dimensions: int, seed: int) -> FloatArray:
    """Points in the unit cube, (runs, dimensions)."""
    if method == "random":
        return np.asarray(np.random.default_rng(seed).random((runs, dimensions)))
    from scipy.stats import qmc

    if method == "latin_hypercube":
        return np.asarray(qmc.LatinHypercube(dimensions, seed=np.random.default_rng(seed)).random(runs))
    sobol = qmc.Sobol(dimensions, seed=np.random.default_rng(seed))
    return np.asarray(sobol.random_base2(math.ceil(math.log2(runs)))[:runs])  # of all that keep it balanced, the first


def _require_runs(runs: int, varied: int) -> None:
    if not 1 <= runs <= RUNS_MAX:
        raise FieldError("", "runs", f"must be from 1 to {RUNS_MAX}, got {runs}")
    require_table("runs", runs, 3 * varied + TABLE)  # places and values of a grid, and the table that comes of them


def _between(path: str, table: Mapping[str, Any]) -> Variation:
    low, high, points, scale = (table.get(key) for key in ("from", "to", "points", "scale"))
    if scale not in (None, "linear", "log"):
        raise FieldError("vary", path, f"scale: must be linear or log, got {quoted(scale)}")
    if low is None or high is None or not low < high:
        raise FieldError("vary", path, f"from: must be below to = {high!r}, got {low!r}")
    if scale == "log" and low <= 0:
        raise FieldError("vary", path, f"from: must be above 0 on a logarithmic scale, got {low!r}")
    if points is not None and (not isinstance(points, int) or not 2 <= points <= RUNS_MAX):
        raise FieldError("vary", path, f"points: must be a whole number from 2 to {RUNS_MAX}, got {points!r}")
    return Variation(path, ends=(float(low), float(high)), points=points or 0, logarithmic=scale == "log")


def _require_finite(path: str, table: Mapping[str, Any]) -> None:
    for key, value in table.items():
        numbers = value if key == "values" else [] if key == "scale" else [value]
        if not isinstance(numbers, list | tuple) or not all(is_number(n) and abs(n) <= LARGEST for n in numbers):
            what = "numbers" if key == "values" else "a number"
            raise FieldError("vary", path, f"{key}: must be {what} of at most {LARGEST:g} in size, got {quoted(value)}")


def _require_seeds(table: Mapping[str, Any]) -> None:
    """A seed is no number that can be drawn between others: floats would be cut to whole ones, and some come twice."""
    if set(table) != {"values"}:
        raise FieldError("vary", SEED, f"must be a list of whole numbers, got {quoted(dict(table))}")
    for value in table["values"]:
        if not 0 <= value <= SEED_EXACT or value != int(value):
            raise FieldError("vary", SEED, f"must be whole numbers from 0 to {SEED_EXACT}, got {value!r}")


def _bounds(path: str, model: Model) -> Variation:
    """Normal around the model's value, 95 % in its interval."""
    intervals = Intervals(model)
    told = model.intervals.get(path)
    if told is not None and not all(map(math.isfinite, told)):
        raise FieldError("vary", path, f"must have a finite interval in the model's [bounds], got {list(told)}")
    interval = intervals.of(path) if path in intervals.paths else None
    if interval is None:
        raise FieldError("vary", path, "must have a finite interval in the model's [bounds], got none")
    value = intervals.value(path)
    return Variation(path, middle=value, sides=((value - interval[0]) / SIGMAS_95, (interval[1] - value) / SIGMAS_95))
