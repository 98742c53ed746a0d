"""The first page of the built site as pictures: `python -m tests.site.screenshots build/site docs/pictures`."""

import shutil
import sys
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

VIEWS = {"desk_light": (1280, 900), "phone_dark": (390, 844)}
COLOURS = 64  # of the palette: such a picture is a tenth as large


def main(site, folder):
    """Write one picture a view."""
    folder.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        for view, (width, height) in VIEWS.items():
            page = browser.new_page(viewport={"width": width, "height": height}, color_scheme=view.split("_")[1])
            page.goto((site / "index.html").resolve().as_uri())
            page.evaluate("() => MathJax.startup.promise")
            path = folder / f"site_{view}.png"
            page.screenshot(path=path)
            with Image.open(path) as picture:
                picture.convert("RGB").quantize(COLOURS).save(path, optimize=True)
        browser.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
