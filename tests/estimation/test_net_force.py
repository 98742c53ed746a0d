"""Net forces of many plants along one motion: each has the bits that it has alone, on any instruction set."""

import numpy as np
import pytest

from cogging import _core
from tests.simulation.test_lanes import SETS, drawn_family

ROWS = 700


def drawn(seed):
    """A log, a motion half-way between its rows, and plants: some share a course, others are alone."""
    rng, (plants, *_) = np.random.default_rng(seed), drawn_family("pid", seed)
    time = np.cumsum(rng.uniform(0.8e-3, 1.2e-3, ROWS))
    position = 0.05 + 0.03 * np.sin(40.0 * time) + 1e-5 * rng.normal(size=ROWS)
    predictor = _core.Predictor(time, position, 3.0 * rng.normal(size=ROWS))
    return predictor, position, np.gradient(position, time), plants


@pytest.mark.parametrize("seed", range(12))
def test_plants_side_by_side_have_the_bits_of_each_alone(seed, monkeypatch):
    predictor, position, velocity, plants = drawn(seed)
    alone = np.concatenate([predictor.net_force([plant], position, velocity) for plant in plants])
    assert len(np.unique(alone, axis=0)) == len(plants)
    for number, instructions in enumerate(SETS):
        monkeypatch.setenv("COGGING_INSTRUCTIONS", instructions)
        together = predictor.net_force(plants, position, velocity, threads=1 + (seed + number) % 3)
        assert together.tobytes() == alone.tobytes()
        for name, motion in (("position", (position[1:], velocity)), ("velocity", (position, velocity[1:]))):
            with pytest.raises(ValueError, match=rf"^middle_{name}: must be as long as the log, got 699$"):
                predictor.net_force(plants, *motion)
