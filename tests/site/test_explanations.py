"""The pages that explain the equations name places in the code that are there, and where each equation comes from."""

import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "docs" / "explanation").glob("*.md"))


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


def test_each_family_has_its_page():
    assert len(PAGES) >= 9


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_the_code_that_a_page_names_is_there(path):
    text = path.read_text(encoding="utf-8")
    python = re.findall(r"`(cogging\.[\w.]+)`", text)
    assert python
    for place in python:
        assert found(place) is not None, place
    for name in re.findall(r"`(cpp/[\w./]+)`", text):
        assert (ROOT / name).exists(), name
    for name, file in re.findall(r"`([\w:]+)`\s+in\s+`(cpp/[\w./]+)`", text):
        kind, _, member = name.rpartition("::")
        code = (ROOT / file).read_text(encoding="utf-8")
        assert re.search(rf"\b{member}\b", code), name
        assert not kind or re.search(rf"\b(class|struct) {kind}\b", code), name


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_a_page_has_formulas_and_their_source(path):
    text = path.read_text(encoding="utf-8")
    assert text.startswith("# ")
    assert text.count("\n$$\n") >= 2
    assert re.search(r"^Sources: |equation \d|^Gains for", text, re.MULTILINE)
    assert "cpp/" in text or "`cogging." in text
