"""Force noise of the truth: coloured, sometimes 1/f-like, resonant or with heavy tails."""

import numpy as np
from scipy.signal import lfilter

#: Families of force noise.
COLOURS = ("first_order", "second_order", "pink", "heavy_tails", "broad")
DRAWN_COLOURS = (*COLOURS, "mixture")  # and one that is never the same twice


def draw_noise(
    rng: np.random.Generator, colour: str, count: int, sample_time: float, rms: float, corner: float
) -> np.ndarray:
    """Draw `count` samples of force noise of the given rms; corner (Hz) is the bandwidth or the resonance."""
    lead = int(2.0 / sample_time)
    white = rng.standard_normal(count + lead)
    if colour == "heavy_tails":
        white = rng.standard_t(4.0, count + lead) / np.sqrt(2.0)
    if colour in ("first_order", "heavy_tails"):
        shaped = _first_order(white, corner, sample_time)
    elif colour == "second_order":
        pole = np.exp((-0.25 + 1j * np.sqrt(1 - 0.25**2)) * 2 * np.pi * corner * sample_time)
        shaped = lfilter([1.0], np.poly([pole, pole.conjugate()]).real, white)
        shaped /= shaped.std()
        shaped += 0.3 * _first_order(rng.standard_normal(count + lead), 4 * corner, sample_time)
    elif colour == "pink":
        shaped = sum(
            _first_order(rng.standard_normal(count + lead), f, sample_time)
            for f in (0.5 * corner / 10, 0.5 * corner / 2, 2 * corner)
        )
    elif colour == "mixture":  # of some resonances and slopes, wide and narrow
        shaped = np.zeros(count + lead)
        for _ in range(int(rng.integers(2, 5))):
            frequency = corner * np.exp(rng.uniform(-1.5, 1.0))
            damping, size = rng.uniform(0.15, 0.9), rng.uniform(0.3, 1.0)
            pole = np.exp((-damping + 1j * np.sqrt(1 - damping**2)) * 2 * np.pi * frequency * sample_time)
            part = lfilter([1.0], np.poly([pole, pole.conjugate()]).real, rng.standard_normal(count + lead))
            shaped += size * part / part.std()
    elif colour == "broad":
        shaped = 0.5 * white + _first_order(rng.standard_normal(count + lead), corner, sample_time)
    else:
        raise ValueError(f"colour: must be one of {', '.join(COLOURS)}, got {colour!r}")
    shaped = shaped[lead:]
    return rms * shaped / np.sqrt(np.mean(shaped**2))


def _first_order(white: np.ndarray, corner: float, sample_time: float) -> np.ndarray:
    pole = np.exp(-2 * np.pi * corner * sample_time)
    return lfilter([np.sqrt(1 - pole**2)], [1.0, -pole], white)
