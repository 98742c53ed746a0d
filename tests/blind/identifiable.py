"""The identifiable signal-to-noise ratio of a hidden effect: what is left of it after re-tuning.

lambda = |Pi W (u_with - u_without)|^2 / sigma^2: commands with and without the effect under the same noise, quantiser
off; W an autoregressive whitening filter of variance sigma^2, fitted to the noisy minus the noise-free command
without the effect; Pi removes what re-tuned nuisances could do: mass, viscous, Coulomb, friction law and width, the
amplitudes of the known cogging, the initial state. A constant force is no nuisance.
"""

import numpy as np
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

from . import truth
from .machines import Machine
from .truth import Plan

ORDER = 40  # of the whitening filter
SKIP = 0.06  # s at the start that do not count


def whitening_filter(noise: np.ndarray) -> tuple[np.ndarray, float]:
    """Autoregressive filter of a record (Yule and Walker) and the variance of its output."""
    noise = noise - noise.mean()
    covariance = np.fft.irfft(np.abs(np.fft.rfft(noise, 2 * len(noise))) ** 2)[: ORDER + 1] / len(noise)
    covariance[0] *= 1 + 1e-9
    taps = np.concatenate([[1.0], -solve_toeplitz(covariance[:-1], covariance[1:])])
    return taps, float(np.var(lfilter(taps, 1.0, noise)[ORDER:]))


class Signal:
    """The measure of effects on one plan without effects: base command, whitening and nuisances.

    Attributes:
        base: command without effect, quantiser off, (n,).
        directions: whitened signatures by name. nuisances: the same, orthonormal, (n', p).
    """

    def __init__(self, plan: Plan, machine: Machine) -> None:
        self._skip = int(SKIP * plan["rate"])
        self.base = plan.smooth().run().command
        noise = (plan.run().command - plan.silent().run().command)[self._skip :]
        self.taps, self.variance = whitening_filter(noise)
        if not self.variance > 0.0:
            raise ArithmeticError("the log has no noise")
        columns = signatures(plan, machine, self.base)
        self.directions = {name: self.whiten(column) for name, column in columns.items()}
        self.nuisances = self._orthonormal(list(self.directions.values()))

    def whiten(self, difference: np.ndarray) -> np.ndarray:
        """Whitened difference of commands in units of the noise, without the start."""
        return lfilter(self.taps, 1.0, difference)[self._skip :] / np.sqrt(self.variance)

    def difference(self, changed: Plan) -> np.ndarray:
        """Whitened difference of the commands of a changed plan, quantiser off."""
        return self.whiten(changed.smooth().run().command - self.base)

    def ratio(self, difference: np.ndarray, *rivals: np.ndarray) -> float:
        """The lambda of a whitened difference beside the nuisances and any rivals."""
        rest = difference - self.nuisances @ (self.nuisances.T @ difference)
        if rivals:
            others = np.column_stack([r - self.nuisances @ (self.nuisances.T @ r) for r in rivals])
            rest = rest - others @ np.linalg.lstsq(others, rest, rcond=None)[0]
        return float(rest @ rest)

    def deviation(self, name: str) -> float:
        """Relative standard deviation of a nuisance parameter by this log alone, the other nuisances free."""
        others = self._orthonormal([column for key, column in self.directions.items() if key != name])
        column = self.directions[name]
        rest = column - others @ (others.T @ column)
        return 1.0 / np.sqrt(max(float(rest @ rest), 1e-12))

    def law_ratio(self) -> float:
        """The lambda of the friction law itself: its distance, to first order, from any arctangent, re-tuned.

        It is no missing effect, but a method that knows one law only sees a gap of this size.
        """
        nominal = self.directions["width 1.0"]
        others = {name: c for name, c in self.directions.items() if not name.startswith("width")}
        others |= {name: self.directions[name] - nominal for name in ("width 0.7", "width 1.6")}
        matrix = self._orthonormal(list(others.values()))
        rest = nominal - matrix @ (matrix.T @ nominal)
        return float(rest @ rest)

    def absorbed(self, difference: np.ndarray, fixed: tuple[str, ...] = ()) -> dict[str, float]:
        """How far re-tuned nuisances would follow a whitened difference; those in `fixed` stay."""
        free = [name for name in self.directions if name not in fixed]
        matrix = np.column_stack([self.directions[name] for name in free])
        sizes = np.linalg.norm(matrix, axis=0)
        sizes[sizes == 0.0] = 1.0
        steps = np.linalg.lstsq(matrix / sizes, difference, rcond=1e-7)[0] / sizes
        return dict(zip(free, steps.tolist(), strict=True))

    @staticmethod
    def _orthonormal(columns: list[np.ndarray]) -> np.ndarray:
        matrix = np.column_stack([c / (np.linalg.norm(c) or 1.0) for c in columns])
        powers, vectors = np.linalg.eigh(matrix.T @ matrix)
        kept = powers > 1e-12 * powers[-1]
        return matrix @ (vectors[:, kept] / np.sqrt(powers[kept]))


#: Signatures of the start of a log, which are no property of the machine.
START = ("x_start", "v_start")


def signatures(base: Plan, machine: Machine, command: np.ndarray) -> dict[str, np.ndarray]:
    """What the nuisances do to the command of a plan without effects, per unit of relative (or SI) change, (n,) each.

    `command` is that of the plan, quantiser off.
    """
    columns: dict[str, np.ndarray] = {}

    def change(name: str, step: float, force: np.ndarray | float = 0.0, **scalars: float) -> None:
        plan = base.smooth()
        plan.maps[truth.M_FORCE] += force
        plan.set(**scalars)
        columns[name] = (plan.run().command - command) / step

    for name in ("mass", "viscous", "coulomb"):
        change(name, 0.02, **{name: 1.02 * base[name]})
    stable = 0.5 * base["coulomb"] / base["mass"] / base["rate"] / base.substeps
    for factor in (0.7, 1.0, 1.6):
        width = max(factor * machine.model["axis"]["coulomb_width"], stable)
        change(f"width {factor}", 1.0, law=truth.ARCTANGENT, width=width)
    for index, size in enumerate(0.1 * np.hypot(machine.sine, machine.cosine)):
        for cosine in (False, True):
            force = size * machine.cogging(base.positions, index, cosine=cosine)
            change(f"cogging {index} {cosine}", 0.1, force)
    for name, step in zip(START, (1e-6, 1e-4), strict=True):
        change(name, step, **{name: base[name] + step})
    return columns
