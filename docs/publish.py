"""Add a built site to the published versions: `python docs/publish.py build/site published v1.2.3`.

Each version has a folder of `published`, and the sidebar of each lists all of them. The front page leads to the newest
release; without one, to what is there.
"""

from __future__ import annotations

import json
import re
import shutil
import sys
from pathlib import Path


def publish(site: Path, published: Path, name: str) -> None:
    """Copy a site to its folder, or replace it there, and write the list of versions into every site."""
    shutil.rmtree(published / name, ignore_errors=True)
    shutil.copytree(site, published / name)
    names = [path.parent.name for path in published.glob("*/index.html")]
    names.sort(key=lambda one: [int(number) for number in re.findall(r"\d+", one)], reverse=True)
    for one in names:
        versions = published / one / "_static" / "versions.js"
        versions.write_text(f"const VERSIONS = {json.dumps(names)};\n", encoding="utf-8")
    lead = f'<!doctype html><meta http-equiv="refresh" content="0; url={names[0]}/index.html">\n'
    (published / "index.html").write_text(lead, encoding="utf-8")


if __name__ == "__main__":
    publish(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3])
