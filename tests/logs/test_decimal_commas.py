"""Tables with decimal commas are read as they are, to the last bit, and that is said; drawn in all their forms."""

import csv
import io
import random

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from cogging.logs.columns import read_columns


def number(value, draw):
    """A number as an export writes it: in full, with few decimals, in powers of ten, without a leading zero."""
    return draw.choice(
        [repr(value), f"{value:.4f}", f"{value:.7e}", f"{value:+.6f}", f"{value:.5f}".replace("0.", ".")]
    )


def drawn_table(seed, comma):
    """A table of three named columns among others, as text, with decimal commas or points; and its numbers."""
    draw = random.Random(seed)
    separator = draw.choice([";", "\t", " ", ","] if comma else [";", "\t", " ", ",", ";"])
    names = ["time", "position", "command", *draw.sample(["Temp", "state", "n"], draw.randrange(3))]
    draw.shuffle(names)
    rows, values = [], {name: [] for name in names}
    for k in range(draw.randrange(3, 60)):
        row = []
        for name in names:
            value = {"time": 1e-3 * k, "state": k % 2, "n": k}.get(
                name, draw.uniform(-3.0, 3.0) * 10.0 ** draw.randrange(-4, 3)
            )
            text = number(float(value), draw) if name not in ("state", "n", "time") else repr(value)
            values[name].append(float(text))
            row.append(text.replace(".", ",") if comma else text)
        rows.append(row)
    buffer = io.StringIO()
    quoting = draw.choice([csv.QUOTE_MINIMAL, csv.QUOTE_ALL]) if separator != " " else csv.QUOTE_MINIMAL
    quoting = csv.QUOTE_ALL if separator == "," and comma else quoting
    writer = csv.writer(buffer, delimiter=separator, quoting=quoting, lineterminator=draw.choice(["\n", "\r\n"]))
    writer.writerows([names, *rows])
    above = draw.choice(["", "# made by a drive\n", "Export 3\n\n"])
    return above + buffer.getvalue(), values


@pytest.mark.parametrize("comma", [True, False], ids=["commas", "points"])
def test_drawn_tables_are_read_as_they_are(comma, tmp_path):
    for seed in range(60):
        text, values = drawn_table(seed, comma)
        path = tmp_path / f"{seed}.csv"
        path.write_bytes(text.encode())
        log = cogging.read_log(path)
        for name in ("time", "position", "command"):
            np.testing.assert_array_equal(getattr(log, name), values[name], err_msg=text[:200])
        assert log.metadata == ({"read_with": ["decimal commas"]} if comma else {})


def test_the_audit_says_so_and_a_written_log_has_points(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = [f"{k / 1000};{k * k / 7e5};{k % 3}\n".replace(".", ",") for k in range(300)]
    (tmp_path / "a.csv").write_text("time;position;command\n" + "".join(rows))
    assert main(["audit", "a.csv"]) == 0
    assert "read with decimal commas" in capsys.readouterr().out
    cogging.read_log("a.csv").write("b.csv")
    assert not (tmp_path / "b.csv.toml").exists()
    again = cogging.read_log("b.csv")
    np.testing.assert_array_equal(again.position, cogging.read_log("a.csv").position)
    assert again.metadata == {}


def test_a_scan_is_read_so_too(tmp_path):
    path = tmp_path / "scan.csv"
    path.write_text("position [mm];force [N]\n" + "".join(f"{k},25;{k % 5},5\n" for k in range(50)))
    table = read_columns(path, ("position", "force"), scale={"position": 1e-3})
    np.testing.assert_allclose(table["position"], 1e-3 * (np.arange(50) + 0.25), rtol=1e-15)
    np.testing.assert_array_equal(table["force"], np.arange(50) % 5 + 0.5)


def test_a_header_with_commas_in_its_names(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time, s;position, mm;command, A\n" + "".join(f"0,{k:03d};1,{k};2\n" for k in range(9)))
    log = cogging.read_log(
        path, columns={"time": "time, s", "position": "position, mm", "command": "command, A"}, scale={"position": 1e-3}
    )
    np.testing.assert_allclose(log.position, [1e-3 * float(f"1.{k}") for k in range(9)], rtol=1e-15)
