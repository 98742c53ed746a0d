"""Whether what is left is noise: predicted by a generic force where that was not fitted; `no_gap` is earned by it."""

from dataclasses import replace

import numpy as np
import pytest

import cogging
from cogging.diagnosis.discrepancy import Discrepancy
from cogging.diagnosis.entries import Gap
from cogging.diagnosis.naming.verdict import not_noise
from cogging.diagnosis.predictable import predicted
from tests.fixtures.measured import FOLDER, needs
from tests.fixtures.pid_axis import run


def logged(log, force, seed, size=1.0):
    """The log with a force in its command that the model lacks, towards -x, and noise; and what is left of it."""
    series = force + size * np.random.default_rng(seed).standard_normal(len(log))
    rows = np.abs(np.gradient(log.reference, log.time)) > 0.01
    gap = Discrepancy(float(np.std(series[rows])), "command of the replayed loop", (series,), (rows,), 1e-6)
    return cogging.Log.of({**log.columns(), "command": log.command + series}), gap


@pytest.mark.parametrize("coordinate", ["position", "velocity", "acceleration"])
def test_a_force_of_any_shape_is_predicted_and_noise_is_not(coordinate):
    """Over other strokes, at speeds and accelerations that the given log has: of others it says nothing."""
    there, elsewhere, largest = [], [], {"position": 0.4, "velocity": 0.25, "acceleration": 3.0}[coordinate]
    for number, log in enumerate((run(duration=4.0), run(start=0.12, distance=0.25, seed=5))):
        velocity = np.gradient(log.reference, log.time)
        values = {"position": log.reference, "velocity": velocity, "acceleration": np.gradient(velocity, log.time)}
        force = np.abs(values[coordinate] / largest - 0.3)  # the same law on both
        there.append(logged(log, force, number, 0.3))
        elsewhere.append(logged(log, np.zeros(len(log)), 7 + number))
    (log, given), (other, confirm) = there
    told = predicted([log], given, [other], confirm)
    assert told.shape.coordinate == coordinate
    assert told.within > 0.4
    assert told.elsewhere > 0.4
    (log, given), (other, confirm) = elsewhere
    quiet = predicted([log], given, [other], confirm)
    assert quiet.share == pytest.approx(0.0, abs=0.01)
    assert predicted([log], given).elsewhere is None
    gap = Gap("V", 0.1, 1.0, 1.0, None, None, "", share=0.45)
    assert not_noise(told, gap)["coordinate"] == coordinate
    assert not_noise(quiet, gap) is None
    assert not_noise(told, replace(gap, share=0.05)) is None  # small beside the command
    assert not_noise(told, replace(gap, before=3.0)) is None  # most of it has a name


def test_a_result_holds_what_each_effect_takes_and_what_is_left(found):
    told = found.to_dict()
    (effect,) = told["effects"]
    gap = told["gap"]
    assert effect["share"] == pytest.approx(1.0 - (gap["after"] / gap["before"]) ** 2)
    log, mask = found.series["logs"][0], found.series["mask"][0]
    assert gap["share"] == pytest.approx(gap["after"] / np.sqrt(np.mean(log.command[mask] ** 2)), rel=1e-2)
    assert 0.0 <= gap["predictable"] < 0.2
    alone = cogging.diagnose(run(duration=3.0), found.series["given"])
    assert alone.verdict == "no_gap"
    assert alone.to_dict()["gap"]["predictable"] is None


@pytest.mark.data
def test_half_of_the_command_is_no_noise():
    """Two masses, log B with the mode stated: what is left is half of the command, and comes back each second."""
    needs("two_mass")
    from scipy.io import loadmat

    rows = slice(2500, 17500)
    columns = loadmat(FOLDER / "two_mass" / "MultisineTypeB.mat", squeeze_me=True)
    log = cogging.Log(
        *(np.ravel(columns[name])[rows] * k for name, k in (("time", 1e-6), ("theta_mx", 1), ("iq_adx", 1)))
    )
    mode = cogging.effects.FlexibleMode(frequency=76.5, damping_ratio=0.02, mass_ratio=0.5)
    axis = cogging.AxisParameters(mass=0.0103, viscous=0.02, coulomb=0.1, coulomb_width=0.05)
    model = cogging.Model(
        axis=axis,
        uncertainty={"mass": 0.3, "viscous": 1.0, "coulomb": 1.0},
        effects=[mode],
        units=cogging.Units(command="A", position="rad"),
    )
    result = cogging.diagnose(log, model)
    assert result.verdict == "unlisted"
    assert result.gap.share > 0.4
    assert result.unlisted["coordinate"]
