"""Hostile calls: each ends with status 0, or with status 2 and one line; nothing else reaches the terminal."""

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


@pytest.mark.parametrize("kind", hostile_calls.KINDS)
def test_a_hostile_call_is_answered(kind, tmp_path, capfd, caplog, monkeypatch):
    monkeypatch.setattr("cogging.cli.reproduce.reproduce", lambda paper, progress: Reproduction(paper, [], {}))
    monkeypatch.setattr("cogging.cli.reproduce.compare", lambda progress: Reproduction("comparison", [], {}))
    wrong = []
    for seed in range(CALLS[kind]):
        folder = tmp_path / f"{seed}"
        folder.mkdir()
        monkeypatch.chdir(folder)
        call = hostile_calls.draw(kind, seed)
        found = list(faults(run(call, folder, capfd, caplog), folder))
        wrong += [f"{seed} {call}\n    {'; '.join(found)}"] if found else []
    assert not wrong, "\n".join(wrong)
