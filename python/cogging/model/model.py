"""The model of an axis, and model files."""

from __future__ import annotations

import importlib
import math
import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from cogging import _core, files
from cogging._core import AxisParameters, CoggingModel, EncoderParameters, NoiseParameters, Plant, SplineHarmonics
from cogging.calls import check_constructor
from cogging.effects.custom import Custom, by_name, refuse_two_of_one_name
from cogging.effects.effect import Effect
from cogging.files import LARGEST, FieldError, errors_of_section, refuse_mistyped, refuse_unknown_keys
from cogging.model.controller import ControllerParameters, ListedController
from cogging.model.units import Units
from cogging.outputs import to_toml, write_files, write_text
from cogging.plot.canvas import plot_method
from cogging.plot.results import whole_model
from cogging.shown import nearest, not_one_of, quoted
from cogging.tables import html_table
from cogging.values import ByValue, fields_of_basis, line_of

if TYPE_CHECKING:
    from cogging.export.control import ControlLoop

#: Parameter struct and class of each controller by its name in model files.
CONTROLLERS: dict[str, tuple[Any, Any]] = {
    name: (controller.PARAMETERS, controller) for name, controller in _core.CONTROLLERS.items()
}
PARAMETERS = tuple({struct for struct, _ in CONTROLLERS.values()})

SECTIONS = ("axis", "cogging", "effects", "encoder", "noise", "controller", "simulation", "units", "bounds")
COGGING_KEYS = ("pitch", "harmonics", "periods", "order", "origin", "sine", "cosine")
LARGEST_FLOAT = int(sys.float_info.max)
COUNTED = 1 << 31  # integers of the core are smaller
STEPS_MAX = 10_000  # largest steps_per_sample
AXIS_FIELDS = ("mass", "viscous", "coulomb", "coulomb_width")  # that are fitted, and may have an uncertainty


@check_constructor
@dataclass(frozen=True, eq=False, repr=False)
class Model(ByValue):
    """An axis as a model file describes it: M x'' = u - B x' - Fc S(x') - F_cogging(x) + effects.

    Attributes:
        axis: mass and friction, in the command unit and SI.
        cogging: F_cogging(x), which opposes the command, or None.
        effects: forces, friction and amplifier effects beyond the axis.
        encoder: resolution and noise of the position reading.
        noise: force noise, for simulation.
        controller: parameters of the controller, or None if it is unknown.
        controller_type: its name in model files, a key of CONTROLLERS; needed where several have these parameters.
        uncertainty: relative 1-sigma of mass, viscous, coulomb (0 = exact).
        intervals: 95 % intervals by parameter path, `[bounds]` of a file; [-inf, inf] for a parameter that the logs do
            not determine.
        steps_per_sample: least number of integration steps between two samples; accuracy may need more.
        units: labels of the units of command and position, used in all output.

    Example:
        >>> axis = cogging.AxisParameters(mass=0.12, viscous=0.2, travel=[0.0, 0.5])
        >>> cogging.Model(axis, effects=[cogging.effects.CableSpring(stiffness=0.4)])
        Model(mass 0.12 V/(m/s^2), cable_spring)
        >>> cogging.Model.from_dict(model.to_dict()) == model
        True
    """

    axis: AxisParameters
    cogging: CoggingModel | None = None
    effects: Sequence[Effect] = ()
    encoder: EncoderParameters = field(default_factory=EncoderParameters)
    noise: NoiseParameters = field(default_factory=NoiseParameters)
    controller: ControllerParameters | None = None
    controller_type: str | None = None
    uncertainty: Mapping[str, float] = field(default_factory=dict)
    intervals: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    steps_per_sample: int = 1
    units: Units = field(default_factory=Units)

    def __post_init__(self) -> None:
        kind = self.controller_type
        if self.controller is None and kind is not None:
            raise ValueError(f"controller: must be given with controller_type {kind!r}, got None")
        if kind is not None and kind not in CONTROLLERS:
            raise ValueError(f"controller_type: {not_one_of(kind, CONTROLLERS)}")
        if not isinstance(self.units, Units):
            raise TypeError(f"units: must be Units(command=..., position=...), got {type(self.units).__name__}")
        if self.controller is not None:
            given = type(self.controller).__name__
            types = [name for name, (struct, _) in CONTROLLERS.items() if isinstance(self.controller, struct)]
            if not types:
                own = "simulate(model, reference, controller=...) accepts a controller of your own"
                own = "give its .parameters" if hasattr(self.controller, "parameters") else own
                rule = f"must be the parameters of one of {', '.join(CONTROLLERS)}, got {given}: {own}"
                raise TypeError(f"controller: {rule}")
            kind = types[0] if kind is None and len(types) == 1 else kind
            if kind not in types:
                raise ValueError(f"controller_type: must be {' or '.join(types)} with {given}, got {kind!r}")
            object.__setattr__(self, "controller_type", kind)
        object.__setattr__(self, "effects", tuple(self.effects))
        refuse_two_of_one_name(self.effects)
        intervals = {path: (float(low), float(high)) for path, (low, high) in self.intervals.items()}
        object.__setattr__(self, "intervals", intervals)

    def _brief(self) -> str:
        parts = [f"mass {self.axis.mass:.6g} {self.units.of('V/(m/s^2)')}"]
        if self.cogging is not None:
            parts.append(f"cogging of {self.cogging.basis.terms} terms")
        parts += [effect.NAME for effect in self.effects]
        if self.controller is not None:
            parts.append(f"{self.controller_type} at {self.controller.sample_rate:g} Hz")
        return ", ".join(parts)

    def _repr_html_(self) -> str:
        parts: list[tuple[str, Any]] = [("axis", self.axis)]
        parts += [(f"effects.{effect.NAME}", effect) for effect in self.effects]
        parts += [("encoder", self.encoder), ("noise", self.noise)]
        if self.controller is not None:
            parts.append((f"controller ({self.controller_type})", self.controller))
        rows = []
        for name, part in parts:
            for key, (unit, _) in part.FIELDS.items():
                low, high = self.intervals.get(f"{name}.{key}", (math.nan, math.nan))
                interval = "" if math.isnan(low) else f"{low:.6g} to {high:.6g}"
                label = self.units.of(str(unit)).removeprefix("1")
                rows.append([f"{name}.{key}", getattr(part, key), label, interval])
        cogging = "no cogging" if self.cogging is None else line_of(self.cogging, self.units.of)
        return html_table(f"Model: {self._brief()}", ["field", "value", "unit", "95 %"], rows, [cogging])

    plot = plot_method(
        whole_model, "Plot the cogging over position with its 95 % band, and the friction over velocity.", "axes"
    )

    def plant(self) -> Plant:
        """Return the plant to simulate."""
        names = ("cogging", "effects", "encoder", "noise")
        return Plant(self.axis, **{name: getattr(self, name) for name in names})

    def make_controller(self) -> ListedController:
        """Return a new controller.

        Raises:
            ValueError: the model has no `[controller]`.
        """
        if self.controller is None or self.controller_type is None:
            rule = "must be given to simulate (--controller pid, controller=...)"
            raise ValueError(f"controller: {rule}, got a model without [controller]")
        controller: ListedController = CONTROLLERS[self.controller_type][1](self.controller)
        return controller

    def export(self, form: str, path: str | os.PathLike[str], **options: Any) -> str:
        """Export the model or its map for another machine, as `cogging export` does.

        Args:
            form: "csv", "akd", "moteus" or another key of cogging.export.FORMS.
            path: of the file; further files have its name and one more suffix.
            **options: of that form.

        Returns:
            What the other machine uses of the model, and what it cannot represent.

        Raises:
            ValueError: there is no such form, or the model cannot be expressed in it.
        """
        # Imported by name: cogging.export imports this module.
        made = importlib.import_module("cogging.export.forms").to(self, form, **options)
        write_files(made.files(path))
        return str(made.text)

    def to_control(
        self,
        *,
        speed: float | None = None,
        position: float | None = None,
        sample_rate: float | None = None,
        pade: int = 3,
    ) -> ControlLoop:
        """Return the linearised axis and its loop as python-control objects (extra `control`).

        The plant is M x'' = u - friction - cogging + effects about a position and a speed, with its delay, current
        loops and flexible mode, for a command that is held over a sample: exact at the samples. The controller is the
        part of `pid`, `cascade`, `speed`, `arc` or `dcarc` that is linear in the error.

        Args:
            speed: m/s, at which friction is linearised; None: viscous friction alone, as for fast motion.
            position: m, at which cogging and position-dependent effects are linearised; None: springs alone.
            sample_rate: Hz, for a model without a controller; None: the controller's.
            pade: order of the delay's approximation in continuous time; 0 omits the delay there.

        Returns:
            Plant, controller, loop, sensitivities, and the parts that were left out.

        Raises:
            ImportError: python-control is not installed; names the extra.
            ValueError: the controller is not linear in the error, friction has no slope there, or a number is out of
                its range.
        """
        linearise = importlib.import_module("cogging.export.control").to_control
        made: ControlLoop = linearise(self, speed=speed, position=position, sample_rate=sample_rate, pade=pade)
        return made

    def replace(self, **changes: Any) -> Model:
        """Return a copy with the given attributes changed; parameters of another controller change its type too."""
        kind = CONTROLLERS.get(self.controller_type or "", (None,))[0]
        if "controller" in changes and kind is not None and not isinstance(changes["controller"], kind):
            changes = {"controller_type": None, **changes}
        return replace(self, **changes)

    @classmethod
    def read(cls, path: str | os.PathLike[str], *, effects: Sequence[Custom] = ()) -> Model:
        """Read a model file (TOML).

        Args:
            path: of the file.
            effects: custom effects that the file names; it holds their parameters, not their laws.

        Raises:
            InputError: the file is invalid; names file, line, field, rule and value.
        """
        with files.errors_of(path):
            return cls.from_dict(files.read_toml(path), effects=effects)

    def write(self, path: str | os.PathLike[str], *, like: str | os.PathLike[str] | None = None) -> None:
        """Write a model file (TOML), without loss.

        The file holds name and parameters of a custom effect: `Model.read(path, effects=[it])` reads it again.

        Args:
            path: of the file.
            like: a model file whose comments and order of lines are kept; a changed value says what it was.
        """
        write_text(path, self.to_toml("" if like is None else files.read_text(like)))

    def to_toml(self, like: str = "") -> str:
        """Return the text of a model file; `like`: that of another one, whose comments and order of lines are kept."""
        document = self.to_dict()
        if "units" in (stated := files.parse_toml(like)):
            document["units"] = self.units.to_dict()
        if "simulation" in stated:
            document["simulation"] = {"steps_per_sample": self.steps_per_sample}
        return to_toml(document, like=like)

    @classmethod
    def from_dict(cls, document: Mapping[str, Any], *, effects: Sequence[Custom] = ()) -> Model:
        """Return the model of the sections of a model file.

        Args:
            document: the sections by name.
            effects: custom effects that the document names.

        Raises:
            FieldError: a ValueError that names section, field, rule and value.
        """
        refuse_unknown_keys(document, SECTIONS, "")
        if "axis" not in document:
            raise FieldError("", "axis", "must be given, got no such section")
        axis_section = dict(_table(document, "axis"))
        uncertainty = axis_section.pop("uncertainty", {})
        if not isinstance(uncertainty, Mapping):
            raise FieldError("axis", "uncertainty", f"must be a section, got {quoted(uncertainty)}")
        refuse_unknown_keys(uncertainty, AXIS_FIELDS, "axis.uncertainty")
        for key, value in uncertainty.items():
            if not is_number(value) or not 0.0 <= value <= LARGEST:
                rule = f"must be a number from 0 to {LARGEST:g}, got {quoted(value)}"
                raise FieldError("axis.uncertainty", key, rule)
        refuse_unknown_keys(axis_section, AxisParameters.FIELDS, "axis")
        if "mass" not in axis_section:
            raise FieldError("axis", "mass", "must be given, got nothing")
        axis = parameters_from(AxisParameters, axis_section, "axis")
        controller_type, controller = _controller_from(document, axis)
        simulation = _table(document, "simulation")
        refuse_unknown_keys(simulation, ("steps_per_sample",), "simulation")
        steps = simulation.get("steps_per_sample", 1)
        if not isinstance(steps, int) or isinstance(steps, bool) or not 1 <= steps <= STEPS_MAX:
            rule = f"must be a whole number from 1 to {STEPS_MAX}"
            raise FieldError("simulation", "steps_per_sample", f"{rule}, got {quoted(steps)}")
        intervals = {}
        for path, ends in _table(document, "bounds").items():
            good = isinstance(ends, list) and len(ends) == 2 and all(map(is_number, ends))
            if not good or not ends[0] <= ends[1]:
                raise FieldError("bounds", path, f"must be [lower, upper] with lower <= upper, got {quoted(ends)}")
            intervals[path] = (float(ends[0]), float(ends[1]))
        return cls(
            axis=axis,
            cogging=_cogging_from(_table(document, "cogging")) if "cogging" in document else None,
            effects=_effects_from(document.get("effects", []), by_name(effects)),
            encoder=parameters_from(EncoderParameters, _table(document, "encoder"), "encoder"),
            noise=parameters_from(NoiseParameters, _table(document, "noise"), "noise"),
            controller=controller,
            controller_type=controller_type,
            uncertainty={key: float(value) for key, value in uncertainty.items()},
            intervals=intervals,
            steps_per_sample=steps,
            units=Units.from_dict(_table(document, "units")),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the sections of a model file, which from_dict reads."""
        document: dict[str, Any] = {"axis": self.axis.to_dict()}
        if self.uncertainty:
            document["axis"]["uncertainty"] = dict(self.uncertainty)
        if self.cogging is not None:
            document["cogging"] = cogging_to_dict(self.cogging)
        if self.effects:
            document["effects"] = [{"name": effect.NAME, **effect.to_dict()} for effect in self.effects]
        document["encoder"] = self.encoder.to_dict()
        document["noise"] = self.noise.to_dict()
        if self.controller is not None:
            document["controller"] = {"type": self.controller_type, **self.controller.to_dict()}
        if self.steps_per_sample != 1:
            document["simulation"] = {"steps_per_sample": self.steps_per_sample}
        if self.units != Units():
            document["units"] = self.units.to_dict()
        if self.intervals:
            document["bounds"] = {path: list(interval) for path, interval in self.intervals.items()}
        return document


def parameters_from(struct: Any, section: Mapping[str, Any], name: str, occurrence: int = 0) -> Any:
    """Return a C++ parameter struct from a section, with the defaults and rules of the struct."""
    with errors_of_section(name, occurrence):
        refuse_unknown_keys(section, struct.FIELDS, name)
        defaults = struct().to_dict()
        for key, value in section.items():
            _require_type(value, defaults[key], name, key)
        return struct(**section)


def cogging_to_dict(cogging: CoggingModel) -> dict[str, Any]:
    """Return the section `[cogging]` of a cogging model."""
    return {**fields_of_basis(cogging.basis), "sine": cogging.sine.tolist(), "cosine": cogging.cosine.tolist()}


def _table(document: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    section = document.get(name, {})
    if not isinstance(section, Mapping):
        raise FieldError("", name, f"must be a section, got {quoted(section)}")
    return section


def is_number(value: Any) -> bool:
    """Return whether a value of a file is a number that fits into a double."""
    if isinstance(value, int) and not isinstance(value, bool):
        return -LARGEST_FLOAT <= value <= LARGEST_FLOAT
    return isinstance(value, float)


def _require_type(value: Any, default: Any, section: str, key: str) -> None:
    kind, holds = "a number", is_number(value)
    if isinstance(default, bool):
        kind, holds = "true or false", isinstance(value, bool)
    elif isinstance(default, str):
        kind, holds = "a text", isinstance(value, str)
    elif isinstance(default, list):
        free = not default or key in ("periods", "observer_gain")  # of any length
        kind = "a list of numbers" if free else f"{len(default)} numbers"
        holds = isinstance(value, list) and all(map(is_number, value)) and (free or len(value) == len(default))
        if key.endswith("harmonics"):
            kind, holds = "a list of whole numbers", holds and all(isinstance(v, int) for v in value)
    elif isinstance(default, int):
        kind, holds = "a whole number", holds and isinstance(value, int)
    if not holds:
        raise FieldError(section, key, f"must be {kind}, got {quoted(value)}")
    counted = key.endswith("harmonics") or isinstance(default, int)
    largest = COUNTED - 1 if counted else LARGEST
    for number in value if isinstance(value, list) else [value]:
        if isinstance(number, int | float) and largest < abs(number) < math.inf:
            raise FieldError(section, key, f"must be at most {largest:.10g} in size, got {quoted(number)}")


def _cogging_from(section: Mapping[str, Any]) -> CoggingModel:
    refuse_unknown_keys(section, COGGING_KEYS, "cogging")
    rows = {}
    for key, value in ((key, section[key]) for key in ("sine", "cosine") if key in section):
        good = isinstance(value, list) and all(isinstance(row, list) and all(map(is_number, row)) for row in value)
        if not good or len({len(row) for row in value}) != 1 or not value[0]:
            raise FieldError("cogging", key, "must be rows of numbers of equal length, one row a harmonic")
        rows[key] = np.array(value, dtype=float)
        if not np.all(np.abs(rows[key]) <= LARGEST):
            raise FieldError("cogging", key, f"must be numbers of at most {LARGEST:g} in size")
    if len(rows) == 1:
        raise FieldError("cogging", next(iter(rows)), "needs both sine and cosine, or neither, got one")
    points = rows["sine"].shape[1] if rows else 1
    arguments = {key: value for key, value in section.items() if key not in rows}
    kinds: dict[str, Any] = {"pitch": 0.0, "origin": 0.0, "order": 3, "harmonics": [], "periods": []}
    for key, value in arguments.items():
        _require_type(value, kinds[key], "cogging", key)
    try:
        basis = SplineHarmonics(control_points=points, **arguments)
        zeros = np.zeros((basis.terms, 1))
        return CoggingModel(basis, rows.get("sine", zeros), rows.get("cosine", zeros))
    except ValueError as error:
        key, _, problem = str(error).partition(": ")
        raise FieldError("cogging", "sine" if key == "control_points" else key, problem) from None


def _effects_from(effects: Any, own: Mapping[str, Custom]) -> tuple[Effect, ...]:
    if not isinstance(effects, list) or not all(isinstance(entry, Mapping) for entry in effects):
        raise FieldError("", "effects", "must be written as [[effects]] tables")
    made = []
    for occurrence, entry in enumerate(effects):
        fields = dict(entry)
        refuse_mistyped(fields, "name", "effects", occurrence)
        name = fields.pop("name", None)
        if isinstance(name, str) and name in own:
            effect = own[name]
            with errors_of_section("effects", occurrence):
                refuse_unknown_keys(fields, effect.FIELDS, "effects")
                for key, value in fields.items():
                    _require_type(value, [] if isinstance(getattr(effect, key), list) else 0.0, "effects", key)
                made.append(effect.replace(**fields))
            continue
        if not isinstance(name, str) or name not in _core.EFFECTS:
            known = ", ".join((*_core.EFFECTS, *own))
            rule = f"must be one of {known} (Model.read(path, effects=[it]) reads one of your own)"
            near = nearest(str(name), (*_core.EFFECTS, *own))
            raise FieldError("effects", "name", f"{rule}, got {quoted(name)}{near}", occurrence)
        made.append(parameters_from(_core.EFFECTS[name], fields, "effects", occurrence))
    return tuple(made)


def _controller_from(
    document: Mapping[str, Any], axis: AxisParameters
) -> tuple[str | None, ControllerParameters | None]:
    if "controller" not in document:
        return None, None
    section = dict(_table(document, "controller"))
    refuse_mistyped(section, "type", "controller")
    kind = section.pop("type", None)
    if not isinstance(kind, str) or kind not in CONTROLLERS:
        raise FieldError("controller", "type", not_one_of(kind, CONTROLLERS))
    struct = CONTROLLERS[kind][0]
    if "coulomb_width" in struct.FIELDS:
        # The controller's width defaults to that of the axis when the file is read, and is independent from then on.
        section.setdefault("coulomb_width", axis.coulomb_width)
    return kind, parameters_from(struct, section, "controller")
