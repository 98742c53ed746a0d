"""The numbers of a run by path, so that a sweep can vary them: model, controller, reference and seed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from cogging._core import Reference
from cogging.calls import did_you_mean
from cogging.files import FieldError
from cogging.model.model import CONTROLLERS, Model
from cogging.model.parameters import parameters_of, with_values
from cogging.model.units import Units
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
    """Refuse a path that the run has not, with the nearest that it has.

    Raises:
        FieldError: names it.
    """
    known = numbers_of(setup)
    for path in paths:
        if path not in known:
            section = [name for name in known if name.split(".")[0] == path.split(".")[0]]
            raise FieldError("vary", path, f"is no number of this run; {did_you_mean(path, section or known)}")


def with_numbers(setup: Setup, values: Mapping[str, float]) -> Setup:
    """The setup with the numbers at these paths changed, but for the seed.

    Raises:
        ValueError: a value that breaks its field's rule.
    """
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
    """The model's controller.

    Raises:
        ValueError: it has none.
    """
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
