"""Sweeps on real Dask clusters: workers that are killed, lack the package or are all gone."""

import contextlib
import os
import random
import signal

import distributed
import pytest

import cogging
from cogging.simulation import sweep as sweeps
from tests.fixtures.sweeps import FEW, MANY, MOVE, SMALL, same

pytestmark = [pytest.mark.study, pytest.mark.filterwarnings("ignore")]  # its own warnings


@pytest.fixture
def started(tmp_path):
    """A function that starts a cluster of so many worker processes, and gives it with a client."""
    place = {"local_directory": str(tmp_path), "dashboard_address": None, "silence_logs": 50}
    with contextlib.ExitStack() as stack:

        def start(workers):
            cluster = distributed.LocalCluster(workers, threads_per_worker=1, processes=True, **place)
            return stack.enter_context(cluster), stack.enter_context(distributed.Client(cluster))

        yield start


def add_one_that(cluster, is_made_so):
    """Give a cluster a further worker that runs a function of lacking_workers before it begins."""
    options = {
        **cluster.new_spec["options"],
        "preload": [f"from tests.fixtures.lacking_workers import *\n{is_made_so}()"],
    }
    cluster.worker_spec["lacking"] = {"cls": cluster.new_spec["cls"], "options": options}
    cluster.sync(cluster._correct_state)


def process():
    return os.getpid()


@pytest.mark.parametrize("seed", range(3))
def test_a_worker_that_is_killed_changes_nothing(started, seed):
    """Both, one after the other, at random pieces: Dask gives theirs to the one that is left, and starts others."""
    _, client = started(2)
    rng, told, workers = random.Random(seed), [], list(client.run(process).values())
    at = sorted(rng.sample(range(1, 35), 2))

    def kill_one(step):
        told.append(step)
        if len(told) in at:
            os.kill(workers.pop(), signal.SIGKILL)

    found = cogging.sweep(
        SMALL, {**MOVE, "duration": 2.0}, MANY, executor=client.get_executor(), progress=kill_one, **FEW
    )
    assert workers == []
    assert told == [f"{8 * done} of 320 runs" for done in range(1, 41)]
    same(found, cogging.sweep(SMALL, {**MOVE, "duration": 2.0}, MANY, **FEW))


@pytest.mark.parametrize("good", [0, 1])
@pytest.mark.parametrize(
    ("is_made_so", "text"),
    [
        ("lacks_the_package", r"cannot import the package: .*, process \d+: ModuleNotFoundError: No module named"),
        ("has_another_version", r"has another version of the package: .*, process \d+: 0\.0\.1, where this is"),
    ],
)
def test_a_worker_that_lacks_the_package_is_one_line(started, tmp_path, good, is_made_so, text):
    """Alone, or beside a good one, whose pieces stand; once it is gone the same call goes on."""
    cluster, client = started(good)
    add_one_that(cluster, is_made_so)
    client.wait_for_workers(good + 1, timeout=30)
    out = tmp_path / "runs.csv"
    with pytest.raises(cogging.InputError, match=f"^executor: ClientExecutor has a worker that {text}") as found:
        cogging.sweep(SMALL, MOVE, MANY, out=out, executor=client.get_executor(), **FEW)
    assert "\n" not in str(found.value)
    stands = str(found.value).endswith("runs.csv.pieces, the same call continues from there")
    assert stands == (tmp_path / "runs.csv.pieces").exists()
    assert not (stands and good == 0)
    del cluster.worker_spec["lacking"]
    cluster.scale(1)
    cluster.sync(cluster._correct_state)
    again = cogging.sweep(SMALL, MOVE, MANY, out=out, executor=client.get_executor(), **FEW)
    same(again, cogging.sweep(SMALL, MOVE, MANY, **FEW))


def test_where_no_worker_is_left_it_ends(started, monkeypatch, tmp_path):
    monkeypatch.setattr(sweeps, "GONE_MOST", 1.5)
    monkeypatch.setattr(sweeps, "LOOK_EVERY", 0.2)
    cluster, client = started(1)

    def take_all(step):
        if step.startswith("40 of"):
            cluster.scale(0)

    text = r"^executor: ClientExecutor has had no worker left for 1\.5 s; finished runs are kept in .*pieces, the same"
    with pytest.raises(cogging.InputError, match=text):
        cogging.sweep(
            SMALL,
            {**MOVE, "duration": 5.0},
            MANY,
            out=tmp_path / "runs.csv",
            executor=client.get_executor(),
            progress=take_all,
            **FEW,
        )
    assert 5 <= len(list((tmp_path / "runs.csv.pieces").glob("[0-9]*.npz"))) < 40


@pytest.mark.parametrize("ends", ["client", "cluster"])
def test_a_connection_that_is_lost_is_one_line(started, ends, tmp_path):
    cluster, client = started(1)

    def close(step):
        if step.startswith("24 of"):
            (client if ends == "client" else cluster).close()

    with pytest.raises(
        cogging.InputError, match=r"^executor: ClientExecutor [^\n]*; finished runs are kept in [^\n]*$"
    ):
        cogging.sweep(
            SMALL, MOVE, MANY, out=tmp_path / "runs.csv", executor=client.get_executor(), progress=close, **FEW
        )
