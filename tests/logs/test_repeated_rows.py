"""The same rows are no new evidence: logs given together count them once, and they confirm nothing."""

import numpy as np
import pytest

import cogging
from cogging import Log
from cogging.logs.repeated_rows import repeated
from tests.fixtures.moving_axis import machine, motion, record

FREE = ["axis.mass", "axis.coulomb"]


def bare(log, *, time=0.0):
    return Log(log.time + time, log.position, log.command)


@pytest.fixture(scope="module")
def log():
    return record(machine(), 3)


@pytest.fixture(scope="module")
def other():
    return record(machine(), 4)


@pytest.mark.parametrize("seed", range(2))
def test_repeats_of_a_motion_with_noise_are_not_the_same(seed):
    """The same machine, motion and controller; noise down to a thousandth of the command, some encoders so coarse
    that stretches of two runs are the same count by count."""
    random = np.random.default_rng(seed)
    force, resolution = 10.0 ** random.uniform(-3.0, -1.0), 10.0 ** random.uniform(-7.0, -5.5)
    if seed % 2:
        resolution, force = 10.0 ** random.uniform(-6.0, -4.7), 10.0 ** random.uniform(-2.5, -1.0)
    model = machine(force=force).replace(encoder=cogging.EncoderParameters(resolution=resolution))
    one, again, same = (cogging.simulate(model, motion(5), seed=k, duration=8.0, steps_per_sample=2) for k in (1, 2, 1))
    assert not repeated(one, again).any()
    assert repeated(one, same).all()


def resampled(log, random):
    """A copy on another grid, from some row on, by another clock, with commands held or interpolated."""
    step = float(np.median(np.diff(log.time)))
    first = int(random.integers(0, len(log) // 3))
    time = np.arange(log.time[first] + random.uniform(0.0, step), log.time[-1], random.uniform(0.4, 1.8) * step)
    held = log.command[np.searchsorted(log.time, time, side="right") - 1]
    command = held if random.random() < 0.5 else np.interp(time, log.time, log.command)
    return Log(time + random.uniform(-100.0, 100.0), np.interp(time, log.time, log.position), command)


COPIES = {
    "40 % left out": lambda log, random: bare(log)[random.random(len(log)) >= 0.4],
    "in mm and mV, from another zero": lambda log, random: Log(log.time, 1e3 * log.position + 7.0, 1e3 * log.command),
    "resampled": resampled,
}


@pytest.mark.parametrize("kind", COPIES)
def test_a_changed_copy_is_known(kind, log, other):
    copy = COPIES[kind](log, np.random.default_rng(1))
    assert repeated(copy, log).mean() > (0.3 if kind == "resampled" else 0.95)
    assert not repeated(copy, other).any()
    if kind != "resampled":  # the rows of the log itself lie on no line of a copy that lacks some
        assert repeated(log, copy).mean() == pytest.approx(len(copy) / len(log), rel=0.05)


def widths(found):
    return {p.path: p.ci95[1] - p.ci95[0] for p in found.parameters if p.determined}


def test_a_log_given_four_times_is_fitted_once(log, other):
    log = log[:2001]
    once = cogging.identify(log, machine(), names=["a"], free=FREE)
    copies = [log, bare(log, time=5.0), log, log[500:1500]]
    found = cogging.identify(copies, machine(), names=["a", "b", "c", "d"], free=FREE)
    assert widths(found) == widths(once), "to the bit"
    assert [entry.name for entry in found.logs] == ["a"]
    rows = {"b": 2001, "c": 2001, "d": 1000}
    assert found.notes == tuple(f"{name}: all its {n} rows are in a too: counted once" for name, n in rows.items())
    assert found.to_dict()["notes"] == list(found.notes)
    both = cogging.identify([log, other[:2001]], machine(), free=FREE)
    assert both.notes == once.notes == ()
    assert widths(both)["axis.coulomb"] < 0.9 * widths(once)["axis.coulomb"], "other motion does count"


#: Rows of a first and a second log, the note, and the rows that count.
REST = "counted once, and the other 100 are too few to count"
OVERLAPS = [
    (2500, 1500, 4001, "first: 1000 of its 2500 rows, from row 1500 on, are in second too: counted once", [1500, 2501]),
    (2600, 2450, 4001, None, [2600, 1551]),  # too few to matter
    (3000, 2500, 3100, f"second: 500 of its 600 rows, from row 0 on, are in first too: {REST}", [3000]),
]


@pytest.mark.parametrize(("end", "start", "stop", "note", "counted"), OVERLAPS)
def test_logs_that_overlap_count_their_common_rows_once(end, start, stop, note, counted, log):
    logs = [log[:end], log[start:stop]]
    added = [np.zeros(len(part)) for part in logs]
    found = cogging.identify(logs, machine(), names=["first", "second"], added_commands=added, free=FREE)
    assert found.notes == ((note,) if note else ())
    assert [audit.rows for audit in found.audits] == counted


def test_a_given_log_confirms_nothing(log, other):
    for confirm in (log, bare(log, time=3.0), log[1000:3000], [other, log[2000:]]):
        with pytest.raises(ValueError, match=r"confirm log \d: must be other motion than log 1 .*, but .* in it$"):
            cogging.diagnose(log, machine(), confirm=confirm)
