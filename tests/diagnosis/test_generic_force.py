"""Whether what is left is noise: predicted by a generic force where that was not fitted; `no_gap` is earned by it."""

from dataclasses import replace

import numpy as np
import pytest

import cogging
from cogging.diagnosis.entries import Gap
from cogging.diagnosis.generic_force import predicted
from cogging.diagnosis.named_effects import unlisted
from cogging.diagnosis.yardstick import BALANCED, Discrepancy
from tests.fixtures.pid_axis import MODEL, run


def gap_of(log, force, seed, size):
    """What is left where a force (V) of the reference acts that nobody knows of, with noise."""
    velocity = np.gradient(log.reference, log.time)
    rows = {"time": log.time, "position": log.reference, "velocity": velocity, "drive": log.command}
    rows["acceleration"] = np.gradient(velocity, log.time)
    left = force(rows) + size * np.random.default_rng(seed).standard_normal(len(log))
    return Discrepancy(BALANCED, (left,), (rows,), (np.abs(velocity) > 0.01,))


@pytest.mark.parametrize("coordinate", ["position", "acceleration"])
def test_a_force_of_any_shape_is_predicted_and_noise_is_not(coordinate):
    logs = run(duration=10.0), run(velocity=0.1, duration=10.0, seed=5)

    def force(rows):
        return np.abs(rows[coordinate] / np.max(np.abs(rows[coordinate])) - 0.3)

    given, confirm = (gap_of(log, force, number, 0.3) for number, log in enumerate(logs))
    told = predicted(given, confirm)
    assert told.curves[0].coordinate == coordinate
    assert told.within > 0.35
    assert told.elsewhere > 0.35
    assert told.noise == pytest.approx(0.3, rel=0.1)
    quiet = predicted(*(gap_of(log, lambda rows: 0.0 * rows["time"], 7 + n, 1.0) for n, log in enumerate(logs)))
    assert quiet.share == pytest.approx(0.0, abs=0.01)
    assert predicted(given).elsewhere is None
    gap, units = Gap("V", 0.1, 1.0, 1.0, None, None, "", share=0.45), MODEL.units
    assert unlisted([], told, gap, units, confirmed=True)["coordinate"] == coordinate
    assert unlisted([], quiet, replace(gap, floor=quiet.noise), units, confirmed=True) is None
    assert unlisted([], quiet, gap, units, confirmed=True) is not None  # half of the command is no noise
    assert unlisted([], quiet, replace(gap, share=0.2), units, confirmed=True) is None
    assert unlisted([], told, replace(gap, share=0.05), units, confirmed=True) is None  # small beside the command
    most = replace(gap, before=3.0, share=0.3)
    assert unlisted([], told, most, units, confirmed=True) is None  # most of it has a name
    large = unlisted([], told, replace(most, share=0.9), units, confirmed=True)
    assert large["coordinate"] == coordinate  # and yet the command is mostly unexplained


@pytest.mark.data
def test_half_of_the_command_is_no_noise(two_mass):
    """Two masses, log B with the mode stated: what is left is half of the command, and comes back each second."""
    mode = cogging.effects.FlexibleMode(frequency=76.5, damping_ratio=0.02, mass_ratio=0.5)
    axis = cogging.AxisParameters(mass=0.0103, viscous=0.02, coulomb=0.1, coulomb_width=0.05)
    model = cogging.Model(
        axis=axis,
        uncertainty={"mass": 0.3, "viscous": 1.0, "coulomb": 1.0},
        effects=[mode],
        units=cogging.Units(command="A", position="rad"),
    )
    result = cogging.diagnose(two_mass("B", slice(2500, 17500)), model)
    assert result.verdict == "unlisted"
    assert result.gap.share > 0.4
    assert result.unlisted["coordinate"]
