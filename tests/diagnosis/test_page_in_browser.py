"""The report in a real browser: on a phone, a tablet and a desk, light and dark, on paper, from drawn results."""

import itertools
import re

import numpy as np
import pytest

from tests.fixtures.browser import MISSING_PICTURES, UNREACHABLE, WIDTHS, Seen
from tests.fixtures.drawn_results import drawn_result

pytestmark = pytest.mark.pages
#: Verdicts and seeds, so that lists of values, names of 240 letters, other shapes and no effect at all are among them.
CASES = [("named", 5), ("ambiguous", 1), ("unlisted", 3), ("data_mismatch", 4)]
TITLE = "axis_of_the_third_machine_in_hall_2_measured_on_monday_before_the_rail_was_cleaned.csv, b.csv"


@pytest.fixture(scope="module", params=CASES, ids=lambda case: f"{case[0]}-{case[1]}")
def report(request, tmp_path_factory, browser):
    """A drawn result and its page, every section unfolded."""
    verdict, seed = request.param
    result = drawn_result(np.random.default_rng(seed), verdict)
    path = tmp_path_factory.mktemp("report") / "report.html"
    result.report(path, title=TITLE)
    with Seen(browser, path) as seen:
        seen.folded = seen.page.evaluate("document.documentElement.scrollHeight")
        seen.page.evaluate("document.querySelectorAll('details').forEach(section => section.open = true)")
        yield result, seen


def test_nothing_sticks_out_and_all_can_be_read(report):
    """At every width, in both schemes; boxes that scroll are reached by the keyboard; nothing is asked of the net."""
    _, seen = report
    for width in WIDTHS:
        assert (seen.too_wide(width), seen.page.evaluate(UNREACHABLE)) == ([], [])
    for scheme in ("dark", "light"):
        assert seen.faint_text(scheme) == []
        ground = seen.page.evaluate("getComputedStyle(document.body).backgroundColor")
        assert (sum(map(int, re.findall(r"\d+", ground))) > 380) is (scheme == "light")
    assert seen.complaints == []
    assert seen.outside() == []


def test_one_headline_and_pictures_that_say_what_they_show(report):
    result, seen = report
    assert seen.page.locator("h1").count() == 1
    told = seen.page.evaluate(
        "[...document.querySelectorAll('figure')].map(f => [f.ariaLabel, f.querySelector('svg').clientWidth])"
    )
    assert bool(told) is ("gap_before" in result.series)
    assert all(label.endswith(".") and len(label.split()) > 3 and width > 300 for label, width in told)
    levels = seen.page.evaluate("[...document.querySelectorAll('h1, h2, h3')].map(h => Number(h.tagName[1]))")
    assert all(after - before <= 1 for before, after in itertools.pairwise(levels))


def test_the_first_screen_has_verdict_next_step_model_and_gap(report):
    result, seen = report
    measured = "gap_before" in result.series
    assert seen.folded <= 3000
    for width, height, shown in ((1280, 900, [".next", "table", "figure"]), (390, 844, [".next"])):
        seen.page.set_viewport_size({"width": width, "height": height})
        for what in shown if measured else [".next"]:
            assert seen.page.locator(what).first.bounding_box()["y"] < height, what


def test_figures_and_bars_stack_on_a_phone(report):
    result, seen = report
    for width, columns in ((1280, 2), (390, 1)):
        seen.page.set_viewport_size({"width": width, "height": 900})
        places = seen.page.evaluate(
            "[...document.querySelectorAll('.columns > *')].map(i => Math.round(i.getBoundingClientRect().left))"
        )
        assert len(set(places)) == (columns if "gap_before" in result.series else 0)
    least = seen.page.evaluate("Math.min(...[...document.querySelectorAll('.bar')].map(b => b.clientWidth))")
    assert least is None or least > 200  # JSON has no infinity: no bar


def test_a_table_that_scrolls_has_a_shadow_where_it_is_cut(report):
    result, seen = report
    seen.page.set_viewport_size({"width": 390, "height": 844})
    cut = seen.page.evaluate(
        "[...document.querySelectorAll('.scroll')].filter(t => t.scrollWidth > t.clientWidth)"
        ".map(t => getComputedStyle(t).backgroundImage)"
    )
    assert cut or "gap_before" not in result.series
    assert all(shadow.count("linear-gradient") == 4 for shadow in cut)


def test_the_print_loses_no_column(report, tmp_path):
    """The words of the last column of every table are in the PDF, whatever line ends the paper put into them."""
    result, seen = report
    last = seen.page.evaluate(
        "[...document.querySelectorAll('tr')].map(r => r.lastElementChild.textContent.trim()).filter(t => t)"
    )
    seen.page.evaluate("document.querySelectorAll('details').forEach(section => section.open = false)")
    pages, words = seen.printed(tmp_path)
    assert pages > 0
    letters = re.sub(r"\s", "", words)
    assert len(last) > 3
    assert [text for text in last if not all(word in letters for word in text.split())] == []
    assert seen.page.locator("h1").inner_text().split()[0] in words
    assert result.verdict.replace("_", " ") in words


@pytest.mark.parametrize("tag", ["main", "article"])
def test_what_is_wrong_with_a_page_is_seen(tag, browser, tmp_path):
    """On a report and on a page of the site: what the tests ask for can fail."""
    path = tmp_path / "bad.html"
    wide = '<div style="overflow-x: auto"><p style="white-space: nowrap">' + "wide " * 99 + "</p></div>"
    path.write_text(
        f'<body style="background: #fff"><{tag}>{wide}<h1 style="color: #888">large</h1><p>dark</p>'
        '<p style="color: #999">faint</p><div style="width: 2000px">out</div>'
        f'<script>nothing()</script><img src="http://127.0.0.1:9/x.png"></{tag}>'
    )
    with Seen(browser, path) as seen:
        scrolls, cut = seen.too_wide(390)
        assert (scrolls[:6], cut) == ("page: ", "DIV: out")
        assert [text for _, text, _ in seen.faint_text("light")] == ["faint"]
        (box,) = seen.page.evaluate(UNREACHABLE)
        assert "overflow-x" in box
        assert seen.page.evaluate(MISSING_PICTURES) == seen.outside() == ["http://127.0.0.1:9/x.png"]
        assert len(seen.complaints) >= 2
