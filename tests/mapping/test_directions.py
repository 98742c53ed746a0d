"""Closed turns, one pitch there and back, what changes sign with the direction of motion: drawn scans and real ones."""

import numpy as np
import pytest
from scipy import stats

from cogging.datasets import laas
from cogging.mapping.fit_map import fit_map
from tests.fixtures.measured import FOLDER

DRAWN = range(12)


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
        entries = zip(self.harmonics, self.amplitudes, self.phases, strict=True)
        return sum(self.wave(x, *entry) for entry in entries)

    def turn(self, points, turns=1):
        """Positions of closed turns: the last one stands a step before the first comes again."""
        start = self.rng.uniform(-2.0, 2.0) * self.pitch
        return start + np.arange(points * turns) * self.pitch / points

    def both(self, x):
        """There and back over the same places, and the direction of each row."""
        return np.concatenate([x, x[::-1]]), np.repeat([1.0, -1.0], x.size)

    def measured(self, clean):
        return clean + self.noise * self.rng.normal(size=clean.size)


def deviations(fit, drawn):
    """Sines and cosines of the map beside the truth, in standard errors."""
    found = fit.cogging.basis.harmonics
    table = {h: a * np.exp(1j * p) for h, a, p in zip(drawn.harmonics, drawn.amplitudes, drawn.phases, strict=True)}
    true = np.array([table.get(h, 0.0) for h in found])
    apart = [(fit.cogging.sine[:, 0] - true.real) / fit.sine_standard_error[:, 0]]
    apart.append((fit.cogging.cosine[:, 0] - true.imag) / fit.cosine_standard_error[:, 0])
    return np.concatenate(apart)


# --- a closed turn ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("turns", [1, 5])
def test_a_closed_turn_is_a_whole_pitch(turns):
    apart, errors = [], []
    for seed in DRAWN:
        drawn = Drawn(seed)
        x = drawn.turn(int(drawn.rng.integers(40, 400)), turns)[:: 1 if seed % 2 else -1]
        fit = fit_map(x, drawn.measured(drawn.map(x) + drawn.coulomb), pitch=drawn.pitch, order=0)
        assert set(drawn.harmonics) <= {entry.harmonic for entry in fit.amplitudes}, seed
        assert len(fit.amplitudes) <= 5
        apart.append(deviations(fit, drawn))
        errors.append((fit.offset - drawn.coulomb) / (drawn.noise / np.sqrt(x.size)))
    spread = np.std(np.concatenate(apart))
    assert 0.6 < spread < 1.35
    assert np.std(errors) < 1.5  # the mean of a whole turn, not of the turn and a bit


def test_a_turn_with_a_piece_missing_is_still_refused():
    for seed in DRAWN:
        drawn = Drawn(seed)
        x = drawn.turn(int(drawn.rng.integers(40, 400)))[:-3]
        with pytest.raises(ValueError, match="must travel at least one pitch"):
            fit_map(x, drawn.map(x), pitch=drawn.pitch)


# --- there and back over one pitch ------------------------------------------------------------------------------------


@pytest.mark.parametrize("way", ["closed turn", "from end to end", "the last place once"])
def test_there_and_back_over_one_pitch_keeps_friction(way):
    apart, errors = [], []
    for seed in DRAWN:
        drawn = Drawn(seed)
        points = int(drawn.rng.integers(60, 300))
        x = drawn.turn(points)
        if way == "from end to end":
            x = np.append(x, x[0] + drawn.pitch)
        x, direction = drawn.both(x)
        if way == "the last place once":
            x, direction = np.delete(x, points), np.delete(direction, points)
        clean = drawn.map(x) + drawn.coulomb * direction + 0.2 * drawn.size
        fit = fit_map(x, drawn.measured(clean), pitch=drawn.pitch, order=0)
        assert fit.coulomb is not None, seed
        apart.append((fit.coulomb - drawn.coulomb) / fit.coulomb_standard_error)
        errors.append((fit.coulomb - drawn.coulomb) / (drawn.noise / np.sqrt(x.size)))
        assert fit.offset == pytest.approx(0.2 * drawn.size, abs=5.0 * fit.offset_standard_error + 1e-9)
    assert 0.4 < np.std(apart) < 1.6
    assert np.std(errors) < 1.6


# --- what changes sign with the direction -----------------------------------------------------------------------------


def scan_with(drawn, odd, turns=2):
    """There and back, with direction times odd(x) on top."""
    x, direction = drawn.both(drawn.turn(200, turns))
    clean = drawn.map(x) + direction * (drawn.coulomb + odd(x))
    return fit_map(x, drawn.measured(clean), pitch=drawn.pitch, order=0)


@pytest.mark.parametrize("turns", [1, 6])
def test_friction_that_ripples_is_told_with_its_size(turns):
    apart, maps = [], []
    for seed in DRAWN:
        drawn = Drawn(seed)
        harmonic, phase = int(drawn.rng.integers(1, 9)), drawn.rng.uniform(-np.pi, np.pi)
        size = drawn.noise * float(np.exp(drawn.rng.uniform(np.log(1.0), np.log(30.0))))
        fit = scan_with(drawn, lambda x, d=drawn, e=(harmonic, size, phase): d.wave(x, *e), turns)
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


def test_nothing_is_said_where_nothing_changes_sign():
    alarms, runs = 0, 60
    for seed in range(runs):
        fit = scan_with(Drawn(100 + seed), np.zeros_like, turns=1 + seed % 4)
        alarms += bool(fit.direction_amplitudes)
        assert ("change sign" in fit.text()) == bool(fit.direction_amplitudes or "none of the pitch" in fit.text())
        assert (fit.direction_rms > 0.0) == bool(fit.direction_amplitudes)
    assert alarms <= stats.binom.ppf(0.999, runs, 0.01)


def test_a_map_that_lags_is_told_from_friction_that_ripples():
    for seed in DRAWN:
        drawn = Drawn(seed)
        x, direction = drawn.both(drawn.turn(200, 2))
        lag = drawn.rng.choice([-1.0, 1.0]) * drawn.rng.uniform(0.01, 0.03) * drawn.pitch
        force = drawn.measured(drawn.map(x - lag * direction) + drawn.coulomb * direction)
        fit = fit_map(x, force, pitch=drawn.pitch, order=0)
        assert fit.direction_lag == pytest.approx(lag, rel=0.15), seed
        assert ("late each way" in fit.text()) == (lag > 0.0)
        ripple = scan_with(drawn, lambda x, d=drawn: d.wave(x, d.harmonics[0], 0.3 * d.size, d.phases[0]))
        assert ripple.direction_lag is None  # in phase with the map, where a lag would stand a quarter off
        assert "friction that ripples" in ripple.text()


# --- real scans -------------------------------------------------------------------------------------------------------


def odd_amplitude(x, force, direction, harmonics, which):
    """Amplitude of direction times a harmonic, by plain least squares beside all harmonics and both levels."""
    angles = np.outer(x, harmonics)
    waves = np.hstack([np.sin(angles), np.cos(angles)])
    columns = np.hstack([np.ones((x.size, 1)), direction[:, None], waves, direction[:, None] * waves])
    solved = np.linalg.lstsq(columns, force, rcond=None)[0]
    odd = solved[2 + 2 * len(harmonics) :]
    return float(np.hypot(odd[harmonics.index(which)], odd[len(harmonics) + harmonics.index(which)]))


@pytest.mark.data
def test_hysteresis_of_a_real_turn_and_back():
    rows = laas.read("stopped_data", FOLDER / "laas")
    fit = fit_map(rows.position, rows.current, pitch=laas.TURN)
    table = {entry.harmonic: entry.amplitude for entry in fit.direction_amplitudes}
    harmonics = [12, 18, 24, 36, 48, 54, 71, 72, 73, 144]
    for harmonic in (72, 144):
        plain = odd_amplitude(fit.position, fit.force, fit.direction, harmonics, harmonic)
        assert table[harmonic] == pytest.approx(plain, rel=0.05)
    assert table[72] == pytest.approx(0.0146, abs=0.001)  # 8 % of the map's own, a quarter of the friction
    assert max(table, key=table.get) == 72
    assert fit.coulomb == pytest.approx(0.053, abs=0.002)
    assert "change sign with the direction of motion (harmonics 72, 144" in fit.text()


def odrive(which):
    """Position (rad) and current (A) of the filled entries of a scan over one turn."""
    entries = np.load(FOLDER / "odrive" / f"cogging_measure_final_{which}_16.npy")
    filled = np.flatnonzero(entries)
    return filled * (2.0 * np.pi / entries.size), entries[filled]


@pytest.mark.data
def test_a_harmonic_of_the_other_way_that_stands_on_its_head():
    """7 a turn (of the neighbour motor) is as large both ways, and of the other sign: the mean of both has none."""
    there, back = odrive("a"), odrive("rev")
    position, current = (np.concatenate([one, other[::-1]]) for one, other in zip(there, back, strict=True))
    fit = fit_map(position, current, pitch=2.0 * np.pi)
    assert fit.coulomb == pytest.approx(0.17, abs=0.02)
    table = {entry.harmonic: entry.amplitude for entry in fit.amplitudes}
    assert 7 not in table
    assert [table[h] for h in (28, 14, 36, 12, 84)] == pytest.approx([0.56, 0.35, 0.29, 0.26, 0.12], rel=0.15)
    (entry,) = [entry for entry in fit.direction_amplitudes if entry.harmonic == 7]
    assert entry.amplitude == pytest.approx(0.875, abs=0.03)
    assert fit.direction_rms > 3.0 * fit.coulomb
    assert "0.624 V rms of the force change sign with the direction of motion (harmonics 7" in fit.text()
