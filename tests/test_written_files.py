"""Each written file is whole, whatever interrupts the writer; a log beside another log's metadata is refused."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import cogging
from cogging import outputs
from cogging.files import InputError
from cogging.papers import result as papers

pytestmark = pytest.mark.skipif(os.name == "nt", reason="processes and modes of POSIX")
OLD = {"a": b"old a", "b": b"old b", "gone": b"old too"}
NEW = {"a": b"new a", "b": b"new b", "c": b"new too"}


def standing(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def log(seed):
    columns = {name: np.full(3, float(seed)) for name in ("position", "command")}
    return cogging.Log(time=np.arange(3.0), **columns, metadata={"seed": seed})


def fail_at(patch, number, error):
    """Raise at the n-th call of what changes a folder; return the list that holds how many are left until then."""
    left = [number]

    def failing(plain):
        def call(*args, **kwargs):
            left[0] -= 1
            if left[0] == 0:
                raise error
            return plain(*args, **kwargs)

        return call

    for name in ("open", "replace", "unlink"):
        patch.setattr(os, name, failing(getattr(os, name)))
    return left


@pytest.mark.parametrize("error", [OSError(errno.EIO, os.strerror(errno.EIO)), KeyboardInterrupt()])
def test_a_failure_between_any_two_steps_leaves_whole_files(error, tmp_path, monkeypatch):
    for number in range(1, 60):
        folder, raised = tmp_path / f"{number}", None
        folder.mkdir()
        for name, content in OLD.items():
            (folder / name).write_bytes(content)
        with monkeypatch.context() as patch:
            left = fail_at(patch, number, error)
            try:
                new = {str(folder / name): [content] for name, content in NEW.items()}
                outputs.write_files({**new, str(folder / "gone"): None})
            except (InputError, KeyboardInterrupt) as found:
                raised = found
        found = {name: content for name, content in standing(folder).items() if not name.endswith(".part")}
        for name in ("a", "b", "c", "gone"):
            assert found.get(name) in (OLD.get(name), NEW.get(name))
        if number <= 4:
            assert found == OLD, "nothing takes its place before all are written"
        if isinstance(error, OSError) and raised is not None:
            assert f"{folder}" in str(raised)
        if left[0] > 0:
            break
    assert found == NEW
    assert number > 8


def test_a_killed_writer_leaves_one_log_or_a_pair_that_is_refused(tmp_path):
    """SIGKILL before each file operation: the reader gets one log with its own metadata, or one line that says why."""
    code = """
import os
from pathlib import Path
import cogging
from tests.attack.operations import at_operation
from tests.test_written_files import log

for number in range(1, 40):
    folder = Path(f"{number}")
    folder.mkdir()
    log(1).write(folder / "log.csv")
    child = os.fork()
    if not child:
        at_operation(number, lambda _, path: path.startswith(f"{folder.resolve()}"), lambda *_: os.kill(os.getpid(), 9))
        log(2).write(folder / "log.csv")
        os._exit(0)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    try:
        read = cogging.read_log(folder / "log.csv")
        assert read.command[0] == read.metadata["seed"]
        print(status, read.metadata["seed"])
    except cogging.InputError as error:
        assert "log.csv.toml: log_checksum: must be the log_checksum of" in str(error)
        print(status, "refused")
    if not status:
        break
"""
    environment = {**os.environ, "PYTHONPATH": f"{Path(__file__).parents[1]}:{Path(cogging.__file__).parents[1]}"}
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert set(lines) == {"-9 1", "-9 refused", "-9 2", "0 2"}
    assert lines[-1] == "0 2"


def test_a_checksum_is_of_its_log_alone(tmp_path):
    path, beside = tmp_path / "log.csv", tmp_path / "log.csv.toml"
    log(1).write(path)
    assert cogging.read_log(path).metadata.keys() == {"version", "seed"}
    cogging.read_log(path).write(tmp_path / "copy.csv")
    assert (tmp_path / "copy.csv.toml").read_bytes() == beside.read_bytes()
    path.write_text(path.read_text() + "3,1,1\n")
    with pytest.raises(InputError, match=r"remove the line if that log was changed on purpose, got 'crc32:"):
        cogging.read_log(path)
    beside.write_text(
        "".join(line for line in beside.read_text().splitlines(keepends=True) if not line.startswith("log_checksum"))
    )
    assert cogging.read_log(path).metadata["seed"] == 1


def test_a_full_disk_leaves_the_old_file(tmp_path, monkeypatch):
    log(1).write(tmp_path / "log.csv")
    before = standing(tmp_path)

    def pieces(self):
        yield b"time"
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(cogging.Log, "_csv", pieces)
    with pytest.raises(InputError, match=r"log\.csv: cannot be written: No space left on device"):
        log(2).write(tmp_path / "log.csv")
    assert standing(tmp_path) == before


def test_data_reach_the_disk_before_their_names(tmp_path, monkeypatch):
    calls = []
    monkeypatch.setattr(outputs, "synced", True)
    for name in ("fsync", "replace"):
        plain = getattr(os, name)
        monkeypatch.setattr(os, name, lambda *args, name=name, plain=plain: calls.append(name) or plain(*args))
    outputs.write_files({str(tmp_path / "a"): [b"1"], str(tmp_path / "b"): [b"2"]})
    assert calls == ["fsync", "fsync", "replace", "replace"]


def test_a_folder_that_was_made_goes_with_what_could_not_be_written(tmp_path, monkeypatch):
    rows = [papers.Row("C1", "e_inf", "m", 1.0, 2.0, "predicted")]
    monkeypatch.setattr(papers, "png", lambda name: name.encode())
    found = papers.Reproduction("paper", [papers.Table("table1", "Table 1", rows)], {"fig": "fig", "x" * 300: "long"})
    with pytest.raises(InputError, match=r"xxx\.png: cannot be written: File name too long"):
        found.write(tmp_path / "deep" / "results")
    assert standing(tmp_path) == {}
    found.figures.pop("x" * 300)
    written = found.write(tmp_path / "deep" / "results")
    assert sorted(path.name for path in written) == ["fig.png", "paper.json"]
    assert (tmp_path / "deep" / "results" / "fig.png").read_bytes() == b"fig"


@pytest.mark.root
def test_a_file_of_another_in_a_shared_folder_is_refused_before_anything_is_computed(tmp_path, monkeypatch):
    tmp_path.chmod(0o1777)
    (tmp_path / "a").write_text("old")
    os.chown(tmp_path, 1, 1)
    os.chown(tmp_path / "a", 2, 2)
    for user, may in ((0, True), (1, True), (2, True), (3, False)):
        monkeypatch.setattr(os, "geteuid", lambda user=user: user)
        if may:
            outputs.check_outputs({"--out": tmp_path / "a"})
        else:
            with pytest.raises(InputError, match="a: cannot be written: Operation not permitted"):
                outputs.check_outputs({"--out": tmp_path / "a"})
