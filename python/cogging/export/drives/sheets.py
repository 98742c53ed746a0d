"""The sheets of all drives, as docs/export.md shows them: `python -m cogging.export.drives.sheets` prints them."""

from __future__ import annotations

from cogging.export.drives import akd, ax8000, by_position, moteus, novanta, odrive, sinamics
from cogging.export.drives.sheet import Sheet

#: By the name of the form.
SHEETS: dict[str, Sheet] = {
    "csv": by_position.SHEET,
    "akd": akd.SHEET,
    "sinamics": sinamics.SHEET,
    "ax8000": ax8000.SHEET,
    "novanta": novanta.SHEET,
    "odrive": odrive.SHEET,
    "moteus": moteus.SHEET,
}


def markdown() -> str:
    """A table of what each takes, then each sheet as a section."""
    lines = ["| `--to` | drive | takes | entries | between entries |", "|---|---|---|---|---|"]
    lines += [
        f"| `{name}` | {one.drive} | {one.quantity} | {one.entries} | {one.between} |" for name, one in SHEETS.items()
    ]
    return "\n".join([*lines, "", *(f"{one.markdown()}\n" for one in SHEETS.values())]).rstrip("\n")


if __name__ == "__main__":
    print(markdown())
