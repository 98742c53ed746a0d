"""The glossary names places in the code that are there, and gives each term once."""

import importlib
import re
from pathlib import Path

GLOSSARY = (Path(__file__).parents[1] / "docs/glossary.md").read_text(encoding="utf-8")
ROWS = [line.strip("|").split("|") for line in GLOSSARY.splitlines() if line.startswith("| ") and "---" not in line]
TERMS = [row for row in ROWS if row[0].strip() != "term"]


def found(place):
    """The module, or what stands in one, of a dotted name."""
    parts = place.split(".")
    for length in range(len(parts), 0, -1):
        try:
            thing = importlib.import_module(".".join(parts[:length]))
        except ModuleNotFoundError:
            continue
        for name in parts[length:]:
            thing = getattr(thing, name)
        return thing
    raise AssertionError(place)


def test_each_term_has_its_place():
    assert len(TERMS) > 30
    for row in TERMS:
        assert len(row) == 4, row
        places = re.findall(r"`(cogging[\w.]*)`", row[2])
        assert places, row
        assert all(found(place) is not None for place in places)


def test_each_term_is_given_once():
    terms = [row[0].strip() for row in TERMS]
    assert len(set(terms)) == len(terms)


def test_each_source_that_is_cited_is_listed():
    cited = re.findall(r"([A-Z][\wü]+)(?: and [A-Z]\w+)? (\d{4})", " ".join(row[3] for row in TERMS))
    assert len(cited) > 8
    listed = GLOSSARY.split("## Sources")[1]
    for name, year in cited:
        assert re.search(rf"{name}[^\n]*(\n  [^\n]*)?{year}", listed), (name, year)
