"""Text files are UTF-8 whatever the system's own encoding is: cp1252 on Windows, ASCII in a bare container."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.fixtures.examples import MODEL

ROOT = Path(__file__).resolve().parents[1]
FILES = sorted(path for folder in ("python", "packaging", "docs", "examples") for path in (ROOT / folder).rglob("*.py"))
#: Calls that take `encoding`, and how many arguments stand before it.
BEFORE = {"read_text": 0, "write_text": 1, "open": 3, "fdopen": 3, "NamedTemporaryFile": 2, "TemporaryFile": 2}
#: What starts a process, which takes it where it is to give text.
PROCESSES = ("run", "Popen", "check_output")
#: What opens no text, though it is called alike.
OTHERS = ("os.open", "Image.open")


def lacking(source):
    """Lines of calls that read or write text in the system's encoding."""
    found = []
    for call in ast.walk(ast.parse(source)):
        if not isinstance(call, ast.Call):
            continue
        name = ast.unparse(call.func)
        last = name.rpartition(".")[2]
        given = {one.arg: one.value for one in call.keywords}
        texts = [one.value for one in [*call.args, *given.values()] if isinstance(one, ast.Constant)]
        binary = any(isinstance(text, str) and len(text) < 4 and "b" in text for text in texts)
        if "encoding" in given or name in OTHERS or None in given:
            continue
        text = (
            "text" in given if last in PROCESSES else last in BEFORE and not binary and len(call.args) <= BEFORE[last]
        )
        if text:
            found.append(call.lineno)
    return found


def test_every_text_file_names_its_encoding():
    found = {path.relative_to(ROOT).as_posix(): lacking(path.read_text(encoding="utf-8")) for path in FILES}
    assert {name: lines for name, lines in found.items() if lines} == {}
    assert len(found) > 300


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("path.read_text()", [1]),
        ("path.read_text('utf-8')", []),
        ("path.write_text(text)", [1]),
        ("\nopen(path)", [2]),
        ("open(path, 'w')", [1]),
        ("open(path, 'rb')", []),
        ("path.open()", [1]),
        ("path.open(mode='wb')", []),
        ("open(path, encoding='utf-8')", []),
        ("subprocess.run(words, text=True)", [1]),
        ("subprocess.run(words)", []),
        ("subprocess.run(words, text=True, encoding='utf-8')", []),
    ],
)
def test_the_search_sees_what_it_should(source, found):
    assert lacking(source) == found


def test_the_commands_open_no_text_in_the_encoding_of_the_system(tmp_path):
    """Python's own word on it: from a model file with letters of other scripts to a log, a table and a map."""
    MODEL.write(tmp_path / "model.toml")
    text = (tmp_path / "model.toml").read_text(encoding="utf-8")
    (tmp_path / "model.toml").write_text(f"# Δx, 力\n{text}", encoding="utf-8")
    (tmp_path / "move.toml").write_text(
        '# Größe\ntype = "sine"\ncenter = 0.25\namplitude = 0.1\nfrequency = 2.0\nduration = 0.5\n', encoding="utf-8"
    )
    code = """
import sys
from cogging_command import main
for words in (
    ["simulate", "model.toml", "--reference", "move.toml", "--out", "log.csv"],
    ["audit", "log.csv"],
    ["identify", "log.csv", "--model", "model.toml", "--out", "fitted.toml"],
    ["export", "model.toml", "--to", "csv", "--out", "map.csv"],
    ["schema"],
):
    sys.argv = ["cogging", *words]
    assert main() == 0, words
"""
    strict = ["-X", "warn_default_encoding", "-W", "error::EncodingWarning"]
    settings = {**os.environ, "LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}
    done = subprocess.run(
        [sys.executable, *strict, "-c", code], cwd=tmp_path, env=settings, capture_output=True, encoding="utf-8"
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert (tmp_path / "fitted.toml").is_file()
