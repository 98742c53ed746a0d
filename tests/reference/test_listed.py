"""Contract of every motion of the list: derivatives, end, period, and its fields in a file and back."""

import math

import numpy as np
import pytest

import cogging
from cogging.files import FieldError
from cogging.simulation.reference import REFERENCES, reference_from, reference_to_dict

EVERY = pytest.mark.parametrize("kind", REFERENCES)


def made(kind, seed):
    """A motion with fields drawn about their defaults: numbers by up to a factor of 2, counts as they are."""
    struct, motion = REFERENCES[kind]
    rng = np.random.default_rng([seed, *kind.encode()])
    drawn = {
        name: value * float(rng.uniform(0.5, 2.0))
        for name, value in struct().to_dict().items()
        if isinstance(value, float) and math.isfinite(value)
    }
    return motion(struct(**drawn))


@EVERY
@pytest.mark.parametrize("seed", range(3))
def test_velocity_and_acceleration_are_derivatives(kind, seed):
    """By central differences, but for the few places at which a piece of the motion ends."""
    motion, step = made(kind, seed), 1e-5
    end = min(motion.end, 3.0 * min(motion.period, 1.0))
    times = np.random.default_rng(seed).uniform(step, end - step, 500)
    before, at, after = (motion.sample(times + shift) for shift in (-step, 0.0, step))
    for i in range(2):
        slope = (after[i] - before[i]) / (2.0 * step)
        size = np.abs(at[i + 1]).max()
        assert np.quantile(np.abs(slope - at[i + 1]), 0.97) < 1e-4 * size + 1e-8
    assert np.abs(at[1]).max() > 0.0


@EVERY
def test_end_and_period(kind):
    motion = made(kind, 7)
    if math.isfinite(motion.end):
        position, velocity, acceleration = motion.sample(motion.end + np.array([0.0, 0.1, 10.0]))
        assert not np.ptp(position)
        assert not velocity.any()
        assert not acceleration.any()
    if math.isfinite(motion.period):
        last = motion.end if math.isfinite(motion.end) else 50.0 * motion.period  # any start-up has died away
        times = last - motion.period * np.linspace(0.01, 0.99, 37)
        struct, again = REFERENCES[kind]
        repeats = {"repeats": 2} if "repeats" in struct.FIELDS else {}
        longer = again(motion.parameters.replace(**repeats))
        for first, second in zip(longer.sample(times), longer.sample(times + motion.period), strict=True):
            np.testing.assert_allclose(first, second, atol=1e-7 * (1e-3 + np.abs(first).max()))


@EVERY
def test_a_file_and_back(kind):
    motion = made(kind, 3)
    fields = reference_to_dict(motion)
    assert fields["type"] == kind == motion.NAME
    again, duration = reference_from({**fields, "duration": 0.5})
    assert (again.parameters, duration) == (motion.parameters, 0.5)
    if math.isfinite(motion.end):
        assert reference_from(fields)[1] == 0.0
    else:
        with pytest.raises(FieldError, match="duration: must be given for a motion without an end, got none"):
            reference_from(fields)
    (entry,) = [
        one for one in cogging.schema()["$defs"]["reference"]["oneOf"] if one["properties"]["type"]["const"] == kind
    ]
    assert set(entry["properties"]) == {"type", "duration", *REFERENCES[kind][0].FIELDS}
    assert ("duration" in entry["required"]) is math.isinf(motion.end)
