"""An axis written down a second time, from the formulas of the contract, and integrated by scipy at tight tolerances.

It shares no code with the simulator: laws by hand, LSODA in place of Runge-Kutta, sticking by its events. It is slow.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import BSpline

TWO_PI = 2 * np.pi
RTOL = 1e-11


@dataclass
class ScipyPlant:
    """M x'' = u - B x' - g S(x') - F_cogging(x) + effects; `effects` are (name, fields) as in a model file.

    cogging: (pitch, harmonics, order, origin, sine, cosine) or None.
    """

    mass: float
    viscous: float = 0.0
    coulomb: float = 0.0
    width: float = 0.0
    cogging: tuple | None = None
    effects: list = field(default_factory=list)

    def __post_init__(self):
        self.by_name = dict(self.effects)
        self.splines = []
        if self.cogging is not None:
            pitch, harmonics, order, origin, sine, cosine = self.cogging
            self.splines = [
                (TWO_PI * h / pitch, amplitude(s, order, origin, pitch), amplitude(c, order, origin, pitch))
                for h, s, c in zip(harmonics, sine, cosine, strict=True)
            ]
        load = self.by_name.get("flexible_mode") or self.by_name.get("backlash") or {}
        self.ratio, self.gap = load.get("mass_ratio", 0.0), load.get("gap")
        reduced = self.mass * self.ratio * (1 - self.ratio)
        w = TWO_PI * load.get("frequency", load.get("contact_frequency", 0.0))
        damping_ratio = load.get("damping_ratio", load.get("contact_damping_ratio", 0.0))
        self.spring, self.damper = w * w * reduced, 2 * damping_ratio * w * reduced
        self.frequency = self.by_name.get("disturbance_tone", {}).get("frequency", 1e-9)
        self.lag = self.by_name.get("actuator_lag", {}).get("time_constant", 0.0)

    def level(self, x, v, direction):
        total = self.coulomb
        for name, p in self.effects:
            if name == "coulomb_asymmetry":
                total += 0.5 * p["difference"] * np.sign(direction)
            elif name == "stribeck_friction":
                total += p["static_excess"] * np.exp(-(abs(v / p["velocity"]) ** p["exponent"]))
            elif name == "position_dependent_friction":
                total += np.interp(x, p["nodes"], p["levels"])
        return max(total, 0.0)

    def push(self, t, x, v, drive):
        """All forces but friction and coupling."""
        gain, total = 1.0, -self.viscous * v
        for k, sine, cosine in self.splines:
            total -= sine(x) * np.sin(k * x) + cosine(x) * np.cos(k * x)
        for name, p in self.effects:
            if name == "disturbance_tone":
                total += p["sine"] * np.sin(TWO_PI * p["frequency"] * t)
                total += p["cosine"] * np.cos(TWO_PI * p["frequency"] * t)
            elif name == "cable_spring":
                total -= p["stiffness"] * (x - p["center"])
            elif name == "cogging_harmonic":
                total -= wave(x, p)
            elif name == "cogging_modulation":
                sine, cosine = (amplitude(p[part], p["order"], p["origin"], p["pitch"]) for part in ("sine", "cosine"))
                total -= wave(x, {"sine": sine(x), "cosine": cosine(x), "period": p["period"]})
            elif name == "disturbance_step":
                total += p["force"] * (p["start"] <= t < p["stop"])
            elif name == "constant_force":
                total += p["force"]
            elif name == "empirical_force":
                for at, kind in ((x, "position"), (v, "velocity"), (t, "time")):
                    total += np.interp(at, p[f"{kind}_nodes"], p[f"{kind}_forces"])
            elif name == "viscous_asymmetry":
                total -= 0.5 * p["difference"] * abs(v)
            elif name == "quadratic_drag":
                total -= p["coefficient"] * v * abs(v)
            elif name == "end_effect":
                low, high = p["travel"]
                total += p["force"] * (np.exp((x - high) / p["decay_length"]) - np.exp((low - x) / p["decay_length"]))
            elif name == "force_constant_ripple":
                gain += wave(x, p)
            elif name == "force_constant_drift":
                gain += p["change"] * (1 - np.exp(-t / p["time_constant"]))
        return total + gain * drive

    def pull(self, q, rate):
        if self.gap is None:
            return self.spring * q + self.damper * rate
        push = self.spring * (q - np.clip(q, -self.gap / 2, self.gap / 2))  # a contact, which never pulls
        return push + np.clip(self.damper * rate, -abs(push), abs(push))

    def rates(self, t, state, command, direction):
        """`direction`: None = friction as it is, -1 or +1 = sliding, 0 = at rest."""
        x, v, drive, z, q, rate = state
        u = drive if self.lag > 0 else command
        settling = (command - drive) / self.lag if self.lag > 0 else 0.0
        pull = self.pull(q, rate) if self.ratio else 0.0
        load = -pull / (self.mass * self.ratio) if self.ratio else 0.0
        if direction == 0:
            return [0.0, 0.0, settling, 0.0, rate, load]
        bristle = self.by_name.get("presliding_friction")
        bristle_rate = 0.0
        if bristle is not None:
            level = self.level(x, v, v)
            bristle_rate = v - bristle["stiffness"] * abs(v) * z / level if level > 0 else v
            friction = bristle["stiffness"] * z + bristle["damping"] * bristle_rate
        elif direction is None:
            smooth = 2 / np.pi * np.arctan(v / self.width) if self.width > 0 else 0.0
            friction = self.level(x, v, smooth) * smooth
        else:
            friction = self.level(x, v, direction) * direction
        a = (self.push(t, x, v, u) + pull - friction) / (self.mass * (1 - self.ratio))
        return [v, a, settling, bristle_rate, rate if self.ratio else 0.0, load - a if self.ratio else 0.0]

    def net(self, t, state, command):
        """What pushes an axis at rest, friction apart."""
        x, _, drive, _, q, rate = state
        push = self.push(t, x, 0.0, drive if self.lag > 0 else command)
        return push + (self.pull(q, rate) if self.ratio else 0.0)

    def breakaway(self, t, state, command):
        push = self.net(t, state, command)
        for direction in (-1, 1):
            if push * direction > self.level(state[0], 0.0, direction):
                return direction
        return 0

    @property
    def sticks(self):
        return self.width == 0.0 and self.coulomb > 0 and "presliding_friction" not in self.by_name

    def run(self, time, commands, x0, v0):
        """True positions and velocities at the sample times, (n, 2)."""
        delay = self.by_name.get("command_delay", {}).get("delay", 0.0)
        limit = self.by_name.get("command_saturation", {}).get("limit", np.inf)
        dead = self.by_name.get("command_dead_zone", {}).get("width", 0.0)
        shaped = commands
        for name, _ in self.effects:
            if name == "command_saturation":
                shaped = np.clip(shaped, -limit, limit)
            elif name == "command_dead_zone":
                shaped = np.sign(shaped) * np.maximum(np.abs(shaped) - dead, 0.0)
        arrival = time + delay
        step, empirical = self.by_name.get("disturbance_step", {}), self.by_name.get("empirical_force", {})
        breaks = np.array([step.get("start", 0.0), step.get("stop", 0.0), *empirical.get("time_nodes", [])])
        edges = np.concatenate([time, arrival[arrival < time[-1]], breaks[(breaks > 0) & (breaks < time[-1])]])
        edges = np.unique(np.round(edges, 13))
        state = np.array([x0, v0, 0.0, 0.0, 0.0, 0.0])
        scale = [max(abs(v0), 1e-6)]
        states = [state[:2]]
        for start, stop in pairwise(edges):
            index = np.searchsorted(arrival, 0.5 * (start + stop), side="right") - 1
            command = shaped[index] if index >= 0 else 0.0
            state = self._piece(start, np.nextafter(stop, start), state, command, scale)
            scale.append(abs(state[1]))
            if np.abs(time - stop).min() < 1e-10:
                states.append(state[:2])
        return np.array(states)

    def _piece(self, start, stop, state, command, scale):
        t, stops, freed = start, 0, 0
        while t < stop:
            direction = None
            if self.sticks:
                direction = np.sign(state[1]) if state[1] != 0 else freed or self.breakaway(t, state, command)
            speed = max(scale)
            atol = [1e-13, 1e-11 * speed, 1e-13, 1e-15, 1e-13, 1e-11 * speed]

            def ends(at, y, command, direction):
                if direction != 0:
                    return y[1] * direction
                push = self.net(at, y, command)
                return self.level(y[0], 0.0, 1 if push >= 0 else -1) - abs(push)

            ends.terminal, ends.direction = True, -1
            solved = solve_ivp(
                self.rates,
                (t, stop),
                state,
                "LSODA",
                args=(command, direction),
                rtol=RTOL,
                atol=atol,
                events=ends if direction is not None else None,
                max_step=min((stop - start) / 4, 0.02 / self.frequency),  # at rest no rate would tell of a wave
            )
            assert solved.success, solved.message
            state, t = solved.y[:, -1], solved.t[-1]
            if direction is not None and t < stop:
                state[1], stops = 0.0, stops + 1
                assert stops < 1000, "endless reversals"
                freed = 0  # the way that the force points when rest ends; at a stop it is looked at anew
                if direction == 0:
                    freed = 1 if self.net(t, state, command) >= 0 else -1
        return state


def wave(x, p):
    return p["sine"] * np.sin(TWO_PI * x / p["period"]) + p["cosine"] * np.cos(TWO_PI * x / p["period"])


def amplitude(values, order, origin, pitch):
    """A B-spline of the amplitudes that keeps its end values."""
    values = np.asarray(values, dtype=float)
    if len(values) == 1:
        return lambda x: values[0]
    knots = origin + (np.arange(len(values) + order) + 1 - order) * pitch
    end = origin + (len(values) - order + 1) * pitch
    spline = BSpline(knots, values, order - 1)
    return lambda x: float(spline(min(max(x, origin), np.nextafter(end, origin))))
