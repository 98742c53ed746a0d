"""Text tables: every number is kept to the last bit, and an ambiguous table is refused with a question."""

import csv
import io
import random

import numpy as np
import pytest

import cogging
from cogging.files import InputError
from cogging.logs.readers import text_table

ROWS = [[repr(0.001 * k), repr(0.01 * k), repr(1.0 - 0.1 * k)] for k in range(30)]
NAMES = ("time", "position", "command")


def table(labels, rows=ROWS):
    return "".join(",".join(line) + "\n" for line in [labels, *rows])


TABLE = "time,position,command\n0,0.5,-1\n0.1,0.25,2e-3\n"
TEXTS = {
    "comma and space": TABLE.replace(",", ", "),
    "byte order mark": "\ufeff" + TABLE,
    "blank lines": "\n" + TABLE.replace("\n", "\n\n"),
    "lines before the header": "Date:;2020-07-08\nSerial, 17\n\n" + TABLE,
    "SI units": TABLE.replace("time,position,command", "time [s],position [m],command (V)"),
    "a row of units": TABLE.replace("command\n", "command\ns,m,A\n"),
    "separators at the ends": TABLE.replace("\n", ",\n"),
    "other columns": 'a text,time,n,position,command\n"x, y",0,,0.5,-1\nz,0.1,7,0.25,2e-3\n',
    "names that hold a name": TABLE.replace("command\n", "command,position error,motor_position,time2\n")
    .replace("-1\n", "-1,1,2,3\n")
    .replace("e-3\n", "e-3,1,2,3\n"),
}


@pytest.mark.parametrize("case", TEXTS)
def test_text_tables(case, tmp_path):
    (tmp_path / "log.csv").write_text(TEXTS[case], newline="")
    log = cogging.read_log(tmp_path / "log.csv")
    np.testing.assert_array_equal([log.time, log.position, log.command], [[0.0, 0.1], [0.5, 0.25], [-1.0, 2e-3]])


def number(value, draw):
    """A number as an export writes it: in full, with few decimals, in powers of ten, without a leading zero."""
    few = [f"{value:.4f}", f"{value:.7e}", f"{value:+.6f}", f"{value:.5f}".replace("0.", ".")]
    return draw.choice([repr(value), *few])


def drawn_table(draw, has_commas):
    """Three named columns among others as text, with decimal commas or points; labels and numbers by name."""
    separator = draw.choice([";", "\t", " ", ","])
    names = [*NAMES, *draw.sample(["Temp", "state", "note"], draw.randrange(4))]
    draw.shuffle(names)
    labels = {name: name if separator == " " else draw.choice([name, f"{name}, x", f'a "{name}"; x']) for name in names}
    rows, values = [], {name: [] for name in names}
    for k in range(draw.randrange(3, 60)):
        row = []
        for name in names:
            if name == "note":
                text = "-" if separator == " " else "".join(draw.choices(['"', ",", ";", " ", "a", "'", "\t"], k=4))
            elif name in ("state", "time"):
                text = repr(1e-3 * k if name == "time" else k % 2)
            else:
                text = number(draw.uniform(-3.0, 3.0) * 10.0 ** draw.randrange(-4, 3), draw)
            values[name].append(text)
            row.append(text.replace(".", ",") if has_commas and name != "note" else text)
        rows.append(row)
    quoting = csv.QUOTE_ALL if separator == "," and has_commas else csv.QUOTE_MINIMAL
    quoting = draw.choice([quoting, csv.QUOTE_ALL]) if separator != " " else quoting
    buffer = io.StringIO()
    writer = csv.writer(buffer, delimiter=separator, quoting=quoting, lineterminator=draw.choice(["\n", "\r\n"]))
    writer.writerows([list(labels.values()), *rows])
    above = draw.choice(["", "# made by a drive\n", "Export 3\n\n"])
    return above + buffer.getvalue(), labels, values


@pytest.mark.parametrize("has_commas", [True, False], ids=["commas", "points"])
def test_drawn_tables_are_read_to_the_last_bit(has_commas, tmp_path):
    path = tmp_path / "log.csv"
    for seed in range(40):
        text, labels, values = drawn_table(random.Random(seed), has_commas)
        path.write_bytes(text.encode())
        log = cogging.read_log(path, columns={name: labels[name] for name in NAMES})
        for name in NAMES:
            np.testing.assert_array_equal(getattr(log, name), np.array(values[name], dtype=float), err_msg=text[:200])
        assert log.metadata == ({"read_with": ["decimal commas"]} if has_commas else {})


def test_numbers_are_read_to_the_last_bit_wherever_a_block_ends(tmp_path, monkeypatch):
    values = np.random.default_rng(0).integers(0, 1 << 63, 3000).view(np.float64)
    values = values[np.isfinite(values)]
    lines = "".join(f"{k},{value!r},{-value!r}\n" for k, value in enumerate(values.tolist()))
    (tmp_path / "log.csv").write_text("time,position,command\n" + lines)
    for block in (1 << 22, 1000, 7):
        monkeypatch.setattr(text_table, "BLOCK", block)
        log = cogging.read_log(tmp_path / "log.csv")
        np.testing.assert_array_equal([log.position, log.command], [values, -values])
        few = cogging.read_log(tmp_path / "log.csv", rows=slice(100, 200))
        np.testing.assert_array_equal(few.position, values[100:200])


NEARLY = [("position", "POSITION", 0), ("time", "Time [s]", 4), ("reference", "Reference", 0)]


@pytest.mark.parametrize(("name", "label", "place"), NEARLY)
def test_a_column_beside_one_of_nearly_its_name_is_asked_about(name, label, place, tmp_path):
    labels, rows = [*NAMES, "reference"], [[*row, row[1]] for row in ROWS]
    for row, added in zip([labels, *rows], [label, *(repr(1000.0 * k) for k in range(30))], strict=True):
        row.insert(place, added)
    path = tmp_path / "log.csv"
    path.write_text(table(labels, rows))
    with pytest.raises(InputError) as refused:
        cogging.read_log(path)
    for words in (f"column {name}: must be one column of the header", repr(name), repr(label), f'--columns "{name}='):
        assert words in str(refused.value)
    plain, other = (cogging.read_log(path, columns={name: one}, scale={name: 1.0}) for one in (name, label))
    assert not np.array_equal(getattr(other, name), getattr(plain, name))


def test_a_lost_quote_is_refused_with_its_line(tmp_path):
    """One quote taken out of a quoted table, anywhere."""
    lines = ['"time","position","command","note"', *(",".join(f'"{v}"' for v in (*row, "a, b")) for row in ROWS[:4])]
    for i, line in enumerate(lines):
        for at, letter in enumerate(line):
            if letter != '"' or line[at:] == '"note"':  # a column that nobody asked for may be called note"
                continue
            damaged = [*lines[:i], line[:at] + line[at + 1 :], *lines[i + 1 :]]
            (tmp_path / "log.csv").write_text("\n".join(damaged) + "\n")
            with pytest.raises(InputError, match=rf"line {i + 1}\b|column .* must be in the header"):
                cogging.read_log(tmp_path / "log.csv")
