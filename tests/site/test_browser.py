"""The built site in a real browser: on a phone, a tablet and two desks, in light and in dark."""

import runpy
from pathlib import Path

import pytest

from tests.fixtures.browser import MISSING_PICTURES, WIDTHS, Seen

pytestmark = pytest.mark.pages

#: Of each kind one: all of them are a longer study.
SOME = ("index.html", "start.html", "glossary.html", "_generated/effects/backlash.html", "explanation/01_axis.html")


def faults_of(path, browser):
    """What is wrong with a page, by what was looked for."""
    with Seen(browser, path) as seen:
        page, found = seen.page, {}
        if formulas := page.evaluate("() => document.querySelectorAll('.math').length"):
            page.wait_for_function("() => window.MathJax?.startup?.promise !== undefined")
            page.evaluate("() => MathJax.startup.promise")
            set_ = page.evaluate("() => document.querySelectorAll('.math mjx-container svg').length")
            bad = page.evaluate("() => document.querySelectorAll('[data-mjx-error], mjx-merror').length")
            found["formulas"] = (formulas, set_, bad) if set_ < formulas or bad else ()
        for width in (*WIDTHS, 1400):  # the last shows the page's own contents beside it
            found[f"too wide in {width}"] = seen.too_wide(width)
        for scheme in ("light", "dark"):
            found[f"faint in {scheme}"] = seen.faint_text(scheme)
            found[f"missing in {scheme}"] = page.evaluate(MISSING_PICTURES)
        found |= {"errors": seen.complaints, "fetched from elsewhere": seen.outside()}
    return {what: where for what, where in found.items() if where}


@pytest.mark.parametrize("every", [False, pytest.param(True, marks=pytest.mark.study)], ids=["some", "every page"])
def test_nothing_is_wrong_with_a_page(every, site, paths, browser):
    """Nothing runs off it, all pictures are there, text stands out, formulas are set; nothing fails or is fetched."""
    looked_at = paths if every else [site / name for name in SOME]
    assert {path.name: faults for path in looked_at if (faults := faults_of(path, browser))} == {}


def test_the_sidebar_leads_to_another_version(site, browser, tmp_path):
    """From a folder, without a server."""
    publish = runpy.run_path(str(Path(__file__).parents[2] / "docs" / "publish.py"))["publish"]
    for name in ("latest", "v0.1.0"):
        publish(site, tmp_path, name)
    page = browser.new_page()
    page.goto((tmp_path / "latest" / "_generated" / "effects" / "backlash.html").as_uri())
    assert page.locator(".versions option").all_inner_texts()[1:] == ["v0.1.0"]
    page.select_option(".versions select", label="v0.1.0")
    page.wait_for_url((tmp_path / "v0.1.0" / "index.html").as_uri())
    page.close()
