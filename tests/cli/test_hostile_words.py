"""Hostile calls: each ends with status 0, or with status 2 and one line; nothing else reaches the terminal.

`python -m pytest tests/cli/test_hostile_words.py -s` prints how many calls of each kind went wrong.
"""

import collections
import logging

import pytest

from cogging.papers.result import Reproduction
from tests.fixtures import hostile_calls
from tests.fixtures.hostile_answers import answered, faults, place

#: How many calls of each kind the default run makes; `python -m tests.attack` makes thousands, `.ci/run` hundreds.
CALLS = {
    "model": 30,
    "option": 30,
    "signal": 10,
    "name": 20,
    "reference": 10,
    "header": 8,
    "document": 12,
    "sidecar": 6,
}


def run(call, folder, capfd, caplog):
    """Make a call in this process, and see all that it prints, C libraries and warnings included."""
    before = place(call, folder)
    caplog.clear()
    capfd.readouterr()

    def said():
        out, err = capfd.readouterr()
        shown = (record for record in caplog.records if record.levelno >= logging.WARNING)
        return out, err + "".join(f"{record.getMessage()}\n" for record in shown)

    return answered(call, folder, before, said)


def count(kind, seeds, tmp_path, capfd, caplog, monkeypatch, request):
    """Run calls of a kind; the faults by call."""
    monkeypatch.setattr("cogging.cli.reproduce.reproduce", lambda paper, progress: Reproduction(paper, [], {}))
    monkeypatch.setattr("cogging.cli.reproduce.compare", lambda progress: Reproduction("comparison", [], {}))
    wrong, slowest, statuses = {}, 0.0, collections.Counter()
    for seed in seeds:
        folder = tmp_path / f"{seed}"
        folder.mkdir()
        monkeypatch.chdir(folder)
        call = hostile_calls.draw(kind, seed)
        answer = run(call, folder, capfd, caplog)
        slowest = max(slowest, answer.seconds)
        statuses[answer.status] += 1
        found = list(faults(answer, folder))
        if found:
            wrong[f"{seed} {call}"] = found
    if request.config.getoption("capture") == "no":
        with capfd.disabled():
            print(f"\n{kind}: {len(wrong)} of {len(seeds)} wrong, statuses {dict(statuses)}, slowest {slowest:.1f} s")
    return wrong


@pytest.mark.parametrize("kind", hostile_calls.KINDS)
def test_a_hostile_call_is_answered(kind, tmp_path, capfd, caplog, monkeypatch, request):
    wrong = count(kind, range(CALLS[kind]), tmp_path, capfd, caplog, monkeypatch, request)
    assert not wrong, "\n".join(f"{call}\n    {'; '.join(found)}" for call, found in wrong.items())
