"""The pictures of the report in the docs: `python -m tests.benchmarks.report_pictures`, from the logs of EMPS.

Needs the measured data (COGGING_DATA), playwright and a Chromium. Takes half a minute.
"""

import argparse
import io
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

import cogging
from cogging.diagnosis.next_step import GivenFiles
from tests.fixtures import emps
from tests.fixtures.browser import chromium

WINDOWS = {1280: 1500, 390: 1500}  # px: width and height of what is shown
COLOURS = 96  # of a picture, so that it is light
FILES = GivenFiles(("DATA_EMPS.csv",), "emps.toml", ("DATA_EMPS_PULSES.csv",))


def report():
    """The page of the published model of EMPS, in newton."""
    model = emps.published().replace(units=cogging.Units(command="N"))
    result = cogging.diagnose(emps.read("DATA_EMPS"), model, confirm=emps.read("DATA_EMPS_PULSES"))
    return result.html(title="DATA_EMPS.csv", files=FILES)


def take(text, out):
    """Write the pictures of a page."""
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as started:
        path = Path(folder) / "report.html"
        path.write_text(text, encoding="utf-8")
        browser = started.chromium.launch(executable_path=chromium(), args=["--no-sandbox"])
        for width, height in WINDOWS.items():
            page = browser.new_page(viewport={"width": width, "height": height}, color_scheme="light")
            page.goto(path.as_uri())
            picture = Image.open(io.BytesIO(page.screenshot()))
            file = out / f"report_{width}.png"
            picture.convert("P", palette=Image.Palette.ADAPTIVE, colors=COLOURS).save(file, optimize=True)
            print(f"{file}: {file.stat().st_size / 1024:.0f} kB")
        browser.close()


def main():
    """Diagnose, and write the pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("docs/pictures"))
    take(report(), parser.parse_args().out)


if __name__ == "__main__":
    main()
