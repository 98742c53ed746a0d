"""Replays of many models at once: each has the bits that it has alone, on any instruction set."""

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

SETS = ["none", *_core.instruction_sets()]
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
    assert (
        residual.tobytes() == replay.of([model])[0].tobytes() == (log.command - replay.run(model)["command"]).tobytes()
    )
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
