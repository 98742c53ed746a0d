"""The report."""

import html.parser
from dataclasses import replace

import jinja2
import numpy as np
import pytest
from markupsafe import Markup, escape

from cogging.diagnosis.entries import NearRest, ShapeTerm
from cogging.diagnosis.report.pictures import pictures_of
from tests.fixtures.drawn_results import drawn_result


def test_a_report_without_its_library_says_what_to_install(found, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "jinja2", None)
    with pytest.raises(ValueError, match=r"a report needs jinja2: pip install 'cogging\[report\]'"):
        found.html()


def test_the_report_says_what_why_and_what_next(found):
    page = found.html(title="log <1>")
    assert "log &lt;1&gt;" in page
    for words in (
        "viscous asymmetry",
        "standard deviations out of the noise",
        "Check on other motion",
        "Before and after",
        "Everything that was tried in earnest",
        "effects.viscous_asymmetry.difference",
        "How to read this page",
    ):
        assert words in page, words
    assert found.location.lines()
    assert all(str(escape(line)) in page for line in found.location.lines())
    assert len(found.plot().axes) == 4


def test_a_shape_of_its_own_and_friction_near_rest_stand_on_page_and_screen(found):
    term = ShapeTerm(
        "position near the ends",
        "m",
        [0.0, 0.01, 0.5, 0.49],
        [0.2, 0.1, -0.3, -0.1],
        [0.01, 0.02, 0.03, np.inf],
        812.0,
        0.3,
        {"coordinate": "position", "places": [0.0, 0.01], "force": [0.2, 0.1]},
    )
    friction = NearRest(93.0, 6, -40.0, -20.0, ("presliding_friction", "stribeck_friction"), "creep at five speeds")
    told = replace(found, effects=(replace(found.effects[0], shape_term=term),), near_rest=friction)
    page, text = told.html(), told.text(verbose=True)
    for words in (
        "viscous asymmetry of a shape of its own",
        "of another shape than its plainest law, T = 812 in position near the ends: +0.2 more about 0 m",
        "What viscous asymmetry has beside its plainest law",
        "Friction near rest",
        "this motion cannot tell which law it follows",
        "presliding friction or stribeck friction",
        "To tell the friction near rest: creep at five speeds.",
    ):
        assert words in page, words
    assert page.count("data:image/png") == found.html().count("data:image/png") + 1
    for words in ("of another shape than its plainest law, T = 812", "near rest the friction is not the model's"):
        assert words in text, words
        assert words not in found.text(verbose=True)
    assert "Friction near rest" not in found.html()


def test_a_way_that_the_axis_did_not_move_has_no_empty_picture():
    """Of an axis that only moved forward: neither a profile nor a folded period backward."""
    result = drawn_result(np.random.default_rng(1), "ambiguous")
    one_way = [np.asarray(result.series["velocity"][0]) > 0.01]
    pictures = pictures_of(replace(result, series={**result.series, "mask": one_way}))
    both = pictures_of(result)
    for part, lost in (("coordinates", 1), ("folded", 1), ("time", 0)):
        assert len(pictures[part]) == len(both[part]) - lost
    assert not any("backward" in one.finding for part in pictures.values() for one in part if "Gap" in one.finding)


HOSTILE = '"><script>alert(1)</script><img src=x onerror=y>&'


class Elements(html.parser.HTMLParser):
    """The elements of a page with the names of their attributes, and all that is text or value."""

    def __init__(self, page):
        super().__init__()
        self.elements, self.texts = [], []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, *(name for name, _ in attrs)))
        self.texts += [value for _, value in attrs if value]

    def handle_data(self, data):
        self.texts.append(data)


@pytest.fixture(scope="module")
def pictures(found):
    return pictures_of(found)


@pytest.mark.parametrize("verdict", ["named", "ambiguous", "unlisted", "data_mismatch", "controller_mismatch"])
def test_every_place_of_the_page_escapes_what_is_put_there(verdict, found, pictures, monkeypatch):
    """Hostile letters behind whatever the template writes, text by text: the page has the same elements as without."""
    monkeypatch.setattr("cogging.diagnosis.report.page.pictures_of", lambda result: pictures)
    result = found if verdict == "named" else drawn_result(np.random.default_rng(2), verdict)
    plain = Elements(result.html(title="a log"))
    made = jinja2.Environment

    def hostile(autoescape, **options):
        return made(autoescape=safe and autoescape, finalize=put, **options)

    def put(value):
        return value if isinstance(value, Markup) or not isinstance(value, str) else value + HOSTILE

    monkeypatch.setattr(jinja2, "Environment", hostile)
    safe = True
    page = Elements(result.html(title="a log"))
    assert page.elements == plain.elements
    assert sum(HOSTILE in text for text in page.texts) > 20
    safe = False  # what the test would see
    assert ("script",) in Elements(result.html(title="a log")).elements
