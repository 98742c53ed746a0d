"""Each log of a call may have its own columns, scale, zero and rows."""

import json
import random

import numpy as np
import pytest

import cogging
from cogging.cli.main import main


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Three logs of one motion: as it is; in mm and A with another zero and other names; and one in a folder."""
    monkeypatch.chdir(tmp_path)
    time = np.arange(1000) * 1e-3
    position, command = 0.1 * np.sin(5 * time), np.cos(5 * time)
    cogging.Log(time, position, command).write("a.csv")
    rows = zip(time.tolist(), (1e3 * (position + 0.02)).tolist(), (command / 35).tolist(), strict=True)
    (tmp_path / "b.csv").write_text("time;qm, raw;i=1\n" + "".join(f"{t!r};{q!r};{u!r}\n" for t, q, u in rows))
    (tmp_path / "runs").mkdir()
    cogging.Log(time, position, 2.0 * command).write("runs/c.csv")
    return tmp_path


#: Options that add up, of one file or of all; and others before them, which they override.
LATE = ["--columns=position=qm, raw", "--columns=b.csv:command=i=1", "--scale=b.csv:position=1e-3,b.csv:command=35"]
LATE += ["--scale=command=1,time=1", "--zero=b.csv:position=0.02", "--rows=10:900"]
OTHERS = ["--columns=a.csv:position=position", "--columns=c.csv:position=position", "--scale=runs/c.csv:command=0.5"]
OTHERS += ["--rows=c.csv:5:,a.csv::50"]
EARLY = ["--rows=5:100", "--scale=command=7", "--columns=position=nothing", "--zero=position=9,time=0"]
EARLY += ["--zero=a.csv:position=0,runs/c.csv:position=0"]


def test_options_add_up_in_every_order_and_those_of_a_file_override_those_of_all(folder):
    draw = random.Random(19)
    for _ in range(4):
        words = [*EARLY, *draw.sample([*LATE, *OTHERS], len(LATE) + len(OTHERS))]
        assert main(["audit", "a.csv", "b.csv", "runs/c.csv", "--json", "found.json", *words]) == 0
        found = json.loads((folder / "found.json").read_text())
        for one, rows in zip(found, (slice(50), slice(10, 900), slice(5, None)), strict=True):
            whole = cogging.audit(cogging.read_log("a.csv", rows=rows))
            assert one["rows"] == whole.rows
            assert one["command_rms"] == pytest.approx(whole.command_rms)
            assert one["travel"] == pytest.approx(whole.travel, abs=1e-12)
