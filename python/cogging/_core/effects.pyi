"""
Every effect that a plant may have, one class each.
"""
from __future__ import annotations
import cogging._core
import collections.abc
import numpy
import numpy.typing
import typing
__all__: list[str] = ['ActuatorLag', 'Backlash', 'CableSpring', 'CoggingHarmonic', 'CoggingModulation', 'CommandDeadZone', 'CommandDelay', 'CommandSaturation', 'CompiledLaw', 'ConstantForce', 'CoulombAsymmetry', 'DisturbanceStep', 'DisturbanceTone', 'EmpiricalForce', 'EncoderPeriodicError', 'EncoderScaleError', 'EndEffect', 'FlexibleMode', 'ForceConstantDrift', 'ForceConstantRipple', 'Gravity', 'Knots', 'LocalForce', 'OwnLaw', 'OwnLaws', 'Place', 'PositionDependentFriction', 'PreslidingFriction', 'PythonLaw', 'QuadraticDrag', 'SplineKnots', 'StribeckFriction', 'Travel', 'Turn', 'ViscousAsymmetry', 'Wave', 'Window']
class Wave:
    """
    A sine and a cosine of one period; the names of their fields.
    
    Fields:
        shape: its period (m), or its frequency (Hz)
        sine: amplitude of the sine
        cosine: amplitude of the cosine
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.Wave()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'shape': ('', 'its period (m), or its frequency (Hz)'), 'sine': ('', 'amplitude of the sine'), 'cosine': ('', 'amplitude of the cosine')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, shape: str = '', sine: str = '', cosine: str = '') -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> Wave:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def cosine(self) -> str:
        """
        amplitude of the cosine
        """
    @property
    def shape(self) -> str:
        """
        its period (m), or its frequency (Hz)
        """
    @property
    def sine(self) -> str:
        """
        amplitude of the sine
        """
class Window:
    """
    A stretch of time; the names of its fields.
    
    Fields:
        start: time at which it begins (s)
        stop: time at which it ends (s)
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.Window()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'start': ('', 'time at which it begins (s)'), 'stop': ('', 'time at which it ends (s)')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, start: str = '', stop: str = '') -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> Window:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def start(self) -> str:
        """
        time at which it begins (s)
        """
    @property
    def stop(self) -> str:
        """
        time at which it ends (s)
        """
class Knots:
    """
    Values at nodes, linear between two; the names of their fields.
    
    Fields:
        coordinate: of the nodes: position, velocity or time
        nodes: list of places, increasing
        levels: list of values, one a node
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.Knots()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'coordinate': ('', 'of the nodes: position, velocity or time'), 'nodes': ('', 'list of places, increasing'), 'levels': ('', 'list of values, one a node')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, coordinate: str = 'position', nodes: str = '', levels: str = '') -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> Knots:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def coordinate(self) -> str:
        """
        of the nodes: position, velocity or time
        """
    @property
    def levels(self) -> str:
        """
        list of values, one a node
        """
    @property
    def nodes(self) -> str:
        """
        list of places, increasing
        """
class SplineKnots:
    """
    Even knots of B-splines whose control points are the lists of amplitudes; the names of their fields.
    
    Fields:
        pitch: distance of the knots (m)
        order: of the B-splines
        origin: first knot of the first full span (m)
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.SplineKnots()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'pitch': ('', 'distance of the knots (m)'), 'order': ('', 'of the B-splines'), 'origin': ('', 'first knot of the first full span (m)')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, pitch: str = '', order: str = '', origin: str = '') -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> SplineKnots:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def order(self) -> str:
        """
        of the B-splines
        """
    @property
    def origin(self) -> str:
        """
        first knot of the first full span (m)
        """
    @property
    def pitch(self) -> str:
        """
        distance of the knots (m)
        """
class Travel:
    """
    The ends of the travel, of the plant where not given; the field's name.
    
    Fields:
        ends: lower and upper end (m)
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.Travel()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'ends': ('', 'lower and upper end (m)')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, ends: str = '') -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> Travel:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def ends(self) -> str:
        """
        lower and upper end (m)
        """
class Place:
    """
    A stretch of the travel about a place; the names of its fields.
    
    Fields:
        center: its middle (m)
        width: how far it reaches to each side (m)
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.Place()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'center': ('', 'its middle (m)'), 'width': ('', 'how far it reaches to each side (m)')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, center: str = '', width: str = '') -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> Place:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def center(self) -> str:
        """
        its middle (m)
        """
    @property
    def width(self) -> str:
        """
        how far it reaches to each side (m)
        """
class Turn:
    """
    A wave of exactly one turn of a rotary axis; the field's name.
    
    Fields:
        angle: where it is zero and rises (rad)
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.Turn()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'angle': ('', 'where it is zero and rises (rad)')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, angle: str = '') -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> Turn:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def angle(self) -> str:
        """
        where it is zero and rises (rad)
        """
class OwnLaw:
    """
    One law of an effect of the user's own.
    """
    def __reduce__(self) -> typing.Any:
        ...
class PythonLaw(OwnLaw):
    """
    A law that is a Python function.
    
    Args:
        label: for messages.
        function: called with what it takes by name: numbers in a run, arrays along a log.
        taken: which of position (0), velocity (1) and time (2).
        values: of its parameters, by name.
    """
    def __init__(self, label: str, function: typing.Any, taken: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], values: dict) -> None:
        ...
class CompiledLaw(OwnLaw):
    """
    A law that is a compiled function of doubles.
    
    Args:
        address: of the function.
        taken: which of position (0), velocity (1) and time (2) come first.
        values: of its parameters, which follow.
        owner: what keeps the code alive.
    
    Raises:
        ValueError: no address, or more than 24 numbers.
    """
    def __init__(self, address: typing.SupportsInt | typing.SupportsIndex, taken: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], values: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], owner: typing.Any) -> None:
        ...
class OwnLaws:
    """
    The laws of an effect of the user's own: what `Custom` hands to a plant.
    
    Args:
        name: of the effect, for messages.
        laws: by hook: force, friction_level, command_gain, reading_error.
        length_scale, velocity_scale, time_scale: m, m/s, s, the shortest on which a law changes; infinite = not stated.
        origin: a function without arguments that makes the effect again.
    
    Raises:
        ValueError: an unknown hook, no law, or a scale that is not above 0.
    """
    def __init__(self, name: str, laws: collections.abc.Mapping[str, OwnLaw], *, length_scale: typing.SupportsFloat | typing.SupportsIndex, velocity_scale: typing.SupportsFloat | typing.SupportsIndex, time_scale: typing.SupportsFloat | typing.SupportsIndex, origin: typing.Any) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def value_at(self, hook: str, position: typing.SupportsFloat | typing.SupportsIndex, velocity: typing.SupportsFloat | typing.SupportsIndex, time: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        One law at one moment, as a run asks it.
        """
    def values_along(self, hook: str, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> numpy.typing.NDArray[numpy.float64]:
        """
        One law along arrays (n,) of m, m/s and s.
        """
class ConstantForce:
    """
    Effect `constant_force`: force.
    
    Fields:
        force (V): pushes towards +x
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.ConstantForce()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'force': ('V', 'pushes towards +x')}
    HOOKS: typing.ClassVar[tuple] = ('force')
    KINDS: typing.ClassVar[tuple] = tuple()
    LAW: typing.ClassVar[str] = 'force'
    NAME: typing.ClassVar[str] = 'constant_force'
    ROLES: typing.ClassVar[dict] = {'force': {'role': 'amplitude', 'quantity': 'force', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': 0.0}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, force: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0) -> typing.Any:
        """
        Force (V) at positions (m), velocities (m/s) and times (s).
        """
    def replace(self, **kwargs) -> ConstantForce:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> ConstantForce:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def force(self) -> float:
        """
        pushes towards +x, V
        """
class CableSpring:
    """
    Effect `cable_spring`: -stiffness (x - center).
    
    Fields:
        stiffness (V/m): force a metre of distance
        center (m): where the spring is slack
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.CableSpring()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'stiffness': ('V/m', 'force a metre of distance'), 'center': ('m', 'where the spring is slack')}
    HOOKS: typing.ClassVar[tuple] = ('force')
    KINDS: typing.ClassVar[tuple] = tuple()
    LAW: typing.ClassVar[str] = '-stiffness (x - center)'
    NAME: typing.ClassVar[str] = 'cable_spring'
    ROLES: typing.ClassVar[dict] = {'stiffness': {'role': 'amplitude', 'quantity': 'force_per_position', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': 0.0}, 'center': {'role': 'shape', 'quantity': 'position', 'low': 0.0, 'high': 1.0, 'logarithmic': False, 'neutral': None}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, stiffness: typing.SupportsFloat | typing.SupportsIndex = 0.0, center: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0) -> typing.Any:
        """
        Force (V) at positions (m), velocities (m/s) and times (s).
        """
    def replace(self, **kwargs) -> CableSpring:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> CableSpring:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def center(self) -> float:
        """
        where the spring is slack, m
        """
    @property
    def stiffness(self) -> float:
        """
        force a metre of distance, V/m
        """
class EndEffect:
    """
    Effect `end_effect`: force (exp(-(x1 - x) / decay_length) - exp(-(x - x0) / decay_length)).
    
    Fields:
        force (V): at an end, outwards
        decay_length (m): distance from the end at which it has fallen to 1/e
        travel (m): ends x0, x1 from which it is measured; infinite = of [axis]
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.EndEffect()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'force': ('V', 'at an end, outwards'), 'decay_length': ('m', 'distance from the end at which it has fallen to 1/e'), 'travel': ('m', 'ends x0, x1 from which it is measured; infinite = of [axis]')}
    HOOKS: typing.ClassVar[tuple] = ('force')
    KINDS: typing.ClassVar[tuple]
    LAW: typing.ClassVar[str] = 'force (exp(-(x1 - x) / decay_length) - exp(-(x - x0) / decay_length))'
    NAME: typing.ClassVar[str] = 'end_effect'
    ROLES: typing.ClassVar[dict] = {'force': {'role': 'amplitude', 'quantity': 'force', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': 0.0}, 'decay_length': {'role': 'shape', 'quantity': 'distance', 'low': 0.005, 'high': 0.5, 'logarithmic': True, 'neutral': None}, 'travel': {'role': 'setting', 'quantity': 'one', 'low': None, 'high': None, 'logarithmic': False, 'neutral': None}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, force: typing.SupportsFloat | typing.SupportsIndex = 0.0, decay_length: typing.SupportsFloat | typing.SupportsIndex = 0.01, travel: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"] = ...) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0) -> typing.Any:
        """
        Force (V) at positions (m), velocities (m/s) and times (s).
        """
    def replace(self, **kwargs) -> EndEffect:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> EndEffect:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def decay_length(self) -> float:
        """
        distance from the end at which it has fallen to 1/e, m
        """
    @property
    def force(self) -> float:
        """
        at an end, outwards, V
        """
    @property
    def travel(self) -> typing.Annotated[list[float], "FixedSize(2)"]:
        """
        ends x0, x1 from which it is measured; infinite = of [axis], m
        """
class LocalForce:
    """
    Effect `local_force`: force exp(-((x - center) / width)^2).
    
    Fields:
        force (V): at the center, towards +x
        center (m): place of the largest force
        width (m): distance from the center at which it has fallen to 1/e
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.LocalForce()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'force': ('V', 'at the center, towards +x'), 'center': ('m', 'place of the largest force'), 'width': ('m', 'distance from the center at which it has fallen to 1/e')}
    HOOKS: typing.ClassVar[tuple] = ('force')
    KINDS: typing.ClassVar[tuple]
    LAW: typing.ClassVar[str] = 'force exp(-((x - center) / width)^2)'
    NAME: typing.ClassVar[str] = 'local_force'
    ROLES: typing.ClassVar[dict] = {'force': {'role': 'amplitude', 'quantity': 'force', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': 0.0}, 'center': {'role': 'shape', 'quantity': 'position', 'low': 0.0, 'high': 1.0, 'logarithmic': False, 'neutral': None}, 'width': {'role': 'shape', 'quantity': 'distance', 'low': 0.002, 'high': 0.1, 'logarithmic': True, 'neutral': None}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, force: typing.SupportsFloat | typing.SupportsIndex = 0.0, center: typing.SupportsFloat | typing.SupportsIndex = 0.0, width: typing.SupportsFloat | typing.SupportsIndex = 0.01) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0) -> typing.Any:
        """
        Force (V) at positions (m), velocities (m/s) and times (s).
        """
    def replace(self, **kwargs) -> LocalForce:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> LocalForce:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def center(self) -> float:
        """
        place of the largest force, m
        """
    @property
    def force(self) -> float:
        """
        at the center, towards +x, V
        """
    @property
    def width(self) -> float:
        """
        distance from the center at which it has fallen to 1/e, m
        """
class Gravity:
    """
    Effect `gravity`: -moment sin(x - angle).
    
    Fields:
        moment (V): weight times arm, felt a quarter turn from `angle`
        angle (rad): where the mass hangs at rest
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.Gravity()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'moment': ('V', 'weight times arm, felt a quarter turn from `angle`'), 'angle': ('rad', 'where the mass hangs at rest')}
    HOOKS: typing.ClassVar[tuple] = ('force')
    KINDS: typing.ClassVar[tuple]
    LAW: typing.ClassVar[str] = '-moment sin(x - angle)'
    NAME: typing.ClassVar[str] = 'gravity'
    ROLES: typing.ClassVar[dict] = {'moment': {'role': 'amplitude', 'quantity': 'force', 'low': 0.0, 'high': 5.0, 'logarithmic': False, 'neutral': 0.0}, 'angle': {'role': 'shape', 'quantity': 'angle', 'low': -0.5, 'high': 0.5, 'logarithmic': False, 'neutral': None}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, moment: typing.SupportsFloat | typing.SupportsIndex = 0.0, angle: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0) -> typing.Any:
        """
        Force (V) at positions (m), velocities (m/s) and times (s).
        """
    def replace(self, **kwargs) -> Gravity:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> Gravity:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def angle(self) -> float:
        """
        where the mass hangs at rest, rad
        """
    @property
    def moment(self) -> float:
        """
        weight times arm, felt a quarter turn from `angle`, V
        """
class CoggingHarmonic:
    """
    Effect `cogging_harmonic`: -(sine sin(2 pi x / period) + cosine cos(2 pi x / period)).
    
    Fields:
        period (m): in position
        sine (V): amplitude of the sine
        cosine (V): amplitude of the cosine
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.CoggingHarmonic()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'period': ('m', 'in position'), 'sine': ('V', 'amplitude of the sine'), 'cosine': ('V', 'amplitude of the cosine')}
    HOOKS: typing.ClassVar[tuple] = ('force')
    KINDS: typing.ClassVar[tuple]
    LAW: typing.ClassVar[str] = '-(sine sin(2 pi x / period) + cosine cos(2 pi x / period))'
    NAME: typing.ClassVar[str] = 'cogging_harmonic'
    ROLES: typing.ClassVar[dict] = {'period': {'role': 'shape', 'quantity': 'distance', 'low': 0.0001, 'high': 1.0, 'logarithmic': True, 'neutral': None}, 'sine': {'role': 'amplitude', 'quantity': 'force', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': 0.0}, 'cosine': {'role': 'amplitude', 'quantity': 'force', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': 0.0}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, period: typing.SupportsFloat | typing.SupportsIndex = 0.01, sine: typing.SupportsFloat | typing.SupportsIndex = 0.0, cosine: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0) -> typing.Any:
        """
        Force (V) at positions (m), velocities (m/s) and times (s).
        """
    def replace(self, **kwargs) -> CoggingHarmonic:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> CoggingHarmonic:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def cosine(self) -> float:
        """
        amplitude of the cosine, V
        """
    @property
    def period(self) -> float:
        """
        in position, m
        """
    @property
    def sine(self) -> float:
        """
        amplitude of the sine, V
        """
class CoggingModulation:
    """
    Effect `cogging_modulation`: -(S(x) sin(2 pi x / period) + C(x) cos(2 pi x / period)).
    
    Fields:
        period (m): in position
        sine (V): amplitude of the sine at each control point
        cosine (V): amplitude of the cosine at each control point
        pitch (m): distance of the knots; 0 = the knots of [cogging]
        order: of the B-splines
        origin (m): first knot of the first full span
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.CoggingModulation()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'period': ('m', 'in position'), 'sine': ('V', 'amplitude of the sine at each control point'), 'cosine': ('V', 'amplitude of the cosine at each control point'), 'pitch': ('m', 'distance of the knots; 0 = the knots of [cogging]'), 'order': ('1', 'of the B-splines'), 'origin': ('m', 'first knot of the first full span')}
    HOOKS: typing.ClassVar[tuple] = ('force')
    KINDS: typing.ClassVar[tuple]
    LAW: typing.ClassVar[str] = '-(S(x) sin(2 pi x / period) + C(x) cos(2 pi x / period))'
    NAME: typing.ClassVar[str] = 'cogging_modulation'
    ROLES: typing.ClassVar[dict] = {'period': {'role': 'shape', 'quantity': 'distance', 'low': 0.002, 'high': 1.0, 'logarithmic': True, 'neutral': None}, 'sine': {'role': 'amplitude', 'quantity': 'force', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': list()}, 'cosine': {'role': 'amplitude', 'quantity': 'force', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': list()}, 'pitch': {'role': 'setting', 'quantity': 'one', 'low': None, 'high': None, 'logarithmic': False, 'neutral': None}, 'order': {'role': 'setting', 'quantity': 'one', 'low': None, 'high': None, 'logarithmic': False, 'neutral': None}, 'origin': {'role': 'setting', 'quantity': 'one', 'low': None, 'high': None, 'logarithmic': False, 'neutral': None}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, period: typing.SupportsFloat | typing.SupportsIndex = 0.01, sine: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [], cosine: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [], pitch: typing.SupportsFloat | typing.SupportsIndex = 0.0, order: typing.SupportsInt | typing.SupportsIndex = 3, origin: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0) -> typing.Any:
        """
        Force (V) at positions (m), velocities (m/s) and times (s).
        """
    def replace(self, **kwargs) -> CoggingModulation:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> CoggingModulation:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def cosine(self) -> list[float]:
        """
        amplitude of the cosine at each control point, V
        """
    @property
    def order(self) -> int:
        """
        of the B-splines, 1
        """
    @property
    def origin(self) -> float:
        """
        first knot of the first full span, m
        """
    @property
    def period(self) -> float:
        """
        in position, m
        """
    @property
    def pitch(self) -> float:
        """
        distance of the knots; 0 = the knots of [cogging], m
        """
    @property
    def sine(self) -> list[float]:
        """
        amplitude of the sine at each control point, V
        """
class CoulombAsymmetry:
    """
    Effect `coulomb_asymmetry`: -(difference / 2) sgn(v) S(v).
    
    Fields:
        difference (V): forward level less backward level
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.CoulombAsymmetry()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'difference': ('V', 'forward level less backward level')}
    HOOKS: typing.ClassVar[tuple] = ('friction_level')
    KINDS: typing.ClassVar[tuple] = tuple()
    LAW: typing.ClassVar[str] = '-(difference / 2) sgn(v) S(v)'
    NAME: typing.ClassVar[str] = 'coulomb_asymmetry'
    ROLES: typing.ClassVar[dict] = {'difference': {'role': 'amplitude', 'quantity': 'friction', 'low': -2.0, 'high': 2.0, 'logarithmic': False, 'neutral': 0.0}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, difference: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def friction_level_at(self, *, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0) -> typing.Any:
        """
        Level (V) that it adds to Fc at positions (m), velocities (m/s) and times (s).
        """
    def replace(self, **kwargs) -> CoulombAsymmetry:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> CoulombAsymmetry:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def difference(self) -> float:
        """
        forward level less backward level, V
        """
class ViscousAsymmetry:
    """
    Effect `viscous_asymmetry`: -(difference / 2) |v|.
    
    Fields:
        difference (V/(m/s)): forward slope less backward slope
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.ViscousAsymmetry()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'difference': ('V/(m/s)', 'forward slope less backward slope')}
    HOOKS: typing.ClassVar[tuple] = ('force')
    KINDS: typing.ClassVar[tuple] = tuple()
    LAW: typing.ClassVar[str] = '-(difference / 2) |v|'
    NAME: typing.ClassVar[str] = 'viscous_asymmetry'
    ROLES: typing.ClassVar[dict] = {'difference': {'role': 'amplitude', 'quantity': 'force_per_velocity', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': 0.0}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, difference: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0) -> typing.Any:
        """
        Force (V) at positions (m), velocities (m/s) and times (s).
        """
    def replace(self, **kwargs) -> ViscousAsymmetry:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> ViscousAsymmetry:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def difference(self) -> float:
        """
        forward slope less backward slope, V/(m/s)
        """
class StribeckFriction:
    """
    Effect `stribeck_friction`: -static_excess exp(-|v / velocity|^exponent) S(v).
    
    Fields:
        static_excess (V): static level above the Coulomb level
        velocity (m/s): speed at which the excess has fallen to 1/e
        exponent: shape of the fall: 1 exponential, 2 Gaussian
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.StribeckFriction()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'static_excess': ('V', 'static level above the Coulomb level'), 'velocity': ('m/s', 'speed at which the excess has fallen to 1/e'), 'exponent': ('1', 'shape of the fall: 1 exponential, 2 Gaussian')}
    HOOKS: typing.ClassVar[tuple] = ('friction_level')
    KINDS: typing.ClassVar[tuple] = tuple()
    LAW: typing.ClassVar[str] = '-static_excess exp(-|v / velocity|^exponent) S(v)'
    NAME: typing.ClassVar[str] = 'stribeck_friction'
    ROLES: typing.ClassVar[dict] = {'static_excess': {'role': 'amplitude', 'quantity': 'friction', 'low': 0.0, 'high': 2.0, 'logarithmic': False, 'neutral': 0.0}, 'velocity': {'role': 'shape', 'quantity': 'velocity', 'low': 0.001, 'high': 0.5, 'logarithmic': True, 'neutral': None}, 'exponent': {'role': 'shape', 'quantity': 'exponent', 'low': 0.5, 'high': 3.0, 'logarithmic': False, 'neutral': None}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, static_excess: typing.SupportsFloat | typing.SupportsIndex = 0.0, velocity: typing.SupportsFloat | typing.SupportsIndex = 0.01, exponent: typing.SupportsFloat | typing.SupportsIndex = 2.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def friction_level_at(self, *, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0) -> typing.Any:
        """
        Level (V) that it adds to Fc at positions (m), velocities (m/s) and times (s).
        """
    def replace(self, **kwargs) -> StribeckFriction:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> StribeckFriction:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def exponent(self) -> float:
        """
        shape of the fall: 1 exponential, 2 Gaussian, 1
        """
    @property
    def static_excess(self) -> float:
        """
        static level above the Coulomb level, V
        """
    @property
    def velocity(self) -> float:
        """
        speed at which the excess has fallen to 1/e, m/s
        """
class PreslidingFriction:
    """
    Effect `presliding_friction`: -(stiffness z + damping z'), z' = v - stiffness |v| z / g, in place of -g S(v).
    
    Fields:
        stiffness (V/m): of the contact at rest; infinite = none
        damping (V/(m/s)): of the bristle
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.PreslidingFriction()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'stiffness': ('V/m', 'of the contact at rest; infinite = none'), 'damping': ('V/(m/s)', 'of the bristle')}
    HOOKS: typing.ClassVar[tuple] = ('state')
    KINDS: typing.ClassVar[tuple] = tuple()
    LAW: typing.ClassVar[str] = "-(stiffness z + damping z'), z' = v - stiffness |v| z / g, in place of -g S(v)"
    NAME: typing.ClassVar[str] = 'presliding_friction'
    ROLES: typing.ClassVar[dict]
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, stiffness: typing.SupportsFloat | typing.SupportsIndex = ..., damping: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> PreslidingFriction:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> PreslidingFriction:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def damping(self) -> float:
        """
        of the bristle, V/(m/s)
        """
    @property
    def stiffness(self) -> float:
        """
        of the contact at rest; infinite = none, V/m
        """
class PositionDependentFriction:
    """
    Effect `position_dependent_friction`: -level(x) S(v), level linear between the nodes.
    
    Fields:
        nodes (m): positions, increasing
        levels (V): added to Fc, one a node
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.PositionDependentFriction()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'nodes': ('m', 'positions, increasing'), 'levels': ('V', 'added to Fc, one a node')}
    HOOKS: typing.ClassVar[tuple] = ('friction_level')
    KINDS: typing.ClassVar[tuple]
    LAW: typing.ClassVar[str] = '-level(x) S(v), level linear between the nodes'
    NAME: typing.ClassVar[str] = 'position_dependent_friction'
    ROLES: typing.ClassVar[dict] = {'nodes': {'role': 'shape', 'quantity': 'position', 'low': 0.0, 'high': 1.0, 'logarithmic': False, 'neutral': None}, 'levels': {'role': 'amplitude', 'quantity': 'friction', 'low': -2.0, 'high': 2.0, 'logarithmic': False, 'neutral': list()}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, nodes: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [], levels: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = []) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def friction_level_at(self, *, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0) -> typing.Any:
        """
        Level (V) that it adds to Fc at positions (m), velocities (m/s) and times (s).
        """
    def replace(self, **kwargs) -> PositionDependentFriction:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> PositionDependentFriction:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def levels(self) -> list[float]:
        """
        added to Fc, one a node, V
        """
    @property
    def nodes(self) -> list[float]:
        """
        positions, increasing, m
        """
class QuadraticDrag:
    """
    Effect `quadratic_drag`: -coefficient v |v|.
    
    Fields:
        coefficient (V/(m/s)^2): force a squared metre a second
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.QuadraticDrag()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'coefficient': ('V/(m/s)^2', 'force a squared metre a second')}
    HOOKS: typing.ClassVar[tuple] = ('force')
    KINDS: typing.ClassVar[tuple] = tuple()
    LAW: typing.ClassVar[str] = '-coefficient v |v|'
    NAME: typing.ClassVar[str] = 'quadratic_drag'
    ROLES: typing.ClassVar[dict] = {'coefficient': {'role': 'amplitude', 'quantity': 'force_per_velocity_squared', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': 0.0}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, coefficient: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0) -> typing.Any:
        """
        Force (V) at positions (m), velocities (m/s) and times (s).
        """
    def replace(self, **kwargs) -> QuadraticDrag:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> QuadraticDrag:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def coefficient(self) -> float:
        """
        force a squared metre a second, V/(m/s)^2
        """
class ForceConstantRipple:
    """
    Effect `force_constant_ripple`: u (1 + sine sin(2 pi x / period) + cosine cos(2 pi x / period)).
    
    Fields:
        period (m): in position
        sine: relative amplitude of the sine
        cosine: relative amplitude of the cosine
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.ForceConstantRipple()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'period': ('m', 'in position'), 'sine': ('1', 'relative amplitude of the sine'), 'cosine': ('1', 'relative amplitude of the cosine')}
    HOOKS: typing.ClassVar[tuple] = ('command_gain')
    KINDS: typing.ClassVar[tuple]
    LAW: typing.ClassVar[str] = 'u (1 + sine sin(2 pi x / period) + cosine cos(2 pi x / period))'
    NAME: typing.ClassVar[str] = 'force_constant_ripple'
    ROLES: typing.ClassVar[dict] = {'period': {'role': 'shape', 'quantity': 'distance', 'low': 0.0001, 'high': 1.0, 'logarithmic': True, 'neutral': None}, 'sine': {'role': 'amplitude', 'quantity': 'relative', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': 0.0}, 'cosine': {'role': 'amplitude', 'quantity': 'relative', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': 0.0}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, period: typing.SupportsFloat | typing.SupportsIndex = 0.01, sine: typing.SupportsFloat | typing.SupportsIndex = 0.0, cosine: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def gain_at(self, *, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0) -> typing.Any:
        """
        What it adds to the gain 1 of the command (relative) at positions (m) and times (s).
        """
    def replace(self, **kwargs) -> ForceConstantRipple:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> ForceConstantRipple:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def cosine(self) -> float:
        """
        relative amplitude of the cosine, 1
        """
    @property
    def period(self) -> float:
        """
        in position, m
        """
    @property
    def sine(self) -> float:
        """
        relative amplitude of the sine, 1
        """
class ForceConstantDrift:
    """
    Effect `force_constant_drift`: u (1 + change (1 - exp(-t / time_constant))).
    
    Fields:
        change: relative, after a long time
        time_constant (s): of the drift
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.ForceConstantDrift()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'change': ('1', 'relative, after a long time'), 'time_constant': ('s', 'of the drift')}
    HOOKS: typing.ClassVar[tuple] = ('command_gain')
    KINDS: typing.ClassVar[tuple] = tuple()
    LAW: typing.ClassVar[str] = 'u (1 + change (1 - exp(-t / time_constant)))'
    NAME: typing.ClassVar[str] = 'force_constant_drift'
    ROLES: typing.ClassVar[dict] = {'change': {'role': 'amplitude', 'quantity': 'relative', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': 0.0}, 'time_constant': {'role': 'shape', 'quantity': 'time', 'low': 0.02, 'high': 5.0, 'logarithmic': True, 'neutral': None}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, change: typing.SupportsFloat | typing.SupportsIndex = 0.0, time_constant: typing.SupportsFloat | typing.SupportsIndex = 60.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def gain_at(self, *, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0) -> typing.Any:
        """
        What it adds to the gain 1 of the command (relative) at positions (m) and times (s).
        """
    def replace(self, **kwargs) -> ForceConstantDrift:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> ForceConstantDrift:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def change(self) -> float:
        """
        relative, after a long time, 1
        """
    @property
    def time_constant(self) -> float:
        """
        of the drift, s
        """
class CommandDelay:
    """
    Effect `command_delay`: u(t - delay).
    
    Fields:
        delay (s): from computed to acting
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.CommandDelay()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'delay': ('s', 'from computed to acting')}
    HOOKS: typing.ClassVar[tuple] = ('command_delay')
    KINDS: typing.ClassVar[tuple] = tuple()
    LAW: typing.ClassVar[str] = 'u(t - delay)'
    NAME: typing.ClassVar[str] = 'command_delay'
    ROLES: typing.ClassVar[dict] = {'delay': {'role': 'shape', 'quantity': 'sample_time', 'low': 0.0, 'high': 50.0, 'logarithmic': False, 'neutral': 0.0}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, delay: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> CommandDelay:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> CommandDelay:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def delay(self) -> float:
        """
        from computed to acting, s
        """
class ActuatorLag:
    """
    Effect `actuator_lag`: u / (time_constant s + 1).
    
    Fields:
        time_constant (s): of the current loop
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.ActuatorLag()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'time_constant': ('s', 'of the current loop')}
    HOOKS: typing.ClassVar[tuple] = ('lag')
    KINDS: typing.ClassVar[tuple] = tuple()
    LAW: typing.ClassVar[str] = 'u / (time_constant s + 1)'
    NAME: typing.ClassVar[str] = 'actuator_lag'
    ROLES: typing.ClassVar[dict] = {'time_constant': {'role': 'shape', 'quantity': 'sample_time', 'low': 0.1, 'high': 100.0, 'logarithmic': True, 'neutral': 0.0}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, time_constant: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> ActuatorLag:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> ActuatorLag:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def time_constant(self) -> float:
        """
        of the current loop, s
        """
class CommandSaturation:
    """
    Effect `command_saturation`: min(max(u, -limit), limit).
    
    Fields:
        limit (V): largest command that passes; infinite = none
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.CommandSaturation()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'limit': ('V', 'largest command that passes; infinite = none')}
    HOOKS: typing.ClassVar[tuple] = ('shape_command')
    KINDS: typing.ClassVar[tuple] = tuple()
    LAW: typing.ClassVar[str] = 'min(max(u, -limit), limit)'
    NAME: typing.ClassVar[str] = 'command_saturation'
    ROLES: typing.ClassVar[dict]
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, limit: typing.SupportsFloat | typing.SupportsIndex = ...) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> CommandSaturation:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> CommandSaturation:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def shape_at(self, command: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
        """
        What the amplifier makes of commands, V.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def limit(self) -> float:
        """
        largest command that passes; infinite = none, V
        """
class CommandDeadZone:
    """
    Effect `command_dead_zone`: sgn(u) max(|u| - width, 0).
    
    Fields:
        width (V): half of the zone: largest command that does nothing
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.CommandDeadZone()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'width': ('V', 'half of the zone: largest command that does nothing')}
    HOOKS: typing.ClassVar[tuple] = ('shape_command')
    KINDS: typing.ClassVar[tuple] = tuple()
    LAW: typing.ClassVar[str] = 'sgn(u) max(|u| - width, 0)'
    NAME: typing.ClassVar[str] = 'command_dead_zone'
    ROLES: typing.ClassVar[dict] = {'width': {'role': 'shape', 'quantity': 'command', 'low': 0.0, 'high': 0.5, 'logarithmic': False, 'neutral': 0.0}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, width: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> CommandDeadZone:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> CommandDeadZone:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def shape_at(self, command: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
        """
        What the amplifier makes of commands, V.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def width(self) -> float:
        """
        half of the zone: largest command that does nothing, V
        """
class EncoderPeriodicError:
    """
    Effect `encoder_periodic_error`: reading = x + sine sin(2 pi x / period) + cosine cos(2 pi x / period).
    
    Fields:
        period (m): in position
        sine (m): amplitude of the sine
        cosine (m): amplitude of the cosine
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.EncoderPeriodicError()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'period': ('m', 'in position'), 'sine': ('m', 'amplitude of the sine'), 'cosine': ('m', 'amplitude of the cosine')}
    HOOKS: typing.ClassVar[tuple] = ('reading')
    KINDS: typing.ClassVar[tuple]
    LAW: typing.ClassVar[str] = 'reading = x + sine sin(2 pi x / period) + cosine cos(2 pi x / period)'
    NAME: typing.ClassVar[str] = 'encoder_periodic_error'
    ROLES: typing.ClassVar[dict] = {'period': {'role': 'shape', 'quantity': 'distance', 'low': 1e-05, 'high': 1.0, 'logarithmic': True, 'neutral': None}, 'sine': {'role': 'amplitude', 'quantity': 'distance', 'low': -0.01, 'high': 0.01, 'logarithmic': False, 'neutral': 0.0}, 'cosine': {'role': 'amplitude', 'quantity': 'distance', 'low': -0.01, 'high': 0.01, 'logarithmic': False, 'neutral': 0.0}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, period: typing.SupportsFloat | typing.SupportsIndex = 0.001, sine: typing.SupportsFloat | typing.SupportsIndex = 0.0, cosine: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def reading_at(self, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
        """
        What the encoder reads at positions, m, before noise and rounding.
        """
    def replace(self, **kwargs) -> EncoderPeriodicError:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> EncoderPeriodicError:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def cosine(self) -> float:
        """
        amplitude of the cosine, m
        """
    @property
    def period(self) -> float:
        """
        in position, m
        """
    @property
    def sine(self) -> float:
        """
        amplitude of the sine, m
        """
class EncoderScaleError:
    """
    Effect `encoder_scale_error`: reading = x (1 + scale).
    
    Fields:
        scale: by which the reading is too large, relative
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.EncoderScaleError()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'scale': ('1', 'by which the reading is too large, relative')}
    HOOKS: typing.ClassVar[tuple] = ('reading')
    KINDS: typing.ClassVar[tuple] = tuple()
    LAW: typing.ClassVar[str] = 'reading = x (1 + scale)'
    NAME: typing.ClassVar[str] = 'encoder_scale_error'
    ROLES: typing.ClassVar[dict] = {'scale': {'role': 'amplitude', 'quantity': 'relative', 'low': -0.1, 'high': 0.1, 'logarithmic': False, 'neutral': 0.0}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, scale: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def reading_at(self, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
        """
        What the encoder reads at positions, m, before noise and rounding.
        """
    def replace(self, **kwargs) -> EncoderScaleError:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> EncoderScaleError:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def scale(self) -> float:
        """
        by which the reading is too large, relative, 1
        """
class Backlash:
    """
    Effect `backlash`: m1 x'' = forces + T(q, q'), m2 (x + q)'' = -T(q, q'), T = 0 for |q| < gap / 2.
    
    Fields:
        gap (m): full play of the load
        mass_ratio: load over total
        contact_frequency (Hz): of the free-free vibration in contact
        contact_damping_ratio: of that vibration
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.Backlash()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'gap': ('m', 'full play of the load'), 'mass_ratio': ('1', 'load over total'), 'contact_frequency': ('Hz', 'of the free-free vibration in contact'), 'contact_damping_ratio': ('1', 'of that vibration')}
    HOOKS: typing.ClassVar[tuple] = ('state')
    KINDS: typing.ClassVar[tuple] = tuple()
    LAW: typing.ClassVar[str] = "m1 x'' = forces + T(q, q'), m2 (x + q)'' = -T(q, q'), T = 0 for |q| < gap / 2"
    NAME: typing.ClassVar[str] = 'backlash'
    ROLES: typing.ClassVar[dict] = {'gap': {'role': 'shape', 'quantity': 'distance', 'low': 1e-06, 'high': 0.02, 'logarithmic': True, 'neutral': 0.0}, 'mass_ratio': {'role': 'shape', 'quantity': 'relative', 'low': 0.0, 'high': 0.9, 'logarithmic': False, 'neutral': 0.0}, 'contact_frequency': {'role': 'setting', 'quantity': 'one', 'low': None, 'high': None, 'logarithmic': False, 'neutral': None}, 'contact_damping_ratio': {'role': 'setting', 'quantity': 'one', 'low': None, 'high': None, 'logarithmic': False, 'neutral': None}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, gap: typing.SupportsFloat | typing.SupportsIndex = 0.0, mass_ratio: typing.SupportsFloat | typing.SupportsIndex = 0.0, contact_frequency: typing.SupportsFloat | typing.SupportsIndex = 400.0, contact_damping_ratio: typing.SupportsFloat | typing.SupportsIndex = 1.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> Backlash:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> Backlash:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def contact_damping_ratio(self) -> float:
        """
        of that vibration, 1
        """
    @property
    def contact_frequency(self) -> float:
        """
        of the free-free vibration in contact, Hz
        """
    @property
    def gap(self) -> float:
        """
        full play of the load, m
        """
    @property
    def mass_ratio(self) -> float:
        """
        load over total, 1
        """
class FlexibleMode:
    """
    Effect `flexible_mode`: m1 x'' = forces + k q + c q', m2 (x + q)'' = -k q - c q'.
    
    Fields:
        frequency (Hz): of the free-free vibration; infinite = rigid
        damping_ratio: of that vibration
        mass_ratio: load over total
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.FlexibleMode()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'frequency': ('Hz', 'of the free-free vibration; infinite = rigid'), 'damping_ratio': ('1', 'of that vibration'), 'mass_ratio': ('1', 'load over total')}
    HOOKS: typing.ClassVar[tuple] = ('state')
    KINDS: typing.ClassVar[tuple] = tuple()
    LAW: typing.ClassVar[str] = "m1 x'' = forces + k q + c q', m2 (x + q)'' = -k q - c q'"
    NAME: typing.ClassVar[str] = 'flexible_mode'
    ROLES: typing.ClassVar[dict]
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, frequency: typing.SupportsFloat | typing.SupportsIndex = ..., damping_ratio: typing.SupportsFloat | typing.SupportsIndex = 0.01, mass_ratio: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> FlexibleMode:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> FlexibleMode:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def damping_ratio(self) -> float:
        """
        of that vibration, 1
        """
    @property
    def frequency(self) -> float:
        """
        of the free-free vibration; infinite = rigid, Hz
        """
    @property
    def mass_ratio(self) -> float:
        """
        load over total, 1
        """
class DisturbanceStep:
    """
    Effect `disturbance_step`: force for start <= t < stop, else 0.
    
    Fields:
        force (V): pushes towards +x
        start (s): time at which it begins
        stop (s): time at which it ends
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.DisturbanceStep()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'force': ('V', 'pushes towards +x'), 'start': ('s', 'time at which it begins'), 'stop': ('s', 'time at which it ends')}
    HOOKS: typing.ClassVar[tuple] = ('force')
    KINDS: typing.ClassVar[tuple]
    LAW: typing.ClassVar[str] = 'force for start <= t < stop, else 0'
    NAME: typing.ClassVar[str] = 'disturbance_step'
    ROLES: typing.ClassVar[dict] = {'force': {'role': 'amplitude', 'quantity': 'force', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': 0.0}, 'start': {'role': 'shape', 'quantity': 'time', 'low': 0.0, 'high': 1.0, 'logarithmic': False, 'neutral': None}, 'stop': {'role': 'shape', 'quantity': 'time', 'low': 0.0, 'high': 1.0, 'logarithmic': False, 'neutral': None}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, force: typing.SupportsFloat | typing.SupportsIndex = 0.0, start: typing.SupportsFloat | typing.SupportsIndex = 0.0, stop: typing.SupportsFloat | typing.SupportsIndex = ...) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0) -> typing.Any:
        """
        Force (V) at positions (m), velocities (m/s) and times (s).
        """
    def replace(self, **kwargs) -> DisturbanceStep:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> DisturbanceStep:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def force(self) -> float:
        """
        pushes towards +x, V
        """
    @property
    def start(self) -> float:
        """
        time at which it begins, s
        """
    @property
    def stop(self) -> float:
        """
        time at which it ends, s
        """
class DisturbanceTone:
    """
    Effect `disturbance_tone`: sine sin(2 pi frequency t) + cosine cos(2 pi frequency t).
    
    Fields:
        frequency (Hz): of the tone
        sine (V): amplitude of the sine
        cosine (V): amplitude of the cosine
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.DisturbanceTone()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'frequency': ('Hz', 'of the tone'), 'sine': ('V', 'amplitude of the sine'), 'cosine': ('V', 'amplitude of the cosine')}
    HOOKS: typing.ClassVar[tuple] = ('force')
    KINDS: typing.ClassVar[tuple]
    LAW: typing.ClassVar[str] = 'sine sin(2 pi frequency t) + cosine cos(2 pi frequency t)'
    NAME: typing.ClassVar[str] = 'disturbance_tone'
    ROLES: typing.ClassVar[dict] = {'frequency': {'role': 'shape', 'quantity': 'frequency', 'low': 0.0005, 'high': 0.5, 'logarithmic': True, 'neutral': None}, 'sine': {'role': 'amplitude', 'quantity': 'force', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': 0.0}, 'cosine': {'role': 'amplitude', 'quantity': 'force', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': 0.0}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, frequency: typing.SupportsFloat | typing.SupportsIndex = 1.0, sine: typing.SupportsFloat | typing.SupportsIndex = 0.0, cosine: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0) -> typing.Any:
        """
        Force (V) at positions (m), velocities (m/s) and times (s).
        """
    def replace(self, **kwargs) -> DisturbanceTone:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> DisturbanceTone:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def cosine(self) -> float:
        """
        amplitude of the cosine, V
        """
    @property
    def frequency(self) -> float:
        """
        of the tone, Hz
        """
    @property
    def sine(self) -> float:
        """
        amplitude of the sine, V
        """
class EmpiricalForce:
    """
    Effect `empirical_force`: f(x) + g(v) + h(t), each linear between its nodes.
    
    Fields:
        position_nodes (m): positions, increasing
        position_forces (V): pushes towards +x, one a node
        velocity_nodes (m/s): velocities, increasing
        velocity_forces (V): pushes towards +x, one a node
        time_nodes (s): times, increasing
        time_forces (V): pushes towards +x, one a node
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.effects.EmpiricalForce()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'position_nodes': ('m', 'positions, increasing'), 'position_forces': ('V', 'pushes towards +x, one a node'), 'velocity_nodes': ('m/s', 'velocities, increasing'), 'velocity_forces': ('V', 'pushes towards +x, one a node'), 'time_nodes': ('s', 'times, increasing'), 'time_forces': ('V', 'pushes towards +x, one a node')}
    HOOKS: typing.ClassVar[tuple] = ('force')
    KINDS: typing.ClassVar[tuple]
    LAW: typing.ClassVar[str] = 'f(x) + g(v) + h(t), each linear between its nodes'
    NAME: typing.ClassVar[str] = 'empirical_force'
    ROLES: typing.ClassVar[dict] = {'position_nodes': {'role': 'setting', 'quantity': 'one', 'low': None, 'high': None, 'logarithmic': False, 'neutral': None}, 'position_forces': {'role': 'amplitude', 'quantity': 'force', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': list()}, 'velocity_nodes': {'role': 'setting', 'quantity': 'one', 'low': None, 'high': None, 'logarithmic': False, 'neutral': None}, 'velocity_forces': {'role': 'amplitude', 'quantity': 'force', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': list()}, 'time_nodes': {'role': 'setting', 'quantity': 'one', 'low': None, 'high': None, 'logarithmic': False, 'neutral': None}, 'time_forces': {'role': 'amplitude', 'quantity': 'force', 'low': -1.0, 'high': 1.0, 'logarithmic': False, 'neutral': list()}}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, position_nodes: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [], position_forces: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [], velocity_nodes: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [], velocity_forces: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [], time_nodes: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [], time_forces: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = []) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] = 0.0) -> typing.Any:
        """
        Force (V) at positions (m), velocities (m/s) and times (s).
        """
    def replace(self, **kwargs) -> EmpiricalForce:
        """
        A copy with the given fields changed.
        """
    def resolved(self, axis: cogging._core.AxisParameters, cogging: cogging._core.CoggingModel | None = None) -> EmpiricalForce:
        """
        A copy whose fields that stand for those of the plant (travel, knots) are filled in.
        
        Raises:
            ValueError: the plant lacks what it needs.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def position_forces(self) -> list[float]:
        """
        pushes towards +x, one a node, V
        """
    @property
    def position_nodes(self) -> list[float]:
        """
        positions, increasing, m
        """
    @property
    def time_forces(self) -> list[float]:
        """
        pushes towards +x, one a node, V
        """
    @property
    def time_nodes(self) -> list[float]:
        """
        times, increasing, s
        """
    @property
    def velocity_forces(self) -> list[float]:
        """
        pushes towards +x, one a node, V
        """
    @property
    def velocity_nodes(self) -> list[float]:
        """
        velocities, increasing, m/s
        """
