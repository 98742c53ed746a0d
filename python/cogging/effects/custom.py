"""Custom effects: laws that are functions of the user."""

from __future__ import annotations

import ctypes
import inspect
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from cogging._core import EFFECTS, AxisParameters, CoggingModel
from cogging._core.effects import CompiledLaw, OwnLaws, PythonLaw
from cogging.shown import nearest, not_one_of

Value = float | list[float]

COMPILED: Any = ctypes.CFUNCTYPE(None).__base__  # base of every ctypes function

#: Arguments of each law beside the parameters, in this order.
PLACES = ("position", "velocity", "time")
HOOKS = {
    "force": PLACES,
    "friction_level": PLACES,
    "command_gain": ("position", "time"),
    "reading_error": ("position",),
}
#: Functions of numbers and arrays by name, and their laws; `reading_at` adds the position.
LAWS = {"force_at": "force", "friction_level_at": "friction_level", "gain_at": "command_gain"}
NAME = re.compile("[a-z][a-z0-9_]*")  # of an effect or a parameter
CHANGES = ("mass_change", "viscous_change", "coulomb_change")  # names in results, reserved too
TRIAL = ([0.02, 0.05, 0.11], [-0.3, 0.0, 0.2], [0.0, 0.4, 1.7])  # m, m/s, s
SAME = 1e-9  # of the largest value: tolerance between numbers and arrays


#: Quantity and multiple that bound an amplitude without bounds, by its unit.
BY_UNIT = {
    "V": ("force", 1.0),
    "V/m": ("force_per_position", 1.0),
    "V/(m/s)": ("force_per_velocity", 1.0),
    "V/(m/s)^2": ("force_per_velocity_squared", 1.0),
    "1": ("relative", 1.0),
    "m": ("distance", 0.01),
}
QUANTITIES = (
    *("one", "relative", "exponent", "force", "command", "friction", "force_per_position", "force_per_velocity"),
    *("force_per_velocity_squared", "stiffness", "position", "distance", "angle", "velocity", "time", "sample_time"),
    *("frequency", "absolute"),
)


@dataclass(frozen=True)
class Parameter:
    """A parameter of a custom effect, and how to search for it.

    Attributes:
        value: a number, or a list of numbers.
        unit: SI and the command unit, as "V/(m/s)"; "1" for a pure number.
        meaning: in a few words.
        role: "amplitude": the law is linear in it and vanishes at 0; "shape": it is not linear; "setting": chosen, not
            searched for.
        low, high: range of the search, in the parameter's unit or in multiples of `quantity`. An amplitude may omit
            them: its unit implies a plausible size.
        quantity: unit of low and high (see cogging.effects); None: the parameter's unit.
        logarithmic: search in the logarithm.
        neutral: of a shape, the value at which the effect vanishes, if there is one.
    """

    value: float | Sequence[float]
    unit: str = "1"
    meaning: str = ""
    role: Literal["amplitude", "shape", "setting"] = "amplitude"
    low: float | None = None
    high: float | None = None
    quantity: str | None = None
    logarithmic: bool = False
    neutral: float | None = None

    def __post_init__(self) -> None:
        if self.role not in ("amplitude", "shape", "setting"):
            raise ValueError(f"role: must be amplitude, shape or setting, got {self.role!r}")
        if self.quantity is not None and self.quantity not in QUANTITIES:
            raise ValueError(f"quantity: {not_one_of(self.quantity, QUANTITIES)}")
        if (self.low is None) != (self.high is None):
            raise ValueError(f"low, high: both or neither must be given, got {self.low} and {self.high}")
        if self.low is not None and self.high is not None:
            if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
                raise ValueError(f"low, high: must be finite, low below high, got {self.low} and {self.high}")
            if self.logarithmic and self.low <= 0.0:
                raise ValueError(f"low: must be above 0 where steps are logarithmic, got {self.low}")
        listed = not isinstance(self.value, int | float)
        if self.role == "shape" and self.low is None and not listed:
            raise ValueError("low, high: must be given for a shape, got neither")
        if self.role == "amplitude":
            if self.low is None and self.quantity is None and self.unit not in BY_UNIT:
                raise ValueError(f"low, high: must be given for an amplitude in {self.unit!r}, got neither")
            if self.low is not None and not self.low <= 0.0 < float(self.high or 0.0):
                raise ValueError(f"low, high: must hold 0 for an amplitude, got {self.low} and {self.high}")
            if self.neutral not in (None, 0.0):
                raise ValueError(f"neutral: must be 0 for an amplitude, got {self.neutral}")


def role_of_parameter(parameter: Parameter, rubs: bool = False) -> dict[str, Any]:
    """Return the entry of ROLES; `rubs`: the effect is a friction level alone."""
    listed = isinstance(parameter.value, Sequence)
    role: dict[str, Any] = {"role": parameter.role, "quantity": parameter.quantity or "absolute"}
    if parameter.role == "setting":
        return role | {"quantity": "one", "low": None, "high": None, "logarithmic": False, "neutral": None}
    low, high, neutral = parameter.low, parameter.high, parameter.neutral
    if parameter.role == "amplitude":
        neutral = [0.0] * len(parameter.value) if isinstance(parameter.value, Sequence) else 0.0  # type: ignore[assignment]
        if low is None:
            quantity, most = BY_UNIT.get(parameter.unit, ("one", 1.0))
            if rubs and quantity == "force":
                quantity, most = "friction", 2.0
            role["quantity"] = parameter.quantity or quantity
            low, high = -most, most
    elif low is None and listed:  # places along the travel
        role["quantity"], low, high = parameter.quantity or "position", 0.0, 1.0
    return role | {"low": low, "high": high, "logarithmic": parameter.logarithmic, "neutral": neutral}


def valid_value(effect: str, name: str, parameter: Parameter, value: Any) -> float | list[float]:
    """Return a valid value of a parameter as a float or a list of floats."""
    listed = not isinstance(parameter.value, int | float)
    try:
        numbers = [float(one) for one in value] if listed else [float(value)]
    except (TypeError, ValueError):
        kind = "a list of numbers" if listed else "a number"
        raise ValueError(f"{effect}.{name}: must be {kind}, got {value!r}") from None
    for number in numbers:
        if not math.isfinite(number):
            raise ValueError(f"{effect}.{name}: must be a finite number, got {number:g}")
        if parameter.role == "shape" and not listed and parameter.low is not None and parameter.low > 0.0 >= number:
            raise ValueError(f"{effect}.{name}: must be above 0, got {number:g}")
    return numbers if listed else numbers[0]


@dataclass(frozen=True)
class Definition:
    """A custom effect without the values of its parameters."""

    name: str
    laws: Mapping[str, Any]
    parameters: Mapping[str, Parameter]
    law: str
    kinds: tuple[Any, ...]
    scales: Mapping[str, float]
    taken: Mapping[str, tuple[str, ...]] = field(compare=False)


class Custom(OwnLaws):
    """An effect of your own, from functions of position (m), velocity (m/s), time (s) and its parameters.

    It is used like a built-in effect: `Plant` and `Model` simulate it, `identify` fits its parameters, and
    `diagnose(..., also=[it])` tries it beside the built-in ones.

    A Python function names its arguments: `def force(velocity, drag, corner)` takes the velocity and two parameters. It
    is called with numbers in a run and with arrays along a log, must give the same for both, and holds Python's lock. A
    compiled function (numba's `cfunc`, or a ctypes function with `argtypes` and `restype`) takes doubles: all arguments
    of its law (below), then all parameters in their order. It runs without the lock on all threads. Functions are pure.

    The integrator shortens a step with a kink or a jump of the law. Features narrower than half the path, or time, of a
    sample may be missed: then state the shortest scale.

    Args:
        name: lower-case letters, digits and `_`; not a built-in effect.
        force: V, towards +x; of position, velocity, time.
        friction_level: V, added to the Coulomb level; of position, velocity, time.
        command_gain: added to the gain 1 of the command; of position, time.
        reading_error: m, added to the reading of the encoder; of position.
        parameters: by name; a number stands for `Parameter(number)`.
        law: the formula, for reports.
        kinds: groups of parameters (`Wave`, `Window`, `Knots`, `SplineKnots`, `Place`), for a search.
        length_scale: m, shortest scale of a law along the travel.
        velocity_scale: m/s, shortest scale in velocity.
        time_scale: s, shortest scale in time.

    Raises:
        ValueError: a reserved name, no law, an unknown argument, a parameter that no law uses, or a function that fails
            or returns no finite number in a trial call.
    """

    NAME: str
    LAW: str
    HOOKS: tuple[str, ...]
    FIELDS: dict[str, tuple[str, str]]
    ROLES: dict[str, dict[str, Any]]
    KINDS: tuple[Any, ...]
    _definition: Definition
    _values: dict[str, Value]

    def __init__(
        self,
        name: str,
        *,
        force: Callable[..., Any] | None = None,
        friction_level: Callable[..., Any] | None = None,
        command_gain: Callable[..., Any] | None = None,
        reading_error: Callable[..., Any] | None = None,
        parameters: Mapping[str, Parameter | float] | None = None,
        law: str = "",
        kinds: Iterable[Any] = (),
        length_scale: float | None = None,
        velocity_scale: float | None = None,
        time_scale: float | None = None,
    ) -> None:
        given = zip(HOOKS, (force, friction_level, command_gain, reading_error), strict=True)
        laws = {hook: function for hook, function in given if function is not None}
        if not isinstance(name, str) or not NAME.fullmatch(name):
            raise ValueError(f"name: must be lower-case letters, digits and _, beginning with a letter, got {name!r}")
        if name in EFFECTS or name in CHANGES:
            raise ValueError(f"name: must not be one of the vocabulary, got {name!r}")
        if not laws:
            raise ValueError(f"{name}: must have a law, one of {', '.join(HOOKS)}, got none")
        specified = {
            key: one if isinstance(one, Parameter) else Parameter(one) for key, one in (parameters or {}).items()
        }
        for key in specified:
            if not isinstance(key, str) or not NAME.fullmatch(key) or key in {*dir(type(self)), *LAWS, *PLACES, "name"}:
                rule = "must be lower-case letters, digits and _, and no place or method of an effect"
                raise ValueError(f"{name}.parameters: {rule}, got {key!r}")
        taken = {hook: arguments_of(f"{name}.{hook}", function, hook, specified) for hook, function in laws.items()}
        used = {argument for arguments in taken.values() for argument in arguments}
        for key in specified:
            if key not in used:
                raise ValueError(f"{name}.{key}: must be an argument of a law, one of {', '.join(sorted(used))}")
        scales = {"length_scale": length_scale, "velocity_scale": velocity_scale, "time_scale": time_scale}
        kinds = tuple(kinds)
        for key in (key for kind in kinds for word, key in kind.to_dict().items() if word != "coordinate"):
            if key not in specified:
                raise ValueError(f"{name}.kinds: must name parameters ({', '.join(specified)}), got {key!r}")
        definition = Definition(
            name,
            laws,
            specified,
            law or "; ".join(f"{hook}({', '.join(arguments)})" for hook, arguments in taken.items()),
            kinds,
            {key: math.inf if scale is None else float(scale) for key, scale in scales.items()},
            taken,
        )
        self._begin(definition, {key: valid_value(name, key, one, one.value) for key, one in specified.items()})
        self._try()

    def _begin(self, definition: Definition, values: dict[str, Value]) -> None:
        rubs = set(definition.laws) == {"friction_level"}
        for name, value in {
            "NAME": definition.name,
            "LAW": definition.law,
            "HOOKS": tuple("reading" if hook == "reading_error" else hook for hook in definition.laws),
            "FIELDS": {key: (one.unit, one.meaning) for key, one in definition.parameters.items()},
            "ROLES": {key: role_of_parameter(one, rubs) for key, one in definition.parameters.items()},
            "KINDS": definition.kinds,
            "_definition": definition,
            "_values": values,
        }.items():
            object.__setattr__(self, name, value)
        super().__init__(
            definition.name,
            {hook: _law(definition, hook, values) for hook in definition.laws},
            origin=partial(_made, definition, values),
            **definition.scales,
        )

    def _try(self) -> None:
        """Raise ValueError for laws that fail, or that differ between numbers and arrays."""
        course = [np.array(column) for column in TRIAL]
        for hook in self._definition.laws:
            try:
                along = np.array(self.values_along(hook, *course))
                alone = np.array([self.value_at(hook, *(float(c[k]) for c in course)) for k in range(len(along))])
            except RuntimeError as error:
                raise ValueError(str(error)) from error.__cause__
            worst = float(np.abs(along - alone).max())
            if worst > SAME * float(np.abs(alone).max()):
                raise ValueError(
                    f"{self.NAME}.{hook}: must give the same for arrays as for numbers, "
                    f"got {along.tolist()} and {alone.tolist()}"
                )

    def to_dict(self) -> dict[str, Any]:
        """Return all parameters by name."""
        return {key: list(value) if isinstance(value, list) else value for key, value in self._values.items()}

    def replace(self, **changes: Any) -> Custom:
        """Return a copy with the given parameters changed.

        Raises:
            ValueError: an unknown parameter, or a value that breaks its rule.
        """
        parameters = self._definition.parameters
        for key in changes:
            if key not in parameters:
                raise ValueError(f"{self.NAME}.{key}: must be one of {', '.join(parameters)}{nearest(key, parameters)}")
        new = {key: valid_value(self.NAME, key, parameters[key], value) for key, value in changes.items()}
        return _made(self._definition, {**self._values, **new})

    def neutral(self) -> Custom:
        """Return a copy without effect, if its parameters have neutral values."""
        values = {key: role["neutral"] for key, role in self.ROLES.items() if role["neutral"] is not None}
        return self.replace(**values)

    def resolved(self, axis: AxisParameters, cogging: CoggingModel | None = None) -> Custom:
        """Return itself: no parameter comes from the plant."""
        return self

    def same_definition(self, other: Any) -> bool:
        """Return whether another effect differs only in the values of its parameters."""
        return isinstance(other, Custom) and self._definition == other._definition

    @property
    def reading_at(self) -> Callable[..., Any]:
        """Reading of the encoder at positions, m, before noise and rounding."""
        error = self._answer("reading_error")
        return lambda position: np.asarray(position, dtype=float) + error(position=position)

    def _answer(self, hook: str) -> Callable[..., Any]:
        if hook not in self._definition.laws:
            raise AttributeError(f"{self.NAME} has no {hook}")
        return partial(_values_at, self, hook)

    def __getattr__(self, name: str) -> Any:
        """Return a parameter, or a law (see laws_of)."""
        if name in LAWS:
            return self._answer(LAWS[name])
        values = object.__getattribute__(self, "__dict__").get("_values", {})
        if name not in values:
            raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")
        value = values[name]
        return list(value) if isinstance(value, list) else value

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{name}: cannot be changed; replace({name}=...) makes a copy")

    def __eq__(self, other: object) -> bool:
        return self.same_definition(other) and self.to_dict() == other.to_dict()  # type: ignore[attr-defined]

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        fields = "".join(f", {key}={value!r}" for key, value in self._values.items())
        return f"Custom({self.NAME!r}{fields})"

    def __reduce__(self) -> tuple[Any, ...]:
        return _made, (self._definition, self._values)


def _made(definition: Definition, values: dict[str, Value]) -> Custom:
    effect = Custom.__new__(Custom)
    effect._begin(definition, values)
    return effect


def _values_at(
    effect: Custom,
    hook: str,
    *,
    position: npt.ArrayLike = 0.0,
    velocity: npt.ArrayLike = 0.0,
    time: npt.ArrayLike = 0.0,
) -> Any:
    course = np.broadcast_arrays(*(np.asarray(column, dtype=float) for column in (position, velocity, time)))
    if course[0].ndim == 0:
        return effect.value_at(hook, *(float(column) for column in course))
    return effect.values_along(hook, *(column.ravel() for column in course)).reshape(course[0].shape)


def _law(definition: Definition, hook: str, values: Mapping[str, Value]) -> PythonLaw | CompiledLaw:
    function, asked = definition.laws[hook], definition.taken[hook]
    taken = [PLACES.index(argument) for argument in asked if argument in PLACES]
    compiled = compiled_function(function)
    if compiled is None:
        mine = {key: np.array(value) if isinstance(value, list) else value for key, value in values.items()}
        return PythonLaw(f"{definition.name}.{hook}", function, taken, {a: mine[a] for a in asked if a in mine})
    address = ctypes.cast(compiled, ctypes.c_void_p).value or 0
    return CompiledLaw(address, taken, [float(values[a]) for a in asked if a in values], function)  # type: ignore[arg-type]


def compiled_function(function: Any) -> Any:
    """Return the ctypes function of a compiled one (numba's `cfunc`, or itself); None for a Python function."""
    inner = getattr(function, "ctypes", function)
    return inner if isinstance(inner, COMPILED) else None


def arguments_of(label: str, function: Any, hook: str, parameters: Mapping[str, Parameter]) -> tuple[str, ...]:
    """Return the names of a law's arguments, places first."""
    known = (*HOOKS[hook], *parameters)
    if (compiled := compiled_function(function)) is not None:
        _require_doubles(label, compiled, known, parameters)
        return known
    if not callable(function):
        raise ValueError(f"{label}: must be a function, got {function!r}")
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        raise ValueError(f"{label}: must be a function whose arguments have names, got {function!r}") from None
    named: set[str] = set()
    for name, argument in signature.parameters.items():
        if argument.kind is argument.VAR_KEYWORD:
            named |= set(known)
        elif argument.kind is argument.VAR_POSITIONAL or (name not in known and argument.default is not argument.empty):
            continue
        elif name not in known or argument.kind is argument.POSITIONAL_ONLY:
            raise ValueError(f"{label}: must take its arguments by name, of {', '.join(known)}, got {name!r}")
        else:
            named.add(name)
    return tuple(name for name in known if name in named)


def _require_doubles(label: str, function: Any, known: tuple[str, ...], parameters: Mapping[str, Parameter]) -> None:
    """Refuse a ctypes function that is a callback of Python, or does not accept all arguments as doubles."""
    if any(type(one).__name__ == "CThunkObject" for one in (getattr(function, "_objects", None) or {}).values()):
        raise ValueError(f"{label}: must be compiled code; give a Python function itself, not a ctypes callback of it")
    for key, one in parameters.items():
        if not isinstance(one.value, int | float):
            raise ValueError(f"{label}: a compiled law accepts numbers only, got the list {key!r}")
    types = tuple(function.argtypes or ())
    if function.restype is not ctypes.c_double or types != (ctypes.c_double,) * len(known):
        arguments = ", ".join(getattr(one, "__name__", str(one)) for one in types)
        given = f"({arguments}) -> {getattr(function.restype, '__name__', function.restype)}"
        raise ValueError(f"{label}: must take doubles ({', '.join(known)}) and return one, got {given}")


def by_name(effects: Sequence[Any]) -> dict[str, Any]:
    """Return custom effects by name."""
    found: dict[str, Custom] = {}
    for effect in effects:
        if not isinstance(effect, Custom):
            raise ValueError(f"effects: must be made by cogging.effects.Custom, got {type(effect).__name__}")
        if effect.NAME in found:
            raise ValueError(f"effects: must have different names, got {effect.NAME!r} twice")
        found[effect.NAME] = effect
    return found


def refuse_two_of_one_name(effects: Iterable[Any]) -> None:
    """Raise ValueError for effects of one name with different laws."""
    first: dict[str, Custom] = {}
    for effect in effects:
        if isinstance(effect, Custom) and not first.setdefault(effect.NAME, effect).same_definition(effect):
            raise ValueError(f"effects: must be one law a name, got two different ones called {effect.NAME!r}")
