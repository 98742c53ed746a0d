"""Mass, friction and the strongest spatial period from the force balance of one log."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cogging._core import AxisParameters
from cogging.arrays import FloatArray
from cogging.estimation.axis_balance import AXIS, CUTOFFS, HIGHEST, AxisBalance, thinned
from cogging.estimation.statistics import shares_of_blocks, spread_of
from cogging.logs.log import Log
from cogging.mapping.cogging_spectrum import HarmonicSpectrum
from cogging.model.model import Model
from cogging.model.units import Units

SIGMAS = 3.0  # from zero: a size that is told
SHOWN = 0.003  # of the command's power, that a parameter must explain alone to be told
WIDEST = 0.5  # relative: a size that is known worse than that is not told
SAFE = 2.0  # by which a first balance is less sure than its blocks are
LEAST = 0.2  # relative uncertainty of what is told: a first balance has a bias that its blocks do not show
BIAS = 0.3  # of what is not explained, by which it may pass for what one parameter explains alone
SPRINGLESS = 0.3  # the same of a mass that only the absence of a spring tells
EXPLAINED = 0.5  # of the command's power, that mass and friction must explain before its sign is doubted
FED = 0.02  # of rms command times rms speed: a command that pushes forward feeds friction at least so much
WIDTH = 0.01  # of the top speed: assumed width of the Coulomb law's change of sign


@dataclass(frozen=True)
class Size:
    """One of mass, viscous and Coulomb friction.

    Attributes:
        value: V/(m/s^2), V/(m/s) or V; assumed where it is not told.
        uncertainty: relative, 1 sigma; None where it is not told.
        told: how it was found, or why not.
    """

    value: float
    uncertainty: float | None
    told: str


@dataclass(frozen=True)
class Sizes:
    """What the force balance of a log tells.

    Attributes:
        sizes: mass, viscous and coulomb by name.
        offset: constant force that the command works against, V.
        explained: share of the command's power in motion that they explain; None: nothing moves.
        reversed: whether the command pushes the other way than the position goes.
        speed: top speed, m/s.
        residuals: command less what they explain, V, (m,), with the position, m, (m,), in motion: below a high cut-off,
            where short waves stand and noise as well, and below that of the balance; none where nothing moves.
    """

    sizes: Mapping[str, Size]
    offset: float
    explained: float | None
    reversed: bool
    speed: float
    residuals: tuple[tuple[FloatArray, FloatArray], ...]


@dataclass(frozen=True)
class _Fit:
    """Least squares of the command: values and sigmas of AXIS, share that each explains alone, and what is left."""

    values: FloatArray
    sigmas: FloatArray
    alone: FloatArray
    offset: float
    explained: float
    residual: FloatArray


def sizes_of(log: Log, units: Units) -> Sizes:
    """Mass and friction of an axis from a log, without any belief about it.

    Least squares of the low-pass filtered command on what a unit of mass, viscous and Coulomb friction needs along the
    measured motion and a constant; once with a force of any place beside them (cogging, springs) and once without.
    Where the former cannot tell a size (a sine's acceleration is a spring's) the latter is taken, and said to.

    Args:
        log: in SI, with the command's sign as it was logged.
        units: its labels.
    """
    balance = _balance(log)
    if balance is None:
        told = "cannot tell: the log hardly moves"
        sizes = dict.fromkeys(AXIS, Size(0.0, None, told)) | {"mass": Size(1.0, None, told)}
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
    sizes = {name: _size(k, name, sign, placed, plain, power, units) for k, name in enumerate(AXIS)}
    if sizes["mass"].value <= 0.0:
        top = float(np.quantile(np.abs(needs[0]), 0.99))
        assumed = float(np.sqrt(power)) / top if top > 0.0 and power > 0.0 else 1.0
        sizes["mass"] = Size(assumed, None, f"{sizes['mass'].told}; assumed: the rms command over the top acceleration")
    return Sizes(
        sizes=sizes,
        offset=sign * plain.offset,
        explained=plain.explained,
        reversed=back,
        speed=float(np.quantile(np.abs(balance.speed), 0.99)),
        residuals=(*_wide(log, sign, plain), (balance.position, sign * plain.residual)),
    )


def _wide(log: Log, sign: float, plain: _Fit) -> list[tuple[FloatArray, FloatArray]]:
    """Position and what the sizes leave of the command below the highest cut-off."""
    step = float(np.median(np.diff(log.time)))
    balance = _balance(log, min(CUTOFFS[0], HIGHEST * step))
    if balance is None:
        return []
    needs = np.array([*(balance.needs[name] for name in AXIS), np.ones(len(balance.taken))])
    return [(balance.position, sign * (balance.command[balance.taken] - plain.values @ needs))]


def _balance(log: Log, share: float | None = None) -> AxisBalance | None:
    """The force balance of a log under no model at all."""
    if len(log) < 100 or np.ptp(log.position) == 0.0:
        return None
    try:
        none = Model(AxisParameters(mass=1.0, viscous=0.0, coulomb=0.0, coulomb_width=0.0))
        return AxisBalance.of(log if share is not None else thinned(log), none, share)
    except ValueError:
        return None


def _fit(columns: FloatArray, command: FloatArray, block: np.ndarray) -> _Fit:
    """Least squares with the spread of leaving out one block after the other; a fourth column is an offset."""
    size = np.sqrt(np.mean(columns**2, axis=1))
    size[size == 0.0] = 1.0
    scaled = columns / size[:, None]
    normal, right = scaled @ scaled.T, scaled @ command
    weights = np.linalg.lstsq(normal, right, rcond=1e-9)[0]
    residual = command - weights @ scaled
    power = max(float(command @ command), 1e-300)
    shifts = [
        np.linalg.lstsq(normal - bread, share, rcond=1e-9)[0]
        for bread, share in shares_of_blocks(scaled, scaled, residual, block)
    ]
    covariance = spread_of(np.array(shifts))[0] if len(shifts) > 1 else np.full((len(size), len(size)), np.inf)
    inverse = np.diag(np.linalg.pinv(normal, rcond=1e-9, hermitian=True))
    alone = weights**2 / np.maximum(inverse, 1e-300) / power  # what is lost without it, of the command's power
    sigmas = np.sqrt(np.abs(np.diag(covariance))) / size
    values = weights / size
    offset = float(values[3]) if len(values) > 3 else 0.0
    return _Fit(values, sigmas, alone, offset, 1.0 - float(residual @ residual) / power, residual)


def _size(k: int, name: str, sign: float, placed: _Fit, plain: _Fit, power: float, units: Units) -> Size:
    """One size: of the fit beside a force of any place where that tells it, else of the plain one, else none."""
    for fit, beside in ((placed, True), (plain, False)):
        value, sigma = sign * float(fit.values[k]), SAFE * float(fit.sigmas[k])
        if value > 0.0 and sigma < WIDEST * value and fit.alone[k] > SHOWN:
            least = LEAST if beside or name != "mass" else SPRINGLESS
            how = "beside a force of any place" if beside else "if no spring and no cogging acts"
            bias = BIAS * float(np.sqrt((1.0 - fit.explained) / fit.alone[k]))
            return Size(value, max(sigma / value, least, bias), f"found by a first force balance, {how}")
    value = sign * float(plain.values[k])
    bound = abs(value) + SIGMAS * float(plain.sigmas[k])
    if not math.isfinite(bound) or name == "mass":
        return Size(0.0, None, "cannot tell from this log")
    return Size(
        max(value, 0.0),
        None,
        f"cannot tell from this log; below {bound:.2g} {units.of(AxisParameters.FIELDS[name][0])}",
    )


ROWS = 3000  # independent enough, and enough for a spectrum
FEWEST_PERIODS = 3  # in the travel: a longer wave may be a slope
MOST_PERIODS = 400
A_PERIOD = 8  # rows, at least, in the shortest period that is sought
SHARE = 0.1  # of what is left, that the wave must explain to be worth a line
LEAST_AMPLITUDE = 0.03  # of the rms command, that its amplitude must be
ALIKE = 0.4  # of its amplitude, by which the wave of one half of the rows may differ from the other's
STEPS = 201  # of the search between two lines of the spectrum


@dataclass(frozen=True)
class Wave:
    """A wave over position.

    Attributes:
        period: m.
        sine: V; cosine: V: force = sine sin(2 pi x / period) + cosine cos(2 pi x / period), which the command meets.
        share: of the power that mass and friction leave.
    """

    period: float
    sine: float
    cosine: float
    share: float


def strongest_wave(position: FloatArray, force: FloatArray, command_rms: float) -> Wave | None:
    """The strongest wave of a force over position that both halves of the rows show alike; None where there is none.

    Args:
        position: m, (n,).
        force: V, (n,).
        command_rms: V, of all that the command does: a wave that is small beside it is not worth a line.
    """
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
    wave = _refined(x, rest, frequency, 0.5 / travel)
    worth = wave.share > SHARE and math.hypot(wave.sine, wave.cosine) > LEAST_AMPLITUDE * command_rms
    return wave if worth and _stays(x, rest, wave) else None


def _stays(x: FloatArray, rest: FloatArray, wave: Wave) -> bool:
    """Whether the first half of the rows shows the same wave as the second: what is bound to the place does."""
    phase = 2.0 * np.pi * x / wave.period
    columns = np.column_stack([np.sin(phase), np.cos(phase)])
    half = len(x) // 2
    weights = [np.linalg.lstsq(columns[rows], rest[rows], rcond=None)[0] for rows in (slice(half), slice(half, None))]
    return bool(np.linalg.norm(weights[0] - weights[1]) < ALIKE * math.hypot(wave.sine, wave.cosine))


def _refined(x: FloatArray, rest: FloatArray, frequency: float, width: float) -> Wave:
    """The wave near a line of the spectrum that leaves least."""
    best = (np.inf, frequency, np.zeros(2))
    for f in np.linspace(frequency - width, frequency + width, STEPS):
        phase = 2.0 * np.pi * f * x
        columns = np.column_stack([np.sin(phase), np.cos(phase)])
        weights = np.linalg.lstsq(columns, rest, rcond=None)[0]
        left = float(np.mean((rest - columns @ weights) ** 2))
        if left < best[0]:
            best = (left, float(f), weights)
    left, f, weights = best
    whole = max(float(np.mean(rest**2)), 1e-300)
    return Wave(1.0 / f, float(weights[0]), float(weights[1]), 1.0 - left / whole)
