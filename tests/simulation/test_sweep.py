"""Sweeps: the run of each row and every way of drawing, on the workers of executors, and with interruptions."""

import concurrent.futures
import itertools
import multiprocessing
import os
import random
import signal
import sys

import numpy as np
import pytest

import cogging
from cogging.effects import Custom
from cogging.simulation import parameter_sweep as sweeps
from cogging.simulation.varied import points_of, variation_of
from tests.fixtures.examples import MOVE as STROKE
from tests.fixtures.lacking_workers import has_another_version
from tests.fixtures.sweeps import FEW, MANY, MOVE, SMALL, same

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="signals, locks, pipes and links of POSIX")


def test_a_row_is_the_run_that_its_numbers_say():
    gains = {"from": 5e3, "to": 9e3, "points": 2}
    vary = {"axis.mass": [0.1, 0.14], "controller.kp": gains, "reference.frequency": [4, 6]}
    runs = cogging.sweep(SMALL, MOVE, vary, seed=11, reductions=["command_max"])
    expected = list(itertools.product([0.1, 0.14], [5e3, 9e3], [4.0, 6.0]))
    assert list(zip(*(runs.table[path] for path in vary), strict=True)) == expected
    for run, (mass, kp, frequency) in enumerate(expected):
        model = SMALL.replace(axis=SMALL.axis.replace(mass=mass), controller=SMALL.controller.replace(kp=kp))
        log = cogging.simulate(model, {**MOVE, "frequency": frequency}, seed=11 + run)
        assert runs.table["seed"][run] == 11 + run
        assert runs.table["error_rms"][run] == cogging.performance(log.time, log.error, log.command).error_rms
        assert runs.table["command_max"][run] == abs(log.command).max()


def test_a_number_that_breaks_its_rule_is_a_row_with_the_reason():
    runs = cogging.sweep(SMALL, STROKE, {"reference.repeats": [1, 1.5]}, duration=0.1)
    assert runs.table["reason"].tolist() == ["", "reference.repeats: must be a whole number, got 1.5"]


@pytest.mark.filterwarnings("ignore:The balance properties of Sobol")
@pytest.mark.parametrize("method", ["random", "latin_hypercube", "sobol"])
def test_draws_have_the_stated_distributions(method):
    stated = {
        "axis.mass": "bounds",
        "axis.viscous": {"from": 0.1, "to": 0.3},
        "controller.kp": {"from": 1e2, "to": 1e4, "scale": "log"},
        "axis.coulomb": {"mean": 0.2, "deviation": 0.01},
        "seed": [1, 5, 9],
    }
    variations = [variation_of(path, how, SMALL) for path, how in stated.items()]
    drawn = points_of(variations, method, 4096, 3)
    np.testing.assert_array_equal(drawn, points_of(variations, method, 4096, 3))
    assert (drawn != points_of(variations, method, 4096, 4)).any()
    mass, viscous, gain, coulomb, seed = drawn.T
    wide = 1.0 if method == "random" else 0.3  # of four standard errors: the others fill space evenly
    assert np.mean((mass > 0.11) & (mass < 0.135)) == pytest.approx(0.95, abs=0.014 * wide)
    assert np.median(mass) == pytest.approx(0.12, abs=1e-3 * wide)
    assert np.quantile(viscous, [0, 0.25, 1]) == pytest.approx([0.1, 0.15, 0.3], abs=6e-3 * wide)
    assert np.median(np.log10(gain)) == pytest.approx(3.0, abs=0.08 * wide)
    assert coulomb.std() == pytest.approx(0.01, rel=0.05 * wide + 0.01)
    assert [np.mean(seed == value) for value in (1, 5, 9)] == pytest.approx([1 / 3] * 3, abs=0.03 * wide)
    assert np.corrcoef(drawn.T)[np.triu_indices(5, 1)] == pytest.approx(0.0, abs=0.07)


@pytest.fixture(scope="module")
def alone():
    """The table of the sweep without an executor, which nothing interrupts."""
    return cogging.sweep(SMALL, MOVE, MANY, **FEW)


def test_threads_and_processes_give_the_same_table(alone):
    for kind in (concurrent.futures.ThreadPoolExecutor, concurrent.futures.ProcessPoolExecutor):
        with kind(2) as executor:
            same(cogging.sweep(SMALL, MOVE, MANY, executor=executor, **FEW), alone)


class Dies(concurrent.futures.Executor):
    """After four pieces its workers are gone."""

    left = 4

    def submit(self, function, *given):
        future = concurrent.futures.Future()
        self.left -= 1
        if self.left < 0:
            future.set_exception(ModuleNotFoundError("No module named\n'cogging'"))
        else:
            future.set_result(function(*given))
        return future


def test_a_failed_executor_is_one_line_and_all_finished_runs_are_kept(tmp_path, alone):
    out = tmp_path / "runs.csv"
    message = r"^executor: Dies could not run a piece: ModuleNotFoundError: No module [^\n]*; finished work is kept in"
    with pytest.raises(cogging.InputError, match=message):
        cogging.sweep(SMALL, MOVE, MANY, out=out, executor=Dies(), **FEW)
    assert len((tmp_path / "runs.csv.kept").read_bytes().splitlines()) == 1 + 4
    same(cogging.sweep(SMALL, MOVE, MANY, out=out, **FEW), alone)


@POSIX
def test_after_a_killed_process_the_same_call_continues(tmp_path, alone):
    out, steps = tmp_path / "runs.csv", []
    with concurrent.futures.ProcessPoolExecutor(2) as pool:

        def kill_one(step):
            steps.append(step)
            if len(steps) == 4:
                os.kill(next(iter(pool._processes)), signal.SIGKILL)

        message = r"^executor: ProcessPoolExecutor could not run a piece: BrokenProcessPool: [^\n]*; finished work is "
        with pytest.raises(cogging.InputError, match=message):
            cogging.sweep(SMALL, MOVE, MANY, out=out, executor=pool, progress=kill_one, **FEW)
    steps.clear()
    same(cogging.sweep(SMALL, MOVE, MANY, out=out, progress=steps.append, **FEW), alone)
    assert 32 < int(steps[0].split()[0]) <= 320, "what was done is not made again"


def test_a_worker_with_another_version_is_one_line(tmp_path):
    new = multiprocessing.get_context("spawn")  # nothing is imported there but what the task imports
    message = r"^executor: ProcessPoolExecutor [^\n]*: RuntimeError: must have version \d[^\n]*, has 0\.0\.1$"
    with (
        concurrent.futures.ProcessPoolExecutor(1, mp_context=new, initializer=has_another_version) as pool,
        pytest.raises(cogging.InputError, match=message),
    ):
        cogging.sweep(SMALL, MOVE, MANY, out=tmp_path / "runs.csv", executor=pool, **FEW)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.study
@pytest.mark.filterwarnings("ignore")  # warnings of Dask
def test_killed_workers_of_dask_change_nothing(tmp_path):
    """Both, one after the other: Dask restarts the workers and their pieces."""
    distributed = pytest.importorskip("distributed")
    place = {"local_directory": str(tmp_path), "dashboard_address": None, "silence_logs": 50}
    move, steps = {**MOVE, "duration": 2.0}, []
    with distributed.LocalCluster(2, threads_per_worker=1, **place) as cluster, distributed.Client(cluster) as client:
        workers = list(client.run(os.getpid).values())

        def kill_one(step):
            steps.append(step)
            if len(steps) in (5, 20):
                os.kill(workers.pop(), signal.SIGKILL)

        found = cogging.sweep(SMALL, move, MANY, executor=client.get_executor(), progress=kill_one, **FEW)
    assert workers == []
    assert steps == [f"{8 * done} of 320 runs" for done in range(1, 41)]
    same(found, cogging.sweep(SMALL, move, MANY, **FEW))


class Ended(Exception):
    pass


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


def test_a_sweep_continues_where_it_ended(tmp_path, monkeypatch, alone):
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
    same(runs, alone)
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
def test_damaged_pieces_are_computed_again_and_copies_used_once(seed, tmp_path, monkeypatch, computed, alone):
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
    same(cogging.sweep(SMALL, MOVE, MANY, out=out, **FEW), alone)
    assert computed == [8 * place for place in (*hit, *range(19, 40))]
    assert [path.name for path in tmp_path.iterdir()] == ["runs.csv"]


def test_a_sweep_killed_in_its_first_line_begins_anew(tmp_path, monkeypatch, alone):
    out = tmp_path / "runs.csv"
    kept = end_sweep(out, monkeypatch)
    kept.write_bytes(kept.read_bytes()[:40])
    same(cogging.sweep(SMALL, MOVE, MANY, out=out, **FEW), alone)
    assert [path.name for path in tmp_path.iterdir()] == ["runs.csv"]


@POSIX
@pytest.mark.parametrize("make", [lambda path: path.write_text("thesis"), os.mkfifo, os.mkdir])
def test_what_no_sweep_wrote_is_refused_and_stays(make, tmp_path):
    kept = tmp_path / "runs.csv.kept"
    make(kept)
    with pytest.raises(cogging.InputError, match=r"^[^\n]*runs\.csv\.kept: "):
        cogging.sweep(SMALL, MOVE, MANY, out=tmp_path / "runs.csv", **FEW)
    assert list(tmp_path.iterdir()) == [kept]
