"""Each study of the papers is one command that describes itself and is listed in studies/README.md."""

import runpy
import sys
from pathlib import Path

import pytest

STUDIES = Path(__file__).parents[2] / "studies"
NAMES = [
    ".".join(path.relative_to(STUDIES.parent).with_suffix("").parts)
    for path in sorted(STUDIES.rglob("*.py"))
    if "sys.exit(run_" in path.read_text(encoding="utf-8") and "diagnosis" not in path.parts
]
assert len(NAMES) >= 11


@pytest.mark.parametrize("name", NAMES)
def test_a_study_describes_itself_and_does_not_start(name, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", [name, "--help"])
    monkeypatch.delitem(sys.modules, name, raising=False)
    with pytest.raises(SystemExit) as end:
        runpy.run_module(name, run_name="__main__", alter_sys=True)
    assert end.value.code == 0
    assert f"usage: python -m {name}" in capsys.readouterr().out
    assert f"`python -m {name}" in (STUDIES / "README.md").read_text(encoding="utf-8")
