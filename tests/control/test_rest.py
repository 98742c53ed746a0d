"""At rest exactly where a motion began: decaying states end at 0, and no state is a denormal number."""

import numpy as np
import pytest

from cogging.model.model import CONTROLLERS
from tests.control.test_faulty_readings import ask
from tests.fixtures.covering import covering
from tests.golden.logs import CONTROLLERS as FIELDS

RATE, RESOLUTION = 5000.0, 0.5e-6
SMALLEST = np.finfo(float).tiny


def states_at_rest(kind, start):
    """The states of a controller, ten times a second over 5 s after a drawn motion from `start`."""
    rng = np.random.default_rng([*kind.encode()])
    struct, made = CONTROLLERS[kind]
    controller = made(struct(**FIELDS[kind]))
    count, (size, turns) = 2000, rng.uniform([1e-3, 1.0], [2e-2, 3.0])
    w, t = 2 * np.pi * round(turns) * RATE / count, np.arange(count) / RATE
    lags = RESOLUTION * rng.integers(-4, 5, count)
    lags[0] = 0.0  # positions of the output feedback count from here
    for time, lag in zip(t, lags, strict=True):
        x = size * (1 - np.cos(w * time))
        point = (start + x, size * w * np.sin(w * time), size * w**2 * np.cos(w * time))
        controller.update(ask(controller, point, start + x + lag))
    states = []
    for k in range(int(5 * RATE)):
        controller.update(ask(controller, (start, 0.0, 0.0), start))
        if k % 500 == 0:
            states.append(controller.__getstate__()[1])
    return np.array(states)


@pytest.mark.parametrize(("kind", "start"), covering(FIELDS, [0.0, 0.2]))
def test_no_state_is_denormal(kind, start):
    states = states_at_rest(kind, start)
    size = np.abs(states)
    assert np.isfinite(size).all()
    assert not ((size > 0.0) & (size < SMALLEST)).any()
    if kind == "output_feedback_arc":  # eta falls by 1/e in 5 ms: after 5 s it would be exp(-1000) of what it was
        assert np.count_nonzero((states[0] != 0.0) & (states[-1] == 0.0)) >= (2 if start else 0)
        assert size[-1].max() > 0.1
