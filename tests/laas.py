"""A direct-drive motor with strong cogging (LAAS anti-cogging logs): from three logs to a closed-loop prediction.

Rotary, in amperes: position in rad stands for m and the current for the command, so mass is J/Kt in A/(rad/s^2).
The logs are public as heitor-andrade/laas_anti_cogging. test_laas.py and notebook 05 both use what stands here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.interpolate import BSpline
from scipy.optimize import minimize

import cogging

FOLDER = Path(__file__).parents[1] / ".." / "shared" / "data" / "laas"
TURN = 2 * np.pi
STEP = 2e-4  # s, of the fine grids on which a log is integrated
GAP = 1.45e-3  # s: a longer step between two rows is a lost packet
SETTLED = 0.05  # s after a lost packet: then the loop has forgotten it
PRINTED = {"gain": 0.09, "reference": TURN, "delay": 2e-3}  # of the loop, as the data's description gives it


@dataclass(frozen=True)
class Rows:
    """Rows of a log: s, rad, rad/s (as the drive reports it), A; each (n,)."""

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    current: np.ndarray

    def between(self, start, stop):
        kept = (self.time >= start) & (self.time < stop)
        return Rows(*(getattr(self, name)[kept] for name in ("time", "position", "velocity", "current")))

    @property
    def settled(self):
        """Rows further than SETTLED from the last lost packet: bool, (n,)."""
        lost = self.time[1:][np.diff(self.time) > GAP]
        before = np.searchsorted(lost, self.time, side="right")
        return (before == 0) | (self.time - lost[np.maximum(before, 1) - 1] > SETTLED)


def read(name):
    """The columns of a file, without what its maker's own compensation did to the speed test."""
    table = np.genfromtxt(FOLDER / f"{name}.txt", delimiter=",", names=True)
    if "Function_Activated" in table.dtype.names:
        table = table[table["Function_Activated"] == 0]
    return Rows(table["Time"], table["Position"], table["Velocity"], table["Iq"])


# What each log says ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Estimate:
    """A least-squares value with a 95 % interval."""

    value: float
    low: float
    high: float


def weak_form(rows, width, shift=0.0, every=4):
    """Force balance integrated against smooth windows, so that nothing is differentiated twice.

    For a window w of compact support, int w x'' dt = int w'' x dt. Windows are quartic B-splines of `width` (s), one
    every width/every; those that hold a lost packet are left out. The current is taken `shift` (s) later than the
    position. Returns the windows' centres (s) and the integrals of acceleration, current, sgn(v), v, 1 and a function
    that integrates any force of position.
    """
    window = BSpline.basis_element(np.linspace(0.0, width, 6))
    grid = np.arange(0.0, width + 0.5 * STEP, STEP)
    w, w2 = window(grid) * STEP, window.derivative(2)(grid) * STEP
    starts = np.arange(rows.time[0] + 0.01, rows.time[-1] - width - 0.01, width / every)
    first, last = np.searchsorted(rows.time, starts) - 1, np.searchsorted(rows.time, starts + width)
    lost = np.concatenate([[0], np.cumsum(np.diff(rows.time) > 2.5e-3)])
    starts = starts[lost[last] == lost[first]]
    at = starts[:, None] + grid
    x = np.interp(at, rows.time, rows.position)
    # A difference over 2 ms tells the direction well enough: friction's sign is wrong for a fraction of a millisecond.
    v = (np.interp(at + 1e-3, rows.time, rows.position) - np.interp(at - 1e-3, rows.time, rows.position)) / 2e-3
    current = np.interp(at + shift, rows.time, rows.current) @ w
    integrals = ((x - x[:, :1]) @ w2, current, np.sign(v) @ w, v @ w, np.full(len(starts), w.sum()))
    return starts + width / 2, *integrals, lambda force: force(x.ravel()).reshape(x.shape) @ w


def axis_from_acceleration(rows):
    """J, B and Fc (all over Kt) from the 2 Hz log, by least squares on the weak form.

    Current = J acceleration + Fc sgn(v) + B v + offset; the cogging goes by far above 2 Hz and averages out. Errors
    are not white: covariance from sums over whole periods (0.5 s). The interval is the union over two widths of the
    window and over a current that is 0 or 0.5 ms late, since the data do not say which is right.
    """
    found = []
    for width in (0.05, 0.1):
        for shift in (0.0, 0.5e-3):
            centre, acceleration, current, direction, velocity, one, _ = weak_form(rows, width, shift)
            design = np.stack([acceleration, direction, velocity, one], axis=1)
            value = np.linalg.lstsq(design, current, rcond=None)[0]
            scores = design * (current - design @ value)[:, None]
            period = np.floor(centre / 0.5).astype(int)
            sums = np.stack([scores[period == k].sum(axis=0) for k in np.unique(period)])
            inverse = np.linalg.inv(design.T @ design)
            found.append((value, 1.96 * np.sqrt(np.diag(inverse @ sums.T @ sums @ inverse))))
    values, halves = (np.array(part) for part in zip(*found, strict=True))
    middle, low, high = values.mean(axis=0), (values - halves).min(axis=0), (values + halves).max(axis=0)
    return dict(zip(("mass", "coulomb", "viscous", "offset"), map(Estimate, middle, low, high), strict=True))


def velocity_window(rows):
    """How the drive measures speed: start and width (s) of v(t) = (x(t - start) - x(t - start - width)) / width.

    Fitted to the reported speed of the rows, with the root mean square of what is left (rad/s).
    """
    inner = rows.time > rows.time[0] + 0.02

    def left(window):
        return np.sqrt(np.mean((mean_velocity(rows.time, rows.position, *window) - rows.velocity)[inner] ** 2))

    found = minimize(lambda ms: left(1e-3 * ms), [0.0, 3.5], method="Nelder-Mead", options={"xatol": 1e-3})
    return *(1e-3 * found.x), float(found.fun)


def mean_velocity(time, position, start, width):
    """The speed (rad/s) that velocity_window describes, of any motion."""
    newer, older = (np.interp(time - before, time, position) for before in (start, start + width))
    return (newer - older) / width


def speed_law(rows):
    """Gain (A/(rad/s)), reference (rad/s) and delay (s) of current(t) = gain (reference - v(t - delay)).

    And what is left. v is the reported speed; what is left is over the rms of the current's variation.
    """

    def fit(delay):
        delayed = np.interp(rows.time - delay, rows.time, rows.velocity)[20:]
        design = np.stack([np.ones_like(delayed), delayed], axis=1)
        value, squares, *_ = np.linalg.lstsq(design, rows.current[20:], rcond=None)
        return value, float(np.sqrt(squares[0] / len(delayed)))

    delays = np.arange(1.0, 3.0, 0.02) * 1e-3
    delay = delays[np.argmin([fit(delay)[1] for delay in delays])]
    (offset, slope), left = fit(delay)
    return -slope, -offset / slope, float(delay), left / rows.current.std()


def current_lateness(rows, cogging_map):
    """By how much (s) the logged current is late on the force: where the force balance with the map leaves least.

    Returns it with the share of the current that is left there, the scale of the map that fits best and J.
    """
    shifts = np.arange(-0.5, 1.3, 0.1) * 1e-3
    left, values = [], []
    for shift in shifts:
        _, acceleration, current, direction, _, one, integrate = weak_form(rows, 0.015, shift)
        design = np.stack([acceleration, integrate(cogging_map.force), direction, one], axis=1)
        value = np.linalg.lstsq(design, current, rcond=None)[0]
        left.append(np.std(current - design @ value) / np.std(current))
        values.append(value)
    best = int(np.argmin(left))
    near = slice(best - 2, best + 3)
    bend, slope, _ = np.polyfit(shifts[near] - shifts[best], np.square(left)[near], 2)
    return shifts[best] - 0.5 * slope / bend, left[best], values[best][1], values[best][0]


# The closed loop ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Loop:
    """The closed loop: cogging, axis and the velocity loop as its two delays see it."""

    cogging_map: cogging.CoggingModel | None
    mass: float
    viscous: float
    coulomb: float
    gain: float = PRINTED["gain"]  # A/(rad/s)
    reference: float = PRINTED["reference"]  # rad/s
    delay: float = PRINTED["delay"]  # s, from a speed to the current it gives, on top of a difference over one sample
    lag: float = 0.0  # s, first order
    effects: tuple = ()

    def model(self, sample_rate=1000.0):
        lag = (cogging.effects.ActuatorLag(time_constant=self.lag),) if self.lag > 0 else ()
        return cogging.Model(
            axis=cogging.AxisParameters(mass=self.mass, viscous=self.viscous, coulomb=self.coulomb),
            cogging=self.cogging_map,
            effects=(*self.effects, *lag),
            controller=cogging.SpeedParameters(sample_rate=sample_rate, kp=self.gain, delay=self.delay),
            controller_type="speed",
        )

    def run(self, rows, window, duration=None):
        """The speed over `duration` (s; that of the rows), from the first row on: Rows with the drive's own speed."""
        duration = rows.time[-1] - rows.time[0] if duration is None else duration
        ends = np.array([0.0, 0.5, 1.0]) * (duration + 1.0)
        log = cogging.simulate(
            self.model(),
            cogging.Sampled(time=ends, position=self.reference * ends, velocity=np.full(3, self.reference)),
            duration=duration,
            steps_per_sample=4,
            initial_position=rows.position[0],
            initial_velocity=rows.velocity[0],
        )
        speed = mean_velocity(log.time, log.true_position, *window)
        return Rows(log.time, log.true_position, speed, log.command)


def effective_delay(window, law_delay, lateness):
    """Delay and lag (s) of Loop that stand for the drive's: the mean over `window` and two waiting times.

    A mean over a width has the delay start + width/2 and the spread width/sqrt(12), which a first-order lag of that
    time constant has too. The loop's own difference over a sample and the hold take one sample between them.
    """
    start, width = window
    lag = width / np.sqrt(12.0)
    return start + 0.5 * width + law_delay - lateness - lag - 1e-3, lag


SHOWN = 0.2  # s: what a run shows before is its start
LEVELS = np.linspace(0.01, 0.99, 99)


@dataclass(frozen=True)
class Ripple:
    """A speed in a few numbers (rad/s): mean, standard deviation, share of reversed rows, quantiles at LEVELS and the
    amplitude and phase (rad) of the part that repeats 72 times a turn."""

    mean: float
    deviation: float
    reversed: float
    quantiles: np.ndarray
    detent: complex

    @classmethod
    def of(cls, rows, kept=slice(None)):
        x, v = rows.position[kept], rows.velocity[kept]
        waves = [part(h * x) for h in (12, 18, 24, 36, 72, 144) for part in (np.cos, np.sin)]
        c = np.linalg.lstsq(np.stack([np.ones_like(x), *waves], axis=1), v, rcond=None)[0]
        return cls(v.mean(), v.std(), (v < 0).mean(), np.quantile(v, LEVELS), complex(c[9], c[10]))

    def distance(self, other):
        """The mean difference of the quantiles, rad/s (Wasserstein distance of order 1)."""
        return float(np.abs(self.quantiles - other.quantiles).mean())


def scaled(model, scale):
    """A cogging model of the same shape, `scale` times as large."""
    return cogging.CoggingModel(model.basis, scale * model.sine, scale * model.cosine)


@dataclass(frozen=True)
class Study:
    """Everything fitted (on the first half of the speed test and on the other two logs), and the variants to run."""

    speed_test: Rows
    half: float  # s: rows before are fitted, rows after are predicted
    map_fit: cogging.MapFit
    axis: dict
    window: tuple
    law: tuple
    lateness: tuple

    @classmethod
    def make(cls):
        scan, speed_test = read("stopped_data"), read("speed_test1")
        half = 0.5 * speed_test.time[-1]
        fitted = speed_test.between(0.0, half)
        map_fit = cogging.fit_map(scan.position, scan.current, pitch=TURN)
        return cls(
            speed_test,
            half,
            map_fit,
            axis_from_acceleration(read("acc_current")),
            velocity_window(fitted)[:2],
            speed_law(fitted),
            current_lateness(fitted, map_fit.cogging),
        )

    @property
    def held_out(self):
        return self.speed_test.between(self.half, np.inf)

    def variants(self):
        """Loops by name: from the description of the data to everything that the logs say, one change at a time.

        All but the last are predictions from the scan, the acceleration log and the first half of the speed test's
        rows, in which no speed was simulated; the last one's delay is chosen by simulating the first half.
        """
        gain, reference, law_delay, _ = self.law
        delay, lag = effective_delay(self.window, law_delay, self.lateness[0])
        changes = {
            "no cogging": {"cogging_map": None},
            "+ cogging of the static map": {"cogging_map": self.map_fit.cogging},
            "+ Coulomb level in motion": {"coulomb": self.axis["coulomb"].value},
            "+ gain and reference as logged": {"gain": gain, "reference": reference},
            "+ delay of the measured speed": {"delay": delay + lag},
            "+ its form, a mean over 3 ms": {"delay": delay, "lag": lag},
            "+ map as large as in motion": {"cogging_map": scaled(self.map_fit.cogging, self.lateness[2])},
        }
        loop = Loop(None, self.axis["mass"].value, self.axis["viscous"].value, self.map_fit.coulomb)
        loops = {}
        for name, change in changes.items():
            loop = loops[name] = replace(loop, **change)
        loops["+ delay tuned on the first half"] = self.tuned(loop)
        return loops

    def tuned(self, loop):
        """The loop with the delay, within 0.3 ms, whose speed comes closest to that of the first half."""
        rows = self.speed_test.between(0.0, self.half)
        measured = Ripple.of(rows, rows.settled)
        candidates = [replace(loop, delay=loop.delay + more) for more in np.arange(-0.3, 0.31, 0.05) * 1e-3]
        runs = [candidate.run(rows, self.window) for candidate in candidates]
        return candidates[int(np.argmin([Ripple.of(run, run.time > SHOWN).distance(measured) for run in runs]))]

    def alternatives(self):
        """The loop predicted from the logs with one thing changed: what else could have closed the distance."""
        full = self.variants()["+ map as large as in motion"]
        leading, effects = self.map_fit.cogging.basis.harmonics.index(72), cogging.effects
        only = cogging.CoggingModel(
            cogging.SplineHarmonics(pitch=TURN, harmonics=[72]),
            full.cogging_map.sine[[leading]],
            full.cogging_map.cosine[[leading]],
        )
        rise = effects.StribeckFriction(static_excess=self.map_fit.coulomb - full.coulomb, velocity=2.0)
        return {
            "as predicted": full,
            "Coulomb level of the static scan": replace(full, coulomb=self.map_fit.coulomb),
            "that at rest, the other in motion": replace(full, effects=(rise,)),
            "Coulomb level 0.03 A asymmetric": replace(full, effects=(effects.CoulombAsymmetry(difference=0.03),)),
            "Stribeck excess of 0.03 A": replace(
                full, effects=(effects.StribeckFriction(static_excess=0.03, velocity=2.0),)
            ),
            "delay of the description, 2 ms": replace(full, delay=PRINTED["delay"], lag=0.0),
            "delay 0.1 ms shorter": replace(full, delay=full.delay - 1e-4),
            "delay 0.1 ms longer": replace(full, delay=full.delay + 1e-4),
            "gain 0.09": replace(full, gain=PRINTED["gain"]),
            "only the 72nd harmonic": replace(full, cogging_map=only),
            "J of the speed test": replace(full, mass=self.lateness[3]),
        }

    def table(self, loops):
        """A line a loop beside the held-out half of the log, and Ripple by name."""
        measured = Ripple.of(self.held_out, self.held_out.settled)
        ripples = {"measured (held out)": Ripple.of(self.held_out), "  without lost packets": measured}
        for name, loop in loops.items():
            run = loop.run(self.held_out, self.window)
            ripples[name] = Ripple.of(run, run.time > SHOWN)
        lines = ["                                    mean  deviation  reversed  detent  distance (rad/s)"]
        for name, r in ripples.items():
            lines.append(
                f"{name:33s} {r.mean:6.2f} {r.deviation:10.2f} {r.reversed:9.1%} {abs(r.detent):7.2f}"
                f" {r.distance(measured):9.2f}"
            )
        return "\n".join(lines), ripples
