"""Sweeps that were interrupted: the same call continues from the finished pieces, and touches no other file."""

import os
import random
import sys

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
    """Run a sweep that ends before a run, and return the file of its pieces."""
    plain = sweeps.run_piece

    def run_piece(piece):
        if piece.first >= first:
            raise Ended
        return plain(piece)

    with monkeypatch.context() as patch:
        patch.setattr(sweeps, "run_piece", run_piece)
        with pytest.raises(Ended):
            cogging.sweep(model, MOVE, MANY, out=out, **FEW | changes)
    return out.with_name("runs.csv.kept")


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
        with pytest.raises(cogging.InputError, match=r"runs\.csv\.kept: holds the work of another call"):
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


@pytest.mark.parametrize("seed", range(4))
def test_damaged_pieces_are_computed_again_and_copies_used_once(seed, tmp_path, monkeypatch, computed, whole):
    """Bits flipped anywhere behind the first line, a line twice, and the last one cut off."""
    out, rng = tmp_path / "runs.csv", random.Random(seed)
    kept = end_sweep(out, monkeypatch)
    computed.clear()
    head, *lines = kept.read_bytes().split(b"\n")
    hit = sorted(rng.sample(range(1, 19), 3))
    damaged = [bytearray(line) for line in (*lines, lines[0])]
    for place in hit:
        damaged[place][rng.randrange(len(lines[place]))] ^= 1 << rng.randrange(8)
    damaged[19] = damaged[19][: rng.randrange(len(damaged[19]))]
    kept.write_bytes(b"\n".join([head, *damaged]))
    same(cogging.sweep(SMALL, MOVE, MANY, out=out, **FEW), whole)
    assert computed == [8 * place for place in (*hit, *range(19, 40))]
    assert [path.name for path in tmp_path.iterdir()] == ["runs.csv"]


def test_a_sweep_killed_in_its_first_line_begins_anew(tmp_path, monkeypatch, whole):
    out = tmp_path / "runs.csv"
    kept = end_sweep(out, monkeypatch)
    kept.write_bytes(kept.read_bytes()[:40])
    same(cogging.sweep(SMALL, MOVE, MANY, out=out, **FEW), whole)
    assert [path.name for path in tmp_path.iterdir()] == ["runs.csv"]


@posix
@pytest.mark.parametrize("make", [lambda path: path.write_text("thesis"), os.mkfifo, os.mkdir])
def test_what_no_sweep_wrote_is_refused_and_stays(make, tmp_path):
    kept = tmp_path / "runs.csv.kept"
    make(kept)
    with pytest.raises(cogging.InputError, match=r"^[^\n]*runs\.csv\.kept: "):
        cogging.sweep(SMALL, MOVE, MANY, out=tmp_path / "runs.csv", **FEW)
    assert list(tmp_path.iterdir()) == [kept]
