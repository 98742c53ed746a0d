"""The README's lines run."""

import re
import runpy
from pathlib import Path

README = Path(__file__).parents[1] / "README.md"


def test_the_fifteen_lines_run(tmp_path, capsys):
    (code,) = re.findall(r"```python\n(.*?)```", README.read_text(), flags=re.DOTALL)
    (tmp_path / "lines.py").write_text(code)
    runpy.run_path(str(tmp_path / "lines.py"))
    printed = re.search(r"(\d+) samples, largest error ([\d.]+) um", capsys.readouterr().out)
    assert int(printed[1]) > 8000
    assert 0.5 < float(printed[2]) < 500.0


def test_the_figure_is_there():
    (path,) = re.findall(r"!\[.*?\]\((.*?)\)", README.read_text())
    assert (README.parent / path).read_bytes().startswith(b"\x89PNG")


def test_links_of_the_documents_beside_the_readme_lead_somewhere():
    """Those of docs/ are checked when the site is built."""
    for path in README.parent.glob("*.md"):
        for link in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", path.read_text(encoding="utf-8")):
            assert link.startswith(("http:", "https:")) or (path.parent / link).exists(), (path.name, link)
