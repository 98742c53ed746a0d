"""Stamps that are noisy of an even clock are told from rows that were taken as unevenly as they are stamped."""

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


def jittered(log, seed=0, share=0.3):
    time = log.time + share * STEP * np.random.default_rng(seed).uniform(-1.0, 1.0, len(log))
    return replace(log, time=np.maximum.accumulate(time))


def taken_at(log, time):
    """The same motion, read and logged at other times."""
    acted = np.append(0.0, np.cumsum(log.command * STEP))
    upto = np.interp(np.append(time, time[-1] + STEP), np.append(log.time, log.time[-1] + STEP), acted)
    position = np.round(CubicSpline(log.time, log.position)(time) / 2e-7) * 2e-7
    reference = CubicSpline(log.time, log.reference)(time)
    return cogging.Log(time, position, np.diff(upto) / np.diff(np.append(time, time[-1] + STEP)), reference)


def test_even_stamps_stand(strokes):
    assert on_its_clock(strokes[1]) == (strokes[1], "")


@pytest.mark.parametrize("share", [0.05, 0.3])
def test_noisy_stamps_give_way_to_the_clock(strokes, share):
    log = strokes[1]
    found, said = on_its_clock(jittered(log, share=share))
    assert np.abs(found.time - log.time).max() < 0.02 * STEP
    assert "even clock of 0.001 s" in said


def test_stamps_that_were_rounded_give_way_to_the_clock(strokes):
    log = strokes[1]
    found, said = on_its_clock(replace(log, time=np.round(log.time / 3e-4) * 3e-4))
    assert np.abs(np.diff(found.time) - STEP).max() < 1e-6
    assert said


def test_the_clock_counts_rows_that_were_lost(strokes):
    log = jittered(strokes[1])
    kept = np.ones(len(log), dtype=bool)
    kept[[900, 901, 1500]] = kept[2000:2100] = False
    found, said = on_its_clock(cogging.Log.of({name: column[kept] for name, column in log.columns().items()}))
    assert np.abs(found.time - strokes[1].time[kept]).max() < 0.1 * STEP
    assert said


@pytest.mark.parametrize("way", ["about an even clock", "step by step"])
def test_rows_that_were_taken_unevenly_keep_their_stamps(strokes, way):
    log, random = strokes[1], np.random.default_rng(2)
    if way == "step by step":
        time = np.cumsum(STEP * (1.0 + 0.3 * random.uniform(-1.0, 1.0, len(log))))
        time = time[time < log.time[-1]]
    else:
        time = np.clip(log.time + 0.3 * STEP * random.uniform(-1.0, 1.0, len(log)), 0.0, log.time[-1])
    uneven = taken_at(log, time)
    assert on_its_clock(uneven) == (uneven, "")


@pytest.mark.parametrize("seed", range(2))
def test_a_mass_is_found_from_stamps_that_jitter_by_three_tenths_of_a_step(seed):
    machine, log = drawn(seed, "nothing")
    noisy = jittered(log, seed)
    found = cogging.identify(noisy, as_believed(machine, noisy))
    mass = found["axis.mass"]
    assert mass.value == pytest.approx(machine.axis.mass, rel=0.005)
    assert mass.ci95[0] < machine.axis.mass < mass.ci95[1]
    assert mass.ci95[1] - mass.ci95[0] < 0.02 * machine.axis.mass
    assert found.warnings == ()
    assert any("even clock" in note for note in found.notes)
    assert cogging.draft_model(noisy).model.axis.mass == pytest.approx(machine.axis.mass, rel=0.1)
