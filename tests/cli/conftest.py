"""What the tests of the command share."""

import pytest

from cogging.papers.result import Reproduction
from tests.fixtures import command_files


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder, with the files of the examples of the command's help; papers are reproduced at once."""
    work = tmp_path / "work"
    work.mkdir()
    command_files.write(work)
    monkeypatch.chdir(work)
    monkeypatch.setattr("cogging.cli.reproduce.reproduce", lambda paper, progress: Reproduction(paper, [], {}))
    monkeypatch.setattr("cogging.cli.reproduce.compare", lambda progress: Reproduction("comparison", [], {}))
    return work
