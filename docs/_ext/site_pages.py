"""What the site takes from elsewhere in the repository: effects, notebooks, root documents, the script of formulas."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
from pathlib import Path
from typing import Any

import effect_pages
import notebook_pages
from api_pages import escaped, put, write_api

DOCS = Path(__file__).parents[1]
ROOT = DOCS.parent
GENERATED = DOCS / "_generated"
#: Pages of the site that stand for files and folders of the repository outside `docs`.
STANDS_FOR = {
    "CONTRIBUTING.md": "_generated/contributing.md",
    "CHANGELOG.md": "_generated/changelog.md",
    "SECURITY.md": "_generated/security.md",
    "THIRD_PARTY.md": "_generated/third_party.md",
    "README.md": "index.md",
    "notebooks": "gallery.md",
    "python/cogging/datasets": "_generated/api/datasets.md",
}
LINK = re.compile(r"(!?\[[^\]]*\]\()([^)\s#]+)((?:#[^)\s]*)?\))")


def setup(app: Any) -> dict[str, Any]:
    """Connect the extension to Sphinx."""
    app.connect("builder-inited", generate)
    app.connect("source-read", repair_links)
    app.connect("autodoc-process-docstring", escaped, priority=400)  # before napoleon makes mark-up
    app.connect("doctree-resolved", name_pictures)
    app.connect("build-finished", copy_mathjax)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def generate(app: Any) -> None:
    """Write the pages that are made from the code and the notebooks."""
    effect_pages.write(GENERATED / "effects")
    notebook_pages.write(ROOT / "notebooks", GENERATED / "notebooks")
    write_api(GENERATED / "api")
    for name in ("CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md", "THIRD_PARTY.md"):
        page = DOCS / STANDS_FOR[name]
        put(page, repaired((ROOT / name).read_text(encoding="utf-8"), ROOT / name, page))


def repair_links(app: Any, document: str, source: list[str]) -> None:
    """Point links of documents to the pages that stand for files; in the repository they stay as they are."""
    source[0] = repaired(source[0], DOCS / document, DOCS / document)


def repaired(text: str, written_at: Path, shown_at: Path) -> str:
    """Return a Markdown text, written in one file, whose links fit the page of the site that shows it."""

    def lead(found: re.Match[str]) -> str:
        start, link, end = found.groups()
        if "://" in link or link.startswith(("mailto:", "_generated")):
            return found.group()
        target = (written_at.parent / link).resolve()
        if not target.exists() or not target.is_relative_to(ROOT):
            return found.group()
        known = target.relative_to(ROOT).as_posix()
        if target.is_dir() and known not in STANDS_FOR:
            return start.removeprefix("!")[1:-2] + f" (`{known}`)"
        target = DOCS / STANDS_FOR[known] if known in STANDS_FOR else target
        return start + Path(os.path.relpath(target, shown_at.parent)).as_posix() + end

    return LINK.sub(lead, text)


def name_pictures(app: Any, doctree: Any, document: str) -> None:
    """Give the pictures of notebooks their alternative texts."""
    if document.startswith("_generated/notebooks/"):
        notebook_pages.name_pictures(doctree)


def copy_mathjax(app: Any, error: Exception | None) -> None:
    """Put the one script that sets formulas into the site."""
    if error is None and app.builder.format == "html":
        package = importlib.util.find_spec("sphinx-mathjax-offline")
        assert package is not None, "extra docs"
        script = Path(str(package.origin)).parent / "static" / "mathjax" / "tex-svg.js"
        place = Path(app.outdir) / "_static" / "mathjax"
        place.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(script, place / script.name)
