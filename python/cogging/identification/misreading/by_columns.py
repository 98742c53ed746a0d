"""What the columns of a log say of each other: which follows which, and which no encoder can have read."""

from __future__ import annotations

import numpy as np

from cogging.arrays import FloatArray
from cogging.identification.misreading.readings import REFERENCES, Reading, whole
from cogging.log_check.encoder_quantum import encoder_quantum
from cogging.logs.log import Log
from cogging.model.model import Model

FOLLOWED = 0.2  # of what follows, that may be left of a column of another that it follows
UNLIKE = 0.6  # of it, that is left of a column which does not
SAME_SIZE = 1.5  # by which one column may be larger than the other that it is
OTHER_SIZE = 3.0  # by which it is larger where its unit is another
EQUAL = 0.999  # of the rows in which a position equals its reference: no axis does that
SMOOTH = 1e-4  # of the encoder's step, that differences of sixth order leave of readings that nothing read
FINE = 0.1  # m: a finer encoder does not read whole numbers
QUANTA = 0.01  # by which two steps of an encoder may differ


def following(column: FloatArray, leader: FloatArray) -> tuple[float, float]:
    """Slope by which a column follows another, and what is left, of its rms about the mean."""
    column, leader = column - np.mean(column), leader - np.mean(leader)
    power = float(np.mean(leader**2))
    size = float(np.sqrt(np.mean(column**2)))
    if power == 0.0 or size == 0.0:
        return 0.0, 1.0
    slope = float(np.mean(column * leader)) / power
    return slope, float(np.sqrt(np.mean((column - slope * leader) ** 2))) / size


def follows(log: Log) -> float:
    """Slope by which the position follows the reference; 0 where it does not or there is none."""
    if log.reference is None:
        return 0.0
    slope, left = following(log.position, log.reference)
    return slope if left < FOLLOWED else 0.0


def misread_columns(log: Log, model: Model) -> list[Reading]:
    """Readings that the columns alone show, beyond doubt; the likeliest first, none where nothing is wrong."""
    if log.reference is not None:
        reference, position = log.reference, log.position
        moves = np.ptp(reference) > 0.0
        if moves and float(np.mean(np.abs(position - reference) <= 1e-9 * np.ptp(reference))) > EQUAL:
            return [Reading("position", "reference", "is the reference, row by row, which no axis follows so")]
        if _is(log.command, reference) and not _like(position, reference):
            return [exchanged("position", "command")]
        velocity = log.reference_velocity
        velocity = np.gradient(reference, log.time) if velocity is None else velocity
        if _is(position, velocity) and not _like(position, reference):
            return [Reading("position", "derivative", "is the velocity: it follows that of the reference")]
        if too_smooth(position, encoder_quantum(reference)) and _is(position, reference):
            return [exchanged("position", "reference")]
    resolution, unit = model.encoder.resolution, model.units.position
    if 0.0 < resolution < FINE and whole(log.position):
        others = REFERENCES if follows(log) > 0.0 else ()
        factors = {"position": resolution, **dict.fromkeys(others, resolution)}
        return [Reading("position", "scale", f"is in counts of the encoder, of {resolution:g} {unit}", factors)]
    if resolution > 0.0:
        if abs(encoder_quantum(log.command) / resolution - 1.0) < QUANTA and encoder_quantum(log.position) == 0.0:
            return [exchanged("position", "command")]
        if too_smooth(log.position, resolution):
            said = f"is smoother than an encoder of {resolution:g} {unit} reads: a reference, or filtered"
            return [Reading("position", "reference", said)]
    return []


def exchanged(one: str, other: str) -> Reading:
    """Two columns that took each other's place."""
    return Reading(one, "swap", f"and {other} stand in each other's place", renamed={one: other, other: one})


def other_units(log: Log) -> list[Reading]:
    """Where a position follows its reference backwards or in another unit: which of them is to be changed."""
    slope = follows(log)
    if slope == 0.0 or 1.0 / OTHER_SIZE < slope < OTHER_SIZE:
        return []
    if slope < 0.0:
        kind, said, factor = "sign", "has the other sign than", -1.0
    else:
        kind, said, factor = "scale", "is in another unit than", float(f"{slope:.3g}")
    return [
        Reading("position", kind, f"{said} the reference", {"position": 1.0 / factor}),
        Reading("reference", kind, f"{said} the position", dict.fromkeys(REFERENCES, factor)),
    ]


def too_smooth(position: FloatArray, resolution: float) -> bool:
    """Whether readings are far smoother than an encoder of this resolution (m) makes them, and on no grid of it."""
    if resolution <= 0.0 or position.size < 50:
        return False
    moving = np.abs(np.diff(position, 6))[np.diff(position)[5:] != 0.0]
    if moving.size < 50 or float(np.median(moving)) > SMOOTH * resolution:
        return False
    return encoder_quantum(position) == 0.0


def _is(column: FloatArray, leader: FloatArray) -> bool:
    slope, left = following(column, leader)
    return left < FOLLOWED and 1.0 / SAME_SIZE < slope < SAME_SIZE


def _like(column: FloatArray, leader: FloatArray) -> bool:
    slope, left = following(column, leader)
    return slope > 0.0 and left < UNLIKE
