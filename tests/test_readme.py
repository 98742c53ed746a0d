"""The README: its lines run and print what it shows, its answer is that of the first page, its links lead somewhere."""

import re
import runpy
from pathlib import Path

from tests.fixtures.shown_commands import shown

README = Path(__file__).parents[1] / "README.md"
TEXT = README.read_text(encoding="utf-8")


def test_the_fifteen_lines_run_and_print_what_stands_below_them(tmp_path, capsys):
    ((code, said),) = re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```", TEXT, flags=re.DOTALL)
    assert max(map(len, code.splitlines())) <= 88
    assert len(code.splitlines()) <= 15
    (tmp_path / "lines.py").write_text(code)
    runpy.run_path(str(tmp_path / "lines.py"))
    assert capsys.readouterr().out == said


def test_the_diagnosis_is_that_of_the_first_page():
    """Whose commands are run (tests.test_first_page): each line stands there below the same command."""
    ((command, lines),) = shown(README)
    said = dict(shown(README.parent / "docs" / "first_model.md"))[command]
    assert len(lines) == 6
    assert [line for line in lines if line not in said] == []


def test_links_of_the_documents_beside_the_readme_lead_somewhere():
    """Those of docs/ are checked when the site is built."""
    for path in README.parent.glob("*.md"):
        text = path.read_text(encoding="utf-8")
        links = re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", text) + re.findall(r'src(?:set)?="([^"]+)"', text)
        for link in links:
            assert link.startswith(("http:", "https:")) or (path.parent / link).exists(), (path.name, link)
