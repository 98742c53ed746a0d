"""Every link of the built site leads to something that it holds; what its pages load: test_browser.py."""

import re
from html.parser import HTMLParser
from urllib.parse import unquote, urldefrag

import pytest

pytestmark = pytest.mark.pages


class Page(HTMLParser):
    """What a page links to, and what can be linked to in it."""

    def __init__(self, text):
        super().__init__()
        self.links, self.places = [], set()
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        known = dict(attributes)
        self.places |= {known[name] for name in ("id", "name") if known.get(name)}
        if tag == "a" and known.get("href"):
            self.links.append(known["href"])


def target_of(path, link):
    """The file and the place in it that a link of a page leads to; None of one that leads out of the site."""
    if re.match(r"[a-z]+:", link):
        return None
    address, place = urldefrag(link)
    file = (path.parent / unquote(address.partition("?")[0])).resolve() if address else path
    return (file / "index.html" if file.is_dir() else file), unquote(place)


def test_links_lead_somewhere(paths, site):
    pages, broken = {path: Page(path.read_text(encoding="utf-8")) for path in paths}, []
    for path, link in ((path, link) for path, page in pages.items() for link in page.links):
        if (target := target_of(path, link)) is not None:
            file, place = target
            known = pages.get(file)
            if not file.is_relative_to(site) or not file.exists() or (place and known and place not in known.places):
                broken.append((str(path.relative_to(site)), link))
    assert not broken
