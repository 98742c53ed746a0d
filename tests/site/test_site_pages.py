"""What the site takes from elsewhere in the repository: links that fit both, notebooks with and without outputs."""

import base64
import io
import json
import re
import runpy

import api_pages
import notebook_pages
import numpy as np
import pytest
from PIL import Image
from site_pages import DOCS, ROOT, STANDS_FOR, repaired

import cogging


@pytest.mark.parametrize("shown", ["tune.md", "explanation/01_axis.md", "_generated/effects/backlash.md"])
def test_a_link_leads_to_the_page_that_stands_for_a_file(shown):
    """From any page of any depth, with and without a place in the target."""
    at = DOCS / shown
    up = "../" * len(at.parent.relative_to(ROOT).parts)
    for target, page in STANDS_FOR.items():
        for end in ("", "#somewhere"):
            made = repaired(f"see [it]({up}{target}{end}), said", at, at)
            link = re.fullmatch(rf"see \[it\]\((.*?){end}\), said", made)[1]
            assert (at.parent / link).resolve() == DOCS / page


def test_other_links_stay_or_become_words():
    at = DOCS / "cpp.md"
    for text in ("[a](https://a.org/b)", "[a](speed.md)", "[a](#place)", "![a](growth.svg)", "[a](none.md)", "plain"):
        assert repaired(text, at, at) == text
    assert repaired("[the examples](../examples/cpp)", at, at) == "the examples (`examples/cpp`)"
    moved = repaired("[own](docs/own_effect.md)", ROOT / "CONTRIBUTING.md", DOCS / "_generated" / "contributing.md")
    assert moved == "[own](../own_effect.md)"
    assert repaired("[law](../pyproject.toml)", at, at) == "[law](../pyproject.toml)"


def notebook(outputs):
    """A notebook with a heading, a text and one cell with such outputs."""
    first = ["# Of *et al.* and more\n", "\n", "Lu et al. 2008 say so. It is short. "]
    first += ["Then comes what is long enough to stop.\n", "\n", "Another paragraph."]
    told = {"cell_type": "markdown", "source": first}
    return {"cells": [told, {"cell_type": "code", "source": [], "outputs": outputs}]}


@pytest.mark.parametrize("lines", [1, 3])
def test_a_card_has_heading_sentences_and_the_first_picture(lines, tmp_path):
    made = io.BytesIO()
    Image.fromarray(np.random.default_rng(1).integers(0, 255, (300, 900, 3), dtype=np.uint8)).save(made, "PNG")
    code = base64.b64encode(made.getvalue()).decode()
    parts = [code[i : i + len(code) // lines + 1] for i in range(0, len(code), len(code) // lines + 1)]
    shown = [{"data": {"text/plain": "x"}}, {"text": "said"}, {"data": {"image/png": parts}}]
    for name, outputs in (("with", shown), ("without", shown[:2])):
        (tmp_path / f"{name}.ipynb").write_text(json.dumps(notebook(outputs)))
    notebook_pages.write(tmp_path, tmp_path / "out")
    cards = (tmp_path / "out" / "cards.md").read_text()
    assert cards.count("{grid-item-card} Of *et al.* and more\n") == 2
    assert cards.count("Lu et al. 2008 say so. It is short. Then") == 2
    assert "Another" not in cards
    assert cards.count("{image}") == 1
    with Image.open(tmp_path / "out" / "with.png") as small:
        assert small.width == notebook_pages.WIDTH


def test_every_published_version_lists_all_and_the_front_page_leads_to_the_newest_release(tmp_path):
    publish = runpy.run_path(str(DOCS / "publish.py"))["publish"]
    built, published = tmp_path / "built", tmp_path / "published"
    (built / "_static").mkdir(parents=True)
    (built / "_static" / "versions.js").write_text((DOCS / "_static" / "versions.js").read_text())
    for name in ("latest", "v0.9.0", "v0.10.0", "latest"):
        (built / "index.html").write_text(name)
        publish(built, published, name)
        assert (published / name / "index.html").read_text() == name
    for name in ("latest", "v0.9.0", "v0.10.0"):
        listed = (published / name / "_static" / "versions.js").read_text()
        assert listed == 'const VERSIONS = ["v0.10.0", "v0.9.0", "latest"];\n'
    assert "url=v0.10.0/index.html" in (published / "index.html").read_text()


def test_every_public_name_has_one_room():
    names = [name for named in api_pages.rooms().values() for name in named]
    assert sorted(names) == sorted(cogging.__all__)
