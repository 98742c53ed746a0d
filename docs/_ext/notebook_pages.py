"""The notebooks as pages of the site, with or without their outputs, and the cards of the gallery."""

from __future__ import annotations

import base64
import io
import json
import re
from pathlib import Path
from typing import Any

from api_pages import put
from PIL import Image

WIDTH = 640  # pixels of a thumbnail
ENOUGH = 80  # characters of a card's text


def write(notebooks: Path, folder: Path) -> None:
    """Copy the notebooks to where the site is built from, and write the cards that lead to them."""
    folder.mkdir(parents=True, exist_ok=True)
    wanted = {path.name: path for path in sorted(notebooks.glob("*.ipynb"))}
    for old in folder.glob("*.ipynb"):
        if old.name not in wanted:
            old.unlink()
    cards = ["``````{grid} 1 2 2 3\n:gutter: 3"]
    for path in wanted.values():
        text = path.read_text(encoding="utf-8")
        put(folder / path.name, text)
        cards.append(_card(path.stem, json.loads(text), folder))
    (folder / "cards.md").write_text("\n\n".join([*cards, "``````"]) + "\n", encoding="utf-8")


def _card(stem: str, notebook: dict[str, Any], folder: Path) -> str:
    """Return the card of a notebook: title, picture and first sentences."""
    title, text = opening(notebook)
    shown, picture = "", first_picture(notebook)
    if picture is not None:
        with Image.open(io.BytesIO(picture)) as image:
            image.thumbnail((WIDTH, WIDTH))
            image.convert("RGB").save(folder / f"{stem}.png", optimize=True)
        options = f":class: thumbnail\n:alt: First figure of the notebook: {title}"
        shown = f"```{{image}} _generated/notebooks/{stem}.png\n{options}\n```\n\n"
    link = f":link: _generated/notebooks/{stem}\n:link-type: doc"
    return f"`````{{grid-item-card}} {title}\n{link}\n\n{shown}{text}\n`````"


def opening(notebook: dict[str, Any]) -> tuple[str, str]:
    """Return the heading of a notebook, and its first sentences, at least ENOUGH characters."""
    first = "".join(notebook["cells"][0]["source"])
    heading, _, rest = first.partition("\n")
    sentences = re.split(r"(?<=[.?])(?<!al\.) (?=[A-Z])", " ".join(rest.strip().split("\n\n")[0].split()))
    text = sentences.pop(0)
    while sentences and len(text) < ENOUGH:
        text += " " + sentences.pop(0)
    return heading.lstrip("# ").strip(), text


def first_picture(notebook: dict[str, Any]) -> bytes | None:
    """Return the first PNG among the outputs; None for a notebook without outputs."""
    for cell in notebook["cells"]:
        for output in cell.get("outputs", []):
            data = output.get("data", {}).get("image/png")
            if data is not None:
                return base64.b64decode("".join(data))
    return None


def name_pictures(doctree: Any) -> None:
    """Give each figure of a notebook an alternative text: the heading above it."""
    from docutils import nodes  # where only the cards are tested, sphinx is not installed

    for picture in doctree.findall(nodes.image):
        if not picture.get("alt"):
            section = picture
            while section.parent is not None and not isinstance(section, nodes.section):
                section = section.parent
            picture["alt"] = f"Figure under the heading: {section.next_node(nodes.title).astext()}"
