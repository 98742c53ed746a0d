"""The pictures of docs/plot.md: `python docs/pictures/plot.py`, from the repository."""

import io
from pathlib import Path

import numpy as np
from PIL import Image

import cogging
from cogging.plot.shown_figure import picture

HERE = Path(__file__).parent
MOVE = {"type": "point_to_point", "start": 0.05, "distance": 0.2, "velocity": 0.4, "acceleration": 8.0, "jerk": 800.0}
MOVE |= {"dwell": 0.1, "repeats": 4}


def machine():
    """An axis whose cogging no controller below knows before it starts."""
    basis = cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2])
    return cogging.Model(
        axis=cogging.AxisParameters(mass=0.12, viscous=0.166, coulomb=0.15, coulomb_width=0.01, travel=[0.0, 0.51]),
        cogging=cogging.CoggingModel(basis, [[0.08], [0.03]], [[0.0], [0.02]]),
        encoder=cogging.EncoderParameters(resolution=0.5e-6),
        noise=cogging.NoiseParameters(force=0.01, bandwidth=50.0),
    )


def learning():
    """A run of an adaptive controller that learns the cogging, with its estimates; the bounds are tight."""
    parameters = cogging.AdaptiveRobustParameters(
        mass=0.12, viscous=0.166, coulomb=0.15, cogging_harmonics=[1, 2], cogging_adaptation=100.0,
        cogging_bounds=(-0.06, 0.06), epsilon=0.1,
    )  # fmt: skip
    return cogging.simulate(machine(), MOVE, controller=cogging.Dcarc(parameters), record_estimates=True, seed=1)


def scan():
    """A map fitted to a scan there and back with noise."""
    x = np.concatenate([np.linspace(0.0, 0.2, 81), np.linspace(0.2, 0.0, 81)])
    rng = np.random.default_rng(1)
    friction = 0.15 * np.repeat([1.0, -1.0], 81)
    return cogging.fit_map(x, machine().cogging.force(x) + friction + 0.03 * rng.normal(size=x.size), pitch=0.05)


def main():
    """Write them all."""
    run = learning()
    figures = {
        "log": cogging.plot.log(run, ["position", "error", "command"]).figure,
        "map": cogging.plot.cogging_map(scan()).figure,
        "adaptation": cogging.plot.adaptation(run, which=["sine 1", "cosine 1", "sine 2", "cosine 2"]).figure,
    }
    for name, figure in figures.items():
        path = HERE / f"plot_{name}.png"
        image = Image.open(io.BytesIO(picture(figure))).convert("RGB")
        image.quantize(64, dither=Image.Dither.NONE).save(path, optimize=True)
        print(f"{path.name}: {path.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
