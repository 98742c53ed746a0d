"""Pauses and lost rows cost no memory, move no fit, hide no effect and feign none."""

import dataclasses
import json
import subprocess
import sys

import numpy as np
import pytest

import cogging
from tests.fixtures.moving_axis import machine, record

SCRIPT = """
import json, resource
resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))
import cogging
import numpy as np
from tests.fixtures.moving_axis import machine, paused, record
log, answer = record(machine(), 3)[:2001], {}
idle = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
for name, pauses in {"none": {}, "both": {500: 1e5, 1500: 3.15e7}}.items():
    found = cogging.identify(paused(log, pauses), machine(), free=["axis.mass", "axis.coulomb"])
    answer[name] = {p.path: [p.value, *p.ci95] for p in found.parameters}
    assert cogging.audit(paused(log, pauses), machine()).gaps == len(pauses)
hidden = [cogging.effects.ViscousAsymmetry(difference=1.5)]
log, other = (record(machine(hidden), seed)[:2001] for seed in (3, 4))
log = log[np.random.default_rng(3).random(len(log)) > 0.03]
result = cogging.diagnose(paused(log, {1250: 3.15e7}), machine(), confirm=paused(other, {1500: 86400.0}))
answer["effects"] = {e.name: e.parameters["difference"].ci95 for e in result.effects}
answer["notes"] = list(result.notes)
answer["megabytes"] = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - idle) / 1024
print(json.dumps(answer))
"""


@pytest.fixture(scope="module")
def log():
    return record(machine(), 3)


def test_pauses_cost_no_memory_move_no_fit_and_hide_no_effect():
    """In a separate process, whose memory is measured: a day took 12 GB and more."""
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer["megabytes"] < 300.0
    for path, (value, low, high) in answer["none"].items():
        with_pauses, low_with, high_with = answer["both"][path]
        assert abs(with_pauses - value) < 0.25 * (high - low), path
        assert 0.6 < (high_with - low_with) / (high - low) < 1.7, path
    low, high = answer["effects"].pop("viscous_asymmetry")
    assert low < 1.5 < high
    assert not answer["effects"]
    pauses = [note for note in answer["notes"] if "pause" in note]
    assert pauses[0] == (
        "log 1: 1 pause in the rows, the longest of 3.15e+07 s after row 1249: cut to 0.5 s, and all times here "
        "exclude what was cut"
    )
    assert [note.partition(":")[0] for note in pauses] == ["log 1", "confirm log 1"]
    assert any("interpolation" in note for note in answer["notes"])
    assert any(note.endswith("the gap is that of the force balance") for note in answer["notes"])


@pytest.mark.parametrize("judge", [cogging.identify, cogging.diagnose])
def test_rows_that_fill_hardly_any_of_the_time_are_refused(judge, log):
    rows = np.arange(len(log))
    time = rows // 3 * 100.0 + rows % 3 * 1e-3  # three rows, and a pause after each three
    with pytest.raises(ValueError, match=r"log 1: time: must have rows in at least 5 % of the time, .* got 0\.\d+ %"):
        judge(dataclasses.replace(log, time=time), machine())
