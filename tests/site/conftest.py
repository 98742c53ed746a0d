"""What the tests of the documentation site share: the code that makes it and the built site."""

import os
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.append(str(ROOT / "docs" / "_ext"))  # the code that makes the site is no part of the package


@pytest.fixture(scope="session")
def paths(site):
    """Of every page but those for the search."""
    found = [path for path in sorted(site.rglob("*.html")) if path.name not in ("search.html", "genindex.html")]
    assert len(found) > 50
    return found


@pytest.fixture(scope="session")
def site():
    """The folder of the built site: COGGING_SITE, or build/site."""
    folder = Path(os.environ.get("COGGING_SITE", ROOT / "build" / "site"))
    built = (folder / "index.html").exists()
    assert built, f"no site in {folder}: python -m sphinx -W --keep-going docs build/site (extra docs)"
    return folder.resolve()
