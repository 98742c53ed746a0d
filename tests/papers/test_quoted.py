"""Numbers that docs/papers and docs/evidence.md quote are those that the commands print today.

A comment `<!-- PAPER: TABLE TABLE ...; PAPER: ...; also N N; roughly -->` stands above a paragraph or table and names
the tables of `cogging reproduce PAPER --all` that print its numbers. `also`: further numbers, such as those of the
paper; `roughly`: within a half, where a solver's digits differ by machine.
"""

import functools
import re
from pathlib import Path

import numpy as np
import pytest

from tests.fixtures.reproduced import reproduced

ROOT = Path(__file__).parents[2]
PAGES = [*sorted((ROOT / "docs" / "papers").glob("*.md")), ROOT / "docs" / "evidence.md"]
MARK = re.compile(r"<!-- (\w+: [^>]*) -->\n(.*?)(?:\n\n|$)", re.DOTALL)
LEFT_OUT = re.compile(r"`[^`]*`|\$[^$]*\$|\((?:A\.)?\d+\)|<!--.*?-->")  # in backquotes, formulas, and (28)
NUMBER = re.compile(r"(?<![\w.])[-−]?\d+(?:[.,]\d+)*(?:e[-+]?\d+)?(?!\w)")
SCALES = {"m": (1e6, 1e3, 1e9), "s": (1e3, 1e6, 1.0), "m/s": (1e3,), "Hz": (1e-6, 1.0), "1": (1.0, 100.0)}


def numbers(text):
    """Each number of a text as it stands, its value, and half a unit of its last digit."""
    for found in NUMBER.findall(LEFT_OUT.sub(" ", text)):
        mantissa, _, power = found.replace("−", "-").replace(",", "").partition("e")
        digits = len(mantissa.partition(".")[2])
        yield found, float(mantissa) * 10.0 ** int(power or 0), 0.5 * 10.0 ** (int(power or 0) - digits)


@functools.cache
def printed(paper, name):
    """Every value that a table of a paper prints, in each unit in which a page may say it."""
    table = next(table for table in reproduced(paper).tables if table.id == name)
    found = [value for _, value, _ in numbers(table.title)]
    for part in filter(None, (table, table.before)):
        for row in part.rows:
            values = [row.simulated, *((row.paper, row.simulated / row.paper) if row.paper else ())]
            found += [value * scale for value in values for scale in SCALES.get(row.unit, (1.0,))]
            found += [value for _, value, _ in numbers(" ".join(row.labels.values()))]
        counts = part.counts()
        found += [*counts.within, *counts.predicted_within, counts.numbers, counts.calibrated, counts.predicted]
        found += [counts.free]
    return found


def quoted(page):
    """The marked blocks of a page: names of tables by paper, further numbers, relative tolerance, the block."""
    for mark, block in MARK.findall(page.read_text(encoding="utf-8")):
        parts = mark.split("; ")
        tables = [
            (paper, name) for paper, _, names in (part.partition(": ") for part in parts) for name in names.split()
        ]
        also = [float(word) for part in parts if part.startswith("also ") for word in part.split()[1:]]
        yield tables, also, 0.5 * ("roughly" in parts), block


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_numbers_of_marked_blocks_are_printed_today(page):
    strangers, blocks = [], list(quoted(page))
    assert blocks
    for tables, also, share, block in blocks:
        values = np.abs(np.array([*(value for place in tables for value in printed(*place)), *also]))
        for text, value, half in numbers(block):
            if np.abs(values - abs(value)).min() > max(half, share * abs(value)) * (1 + 1e-6):
                strangers.append((text, tables, block[:60]))
    assert not strangers


def test_a_number_that_no_command_prints_is_found():
    assert [value for _, value, _ in numbers("8.1 of 1,700 at 1e15, not `3` nor $4$ nor (5) nor x6")] == [
        8.1,
        1700,
        1e15,
    ]
    assert np.abs(np.array(printed("xu2001", "table1")) - 155.0).min() > 0.5  # µm: the paper says 156
