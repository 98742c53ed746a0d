"""Numbers of a run by path, and how they vary: grids, sequences and distributions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from cogging._core import Reference
from cogging.arrays import FloatArray
from cogging.calls import did_you_mean
from cogging.files import LARGEST, FieldError, refuse_unknown_keys
from cogging.model.intervals import SIGMAS_95, Intervals
from cogging.model.model import CONTROLLERS, Model, is_number
from cogging.model.parameters import SECTIONS, Parameter, parameters_of, with_fields, with_values
from cogging.model.units import Units
from cogging.resources import require_table
from cogging.shown import not_one_of, quoted
from cogging.simulation.reductions import unit_of
from cogging.simulation.reference import REFERENCES

SEED = "seed"
METHODS = ("grid", "random", "latin_hypercube", "sobol")
BOUNDS = "bounds"  # in place of a variation, or of all of them: the model's intervals
VARIATION_KEYS = ("values", "from", "to", "points", "scale", "mean", "deviation")
RUNS_MAX = 10**8
SEED_EXACT = 2**53  # largest whole number of which a float array holds all smaller ones
THREADS_MOST = 1024
SEED_MOST = 2**62  # that of run i is then below 2^63, which an integer column can hold
TABLE_COLUMNS = 12  # of a sweep's table beside the varied numbers
TINY = 1e-12  # distance from 0 and 1, where a normal quantile is infinite


class Setup(NamedTuple):
    """A run without its noise."""

    model: Model
    reference: Reference


def numbers_of(setup: Setup) -> dict[str, Parameter | None]:
    """Return every number that can vary by path (see `sweep`); `seed` has no value (None)."""
    model = setup.model
    found: dict[str, Parameter | None] = {**parameters_of(model, together=True)}
    structs = {name: getattr(model, name) for name in SECTIONS}
    structs["reference"] = getattr(setup.reference, "parameters", None)
    for name, struct in structs.items():
        for field, value in ({} if struct is None else struct.to_dict()).items():
            entries = enumerate(value) if isinstance(value, list | tuple) else [(-1, value)]
            for place, entry in entries:
                if isinstance(entry, int | float) and not isinstance(entry, bool):
                    path = f"{name}.{field}" + f"[{place}]" * (place >= 0)
                    found[path] = Parameter(path, float(entry), struct.FIELDS[field][0] or "", units=model.units)
    return {**found, SEED: None}


def units_of(setup: Setup, paths: Iterable[str], indexes: Iterable[str] = ()) -> dict[str, str]:
    """Return the units of numbers by path, except of the seed; those of indexes if the model has its own labels."""
    labels, known = setup.model.units, numbers_of(setup)
    units = {path: number.unit for path in paths if (number := known[path]) is not None}
    if labels != Units():
        units |= {name: labels.of(unit) for name in indexes if (unit := unit_of(name))}
    return units


def refuse_unknown_paths(setup: Setup, paths: Iterable[str]) -> None:
    """Raise FieldError for a path that the run does not have, with the nearest one."""
    known = numbers_of(setup)
    for path in paths:
        if path not in known:
            section = [name for name in known if name.split(".")[0] == path.split(".")[0]]
            raise FieldError("vary", path, f"is not a number of this run; {did_you_mean(path, section or known)}")


def with_numbers(setup: Setup, values: Mapping[str, float]) -> Setup:
    """Return the setup with the numbers at these paths changed, except the seed."""
    reference: Any = setup.reference
    own = {path: value for path, value in values.items() if path != SEED}
    moved = {path.removeprefix("reference."): own.pop(path) for path in [*own] if path.startswith("reference.")}
    if moved:
        motion = next(motion for _, motion in REFERENCES.values() if isinstance(reference, motion))
        reference = motion(with_fields("reference", reference.parameters, moved))
    return Setup(with_values(setup.model, own), reference)


def make_controller(model: Model) -> Any:
    """Return the model's controller; raise ValueError if it has none."""
    if model.controller is None or model.controller_type not in CONTROLLERS:
        raise ValueError("controller: must be given to run the model, got none")
    return model.make_controller()


class Variation(NamedTuple):
    """How one number varies."""

    path: str
    of_shares: Callable[[FloatArray], FloatArray]  # quantiles of its distribution at shares from 0 to 1
    grid: Callable[[], FloatArray] | None = None  # returns the values of a grid; None if it has none


def variation_of(path: str, stated: Any, model: Model) -> Variation:
    """Return how a number varies from a list of values, a table of VARIATION_KEYS, or "bounds"."""
    if stated == BOUNDS:
        return _within_bounds(path, model)
    table: Mapping[str, Any] = {"values": stated} if isinstance(stated, list | tuple) else stated
    if not isinstance(table, Mapping):
        raise FieldError("vary", path, f'must be a list, a table or "bounds", got {quoted(stated)}')
    refuse_unknown_keys(table, VARIATION_KEYS, f"vary.{path}")
    for key, value in table.items():
        numbers = value if key == "values" else [] if key == "scale" else [value]
        if not isinstance(numbers, list | tuple) or not all(is_number(n) and abs(n) <= LARGEST for n in numbers):
            what = "numbers" if key == "values" else "a number"
            raise FieldError("vary", path, f"{key}: must be {what} of at most {LARGEST:g} in size, got {quoted(value)}")
    if path == SEED:
        _require_seeds(table)
    kinds = [kind for kind in (("values",), ("from", "to"), ("mean", "deviation")) if set(kind) <= set(table)]
    if len(kinds) != 1 or set(table) - set(kinds[0]) - ({"points", "scale"} if "from" in table else set()):
        rule = "must be values, or from and to, or mean and deviation"
        raise FieldError("vary", path, f"{rule}, got {quoted(dict(table))}")
    if "values" in table:
        values = np.array(table["values"], dtype=float)
        if not values.size:
            raise FieldError("vary", path, "values: must hold at least one number, got none")
        last = len(values) - 1
        return Variation(path, lambda s: values[np.minimum(s * len(values), last).astype(int)], lambda: values)
    if "mean" in table:
        if table["deviation"] < 0:
            raise FieldError("vary", path, f"deviation: must be at least 0, got {table['deviation']!r}")
        return _normal(path, table["mean"], table["deviation"], table["deviation"])
    low, high, is_log = range_of("vary", path, table)
    points = table.get("points")
    if points is not None and (not isinstance(points, int) or not 2 <= points <= RUNS_MAX):
        raise FieldError("vary", path, f"points: must be a whole number from 2 to {RUNS_MAX}, got {points!r}")
    space: Any = np.geomspace if is_log else np.linspace
    grid = (lambda: np.asarray(space(low, high, points))) if points else None
    if is_log:
        return Variation(path, lambda shares: np.asarray(low * (high / low) ** shares), grid)
    return Variation(path, lambda shares: np.asarray(low + (high - low) * shares), grid)


def range_of(section: str, path: str, table: Mapping[str, Any], scale: str = "linear") -> tuple[float, float, bool]:
    """Return the ends of a range and whether it is logarithmic, from a table with numbers; scale: if it has none."""
    low, high, scale = float(table["from"]), float(table["to"]), table.get("scale", scale)
    if scale not in ("linear", "log"):
        raise FieldError(section, path, f"scale: must be linear or log, got {quoted(scale)}")
    if not low < high:
        raise FieldError(section, path, f"from: must be below to = {high:g}, got {low:g}")
    if scale == "log" and low <= 0.0:
        raise FieldError(section, path, f"from: must be above 0 on a logarithmic scale, got {low:g}")
    return low, high, scale == "log"


def _within_bounds(path: str, model: Model) -> Variation:
    """Return a normal distribution around the model's value with 95 % in its interval."""
    intervals = Intervals(model)
    stated = model.intervals.get(path)
    if stated is not None and not all(map(math.isfinite, stated)):
        raise FieldError("vary", path, f"must have a finite interval in the model's [bounds], got {list(stated)}")
    interval = intervals.of(path) if path in intervals.paths else None
    if interval is None:
        raise FieldError("vary", path, "must have a finite interval in the model's [bounds], got none")
    value = intervals.value(path)
    return _normal(path, value, (value - interval[0]) / SIGMAS_95, (interval[1] - value) / SIGMAS_95)


def _normal(path: str, median: float, below: float, above: float) -> Variation:
    """Return a normal distribution with other deviations below and above its median."""
    from scipy.special import ndtri

    def quantiles(shares: FloatArray) -> FloatArray:
        normal = ndtri(np.clip(shares, TINY, 1.0 - TINY))
        return np.asarray(median + normal * np.where(normal > 0, above, below))

    return Variation(path, quantiles)


def _require_seeds(table: Mapping[str, Any]) -> None:
    """Refuse seeds that are not listed whole numbers: drawn ones would be truncated, and some would repeat."""
    if set(table) != {"values"}:
        raise FieldError("vary", SEED, f"must be a list of whole numbers, got {quoted(dict(table))}")
    for value in table["values"]:
        if not 0 <= value <= SEED_EXACT or value != int(value):
            raise FieldError("vary", SEED, f"must be whole numbers from 0 to {SEED_EXACT}, got {value!r}")


def require_numbers(
    counts: Mapping[str, Any], seed: Any, duration: Any, window: tuple[Any, ...] = (0.0, 1.0, 1.0), threads: Any = 0
) -> None:
    """Raise FieldError for a number that no runs can have; counts: from 1; window: start, stop, final window, s."""
    whole = [(name, value, 1, RUNS_MAX) for name, value in counts.items()]
    for name, value, least, most in (*whole, ("seed", seed, 0, SEED_MOST), ("threads", threads, 0, THREADS_MOST)):
        if isinstance(value, bool) or not isinstance(value, int | np.integer):
            raise FieldError("", name, f"must be a whole number, got {quoted(value)}")
        if not least <= value <= most:
            raise FieldError("", name, f"must be from {least} to {most}, got {value}")
    start, stop, final_window = window
    for name, value in (("duration", duration), ("start", start), ("stop", stop), ("final_window", final_window)):
        if not (is_number(value) or isinstance(value, np.number)) or math.isnan(value):
            raise FieldError("", name, f"must be a number, got {quoted(value)}")
    if not 0.0 <= duration < math.inf:
        raise FieldError("", "duration", f"must be finite and at least 0, got {duration!r}")
    if not start < stop:
        raise FieldError("", "start", f"must be below stop = {stop!r}, got {start!r}")
    if not final_window > 0.0:
        raise FieldError("", "final_window", f"must be above 0, got {final_window!r}")


def points_of(variations: list[Variation], method: str, runs: int, seed: int) -> FloatArray:
    """Return the values of each run, (runs, variations); the same arguments give the same points."""
    count = len(variations)
    if method not in METHODS:
        raise FieldError("", "method", not_one_of(method, METHODS))
    axes = []
    for variation in variations if method == "grid" else ():
        if variation.grid is None:
            rule = f"must have values, or from, to and points, on a grid; the methods {', '.join(METHODS[1:])} draw it"
            raise FieldError("vary", variation.path, rule)
        axes.append(variation.grid())
    runs = math.prod(map(len, axes)) if axes else runs
    if not 1 <= runs <= RUNS_MAX:
        raise FieldError("", "runs", f"must be from 1 to {RUNS_MAX}, got {runs}")
    require_table("runs", runs, 3 * count + TABLE_COLUMNS)  # places and values of a grid, and the table of results
    if method == "grid":
        places = np.unravel_index(np.arange(runs), [len(axis) for axis in axes])
        return np.stack([axis[place] for axis, place in zip(axes, places, strict=True)], axis=1)
    random = np.random.default_rng(seed)
    if method == "random":
        shares = random.random((runs, count))
    else:
        from scipy.stats import qmc

        if method == "latin_hypercube":
            shares = np.asarray(qmc.LatinHypercube(count, seed=random).random(runs))
        else:  # the first of the fewest points that are balanced
            shares = np.asarray(qmc.Sobol(count, seed=random).random_base2(math.ceil(math.log2(runs)))[:runs])
    return np.stack([variation.of_shares(shares[:, i]) for i, variation in enumerate(variations)], axis=1)
