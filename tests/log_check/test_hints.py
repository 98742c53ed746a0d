"""What an audit found is repeated where it bears on the verdict, and only there."""

from dataclasses import replace

import numpy as np
import pytest

import cogging
from cogging import Log
from cogging.log_check.log_audit import hints
from tests.fixtures import moving_axis

STEP, RANDOM = 1.0 / moving_axis.RATE, np.random.default_rng(5).uniform(-1.0, 1.0, 10_000)
UNCONTROLLED = moving_axis.machine().replace(controller=None, controller_type=None)


@pytest.fixture(scope="module")
def log():
    return moving_axis.record(moving_axis.machine(), 3)


def rest(log, share):
    """The log with so many rows at rest after it."""
    more = int(len(log) * share / (1.0 - share))
    time = np.concatenate([log.time, log.time[-1] + STEP * np.arange(1, more + 1)])
    position = np.concatenate([log.position, np.full(more, log.position[-1])])
    return Log(time, position, np.concatenate([log.command, np.zeros(more)]))


#: How a log is changed, how much a hint needs, and what is too little for one.
CASES = {
    "limit": (lambda log, much: replace(log, command=np.clip(log.command, -much, much)), 2.0, 50.0),
    "at rest": (rest, 0.8, 0.1),
    "missing": (lambda log, much: log[np.arange(len(log)) % 100 >= much], 8, 0),
    "uneven": (lambda log, much: replace(log, time=log.time + much * STEP * RANDOM[: len(log)]), 0.2, 0.001),
    "step by": (lambda log, much: replace(log, position=much * np.round(log.position / much)), 1e-6, 1e-7),
}


@pytest.mark.parametrize("words", CASES)
def test_a_hint_is_given_where_it_matters(words, log):
    change, much, little = CASES[words]
    many, few = (hints(cogging.audit(change(log, size)), UNCONTROLLED) for size in (much, little))
    (hint,) = [one for one in many if words in one]
    assert any(character.isdigit() for character in hint)
    assert not any(words in one for one in few)
    assert hints(cogging.audit(log), UNCONTROLLED) == []


def test_identify_repeats_a_hint(log):
    coarse = replace(log, position=1e-6 * np.round(log.position / 1e-6))
    found = cogging.identify(coarse, UNCONTROLLED, free=["axis.mass"])
    assert any("readings step by 1e-06 m" in note for note in found.notes)


def test_a_time_in_ms_names_the_option_whatever_ends_the_call(log):
    """No controller or reference betrays it."""
    try:
        notes = cogging.diagnose(Log(1e3 * log.time, log.position, log.command), UNCONTROLLED).notes
    except cogging.DivergedError as error:
        notes = (str(error),)
    assert "--scale time=0.001" in " ".join(notes)
