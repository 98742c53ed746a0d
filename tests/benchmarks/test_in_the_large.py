"""The machines of `in_the_large` are what they say: a least squares and a frequency response find what was put in."""

import numpy as np
import pytest
from scipy.signal import csd, welch

import cogging
from tests.benchmarks.in_the_large import QUANTUM, harmonic_logs, motor, multisine, resonance_logs, tell, two_masses


@pytest.mark.parametrize("scale", [0.03, 0.3])
def test_the_harmonic_is_as_large_as_the_scale_says(scale):
    log, confirm = harmonic_logs(scale)
    for one, speed in ((log, 0.63), (confirm, 0.19)):
        assert one.reference is None
        np.testing.assert_allclose(one.position / QUANTUM, np.rint(one.position / QUANTUM), atol=1e-6)
        velocity = np.gradient(one.position, one.time)
        smooth = np.convolve(velocity, np.ones(41) / 41, "same")
        axis = motor().axis
        even = np.abs(np.abs(smooth) - speed) < 0.15 * speed
        rest = (one.command - axis.viscous * smooth - axis.coulomb * np.sign(smooth))[even]
        waves = np.column_stack([np.sin(7 * one.position), np.cos(7 * one.position)])[even]
        found = np.linalg.lstsq(waves, rest, rcond=None)[0]
        assert np.hypot(*found) == pytest.approx(0.79 * scale, rel=0.1)
        assert even.sum() > 1000


@pytest.mark.parametrize(("frequency", "load"), [(40.0, 0.6), (90.0, 0.3)])
def test_the_resonance_lies_within_the_band(frequency, load):
    """Of position over command: a dip at f (1 - load)^(1/2), where the load holds the motor still, a peak at f."""
    log, _ = resonance_logs(1.0, frequency, load)
    assert log.reference is None
    _, power = welch(log.command, 1000.0, nperseg=2000)
    f, cross = csd(log.command, np.gradient(np.gradient(log.position, log.time), log.time), 1000.0, nperseg=2000)
    inside = (f > 0.6 * frequency * np.sqrt(1 - load)) & (f < 1.3 * frequency)
    gain = np.abs(cross / power)[inside]
    assert f[inside][np.argmin(gain)] == pytest.approx(frequency * np.sqrt(1 - load), rel=0.03)
    assert f[inside][np.argmax(gain)] == pytest.approx(frequency, rel=0.03)
    assert gain.max() > 10 * gain.min()


def test_the_multisine_is_as_large_as_the_scale_says():
    one, other = multisine(1, 3.0), multisine(2, 3.0)
    assert np.sqrt(np.mean(one**2)) == pytest.approx(3.0, rel=0.1)
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.2


def test_a_case_is_told_on_one_line():
    log, confirm = resonance_logs(1.0, 60.0, 0.45)
    short = cogging.Log(log.time[:600], log.position[:600], log.command[:600])
    line = tell(short, confirm, two_masses())
    assert "\n" not in line
    assert line.startswith("insufficient_excitation: nothing; gap ")
    assert "mass 0.5, viscous 1, coulomb 0.1" in line
