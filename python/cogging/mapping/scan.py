"""A scan: the force that holds an axis against its position, which way it went, and its points on a grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cogging.arrays import FloatArray, real_array
from cogging.files import LARGEST
from cogging.logs.log import SMALLEST
from cogging.model.units import Units

FEWEST_POINTS = 10
TURN = 0.01  # of the travel: a smaller step back is encoder noise, no reversal
POINTS_PER_PERIOD = 2.5  # fewer points do not resolve a harmonic
OPEN_END = 1.5  # spacings by which a whole pitch may be short: n - 1 of the n intervals of a turn are enough
WAY_BACK = 0.9  # of a pitch: shortest way back that separates friction from the offset
CELLS_PER_PERIOD = 20  # of the highest harmonic: averaging over a cell reduces its amplitude by at most 0.4 %


@dataclass(frozen=True)
class Scan:
    """The points of a scan, at most one a cell and pass, in the order of the passes."""

    position: FloatArray  # m, (n,)
    force: FloatArray  # V, (n,): F_cogging + friction, whatever the sensor's sign was
    direction: FloatArray  # (n,), +1 where the position rose, -1 where it fell
    spacing: float  # m, of neighbouring points, whatever their pass
    both_ways: bool  # whether friction is separable from the offset
    resolvable: int  # the highest harmonic that the points resolve
    highest: int  # the highest harmonic searched
    notes: tuple[str, ...]  # remarks on the rows
    units: Units  # labels of force and position

    @property
    def travel(self) -> float:
        """m."""
        return float(np.ptp(self.position))

    def spans(self, length: float) -> bool:
        """Whether the points cover a length (m): those of a closed turn end one spacing before they begin."""
        return self.travel >= length - OPEN_END * self.spacing


def read_scan(
    position: npt.ArrayLike, force: npt.ArrayLike, units: Units, *, pitch: float, force_sign: int, highest_harmonic: int
) -> Scan:
    """Check a scan, find its directions and average rows that are close together; ValueError: an invalid one.

    A travel of one pitch less a spacing is a whole pitch. Directions come from the reversals, from which the position
    goes back by more than 1 % of the travel; rows within that distance after one are left out, since friction has not
    yet changed its sign. Rows of one pass within a cell of pitch / (20 highest harmonics) are averaged.
    """
    x, y = finite_column("position", position), finite_column("force", force)
    require(y.size == x.size, "force", f"must have one value for each of the {x.size} positions", y.size)
    require(x.size >= FEWEST_POINTS, "position", f"must hold at least {FEWEST_POINTS} points of a scan", x.size)
    is_sign = not isinstance(force_sign, bool) and force_sign in (1, -1)
    require(is_sign, "force_sign", "must be 1 or -1", repr(force_sign))
    travel, m = float(np.ptp(x)), units.position
    # The distance of neighbours below which half of the travel lies: jitter and rests do not shorten it.
    gaps = np.sort(np.diff(np.unique(x)))
    spacing = float(gaps[np.searchsorted(np.cumsum(gaps), 0.5 * gaps.sum())]) if travel > 0.0 else 0.0
    is_whole = travel >= pitch - OPEN_END * min(spacing, pitch / FEWEST_POINTS)
    require(is_whole, "position", f"must travel at least one pitch ({pitch:g} {m})", f"{travel:g} {m}")
    resolvable = int(pitch / (POINTS_PER_PERIOD * spacing) - 0.5)
    rule = f"must have a point every {pitch / 3.75:.3g} {m} or less"
    require(resolvable >= 1, "position", rule, f"one every {spacing:.3g} {m}")
    highest = min(highest_harmonic, resolvable)
    y = force_sign * y
    passes, direction, turns = _passes(x)
    turned = (np.abs(x - turns) < TURN * travel) & (passes > 0)
    # From where it turned: a way back over one pitch is a whole one, though its first rows are left out.
    ways = [direction == way for way in (1.0, -1.0)]
    both_ways = all(way.any() and np.ptp(np.append(x[way], turns[way])) >= WAY_BACK * pitch for way in ways)
    kept = ~turned if both_ways else max(ways, key=np.count_nonzero)
    one_way = "the scan goes one way only: friction and offset cannot be told apart, `offset` holds both"
    notes = [] if both_ways else [one_way]
    if not kept.all():
        which = "just after a reversal" if both_ways else "of a short way back"
        notes.append(f"{int(np.sum(~kept))} rows {which} left out")
    cell = pitch / (CELLS_PER_PERIOD * highest)
    keys = np.stack([passes[kept], np.floor((x[kept] - x.min()) / cell).astype(np.int64)])
    _, members, counts = np.unique(keys, axis=1, return_inverse=True, return_counts=True)
    members = members.ravel()
    if counts.size < kept.sum():
        notes.append(f"{int(kept.sum())} rows averaged to {counts.size} points, one a {cell:.3g} {m} and pass")
    position, force, way = (np.bincount(members, v[kept]) / counts for v in (x, y, direction))
    rule = f"must hold at least {FEWEST_POINTS} points that differ"
    require(position.size >= FEWEST_POINTS, "position", rule, position.size)
    return Scan(position, force, np.sign(way), spacing, both_ways, resolvable, highest, tuple(notes), units)


def require(holds: bool, name: str, rule: str, value: object) -> None:
    """Raise ValueError that names field, rule and value unless a condition holds."""
    if not holds:
        raise ValueError(f"{name}: {rule}, got {value}")


def is_number(value: object) -> bool:
    """Return whether a value is a finite real number, and not a truth value."""
    return isinstance(value, int | float | np.number) and not isinstance(value, bool) and bool(np.isfinite(value))


def finite_column(name: str, values: npt.ArrayLike) -> FloatArray:
    """Return finite numbers (n,) of usual size; ValueError names the rule."""
    array = real_array(name, values)
    require(array.ndim == 1 and array.size > 0, name, "must be one-dimensional and not empty", f"shape {array.shape}")
    bad = np.flatnonzero(~np.isfinite(array))
    if bad.size:
        raise ValueError(f"{name}: must be finite numbers, got {array[bad[0]]:g} in row {bad[0]}")
    size = float(np.abs(array).max())
    is_usual = size == 0.0 or SMALLEST <= size <= LARGEST
    require(is_usual, name, f"must be 0 or between {SMALLEST:g} and {LARGEST:g} in size", f"{size:g}")
    return array


def _passes(position: FloatArray) -> tuple[npt.NDArray[np.int64], FloatArray, FloatArray]:
    """For each row the number of its pass, the pass's direction and where the motion turned into it."""
    limit = TURN * float(np.ptp(position))
    x = position.tolist()
    starts, directions, way, low, high = [0], [0.0], 0.0, 0, 0
    for i, here in enumerate(x):
        low, high = (i if here < x[low] else low), (i if here > x[high] else high)
        if way <= 0.0 and here - x[low] > limit:
            starts, directions, way, high = [*starts, low + 1], [*directions, 1.0], 1.0, i
        elif way >= 0.0 and x[high] - here > limit:
            starts, directions, way, low = [*starts, high + 1], [*directions, -1.0], -1.0, i
    starts, directions = [0, *starts[2:]], directions[1:]  # what lies before the first motion belongs to it
    passes = np.repeat(np.arange(len(starts)), np.diff([*starts, len(x)]))
    return passes, np.array(directions)[passes], position[np.maximum(np.array(starts) - 1, 0)][passes]
