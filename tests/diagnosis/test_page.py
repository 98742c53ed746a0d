"""The report and its figures."""

import html.parser
import re
from dataclasses import replace

import jinja2
import numpy as np
import pytest
from markupsafe import Markup, escape

from cogging.diagnosis.report.pictures import COLOURS, in_schemes, pictures_of, spectrum
from cogging.plot.gaps import Rows, binned
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
        "standard deviations above the noise",
        "How sure",
        "The model before and after",
        "Gap against each coordinate",
        "Tested effects",
        "effects.viscous_asymmetry.difference",
        "How to read this page",
    ):
        assert words in page, words
    assert found.location.lines()
    assert all(str(escape(line)) in page for line in found.location.lines())
    assert len(found.plot().axes) == 4


def test_a_shape_of_its_own_stands_on_page_and_screen(found):
    curve = {"coordinate": "position", "places": [0.0, 0.01, 0.5], "force": [0.2, 0.1, -0.3]}
    told = replace(found, effects=(replace(found.effects[0], shape="other", curve=curve),))
    page, text = told.html(), told.text(verbose=True)
    words = "the force deviates from the standard law, with a peak of -0.3 V near position 0.5 m"
    assert words in page
    assert words in text
    assert "viscous asymmetry with a non-standard law" in page
    assert words not in found.text(verbose=True)
    assert page.count("<svg") == found.html().count("<svg") + 1
    assert told.to_dict()["effects"][0]["shape"] == "other"
    without = replace(told.effects[0], curve=None, in_model=False)
    assert "it is not in the model" in replace(told, effects=(without,)).text(verbose=True)


def test_the_first_screen_shows_the_gap_along_the_coordinate_of_the_effect():
    result = drawn_result(np.random.default_rng(1), "named", count=1)
    (effect,) = result.effects
    along = replace(result, effects=(replace(effect, where={"coordinate": "velocity", "range": None}),))
    first, over_time = pictures_of(along)["first"]
    assert "against velocity" in first.finding
    assert "over time" in over_time.finding
    assert not any("against velocity" in one.finding for one in pictures_of(along)["coordinates"])


def test_bands_hold_the_truth_and_the_spectrum_its_scale():
    rng = np.random.default_rng(0)
    inside = []
    for _ in range(200):
        block = np.repeat(np.arange(60), 50)
        gap = 0.3 + np.repeat(rng.normal(0.0, 1.0, 60), 50) + rng.normal(0.0, 0.1, 3000)
        _, mean, half = binned(Rows(gap, {"place": rng.uniform(0.0, 1.0, 3000)}, block), "place")
        inside.append(np.abs(mean - 0.3) < half)
    assert 0.9 < np.mean(inside) < 0.98  # rows of a block say the same; bands of single rows would hold 25 %
    frequency, density = spectrum(np.arange(20000) / 1000.0, rng.normal(0.0, 2.0, 20000))
    assert frequency[-1] == pytest.approx(500.0, rel=1e-2)
    assert np.sqrt(np.mean(density**2)) == pytest.approx(2.0 / np.sqrt(500.0), rel=0.05)


def test_every_colour_of_a_figure_is_one_of_the_page_in_light_and_dark():
    pictures = pictures_of(drawn_result(np.random.default_rng(1), "ambiguous"))
    drawn = "".join(one.svg for part in pictures.values() for one in part)
    assert set(re.findall(r"#[0-9a-f]{6}", drawn)) == set()
    used = set(re.findall(r"var\((--\w+)\)", drawn))
    assert {"--first", "--second", "--soft"} <= used <= set(COLOURS.values())
    light, dark = in_schemes(drawn).values()
    assert "var(" not in light + dark
    assert light.count("#0072b2") == dark.count("#56b4e9") > 0


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
