"""Each log of a call may have its own columns, scale, zero and rows."""

import argparse
import json
import random

import numpy as np
import pytest

import cogging
from cogging.cli.log_options import add_log_options, read_logs
from cogging.cli.main import main
from cogging.files import InputError


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Three logs of one motion: as it is; in mm and A with another name and zero; and one in a folder."""
    monkeypatch.chdir(tmp_path)
    time = np.arange(1000) * 1e-3
    position, command = 0.1 * np.sin(5 * time), np.cos(5 * time)
    cogging.Log(time, position, command).write("a.csv")
    rows = zip(time.tolist(), (1e3 * (position + 0.02)).tolist(), (command / 35).tolist(), strict=True)
    (tmp_path / "b.csv").write_text("time,qm,command\n" + "".join(f"{t!r},{q!r},{u!r}\n" for t, q, u in rows))
    (tmp_path / "runs").mkdir()
    cogging.Log(time, position, 2.0 * command).write("runs/c.csv")
    return tmp_path


def read(*words, logs=("a.csv", "b.csv"), confirm=("runs/c.csv",)):
    parser = argparse.ArgumentParser()
    parser.add_argument("logs", nargs="+")
    parser.add_argument("--confirm", nargs="+", default=[])
    add_log_options(parser)
    arguments = parser.parse_args([*logs, *(["--confirm", *confirm] if confirm else []), *words])
    return read_logs(arguments, [*arguments.logs, *arguments.confirm])


OWN = ["--columns", "b.csv:position=qm", "--scale", "b.csv:position=1e-3,b.csv:command=35,runs/c.csv:command=0.5"]


def test_one_overrides_all_and_options_add_up(folder):
    a, b, c = read(*OWN, "--scale", "command=3", "--rows", "10:900,c.csv:5:,a.csv::50", "--zero", "position=1")
    assert [len(a), len(b), len(c)] == [50, 890, 995]
    np.testing.assert_allclose(a.command, 3.0 * np.cos(5 * a.time))
    np.testing.assert_allclose(b.command, np.cos(5 * b.time))
    np.testing.assert_allclose(c.command, np.cos(5 * c.time))
    np.testing.assert_allclose(a.position, 0.1 * np.sin(5 * a.time) - 1.0)


@pytest.mark.parametrize(
    ("words", "rule"),
    [
        (["--scale", "d.csv:command=2"], "'d.csv': must be a file of this call, a.csv"),
        (["--rows", "d.csv:0:10"], "must be a file of this call"),
        (["--zero", "velocity=2"], "'velocity': must be a column of a.csv, time, position, command"),
    ],
)
def test_what_is_meant_for_no_log_is_refused(folder, words, rule):
    with pytest.raises(InputError, match=rule):
        read(*words, logs=("a.csv",))


@pytest.mark.parametrize("words", [["--rows", "a.csv:1"], ["--rows", "7"], ["--zero", "position=inf"], ["--zero", "x"]])
def test_a_wrong_option_is_one_line(folder, words, capsys):
    with pytest.raises(SystemExit):
        main(["audit", "a.csv", *words])
    assert capsys.readouterr().err.count("\n") == 1


def test_map_takes_them_too(folder, capsys):
    assert main(["map", "scan.csv", "--pitch", "0.05", "--zero", "other.csv:position=1"]) == 2
    assert "must be a file of this call, scan.csv" in capsys.readouterr().err


# Several times the same option, at the command line -------------------------------------------------------------------

SAID = {  # of b.csv; what is said of all files is overridden by what is said of one, whatever comes first
    "--columns": {"position": "qm, raw", "command": "i=1"},
    "--scale": {"position": "1e-3", "command": "35", "time": "1"},
    "--zero": {"position": "0.02", "time": "0"},
}


def split(said, draw):
    """The words that say it, in drawn pieces and order, with and without the file's name, each overridden or not."""
    pieces = []
    for option, pairs in said.items():
        entries = [f"{draw.choice(['', 'b.csv:', 'b.csv:'])}{name}={value}" for name, value in pairs.items()]
        draw.shuffle(entries)
        while entries:
            taken = draw.randrange(1, len(entries) + 1)
            pieces.append([option, ",".join(entries[:taken])])
            entries = entries[taken:]
    draw.shuffle(pieces)
    late = [["--rows", "5:100"], ["--rows", "b.csv:10:900"]]
    draw.shuffle(late)
    early = [["--scale", "command=7"], ["--columns", "position=nothing"], ["--zero", "position=9"]]
    return [word for piece in [*early, *pieces, *late] for word in piece]


def test_options_add_up_in_every_order_at_the_command_line(folder, capsys):
    lines = (folder / "b.csv").read_text().splitlines()
    (folder / "b.csv").write_text(
        "\n".join(["time;qm, raw;i=1", *(line.replace(",", ";") for line in lines[1:])]) + "\n"
    )
    draw = random.Random(19)
    for _ in range(6):
        assert main(["audit", "b.csv", "--json", "found.json", *split(SAID, draw)]) == 0
        (found,) = json.loads((folder / "found.json").read_text())
        plain = cogging.audit(read(logs=("a.csv",), confirm=())[0])
        whole = cogging.read_log("a.csv", rows=slice(10, 900))
        assert found["rows"] == len(whole) == 890
        assert found["command_rms"] == pytest.approx(cogging.audit(whole).command_rms)
        assert found["travel"] == pytest.approx(cogging.audit(whole).travel, abs=1e-12)
        assert found["rate"] == pytest.approx(plain.rate)
