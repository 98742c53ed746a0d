"""Net forces of many plants along one motion: each has the bits that it has alone, on any instruction set."""

import numpy as np
import pytest

import cogging
from cogging import _core
from tests.fixtures.plants_by_hand import EXAMPLES, example, varied

SETS = ["none", *_core.instruction_sets()]
ROWS, MASS = 700, 0.3


def drawn(seed):
    """A log, a motion half-way between its rows, and plants: some share a course, others are alone."""
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(0.8e-3, 1.2e-3, ROWS))
    position = 0.05 + 0.03 * np.sin(40.0 * time) + 1e-5 * rng.normal(size=ROWS)
    predictor = _core.Predictor(time, position, 3.0 * rng.normal(size=ROWS))
    names = {str(name) for name in rng.choice(sorted(EXAMPLES), size=int(rng.integers(1, 5)), replace=False)}
    names -= {"backlash"} if names >= {"backlash", "flexible_mode"} else set()
    basis = cogging.SplineHarmonics(pitch=0.02, harmonics=[1, 3], order=int(rng.integers(1, 5)), control_points=9)
    is_sticking, is_varied = rng.random() < 0.3, rng.random() < 0.7
    plants = []
    for i in range(int(rng.integers(2, 25))):
        axis = cogging.AxisParameters(
            mass=MASS * rng.uniform(0.9, 1.1),
            viscous=rng.uniform(0.2, 0.6),
            coulomb=rng.choice([0.0, rng.uniform(0.05, 0.15)]),
            coulomb_width=0.0 if is_sticking and i % 3 == 0 else rng.uniform(1e-3, 1e-2),
            travel=[-0.2, 0.6],
        )
        effects = [example(name) for name in sorted(names)]
        effects = [varied(one, rng) for one in effects] if is_varied else effects
        cogging_model = cogging.CoggingModel(basis, *(0.05 * rng.normal(size=(2, 2, 9))))
        plants.append(cogging.Plant(axis, cogging=cogging_model, effects=effects))
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
