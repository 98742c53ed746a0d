"""The figure of the README, of a page that the commands of docs/first_model.md write.

python docs/pictures/diagnosis.py page.html [FOLDER]
"""

import re
import sys
from pathlib import Path

from cogging.diagnosis.report.pictures import in_schemes


def main(page, folder=Path(__file__).parent):
    """Write the first figure of the page as diagnosis_light.svg and diagnosis_dark.svg."""
    figure = re.search(r"<svg.*?</svg>", Path(page).read_text(encoding="utf-8"), flags=re.DOTALL)[0]
    for scheme, svg in in_schemes(figure).items():
        (Path(folder) / f"diagnosis_{scheme}.svg").write_text(svg + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
