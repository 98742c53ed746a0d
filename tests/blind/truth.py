"""The truth: an axis under digital control, integrated by Heun's method between the samples.

It imports nothing of the package under test (a test walks the imports), and differs from it on purpose: another
integrator, other friction laws, force maps read from a fine table instead of a spline basis, exact stick-slip,
bristles, two masses, an actuator chain and an encoder with faults. All states are SI; forces are in the command unit.

One sample: read the encoder at the true instant, compute the command with Ts = 1 / rate, hold it, integrate
`substeps` steps of Heun to the next instant. Positive force pushes towards +x.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass

import numpy as np
from numba import njit

from .motions import Motion

_SCALARS = """
mass viscous coulomb width law bristle bristle_damping resolution x_start v_start
controller rate kp ki kd kv ff_mass ff_viscous ff_coulomb ff_width limit
coulomb_asymmetry viscous_asymmetry stribeck stribeck_velocity stribeck_exponent stribeck_shape drag drag_exponent
delay lag second_lag lag_damping saturation_up saturation_down saturation_soft saturation_knee
dead_zone dead_zone_shape
coupling load_ratio mode_frequency mode_damping hardening gap
hysteresis hysteresis_length hysteresis_period gain_speed
encoder_scale encoder_period encoder_sine encoder_cosine encoder_triangular
encoder_harmonics encoder_turn lost_at lost_counts share
"""
SCALARS = _SCALARS.split()  # of a plan, by name
#: Those that are not 0 in a plan at rest.
AT_REST = {"saturation_up": np.inf, "saturation_down": np.inf, "saturation_knee": 2.0, "drag_exponent": 2.0}
AT_REST |= {"stribeck_velocity": 0.01, "stribeck_exponent": 2.0, "width": 1e-3, "encoder_period": 1.0}
AT_REST |= {"hysteresis_length": 1e-3, "bristle": 1e-6}
#: Rows of a plan over the samples: reference, force (noise included), additions to gain, viscous and Coulomb, what is
#: added to the reading, and 1 where the amplifier misses the new command.
ROWS = ("position", "velocity", "acceleration", "force", "gain", "viscous", "coulomb", "reading", "held")
R_POSITION, R_VELOCITY, R_ACCELERATION, R_FORCE, R_GAIN, R_VISCOUS, R_COULOMB, R_READING, R_HELD = range(len(ROWS))

#: Maps of a plan over the travel: force, additions to Coulomb, viscous and gain, and force per squared command.
MAPS = ("force", "coulomb", "viscous", "gain", "reluctance")
M_FORCE, M_COULOMB, M_VISCOUS, M_GAIN, M_RELUCTANCE = range(len(MAPS))

#: Friction laws: what stands for the sign of the velocity.
LAWS = ("tanh", "algebraic", "arctangent", "bristle", "stick", "mixture", "ramp")
TANH, ALGEBRAIC, ARCTANGENT, BRISTLES, STICK, MIXTURE, RAMP = range(len(LAWS))
#: How friction above Coulomb falls with speed, and what becomes of small commands: forms of one cause.
STRIBECK_SHAPES = ("usual", "rational", "hyperbolic", "two_speeds")
DEAD_ZONES = ("usual", "one_sided", "rounded")
PID, CASCADE = 0, 1
RIGID, FLEXIBLE, BACKLASH = 0, 1, 2
GRID_STEP = 4e-5  # m, of the maps; cubic interpolation between


@dataclass
class Plan:
    """All that one run needs: scalars, instants, rows over the samples, maps over the travel.

    Attributes:
        scalars: by the names of SCALARS, one record, (1,).
        instants: true sampling instants, s, (n,).
        stamps: what the log says of them, s, (n,).
        rows: (n, len(ROWS)).
        grid_start: position of the maps' first point, m.
        maps: (len(MAPS), points), spaced by GRID_STEP.
        substeps: steps of Heun in one sample.
        force_noise, reading_noise: the part of the rows that is noise, (n,) each.
    """

    scalars: np.ndarray
    instants: np.ndarray
    stamps: np.ndarray
    rows: np.ndarray
    grid_start: float
    maps: np.ndarray
    substeps: int
    force_noise: np.ndarray
    reading_noise: np.ndarray

    @classmethod
    def empty(cls, instants: np.ndarray, travel: tuple[float, float], substeps: int = 10) -> Plan:
        """Make a plan at rest: no forces, infinite limits, no encoder faults."""
        margin = 0.05 * (travel[1] - travel[0]) + 4 * GRID_STEP
        points = int(np.ceil((travel[1] - travel[0] + 2 * margin) / GRID_STEP)) + 1
        scalars, maps = np.zeros(1, [(name, float) for name in SCALARS]), np.zeros((len(MAPS), points))
        rows, noises = np.zeros((len(instants), len(ROWS))), np.zeros((2, len(instants)))
        plan = cls(scalars, instants.copy(), instants.copy(), rows, travel[0] - margin, maps, substeps, *noises)
        plan.set(**AT_REST)
        return plan

    def follow(self, motion: Motion) -> None:
        """Make a motion the reference, in place."""
        self.rows[:, : R_ACCELERATION + 1] = np.transpose([motion.position, motion.velocity, motion.acceleration])

    def add_noise(self, force: np.ndarray, reading: np.ndarray) -> None:
        """Add force noise (command unit) and white noise of the reading (m), in place."""
        self.force_noise, self.reading_noise = self.force_noise + force, self.reading_noise + reading
        self.rows[:, R_FORCE] += force
        self.rows[:, R_READING] += reading

    def smooth(self) -> Plan:
        """A copy without the quantiser."""
        plan = self.copy()
        plan.set(resolution=0.0)
        return plan

    def silent(self) -> Plan:
        """A copy without quantiser and noise; effects stay."""
        plan = self.smooth()
        plan.add_noise(-self.force_noise, -self.reading_noise)
        return plan

    def copy(self) -> Plan:
        """A copy that shares nothing with this one."""
        return copy.deepcopy(self)

    @property
    def positions(self) -> np.ndarray:
        """Where the maps are known, m."""
        return self.grid_start + GRID_STEP * np.arange(self.maps.shape[1])

    @property
    def times(self) -> np.ndarray:
        """Of the samples from the first row, s."""
        return self.instants - self.instants[0]

    def __getitem__(self, name: str) -> float:
        return float(self.scalars[name][0])

    def set(self, **scalars: float) -> None:
        """Give scalars these values, in place."""
        for name, value in scalars.items():
            self.scalars[name] = value

    def run(self) -> Run:
        """Simulate.

        Raises:
            ArithmeticError: the axis left its maps or the numbers: such a loop is unstable.
        """
        active = np.any(self.maps != 0.0, axis=1)
        places = self.maps, active, self.grid_start
        ok, *columns = _loop(self.scalars[0], self.instants, self.rows, *places, self.substeps)
        if not ok:
            raise ArithmeticError("the closed loop is unstable or leaves the travel")
        return Run(*columns)


@dataclass(frozen=True)
class Run:
    """What a run gives, one value a sample: encoder reading (m), command, true position (m) and velocity (m/s)."""

    reading: np.ndarray
    command: np.ndarray
    position: np.ndarray
    velocity: np.ndarray


@njit(cache=True, error_model="numpy")
def _smooth_sign(law, v, width, share):
    if law == TANH:
        return np.tanh(v / width)
    if law == MIXTURE:  # of a narrow and a wide one
        return share * np.tanh(v / width) + (1.0 - share) * v / (abs(v) + 4.0 * width)
    if law == RAMP:  # with a corner
        return min(max(v / width, -1.0), 1.0)
    if law == ALGEBRAIC:
        return v / np.sqrt(v * v + width * width)
    return 2.0 / np.pi * np.arctan(v / width)


@njit(cache=True, error_model="numpy")
def _read_map(m, s):
    """A map at a place in steps of the grid, with Catmull-Rom weights."""
    i = int(s)
    f = s - i
    w0 = f * (-0.5 + f * (1.0 - 0.5 * f))
    w1 = 1.0 + f * f * (-2.5 + 1.5 * f)
    w2 = f * (0.5 + f * (2.0 - 1.5 * f))
    w3 = f * f * (-0.5 + 0.5 * f)
    return w0 * m[i - 1] + w1 * m[i] + w2 * m[i + 1] + w3 * m[i + 2]


@njit(cache=True, error_model="numpy")
def _friction(p, law, level, direction, bristle, v):
    """Coulomb friction: of an axis that sticks by its direction, of bristles by their state, else by the speed."""
    if law == STICK:
        return direction * level + 0.5 * p.coulomb_asymmetry
    share = bristle / p.bristle if law == BRISTLES else _smooth_sign(law, v, p.width, p.share)
    friction = level * share + 0.5 * p.coulomb_asymmetry * abs(share)
    if law == BRISTLES:
        friction += p.bristle_damping * (v - abs(v) * share)
    return friction


@njit(cache=True, error_model="numpy")
def _forces(p, maps, active, grid_start, row, x, v, u, force, hysteresis):
    """Force without Coulomb friction, and the Coulomb level at this place, speed and time."""
    s = (x - grid_start) / GRID_STEP
    gain = 1.0 + row[R_GAIN] + p.gain_speed * abs(v)
    viscous = p.viscous + row[R_VISCOUS] + 0.5 * np.sign(v) * p.viscous_asymmetry
    level = p.coulomb + row[R_COULOMB]
    total = force
    if active[M_FORCE]:
        total += _read_map(maps[M_FORCE], s)
    if active[M_COULOMB]:
        level += _read_map(maps[M_COULOMB], s)
    if active[M_VISCOUS]:
        viscous += _read_map(maps[M_VISCOUS], s)
    if active[M_GAIN]:
        gain += _read_map(maps[M_GAIN], s)
    if active[M_RELUCTANCE]:
        total += u * u * _read_map(maps[M_RELUCTANCE], s)
    total += u * gain - viscous * v
    if p.drag != 0.0:
        total -= p.drag * np.sign(v) * abs(v) ** p.drag_exponent
    if p.hysteresis != 0.0:
        pull = p.hysteresis * hysteresis / p.hysteresis_length
        if p.hysteresis_period > 0.0:
            pull *= np.sin(2.0 * np.pi * x / p.hysteresis_period)
        total -= pull
    if p.stribeck != 0.0:
        ratio = abs(v) / p.stribeck_velocity
        if p.stribeck_shape == 0.0:
            level += p.stribeck * np.exp(-(ratio**p.stribeck_exponent))
        elif p.stribeck_shape == 1.0:
            level += p.stribeck / (1.0 + ratio * ratio)
        elif p.stribeck_shape == 2.0:
            level += p.stribeck / np.cosh(ratio)
        else:
            level += p.stribeck * (0.6 * np.exp(-ratio) + 0.4 * np.exp(-ratio / 4.0))
    return total, level


@njit(cache=True, error_model="numpy")
def _actuator(p, u):
    if p.saturation_soft > 0.0:  # the larger the exponent, the sharper the knee
        n = p.saturation_knee
        u = u / (1.0 + abs(u / p.saturation_soft) ** n) ** (1.0 / n)
    u = min(max(u, -p.saturation_down), p.saturation_up)
    if p.dead_zone > 0.0:
        if p.dead_zone_shape == 2.0:
            u = u - p.dead_zone * np.tanh(u / p.dead_zone)
        elif p.dead_zone_shape == 0.0 or u > 0.0:
            u = np.sign(u) * max(abs(u) - p.dead_zone, 0.0)
    return u


@njit(cache=True, error_model="numpy")
def _relaxed(state, v, length, h):
    """Bristle or hysteresis state after h at constant velocity: z' = v - |v| z / length, solved exactly."""
    goal = length * np.sign(v)
    return goal + (state - goal) * np.exp(-abs(v) * h / length)


@njit(cache=True, error_model="numpy")
def _swung(d, slope, time, damping, h):
    """Deviation and its derivative after h: time^2 d'' + 2 damping time d' + d = 0, for a damping below 1."""
    rate = damping / time
    turn = np.sqrt(1.0 - damping * damping) / time
    fall, sine, cosine = np.exp(-rate * h), np.sin(turn * h), np.cos(turn * h)
    after = fall * (d * cosine + (slope + rate * d) / turn * sine)
    return after, fall * (slope * cosine - ((rate * rate + turn * turn) * d + rate * slope) / turn * sine)


@njit(cache=True, error_model="numpy")
def _loop(p, t, rows, maps, active, grid_start, substeps):
    n = t.size
    readings, commands = np.zeros(n), np.zeros(n)
    positions, velocities = np.zeros(n), np.zeros(n)
    held = np.zeros(n)  # what the amplifier was given
    ts = 1.0 / p.rate
    law = int(p.law)
    x, v = p.x_start, p.v_start
    xl, vl, engaged = x, v, 0
    bristle, hysteresis, lost = 0.0, 0.0, 0.0
    lag_1, lag_2, lag_slope = 0.0, 0.0, 0.0
    error_sum, error_before, reading_before = 0.0, 0.0, 0.0
    m_motor, m_load, stiffness, damping = p.mass, 0.0, 0.0, 0.0
    if p.coupling != RIGID:
        m_load = p.mass * p.load_ratio
        m_motor = p.mass - m_load
        reduced = m_load * m_motor / p.mass
        omega = 2.0 * np.pi * p.mode_frequency
        stiffness = reduced * omega * omega
        damping = 2.0 * p.mode_damping * omega * reduced
    x_low = grid_start + 2 * GRID_STEP
    x_high = grid_start + (maps.shape[1] - 3) * GRID_STEP
    active_index = 0
    for k in range(n):
        # the encoder
        y = x + p.encoder_scale * x + rows[k, R_READING] + lost
        if p.encoder_sine != 0.0 or p.encoder_cosine != 0.0:
            phase = 2.0 * np.pi * x / p.encoder_period
            amplitude = np.hypot(p.encoder_sine, p.encoder_cosine)
            if p.encoder_triangular > 0.0:
                shift = np.arctan2(p.encoder_cosine, p.encoder_sine)
                y += amplitude * 2.0 / np.pi * np.arcsin(np.sin(phase + shift))
            else:
                y += p.encoder_sine * np.sin(phase) + p.encoder_cosine * np.cos(phase)
            if p.encoder_harmonics > 0.0:
                for order in range(2, 5):
                    turned = order * phase + (order - 1) * p.encoder_turn
                    y += amplitude * p.encoder_harmonics ** (order - 1) * np.sin(turned)
        if p.resolution > 0.0:
            y = p.resolution * np.rint(y / p.resolution)
        readings[k], positions[k], velocities[k] = y, x, v
        # the controller
        error = y - rows[k, R_POSITION]
        if k == 0:
            error_before, reading_before = error, y
        measured = (y - reading_before) / ts
        u = p.ff_mass * rows[k, R_ACCELERATION] + p.ff_viscous * rows[k, R_VELOCITY]
        speed = rows[k, R_VELOCITY]
        u += p.ff_coulomb * (_smooth_sign(ARCTANGENT, speed, p.ff_width, 0.0) if p.ff_width > 0.0 else np.sign(speed))
        step = error * ts
        if p.controller == PID:
            error_sum += step
            u += -p.kp * error - p.ki * error_sum - p.kd * (error - error_before) / ts
        else:
            u += p.kv * (-p.kp * error - measured)
        if p.limit > 0.0:
            cut = min(max(u, -p.limit), p.limit)
            if (u - cut) * step < 0.0:
                error_sum -= step
            u = cut
        error_before, reading_before = error, y
        commands[k] = u
        held[k] = held[k - 1] if rows[k, R_HELD] > 0.0 and k > 0 else u
        if k == n - 1:
            break
        # the axis until the next sample
        h = (t[k + 1] - t[k]) / substeps
        force_0 = rows[k, R_FORCE]
        force_slope = (rows[k + 1, R_FORCE] - force_0) / substeps
        row = rows[k]
        u_now = _actuator(p, held[k])
        for j in range(substeps):
            if p.delay > 0.0:
                late = t[k] + (j + 1) * h - p.delay
                while active_index < k and t[active_index + 1] <= late:
                    active_index += 1
                u_now = _actuator(p, held[active_index])
                since = late - t[active_index]
                if late < t[0]:
                    u_now = _actuator(p, held[0])
                elif since < h and active_index > 0:  # the change falls into this step: its mean over the step
                    u_before = _actuator(p, held[active_index - 1])
                    u_now = u_before + (u_now - u_before) * since / h
            u_0 = u_1 = u_now
            if p.lag > 0.0:
                if k == 0 and j == 0:
                    lag_1 = lag_2 = u_now
                u_0 = lag_1
                if p.lag_damping > 0.0:  # two poles that are no real ones, solved exactly for a command that is held
                    lag_1, lag_slope = _swung(lag_1 - u_now, lag_slope, p.lag, p.lag_damping, h)
                    lag_1 += u_now
                else:
                    lag_1 += (u_now - lag_1) * (1.0 - np.exp(-h / p.lag))
                u_1 = lag_1
                if p.second_lag > 0.0:
                    before = lag_2
                    lag_2 += (0.5 * (u_0 + u_1) - lag_2) * (1.0 - np.exp(-h / p.second_lag))
                    u_0, u_1 = before, lag_2
            f_0 = force_0 + force_slope * j
            f_1 = f_0 + force_slope
            # slope at the start
            total, level = _forces(p, maps, active, grid_start, row, x, v, u_0, f_0, hysteresis)
            pull = 0.0
            if p.coupling == FLEXIBLE:
                d = x - xl
                pull = stiffness * d * (1.0 + p.hardening * d * d) + damping * (v - vl)
                total -= pull
            direction = np.sign(v)
            if law == STICK and v == 0.0:
                direction = np.sign(total)
                if abs(total) <= level + 0.5 * direction * p.coulomb_asymmetry:
                    continue
            friction = _friction(p, law, level, direction, bristle, v)
            inertia = m_motor
            if p.coupling == BACKLASH and engaged != 0:
                if engaged * (total - friction) < 0.0:
                    engaged = 0
                else:
                    inertia = p.mass
            a_0 = (total - friction) / inertia
            # predictor
            vp = v + h * a_0
            xp = x + 0.5 * h * (v + vp)
            bristle_p = _relaxed(bristle, 0.5 * (v + vp), p.bristle, h) if law == BRISTLES else 0.0
            if p.hysteresis != 0.0:
                hysteresis = _relaxed(hysteresis, 0.5 * (v + vp), p.hysteresis_length, h)
            if not (x_low < xp < x_high):
                return False, readings, commands, positions, velocities
            # slope at the end
            total, level = _forces(p, maps, active, grid_start, row, xp, vp, u_1, f_1, hysteresis)
            if p.coupling == FLEXIBLE:
                al_0 = pull / m_load
                vlp = vl + h * al_0
                xlp = xl + 0.5 * h * (vl + vlp)
                d = xp - xlp
                pull_1 = stiffness * d * (1.0 + p.hardening * d * d) + damping * (vp - vlp)
                total -= pull_1
                vl_new = vl + 0.5 * h * (al_0 + pull_1 / m_load)
                xl += 0.5 * h * (vl + vl_new)
                vl = vl_new
            friction = _friction(p, law, level, direction, bristle_p, vp)
            a_1 = (total - friction) / inertia
            v_new = v + 0.5 * h * (a_0 + a_1)
            stop = 1.0
            if law == STICK and v_new * direction < 0.0:
                stop = min(1.0, abs(v) / (abs(v) + abs(v_new)))
                v_new = 0.0
            x_new = x + 0.5 * h * stop * (v + v_new)
            if law == BRISTLES:
                bristle = _relaxed(bristle, 0.5 * (v + v_new), p.bristle, h)
            if p.lost_counts != 0.0 and x < p.lost_at <= x_new:
                lost -= p.lost_counts
            if p.coupling == BACKLASH:
                if engaged != 0:
                    vl = v_new
                    xl = x_new - engaged * 0.5 * p.gap
                else:
                    xl += h * vl
                    play = x_new - xl
                    if abs(play) >= 0.5 * p.gap:
                        side = 1 if play > 0.0 else -1
                        if side * (v_new - vl) > 0.0:  # an impact without rebound: momentum is kept
                            v_new = (m_motor * v_new + m_load * vl) / p.mass
                            vl = v_new
                            engaged = side
                        xl = x_new - side * 0.5 * p.gap
            x, v = x_new, v_new
            if not abs(v) < 1e3:
                return False, readings, commands, positions, velocities
    return True, readings, commands, positions, velocities
