"""What the package gave when values.json was written; `python -m tests.golden.small` rewrites that file.

Figures are compared within 1e-9, since another compiler may round another last bit.
"""

import copy
import json

import pytest

from tests.golden import small as golden_small
from tests.golden.comparison import compare

VALUES = json.loads(golden_small.FILE.read_text())


def agree(was, now):
    found = compare(was, json.loads(json.dumps(now)))
    assert found.values > 0
    assert not found.failures, found.text()
    assert not found.new, found.text()


def test_the_logs_of_every_controller_and_effect():
    agree(VALUES["logs"], golden_small.logs())


@pytest.mark.parametrize("name", golden_small.PAPERS)
def test_a_table_of_a_paper(name):
    agree(VALUES["papers"][name], golden_small.paper(name))


@pytest.mark.parametrize("hidden", golden_small.HIDDEN)
def test_the_verdict_on_a_log(hidden):
    agree(VALUES["verdicts"][hidden], golden_small.verdict(hidden))


# The comparison itself ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("factor", [1 + 3e-9, 1 - 3e-9, -1.0, 0.0])
def test_a_number_beyond_the_tolerance_fails(factor):
    was = {"logs": [{"rms": 2e-5, "last": 0.3}]}
    now = copy.deepcopy(was)
    now["logs"][0]["rms"] *= factor
    found = compare(was, now)
    assert len(found.failures) == found.differ == 1
    assert found.failures[0].startswith("/logs/0/rms: 2e-05 -> ")
    assert found.largest == pytest.approx(abs(factor - 1) / max(abs(factor), 1), rel=1e-6)


def test_a_last_bit_is_counted_and_passes():
    found = compare({"rms": 0.3, "hash": {"sha256": "ab"}}, {"rms": 0.30000000000000004, "hash": {"sha256": "cd"}})
    assert (found.values, found.differ, found.failures) == (2, 2, [])
    assert 1e-16 < found.largest < 3e-16


def test_labels_fail_and_sentences_are_listed():
    was = {"verdict": "named", "notes": ["a note in some words"], "effects": [{"name": "backlash"}]}
    assert compare(was, was).differ == 0
    said = compare(was, was | {"notes": ["the same in other words", "and one more of them"]})
    assert (said.failures, len(said.sentences), len(said.new)) == ([], 1, 1)
    assert len(compare(was, was | {"verdict": "ambiguous"}).failures) == 1
    assert compare(was, was | {"effects": []}).failures
    assert compare(was, was | {"effects": [{"name": "backlash"}, {"name": "cable_spring"}]}).failures
    assert compare(was, {"notes": was["notes"], "effects": was["effects"]}).failures
    assert not compare(was, was | {"limits": {"force": 1.0}}).failures


def test_a_value_that_is_no_number_any_more_fails():
    assert compare({"ci95": [0.1, 0.2]}, {"ci95": [0.1, None]}).failures
    assert compare({"width": 0.0}, {"width": -0.0}).differ == 1
    assert not compare({"width": 1}, {"width": 1.0}).differ
