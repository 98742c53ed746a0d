"""
The core of cogging: cogging model, references, plant, controllers and simulation, in C++.
"""
from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing
from . import references
from . import effects
from . import controllers
__all__: list[str] = ['AdaptiveRobustParameters', 'Arc', 'AxisParameters', 'BSpline', 'CONTROLLERS', 'Cascade', 'CascadeParameters', 'CoggingModel', 'CompiledController', 'ControllerError', 'Dcarc', 'DivergedError', 'EFFECTS', 'EncoderParameters', 'FilteredSine', 'FilteredSineParameters', 'NoiseParameters', 'NumberReader', 'ObserverBased', 'ObserverBasedParameters', 'OutputFeedbackArc', 'OutputFeedbackArcParameters', 'Performance', 'Pid', 'PidParameters', 'Plant', 'PlantAlong', 'PointToPoint', 'PointToPointParameters', 'Prediction', 'Predictor', 'REFERENCES', 'Reference', 'Sampled', 'Sine', 'SineParameters', 'Speed', 'SpeedParameters', 'SplineHarmonics', 'StopFlag', 'autoregression', 'closed_loop', 'closed_loop_records', 'cogging_slope_max', 'controllers', 'desired_compensation_condition', 'desired_compensation_matrix', 'effects', 'format_rows', 'friction_slope_max', 'instruction_set', 'instruction_sets', 'memory_left', 'performance', 'project', 'references', 'replay_controller', 'require_memory', 'smooth_sign', 'whiten']
class DivergedError(RuntimeError):
    pass
class BSpline:
    """
    Uniform B-spline basis of order k with m control points.
    
    Lu et al. 2008, eq. 6: control point c (from 0) acts on [origin + (c + 1 - k) pitch, origin + (c + 1) pitch).
    Between `origin` and `end` the m - k + 1 spans carry k control points each and the basis sums to one; outside, a
    spline keeps its end value. One control point is a constant, whatever the order.
    
    Raises:
        ValueError: order not in 1..16, pitch <= 0, control points above one but below the order.
    
    Example:
        >>> spline = cogging.BSpline(order=2, origin=0.0, pitch=0.1, control_points=3)
        >>> spline.design_matrix([0.05]).round(6).tolist()
        [[0.5, 0.5, 0.0]]
    """
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __init__(self, *, order: typing.SupportsInt | typing.SupportsIndex, origin: typing.SupportsFloat | typing.SupportsIndex, pitch: typing.SupportsFloat | typing.SupportsIndex, control_points: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def design_matrix(self, positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, 1]"]) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]"]:
        """
        N_{c,k}(x) for positions (n,), m: array (n, control_points).
        """
    @property
    def control_points(self) -> int:
        """
        m
        """
    @property
    def end(self) -> float:
        """
        last knot of the last full span, m
        """
    @property
    def order(self) -> int:
        """
        k: 1 piecewise constant, 2 linear, 3 quadratic
        """
    @property
    def origin(self) -> float:
        """
        first knot of the first full span, m
        """
    @property
    def pitch(self) -> float:
        """
        distance of the knots, m
        """
class SplineHarmonics:
    """
    The regressor S_r(x) of the cogging model (Lu et al. 2008, eq. 3 to 7).
    
    F_r(x) = sum_i (f_Si(x) sin(2 pi h_i x / pitch) + f_Ci(x) cos(2 pi h_i x / pitch)), amplitudes f being B-splines; with
    `periods` in place of `harmonics`, sin(2 pi x / period). Coefficients A_r: one control point after the other, in each
    sine and cosine of every term.
    
    Raises:
        ValueError: a harmonic below 1, a period <= 0, one given twice, both or neither given, no pitch where it is needed.
    
    Example:
        >>> basis = cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2])
        >>> basis.regressor([0.0125]).round(6).tolist()
        [[1.0, 0.0, 0.0, -1.0]]
    """
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __init__(self, *, pitch: typing.SupportsFloat | typing.SupportsIndex | None = None, harmonics: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex] | None = None, periods: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] | None = None, order: typing.SupportsInt | typing.SupportsIndex = 3, origin: typing.SupportsFloat | typing.SupportsIndex = 0.0, control_points: typing.SupportsInt | typing.SupportsIndex = 1) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def active_regressor(self, position: typing.SupportsFloat | typing.SupportsIndex) -> tuple[int, list[float]]:
        """
        Index of the first active coefficient and the values of the active ones, at one position (m).
        """
    def regressor(self, positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, 1]"]) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]"]:
        """
        S_r(x) for positions (n,), m: array (n, coefficients), zero where a control point does not act.
        """
    @property
    def coefficients(self) -> int:
        """
        length of A_r
        """
    @property
    def harmonics(self) -> list[int]:
        ...
    @property
    def periods(self) -> list[float]:
        """
        m
        """
    @property
    def pitch(self) -> float:
        """
        m; 0 with periods
        """
    @property
    def spline(self) -> BSpline:
        """
        the B-spline of the amplitudes
        """
    @property
    def terms(self) -> int:
        """
        number of harmonics or periods
        """
    @property
    def wavenumbers(self) -> list[float]:
        """
        2 pi / period of each term, 1/m
        """
class CoggingModel:
    """
    A cogging force F_cogging(x) that opposes the command, V.
    
    sine, cosine: V, one row a term, one column a control point (Lu et al. 2008, eq. 3 to 7).
    
    Raises:
        ValueError: wrong shape, or a value that is not finite.
    
    Example:
        >>> basis = cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2])
        >>> cogging.CoggingModel(basis, sine=[[0.1], [0.0]], cosine=[[0.0], [0.02]]).force(0.0125)
        0.08
    """
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> tuple[float, list[int], list[float], int, float, int, list[float]]:
        ...
    def __init__(self, basis: SplineHarmonics, sine: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, n]"], cosine: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, n]"]) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: tuple) -> None:
        ...
    def force(self, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
        """
        F_cogging(x), V, at positions in m.
        """
    def slope(self, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
        """
        dF_cogging/dx, V/m, at positions in m.
        """
    @property
    def basis(self) -> SplineHarmonics:
        """
        the SplineHarmonics it stands on
        """
    @property
    def coefficients(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        A_r of eq. 7, V
        """
    @property
    def cosine(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]"]:
        """
        V
        """
    @property
    def sine(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]"]:
        """
        V
        """
class Reference:
    """
    A motion: position and its first two derivatives over time.
    """
    def __reduce__(self) -> typing.Any:
        ...
    def sample(self, times: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
        """
        Position (m), velocity (m/s) and acceleration (m/s^2) at the times (n,), s.
        """
    @property
    def end(self) -> float:
        """
        time at which the motion is over, s; infinite if it never is
        """
    @property
    def period(self) -> float:
        """
        after which it repeats itself, s, rests included; infinite if it never does
        """
class PointToPointParameters:
    """
    Limits and rests of a PointToPoint.
    
    Fields:
        start (m): position before the first move
        distance (m): length of a move, with its sign
        velocity (m/s): limit on the speed
        acceleration (m/s^2): limit on the acceleration
        jerk (m/s^3): limit on the jerk; infinite = trapezoidal velocity
        dwell (s): rest after each move
        repeats: number of moves there and back
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.PointToPointParameters()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'start': ('m', 'position before the first move'), 'distance': ('m', 'length of a move, with its sign'), 'velocity': ('m/s', 'limit on the speed'), 'acceleration': ('m/s^2', 'limit on the acceleration'), 'jerk': ('m/s^3', 'limit on the jerk; infinite = trapezoidal velocity'), 'dwell': ('s', 'rest after each move'), 'repeats': ('1', 'number of moves there and back')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, start: typing.SupportsFloat | typing.SupportsIndex = 0.0, distance: typing.SupportsFloat | typing.SupportsIndex = 0.1, velocity: typing.SupportsFloat | typing.SupportsIndex = 0.1, acceleration: typing.SupportsFloat | typing.SupportsIndex = 1.0, jerk: typing.SupportsFloat | typing.SupportsIndex = ..., dwell: typing.SupportsFloat | typing.SupportsIndex = 0.0, repeats: typing.SupportsInt | typing.SupportsIndex = 1) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> PointToPointParameters:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def acceleration(self) -> float:
        """
        limit on the acceleration, m/s^2
        """
    @property
    def distance(self) -> float:
        """
        length of a move, with its sign, m
        """
    @property
    def dwell(self) -> float:
        """
        rest after each move, s
        """
    @property
    def jerk(self) -> float:
        """
        limit on the jerk; infinite = trapezoidal velocity, m/s^3
        """
    @property
    def repeats(self) -> int:
        """
        number of moves there and back, 1
        """
    @property
    def start(self) -> float:
        """
        position before the first move, m
        """
    @property
    def velocity(self) -> float:
        """
        limit on the speed, m/s
        """
class PointToPoint(Reference):
    """
    Jerk-limited moves there and back.
    
    start -> start + distance -> start, `repeats` times, resting `dwell` after each move. Each move is the fastest under
    the limits on velocity, acceleration and jerk that starts and ends at rest with zero acceleration.
    
    Example:
        >>> motion = cogging.PointToPoint(cogging.PointToPoint.PARAMETERS())
        >>> position, velocity, acceleration = motion.sample([0.0, 0.1])
    """
    NAME: typing.ClassVar[str] = 'point_to_point'
    __hash__: typing.ClassVar[None] = None
    PARAMETERS = PointToPointParameters
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __init__(self, parameters: PointToPointParameters) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    @property
    def move_time(self) -> float:
        """
        duration of one move, s
        """
    @property
    def parameters(self) -> PointToPointParameters:
        ...
class SineParameters:
    """
    Centre, amplitude and frequency of a Sine.
    
    Fields:
        center (m): middle of the motion
        amplitude (m): half the stroke
        frequency (Hz): strokes there and back a second
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.SineParameters()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'center': ('m', 'middle of the motion'), 'amplitude': ('m', 'half the stroke'), 'frequency': ('Hz', 'strokes there and back a second')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, center: typing.SupportsFloat | typing.SupportsIndex = 0.0, amplitude: typing.SupportsFloat | typing.SupportsIndex = 0.1, frequency: typing.SupportsFloat | typing.SupportsIndex = 1.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> SineParameters:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def amplitude(self) -> float:
        """
        half the stroke, m
        """
    @property
    def center(self) -> float:
        """
        middle of the motion, m
        """
    @property
    def frequency(self) -> float:
        """
        strokes there and back a second, Hz
        """
class Sine(Reference):
    """
    x_d(t) = center + amplitude sin(2 pi frequency t). It starts at speed: the axis does not.
    
    Example:
        >>> motion = cogging.Sine(cogging.Sine.PARAMETERS())
        >>> position, velocity, acceleration = motion.sample([0.0, 0.1])
    """
    NAME: typing.ClassVar[str] = 'sine'
    __hash__: typing.ClassVar[None] = None
    PARAMETERS = SineParameters
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __init__(self, parameters: SineParameters) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    @property
    def parameters(self) -> SineParameters:
        ...
class FilteredSineParameters:
    """
    Sine and generator of a FilteredSine (Xu and Yao 2001, eq. 58).
    
    Fields:
        center (m): where the motion starts, at rest
        amplitude (m): of the sine that it approaches
        frequency (Hz): of that sine
        beta_1 (1/s): damping of the generator
        beta_2 (1/s^2): stiffness of the generator
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.FilteredSineParameters()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'center': ('m', 'where the motion starts, at rest'), 'amplitude': ('m', 'of the sine that it approaches'), 'frequency': ('Hz', 'of that sine'), 'beta_1': ('1/s', 'damping of the generator'), 'beta_2': ('1/s^2', 'stiffness of the generator')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, center: typing.SupportsFloat | typing.SupportsIndex = 0.0, amplitude: typing.SupportsFloat | typing.SupportsIndex = 0.05, frequency: typing.SupportsFloat | typing.SupportsIndex = 0.6366197723675814, beta_1: typing.SupportsFloat | typing.SupportsIndex = 100.0, beta_2: typing.SupportsFloat | typing.SupportsIndex = 2500.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> FilteredSineParameters:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def amplitude(self) -> float:
        """
        of the sine that it approaches, m
        """
    @property
    def beta_1(self) -> float:
        """
        damping of the generator, 1/s
        """
    @property
    def beta_2(self) -> float:
        """
        stiffness of the generator, 1/s^2
        """
    @property
    def center(self) -> float:
        """
        where the motion starts, at rest, m
        """
    @property
    def frequency(self) -> float:
        """
        of that sine, Hz
        """
class FilteredSine(Reference):
    """
    A sine that starts from rest (Xu and Yao 2001, eq. 58).
    
    q_d'' + beta_1 q_d' + beta_2 q_d = q_r'' + beta_1 q_r' + beta_2 q_r, q_r = center + amplitude sin(omega t), from rest at
    the centre. Solved exactly at every time; the acceleration starts at beta_1 amplitude omega.
    
    Example:
        >>> motion = cogging.FilteredSine(cogging.FilteredSine.PARAMETERS())
        >>> position, velocity, acceleration = motion.sample([0.0, 0.1])
    """
    NAME: typing.ClassVar[str] = 'filtered_sine'
    __hash__: typing.ClassVar[None] = None
    PARAMETERS = FilteredSineParameters
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __init__(self, parameters: FilteredSineParameters) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    @property
    def parameters(self) -> FilteredSineParameters:
        ...
class Sampled(Reference):
    """
    A motion given by its samples.
    
    time (s), position (m) and, where known, velocity (m/s) and acceleration (m/s^2), all (n,). A missing derivative is
    differentiated from the one before it. Between samples cubic, the acceleration linear; outside at rest.
    
    Raises:
        ValueError: fewer than three samples, time not strictly increasing, lengths that differ, a NaN.
    
    Example:
        >>> motion = cogging.Sampled(time=[0.0, 0.1, 0.2], position=[0.0, 0.01, 0.02])
        >>> position, velocity, acceleration = motion.sample([0.05, 0.1])
    """
    NAME: typing.ClassVar[str] = 'sampled'
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __init__(self, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None = None, acceleration: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None = None) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    @property
    def samples(self) -> dict[str, numpy.typing.NDArray[numpy.float64]]:
        """
        Its samples and their derivatives by the names of a log's columns, (n,) each.
        """
class AxisParameters:
    """
    Mass and friction of the axis: M x'' = u - B x' - Fc S(x') - F_cogging(x) + effects (Lu et al. 2008, eq. 1, 2).
    
    Fields:
        mass (V/(m/s^2)): M
        viscous (V/(m/s)): B
        coulomb (V): Fc (A_f in Lu et al. 2008)
        coulomb_width (m/s): S(v) = (2/pi) atan(v / coulomb_width); 0 = sgn with sticking
        travel (m): lower and upper end of the motion
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.AxisParameters()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'mass': ('V/(m/s^2)', 'M'), 'viscous': ('V/(m/s)', 'B'), 'coulomb': ('V', 'Fc (A_f in Lu et al. 2008)'), 'coulomb_width': ('m/s', 'S(v) = (2/pi) atan(v / coulomb_width); 0 = sgn with sticking'), 'travel': ('m', 'lower and upper end of the motion')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, mass: typing.SupportsFloat | typing.SupportsIndex = 1.0, viscous: typing.SupportsFloat | typing.SupportsIndex = 0.0, coulomb: typing.SupportsFloat | typing.SupportsIndex = 0.0, coulomb_width: typing.SupportsFloat | typing.SupportsIndex = 0.0, travel: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"] = ...) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> AxisParameters:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def coulomb(self) -> float:
        """
        Fc (A_f in Lu et al. 2008), V
        """
    @property
    def coulomb_width(self) -> float:
        """
        S(v) = (2/pi) atan(v / coulomb_width); 0 = sgn with sticking, m/s
        """
    @property
    def mass(self) -> float:
        """
        M, V/(m/s^2)
        """
    @property
    def travel(self) -> typing.Annotated[list[float], "FixedSize(2)"]:
        """
        lower and upper end of the motion, m
        """
    @property
    def viscous(self) -> float:
        """
        B, V/(m/s)
        """
class EncoderParameters:
    """
    reading = resolution round((x + errors + noise) / resolution).
    
    Fields:
        resolution (m): one count; 0 = ideal
        noise (m): rms of the white noise before rounding
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.EncoderParameters()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'resolution': ('m', 'one count; 0 = ideal'), 'noise': ('m', 'rms of the white noise before rounding')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, resolution: typing.SupportsFloat | typing.SupportsIndex = 0.0, noise: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> EncoderParameters:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def noise(self) -> float:
        """
        rms of the white noise before rounding, m
        """
    @property
    def resolution(self) -> float:
        """
        one count; 0 = ideal, m
        """
class NoiseParameters:
    """
    Force noise of a first-order spectrum, held between samples.
    
    Fields:
        force (V): rms of the force noise
        bandwidth (Hz): corner of its first-order spectrum
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.NoiseParameters()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'force': ('V', 'rms of the force noise'), 'bandwidth': ('Hz', 'corner of its first-order spectrum')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, force: typing.SupportsFloat | typing.SupportsIndex = 0.0, bandwidth: typing.SupportsFloat | typing.SupportsIndex = 50.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> NoiseParameters:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def bandwidth(self) -> float:
        """
        corner of its first-order spectrum, Hz
        """
    @property
    def force(self) -> float:
        """
        rms of the force noise, V
        """
class Plant:
    """
    A whole machine: axis, cogging, effects, encoder and noise.
    
    Raises:
        ValueError: more than one actuator_lag, presliding_friction, or load (backlash, flexible_mode) among the effects;
            an effect that needs the travel or the knots of the cogging where there are none.
    
    Example:
        >>> plant = cogging.Plant(cogging.AxisParameters(mass=0.1), effects=[cogging.effects.ConstantForce(force=0.5)])
        >>> plant.acceleration(position=0.0, velocity=0.0, command=1.0)
        15.0
    """
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __init__(self, axis: AxisParameters, *, cogging: CoggingModel | None = None, effects: collections.abc.Sequence[effects.ConstantForce | effects.CableSpring | effects.EndEffect | effects.LocalForce | effects.Gravity | effects.CoggingHarmonic | effects.CoggingModulation | effects.CoulombAsymmetry | effects.ViscousAsymmetry | effects.StribeckFriction | effects.PreslidingFriction | effects.PositionDependentFriction | effects.QuadraticDrag | effects.ForceConstantRipple | effects.ForceConstantDrift | effects.CommandDelay | effects.ActuatorLag | effects.CommandSaturation | effects.CommandDeadZone | effects.EncoderPeriodicError | effects.EncoderScaleError | effects.Backlash | effects.FlexibleMode | effects.DisturbanceStep | effects.DisturbanceTone | effects.EmpiricalForce | effects.OwnLaws] = [], encoder: EncoderParameters = ..., noise: NoiseParameters = ...) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def acceleration(self, *, position: typing.SupportsFloat | typing.SupportsIndex, velocity: typing.SupportsFloat | typing.SupportsIndex, command: typing.SupportsFloat | typing.SupportsIndex, time: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> float:
        """
        Acceleration (m/s^2) of the moving axis when `command` (V) acts: shape, delay and lag of the amplifier are not in it, nor are states (a bristle, a load of its own).
        """
    @property
    def axis(self) -> AxisParameters:
        ...
    @property
    def cogging(self) -> CoggingModel | None:
        ...
    @property
    def effects(self) -> list:
        ...
    @property
    def encoder(self) -> EncoderParameters:
        ...
    @property
    def noise(self) -> NoiseParameters:
        ...
class PidParameters:
    """
    Gains and feedforward of a Pid.
    
    Fields:
        sample_rate (Hz): samples a second
        kp (V/m): proportional gain
        ki (V/(m s)): integral gain
        kd (V/(m/s)): derivative gain
        mass (V/(m/s^2)): feedforward of the reference acceleration; 0 = none
        viscous (V/(m/s)): feedforward of the velocity
        coulomb (V): friction compensation
        coulomb_width (m/s): of the compensation's S(v); 0 = sgn
        feedforward_velocity: "reference" or "measured" (backward difference of the reading)
        command_limit (V): largest command, with anti-windup; 0 = none
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.PidParameters()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'sample_rate': ('Hz', 'samples a second'), 'kp': ('V/m', 'proportional gain'), 'ki': ('V/(m s)', 'integral gain'), 'kd': ('V/(m/s)', 'derivative gain'), 'mass': ('V/(m/s^2)', 'feedforward of the reference acceleration; 0 = none'), 'viscous': ('V/(m/s)', 'feedforward of the velocity'), 'coulomb': ('V', 'friction compensation'), 'coulomb_width': ('m/s', "of the compensation's S(v); 0 = sgn"), 'feedforward_velocity': ('', '"reference" or "measured" (backward difference of the reading)'), 'command_limit': ('V', 'largest command, with anti-windup; 0 = none')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, sample_rate: typing.SupportsFloat | typing.SupportsIndex = 5000.0, kp: typing.SupportsFloat | typing.SupportsIndex = 0.0, ki: typing.SupportsFloat | typing.SupportsIndex = 0.0, kd: typing.SupportsFloat | typing.SupportsIndex = 0.0, mass: typing.SupportsFloat | typing.SupportsIndex = 0.0, viscous: typing.SupportsFloat | typing.SupportsIndex = 0.0, coulomb: typing.SupportsFloat | typing.SupportsIndex = 0.0, coulomb_width: typing.SupportsFloat | typing.SupportsIndex = 0.0, feedforward_velocity: str = 'reference', command_limit: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> PidParameters:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def command_limit(self) -> float:
        """
        largest command, with anti-windup; 0 = none, V
        """
    @property
    def coulomb(self) -> float:
        """
        friction compensation, V
        """
    @property
    def coulomb_width(self) -> float:
        """
        of the compensation's S(v); 0 = sgn, m/s
        """
    @property
    def feedforward_velocity(self) -> str:
        """
        "reference" or "measured" (backward difference of the reading)
        """
    @property
    def kd(self) -> float:
        """
        derivative gain, V/(m/s)
        """
    @property
    def ki(self) -> float:
        """
        integral gain, V/(m s)
        """
    @property
    def kp(self) -> float:
        """
        proportional gain, V/m
        """
    @property
    def mass(self) -> float:
        """
        feedforward of the reference acceleration; 0 = none, V/(m/s^2)
        """
    @property
    def sample_rate(self) -> float:
        """
        samples a second, Hz
        """
    @property
    def viscous(self) -> float:
        """
        feedforward of the velocity, V/(m/s)
        """
class Pid:
    """
    PID with feedforward, from positions only.
    
    u = mass a_r + viscous v + coulomb S(v) - kp e - ki sum(e Ts) - kd (e - e_prev) / Ts, e = reading - reference. The sum
    includes the current sample and starts at zero; e_prev = e in the first sample. With a command limit the sum does not
    take up an error that pushes further into it.
    
    A sample is refused whose reading or reference is not finite, or 1e12 and more: the last command is held, cut at
    `command_limit` (0 V before the first), what it knows from readings stays, and `samples_refused` counts it. Differences
    of the next reading are taken over all samples that have passed.
    
    Example:
        >>> controller = cogging.Pid(cogging.Pid.PARAMETERS(sample_rate=2000.0))
        >>> controller.sample_rate
        2000.0
    """
    NAME: typing.ClassVar[str] = 'pid'
    __hash__: typing.ClassVar[None] = None
    PARAMETERS = PidParameters
    def __copy__(self) -> Pid:
        ...
    def __deepcopy__(self, memo: dict) -> Pid:
        ...
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> tuple[PidParameters, list[float]]:
        ...
    def __init__(self, parameters: PidParameters) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: tuple) -> None:
        ...
    @typing.overload
    def command(self, *, reference: typing.SupportsFloat | typing.SupportsIndex, reference_velocity: typing.SupportsFloat | typing.SupportsIndex = 0.0, reference_acceleration: typing.SupportsFloat | typing.SupportsIndex = 0.0, reading: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        The command (V) of this sample from reference (m, m/s, m/s^2) and encoder reading (m).
        """
    @typing.overload
    def command(self, reference: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], reading: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        The command (V) of this sample from reference (m, m/s, m/s^2) and encoder reading (m).
        """
    def copy(self) -> Pid:
        """
        A controller in the same state.
        """
    def update(self, applied: typing.SupportsFloat | typing.SupportsIndex) -> None:
        """
        Ends the sample: the command (V) that was really applied; one that is not finite is taken to have been its own, cut at the limit.
        """
    @property
    def estimates(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        What it believes now, (p,): a copy; empty for a controller that does not adapt.
        """
    @property
    def parameters(self) -> PidParameters:
        ...
    @property
    def sample_rate(self) -> float:
        """
        Hz
        """
    @property
    def samples_refused(self) -> int:
        """
        How many samples were refused so far, for a reading or a reference that is not finite.
        """
class CascadeParameters:
    """
    Gains and feedforward of a Cascade.
    
    Fields:
        sample_rate (Hz): samples a second
        kp (1/s): gain of the position loop
        kv (V/(m/s)): gain of the velocity loop
        mass (V/(m/s^2)): feedforward of the reference acceleration; 0 = none
        viscous (V/(m/s)): feedforward of the velocity
        coulomb (V): friction compensation
        coulomb_width (m/s): of the compensation's S(v); 0 = sgn
        feedforward_velocity: "reference" or "measured" (backward difference of the reading)
        command_limit (V): largest command; 0 = none
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.CascadeParameters()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'sample_rate': ('Hz', 'samples a second'), 'kp': ('1/s', 'gain of the position loop'), 'kv': ('V/(m/s)', 'gain of the velocity loop'), 'mass': ('V/(m/s^2)', 'feedforward of the reference acceleration; 0 = none'), 'viscous': ('V/(m/s)', 'feedforward of the velocity'), 'coulomb': ('V', 'friction compensation'), 'coulomb_width': ('m/s', "of the compensation's S(v); 0 = sgn"), 'feedforward_velocity': ('', '"reference" or "measured" (backward difference of the reading)'), 'command_limit': ('V', 'largest command; 0 = none')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, sample_rate: typing.SupportsFloat | typing.SupportsIndex = 1000.0, kp: typing.SupportsFloat | typing.SupportsIndex = 0.0, kv: typing.SupportsFloat | typing.SupportsIndex = 0.0, mass: typing.SupportsFloat | typing.SupportsIndex = 0.0, viscous: typing.SupportsFloat | typing.SupportsIndex = 0.0, coulomb: typing.SupportsFloat | typing.SupportsIndex = 0.0, coulomb_width: typing.SupportsFloat | typing.SupportsIndex = 0.0, feedforward_velocity: str = 'reference', command_limit: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> CascadeParameters:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def command_limit(self) -> float:
        """
        largest command; 0 = none, V
        """
    @property
    def coulomb(self) -> float:
        """
        friction compensation, V
        """
    @property
    def coulomb_width(self) -> float:
        """
        of the compensation's S(v); 0 = sgn, m/s
        """
    @property
    def feedforward_velocity(self) -> str:
        """
        "reference" or "measured" (backward difference of the reading)
        """
    @property
    def kp(self) -> float:
        """
        gain of the position loop, 1/s
        """
    @property
    def kv(self) -> float:
        """
        gain of the velocity loop, V/(m/s)
        """
    @property
    def mass(self) -> float:
        """
        feedforward of the reference acceleration; 0 = none, V/(m/s^2)
        """
    @property
    def sample_rate(self) -> float:
        """
        samples a second, Hz
        """
    @property
    def viscous(self) -> float:
        """
        feedforward of the velocity, V/(m/s)
        """
class Cascade:
    """
    u = kv (kp (reference - reading) - v) + feedforward, v the backward difference of the reading.
    
    A sample is refused whose reading or reference is not finite, or 1e12 and more: the last command is held, cut at
    `command_limit` (0 V before the first), what it knows from readings stays, and `samples_refused` counts it. Differences
    of the next reading are taken over all samples that have passed.
    
    Example:
        >>> controller = cogging.Cascade(cogging.Cascade.PARAMETERS(sample_rate=2000.0))
        >>> controller.sample_rate
        2000.0
    """
    NAME: typing.ClassVar[str] = 'cascade'
    __hash__: typing.ClassVar[None] = None
    PARAMETERS = CascadeParameters
    def __copy__(self) -> Cascade:
        ...
    def __deepcopy__(self, memo: dict) -> Cascade:
        ...
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> tuple[CascadeParameters, list[float]]:
        ...
    def __init__(self, parameters: CascadeParameters) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: tuple) -> None:
        ...
    @typing.overload
    def command(self, *, reference: typing.SupportsFloat | typing.SupportsIndex, reference_velocity: typing.SupportsFloat | typing.SupportsIndex = 0.0, reference_acceleration: typing.SupportsFloat | typing.SupportsIndex = 0.0, reading: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        The command (V) of this sample from reference (m, m/s, m/s^2) and encoder reading (m).
        """
    @typing.overload
    def command(self, reference: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], reading: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        The command (V) of this sample from reference (m, m/s, m/s^2) and encoder reading (m).
        """
    def copy(self) -> Cascade:
        """
        A controller in the same state.
        """
    def update(self, applied: typing.SupportsFloat | typing.SupportsIndex) -> None:
        """
        Ends the sample: the command (V) that was really applied; one that is not finite is taken to have been its own, cut at the limit.
        """
    @property
    def estimates(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        What it believes now, (p,): a copy; empty for a controller that does not adapt.
        """
    @property
    def parameters(self) -> CascadeParameters:
        ...
    @property
    def sample_rate(self) -> float:
        """
        Hz
        """
    @property
    def samples_refused(self) -> int:
        """
        How many samples were refused so far, for a reading or a reference that is not finite.
        """
class SpeedParameters:
    """
    Gain, delay and feedforward of a Speed.
    
    Fields:
        sample_rate (Hz): samples a second
        kp (V/(m/s)): gain of the velocity loop
        delay (s): from a reading to the command that it gives
        mass (V/(m/s^2)): feedforward of the reference acceleration; 0 = none
        viscous (V/(m/s)): feedforward of the velocity
        coulomb (V): friction compensation
        coulomb_width (m/s): of the compensation's S(v); 0 = sgn
        feedforward_velocity: "reference" or "measured" (backward difference of the reading)
        command_limit (V): largest command; 0 = none
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.SpeedParameters()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'sample_rate': ('Hz', 'samples a second'), 'kp': ('V/(m/s)', 'gain of the velocity loop'), 'delay': ('s', 'from a reading to the command that it gives'), 'mass': ('V/(m/s^2)', 'feedforward of the reference acceleration; 0 = none'), 'viscous': ('V/(m/s)', 'feedforward of the velocity'), 'coulomb': ('V', 'friction compensation'), 'coulomb_width': ('m/s', "of the compensation's S(v); 0 = sgn"), 'feedforward_velocity': ('', '"reference" or "measured" (backward difference of the reading)'), 'command_limit': ('V', 'largest command; 0 = none')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, sample_rate: typing.SupportsFloat | typing.SupportsIndex = 1000.0, kp: typing.SupportsFloat | typing.SupportsIndex = 0.0, delay: typing.SupportsFloat | typing.SupportsIndex = 0.0, mass: typing.SupportsFloat | typing.SupportsIndex = 0.0, viscous: typing.SupportsFloat | typing.SupportsIndex = 0.0, coulomb: typing.SupportsFloat | typing.SupportsIndex = 0.0, coulomb_width: typing.SupportsFloat | typing.SupportsIndex = 0.0, feedforward_velocity: str = 'reference', command_limit: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> SpeedParameters:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def command_limit(self) -> float:
        """
        largest command; 0 = none, V
        """
    @property
    def coulomb(self) -> float:
        """
        friction compensation, V
        """
    @property
    def coulomb_width(self) -> float:
        """
        of the compensation's S(v); 0 = sgn, m/s
        """
    @property
    def delay(self) -> float:
        """
        from a reading to the command that it gives, s
        """
    @property
    def feedforward_velocity(self) -> str:
        """
        "reference" or "measured" (backward difference of the reading)
        """
    @property
    def kp(self) -> float:
        """
        gain of the velocity loop, V/(m/s)
        """
    @property
    def mass(self) -> float:
        """
        feedforward of the reference acceleration; 0 = none, V/(m/s^2)
        """
    @property
    def sample_rate(self) -> float:
        """
        samples a second, Hz
        """
    @property
    def viscous(self) -> float:
        """
        feedforward of the velocity, V/(m/s)
        """
class Speed:
    """
    A velocity loop, from positions only.
    
    w = kp (v_r - v) + feedforward, put out `delay` later; v is the backward difference of the reading, 0 in the first
    sample. With delay = (n + f) / sample_rate, 0 <= f < 1, the command of sample k is (1 - f) w[k-n] + f w[k-n-1], w = 0
    before the first sample: the mean over the sample of the held w after the exact delay. What is held in a sample that is
    refused is w, which goes through the delay as ever.
    
    A sample is refused whose reading or reference is not finite, or 1e12 and more: the last command is held, cut at
    `command_limit` (0 V before the first), what it knows from readings stays, and `samples_refused` counts it. Differences
    of the next reading are taken over all samples that have passed.
    
    Example:
        >>> controller = cogging.Speed(cogging.Speed.PARAMETERS(sample_rate=2000.0))
        >>> controller.sample_rate
        2000.0
    """
    NAME: typing.ClassVar[str] = 'speed'
    __hash__: typing.ClassVar[None] = None
    PARAMETERS = SpeedParameters
    def __copy__(self) -> Speed:
        ...
    def __deepcopy__(self, memo: dict) -> Speed:
        ...
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> tuple[SpeedParameters, list[float]]:
        ...
    def __init__(self, parameters: SpeedParameters) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: tuple) -> None:
        ...
    @typing.overload
    def command(self, *, reference: typing.SupportsFloat | typing.SupportsIndex, reference_velocity: typing.SupportsFloat | typing.SupportsIndex = 0.0, reference_acceleration: typing.SupportsFloat | typing.SupportsIndex = 0.0, reading: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        The command (V) of this sample from reference (m, m/s, m/s^2) and encoder reading (m).
        """
    @typing.overload
    def command(self, reference: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], reading: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        The command (V) of this sample from reference (m, m/s, m/s^2) and encoder reading (m).
        """
    def copy(self) -> Speed:
        """
        A controller in the same state.
        """
    def update(self, applied: typing.SupportsFloat | typing.SupportsIndex) -> None:
        """
        Ends the sample: the command (V) that was really applied; one that is not finite is taken to have been its own, cut at the limit.
        """
    @property
    def estimates(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        What it believes now, (p,): a copy; empty for a controller that does not adapt.
        """
    @property
    def parameters(self) -> SpeedParameters:
        ...
    @property
    def sample_rate(self) -> float:
        """
        Hz
        """
    @property
    def samples_refused(self) -> int:
        """
        How many samples were refused so far, for a reading or a reference that is not finite.
        """
class AdaptiveRobustParameters:
    """
    Gains, bounds and initial estimates of Arc and Dcarc (Lu et al. 2008, eq. 11 to 30).
    
    Fields:
        sample_rate (Hz): samples a second
        error_gain (1/s): k_1 of p = e' + k_1 e (eq. 15)
        feedback_gain (V/(m/s)): k_s1 of u_s1 = -k_s1 p (eq. 19, 27)
        mass (V/(m/s^2)): initial estimate of theta_1 = M
        mass_bounds (V/(m/s^2)): theta_1 min and max (eq. 11)
        mass_adaptation (V/(m/s^2)/(V m/s) m/s): Gamma of theta_1
        viscous (V/(m/s)): initial estimate of theta_2 = B
        viscous_bounds (V/(m/s)): theta_2 min and max
        viscous_adaptation (V s/m^2): Gamma of theta_2
        coulomb (V): initial estimate of theta_3 = A_f
        coulomb_bounds (V): theta_3 min and max
        coulomb_adaptation (V/m): Gamma of theta_3
        coulomb_width (m/s): of S_f(v) = (2/pi) atan(v / width) (eq. 2)
        disturbance (V): initial estimate of d_n = -theta_5
        disturbance_bounds (V): d_n min and max
        disturbance_adaptation (V/m): Gamma of theta_5
        cogging_pitch (m): P of the harmonics and of the knots
        cogging_harmonics: those compensated; empty = no cogging compensation
        cogging_order: k of the B-splines (eq. 6)
        cogging_origin (m): first knot inside the travel
        cogging_control_points: m of the B-splines; 1 = periodic, amplitudes constant along the travel
        cogging_bounds (V): min and max of every entry of theta_4b = A_r
        cogging_adaptation (V/m): Gamma of every entry of A_r
        cogging_estimates (V): initial A_r, one control point after the other; empty = zeros
        epsilon (V m/s): of the robust term u_s2 (eq. 20, 30); 0 = no such term
        disturbance_bound (V): delta_d of eq. 12, for u_s2
        command_limit (V): largest command; 0 = none
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.AdaptiveRobustParameters()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'sample_rate': ('Hz', 'samples a second'), 'error_gain': ('1/s', "k_1 of p = e' + k_1 e (eq. 15)"), 'feedback_gain': ('V/(m/s)', 'k_s1 of u_s1 = -k_s1 p (eq. 19, 27)'), 'mass': ('V/(m/s^2)', 'initial estimate of theta_1 = M'), 'mass_bounds': ('V/(m/s^2)', 'theta_1 min and max (eq. 11)'), 'mass_adaptation': ('V/(m/s^2)/(V m/s) m/s', 'Gamma of theta_1'), 'viscous': ('V/(m/s)', 'initial estimate of theta_2 = B'), 'viscous_bounds': ('V/(m/s)', 'theta_2 min and max'), 'viscous_adaptation': ('V s/m^2', 'Gamma of theta_2'), 'coulomb': ('V', 'initial estimate of theta_3 = A_f'), 'coulomb_bounds': ('V', 'theta_3 min and max'), 'coulomb_adaptation': ('V/m', 'Gamma of theta_3'), 'coulomb_width': ('m/s', 'of S_f(v) = (2/pi) atan(v / width) (eq. 2)'), 'disturbance': ('V', 'initial estimate of d_n = -theta_5'), 'disturbance_bounds': ('V', 'd_n min and max'), 'disturbance_adaptation': ('V/m', 'Gamma of theta_5'), 'cogging_pitch': ('m', 'P of the harmonics and of the knots'), 'cogging_harmonics': ('1', 'those compensated; empty = no cogging compensation'), 'cogging_order': ('1', 'k of the B-splines (eq. 6)'), 'cogging_origin': ('m', 'first knot inside the travel'), 'cogging_control_points': ('1', 'm of the B-splines; 1 = periodic, amplitudes constant along the travel'), 'cogging_bounds': ('V', 'min and max of every entry of theta_4b = A_r'), 'cogging_adaptation': ('V/m', 'Gamma of every entry of A_r'), 'cogging_estimates': ('V', 'initial A_r, one control point after the other; empty = zeros'), 'epsilon': ('V m/s', 'of the robust term u_s2 (eq. 20, 30); 0 = no such term'), 'disturbance_bound': ('V', 'delta_d of eq. 12, for u_s2'), 'command_limit': ('V', 'largest command; 0 = none')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, sample_rate: typing.SupportsFloat | typing.SupportsIndex = 5000.0, error_gain: typing.SupportsFloat | typing.SupportsIndex = 200.0, feedback_gain: typing.SupportsFloat | typing.SupportsIndex = 48.0, mass: typing.SupportsFloat | typing.SupportsIndex = 0.12, mass_bounds: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"] = [0.1, 0.2], mass_adaptation: typing.SupportsFloat | typing.SupportsIndex = 0.0, viscous: typing.SupportsFloat | typing.SupportsIndex = 0.0, viscous_bounds: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"] = [0.0, 1.0], viscous_adaptation: typing.SupportsFloat | typing.SupportsIndex = 0.0, coulomb: typing.SupportsFloat | typing.SupportsIndex = 0.0, coulomb_bounds: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"] = [0.0, 1.0], coulomb_adaptation: typing.SupportsFloat | typing.SupportsIndex = 0.0, coulomb_width: typing.SupportsFloat | typing.SupportsIndex = 0.0011111111111111111, disturbance: typing.SupportsFloat | typing.SupportsIndex = 0.0, disturbance_bounds: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"] = [-1.0, 1.0], disturbance_adaptation: typing.SupportsFloat | typing.SupportsIndex = 0.0, cogging_pitch: typing.SupportsFloat | typing.SupportsIndex = 0.05, cogging_harmonics: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex] = [], cogging_order: typing.SupportsInt | typing.SupportsIndex = 3, cogging_origin: typing.SupportsFloat | typing.SupportsIndex = 0.0, cogging_control_points: typing.SupportsInt | typing.SupportsIndex = 1, cogging_bounds: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"] = [-0.1, 0.1], cogging_adaptation: typing.SupportsFloat | typing.SupportsIndex = 0.0, cogging_estimates: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [], epsilon: typing.SupportsFloat | typing.SupportsIndex = 0.0, disturbance_bound: typing.SupportsFloat | typing.SupportsIndex = 0.0, command_limit: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> AdaptiveRobustParameters:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def cogging_adaptation(self) -> float:
        """
        Gamma of every entry of A_r, V/m
        """
    @property
    def cogging_bounds(self) -> typing.Annotated[list[float], "FixedSize(2)"]:
        """
        min and max of every entry of theta_4b = A_r, V
        """
    @property
    def cogging_control_points(self) -> int:
        """
        m of the B-splines; 1 = periodic, amplitudes constant along the travel, 1
        """
    @property
    def cogging_estimates(self) -> list[float]:
        """
        initial A_r, one control point after the other; empty = zeros, V
        """
    @property
    def cogging_harmonics(self) -> list[int]:
        """
        those compensated; empty = no cogging compensation, 1
        """
    @property
    def cogging_order(self) -> int:
        """
        k of the B-splines (eq. 6), 1
        """
    @property
    def cogging_origin(self) -> float:
        """
        first knot inside the travel, m
        """
    @property
    def cogging_pitch(self) -> float:
        """
        P of the harmonics and of the knots, m
        """
    @property
    def command_limit(self) -> float:
        """
        largest command; 0 = none, V
        """
    @property
    def coulomb(self) -> float:
        """
        initial estimate of theta_3 = A_f, V
        """
    @property
    def coulomb_adaptation(self) -> float:
        """
        Gamma of theta_3, V/m
        """
    @property
    def coulomb_bounds(self) -> typing.Annotated[list[float], "FixedSize(2)"]:
        """
        theta_3 min and max, V
        """
    @property
    def coulomb_width(self) -> float:
        """
        of S_f(v) = (2/pi) atan(v / width) (eq. 2), m/s
        """
    @property
    def disturbance(self) -> float:
        """
        initial estimate of d_n = -theta_5, V
        """
    @property
    def disturbance_adaptation(self) -> float:
        """
        Gamma of theta_5, V/m
        """
    @property
    def disturbance_bound(self) -> float:
        """
        delta_d of eq. 12, for u_s2, V
        """
    @property
    def disturbance_bounds(self) -> typing.Annotated[list[float], "FixedSize(2)"]:
        """
        d_n min and max, V
        """
    @property
    def epsilon(self) -> float:
        """
        of the robust term u_s2 (eq. 20, 30); 0 = no such term, V m/s
        """
    @property
    def error_gain(self) -> float:
        """
        k_1 of p = e' + k_1 e (eq. 15), 1/s
        """
    @property
    def feedback_gain(self) -> float:
        """
        k_s1 of u_s1 = -k_s1 p (eq. 19, 27), V/(m/s)
        """
    @property
    def mass(self) -> float:
        """
        initial estimate of theta_1 = M, V/(m/s^2)
        """
    @property
    def mass_adaptation(self) -> float:
        """
        Gamma of theta_1, V/(m/s^2)/(V m/s) m/s
        """
    @property
    def mass_bounds(self) -> typing.Annotated[list[float], "FixedSize(2)"]:
        """
        theta_1 min and max (eq. 11), V/(m/s^2)
        """
    @property
    def sample_rate(self) -> float:
        """
        samples a second, Hz
        """
    @property
    def viscous(self) -> float:
        """
        initial estimate of theta_2 = B, V/(m/s)
        """
    @property
    def viscous_adaptation(self) -> float:
        """
        Gamma of theta_2, V s/m^2
        """
    @property
    def viscous_bounds(self) -> typing.Annotated[list[float], "FixedSize(2)"]:
        """
        theta_2 min and max, V/(m/s)
        """
class Arc:
    """
    Adaptive robust control (Lu et al. 2008, eq. 15 to 23).
    
    u = -phi^T theta_hat - k_s1 p + u_s2 with p = e' + k_1 e, the regressor phi at the measured state;
    theta_hat' = Proj(Gamma phi p), one Euler step a sample. Estimates: mass, viscous, coulomb, d_n, then A_r.
    
    A sample is refused whose reading or reference is not finite, or 1e12 and more: the last command is held, cut at
    `command_limit` (0 V before the first), what it knows from readings stays, and `samples_refused` counts it. Differences
    of the next reading are taken over all samples that have passed.
    
    Example:
        >>> controller = cogging.Arc(cogging.Arc.PARAMETERS(sample_rate=2000.0))
        >>> controller.sample_rate
        2000.0
    """
    NAME: typing.ClassVar[str] = 'arc'
    __hash__: typing.ClassVar[None] = None
    PARAMETERS = AdaptiveRobustParameters
    def __copy__(self) -> Arc:
        ...
    def __deepcopy__(self, memo: dict) -> Arc:
        ...
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> tuple[AdaptiveRobustParameters, list[float]]:
        ...
    def __init__(self, parameters: AdaptiveRobustParameters) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: tuple) -> None:
        ...
    @typing.overload
    def command(self, *, reference: typing.SupportsFloat | typing.SupportsIndex, reference_velocity: typing.SupportsFloat | typing.SupportsIndex = 0.0, reference_acceleration: typing.SupportsFloat | typing.SupportsIndex = 0.0, reading: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        The command (V) of this sample from reference (m, m/s, m/s^2) and encoder reading (m).
        """
    @typing.overload
    def command(self, reference: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], reading: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        The command (V) of this sample from reference (m, m/s, m/s^2) and encoder reading (m).
        """
    def copy(self) -> Arc:
        """
        A controller in the same state.
        """
    def update(self, applied: typing.SupportsFloat | typing.SupportsIndex) -> None:
        """
        Ends the sample: the command (V) that was really applied; one that is not finite is taken to have been its own, cut at the limit.
        """
    @property
    def estimates(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        What it believes now, (p,): a copy; empty for a controller that does not adapt.
        """
    @property
    def parameters(self) -> AdaptiveRobustParameters:
        ...
    @property
    def sample_rate(self) -> float:
        """
        Hz
        """
    @property
    def samples_refused(self) -> int:
        """
        How many samples were refused so far, for a reading or a reference that is not finite.
        """
class Dcarc:
    """
    Desired compensation adaptive robust control (Lu et al. 2008, eq. 24 to 30).
    
    As Arc, with the regressor on the reference in place of the measured state. Estimates: mass, viscous, coulomb, d_n,
    then A_r.
    
    A sample is refused whose reading or reference is not finite, or 1e12 and more: the last command is held, cut at
    `command_limit` (0 V before the first), what it knows from readings stays, and `samples_refused` counts it. Differences
    of the next reading are taken over all samples that have passed.
    
    Example:
        >>> controller = cogging.Dcarc(cogging.Dcarc.PARAMETERS(sample_rate=2000.0))
        >>> controller.sample_rate
        2000.0
    """
    NAME: typing.ClassVar[str] = 'dcarc'
    __hash__: typing.ClassVar[None] = None
    PARAMETERS = AdaptiveRobustParameters
    def __copy__(self) -> Dcarc:
        ...
    def __deepcopy__(self, memo: dict) -> Dcarc:
        ...
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> tuple[AdaptiveRobustParameters, list[float]]:
        ...
    def __init__(self, parameters: AdaptiveRobustParameters) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: tuple) -> None:
        ...
    @typing.overload
    def command(self, *, reference: typing.SupportsFloat | typing.SupportsIndex, reference_velocity: typing.SupportsFloat | typing.SupportsIndex = 0.0, reference_acceleration: typing.SupportsFloat | typing.SupportsIndex = 0.0, reading: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        The command (V) of this sample from reference (m, m/s, m/s^2) and encoder reading (m).
        """
    @typing.overload
    def command(self, reference: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], reading: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        The command (V) of this sample from reference (m, m/s, m/s^2) and encoder reading (m).
        """
    def copy(self) -> Dcarc:
        """
        A controller in the same state.
        """
    def update(self, applied: typing.SupportsFloat | typing.SupportsIndex) -> None:
        """
        Ends the sample: the command (V) that was really applied; one that is not finite is taken to have been its own, cut at the limit.
        """
    @property
    def estimates(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        What it believes now, (p,): a copy; empty for a controller that does not adapt.
        """
    @property
    def parameters(self) -> AdaptiveRobustParameters:
        ...
    @property
    def sample_rate(self) -> float:
        """
        Hz
        """
    @property
    def samples_refused(self) -> int:
        """
        How many samples were refused so far, for a reading or a reference that is not finite.
        """
class OutputFeedbackArcParameters:
    """
    Observer, gains, bounds and robust terms of an OutputFeedbackArc (Xu and Yao 2001, eq. 8 to 50).
    
    Fields:
        sample_rate (Hz): samples a second
        observer_gain_1 (1/s): k_1 of A_0 (eq. 10)
        observer_gain_2 (1/s^2): k_2 of A_0 (eq. 10)
        theta: initial estimates of 1/M, B/M, d_n/M
        theta_min: lower bounds (eq. 8)
        theta_max: upper bounds (eq. 8)
        adaptation: diagonal of Gamma (eq. 19); 0 = no adaptation
        weight_1: w_1 (eq. 30)
        weight_2: w_2 (eq. 41)
        gain_1 (1/s): g_1 (eq. 28)
        gain_2 (1/s): g_2 (eq. 43)
        epsilon_11: of alpha_1s2 (eq. 33)
        epsilon_12: of alpha_1s3 (eq. 35)
        epsilon_21: of u_s2 (eq. 46)
        epsilon_22: of u_s3 (eq. 46)
        c_phi_1: diagonal of C_phi1 (eq. 28)
        c_phi_2: diagonal of C_phi2 (eq. 43)
        c_theta_2: diagonal of C_theta2 (eq. 43)
        use_alpha_1s2: robust term against parameters, step 1 (eq. 37)
        use_alpha_1s3: robust term against estimation errors, step 1 (eq. 38)
        use_c_phi_1: state-dependent part of k_1s (eq. 28)
        use_c_theta_2: part of k_2s with d alpha_1 / d theta_hat (eq. 43)
        use_c_phi_2: part of k_2s with phi_2 (eq. 43)
        use_u_s2: robust term against parameters, step 2 (eq. 47)
        use_u_s3: robust term against estimation errors, step 2 (eq. 47)
        robust_factor: common factor on the terms that are switched on
        coulomb (V): level of the friction compensation at reference velocity (eq. 5)
        coulomb_width (m/s): of its S(v); 0 = sgn
        filter_steps: "exact" for held inputs, or "euler"
        command_limit (V): largest command; 0 = none
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.OutputFeedbackArcParameters()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'sample_rate': ('Hz', 'samples a second'), 'observer_gain_1': ('1/s', 'k_1 of A_0 (eq. 10)'), 'observer_gain_2': ('1/s^2', 'k_2 of A_0 (eq. 10)'), 'theta': ('', 'initial estimates of 1/M, B/M, d_n/M'), 'theta_min': ('', 'lower bounds (eq. 8)'), 'theta_max': ('', 'upper bounds (eq. 8)'), 'adaptation': ('', 'diagonal of Gamma (eq. 19); 0 = no adaptation'), 'weight_1': ('1', 'w_1 (eq. 30)'), 'weight_2': ('1', 'w_2 (eq. 41)'), 'gain_1': ('1/s', 'g_1 (eq. 28)'), 'gain_2': ('1/s', 'g_2 (eq. 43)'), 'epsilon_11': ('', 'of alpha_1s2 (eq. 33)'), 'epsilon_12': ('', 'of alpha_1s3 (eq. 35)'), 'epsilon_21': ('', 'of u_s2 (eq. 46)'), 'epsilon_22': ('', 'of u_s3 (eq. 46)'), 'c_phi_1': ('', 'diagonal of C_phi1 (eq. 28)'), 'c_phi_2': ('', 'diagonal of C_phi2 (eq. 43)'), 'c_theta_2': ('', 'diagonal of C_theta2 (eq. 43)'), 'use_alpha_1s2': ('', 'robust term against parameters, step 1 (eq. 37)'), 'use_alpha_1s3': ('', 'robust term against estimation errors, step 1 (eq. 38)'), 'use_c_phi_1': ('', 'state-dependent part of k_1s (eq. 28)'), 'use_c_theta_2': ('', 'part of k_2s with d alpha_1 / d theta_hat (eq. 43)'), 'use_c_phi_2': ('', 'part of k_2s with phi_2 (eq. 43)'), 'use_u_s2': ('', 'robust term against parameters, step 2 (eq. 47)'), 'use_u_s3': ('', 'robust term against estimation errors, step 2 (eq. 47)'), 'robust_factor': ('1', 'common factor on the terms that are switched on'), 'coulomb': ('V', 'level of the friction compensation at reference velocity (eq. 5)'), 'coulomb_width': ('m/s', 'of its S(v); 0 = sgn'), 'filter_steps': ('', '"exact" for held inputs, or "euler"'), 'command_limit': ('V', 'largest command; 0 = none')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, sample_rate: typing.SupportsFloat | typing.SupportsIndex = 2500.0, observer_gain_1: typing.SupportsFloat | typing.SupportsIndex = 400.0, observer_gain_2: typing.SupportsFloat | typing.SupportsIndex = 40000.0, theta: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [30.0, 10.0, 0.0], theta_min: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [8.3, 2.4, -50.0], theta_max: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [50.0, 17.5, 50.0], adaptation: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [500000.0, 300000.0, 2000000.0], weight_1: typing.SupportsFloat | typing.SupportsIndex = 1.0, weight_2: typing.SupportsFloat | typing.SupportsIndex = 0.1, gain_1: typing.SupportsFloat | typing.SupportsIndex = 600.0, gain_2: typing.SupportsFloat | typing.SupportsIndex = 850.0, epsilon_11: typing.SupportsFloat | typing.SupportsIndex = 5e-05, epsilon_12: typing.SupportsFloat | typing.SupportsIndex = 5e-05, epsilon_21: typing.SupportsFloat | typing.SupportsIndex = 0.001, epsilon_22: typing.SupportsFloat | typing.SupportsIndex = 1.0, c_phi_1: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [5e-05, 5e-06, 0.0001], c_phi_2: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [5e-05, 5e-06, 0.0001], c_theta_2: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [100000.0, 100000.0, 100000.0], use_alpha_1s2: bool = False, use_alpha_1s3: bool = False, use_c_phi_1: bool = False, use_c_theta_2: bool = False, use_c_phi_2: bool = False, use_u_s2: bool = False, use_u_s3: bool = False, robust_factor: typing.SupportsFloat | typing.SupportsIndex = 1.0, coulomb: typing.SupportsFloat | typing.SupportsIndex = 0.0, coulomb_width: typing.SupportsFloat | typing.SupportsIndex = 0.0, filter_steps: str = 'exact', command_limit: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> OutputFeedbackArcParameters:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def adaptation(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        diagonal of Gamma (eq. 19); 0 = no adaptation
        """
    @property
    def c_phi_1(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        diagonal of C_phi1 (eq. 28)
        """
    @property
    def c_phi_2(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        diagonal of C_phi2 (eq. 43)
        """
    @property
    def c_theta_2(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        diagonal of C_theta2 (eq. 43)
        """
    @property
    def command_limit(self) -> float:
        """
        largest command; 0 = none, V
        """
    @property
    def coulomb(self) -> float:
        """
        level of the friction compensation at reference velocity (eq. 5), V
        """
    @property
    def coulomb_width(self) -> float:
        """
        of its S(v); 0 = sgn, m/s
        """
    @property
    def epsilon_11(self) -> float:
        """
        of alpha_1s2 (eq. 33)
        """
    @property
    def epsilon_12(self) -> float:
        """
        of alpha_1s3 (eq. 35)
        """
    @property
    def epsilon_21(self) -> float:
        """
        of u_s2 (eq. 46)
        """
    @property
    def epsilon_22(self) -> float:
        """
        of u_s3 (eq. 46)
        """
    @property
    def filter_steps(self) -> str:
        """
        "exact" for held inputs, or "euler"
        """
    @property
    def gain_1(self) -> float:
        """
        g_1 (eq. 28), 1/s
        """
    @property
    def gain_2(self) -> float:
        """
        g_2 (eq. 43), 1/s
        """
    @property
    def observer_gain_1(self) -> float:
        """
        k_1 of A_0 (eq. 10), 1/s
        """
    @property
    def observer_gain_2(self) -> float:
        """
        k_2 of A_0 (eq. 10), 1/s^2
        """
    @property
    def robust_factor(self) -> float:
        """
        common factor on the terms that are switched on, 1
        """
    @property
    def sample_rate(self) -> float:
        """
        samples a second, Hz
        """
    @property
    def theta(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        initial estimates of 1/M, B/M, d_n/M
        """
    @property
    def theta_max(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        upper bounds (eq. 8)
        """
    @property
    def theta_min(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        lower bounds (eq. 8)
        """
    @property
    def use_alpha_1s2(self) -> bool:
        """
        robust term against parameters, step 1 (eq. 37)
        """
    @property
    def use_alpha_1s3(self) -> bool:
        """
        robust term against estimation errors, step 1 (eq. 38)
        """
    @property
    def use_c_phi_1(self) -> bool:
        """
        state-dependent part of k_1s (eq. 28)
        """
    @property
    def use_c_phi_2(self) -> bool:
        """
        part of k_2s with phi_2 (eq. 43)
        """
    @property
    def use_c_theta_2(self) -> bool:
        """
        part of k_2s with d alpha_1 / d theta_hat (eq. 43)
        """
    @property
    def use_u_s2(self) -> bool:
        """
        robust term against parameters, step 2 (eq. 47)
        """
    @property
    def use_u_s3(self) -> bool:
        """
        robust term against estimation errors, step 2 (eq. 47)
        """
    @property
    def weight_1(self) -> float:
        """
        w_1 (eq. 30), 1
        """
    @property
    def weight_2(self) -> float:
        """
        w_2 (eq. 41), 1
        """
class OutputFeedbackArc:
    """
    Output-feedback adaptive robust control (Xu and Yao 2001).
    
    u = u* + coulomb S(reference velocity): filters (18), state estimate (13), two backstepping steps (25) to (47),
    adaptation (50) with projection. theta = [1/M, B/M, d_n/M]. Positions count from the first reading. The
    filters of the applied command go on through samples that are refused; that of the readings makes up for them behind.
    
    A sample is refused whose reading or reference is not finite, or 1e12 and more: the last command is held, cut at
    `command_limit` (0 V before the first), what it knows from readings stays, and `samples_refused` counts it. Differences
    of the next reading are taken over all samples that have passed.
    
    Example:
        >>> controller = cogging.OutputFeedbackArc(cogging.OutputFeedbackArc.PARAMETERS(sample_rate=2000.0))
        >>> controller.sample_rate
        2000.0
    """
    NAME: typing.ClassVar[str] = 'output_feedback_arc'
    __hash__: typing.ClassVar[None] = None
    PARAMETERS = OutputFeedbackArcParameters
    def __copy__(self) -> OutputFeedbackArc:
        ...
    def __deepcopy__(self, memo: dict) -> OutputFeedbackArc:
        ...
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> tuple[OutputFeedbackArcParameters, list[float]]:
        ...
    def __init__(self, parameters: OutputFeedbackArcParameters) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: tuple) -> None:
        ...
    @typing.overload
    def command(self, *, reference: typing.SupportsFloat | typing.SupportsIndex, reference_velocity: typing.SupportsFloat | typing.SupportsIndex = 0.0, reference_acceleration: typing.SupportsFloat | typing.SupportsIndex = 0.0, reading: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        The command (V) of this sample from reference (m, m/s, m/s^2) and encoder reading (m).
        """
    @typing.overload
    def command(self, reference: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], reading: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        The command (V) of this sample from reference (m, m/s, m/s^2) and encoder reading (m).
        """
    def copy(self) -> OutputFeedbackArc:
        """
        A controller in the same state.
        """
    def update(self, applied: typing.SupportsFloat | typing.SupportsIndex) -> None:
        """
        Ends the sample: the command (V) that was really applied; one that is not finite is taken to have been its own, cut at the limit.
        """
    def velocity_state(self, theta: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"]) -> float:
        """
        x_2 hat of eq. 13 for a theta: exact for the true one without disturbance.
        """
    def virtual_control(self, *, position: typing.SupportsFloat | typing.SupportsIndex, eta_1: typing.SupportsFloat | typing.SupportsIndex, eta_2: typing.SupportsFloat | typing.SupportsIndex, psi_2: typing.SupportsFloat | typing.SupportsIndex, reference: typing.SupportsFloat | typing.SupportsIndex, reference_velocity: typing.SupportsFloat | typing.SupportsIndex, theta: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"]) -> dict[str, float]:
        """
        alpha_1 (eq. 25, 27) as `value`, and its partial derivatives by the name of the argument.
        """
    @property
    def estimates(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        What it believes now, (p,): a copy; empty for a controller that does not adapt.
        """
    @property
    def filters(self) -> typing.Annotated[list[float], "FixedSize(6)"]:
        """
        eta, lambda, psi: array of six
        """
    @property
    def parameters(self) -> OutputFeedbackArcParameters:
        ...
    @property
    def sample_rate(self) -> float:
        """
        Hz
        """
    @property
    def samples_refused(self) -> int:
        """
        How many samples were refused so far, for a reading or a reference that is not finite.
        """
    @property
    def z_1(self) -> float:
        """
        y - q_d of the last sample, m
        """
    @property
    def z_2(self) -> float:
        """
        lambda_2 - alpha_1 of the last sample
        """
class ObserverBasedParameters:
    """
    Periods and gains of an ObserverBased (Malaize and Levine 2009, eq. 2, 6, 8).
    
    Fields:
        sample_rate (Hz): samples a second
        periods (m): spatial periods P_n that are cancelled (eq. 2)
        observer_gain: K (eq. 6): of x (1/s), nu (1/s^2), lambda_0 and each period's sine and cosine (1/s^3)
        observer_gain_slope: K grows by |nu*| (m/s) times this; empty = constant
        position_gain (1/s^2): L_x = omega^2 (section IV.C)
        velocity_gain (1/s): L_nu = 2 xi omega - mu
        mass (V/(m/s^2)): by which accelerations become commands
        viscous (1/s): mu (eq. 1)
        velocity_min (m/s): below this |nu*| the harmonics are frozen
        delay (s): from reading to acting command; feedforward looks ahead by it
        rotation: harmonics turn with the "reference" (the paper) or the "measured" position
        command_limit (V): largest command; 0 = none
    
    Raises:
        ValueError: a value breaks its rule; the message names field, rule and value.
    
    Example:
        >>> one = cogging.ObserverBasedParameters()
        >>> one.replace(**one.to_dict()) == one
        True
    """
    FIELDS: typing.ClassVar[dict] = {'sample_rate': ('Hz', 'samples a second'), 'periods': ('m', 'spatial periods P_n that are cancelled (eq. 2)'), 'observer_gain': ('', "K (eq. 6): of x (1/s), nu (1/s^2), lambda_0 and each period's sine and cosine (1/s^3)"), 'observer_gain_slope': ('', 'K grows by |nu*| (m/s) times this; empty = constant'), 'position_gain': ('1/s^2', 'L_x = omega^2 (section IV.C)'), 'velocity_gain': ('1/s', 'L_nu = 2 xi omega - mu'), 'mass': ('V/(m/s^2)', 'by which accelerations become commands'), 'viscous': ('1/s', 'mu (eq. 1)'), 'velocity_min': ('m/s', 'below this |nu*| the harmonics are frozen'), 'delay': ('s', 'from reading to acting command; feedforward looks ahead by it'), 'rotation': ('', 'harmonics turn with the "reference" (the paper) or the "measured" position'), 'command_limit': ('V', 'largest command; 0 = none')}
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> dict:
        ...
    def __init__(self, *, sample_rate: typing.SupportsFloat | typing.SupportsIndex = 10000.0, periods: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [0.024], observer_gain: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [300.0, 30000.0, 1000000.0, 0.0, 0.0], observer_gain_slope: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [], position_gain: typing.SupportsFloat | typing.SupportsIndex = 14400.0, velocity_gain: typing.SupportsFloat | typing.SupportsIndex = 239.0, mass: typing.SupportsFloat | typing.SupportsIndex = 1.0, viscous: typing.SupportsFloat | typing.SupportsIndex = 0.0, velocity_min: typing.SupportsFloat | typing.SupportsIndex = 0.0, delay: typing.SupportsFloat | typing.SupportsIndex = 0.0, rotation: str = 'reference', command_limit: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: dict) -> None:
        ...
    def replace(self, **kwargs) -> ObserverBasedParameters:
        """
        A copy with the given fields changed.
        """
    def to_dict(self) -> dict:
        """
        All fields by name.
        """
    @property
    def command_limit(self) -> float:
        """
        largest command; 0 = none, V
        """
    @property
    def delay(self) -> float:
        """
        from reading to acting command; feedforward looks ahead by it, s
        """
    @property
    def mass(self) -> float:
        """
        by which accelerations become commands, V/(m/s^2)
        """
    @property
    def observer_gain(self) -> list[float]:
        """
        K (eq. 6): of x (1/s), nu (1/s^2), lambda_0 and each period's sine and cosine (1/s^3)
        """
    @property
    def observer_gain_slope(self) -> list[float]:
        """
        K grows by |nu*| (m/s) times this; empty = constant
        """
    @property
    def periods(self) -> list[float]:
        """
        spatial periods P_n that are cancelled (eq. 2), m
        """
    @property
    def position_gain(self) -> float:
        """
        L_x = omega^2 (section IV.C), 1/s^2
        """
    @property
    def rotation(self) -> str:
        """
        harmonics turn with the "reference" (the paper) or the "measured" position
        """
    @property
    def sample_rate(self) -> float:
        """
        samples a second, Hz
        """
    @property
    def velocity_gain(self) -> float:
        """
        L_nu = 2 xi omega - mu, 1/s
        """
    @property
    def velocity_min(self) -> float:
        """
        below this |nu*| the harmonics are frozen, m/s
        """
    @property
    def viscous(self) -> float:
        """
        mu (eq. 1), 1/s
        """
class ObserverBased:
    """
    Observer-based cancellation (Malaize and Levine 2009).
    
    Extended observer (6) of position, velocity, lambda_0 and each spatial period, and law (8); K from gains.design_observer.
    Positions only. Estimates: x_hat, nu_hat, lambda_0, then sine and cosine of each period. Behind more than 16 samples that
    were refused x_hat and nu_hat start anew from the readings at both ends.
    
    lambda_0 holds the dry friction. Of its reset the paper only says that it needs care; here it begins each motion with
    the last estimate of that direction in steady motion (of the other, turned, where that is the first), and each rest with
    the mean of both, which is without friction. What is learned at rest ends with it.
    
    A sample is refused whose reading or reference is not finite, or 1e12 and more: the last command is held, cut at
    `command_limit` (0 V before the first), what it knows from readings stays, and `samples_refused` counts it. Differences
    of the next reading are taken over all samples that have passed.
    
    Example:
        >>> controller = cogging.ObserverBased(cogging.ObserverBased.PARAMETERS(sample_rate=2000.0))
        >>> controller.sample_rate
        2000.0
    """
    NAME: typing.ClassVar[str] = 'observer_based'
    __hash__: typing.ClassVar[None] = None
    PARAMETERS = ObserverBasedParameters
    def __copy__(self) -> ObserverBased:
        ...
    def __deepcopy__(self, memo: dict) -> ObserverBased:
        ...
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> tuple[ObserverBasedParameters, list[float]]:
        ...
    def __init__(self, parameters: ObserverBasedParameters) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: tuple) -> None:
        ...
    def command(self, *, reference: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], ahead: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], reading: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        The command (V) of this sample from the reference now and `preview` s ahead (each m, m/s, m/s^2) and encoder reading (m).
        """
    def copy(self) -> ObserverBased:
        """
        A controller in the same state.
        """
    def update(self, applied: typing.SupportsFloat | typing.SupportsIndex) -> None:
        """
        Ends the sample: the command (V) that was really applied; one that is not finite is taken to have been its own, cut at the limit.
        """
    @property
    def estimates(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        What it believes now, (p,): a copy; empty for a controller that does not adapt.
        """
    @property
    def parameters(self) -> ObserverBasedParameters:
        ...
    @property
    def preview(self) -> float:
        """
        how far ahead the second reference is, s
        """
    @property
    def sample_rate(self) -> float:
        """
        Hz
        """
    @property
    def samples_refused(self) -> int:
        """
        How many samples were refused so far, for a reading or a reference that is not finite.
        """
class ControllerError(RuntimeError):
    """
    A controller of one's own raised, which is the cause of this, or gave a command that is no finite number.
    
    `row` of the run (from 0) and `time` (s) say when.
    """
    row: typing.ClassVar[int] = 0
    time: typing.ClassVar[float] = 0.0
class CompiledController:
    """
    A controller of compiled functions.
    
        double command(double* state, const double* parameters, const double* reference, double reading);
        void update(double* state, const double* parameters, double applied);
    
    `reference` holds position, velocity and acceleration (m, m/s, m/s^2), `reading` is in m, commands in V. A run starts
    from the state given here, has a state of its own, and calls the functions without Python's lock: in a batch on many
    threads at once, so that what is not in their state must not be written. They must not raise.
    
    Args:
        command, update: of numba, `@numba.cfunc(cogging.CompiledController.COMMAND)` and `.UPDATE`; or of ctypes, a
            function of a shared library. They are kept alive.
        sample_rate: Hz.
        state: V, m or whatever it means, (n,); with which a run begins.
        parameters: (p,), never written.
        command_limit: V, largest command; 0 = none.
    
    Raises:
        TypeError: what is no compiled function, or says that its signature is another.
        ValueError: a number breaks its rule; the message names field, rule and value.
    """
    COMMAND: typing.ClassVar[str] = 'float64(CPointer(float64), CPointer(float64), CPointer(float64), float64)'
    UPDATE: typing.ClassVar[str] = 'void(CPointer(float64), CPointer(float64), float64)'
    __hash__: typing.ClassVar[None] = None
    def __copy__(self) -> CompiledController:
        ...
    def __deepcopy__(self, memo: dict) -> CompiledController:
        ...
    def __eq__(self, arg0: CompiledController) -> bool:
        ...
    def __init__(self, command: typing.Any, *, update: typing.Any = None, sample_rate: typing.SupportsFloat | typing.SupportsIndex, state: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [], parameters: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [], command_limit: typing.SupportsFloat | typing.SupportsIndex = 0.0) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def command(self, reference: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], reading: typing.SupportsFloat | typing.SupportsIndex) -> float:
        """
        The command (V) of this sample from reference (m, m/s, m/s^2) and encoder reading (m).
        """
    def copy(self) -> CompiledController:
        """
        A controller in the same state.
        """
    def reset(self) -> None:
        """
        Back to the state with which a run begins.
        """
    def update(self, applied: typing.SupportsFloat | typing.SupportsIndex) -> None:
        """
        Ends the sample: the command (V) that was really applied.
        """
    @property
    def command_limit(self) -> float:
        """
        V; 0 = none
        """
    @property
    def estimates(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Its state now, (n,): a copy.
        """
    @property
    def parameters(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (p,): a copy
        """
    @property
    def sample_rate(self) -> float:
        """
        Hz
        """
class StopFlag:
    """
    What ends the work of the core in other threads than Python's main one.
    
    Python tells its main thread alone of Ctrl-C. A thread that heeds a flag raises KeyboardInterrupt out of the core within
    milliseconds after another thread has set it.
    """
    def __init__(self) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def heed(self) -> None:
        """
        Heed this flag, and no other, in the calling thread.
        """
    def set(self) -> None:
        """
        End what the threads that heed this flag do in the core, now and later.
        """
class Performance:
    """
    The indexes of one run: what `performance` gives.
    
    Example:
        >>> print(f"{cogging.performance(log.time, log.error, log.command).command_rms:.3f} V")
        0.421 V
    """
    __hash__: typing.ClassVar[None] = None
    def __eq__(self, other: typing.Any) -> bool:
        ...
    def __getstate__(self) -> typing.Annotated[list[float], "FixedSize(6)"]:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def __repr__(self) -> str:
        ...
    def __setstate__(self, arg0: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(6)"]) -> None:
        ...
    @property
    def command_change_rms(self) -> float:
        """
        rms of u_k - u_(k-1), V
        """
    @property
    def command_chatter(self) -> float:
        """
        command_change_rms / command_rms
        """
    @property
    def command_rms(self) -> float:
        """
        sqrt(mean u^2), V
        """
    @property
    def error_final_max(self) -> float:
        """
        max |e| in the final window, m
        """
    @property
    def error_max(self) -> float:
        """
        max |e|, m
        """
    @property
    def error_rms(self) -> float:
        """
        sqrt(mean e^2), m
        """
class Prediction:
    """
    A prediction along a log, with its slopes: what `propagate` needs.
    """
    def __reduce__(self) -> typing.Any:
        ...
    @property
    def innovation(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        m, reading less what was foreseen
        """
    @property
    def middle_position(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        m, half-way to the next row
        """
    @property
    def middle_velocity(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        m/s, half-way to the next row
        """
    @property
    def moving(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        1, or 0 where the axis sticks
        """
    @property
    def position(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        m, corrected
        """
    @property
    def velocity(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        m/s, corrected
        """
class PlantAlong:
    """
    A plant along its prediction on a log, to which effects are added.
    
    What all effects need of the plant is worked out once, when the first asks for it.
    """
    def __reduce__(self) -> typing.Any:
        ...
    def added(self, effects: collections.abc.Sequence[effects.ConstantForce | effects.CableSpring | effects.EndEffect | effects.LocalForce | effects.Gravity | effects.CoggingHarmonic | effects.CoggingModulation | effects.CoulombAsymmetry | effects.ViscousAsymmetry | effects.StribeckFriction | effects.PreslidingFriction | effects.PositionDependentFriction | effects.QuadraticDrag | effects.ForceConstantRipple | effects.ForceConstantDrift | effects.CommandDelay | effects.ActuatorLag | effects.CommandSaturation | effects.CommandDeadZone | effects.EncoderPeriodicError | effects.EncoderScaleError | effects.Backlash | effects.FlexibleMode | effects.DisturbanceStep | effects.DisturbanceTone | effects.EmpiricalForce | effects.OwnLaws], sizes: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], *, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.float64]:
        """
        As Predictor.added.
        """
class Predictor:
    """
    One step ahead along a log.
    
    The plant is driven by the recorded command and held to the recorded position by an observer with both poles at
    exp(-2 pi bandwidth Ts); the innovation (m) is what the model did not foresee. Of a load with play it is the mean over
    gaps 0.7 to 1.3 of the one that is meant: when it strikes hangs on forces that no model has. Time steps may differ;
    after one longer than `gap` (s) the observer starts anew.
    
    Raises:
        ValueError: columns of different lengths, time that does not increase, a NaN or an infinity in one of them, a
            bandwidth that is not positive.
    """
    @staticmethod
    def is_addable(plant: Plant, effect: effects.ConstantForce | effects.CableSpring | effects.EndEffect | effects.LocalForce | effects.Gravity | effects.CoggingHarmonic | effects.CoggingModulation | effects.CoulombAsymmetry | effects.ViscousAsymmetry | effects.StribeckFriction | effects.PreslidingFriction | effects.PositionDependentFriction | effects.QuadraticDrag | effects.ForceConstantRipple | effects.ForceConstantDrift | effects.CommandDelay | effects.ActuatorLag | effects.CommandSaturation | effects.CommandDeadZone | effects.EncoderPeriodicError | effects.EncoderScaleError | effects.Backlash | effects.FlexibleMode | effects.DisturbanceStep | effects.DisturbanceTone | effects.EmpiricalForce | effects.OwnLaws) -> bool:
        """
        Whether `added` can tell what an effect would add to a plant: no bristle, no error of the reading, no memory of its own beside a bristle or a load, and under friction no heavy load that rings long or has play.
        """
    def __init__(self, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], command: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], *, bandwidth: typing.SupportsFloat | typing.SupportsIndex = 30.0, gap: typing.SupportsFloat | typing.SupportsIndex = 1e+30, initial_velocity: typing.SupportsFloat | typing.SupportsIndex = 0.0, steps_per_sample: typing.SupportsInt | typing.SupportsIndex = 1) -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def added(self, along: Prediction, plant: Plant, effects: collections.abc.Sequence[effects.ConstantForce | effects.CableSpring | effects.EndEffect | effects.LocalForce | effects.Gravity | effects.CoggingHarmonic | effects.CoggingModulation | effects.CoulombAsymmetry | effects.ViscousAsymmetry | effects.StribeckFriction | effects.PreslidingFriction | effects.PositionDependentFriction | effects.QuadraticDrag | effects.ForceConstantRipple | effects.ForceConstantDrift | effects.CommandDelay | effects.ActuatorLag | effects.CommandSaturation | effects.CommandDeadZone | effects.EncoderPeriodicError | effects.EncoderScaleError | effects.Backlash | effects.FlexibleMode | effects.DisturbanceStep | effects.DisturbanceTone | effects.EmpiricalForce | effects.OwnLaws], sizes: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], *, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.float64]:
        """
        What each effect would add to the innovations of a plant (m, (p, n)) per size of it, to first order.
        
        Its own law is evaluated along the prediction of the plant and passed through the observer's loop: forces, friction
        levels and gains; the difference that a shape, a delay or a lag makes to the command that acts, with where in each
        interval it does; a load of its own by the deflection that the plant's net force causes.
        
        Args:
            along: prediction of `plant` on this log.
            plant: what the effects join, one at a time.
            effects: p of them.
            sizes: what each row is divided by, (p,), above 0.
        
        Raises:
            ValueError: an effect that is not addable (see is_addable) or not valid; sizes that are not one an effect.
        """
    def innovations(self, plants: collections.abc.Sequence[Plant], *, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.float64]:
        """
        Innovations (m) of many plants, (plants, n), on `threads` threads (0 = all cores).
        """
    def net_force(self, plants: collections.abc.Sequence[Plant], middle_position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], middle_velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], *, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.float64]:
        """
        Command that acts plus all forces (V) along a motion given half-way between rows, (plants, n).
        """
    def plant_along(self, along: Prediction, plant: Plant) -> PlantAlong:
        """
        A plant along its prediction on this log, for many calls of `added`.
        """
    def predict(self, plant: Plant) -> Prediction:
        """
        The prediction along the log, with slopes.
        """
    def propagate(self, along: Prediction, mass: typing.SupportsFloat | typing.SupportsIndex, forces: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], reading_errors: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None = None, *, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.float64]:
        """
        What small forces (V, (p, n)) and errors of the reading (m, (p, n)) add to the innovations (m, (p, n)).
        """
    def propagate_transposed(self, along: Prediction, mass: typing.SupportsFloat | typing.SupportsIndex, weight: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
        """
        The transpose of propagate: by how much forces (n,) and errors of the reading (n,) move sum(weight innovation).
        """
class NumberReader:
    """
    Columns of numbers out of separated text, block by block.
    
    separator: one character, " " = any run of blanks; fields: how many each line has; wanted: indexes of those to read,
    ascending, with a label each. Rows first_row to end_row (without) are kept; first_line numbers the first line that will
    come. Blank lines are skipped, a number may stand in quotes. Numbers have a decimal point, or all a decimal comma.
    
    Raises:
        ValueError: a line with other than `fields` fields, or a wanted one that is no finite number; names the line. A
            call while another thread is within one.
    """
    LINE_MAX: typing.ClassVar[int] = 16777216
    def __init__(self, *, separator: str, fields: typing.SupportsInt | typing.SupportsIndex, wanted: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], labels: collections.abc.Sequence[str], first_row: typing.SupportsInt | typing.SupportsIndex = 0, end_row: typing.SupportsInt | typing.SupportsIndex | None = None, first_line: typing.SupportsInt | typing.SupportsIndex = 1, expected_rows: typing.SupportsInt | typing.SupportsIndex = 0, decimal: str = '.') -> None:
        ...
    def __reduce__(self) -> typing.Any:
        ...
    def feed(self, block: bytes) -> None:
        """
        Take the next block of the file, which may end anywhere.
        """
    def finish(self) -> None:
        """
        Take what stands after the last line end.
        """
    def take(self) -> list[numpy.typing.NDArray[numpy.float64]]:
        """
        The columns, (n,) each, in the order of `wanted`; the reader is empty afterwards and may read on.
        """
    @property
    def done(self) -> bool:
        """
        whether the last wanted row has been read
        """
    @property
    def rows(self) -> int:
        """
        rows read since the start or the last `take`
        """
def autoregression(residual: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], counts: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], *, order: typing.SupportsInt | typing.SupportsIndex) -> list[float]:
    """
    Coefficients a (order,) of e_k = r_k - sum_i a_i r_(k-i) with the least rms of e.
    
    Yule and Walker's equations; rows with counts = 0 and pairs with one of them are left out.
    
    Raises:
        ValueError: lengths differ, order above a quarter of the rows, nothing that counts.
    """
def closed_loop(plant: Plant, controller: typing.Any, reference: Reference, *, duration: typing.SupportsFloat | typing.SupportsIndex = 0.0, seed: typing.SupportsInt | typing.SupportsIndex = 0, steps_per_sample: typing.SupportsInt | typing.SupportsIndex = 1, record_estimates: bool = False, initial_position: typing.SupportsFloat | typing.SupportsIndex | None = None, initial_velocity: typing.SupportsFloat | typing.SupportsIndex = 0.0, added_command: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None = None) -> dict[str, numpy.typing.NDArray[numpy.float64]]:
    """
    One closed-loop run: columns by name, arrays (n,); `estimates` is (n, p).
    
    A pure function: the controller given is copied, the noise comes from `seed`, the same call gives the same bits.
    duration (s): 0 = the reference's own end. Between samples the command is held and the axis integrated by Runge-Kutta
    steps of fourth order: `steps_per_sample`, or as many more as keep what they err by below 1e-6 of the motion. The axis
    starts at rest on the reference unless told otherwise.
    `added_command` (V, one entry a row) is added to what the controller computes, before the limit: test pulses.
    The controller is one of the core, a CompiledController, or any object that is a cogging.Controller, whose deep copy is
    called in every row with Python's lock held.
    
    Raises:
        TypeError, ValueError: the controller is none, cannot be copied, or states a sample rate or limit that is none.
        ValueError: the reference leaves the travel, a motion without an end and no duration, more samples than fit into
            memory, a delay as long as the run.
        ControllerError: a controller of Python's raised, or its command is no finite number; says when and in which row.
        DivergedError: the state left the travel by half its length, is not finite, or is so fast that a sample needs more
            than 1e5 steps; says when and where, or how fast.
    """
def closed_loop_records(plants: collections.abc.Sequence[Plant], controllers: collections.abc.Sequence[typing.Any], references: collections.abc.Sequence[Reference], *, durations: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], seeds: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], steps_per_sample: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex], threads: typing.SupportsInt | typing.SupportsIndex, start: typing.SupportsFloat | typing.SupportsIndex, stop: typing.SupportsFloat | typing.SupportsIndex, final_window: typing.SupportsFloat | typing.SupportsIndex, reductions: collections.abc.Sequence[tuple[str, str, typing.SupportsFloat | typing.SupportsIndex]], columns: collections.abc.Sequence[str], every: typing.SupportsInt | typing.SupportsIndex, keeps_refused: bool, initial_positions: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [], initial_velocity: typing.SupportsFloat | typing.SupportsIndex = 0.0, added_command: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex] = [], runs_in_all: typing.SupportsInt | typing.SupportsIndex = 0) -> dict:
    """
    Many runs on `threads` threads (0 = all cores) without their rows: what cogging.closed_loop_batch keeps.
    
    `values` (runs, 6 + reductions): the fields of Performance in order, then the reductions (quantity, kind, at); NaN where a
    run failed. `failures`: run, time (s), reason. `columns`: one list for each, an array a run, every so many rows.
    `in_lanes`: of each run whether it shared its steps with others of its course.
    `initial_positions` (m): one for all runs, one for each or none, where each starts on its reference; `added_command` (V,
    one entry a row or none) is added to what each controller computes, as by closed_loop.
    `runs_in_all`: of how many the caller will keep as much as of these, for which there must be room in memory.
    
    Raises:
        ValueError: a list of another length, what a run alone refuses, rows that do not fit into memory.
    """
def cogging_slope_max(basis: SplineHarmonics, amplitude: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    Bound on |d/dx A_r^T S_r(x)| (V/m) when every coefficient lies in [-amplitude, amplitude] (V).
    
    Args:
        basis: a SplineHarmonics.
        amplitude: V.
    
    Returns:
        The bound.
    
    Example:
        >>> basis = cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2])
        >>> print(f"{cogging.cogging_slope_max(basis, 0.1):.1f}")
        53.3
    """
def desired_compensation_condition(parameters: AdaptiveRobustParameters, *, friction_slope: typing.SupportsFloat | typing.SupportsIndex, cogging_slope: typing.SupportsFloat | typing.SupportsIndex) -> tuple[float, float]:
    """
    Smallest eigenvalue of the matrix (29) over the bounds and slopes, and the decay rate (1/s) it gives.
    
    Over mass, viscous and Coulomb bounds, 0 <= g_f <= friction_slope (1/(m/s)), |theta_4b^T g_r| <= cogging_slope (V/m).
    Above zero, V = M p^2 / 2 + M k_1^2 e^2 / 2 obeys V' <= -rate V + epsilon. At or below zero k_s1 is too small.
    
    Args:
        parameters: gains and bounds of Arc or Dcarc.
        friction_slope: the largest, 1/(m/s).
        cogging_slope: the largest, V/m.
    
    Returns:
        The eigenvalue and the rate.
    
    Example:
        >>> gains = cogging.AdaptiveRobustParameters(feedback_gain=48.0, error_gain=200.0, mass_bounds=[0.1, 0.14])
        >>> eigenvalue, rate = cogging.desired_compensation_condition(gains, friction_slope=0.0, cogging_slope=10.0)
        >>> print(f"{eigenvalue:.1f}, {rate:.0f} 1/s")
        20.0, 286 1/s
    """
def desired_compensation_matrix(*, feedback_gain: typing.SupportsFloat | typing.SupportsIndex, error_gain: typing.SupportsFloat | typing.SupportsIndex, mass: typing.SupportsFloat | typing.SupportsIndex, viscous: typing.SupportsFloat | typing.SupportsIndex, coulomb: typing.SupportsFloat | typing.SupportsIndex, friction_slope: typing.SupportsFloat | typing.SupportsIndex, cogging_slope: typing.SupportsFloat | typing.SupportsIndex) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[2, 2]"]:
    """
    The matrix of Lu et al. 2008, eq. 29, at one point: array (2, 2).
    
    Args:
        feedback_gain: k_s1, V/(m/s).
        error_gain: k_1, 1/s.
        mass, viscous, coulomb: theta_1 to theta_3, V/(m/s^2), V/(m/s), V.
        friction_slope: g_f of eq. 24, 1/(m/s).
        cogging_slope: theta_4b^T g_r of eq. 25, V/m.
    
    Returns:
        The matrix.
    
    Example:
        >>> axis = {"mass": 0.12, "viscous": 0.2, "coulomb": 0.0, "friction_slope": 0.0, "cogging_slope": 10.0}
        >>> matrix = cogging.desired_compensation_matrix(feedback_gain=48.0, error_gain=200.0, **axis)
        >>> bool(np.linalg.eigvalsh(matrix)[0] > 0.0)
        True
    """
def format_rows(columns: collections.abc.Sequence[typing.Annotated[numpy.typing.ArrayLike, numpy.float64]], first: typing.SupportsInt | typing.SupportsIndex, end: typing.SupportsInt | typing.SupportsIndex) -> bytes:
    """
    Rows first to end (without) of columns (n,) as comma-separated lines, every number to its last bit.
    """
def friction_slope_max(coulomb_width: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    Steepest slope of S(v) = (2/pi) atan(v / coulomb_width): 2 / (pi coulomb_width), 1/(m/s).
    
    Args:
        coulomb_width: m/s.
    
    Returns:
        The slope.
    
    Example:
        >>> print(f"{cogging.friction_slope_max(1.11e-3):.1f}")
        573.5
    """
def instruction_set() -> str:
    """
    The instruction set that closed_loop_batch uses: the widest of instruction_sets, or what the environment variable
    COGGING_INSTRUCTIONS names; "none": each run alone.
    
    Raises:
        ValueError: COGGING_INSTRUCTIONS names one that this machine lacks.
    """
def instruction_sets() -> dict[str, int]:
    """
    Instruction sets of this machine for which runs in packs were compiled, and how many runs a pack holds.
    """
def memory_left() -> float:
    """
    Bytes that this process may still take.
    
    What the machine has left, no more than control groups and the limit of addresses allow; where the system does not say,
    half of its memory, or 8 GiB.
    """
def performance(time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], error: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], command: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], *, start: typing.SupportsFloat | typing.SupportsIndex = ..., stop: typing.SupportsFloat | typing.SupportsIndex = ..., final_window: typing.SupportsFloat | typing.SupportsIndex = 2.0) -> Performance:
    """
    Indexes over the rows with start <= time < stop (s); arrays (n,): s, m, V.
    
    error_final_max looks at the last `final_window` seconds of them (Xu and Yao 2001, section 4.2).
    
    Args:
        time, error, command: of a log.
        start, stop: s.
        final_window: s.
    
    Returns:
        The indexes.
    
    Example:
        >>> last = cogging.performance(log.time, log.error, log.command, start=1.0)
        >>> last.error_rms < last.error_max
        True
    """
def project(rate: typing.SupportsFloat | typing.SupportsIndex, estimate: typing.SupportsFloat | typing.SupportsIndex, minimum: typing.SupportsFloat | typing.SupportsIndex, maximum: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    The adaptation rate, 0 where it would leave the bound (Lu et al. 2008, eq. 14).
    
    Args:
        rate: of the estimate, a second.
        estimate: as it is.
        minimum, maximum: of the estimate.
    
    Returns:
        The rate that is left.
    
    Example:
        >>> cogging.project(2.0, 1.0, 0.0, 1.0), cogging.project(-2.0, 1.0, 0.0, 1.0)
        (0.0, -2.0)
    """
def replay_controller(controller: typing.Any, *, time: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], reference: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], reference_velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None = None, reference_acceleration: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None = None, position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], applied: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None = None) -> numpy.typing.NDArray[numpy.float64]:
    """
    The commands (V, (n,)) that a controller gives for the references and readings of a log.
    
    Columns (n,): s, m, m/s, m/s^2, m, V. A missing derivative of the reference is differentiated. The controller is copied,
    called once a row whatever the times are, and told that its own command, cut at its limit, was applied, or what
    `applied` holds; one that looks ahead sees the reference interpolated between rows, at rest after the last.
    
    Raises:
        ValueError: fewer than three rows, time not strictly increasing, lengths that differ, a NaN.
    
    Example:
        >>> pid = cogging.Pid(cogging.PidParameters(kp=1000.0))
        >>> time, at_rest = 0.01 * np.arange(3), np.zeros(3)
        >>> cogging.replay_controller(pid, time=time, reference=at_rest, position=[0.0, 1e-6, -2e-6]).tolist()
        [0.0, -0.001, 0.002]
    """
def require_memory(name: str, bytes: typing.SupportsFloat | typing.SupportsIndex, what: str, value: str) -> None:
    """
    Refuse what would not fit into memory, before any of it is taken: over 64 MB, more than 0.8 of memory_left.
    
    Args:
        name: of the field that asks.
        bytes: that are asked.
        what: it is that takes them, in words.
        value: of the field.
    
    Raises:
        ValueError: names field, rule and value.
    """
def smooth_sign(velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], width: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    S(v) = (2/pi) atan(v / width), v and width in m/s; width = 0 is sgn(v), with sgn(0) = 0.
    """
def whiten(rows: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], coefficients: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], *, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.float64]:
    """
    e_k = r_k - sum_i a_i r_(k-i) of every row of (p, n); r is 0 before the first column.
    """
CONTROLLERS: dict = {'pid': Pid, 'cascade': Cascade, 'speed': Speed, 'arc': Arc, 'dcarc': Dcarc, 'output_feedback_arc': OutputFeedbackArc, 'observer_based': ObserverBased}
EFFECTS: dict = {'constant_force': effects.ConstantForce, 'cable_spring': effects.CableSpring, 'end_effect': effects.EndEffect, 'local_force': effects.LocalForce, 'gravity': effects.Gravity, 'cogging_harmonic': effects.CoggingHarmonic, 'cogging_modulation': effects.CoggingModulation, 'coulomb_asymmetry': effects.CoulombAsymmetry, 'viscous_asymmetry': effects.ViscousAsymmetry, 'stribeck_friction': effects.StribeckFriction, 'presliding_friction': effects.PreslidingFriction, 'position_dependent_friction': effects.PositionDependentFriction, 'quadratic_drag': effects.QuadraticDrag, 'force_constant_ripple': effects.ForceConstantRipple, 'force_constant_drift': effects.ForceConstantDrift, 'command_delay': effects.CommandDelay, 'actuator_lag': effects.ActuatorLag, 'command_saturation': effects.CommandSaturation, 'command_dead_zone': effects.CommandDeadZone, 'encoder_periodic_error': effects.EncoderPeriodicError, 'encoder_scale_error': effects.EncoderScaleError, 'backlash': effects.Backlash, 'flexible_mode': effects.FlexibleMode, 'disturbance_step': effects.DisturbanceStep, 'disturbance_tone': effects.DisturbanceTone, 'empirical_force': effects.EmpiricalForce}
REFERENCES: dict = {'point_to_point': PointToPoint, 'sine': Sine, 'filtered_sine': FilteredSine, 'sampled': Sampled}
