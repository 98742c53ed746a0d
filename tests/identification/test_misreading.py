"""A column that was read as something else is reported with a remedy; a log that was read right never is.

The machines lack what makes most of the command, their models know mass and friction within a factor of three.
"""

import functools
from dataclasses import replace

import numpy as np
import pytest

import cogging
from cogging import Log
from cogging.files import InputError
from cogging.identification.misreading import misreading
from tests.fixtures import moving_axis, slow_rotary, unlike_machines
from tests.fixtures.measured import emps_log, emps_model
from tests.fixtures.unlike_machines import MISREADINGS, MISSING

drawn = functools.cache(unlike_machines.drawn)


def find(log, model):
    """The misreading; "refused" where the log is refused for its units."""
    try:
        cogging.check_against_model(log, model)
    except InputError:
        return "refused"
    return misreading([log], model)


@pytest.mark.parametrize("missing", MISSING)
def test_a_log_read_right_is_not_doubted(missing):
    for seed, motion in ((59, "multisine"), (45, "slow")):
        case = drawn(seed, missing, motion)
        assert misreading([case.log], case.model) is None, (missing, motion)


def test_nor_is_one_that_cogging_drives_back_and_forth():
    """Under a soft loop the command follows the axis; but it does work, as no command of the other sign does."""
    for log in slow_rotary.logs(0, [0.3, 0.3, 1.0, 1.0], [3.45, 9.0, 5.0, 20.0]):
        assert misreading([log], slow_rotary.model()) is None


#: What two machines lack and how they move, by seed.
PLAIN = {59: ("nothing", "strokes"), 45: ("spring", "multisine")}


def judge(kind, case):
    """right, wrong or nothing: the column of the answer, or of one that this log does not tell from it."""
    found = find(unlike_machines.misread(kind, case), case.model)
    if found == "refused":
        return "right"
    if found is None:
        return "nothing"
    options = [found.column, *(option.split()[1] for option in found.alternatives)]
    return "right" if any(option.startswith(MISREADINGS[kind]) for option in options) else "wrong"


@pytest.mark.parametrize("kind", MISREADINGS)
def test_a_misreading_is_found(kind):
    """Where the motion is rich, in both logs; a command that lies a tenth of a second off its rows in one."""
    answers = [judge(kind, drawn(seed, *which, with_reference=True)) for seed, which in PLAIN.items()]
    assert "wrong" not in answers, answers
    assert answers.count("right") >= (1 if kind.startswith("command") else 2), answers


@pytest.mark.data
def test_volts_for_newtons_on_a_real_machine():
    model, log = emps_model(controller=False), emps_log()
    assert misreading([log], model) is None
    found = misreading([replace(log, command=log.command / 35.15)], model)
    assert (found.column, found.misreading) == ("command", "scale")
    assert found.factor == pytest.approx(35.15, rel=0.05)
    assert found.explained_otherwise > 0.98 > 0.2 > found.explained


@pytest.fixture(scope="module")
def right():
    log = moving_axis.record(moving_axis.machine(), 3)
    return Log(log.time, log.position, log.command, log.reference)


def test_the_report_names_log_column_remedy_and_shares(right):
    wrong = replace(right, command=-right.command)
    found = misreading([right, wrong], moving_axis.machine(), ["a.csv", "b.csv"])
    assert (found.logs, found.column, found.misreading, found.factor) == (("b.csv",), "command", "sign", -1.0)
    assert found.option == "--scale b.csv:command=-1"
    assert found.explained < 0.1 < 0.9 < found.explained_otherwise <= 1.0
    assert "b.csv: command has the opposite sign" in found.text
    fit = cogging.identify([right, wrong], moving_axis.machine(), names=["a.csv", "b.csv"], free=["axis.mass"])
    assert any("b.csv: command has the opposite sign" in note for note in fit.notes), fit.notes
    both = misreading([wrong, wrong], moving_axis.machine())
    assert (both.logs, both.option) == (("log 1", "log 2"), "--scale command=-1")


@pytest.mark.parametrize("rows", [3, -40])
def test_a_shift_is_reported_in_rows_where_the_controller_is_known(right, rows):
    log = replace(right, command=np.roll(right.command, rows))[abs(rows) : -abs(rows)]
    found = misreading([log], moving_axis.machine())
    assert (found.misreading, found.rows, found.option) == ("shift", rows, "")
    assert f"{abs(rows)} rows" in found.text
    assert ("late" in found.text) == (rows > 0)
