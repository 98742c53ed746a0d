"""The notebooks as pages of the site, with or without their outputs, and the cards of the gallery."""

from __future__ import annotations

import base64
import io
import json
import re
from pathlib import Path
from typing import Any

from api_pages import put

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
    title, told = opening(notebook)
    picture = first_picture(notebook)
    shown = ""
    if picture is not None:
        (folder / f"{stem}.png").write_bytes(_small(picture))
        told_picture = f":class: thumbnail\n:alt: First figure of the notebook: {title}"
        shown = f"```{{image}} _generated/notebooks/{stem}.png\n{told_picture}\n```\n\n"
    return (
        f"`````{{grid-item-card}} {title}\n:link: _generated/notebooks/{stem}\n:link-type: doc\n\n{shown}{told}\n`````"
    )


def opening(notebook: dict[str, Any]) -> tuple[str, str]:
    """Return the heading of a notebook, and its first sentences, at least ENOUGH characters."""
    first = "".join(notebook["cells"][0]["source"])
    heading, _, rest = first.partition("\n")
    sentences = re.split(r"(?<=[.?])(?<!al\.) (?=[A-Z])", " ".join(rest.strip().split("\n\n")[0].split()))
    told = sentences.pop(0)
    while sentences and len(told) < ENOUGH:
        told += " " + sentences.pop(0)
    return heading.lstrip("# ").strip(), told


def first_picture(notebook: dict[str, Any]) -> bytes | None:
    """Return the first PNG among the outputs; None for a notebook without outputs."""
    for cell in notebook["cells"]:
        for output in cell.get("outputs", []):
            data = output.get("data", {}).get("image/png")
            if data is not None:
                return base64.b64decode("".join(data))
    return None


def _small(picture: bytes) -> bytes:
    """Return a picture no wider than WIDTH."""
    from PIL import Image

    with Image.open(io.BytesIO(picture)) as image:
        image.thumbnail((WIDTH, WIDTH))
        made = io.BytesIO()
        image.convert("RGB").save(made, "PNG", optimize=True)
    return made.getvalue()


def name_pictures(doctree: Any) -> None:
    """Give each figure of a notebook an alternative text: the heading above it."""
    from docutils import nodes

    for picture in doctree.findall(nodes.image):
        if not picture.get("alt"):
            section = picture
            while section.parent is not None and not isinstance(section, nodes.section):
                section = section.parent
            picture["alt"] = f"Figure under the heading: {section.next_node(nodes.title).astext()}"
