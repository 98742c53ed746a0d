"""What an audit found is repeated where it bears on the verdict, and only there."""

from dataclasses import replace

import numpy as np
import pytest

import cogging
from cogging import Log
from cogging.diagnosis.preparation import prepared
from cogging.identification.identification import identify
from cogging.log_check.log_audit import hints
from tests.fixtures import moving_axis


@pytest.fixture(scope="module")
def log():
    return moving_axis.record(moving_axis.machine(), 3)


def said(log, model=None):
    return hints(cogging.audit(log), model or moving_axis.machine())


def jittered(log, share):
    random = np.random.default_rng(5)
    return replace(log, time=log.time + share * 1e-3 * random.uniform(-1.0, 1.0, len(log)))


def resting(log, share):
    """The log with so many rows at rest after it."""
    more = int(len(log) * share / (1.0 - share))
    time = np.concatenate([log.time, log.time[-1] + 1e-3 * np.arange(1, more + 1)])
    position = np.concatenate([log.position, np.full(more, log.position[-1])])
    return Log(time, position, np.concatenate([log.command, np.zeros(more)]))


CASES = {
    "limit": (lambda log, much: replace(log, command=np.clip(log.command, -much, much)), 2.0, 50.0),
    "at rest": (resting, 0.8, 0.1),
    "missing": (lambda log, much: log[np.arange(len(log)) % 100 >= much], 8, 0),
    "uneven": (jittered, 0.2, 0.001),
    "if the time is in ms": (lambda log, much: replace(log, time=much * log.time), 1000.0, 10.0),
    "step by": (lambda log, much: replace(log, position=much * np.round(log.position / much)), 1e-6, 1e-7),
}


@pytest.mark.parametrize("what", CASES)
def test_a_hint_is_given_where_it_matters(what, log):
    spoiled, much, little = CASES[what]
    (hint,) = [hint for hint in said(spoiled(log, much)) if what in hint]
    assert any(character.isdigit() for character in hint), "with its figure"
    assert not any(what in hint for hint in said(spoiled(log, little)))


def test_a_clean_log_has_none(log):
    assert said(log) == []


def test_diagnose_and_identify_repeat_them(log):
    model = moving_axis.machine().replace(controller=None, controller_type=None)
    coarse = replace(log, position=1e-6 * np.round(log.position / 1e-6))
    ready = prepared([moving_axis.record(moving_axis.machine(), 4), coarse], model, [], None, None)
    (note,) = [note for note in ready.notes if "readings step by" in note]
    assert note.startswith("log 2: ")
    found = identify(coarse, model, free=["axis.mass"])
    assert any("readings step by 1e-06 m" in note for note in found.notes)


def test_a_log_that_no_fit_can_hold_says_what_the_audit_saw(log):
    """A time in ms, and no controller or reference that would betray it: whatever ends the call names the option."""
    model = moving_axis.machine().replace(controller=None, controller_type=None)
    slow = Log(1e3 * log.time, log.position, log.command)
    try:
        told = " ".join(cogging.diagnose(slow, model).notes)
    except cogging.DivergedError as error:
        told = str(error)
    assert "--scale time=0.001" in told
