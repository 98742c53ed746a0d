"""Replays of many models at once: each has the bits that it has alone, on any instruction set."""

import re

import numpy as np
import pytest

import cogging
from cogging import Model, _core
from cogging.estimation.gauss_newton import columns_of
from cogging.estimation.replay import Replay
from cogging.model.model import CONTROLLERS
from cogging.model.parameters import central, parameters_of, with_values
from tests.fixtures.plants_by_hand import EXAMPLES, effect
from tests.golden.logs import CONTROLLERS as FIELDS

SETS = ["none", *_core.instruction_sets()]
MASS = 0.12
MOVE = cogging.Sine(cogging.SineParameters(center=0.05, amplitude=0.03, frequency=6.0))
EFFECTS = sorted(name for name in EXAMPLES if name not in {"presliding_friction", "backlash", "flexible_mode"})
READING = sorted(name for name in EFFECTS if "reading" in cogging.EFFECTS[name].HOOKS)


def drawn(kind, seed):
    """The replay of a log of a model with a few effects, one of them of the encoder, and the model."""
    rng = np.random.default_rng([seed, *kind.encode()])
    names = {*rng.choice(EFFECTS, size=2, replace=False), str(rng.choice(READING))}
    model = Model(
        axis=cogging.AxisParameters(
            mass=MASS * rng.uniform(0.8, 1.2),
            viscous=rng.uniform(0.2, 0.8),
            coulomb=rng.uniform(0.05, 0.15),
            coulomb_width=0.003 * rng.uniform(0.3, 3.0),
        ),
        effects=tuple(effect(name, **EXAMPLES[name][0]) for name in sorted(names)),
        controller=CONTROLLERS[kind][0](**FIELDS[kind] | {"command_limit": 0.0}),
        controller_type=kind,
    )
    log = cogging.simulate(model, MOVE, seed=seed, duration=0.12)
    added = 0.1 * rng.normal(size=len(log)) if seed % 2 else None
    return Replay(log, model, added_command=added), model


def step_of(replay, model, parameter):
    return central(model, parameter, replay.scales.step(parameter))


@pytest.mark.parametrize("kind", CONTROLLERS)
def test_models_side_by_side_have_the_bits_of_each_alone(kind, monkeypatch):
    replay, model = drawn(kind, len(kind))
    models = [model]
    for parameter in parameters_of(model).values():
        try:
            step = step_of(replay, model, parameter)
        except ValueError:  # one that no step may move
            continue
        models += [step.above, step.below]
    alone = np.array([replay.run(one)["command"] for one in models])
    assert len(np.unique(alone, axis=0)) > 9
    for instructions in SETS:
        monkeypatch.setenv("COGGING_INSTRUCTIONS", instructions)
        assert replay.of(models).tobytes() == (replay.log.command - alone).tobytes()


@pytest.mark.parametrize("instructions", SETS)
def test_derivatives_and_errors_are_those_of_single_replays(instructions, monkeypatch):
    monkeypatch.setenv("COGGING_INSTRUCTIONS", instructions)
    replay, model = drawn("pid", 1)
    known = parameters_of(model)
    moved = [known[path] for path in ("axis.mass", "axis.viscous", "axis.coulomb", "axis.coulomb_width")]
    (residual,), (columns,) = columns_of(model, moved, [replay], replay.scales)
    assert residual.tobytes() == replay.of([model])[0].tobytes()
    for parameter, column in zip(moved, columns, strict=True):
        step = step_of(replay, model, parameter)
        above, below = replay.of([step.above])[0], replay.of([step.below])[0]
        assert column.tobytes() == ((above - below) / step.span).tobytes()
    models = [with_values(model, {"axis.mass": MASS * (1.0 + 0.01 * i)}) for i in range(10)]
    models[9] = with_values(model, {"axis.mass": 1e-4, "axis.coulomb": 0.0})
    with pytest.raises(cogging.DivergedError) as alone:
        replay.of(models[9:])
    with pytest.raises(cogging.DivergedError, match=re.escape(str(alone.value))):
        replay.of(models)
    short = Replay(replay.log, model, added_command=np.zeros(5))
    for models in ([model], [model] * 10):
        with pytest.raises(ValueError, match=r"^added_command: must have an entry for each row, got 5$"):
            short.of(models)
