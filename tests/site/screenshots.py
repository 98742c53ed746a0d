"""Pages of the built site as pictures: `python -m tests.site.screenshots build/site docs/pictures`."""

import sys
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

from tests.fixtures.browser import chromium

#: Name of the picture, which ends in its scheme: page, width, height, and what is moved to the top.
VIEWS = {
    "site_desk_light": ("index.html", 1280, 900, ""),
    "site_phone_dark": ("index.html", 390, 844, ""),
    "effect_desk_light": ("_generated/effects/cable_spring.html", 1280, 900, ""),
    "notebook_desk_light": ("_generated/notebooks/06_missing_effect.html", 1280, 900, "article img"),
}
COLOURS = 64  # of the palette: such a picture is a tenth as large


def main(site, folder):
    folder.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium(), args=["--no-sandbox"])
        for view, (name, width, height, top) in VIEWS.items():
            page = browser.new_page(viewport={"width": width, "height": height}, color_scheme=view.rpartition("_")[2])
            page.goto((site / name).resolve().as_uri())
            page.evaluate("() => window.MathJax && MathJax.startup.promise")
            if top:
                page.evaluate("top => scrollTo(0, document.querySelector(top).getBoundingClientRect().top - 160)", top)
            path = folder / f"{view}.png"
            page.screenshot(path=path)
            with Image.open(path) as picture:
                picture.convert("RGB").quantize(COLOURS).save(path, optimize=True)
        browser.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
