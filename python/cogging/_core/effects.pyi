"""
Every effect that a plant may have, one class each.
"""
from __future__ import annotations
import typing
__all__: list[str] = ['ActuatorLag', 'CableSpring', 'CoggingHarmonic', 'CommandDelay', 'CommandSaturation', 'ConstantForce', 'CoulombAsymmetry', 'DisturbanceStep', 'DisturbanceTone', 'QuadraticDrag', 'StribeckFriction', 'ViscousAsymmetry']
class ConstantForce:
    """
    Effect `constant_force`: force.
    
    Fields:
        force (V): pushes towards +x
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    """
    FIELDS: typing.ClassVar[dict] = {'force': ('V', 'pushes towards +x')}
    LAW: typing.ClassVar[str] = 'force'
    NAME: typing.ClassVar[str] = 'constant_force'
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, force: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.SupportsFloat | typing.SupportsIndex = 0.0, velocity: typing.SupportsFloat | typing.SupportsIndex = 0.0, time: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> float:
        """
        Force (V) at a position (m), velocity (m/s) and time (s).
        """
    def replace(self, **kwargs) -> ConstantForce:
        """
        A copy with the given fields changed.
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
    """
    FIELDS: typing.ClassVar[dict] = {'stiffness': ('V/m', 'force a metre of distance'), 'center': ('m', 'where the spring is slack')}
    LAW: typing.ClassVar[str] = '-stiffness (x - center)'
    NAME: typing.ClassVar[str] = 'cable_spring'
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, stiffness: typing.SupportsFloat | typing.SupportsIndex = 0.0, center: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.SupportsFloat | typing.SupportsIndex = 0.0, velocity: typing.SupportsFloat | typing.SupportsIndex = 0.0, time: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> float:
        """
        Force (V) at a position (m), velocity (m/s) and time (s).
        """
    def replace(self, **kwargs) -> CableSpring:
        """
        A copy with the given fields changed.
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
class CoggingHarmonic:
    """
    Effect `cogging_harmonic`: -(sine sin(2 pi x / period) + cosine cos(2 pi x / period)).
    
    Fields:
        period (m): in position
        sine (V): amplitude of the sine
        cosine (V): amplitude of the cosine
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    """
    FIELDS: typing.ClassVar[dict] = {'period': ('m', 'in position'), 'sine': ('V', 'amplitude of the sine'), 'cosine': ('V', 'amplitude of the cosine')}
    LAW: typing.ClassVar[str] = '-(sine sin(2 pi x / period) + cosine cos(2 pi x / period))'
    NAME: typing.ClassVar[str] = 'cogging_harmonic'
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, period: typing.SupportsFloat | typing.SupportsIndex = 0.01, sine: typing.SupportsFloat | typing.SupportsIndex = 0.0, cosine: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.SupportsFloat | typing.SupportsIndex = 0.0, velocity: typing.SupportsFloat | typing.SupportsIndex = 0.0, time: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> float:
        """
        Force (V) at a position (m), velocity (m/s) and time (s).
        """
    def replace(self, **kwargs) -> CoggingHarmonic:
        """
        A copy with the given fields changed.
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
class CoulombAsymmetry:
    """
    Effect `coulomb_asymmetry`: -(difference / 2) sgn(v) S(v).
    
    Fields:
        difference (V): forward level less backward level
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    """
    FIELDS: typing.ClassVar[dict] = {'difference': ('V', 'forward level less backward level')}
    LAW: typing.ClassVar[str] = '-(difference / 2) sgn(v) S(v)'
    NAME: typing.ClassVar[str] = 'coulomb_asymmetry'
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, difference: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def friction_level_at(self, *, position: typing.SupportsFloat | typing.SupportsIndex = 0.0, velocity: typing.SupportsFloat | typing.SupportsIndex = 0.0, time: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> float:
        """
        Level (V) that it adds to Fc at a position (m), velocity (m/s) and time (s).
        """
    def replace(self, **kwargs) -> CoulombAsymmetry:
        """
        A copy with the given fields changed.
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
    """
    FIELDS: typing.ClassVar[dict] = {'difference': ('V/(m/s)', 'forward slope less backward slope')}
    LAW: typing.ClassVar[str] = '-(difference / 2) |v|'
    NAME: typing.ClassVar[str] = 'viscous_asymmetry'
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, difference: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.SupportsFloat | typing.SupportsIndex = 0.0, velocity: typing.SupportsFloat | typing.SupportsIndex = 0.0, time: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> float:
        """
        Force (V) at a position (m), velocity (m/s) and time (s).
        """
    def replace(self, **kwargs) -> ViscousAsymmetry:
        """
        A copy with the given fields changed.
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
    """
    FIELDS: typing.ClassVar[dict] = {'static_excess': ('V', 'static level above the Coulomb level'), 'velocity': ('m/s', 'speed at which the excess has fallen to 1/e'), 'exponent': ('1', 'shape of the fall: 1 exponential, 2 Gaussian')}
    LAW: typing.ClassVar[str] = '-static_excess exp(-|v / velocity|^exponent) S(v)'
    NAME: typing.ClassVar[str] = 'stribeck_friction'
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, static_excess: typing.SupportsFloat | typing.SupportsIndex = 0.0, velocity: typing.SupportsFloat | typing.SupportsIndex = 0.01, exponent: typing.SupportsFloat | typing.SupportsIndex = 2.0) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def friction_level_at(self, *, position: typing.SupportsFloat | typing.SupportsIndex = 0.0, velocity: typing.SupportsFloat | typing.SupportsIndex = 0.0, time: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> float:
        """
        Level (V) that it adds to Fc at a position (m), velocity (m/s) and time (s).
        """
    def replace(self, **kwargs) -> StribeckFriction:
        """
        A copy with the given fields changed.
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
class QuadraticDrag:
    """
    Effect `quadratic_drag`: -coefficient v |v|.
    
    Fields:
        coefficient (V/(m/s)^2): force a squared metre a second
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    """
    FIELDS: typing.ClassVar[dict] = {'coefficient': ('V/(m/s)^2', 'force a squared metre a second')}
    LAW: typing.ClassVar[str] = '-coefficient v |v|'
    NAME: typing.ClassVar[str] = 'quadratic_drag'
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, coefficient: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.SupportsFloat | typing.SupportsIndex = 0.0, velocity: typing.SupportsFloat | typing.SupportsIndex = 0.0, time: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> float:
        """
        Force (V) at a position (m), velocity (m/s) and time (s).
        """
    def replace(self, **kwargs) -> QuadraticDrag:
        """
        A copy with the given fields changed.
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
class CommandDelay:
    """
    Effect `command_delay`: u(t - delay).
    
    Fields:
        delay (s): from computed to acting
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    """
    FIELDS: typing.ClassVar[dict] = {'delay': ('s', 'from computed to acting')}
    LAW: typing.ClassVar[str] = 'u(t - delay)'
    NAME: typing.ClassVar[str] = 'command_delay'
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, delay: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> CommandDelay:
        """
        A copy with the given fields changed.
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
    """
    FIELDS: typing.ClassVar[dict] = {'time_constant': ('s', 'of the current loop')}
    LAW: typing.ClassVar[str] = 'u / (time_constant s + 1)'
    NAME: typing.ClassVar[str] = 'actuator_lag'
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, time_constant: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> ActuatorLag:
        """
        A copy with the given fields changed.
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
    """
    FIELDS: typing.ClassVar[dict] = {'limit': ('V', 'largest command that passes; infinite = none')}
    LAW: typing.ClassVar[str] = 'min(max(u, -limit), limit)'
    NAME: typing.ClassVar[str] = 'command_saturation'
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, limit: typing.SupportsFloat | typing.SupportsIndex = ...) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> CommandSaturation:
        """
        A copy with the given fields changed.
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
class DisturbanceStep:
    """
    Effect `disturbance_step`: force for start <= t < stop, else 0.
    
    Fields:
        force (V): pushes towards +x
        start (s): time at which it begins
        stop (s): time at which it ends
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    """
    FIELDS: typing.ClassVar[dict] = {'force': ('V', 'pushes towards +x'), 'start': ('s', 'time at which it begins'), 'stop': ('s', 'time at which it ends')}
    LAW: typing.ClassVar[str] = 'force for start <= t < stop, else 0'
    NAME: typing.ClassVar[str] = 'disturbance_step'
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, force: typing.SupportsFloat | typing.SupportsIndex = 0.0, start: typing.SupportsFloat | typing.SupportsIndex = 0.0, stop: typing.SupportsFloat | typing.SupportsIndex = ...) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.SupportsFloat | typing.SupportsIndex = 0.0, velocity: typing.SupportsFloat | typing.SupportsIndex = 0.0, time: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> float:
        """
        Force (V) at a position (m), velocity (m/s) and time (s).
        """
    def replace(self, **kwargs) -> DisturbanceStep:
        """
        A copy with the given fields changed.
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
    """
    FIELDS: typing.ClassVar[dict] = {'frequency': ('Hz', 'of the tone'), 'sine': ('V', 'amplitude of the sine'), 'cosine': ('V', 'amplitude of the cosine')}
    LAW: typing.ClassVar[str] = 'sine sin(2 pi frequency t) + cosine cos(2 pi frequency t)'
    NAME: typing.ClassVar[str] = 'disturbance_tone'
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, arg0: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, frequency: typing.SupportsFloat | typing.SupportsIndex = 1.0, sine: typing.SupportsFloat | typing.SupportsIndex = 0.0, cosine: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def force_at(self, *, position: typing.SupportsFloat | typing.SupportsIndex = 0.0, velocity: typing.SupportsFloat | typing.SupportsIndex = 0.0, time: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> float:
        """
        Force (V) at a position (m), velocity (m/s) and time (s).
        """
    def replace(self, **kwargs) -> DisturbanceTone:
        """
        A copy with the given fields changed.
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
