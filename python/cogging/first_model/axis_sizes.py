"""Mass, friction and the strongest spatial period from the force balance of one log."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cogging._core import AxisParameters
from cogging.arrays import FloatArray
from cogging.estimation.axis_balance import AXIS, CUTOFFS, HIGHEST, AxisBalance, thinned
from cogging.estimation.statistics import shares_of_blocks, spread_of
from cogging.logs.log import Log
from cogging.mapping.cogging_spectrum import HarmonicSpectrum
from cogging.model.model import Model
from cogging.model.units import Units

SIGMAS = 3.0  # from zero, at which a size is significant
SHOWN = 0.003  # of the command's power, that a parameter must explain alone
WIDEST = 0.5  # largest relative uncertainty of a reported size
SAFE = 2.0  # factor on the jackknife uncertainty of a first balance
LEAST = 0.2  # least relative uncertainty: a first balance has a bias that the jackknife does not show
BIAS = 0.3  # of the unexplained command, that may bias one parameter
SPRINGLESS = 0.3  # least relative uncertainty of a mass that is identifiable only without a spring
EXPLAINED = 0.5  # of the command's power, that mass and friction must explain before its sign is doubted
FED = 0.02  # of rms command times rms speed: least mean power of a command of the right sign
WIDTH = 0.01  # of the top speed: assumed width of the Coulomb law's sign change


@dataclass(frozen=True)
class Size:
    """One of mass, viscous and Coulomb friction."""

    value: float  # V/(m/s^2), V/(m/s) or V; assumed where it is not identifiable
    uncertainty: float | None  # relative, 1 sigma; None where it is not identifiable
    reason: str  # how it was found, or why not


@dataclass(frozen=True)
class Sizes:
    """Mass and friction from the force balance of a log."""

    sizes: Mapping[str, Size]  # mass, viscous and coulomb by name
    offset: float  # constant force that the command balances, V
    explained: float | None  # share of the command's power in motion that they explain; None: no motion
    reversed: bool  # whether command and position have opposite signs
    speed: float  # top speed, m/s
    # pairs of position, m, (m,), and unexplained command, V, (m,), in motion: below a high cut-off, for short waves,
    # and below that of the balance; empty without motion
    residuals: tuple[tuple[FloatArray, FloatArray], ...]


class _Fit(NamedTuple):
    """Least squares of the command: values and sigmas of AXIS (and offset), what each explains alone, the residual."""

    values: FloatArray
    sigmas: FloatArray
    alone: FloatArray
    explained: float
    residual: FloatArray


def sizes_of(log: Log, units: Units) -> Sizes:
    """Estimate mass and friction of an axis from a log in SI, without a prior model.

    Least squares of the filtered command on mass, friction and a constant, once with a free force of position beside
    them (cogging, springs) and once without, which is used where the former does not identify a size.
    """
    balance = _balance(log)
    if balance is None:
        reason = "not identifiable: the log hardly moves"
        sizes = dict.fromkeys(AXIS, Size(0.0, None, reason)) | {"mass": Size(1.0, None, reason)}
        return Sizes(sizes, 0.0, None, False, 0.0, ())
    command = balance.command[balance.taken]
    needs = np.array([balance.needs[name] for name in AXIS])
    plain = _fit(np.vstack([needs, np.ones(len(command))]), command, balance.block)
    placed = _fit(balance.freed(needs), balance.freed(command[None])[0], balance.block)
    power = float(np.mean(command**2))
    fed = float(np.mean(command * balance.speed))  # power that friction must take up
    fed /= max(float(np.sqrt(power * np.mean(balance.speed**2))), 1e-300)
    back = plain.values[0] < -SIGMAS * plain.sigmas[0] and plain.explained > EXPLAINED and fed < FED
    sign = -1.0 if back else 1.0
    sizes = {name: _size(k, name, sign, placed, plain, units) for k, name in enumerate(AXIS)}
    if sizes["mass"].value <= 0.0:
        top = float(np.quantile(np.abs(needs[0]), 0.99))
        assumed = float(np.sqrt(power)) / top if top > 0.0 and power > 0.0 else 1.0
        reason = f"{sizes['mass'].reason}; assumed: the rms command over the top acceleration"
        sizes["mass"] = Size(assumed, None, reason)
    residuals = [(balance.position, sign * plain.residual)]
    share = min(CUTOFFS[0], HIGHEST * float(np.median(np.diff(log.time))))
    if (wide := _balance(log, share)) is not None:
        columns = np.array([*(wide.needs[name] for name in AXIS), np.ones(len(wide.taken))])
        residuals.insert(0, (wide.position, sign * (wide.command[wide.taken] - plain.values @ columns)))
    return Sizes(
        sizes=sizes,
        offset=sign * float(plain.values[3]),
        explained=plain.explained,
        reversed=back,
        speed=float(np.quantile(np.abs(balance.speed), 0.99)),
        residuals=tuple(residuals),
    )


def _balance(log: Log, share: float | None = None) -> AxisBalance | None:
    """The force balance of a log without a model."""
    if len(log) < 100 or np.ptp(log.position) == 0.0:
        return None
    try:
        none = Model(AxisParameters(mass=1.0, viscous=0.0, coulomb=0.0, coulomb_width=0.0))
        return AxisBalance.of(log if share is not None else thinned(log), none, share)
    except ValueError:
        return None


def _fit(columns: FloatArray, command: FloatArray, block: np.ndarray) -> _Fit:
    """Least squares with jackknife errors over blocks; a fourth column is an offset."""
    size = np.sqrt(np.mean(columns**2, axis=1))
    size[size == 0.0] = 1.0
    scaled = columns / size[:, None]
    normal, right = scaled @ scaled.T, scaled @ command
    weights = np.linalg.lstsq(normal, right, rcond=1e-9)[0]
    residual = command - weights @ scaled
    power = max(float(command @ command), 1e-300)
    shares = shares_of_blocks(scaled, scaled, residual, block)
    shifts = [np.linalg.lstsq(normal - bread, share, rcond=1e-9)[0] for bread, share in shares]
    covariance = spread_of(np.array(shifts))[0] if len(shifts) > 1 else np.full((len(size), len(size)), np.inf)
    inverse = np.diag(np.linalg.pinv(normal, rcond=1e-9, hermitian=True))
    alone = weights**2 / np.maximum(inverse, 1e-300) / power  # share of the command's power that is lost without it
    sigmas, values = np.sqrt(np.abs(np.diag(covariance))) / size, weights / size
    return _Fit(values, sigmas, alone, 1.0 - float(residual @ residual) / power, residual)


def _size(k: int, name: str, sign: float, placed: _Fit, plain: _Fit, units: Units) -> Size:
    """One size: from the fit with a free force of position, else from the plain fit, else not identifiable."""
    for fit, beside in ((placed, True), (plain, False)):
        value, sigma = sign * float(fit.values[k]), SAFE * float(fit.sigmas[k])
        if value > 0.0 and sigma < WIDEST * value and fit.alone[k] > SHOWN:
            least = LEAST if beside or name != "mass" else SPRINGLESS
            how = "beside a free force of position" if beside else "assuming no spring and no cogging"
            bias = BIAS * float(np.sqrt((1.0 - fit.explained) / fit.alone[k]))
            return Size(value, max(sigma / value, least, bias), f"found by a first force balance, {how}")
    value, reason = sign * float(plain.values[k]), "not identifiable from this log"
    bound = abs(value) + SIGMAS * float(plain.sigmas[k])
    if not math.isfinite(bound) or name == "mass":
        return Size(0.0, None, reason)
    return Size(max(value, 0.0), None, f"{reason}; below {bound:.2g} {units.of(AxisParameters.FIELDS[name][0])}")


ROWS = 3000  # used at most
FEWEST_PERIODS = 3  # in the travel: a longer wave may be a trend
MOST_PERIODS = 400
A_PERIOD = 8  # rows in the shortest period searched
SHARE = 0.1  # of the residual's power, that a reported wave explains
LEAST_AMPLITUDE = 0.03  # of the rms command
ALIKE = 0.4  # of its amplitude: largest difference between the halves of the rows
STEPS = 201  # of the search between two lines of the spectrum


@dataclass(frozen=True)
class Wave:
    """A wave over position."""

    period: float  # m
    sine: float  # sine, cosine: V: the command balances sine sin(2 pi x / period) + cosine cos(2 pi x / period)
    cosine: float
    share: float  # of the power of the residual of mass and friction


def strongest_wave(position: FloatArray, force: FloatArray, command_rms: float) -> Wave | None:
    """The strongest wave of a force over position that both halves of the rows agree on, or None."""
    travel = float(np.ptp(position)) if len(position) else 0.0
    if len(position) < 200 or travel == 0.0:
        return None
    taken = np.linspace(0, len(position) - 1, min(len(position), ROWS)).astype(int)
    x, f = position[taken], force[taken]
    nuisance = np.column_stack([np.ones(len(x)), (x - x.mean()) / travel])
    rest = f - nuisance @ np.linalg.lstsq(nuisance, f, rcond=None)[0]
    spectrum = HarmonicSpectrum(x, 2.0 * travel, 2 * min(MOST_PERIODS, len(x) // A_PERIOD))  # lines half as far apart
    power = spectrum.power(rest)
    power[: 2 * FEWEST_PERIODS] = 0.0
    frequency = float(spectrum.frequency.ravel()[int(np.argmax(power))])

    def fitted(phase: FloatArray, rows: slice = slice(None)) -> tuple[float, FloatArray]:
        """Mean square of what a wave leaves of some rows, and its sine and cosine."""
        columns = np.column_stack([np.sin(phase), np.cos(phase)])[rows]
        weights = np.linalg.lstsq(columns, rest[rows], rcond=None)[0]
        return float(np.mean((rest[rows] - columns @ weights) ** 2)), np.asarray(weights)

    frequencies = np.linspace(frequency - 0.5 / travel, frequency + 0.5 / travel, STEPS).tolist()
    tried = [(*fitted(2.0 * np.pi * one * x), one) for one in frequencies]
    left, (sine, cosine), frequency = min(tried, key=lambda one: one[0])
    wave = Wave(1.0 / frequency, float(sine), float(cosine), 1.0 - left / max(float(np.mean(rest**2)), 1e-300))
    amplitude = math.hypot(wave.sine, wave.cosine)
    if wave.share <= SHARE or amplitude <= LEAST_AMPLITUDE * command_rms:
        return None
    # The first half of the rows has the wave of the second, as a force of position does.
    phase, half = 2.0 * np.pi * x / wave.period, len(x) // 2
    (_, first), (_, second) = fitted(phase, slice(half)), fitted(phase, slice(half, None))
    return wave if np.linalg.norm(first - second) < ALIKE * amplitude else None
