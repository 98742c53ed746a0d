"""The pages of the papers say where items stand, how they are checked, and today's numbers; studies are listed."""

import functools
import re
import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

from cogging.papers.reproduction import PAPERS
from tests.fixtures.reproduced import reproduced, table_of
from tests.fixtures.shown_commands import missing, shown

ROOT = Path(__file__).parents[2]
HEAD = ["item", "what it says", "where it stands", "how it is checked", "status"]
STATUSES = ("as printed", "mended", "read", "derived", "calibrated", "predicted", "not reproduced", "background")
EACH_PAPER = pytest.mark.parametrize("paper", PAPERS)


def page(paper):
    return (ROOT / "docs" / "papers" / f"{paper}.md").read_text(encoding="utf-8")


def cells(line):
    """Cells of a line of a table; a bar within backquotes or a formula belongs to its cell."""
    line = re.sub(r"`[^`]*`|\$[^$]*\$", lambda found: found.group().replace("|", "\0"), line.strip().strip("|"))
    return [cell.strip().replace("\0", "|") for cell in re.split(r"(?<!\\)\|", line)]


def items(paper):
    """Rows of the tables of items."""
    tables = re.findall(r"(?:^\|.*\n)+", page(paper), re.MULTILINE)
    rows = [[cells(line) for line in table.splitlines()] for table in tables]
    return [row for head, _, *table in rows if head == HEAD for row in table]


def places(cell):
    """File and symbol of each place in backquotes that looks like a path."""
    for place in re.findall(r"`([^`]+)`", cell):
        path, _, symbol = place.partition("::")
        if "/" in path:
            yield path, symbol


@EACH_PAPER
def test_every_item_stands_and_is_checked_where_the_page_says(paper):
    tables = {table.id for table in reproduced(paper).tables}
    for item, says, where, how, status in items(paper):
        assert says, item
        assert status.startswith(STATUSES), (item, status)
        for path, symbol in (*places(where), *places(how)):
            text = (ROOT / path).read_text()
            for name in filter(None, symbol.split("::")):
                assert re.search(rf"\b{re.escape(name.split('.')[-1])}\b", text), (item, name)
        if status != "background":
            named = {word for word in re.findall(r"`([^`/]+)`", how) if word in tables}
            assert named or any(path.startswith("tests/") for path, _ in places(how)), (item, how)


@EACH_PAPER
def test_the_page_shows_what_reproduce_prints_today(paper):
    blocks = [block for block in shown(ROOT / "docs" / "papers" / f"{paper}.md") if paper in block[0]]
    assert blocks
    for command, said in blocks:
        lines = reproduced(paper).text(every="--all" in command).splitlines()
        assert sum(line != "..." for line in said) >= 6
        gone = missing([*said, "..."], lines)
        assert gone is None, gone


# Quoted numbers -------------------------------------------------------------------------------------------------------
# A comment `<!-- PAPER: TABLE TABLE ...; PAPER: ...; also N N; roughly -->` stands above a paragraph or table and names
# the tables of `cogging reproduce PAPER --all` that print its numbers. `also`: further numbers, such as those of the
# paper; `roughly`: within a half, where a solver's digits differ by machine.

PAGES = [*sorted((ROOT / "docs" / "papers").glob("*.md")), ROOT / "docs" / "evidence.md"]
MARK = re.compile(r"<!-- (\w+: [^>]*) -->\n(.*?)(?:\n\n|$)", re.DOTALL)
LEFT_OUT = re.compile(r"`[^`]*`|\$[^$]*\$|\((?:A\.)?\d+\)|<!--.*?-->")  # in backquotes, formulas, and (28)
FIGURE = re.compile(r"(?<![\w.])[-−]?\d+(?:[.,]\d+)*(?:e[-+]?\d+)?(?!\w)")
SCALES = {"m": (1e6, 1e3, 1e9), "s": (1e3, 1e6, 1.0), "m/s": (1e3,), "Hz": (1e-6, 1.0), "1": (1.0, 100.0)}


def figures_in(text):
    """Each number of a text, its value, and half a unit of its last digit."""
    for found in FIGURE.findall(LEFT_OUT.sub(" ", text)):
        mantissa, _, power = found.replace("−", "-").replace(",", "").partition("e")
        digits = len(mantissa.partition(".")[2])
        yield found, float(mantissa) * 10.0 ** int(power or 0), 0.5 * 10.0 ** (int(power or 0) - digits)


@functools.cache
def printed(paper, name):
    """Every value that a table of a paper prints, in each unit in which a page may say it."""
    table = table_of(paper, name)
    found = [value for _, value, _ in figures_in(table.title)]
    for part in filter(None, (table, table.before)):
        for row in part.rows:
            values = [value for value in (row.simulated, row.paper, row.ratio) if value is not None]
            found += [value * scale for value in values for scale in SCALES.get(row.unit, (1.0,))]
            found += [value for _, value, _ in figures_in(" ".join(row.labels.values()))]
        counts = part.counts()
        found += [*counts.pop("within").values(), *counts.pop("predicted_within").values(), *counts.values()]
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_numbers_of_marked_blocks_are_printed_today(page):
    strangers, blocks = [], MARK.findall(page.read_text(encoding="utf-8"))
    assert blocks
    for mark, block in blocks:
        parts = mark.split("; ")
        values = [float(word) for part in parts if part.startswith("also ") for word in part.split()[1:]]
        for paper, _, names in (part.partition(": ") for part in parts):
            for name in names.split():
                values += printed(paper, name)
        share = 0.5 * ("roughly" in parts)
        for text, value, half in figures_in(block):
            if np.abs(np.abs(values) - abs(value)).min() > max(half, share * abs(value)) * (1 + 1e-6):
                strangers.append((text, mark, block[:60]))
    assert not strangers


# Studies: each is one command that describes itself and is listed in studies/README.md ------------------------------

STUDIES = ROOT / "studies"
NAMES = [
    ".".join(path.relative_to(ROOT).with_suffix("").parts)
    for path in sorted(STUDIES.rglob("*.py"))
    if "sys.exit(run_" in path.read_text(encoding="utf-8") and "diagnosis" not in path.parts
]
assert len(NAMES) >= 11


@pytest.mark.parametrize("name", NAMES)
def test_a_study_describes_itself_and_does_not_start(name, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", [name, "--help"])
    monkeypatch.delitem(sys.modules, name, raising=False)
    with pytest.raises(SystemExit) as end:
        runpy.run_module(name, run_name="__main__", alter_sys=True)
    assert end.value.code == 0
    assert f"usage: python -m {name}" in capsys.readouterr().out
    assert f"`python -m {name}" in (STUDIES / "README.md").read_text(encoding="utf-8")
