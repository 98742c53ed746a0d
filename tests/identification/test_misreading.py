"""A column that was read as something it is not is said, with what to do; a log that was read right never is.

The machines lack what makes most of the command, their models know mass and friction within a factor of three.
"""

import functools
import json
from dataclasses import replace

import numpy as np
import pytest

import cogging
from cogging import Log
from cogging.cli.main import main
from cogging.estimation.axis_balance import AXIS, AxisBalance, explained_share, stated_bounds
from cogging.files import InputError
from cogging.identification.misreading import misreading
from cogging.log_check.log_audit import check_against_model
from tests.fixtures import emps, moving_axis, slow_rotary, unlike_machines
from tests.fixtures.unlike_machines import MISREADINGS, MISSING


@functools.cache
def drawn(seed, missing, motion, known_controller=None, with_reference=None):
    return unlike_machines.drawn(
        seed, missing, motion, known_controller=known_controller, with_reference=with_reference
    )


def told(log, model):
    """The misreading; "refused" where the log is refused for its units."""
    try:
        check_against_model(log, model)
    except InputError:
        return "refused"
    return misreading([log], model)


# Right logs -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("missing", MISSING)
def test_a_log_read_right_is_not_doubted(missing):
    for seed, motion in ((12, "multisine"), (13, "slow")):
        case = drawn(seed, missing, motion)
        assert misreading([case.log], case.model) is None, (missing, motion)


@pytest.mark.parametrize("seed", [0, 1])
def test_nor_is_one_that_cogging_drives_back_and_forth(seed):
    """Under a soft loop the command follows the axis; but it does work, as no command of the other sign does."""
    amplitudes, poles = np.repeat([0.3, 1.0], 4), np.tile([3.45, 5.0, 9.0, 20.0], 2)
    for log in slow_rotary.logs(seed, amplitudes, poles):
        assert misreading([log], slow_rotary.model()) is None
        assert AxisBalance.of(replace(log, command=-log.command), slow_rotary.model()).work < 0.0


@pytest.mark.study
def test_nor_are_two_hundred():
    doubted = [seed for seed in range(1000, 1200) if told(*case_of(seed)) is not None]
    assert len(doubted) <= 1, doubted


def case_of(seed):
    case = unlike_machines.drawn(seed)
    return case.log, case.model


# Wrong ones -----------------------------------------------------------------------------------------------------------

PLAIN = [("nothing", "strokes"), ("harmonics", "strokes"), ("spring", "multisine")]


def answered(kind, case):
    """right, wrong or nothing: the column of the answer, or of one that cannot be told from it."""
    found = told(unlike_machines.misread(kind, case), case.model)
    if found == "refused":
        return "right"
    if found is None:
        return "nothing"
    options = [found.column, *(option.split()[1] for option in found.alternatives)]
    return "right" if any(option.startswith(MISREADINGS[kind]) for option in options) else "wrong"


@pytest.mark.parametrize("kind", MISREADINGS)
def test_a_misreading_is_found(kind):
    """Where the motion is rich, in two logs of three; a command that lies a tenth of a second off its rows in one."""
    cases = [drawn(21 + i, *which, None, True) for i, which in enumerate(PLAIN)]
    answers = [answered(kind, case) for case in cases]
    assert "wrong" not in answers, answers
    assert answers.count("right") >= (1 if kind.startswith("command") else 2), answers


@pytest.mark.study
@pytest.mark.parametrize("kind", MISREADINGS)
def test_a_misreading_is_found_in_any_motion(kind):
    """Without a reference in half of the logs, whatever is missing, and where the motion is poor."""
    cases = [unlike_machines.drawn(seed) for seed in range(1000, 1040)]
    answers = [answered(kind, case) for case in cases if unlike_machines.misread(kind, case) is not None]
    assert answers.count("wrong") <= 0.05 * len(answers)
    assert answers.count("right") >= LEAST.get(kind, 0.5) * len(answers)


LEAST = {"command late": 0.1, "command early": 0.1, "velocity as position": 0.3, "sample number": 0.2}


@pytest.mark.data
def test_volts_for_newtons_on_a_real_machine():
    model, log = emps.published(controller=False), emps.read()
    assert misreading([log], model) is None
    found = misreading([replace(log, command=log.command / 35.15)], model)
    assert (found.column, found.misreading) == ("command", "scale")
    assert found.factor == pytest.approx(35.15, rel=0.05)
    assert found.explained_otherwise > 0.98 > 0.2 > found.explained


# What is said ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def right():
    log = moving_axis.record(moving_axis.machine(), 3)
    return Log(log.time, log.position, log.command, log.reference)


def test_what_is_said_of_one_log_of_several(right):
    wrong = replace(right, command=-right.command)
    found = misreading([right, wrong], moving_axis.machine(), ["a.csv", "b.csv"])
    assert found.logs == ("b.csv",)
    assert (found.column, found.misreading, found.factor) == ("command", "sign", -1.0)
    assert found.option == "--scale b.csv:command=-1"
    assert found.explained < 0.1 < 0.9 < found.explained_otherwise <= 1.0
    assert "b.csv: command has the opposite sign" in found.text
    assert found.option in found.text
    both = misreading([wrong, wrong], moving_axis.machine())
    assert both.logs == ("log 1", "log 2")
    assert both.option == "--scale command=-1"
    assert misreading([right, right], moving_axis.machine()) is None


@pytest.mark.parametrize("rows", [3, -40])
def test_a_shift_is_said_in_rows_where_the_controller_is_known(right, rows):
    late, kept = abs(rows), len(right) - abs(rows)
    early, last = slice(0, kept), slice(late, None)
    command, others = (early, last) if rows > 0 else (last, early)
    columns = {name: column[command if name == "command" else others] for name, column in right.columns().items()}
    found = misreading([Log.of(columns)], moving_axis.machine())
    assert (found.misreading, found.rows, found.option) == ("shift", rows, "")
    assert f"{late} rows" in found.text
    assert ("late" in found.text) == (rows > 0)


def test_the_verdict_comes_before_any_name(right, tmp_path, monkeypatch, capsys):
    """And the option that it names leads on."""
    monkeypatch.chdir(tmp_path)
    model = moving_axis.machine([cogging.effects.ViscousAsymmetry(difference=1.5)])
    log = moving_axis.record(model, 3)
    Log(log.time, log.position, -1e3 * log.command).write("b.csv")
    bare = moving_axis.machine().to_dict()
    del bare["controller"]
    cogging.Model.from_dict(bare).write("m.toml")
    words = ["diagnose", "b.csv", "--model", "m.toml", "--json", "r.json", "--report", "r.html"]
    assert main(words) == 0
    result = json.loads((tmp_path / "r.json").read_text())
    assert result["verdict"] == "data_mismatch"
    assert (result["mismatch"]["column"], result["mismatch"]["factor"]) == ("command", -1e-3)
    assert result["effects"] == []
    said = capsys.readouterr().out
    page = (tmp_path / "r.html").read_text()
    for text in (said, page):
        assert result["mismatch"]["option"] in text
    option = result["mismatch"]["option"].split()
    for given, warned in (([], True), (option, False)):
        assert main(["identify", "b.csv", "--model", "m.toml", "--free", "axis.mass", "--json", "i.json", *given]) == 0
        fit = json.loads((tmp_path / "i.json").read_text())
        assert any("command is in thousandths" in note for note in fit["notes"]) == warned
    assert fit["parameters"]["axis.mass"]["value"] == pytest.approx(2.0, rel=0.05)


def test_identify_warns(right):
    model = moving_axis.machine().replace(controller=None, controller_type=None)
    found = cogging.identify(replace(right, command=-right.command), model, free=["axis.mass"])
    assert any("command has the opposite sign" in note for note in found.notes)
    assert not any("sign" in note for note in cogging.identify(right, model, free=["axis.mass"]).notes)


# The share that is explained ------------------------------------------------------------------------------------------


def test_the_share_is_that_of_a_model_within_its_uncertainty(right):
    model = moving_axis.machine()
    assert explained_share([right], model) > 0.99
    heavy = model.replace(axis=model.axis.replace(mass=2.5 * model.axis.mass))
    exact = heavy.replace(uncertainty={**model.uncertainty, "mass": 0.0})
    free = heavy.replace(uncertainty={})
    shares = [explained_share([right], one) for one in (exact, heavy, free)]
    assert shares[0] < shares[1] < shares[2]
    assert shares[2] > 0.99
    assert stated_bounds(exact)["mass"] == (5.0, 5.0)
    assert stated_bounds(free)["mass"] == pytest.approx((5.0 / 3.0, 15.0))
    light = model.replace(axis=model.axis.replace(mass=0.02), uncertainty=dict.fromkeys(AXIS, 0.0))
    assert explained_share([right], light) < shares[2], "unlike an innovation, no small mass raises it"


def test_the_fit_is_that_of_a_dense_least_squares(right):
    """Of the places by hat functions written out, and of the rest by numpy."""
    balance = AxisBalance.of(right, moving_axis.machine())
    fit = balance.fit(dict.fromkeys((*AXIS, "drag"), (-1e9, 1e9)))
    node, share, matrix = balance._nodes
    hats = np.zeros((matrix.shape[1], len(node)))
    hats[node, np.arange(len(node))] += 1.0 - share
    hats[node + 1, np.arange(len(node))] += share
    hats = hats[hats.sum(axis=1) > 0.0]
    speed = balance.speed
    phase = 2.0 * balance.taken / len(balance.command) - 1.0
    slow = np.polynomial.legendre.legvander(phase, 3)[:, 1:].T
    columns = np.vstack([*balance.needs.values(), speed * np.abs(speed), np.abs(speed), *slow, hats])
    columns /= np.sqrt(np.mean(columns**2, axis=1))[:, None]
    target = (balance.command + balance.known)[balance.taken]
    left = target - columns.T @ np.linalg.lstsq(columns.T, target, rcond=1e-12)[0]
    assert fit.left == pytest.approx(np.mean(left**2), rel=1e-3)
