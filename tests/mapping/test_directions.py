"""Closed turns, one pitch there and back, what changes sign with the direction of motion: drawn scans and real ones."""

import numpy as np
import pytest
from scipy import stats

from cogging import fit_map

DRAWN = range(10)


class Drawn:
    """A periodic force with friction and noise, in plain numpy."""

    def __init__(self, seed):
        self.rng = np.random.default_rng(seed)
        self.pitch = float(np.exp(self.rng.uniform(np.log(0.01), np.log(10.0))))
        self.size = float(np.exp(self.rng.uniform(np.log(0.01), np.log(100.0))))
        self.harmonics = sorted(self.rng.choice(np.arange(1, 9), 3, replace=False).tolist())
        self.amplitudes = self.size * self.rng.uniform(0.3, 1.0, 3)
        self.phases = self.rng.uniform(-np.pi, np.pi, 3)
        self.coulomb = self.size * self.rng.uniform(0.1, 1.0)
        self.noise = self.size * self.rng.uniform(0.005, 0.05)

    def wave(self, x, harmonic, amplitude, phase):
        return amplitude * np.sin(2.0 * np.pi * harmonic * x / self.pitch + phase)

    def map(self, x):
        return sum(self.wave(x, *entry) for entry in zip(self.harmonics, self.amplitudes, self.phases, strict=True))

    def turn(self, points, turns=1):
        """Positions of closed turns: the last one stands a step before the first comes again."""
        start = self.rng.uniform(-2.0, 2.0) * self.pitch
        return start + np.arange(points * turns) * self.pitch / points

    def fit(self, x, clean, **options):
        """The fit to a force with noise."""
        force = clean + self.noise * self.rng.normal(size=clean.size)
        return fit_map(x, force, pitch=self.pitch, **{"order": 0, **options})


def there_and_back(x):
    return np.concatenate([x, x[::-1]]), np.repeat([1.0, -1.0], x.size)


def deviations(fit, drawn):
    """Sines and cosines of the map beside the truth, in standard errors."""
    table = {h: a * np.exp(1j * p) for h, a, p in zip(drawn.harmonics, drawn.amplitudes, drawn.phases, strict=True)}
    true = np.array([table.get(h, 0.0) for h in fit.cogging.basis.harmonics])
    sine = (fit.cogging.sine[:, 0] - true.real) / fit.sine_standard_error[:, 0]
    return np.concatenate([sine, (fit.cogging.cosine[:, 0] - true.imag) / fit.cosine_standard_error[:, 0]])


@pytest.mark.parametrize("turns", [1, 5])
def test_a_closed_turn_is_a_whole_pitch(turns):
    apart, errors = [], []
    for seed in DRAWN:
        drawn = Drawn(seed)
        x = drawn.turn(int(drawn.rng.integers(40, 400)), turns)[:: 1 if seed % 2 else -1]
        fit = drawn.fit(x, drawn.map(x) + drawn.coulomb)
        assert set(drawn.harmonics) <= {entry.harmonic for entry in fit.amplitudes}, seed
        assert len(fit.amplitudes) <= 5
        apart.append(deviations(fit, drawn))
        errors.append((fit.offset - drawn.coulomb) / (drawn.noise / np.sqrt(x.size)))
        if turns == 1:
            with pytest.raises(ValueError, match="must travel at least one pitch"):
                drawn.fit(x[:-3], drawn.map(x[:-3]))
    assert 0.6 < np.std(np.concatenate(apart)) < 1.35
    assert np.std(errors) < 1.5  # the mean of a whole turn, not of the turn and a bit


@pytest.mark.parametrize("way", ["closed turn", "from end to end", "the last place once"])
def test_one_pitch_there_and_back_gives_the_friction(way):
    apart = []
    for seed in DRAWN:
        drawn = Drawn(seed)
        points = int(drawn.rng.integers(60, 300))
        x = drawn.turn(points)
        if way == "from end to end":
            x = np.append(x, x[0] + drawn.pitch)
        x, direction = there_and_back(x)
        if way == "the last place once":
            x, direction = np.delete(x, points), np.delete(direction, points)
        fit = drawn.fit(x, drawn.map(x) + drawn.coulomb * direction + 0.2 * drawn.size)
        assert fit.coulomb is not None, seed
        apart.append(
            [(fit.coulomb - drawn.coulomb) / e for e in (fit.coulomb_standard_error, drawn.noise / x.size**0.5)]
        )
        assert fit.offset == pytest.approx(0.2 * drawn.size, abs=5.0 * fit.offset_standard_error + 1e-9)
    stated, white = np.std(apart, axis=0)
    assert 0.4 < stated < 1.6
    assert white < 1.6


def fit_with(drawn, odd, turns=2):
    """The fit of a scan there and back, with direction times odd(x) on top."""
    x, direction = there_and_back(drawn.turn(200, turns))
    return drawn.fit(x, drawn.map(x) + direction * (drawn.coulomb + odd(x)))


@pytest.mark.parametrize("turns", [1, 6])
def test_friction_that_ripples_is_reported_with_its_size(turns):
    apart, maps = [], []
    for seed in DRAWN:
        drawn = Drawn(seed)
        harmonic, phase = int(drawn.rng.integers(1, 9)), drawn.rng.uniform(-np.pi, np.pi)
        size = drawn.noise * float(np.exp(drawn.rng.uniform(np.log(1.0), np.log(30.0))))
        fit = fit_with(drawn, lambda x, d=drawn, e=(harmonic, size, phase): d.wave(x, *e), turns)
        table = {entry.harmonic: entry for entry in fit.direction_amplitudes}
        assert harmonic in table, seed
        assert len(table) <= 3
        entry = table[harmonic]
        difference = entry.amplitude * np.exp(1j * entry.phase) - size * np.exp(1j * phase)
        apart += [difference.real / entry.standard_error, difference.imag / entry.standard_error]
        maps.append(deviations(fit, drawn))
        assert fit.direction_rms == pytest.approx(size / np.sqrt(2.0), rel=0.4)
        assert f"{fit.direction_rms:.3g} V rms of the force change sign with the direction" in fit.text()
        assert fit.residual_rms < 1.2 * drawn.noise
    assert 0.6 < np.std(apart) < 1.4
    assert 0.6 < np.std(np.concatenate(maps)) < 1.4


def test_nothing_is_reported_where_nothing_changes_sign():
    alarms, runs = 0, 40
    for seed in range(runs):
        fit = fit_with(Drawn(100 + seed), np.zeros_like, turns=1 + seed % 4)
        alarms += bool(fit.direction_amplitudes)
        assert ("change sign" in fit.text()) == bool(fit.direction_amplitudes or "none of the pitch" in fit.text())
        assert (fit.direction_rms > 0.0) == bool(fit.direction_amplitudes)
    assert alarms <= stats.binom.ppf(0.999, runs, 0.01)


def test_a_map_that_lags_is_told_from_friction_that_ripples():
    for seed in DRAWN:
        drawn = Drawn(seed)
        x, direction = there_and_back(drawn.turn(200, 2))
        lag = drawn.rng.choice([-1.0, 1.0]) * drawn.rng.uniform(0.01, 0.03) * drawn.pitch
        fit = drawn.fit(x, drawn.map(x - lag * direction) + drawn.coulomb * direction)
        assert fit.direction_lag == pytest.approx(lag, rel=0.15), seed
        assert ("late each way" in fit.text()) == (lag > 0.0)
        ripple = fit_with(drawn, lambda x, d=drawn: d.wave(x, d.harmonics[0], 0.3 * d.size, d.phases[0]))
        assert ripple.direction_lag is None  # in phase with the map, where a lag would stand a quarter off
        assert "friction that ripples" in ripple.text()
