"""What stands in the folder of a sweep's pieces: only what the sweep wrote is used, and only that is removed."""

import io
import os
import shutil

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from cogging.outputs import to_toml
from tests.attack import damaged
from tests.fixtures.sweeps import DOCUMENT, MANY, MOVE

SWEEP = {"model": "m.toml", "reference": "r.toml", "vary": {"axis.mass": [0.11, 0.12]}}


def test_a_flipped_bit_is_made_anew():
    """Of these flips 5 ended in a traceback before; 10,000: `python -m tests.attack.damaged`."""
    found = damaged.attack(400, seed=0)
    assert found.faults == []
    assert found.counts["made anew, the same table"] > 390


@pytest.fixture
def ended(tmp_path):
    """Pieces of a sweep that was ended, and the table that it would have written."""
    damaged.run(tmp_path / "runs.csv", damaged.ASKED["runs"])
    whole = (tmp_path / "runs.csv").read_bytes()
    (tmp_path / "runs.csv").unlink()
    damaged.ended(tmp_path / "runs.csv")
    return tmp_path / "runs.csv", whole


def crafted(path, **changes):
    """Write a piece again with other columns; None: without one."""
    with np.load(path) as piece:
        table = {name: piece[name] for name in piece.files}
    file = io.BytesIO()
    np.savez(file, **{name: values for name, values in {**table, **changes}.items() if values is not None})
    path.write_bytes(file.getvalue())


@pytest.mark.parametrize(
    "changes",
    [
        {"run": np.arange(8.0)},
        {"run": np.arange(-8, 0)},
        {"run": np.zeros(8, dtype=int)},
        {"run": np.arange(8, 16)},
        {"run": np.arange(40, 48)},
        {"seed": None},
        {"reason": None},
        {"more": np.zeros(8)},
        {"error_rms": np.ones(8)},
        {"error_rms": np.ones(7)},
        {"error_rms": np.array(["x"] * 8)},
    ],
    ids=lambda changes: "-".join(f"{name}" for name in changes),
)
def test_a_piece_that_somebody_else_wrote_is_made_anew(changes, ended):
    out, whole = ended
    crafted(min(out.with_name("runs.csv.pieces").glob("0*.npz")), **changes)
    damaged.run(out, damaged.ASKED["runs"])
    assert out.read_bytes() == whole


def test_a_piece_twice_and_pieces_of_another_name_are_used_once(ended):
    out, whole = ended
    first, *_, last = sorted(out.with_name("runs.csv.pieces").glob("0*.npz"))
    shutil.copy(first, first.with_name(f"000000032{first.name[9:]}"))
    last.rename(last.with_name(f"000000008{last.name[9:]}"))
    damaged.run(out, damaged.ASKED["runs"])
    assert out.read_bytes() == whole
    assert not out.with_name("runs.csv.pieces").exists()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes of POSIX")
def test_a_pipe_in_place_of_a_piece_is_not_waited_for(ended):
    out, whole = ended
    piece = min(out.with_name("runs.csv.pieces").glob("0*.npz"))
    piece.unlink()
    os.mkfifo(piece)
    damaged.run(out, damaged.ASKED["runs"])
    assert out.read_bytes() == whole
    assert not out.with_name("runs.csv.pieces").exists()


@pytest.mark.parametrize("content", [b"[" * 4000, b"{}", b"\xff", b"0"])
def test_a_sweep_json_that_is_another_s_is_refused(content, ended):
    out, _ = ended
    (out.with_name("runs.csv.pieces") / "sweep.json").write_bytes(content)
    with pytest.raises(cogging.InputError, match=r"runs\.csv\.pieces: holds pieces of another sweep, or of"):
        damaged.run(out, damaged.ASKED["runs"])


# What stands there and is not the sweep's ----------------------------------------------------------------------------


def snapshot(folder):
    return {path: path.read_bytes() if path.is_file() else None for path in sorted(folder.rglob("*"))}


@pytest.fixture
def files(tmp_path, monkeypatch):
    """The files of a sweep, in a folder that is the current one."""
    monkeypatch.chdir(tmp_path)
    write(tmp_path)
    return tmp_path


def write(folder):
    (folder / "m.toml").write_text(to_toml(DOCUMENT))
    (folder / "r.toml").write_text(to_toml(MOVE))
    (folder / "s.toml").write_text(to_toml(SWEEP))


def refused(capsys, *words):
    assert main(["sweep", *words]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    return said


@pytest.mark.parametrize("name", ["thesis.txt", "sub/thesis.txt", "sweep.txt", "000000000.npz", ".cogging-x.part"])
def test_a_folder_of_something_else_is_refused_and_left(name, files, capsys):
    path = files / "x.csv.pieces" / name
    path.parent.mkdir(parents=True)
    path.write_text("thesis")
    before = snapshot(files)
    said = refused(capsys, "s.toml", "--out", "x.csv")
    top = name.partition("/")[0]
    assert f"x.csv.pieces: must hold nothing but the pieces of a sweep, got '{top}': remove it, or write to ano" in said
    assert snapshot(files) == before


def test_a_sweep_whose_files_stand_in_its_folder_is_refused(files, capsys):
    (files / "runs.csv.pieces").mkdir()
    write(files / "runs.csv.pieces")
    before = snapshot(files)
    said = refused(capsys, "runs.csv.pieces/s.toml", "--out", "runs.csv")
    assert "runs.csv.pieces: must hold nothing but the pieces of a sweep, got 'm.toml'" in said
    assert snapshot(files) == before


@pytest.mark.skipif(not hasattr(os, "symlink"), reason="links of POSIX")
@pytest.mark.parametrize("inside", ["0000.npz", None])
def test_a_link_in_place_of_the_folder_is_refused(inside, files, capsys):
    (files / "target").mkdir()
    if inside:
        (files / "target" / inside).write_text("thesis")
    (files / "y.csv.pieces").symlink_to("target")
    before = snapshot(files)
    assert "y.csv.pieces: must be a folder, got a link" in refused(capsys, "s.toml", "--out", "y.csv")
    assert snapshot(files) == before


def test_a_file_that_comes_while_the_sweep_runs_stays(files, monkeypatch):
    plain = damaged.sweeps.run_piece

    def run_piece(piece):
        (files / "x.csv.pieces" / "thesis.txt").write_text("thesis")
        return plain(piece)

    monkeypatch.setattr(damaged.sweeps, "run_piece", run_piece)
    cogging.sweep(cogging.Model.from_dict(DOCUMENT), MOVE, MANY, method="random", runs=2, out="x.csv")
    assert [path.name for path in (files / "x.csv.pieces").iterdir()] == ["thesis.txt"]
