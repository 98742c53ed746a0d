"""Which column of a table is meant, and quotes that do not close: asked about and refused, not guessed."""

import csv
import io

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from cogging.files import InputError

ROWS = [[repr(0.001 * k), repr(0.01 * k), repr(1.0 - 0.1 * k)] for k in range(30)]


def table(labels, rows=ROWS, separator=","):
    return "".join(separator.join(line) + "\n" for line in [labels, *rows])


def with_column(label, place, scale=1000.0):
    labels, rows = ["time", "position", "command"], [list(row) for row in ROWS]
    labels.insert(place, label)
    for row in rows:
        row.insert(place, repr(scale * float(row[1 if place > 1 else 0])))
    return table(labels, rows)


# Columns that may both be meant ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("position", "position [m]"),
        ("position", "position [mm]"),
        ("position", "Position"),
        ("position", "POSITION (mm)"),
        ("time", "Time [s]"),
        ("time", "time [ms]"),
        ("command", "Command"),
        ("command", "command [A]"),
    ],
)
@pytest.mark.parametrize("place", [0, 3])
def test_a_column_beside_one_of_nearly_its_name_is_asked_about(name, label, place, tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(with_column(label, place))
    with pytest.raises(InputError) as refused:
        cogging.read_log(path)
    said = str(refused.value)
    assert f"column {name}: must be one column of the header" in said
    assert repr(name) in said
    assert repr(label) in said
    assert f'--columns "{name}=' in said
    plain = cogging.read_log(path, columns={name: name})
    for column, k in (("time", 0), ("position", 1), ("command", 2)):
        np.testing.assert_array_equal(getattr(plain, column), [float(row[k]) for row in ROWS])
    other = cogging.read_log(path, columns={name: label}, scale={name: 1.0})
    assert not np.array_equal(getattr(other, name), getattr(plain, name))


def test_an_optional_column_is_asked_about_too(tmp_path):
    path = tmp_path / "log.csv"
    rows = [[*row, row[1], row[1]] for row in ROWS]
    path.write_text(table(["time", "position", "command", "reference", "Reference [m]"], rows))
    with pytest.raises(InputError, match=r"column reference: .*'reference', 'Reference \[m\]'"):
        cogging.read_log(path)
    assert cogging.read_log(path, columns={"reference": "reference"}).reference is not None


def test_two_units_of_one_name(tmp_path):
    path = tmp_path / "log.csv"
    rows = [[*row, row[1]] for row in ROWS]
    path.write_text(table(["time", "x [m]", "command", "x [mm]"], rows))
    with pytest.raises(InputError, match=r"column x: .*'x \[m\]', 'x \[mm\]'.*--columns \"position=x \[m\]\""):
        cogging.read_log(path, columns={"position": "x"})
    assert len(cogging.read_log(path, columns={"position": "x [m]"})) == len(ROWS)


def test_other_columns_whose_names_only_hold_the_name_are_no_matter(tmp_path):
    path = tmp_path / "log.csv"
    rows = [[*row, "1", "2", "3"] for row in ROWS]
    path.write_text(table(["time", "position", "command", "position error", "motor_position", "time2"], rows))
    assert len(cogging.read_log(path)) == len(ROWS)


@pytest.mark.parametrize("suffix", ["mat", "parquet"])
def test_the_same_in_other_formats(suffix, tmp_path):
    columns = {
        name: np.array([float(row[k]) for row in ROWS]) for k, name in enumerate(("time", "position", "command"))
    }
    columns["Position"] = 2.0 * columns["position"]
    path = tmp_path / f"log.{suffix}"
    if suffix == "mat":
        from scipy.io import savemat

        savemat(path, columns, oned_as="column")
    else:
        import pyarrow as pa
        import pyarrow.parquet as parquet

        parquet.write_table(pa.table(columns), path)
    with pytest.raises(InputError, match="column position: must be one column of the file, got 'position', 'Position'"):
        cogging.read_log(path)
    chosen = cogging.read_log(path, columns={"position": "Position"})
    np.testing.assert_array_equal(chosen.position, columns["Position"])


# Quotes ---------------------------------------------------------------------------------------------------------------

HEAD = "time,position,command,note\n"
FAULTS = {
    "open at the header's end": ('time,position,command,"note\n0,1,2,x\n1,2,3,x\n', "line 1: must close its quotes"),
    "open in the header": ('time,"position,command,note\n0,1,2,x\n1,2,3,x\n', "line 1: must close its quotes"),
    "text behind a label": ('time,"position"x,command\n0,1,2\n1,2,3\n', "line 1: must have a separator behind closed"),
    "open in a row of units": (HEAD + 's,m,V,"\n0,1,2,x\n1,2,3,x\n', "line 2: must close its quotes"),
    "open in a number": (HEAD + '0,1,2,x\n1,"2,3,x\n', "line 3: must close its quotes"),
    "open in the last number": ('time,position,command\n0,1,2\n1,2,"3\n', "line 3: must close its quotes"),
    "open in a note": (HEAD + '0,1,2,x\n1,2,3,"x\n2,3,4,x\n', "line 3: must close its quotes"),
    "open in the last line": (HEAD + '0,1,2,x\n1,2,3,"x', "line 3: must close its quotes"),
    "open over two lines": (HEAD + '0,1,2,"x\ny"\n1,2,3,x\n', "line 2: must close its quotes"),
    "open before other columns": ('note,time,position,command\nx,0,1,2\n"x,1,2,3\n', "line 3: must close its quotes"),
    "text behind a number": (HEAD + '0,1,2,x\n1,"2"3,3,x\n', "line 3: must have a separator behind closed quotes"),
    "text behind a note": (HEAD + '0,1,2,x\n1,2,3,"x"y\n', "line 3: must have a separator behind closed quotes"),
    "a doubled quote that closes nothing": (HEAD + '0,1,2,x\n1,2,3,"x""\n', "line 3: must close its quotes"),
}


@pytest.mark.parametrize("separator", [",", ";", "\t"])
@pytest.mark.parametrize("case", FAULTS)
def test_quotes_that_do_not_close_are_refused_with_the_line(case, separator, tmp_path, capsys):
    text, message = FAULTS[case]
    path = tmp_path / "log.csv"
    path.write_text(text.replace(",", separator))
    with pytest.raises(InputError, match=rf"log\.csv: {message}"):
        cogging.read_log(path)
    assert main(["audit", str(path)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_quotes_that_close_are_read_as_python_reads_them(tmp_path):
    """Random notes with quotes, separators and blanks, written by the csv module."""
    random = np.random.default_rng(5)
    letters = ['"', ",", ";", " ", "a", "x y", "'", '""', "\t", "1.5"]
    for trial in range(150):
        separator = [",", ";", "\t"][trial % 3]
        places = random.permutation(4).tolist()
        labels = [["time", "position", "command", 'a "note"; of, x'][k] for k in places]
        quoting = csv.QUOTE_ALL if random.random() < 0.5 else csv.QUOTE_MINIMAL
        file = io.StringIO()
        writer = csv.writer(file, delimiter=separator, quoting=quoting, lineterminator="\n")
        writer.writerow(labels)
        for row in ROWS[:5]:
            note = "".join(random.choice(letters, size=random.integers(0, 7)))
            writer.writerow([[*row, note][k] for k in places])
        path = tmp_path / "log.csv"
        path.write_text(file.getvalue())
        log = cogging.read_log(path)
        np.testing.assert_array_equal(log.position, [float(row[1]) for row in ROWS[:5]], err_msg=file.getvalue())
        np.testing.assert_array_equal(log.command, [float(row[2]) for row in ROWS[:5]])


def test_a_lost_quote_is_never_read_silently(tmp_path):
    """One quote taken out of a quoted table, anywhere: refused with its line."""
    lines = ['"time","position","command","note"', *(",".join(f'"{v}"' for v in (*row, "a, b")) for row in ROWS[:4])]
    for number, line in enumerate(lines, start=1):
        for at, letter in enumerate(line):
            if letter != '"' or line[at:] == '"note"':  # a column that nobody asked for may be called note"
                continue
            damaged = [*lines]
            damaged[number - 1] = line[:at] + line[at + 1 :]
            (tmp_path / "log.csv").write_text("\n".join(damaged) + "\n")
            with pytest.raises(InputError, match=rf"line {number}\b|column .* must be in the header"):
                cogging.read_log(tmp_path / "log.csv")
