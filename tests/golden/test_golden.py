"""What the package gave when values.json was written; `python -m tests.golden.small` rewrites that file.

Figures are compared within 1e-9, since another compiler may round another last bit.
"""

import json

import pytest

from tests.golden import small as golden_small

VALUES = json.loads(golden_small.FILE.read_text())


RELATIVE = 1e-9
SMALLEST = 1e-6  # a smaller number's difference is taken relative to this: 1e-15 is agreement


def leaves(value, path=""):
    """Every number and text by its path, and the length of every list."""
    if isinstance(value, dict | list):
        found = {f"{path}/length": len(value)}
        for key, entry in value.items() if isinstance(value, dict) else enumerate(value):
            found |= leaves(entry, f"{path}/{key}")
        return found
    return {path: value}


def differences(was, now):
    """Values that differ, by path: numbers by more than RELATIVE, others at all."""
    before, after = leaves(was), leaves(json.loads(json.dumps(now)))
    pairs = {path: (before.get(path, "missing"), after.get(path, "missing")) for path in before.keys() | after.keys()}
    return {path: pair for path, pair in pairs.items() if not same(*pair)}


def same(one, other):
    if isinstance(one, str | bool | None) or isinstance(other, str | bool | None):
        return one == other
    return abs(one - other) <= RELATIVE * max(abs(one), abs(other), SMALLEST)


def test_the_logs_of_every_controller_and_effect():
    assert not differences(VALUES["logs"], golden_small.logs())


@pytest.mark.parametrize("name", golden_small.PAPERS)
def test_a_table_of_a_paper(name):
    assert not differences(VALUES["papers"][name], golden_small.paper(name))


@pytest.mark.parametrize("hidden", golden_small.HIDDEN)
def test_the_verdict_on_a_log(hidden):
    assert not differences(VALUES["verdicts"][hidden], golden_small.verdict(hidden))


def test_the_comparison_finds_differences():
    was = {"verdict": "named", "rms": 2e-5, "effects": [{"name": "backlash"}], "width": 0.0}
    same = {"rms": 2e-5 * (1 + 1e-12), "effects": [{"name": "backlash"}], "verdict": "named", "width": 0}
    assert not differences(was, same)
    for change in ({"rms": 2e-5 * (1 + 3e-9)}, {"rms": None}, {"verdict": "no_gap"}, {"effects": []}, {"new": 1}):
        assert differences(was, {**was, **change})
    assert differences(was, {"verdict": "named"})
