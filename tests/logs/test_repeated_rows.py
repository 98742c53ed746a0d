"""The same rows are no new evidence: counted once where logs are given together, refused where they are to confirm."""

import json
from dataclasses import replace

import numpy as np
import pytest

import cogging
from cogging import Log
from cogging.cli.main import main
from cogging.identification.identification import identify
from cogging.logs.repeated_rows import STRETCH, repeated
from tests.fixtures.moving_axis import machine, motion, record

ROWS = 8001


def bare(log, *, time=0.0):
    return Log(log.time + time, log.position, log.command)


@pytest.fixture(scope="module")
def log():
    return record(machine(), 3)


@pytest.fixture(scope="module")
def other():
    return record(machine(), 4)


def test_parts_of_a_log_are_known_wherever_they_stand(log, other):
    random = np.random.default_rng(7)
    for _ in range(25):
        first, length = int(random.integers(0, 7000)), int(random.integers(2 * STRETCH, 4000))
        part = log[first : first + length]
        before, after = (other[: max(1, int(random.integers(0, 900)))] for _ in range(2))
        rows = [column for piece in (before, part, after) for column in [(piece.position, piece.command)]]
        position, command = (np.concatenate([pair[k] for pair in rows]) for k in (0, 1))
        mixed = Log(np.arange(len(position)) * 1e-3, position, command)
        found = repeated(mixed, log)
        expected = np.zeros(len(mixed), dtype=bool)
        expected[len(before) : len(before) + len(part)] = True
        assert np.sum(found != expected) <= 2, "a row at a seam may be like its neighbour"


@pytest.mark.parametrize("is_coarse", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_repeats_of_a_motion_with_noise_are_not_the_same(seed, is_coarse):
    """The same machine, motion and controller: noise down to a thousandth of the command, and encoders so coarse that
    stretches of two runs are the same count by count."""
    random = np.random.default_rng([3, seed] if is_coarse else seed)
    if is_coarse:
        resolution, force = 10.0 ** random.uniform(-6.0, -4.7), 10.0 ** random.uniform(-2.5, -1.0)
    else:
        force, resolution = 10.0 ** random.uniform(-3.0, -1.0), 10.0 ** random.uniform(-7.0, -5.5)
    model = machine(force=force).replace(encoder=cogging.EncoderParameters(resolution=resolution))
    one, again = (cogging.simulate(model, motion(5), seed=k, duration=8.0, steps_per_sample=2) for k in (1, 2))
    assert not repeated(one, again).any()
    same = cogging.simulate(model, motion(5), seed=1, duration=8.0, steps_per_sample=2)
    assert repeated(one, same).all()


def test_machines_at_rest_look_alike_and_are_not_the_same():
    random = np.random.default_rng(3)
    for kind in range(12):
        flicker = random.integers(0, 2 + kind % 3, (2, 3000)) * 1e-6
        ends = random.normal(size=(2, 300)) * 1e-3
        still = np.array(
            [np.concatenate([end.cumsum() * 1e-2, 0.1 + rest]) for end, rest in zip(ends, flicker, strict=True)]
        )
        if kind % 2:
            still[:, 300:] = 0.1
        logs = [Log(np.arange(3300) * 1e-3, position, -40.0 * (position - 0.1)) for position in still]
        assert not repeated(*logs).any()
        assert repeated(logs[0], logs[0]).any(), "but what moves is known again"


# What was changed -----------------------------------------------------------------------------------------------------


def left_out(log, random, share):
    return bare(log)[np.flatnonzero(random.random(len(log)) >= share)]


def read_anew(log, random, held):
    """A copy on another grid, from some row on, by another clock."""
    step = float(np.median(np.diff(log.time)))
    first = int(random.integers(0, len(log) // 3))
    time = np.arange(log.time[first] + random.uniform(0.0, step), log.time[-1], random.uniform(0.4, 1.8) * step)
    before = np.searchsorted(log.time, time, side="right") - 1
    command = log.command[before] if held else np.interp(time, log.time, log.command)
    return Log(time + random.uniform(-100.0, 100.0), np.interp(time, log.time, log.position), command)


CHANGED = {
    "itself": lambda log, random: log,
    "without references, at another time": lambda log, random: bare(log, time=1e4),
    "another reference": lambda log, random: replace(log, reference=log.reference + 0.01),
    "another clock": lambda log, random: Log(1.0001 * log.time, log.position, log.command),
    "scaled there and back": lambda log, random: replace(log, command=log.command / 35.15065 * 35.15065),
    "in single precision": lambda log, random: Log(
        log.time, log.position.astype(np.float32), log.command.astype(np.float32).astype(float)
    ),
    "5 % left out": lambda log, random: left_out(log, random, 0.05),
    "40 % left out": lambda log, random: left_out(log, random, 0.4),
    "every second": lambda log, random: bare(log)[::2],
    "5 % left out of a part": lambda log, random: left_out(bare(log)[2000:6000], random, 0.05),
    "in mm and mV, from another zero": lambda log, random: Log(log.time, 1e3 * log.position + 7.0, 1e3 * log.command),
    "in A, 5 % left out": lambda log, random: left_out(replace(log, command=log.command / 35.15), random, 0.05),
    "read anew": lambda log, random: read_anew(log, random, held=False),
    "read anew, commands held": lambda log, random: read_anew(log, random, held=True),
}


@pytest.mark.parametrize("kind", CHANGED)
def test_a_changed_copy_is_known(kind, log, other):
    for seed in range(2):
        copy = CHANGED[kind](log, np.random.default_rng(seed))
        assert repeated(copy, log).mean() > (0.3 if "anew" in kind else 0.95)
        assert not repeated(copy, other).any()
        if "anew" not in kind:  # the rows of the log itself lie on no line of a copy that lacks some
            assert repeated(log, copy).mean() == pytest.approx(len(copy) / len(log), rel=0.05)


# identify -------------------------------------------------------------------------------------------------------------


def widths(found):
    return {p.path: p.ci95[1] - p.ci95[0] for p in found.parameters if p.determined}


def test_a_log_given_four_times_is_fitted_once(log, other):
    once = identify(log, machine(), names=["a"])
    copies = [log, bare(log, time=5.0), log, log[2000:6000]]
    found = identify(copies, machine(), names=["a", "b", "c", "d"])
    assert widths(found) == widths(once), "to the bit"
    assert [entry.name for entry in found.logs] == ["a"]
    assert found.notes == (
        f"b: all its {ROWS} rows are in a too: counted once",
        f"c: all its {ROWS} rows are in a too: counted once",
        "d: all its 4000 rows are in a too: counted once",
    )
    for note in found.notes:
        assert f"note: {note}" in found.text()
    assert found.to_dict()["notes"] == list(found.notes)
    assert once.notes == ()
    both = identify([log, other], machine())
    assert both.notes == ()
    assert widths(both)["axis.coulomb"] < 0.9 * widths(once)["axis.coulomb"], "other motion does count"


def test_logs_that_overlap_count_their_common_rows_once(log):
    first, second = log[:5000], log[3000:]
    added = [np.zeros(5000), np.linspace(0.0, 1e-9, 5001)]
    found = identify([first, second], machine(), names=["first", "second"], added_commands=added)
    assert found.notes == ("first: 2000 of its 5000 rows, from row 3000 on, are in second too: counted once",)
    assert [audit.rows for audit in found.audits] == [3000, 5001]
    whole = widths(identify(log, machine()))
    for path, width in widths(found).items():
        assert width == 0.0 or 0.75 * whole[path] < width, path
    part = identify([log[2000:6000], log], machine(), names=["part", "whole"])
    assert part.notes == ("part: all its 4000 rows are in whole too: counted once",), "the longest stays whole"
    short = log[4900:]
    found = identify([log[:5050], short], machine(), names=["first", "second"])
    assert found.notes == (), f"under {STRETCH} rows in common are little"


def test_what_is_left_may_be_too_little(log):
    first, second = log[:6000], log[5500:6100]
    found = identify([first, second], machine(), names=["first", "second"])
    (note,) = found.notes
    assert note == (
        "second: 500 of its 600 rows, from row 0 on, are in first too: counted once, and the other 100 are too few to "
        "count"
    )
    assert [entry.name for entry in found.logs] == ["first"]


# diagnose -------------------------------------------------------------------------------------------------------------


def test_a_given_log_confirms_nothing(log, other):
    for confirm in (log, bare(log, time=3.0), log[1000:5000], [other, log[4000:]]):
        with pytest.raises(ValueError, match=r"confirm log \d: must be other motion than log 1 .*, but .* in it$"):
            cogging.diagnose(log, machine(), confirm=confirm)


def test_given_logs_count_once(log, other):
    result = cogging.diagnose([log, bare(log)], machine(), confirm=[other, bare(other)])
    assert result.verdict == "no_gap"
    assert result.notes[:2] == (
        f"log 2: all its {ROWS} rows are in log 1 too: counted once",
        f"confirm log 2: all its {ROWS} rows are in confirm log 1 too: counted once",
    )


# Commands -------------------------------------------------------------------------------------------------------------


def test_the_commands_say_so(log, other, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    log.write("a.csv")
    log.write("b.parquet")
    other.write("c.csv")
    machine().write("m.toml")
    assert main(["identify", "a.csv", "b.parquet", "a.csv", "--model", "m.toml", "--json", "f.json"]) == 0
    said = capsys.readouterr().out
    expected = [f"{name}: all its {ROWS} rows are in a.csv too: counted once" for name in ("b.parquet", "a.csv")]
    for note in expected:
        assert f"note: {note}" in said
    assert json.loads((tmp_path / "f.json").read_text())["notes"] == expected
    assert main(["diagnose", "a.csv", "--confirm", "c.csv", "b.parquet", "--model", "m.toml", "--json", "d.json"]) == 2
    answer = capsys.readouterr()
    assert answer.err.splitlines()[-1] == (
        f"cogging: b.parquet: must be other motion than a.csv to confirm anything, but all its {ROWS} rows are in it"
    )
    assert not (tmp_path / "d.json").exists()
