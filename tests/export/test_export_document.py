"""docs/export.md: its sheets are those of the code, its lines run, and its figures are what they print."""

import re
import runpy
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

import cogging
from cogging.cli.main import main
from cogging.export.drives import QUESTIONS, SHEETS
from cogging.export.forms import FORMS
from tests.fixtures.measured import FOLDER

DOCUMENT = (Path(__file__).parents[2] / "docs" / "export.md").read_text(encoding="utf-8")
CONSTANT = {"scale": 0.04}  # Nm/A
SAME_MAP = {"csv": {}, "akd": {}, "moteus": {}, "sinamics": CONSTANT, "ax8000": CONSTANT}
SAME_MAP |= {"novanta": {"entries": 256, "pole_pairs": 7}, "odrive": {"quantity": "current"}}


def code():
    return re.findall(r"```python\n(.*?)```", DOCUMENT, flags=re.DOTALL)


def test_the_sheets_stand_in_the_document():
    assert list(SHEETS) == [name for name, form in FORMS.items() if form.of_map]
    for sheet in SHEETS.values():
        for said in (sheet["drive"], *(sheet[key] for key in QUESTIONS.values()), *sheet["assumed"]):
            assert f"| {said} |" in DOCUMENT or f"### {said}" in DOCUMENT, said


def test_the_loop_of_the_document(capsys):
    plt.switch_backend("agg")
    with plt.rc_context():  # python-control has settings of its own
        exec(code()[1], {})
    plt.close("all")
    assert f"\n    {capsys.readouterr().out.strip()}\n" in DOCUMENT


@pytest.mark.data
def test_the_motor_of_the_document(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COGGING_DATA", str(FOLDER))
    (tmp_path / "lines.py").write_text(code()[0])
    runpy.run_path("lines.py")
    capsys.readouterr()
    called = re.findall(r"^    \$ cogging (export .*)\n((?:    [^$\s].*\n)+)", DOCUMENT, re.MULTILINE)
    assert len(called) >= 2
    for words, shown in called:
        assert main(words.split()) == 0
        assert [line.strip() for line in shown.splitlines()] == capsys.readouterr().out.splitlines()
    for form, options in SAME_MAP.items():  # its size, the share removed, what is left and why
        text = cogging.export.to("motor.toml", form, **options).text
        size = re.search(r": (\d.*?)(?:, largest|; its zero)", text)[1]
        share, left = re.search(r"removes (\S+) % of the cogging's rms, \S+ A to (\S+) A", text).groups()
        row = f"| `{form}` | {size} | {share} % | {1e3 * float(left):.3g} mA | "
        assert row + "; ".join(re.findall(r"cannot hold (.*)", text)) + " |" in DOCUMENT, form
