"""Replays and net forces of many machines at once: each has the bits that it has alone, on any instruction set."""

import re

import numpy as np
import pytest

import cogging
from cogging import _core
from cogging.estimation.gauss_newton import columns_of
from cogging.estimation.replay import Replay
from cogging.model.parameters import central, parameters_of, with_values
from tests.fixtures.plants_by_hand import example
from tests.golden.logs import CONTROLLERS as FIELDS
from tests.simulation.test_lanes import SETS, drawn_family

MOVE = cogging.Sine(cogging.SineParameters(center=0.05, amplitude=0.03, frequency=6.0))
MOVED = ("axis.mass", "axis.viscous", "axis.coulomb", "axis.coulomb_width")


@pytest.mark.parametrize("instructions", SETS)
def test_derivatives_and_errors_are_those_of_single_replays(instructions, monkeypatch):
    monkeypatch.setenv("COGGING_INSTRUCTIONS", instructions)
    model = cogging.Model(
        axis=cogging.AxisParameters(mass=0.12, viscous=0.4, coulomb=0.1, coulomb_width=3e-3),
        effects=[example("cable_spring"), example("encoder_periodic_error")],
        controller=cogging.PidParameters(**FIELDS["pid"] | {"command_limit": 0.0}),
        controller_type="pid",
    )
    log = cogging.simulate(model, MOVE, seed=1, duration=0.12)
    replay = Replay(log, model, added_command=0.1 * np.random.default_rng(1).normal(size=len(log)))
    moved = [parameters_of(model)[path] for path in MOVED]
    (residual,), (columns,) = columns_of(model, moved, [replay], replay.scales)
    assert residual.tobytes() == replay.of([model])[0].tobytes()
    assert residual.tobytes() == (log.command - replay.run(model)["command"]).tobytes()
    for parameter, column in zip(moved, columns, strict=True):
        step = central(model, parameter, replay.scales.step(parameter))
        above, below = replay.of([step.above])[0], replay.of([step.below])[0]
        assert column.tobytes() == ((above - below) / step.span).tobytes()
    models = [with_values(model, {"axis.mass": 0.12 * (1.0 + 0.01 * i)}) for i in range(10)]
    models[9] = with_values(model, {"axis.mass": 1e-4, "axis.coulomb": 0.0})
    with pytest.raises(cogging.DivergedError) as alone:
        replay.of(models[9:])
    with pytest.raises(cogging.DivergedError, match=re.escape(str(alone.value))):
        replay.of(models)
    short = Replay(log, model, added_command=np.zeros(5))
    for models in ([model], [model] * 10):
        with pytest.raises(ValueError, match=r"^added_command: must have an entry for each row, got 5$"):
            short.of(models)


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
