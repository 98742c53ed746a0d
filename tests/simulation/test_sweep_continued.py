"""Sweeps that were interrupted: the same call continues from the finished pieces, and touches no other file."""

import os
import random
import shutil
import sys

import numpy as np
import pytest

import cogging
from cogging.effects import Custom
from cogging.simulation import parameter_sweep as sweeps
from tests.fixtures.sweeps import FEW, MANY, MOVE, SMALL, same

posix = pytest.mark.skipif(sys.platform == "win32", reason="signals, locks, pipes and links of POSIX")


class Ended(Exception):
    pass


@pytest.fixture(scope="module")
def whole():
    """The table of the sweep that nothing interrupts."""
    return cogging.sweep(SMALL, MOVE, MANY, **FEW)


def end_sweep(out, monkeypatch, model=SMALL, first=160, **changes):
    """Run a sweep that ends before a run, and return the folder of its pieces."""
    plain = sweeps.run_piece

    def run_piece(piece):
        if piece.first >= first:
            raise Ended
        return plain(piece)

    with monkeypatch.context() as patch:
        patch.setattr(sweeps, "run_piece", run_piece)
        with pytest.raises(Ended):
            cogging.sweep(model, MOVE, MANY, out=out, **FEW | changes)
    return out.with_name("runs.csv.pieces")


@pytest.fixture
def computed(monkeypatch):
    """The first runs of the pieces that are computed, in order."""
    made, plain = [], sweeps.run_piece
    monkeypatch.setattr(sweeps, "run_piece", lambda piece: made.append(piece.first) or plain(piece))
    return made


def test_a_sweep_continues_where_it_ended(tmp_path, monkeypatch, whole):
    """Ended at random pieces until it is complete, with another number of threads each time: every run is made once."""
    out, rng, made = tmp_path / "runs.csv", random.Random(3), []
    plain = sweeps.run_piece

    def ends_at_times(piece):
        if rng.random() < 0.2:
            raise Ended
        made.extend(range(piece.first, piece.first + len(piece.points)))
        return plain(piece)

    monkeypatch.setattr(sweeps, "run_piece", ends_at_times)
    ended = 0
    while True:
        try:
            runs = cogging.sweep(SMALL, MOVE, MANY, out=out, **{**FEW, "threads": rng.randint(1, 3)})
            break
        except Ended:
            ended += 1
            assert not out.exists()
    assert ended > 3
    assert sorted(made) == list(range(320))
    same(runs, whole)
    assert [path.name for path in tmp_path.iterdir()] == ["runs.csv"]
    lines = out.read_text().splitlines()
    assert len(lines) == 321
    assert float(lines[9].split(",")[3]) == runs.table["error_max"][8]


def test_another_sweep_is_refused(tmp_path, monkeypatch, computed):
    out, two = tmp_path / "runs.csv", {**FEW, "runs": 16}
    end_sweep(out, monkeypatch, first=8, runs=16)
    for other in ({"seed": 6}, {"runs": 17}, {"duration": 0.1}, {"reductions": ["error_final"]}, {"stop": 0.1}):
        with pytest.raises(cogging.InputError, match=r"runs\.csv\.pieces: holds pieces of another sweep"):
            cogging.sweep(SMALL, MOVE, MANY, out=out, **{**two, **other})
    computed.clear()
    cogging.sweep(SMALL, MOVE, MANY, out=out, **two)
    assert computed == [8]


def test_a_model_with_a_custom_effect_stores_no_pieces(tmp_path, monkeypatch):
    model = SMALL.replace(effects=[Custom("drag", force=lambda velocity, k: -k * velocity, parameters={"k": 0.1})])
    end_sweep(tmp_path / "runs.csv", monkeypatch, model, first=8)
    assert list(tmp_path.iterdir()) == []
    cogging.sweep(model, MOVE, MANY, out=tmp_path / "runs.csv", **{**FEW, "runs": 8})
    assert [path.name for path in tmp_path.iterdir()] == ["runs.csv"]


def test_a_sweep_that_ends_before_its_first_piece_leaves_nothing(tmp_path, monkeypatch):
    end_sweep(tmp_path / "runs.csv", monkeypatch, first=0)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(cogging.InputError, match=r"^.*cannot be written: No such file or directory$"):
        cogging.sweep(SMALL, MOVE, MANY, out=tmp_path / "none" / "runs.csv", **FEW)


def renamed(piece, first):
    """Return the path of a piece under the number of another first run."""
    digest, _, checksum = piece.name.split("-")
    return piece.with_name(f"{digest}-{first:09d}-{checksum}")


@posix
def test_changed_pieces_are_computed_again_and_copies_used_once(tmp_path, monkeypatch, computed, whole):
    """Other numbers, half a file, no archive, a pipe, drawn bits, one piece twice, and one under another number."""
    out = tmp_path / "runs.csv"
    pieces = sorted(end_sweep(out, monkeypatch).glob("*.npz"))
    computed.clear()
    with np.load(pieces[0]) as piece:
        columns = dict(piece)
    np.savez(pieces[0], **{**columns, "error_max": 2.0 * columns["error_max"]})
    pieces[7].write_bytes(pieces[7].read_bytes()[:200])
    pieces[9].write_bytes(b"PK\x03\x04 no archive")
    pieces[11].unlink()
    os.mkfifo(pieces[11])
    for seed, piece in enumerate(pieces[13:17]):
        content, draw = bytearray(piece.read_bytes()), random.Random(seed)
        content[draw.randrange(len(content))] ^= 1 << draw.randrange(8)
        piece.write_bytes(content)
    shutil.copy(pieces[1], renamed(pieces[1], 32))
    pieces[19].rename(renamed(pieces[19], 8))
    same(cogging.sweep(SMALL, MOVE, MANY, out=out, **FEW), whole)
    assert computed == [0, 56, 72, 88, *range(104, 136, 8), *range(160, 320, 8)]
    assert [path.name for path in tmp_path.iterdir()] == ["runs.csv"]


def test_a_file_that_appears_during_the_sweep_stays(tmp_path, monkeypatch):
    plain = sweeps.run_piece

    def run_piece(piece):
        (tmp_path / "x.csv.pieces" / "thesis.txt").write_text("thesis")
        return plain(piece)

    monkeypatch.setattr(sweeps, "run_piece", run_piece)
    cogging.sweep(SMALL, MOVE, MANY, method="random", runs=2, out=tmp_path / "x.csv")
    assert [path.name for path in (tmp_path / "x.csv.pieces").iterdir()] == ["thesis.txt"]
