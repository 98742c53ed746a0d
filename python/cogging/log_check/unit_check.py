"""Whether the units of a log can be those of a model."""

from __future__ import annotations

import math

import numpy as np

from cogging.calls import takes
from cogging.files import InputError
from cogging.log_check.outliers import find_outliers
from cogging.logs.log import Log, require_sizes
from cogging.model.model import Model
from cogging.model.units import Units
from cogging.simulation.arguments import LOG, MODEL_ALONE

ANGLES = {math.pi / 180.0: "degrees", 2.0 * math.pi: "turns"}
TIME_UNITS = {1e-3: "ms", 1e-6: "us"}


@takes(log=LOG, model=MODEL_ALONE)
def check_against_model(log: Log, model: Model, name: str = "log") -> None:
    """Refuse a log whose units cannot be those of the model: asked about, not guessed.

    The readings must fit into the model's travel, span about what the reference spans, and their rows must not be a
    thousand times further apart or closer than the controller's samples.

    Args:
        log: the log.
        model: its travel and sample rate are looked at.
        name: of the log's file, for the error.

    Raises:
        InputError: names the column, the figures and the scale to state.

    Example:
        >>> in_mm = cogging.Log(log.time, 1e3 * log.position, log.command)
        >>> cogging.check_against_model(in_mm, model)
        Traceback (most recent call last):
            ...
        cogging.files.InputError: log: position: spans ... but the model's travel is 0.51 m: give ...
    """
    try:
        require_sizes(log)
    except ValueError as error:
        raise InputError(f"{name}: {error}") from None
    inside = np.delete(log.position, find_outliers(log.position))
    low, high = (float(inside.min()), float(inside.max())) if inside.size else (0.0, 0.0)
    _check_against_travel(low, high, model, name)
    if log.reference is not None:
        _check_against_reference(high - low, float(np.ptp(log.reference)), model.units, name)
    if model.controller is not None:
        _check_against_sample_rate(float(np.median(np.diff(log.time))), model.controller.sample_rate, name)


def position_units(units: Units) -> dict[float, str]:
    """In what a position may be written other than the unit of a model, by the factor to that, the likelier first."""
    small = {1e-3: units.of("mm"), 1e-6: units.of("um")}
    return ANGLES | small if units.position == "rad" else small | {1e-2: "cm", 0.0254: "inches"}


def _check_against_travel(low: float, high: float, model: Model, name: str) -> None:
    span, (start, end), unit, others = high - low, model.axis.travel, model.units.position, position_units(model.units)
    length = end - start
    if not math.isfinite(length):
        return
    if span > 1.5 * length:
        factor = next((f for f in others if span * f <= 1.02 * length), None)
        raise InputError(
            f"{name}: position: spans {span:.4g} {unit} but the model's travel is {length:.4g} {unit}: give "
            + _advice("position", factor, others)
        )
    if low > end + length or high < start - length:
        raise InputError(
            f"{name}: position: lies in [{low:.4g}, {high:.4g}] {unit}, far outside the model's travel "
            f"[{start:.4g}, {end:.4g}] {unit}"
        )


def _check_against_sample_rate(step: float, sample_rate: float, name: str) -> None:
    for factor in TIME_UNITS:
        if abs(step * factor * sample_rate - 1.0) < 0.02:
            raise InputError(
                f"{name}: time: has rows {step:.4g} s apart but the model's controller samples at "
                f"{sample_rate:g} Hz: give " + _advice("time", factor, TIME_UNITS)
            )


def _check_against_reference(span: float, reference: float, units: Units, name: str) -> None:
    if span == 0.0 or reference == 0.0:
        return
    unit, others = units.position, position_units(units)
    for factor in others:
        for column, other, ratio in (
            ("position", "reference", span / reference),
            ("reference", "position", reference / span),
        ):
            if 0.7 < ratio * factor < 1.4 and ratio > 30.0:
                wide, narrow = max(span, reference), min(span, reference)
                raise InputError(
                    f"{name}: {column}: spans {wide:.4g} {unit} but the {other} {narrow:.4g} {unit}: give "
                    + _advice(column, factor, others)
                )


def _advice(column: str, factor: float | None, units: dict[float, str]) -> str:
    if factor is None:
        return f"--scale {column}=FACTOR"
    return f"--scale {column}={factor:g} if it is in {units[factor]}"
