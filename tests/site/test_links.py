"""Every link and picture of the built site leads to something that it holds; nothing is fetched from elsewhere."""

import re
from html.parser import HTMLParser
from urllib.parse import unquote, urldefrag

import pytest

pytestmark = pytest.mark.pages


class Page(HTMLParser):
    """What a page refers to, and what can be referred to in it."""

    def __init__(self, text):
        super().__init__()
        self.links, self.loaded, self.places, self.headings, self.unnamed = [], [], set(), 0, []
        self.title = re.search(r"<title>(.*?)</title>", text, re.DOTALL)
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        known = dict(attributes)
        self.places |= {known[name] for name in ("id", "name") if known.get(name)}
        self.headings += tag == "h1"
        if tag == "a" and known.get("href"):
            self.links.append(known["href"])
        if tag in ("img", "script", "source") and known.get("src"):
            self.loaded.append(known["src"])
        text = (known.get("alt") or "").strip()
        if tag == "img" and (len(text) < 10 or text.endswith((".png", ".svg"))):
            self.unnamed.append(known.get("src"))
        if tag == "link" and known.get("rel") in ("stylesheet", "icon", "preload"):
            self.loaded.append(known["href"])


@pytest.fixture(scope="module")
def pages(site):
    """Every page by its path."""
    found = {path: Page(path.read_text(encoding="utf-8")) for path in sorted(site.rglob("*.html"))}
    assert len(found) > 50
    return {path: page for path, page in found.items() if path.name not in ("search.html", "genindex.html")}


def target_of(path, link):
    """The file and the place in it that a link of a page leads to; None of one that leads out of the site."""
    if re.match(r"[a-z]+:", link):
        return None
    address, place = urldefrag(link)
    file = (path.parent / unquote(address.partition("?")[0])).resolve() if address else path
    return (file / "index.html" if file.is_dir() else file), unquote(place)


def test_links_lead_somewhere(pages, site):
    broken = []
    for path, page in pages.items():
        for link in page.links:
            target = target_of(path, link)
            if target is None:
                continue
            file, place = target
            known = pages.get(file)
            if not file.is_relative_to(site) or not file.exists() or (place and known and place not in known.places):
                broken.append((str(path.relative_to(site)), link))
    assert not broken


def test_what_a_page_loads_is_in_the_site(pages, site):
    """Pictures, scripts and style: none is missing, none comes from another host."""
    for path, page in pages.items():
        for link in page.loaded:
            if link.startswith("data:"):
                continue
            target = target_of(path, link)
            assert target is not None, (path, link)
            assert target[0].is_file(), (path, link)
    for style in site.rglob("*.css"):
        assert not re.search(r"url\(\s*['\"]?(https?:)?//", style.read_text(encoding="utf-8")), style
