"""The built site in a real browser: on a phone, a tablet and two desks, in light and in dark."""

import runpy
from pathlib import Path

import pytest

pytestmark = pytest.mark.pages
WIDTHS = (390, 768, 1280, 1400)  # the last shows the page's own contents beside it
SCHEMES = ("light", "dark")
ENOUGH, ENOUGH_LARGE = 4.5, 3.0  # contrast of text, of large text: WCAG 2.2, 1.4.3

#: Gives what runs off the page on its right.
TOO_WIDE = (Path(__file__).parent / "too_wide.js").read_text(encoding="utf-8")
MISSING = """() => [...document.images].filter(one => one.complete && one.naturalWidth === 0).map(one => one.src)"""

#: Gives the text whose contrast with what lies behind it is too low: [kind, text, contrast].
FAINT = (Path(__file__).parent / "faint_text.js").read_text(encoding="utf-8")


#: Of each kind one: all of them are a longer study.
SOME = ("index.html", "start.html", "glossary.html", "_generated/effects/backlash.html", "explanation/01_axis.html")


def looked_at(paths, browser):
    """What is wrong with each page, by what was looked for. Each is opened once."""
    found = {"too wide": [], "missing": [], "faint": [], "errors": [], "formulas": []}
    context = browser.new_context(viewport={"width": WIDTHS[0], "height": 900})
    page = context.new_page()
    page.on("pageerror", lambda error: found["errors"].append((page.url, str(error))))
    page.on("console", lambda said: found["errors"].append((page.url, said.text)) if said.type == "error" else None)
    page.on("requestfailed", lambda request: found["errors"].append((page.url, request.url)))
    outside = []
    page.on("request", lambda request: outside.append(request.url))
    for path in paths:
        page.goto(path.as_uri())
        formulas = page.evaluate("() => document.querySelectorAll('.math').length")
        if formulas:
            page.wait_for_function("() => window.MathJax?.startup?.promise !== undefined")
            page.evaluate("() => MathJax.startup.promise")
            set_ = page.evaluate("() => document.querySelectorAll('.math mjx-container svg').length")
            bad = page.evaluate("() => document.querySelectorAll('[data-mjx-error], mjx-merror').length")
            if set_ < formulas or bad:
                found["formulas"].append((path.name, formulas, set_, bad))
        for width in WIDTHS:
            page.set_viewport_size({"width": width, "height": 900})
            found["too wide"] += [(path.name, width, one) for one in page.evaluate(TOO_WIDE)]
        for scheme in SCHEMES:
            page.emulate_media(color_scheme=scheme)
            found["faint"] += [(path.name, scheme, *one) for one in page.evaluate(FAINT, [ENOUGH, ENOUGH_LARGE])]
            found["missing"] += [(path.name, scheme, one) for one in page.evaluate(MISSING)]
    context.close()
    outside = [address for address in outside if not address.startswith(("file:", "data:"))]
    return {**found, "fetched from elsewhere": outside}


@pytest.mark.parametrize("every", [False, pytest.param(True, marks=pytest.mark.study)], ids=["some", "every page"])
def test_nothing_is_wrong_with_a_page(every, site, browser):
    """Nothing runs off it, all pictures are there, text stands out, formulas are set; nothing fails or is fetched."""
    if every:
        paths = sorted(path for path in site.rglob("*.html") if path.name not in ("search.html", "genindex.html"))
        assert len(paths) > 50
    else:
        paths = [site / name for name in SOME]
    found = looked_at(paths, browser)
    assert {what: where for what, where in found.items() if where} == {}


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


def test_the_checks_see_what_is_wrong(browser):
    """A page with a wide box, faint text and a missing picture fails each check."""
    page = browser.new_page(viewport={"width": 390, "height": 600})
    page.set_content(
        "<p style='color:#999;background:#fff'>faint</p><p style='color:#000'>dark</p><h1 style='color:#888'>large</h1>"
        "<div style='width:800px'>wide</div><img src='data:image/png;base64,AAAA'>"
    )
    page.wait_for_function("() => document.images[0].complete")
    scrolls, cut = page.evaluate(TOO_WIDE)
    assert scrolls.startswith("page: ")
    assert cut == "DIV: wide"
    assert len(page.evaluate(MISSING)) == 1
    assert [one[1] for one in page.evaluate(FAINT, [ENOUGH, ENOUGH_LARGE])] == ["faint"]
    page.close()
