"""The pages of the papers: every item stands where the page says, is checked as it says, and numbers are today's."""

import re
from pathlib import Path

import pytest

from cogging.papers.reproduction import PAPERS
from tests.fixtures.reproduced import reproduced
from tests.fixtures.shown_commands import missing, shown

ROOT = Path(__file__).parents[2]
HEAD = ["item", "what it says", "where it stands", "how it is checked", "status"]
STATUSES = {"as printed", "mended", "read", "derived", "calibrated", "predicted", "not reproduced", "background"}
#: Numbers of each paper's equations, tables and figures.
EQUATIONS = {
    "lu2008": [str(number) for number in range(1, 31)],
    "malaize2009": [str(number) for number in range(1, 17)],
    "xu2001": [*(str(number) for number in range(1, 59)), *(f"A.{number}" for number in range(1, 9))],
}
TABLES = {"lu2008": ["Table 1", "Table 2"], "malaize2009": ["Table I"], "xu2001": ["Table 1"]}
FIGURES = {"lu2008": range(1, 11), "malaize2009": range(1, 5), "xu2001": range(1, 7)}
NUMBER = r"(?:A\.)?\d+"


def page(paper):
    """Text of a paper's page."""
    return (ROOT / "docs" / "papers" / f"{paper}.md").read_text(encoding="utf-8")


def cells(line):
    """Cells of a line of a table; a bar within backquotes or a formula belongs to its cell."""
    line = re.sub(r"`[^`]*`|\$[^$]*\$", lambda found: found.group().replace("|", "\0"), line.strip().strip("|"))
    return [cell.strip().replace("\0", "|") for cell in re.split(r"(?<!\\)\|", line)]


def items(paper):
    """Rows of the tables of items."""
    lines, found = page(paper).splitlines(), []
    for start, line in enumerate(lines):
        if line.startswith("|") and cells(line) == HEAD:
            for row in lines[start + 2 :]:
                if not row.startswith("|"):
                    break
                found.append(cells(row))
    return found


def numbers(item):
    """Numbers of equations that an item names: (3), (12)-(14), (A.1) to (A.3)."""
    found = []
    for first, last in re.findall(rf"\(({NUMBER})\)(?:\s*(?:-|–|to)\s*\(({NUMBER})\))?", item):
        prefix, begin = ("A.", first[2:]) if first.startswith("A.") else ("", first)
        end = last.removeprefix("A.") or begin
        found += [f"{prefix}{number}" for number in range(int(begin), int(end) + 1)]
    return found


def places(cell):
    """File and symbol of each place in backquotes that looks like a path."""
    for place in re.findall(r"`([^`]+)`", cell):
        path, _, symbol = place.partition("::")
        if "/" in path:
            yield path, symbol


@pytest.mark.parametrize("paper", PAPERS)
def test_every_equation_table_and_figure_is_there(paper):
    rows = items(paper)
    assert len(rows) > 20
    said = [number for item, *_ in rows for number in numbers(item)]
    assert sorted(set(said) - set(EQUATIONS[paper])) == []
    assert [number for number in EQUATIONS[paper] if number not in said] == []
    told = " ".join(item for item, *_ in rows)
    for table in TABLES[paper]:
        assert re.search(rf"\b{table}\b", told), table
    figures = {
        number
        for first, last in re.findall(r"Figs?\. (\d+)(?:\s*(?:-|–|to|and|,)\s*(\d+))?", told)
        for number in range(int(first), int(last or first) + 1)
    }
    assert figures >= set(FIGURES[paper])


@pytest.mark.parametrize("paper", PAPERS)
def test_every_item_stands_and_is_checked_where_the_page_says(paper):
    tables = {table.id for table in reproduced(paper).tables}
    for item, says, where, how, status in items(paper):
        assert says, item
        assert status.startswith(tuple(STATUSES)), (item, status)
        for path, symbol in (*places(where), *places(how)):
            assert (ROOT / path).exists(), (item, path)
            for name in filter(None, symbol.split("::")):
                assert re.search(rf"\b{re.escape(name.split('.')[-1])}\b", (ROOT / path).read_text()), (item, name)
        if status != "background":
            assert [*places(where), *places(how)], (item, "no place")
            named = {word for word in re.findall(r"`([^`/]+)`", how) if word in tables}
            assert named or any(path.startswith("tests/") for path, _ in places(how)), (item, how)


@pytest.mark.parametrize("paper", PAPERS)
def test_the_page_shows_what_reproduce_prints_today(paper):
    blocks = [block for block in shown(ROOT / "docs" / "papers" / f"{paper}.md") if paper in block[0]]
    assert blocks
    for command, said in blocks:
        lines = reproduced(paper).text(every="--all" in command).splitlines()
        assert sum(line != "..." for line in said) >= 6
        gone = missing([*said, "..."], lines)
        assert gone is None, gone


@pytest.mark.parametrize("paper", PAPERS)
def test_every_figure_that_is_named_is_drawn(paper):
    named = set(re.findall(rf"\b({paper}_\w+)(?:\.png)?\b", page(paper)))
    drawn = set(reproduced(paper).figures)
    assert sorted(name for name in named - drawn if not name.endswith("_sweep")) == []
    assert sorted(drawn - named) == []
