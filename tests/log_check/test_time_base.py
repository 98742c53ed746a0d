"""Noisy time stamps of a uniform clock, and rows that were really sampled at uneven times: which is which."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import cogging
from cogging.log_check.controller_samples import on_its_clock
from tests.fixtures.strokes import as_believed, drawn

STEP = 1e-3  # s


@pytest.fixture(scope="module")
def strokes():
    return drawn(1, "nothing")


def jitter(log, seed=0, share=0.3):
    time = log.time + share * STEP * np.random.default_rng(seed).uniform(-1.0, 1.0, len(log))
    return replace(log, time=np.maximum.accumulate(time))


def taken_at(log, time):
    """The same motion, read and logged at other times."""
    acted = np.append(0.0, np.cumsum(log.command * STEP))
    upto = np.interp(np.append(time, time[-1] + STEP), np.append(log.time, log.time[-1] + STEP), acted)
    position = np.round(CubicSpline(log.time, log.position)(time) / 2e-7) * 2e-7
    reference = CubicSpline(log.time, log.reference)(time)
    return cogging.Log(time, position, np.diff(upto) / np.diff(np.append(time, time[-1] + STEP)), reference)


#: How the stamps of an even clock are spoiled, and by how much of a step the clock that is found may be off.
SPOILED = {
    "slightly noisy": (lambda log: jitter(log, share=0.05), 0.02),
    "noisy": (jitter, 0.02),
    "rounded": (lambda log: replace(log, time=np.round(log.time / 3e-4) * 3e-4), 0.2),
}


@pytest.mark.parametrize("kind", SPOILED)
def test_spoiled_stamps_give_way_to_the_clock(strokes, kind):
    """Which counts the rows that were lost."""
    spoil, off = SPOILED[kind]
    log, kept = strokes[1], np.ones(len(strokes[1]), dtype=bool)
    found, note = on_its_clock(spoil(log))
    assert np.abs(found.time - log.time).max() < off * STEP
    assert "even clock of 0.001 s" in note
    kept[[900, 901, 1500]] = kept[2000:2100] = False
    assert np.abs(on_its_clock(spoil(log)[kept])[0].time - log.time[kept]).max() < max(off, 0.1) * STEP


@pytest.mark.parametrize("way", ["even", "about an even clock", "step by step"])
def test_rows_that_were_taken_when_they_say_keep_their_stamps(strokes, way):
    log, random = strokes[1], np.random.default_rng(2)
    if way == "step by step":
        time = np.cumsum(STEP * (1.0 + 0.3 * random.uniform(-1.0, 1.0, len(log))))
        log = taken_at(log, time[time < log.time[-1]])
    elif way == "about an even clock":
        log = taken_at(log, np.clip(log.time + 0.3 * STEP * random.uniform(-1.0, 1.0, len(log)), 0.0, log.time[-1]))
    assert on_its_clock(log) == (log, "")


def test_a_mass_is_found_from_stamps_that_jitter_by_three_tenths_of_a_step(strokes):
    machine, log = strokes
    noisy = jitter(log, 1)
    found = cogging.identify(noisy, as_believed(machine, noisy))
    mass = found["axis.mass"]
    assert mass.value == pytest.approx(machine.axis.mass, rel=0.005)
    assert mass.ci95[0] < machine.axis.mass < mass.ci95[1]
    assert mass.ci95[1] - mass.ci95[0] < 0.02 * machine.axis.mass
    assert found.warnings == ()
    assert any("even clock" in note for note in found.notes)
    assert cogging.draft_model(noisy).model.axis.mass == pytest.approx(machine.axis.mass, rel=0.1)
