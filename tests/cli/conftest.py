"""What the tests of the command share."""

from pathlib import Path

import pytest

from cogging.cli.main import main
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


@pytest.fixture
def refused(folder, capsys):
    """Check that a call ends in one line with status 2 and these words, before it has computed or written anything."""

    def content():
        return {path: path.read_bytes() for path in Path().rglob("*") if path.is_file() and path.stat().st_size < 1e9}

    def check(call, *parts):
        before = content()
        try:
            status = main(call)
        except SystemExit as end:
            status = end.code
        out, error = capsys.readouterr()
        assert (status, out, error[:7], error.count("\n")) == (2, "", "cogging", 1)
        assert [part for part in parts if part not in error] == [], error
        assert content() == before

    return check
