"""Text files are UTF-8 whatever the system's own encoding is: cp1252 on Windows, ASCII in a bare container."""

import os
import subprocess
import sys

from tests.fixtures.examples import MODEL


def test_the_commands_open_no_text_in_the_encoding_of_the_system(tmp_path):
    """Python's own word on it: from a model file with letters of other scripts to a log, a table and a map."""
    MODEL.write(tmp_path / "model.toml")
    text = (tmp_path / "model.toml").read_text(encoding="utf-8")
    (tmp_path / "model.toml").write_text(f"# Δx, 力\n{text}", encoding="utf-8")
    (tmp_path / "move.toml").write_text(
        '# Größe\ntype = "sine"\ncenter = 0.25\namplitude = 0.1\nfrequency = 2.0\nduration = 0.5\n', encoding="utf-8"
    )
    calls = "simulate model.toml --reference move.toml --out log.csv;audit log.csv;schema"
    calls += ";identify log.csv --model model.toml --out fitted.toml;export model.toml --to csv --out map.csv"
    code = """
import sys
from cogging_command import main
for call in sys.argv[1].split(";"):
    sys.argv[1:] = call.split()
    assert main() == 0, call
"""
    strict = ["-X", "warn_default_encoding", "-W", "error::EncodingWarning"]
    settings = {**os.environ, "LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}
    command = [sys.executable, *strict, "-c", code, calls]
    done = subprocess.run(command, cwd=tmp_path, env=settings, capture_output=True, encoding="utf-8")
    assert done.returncode == 0, done.stderr[-2000:]
    assert (tmp_path / "fitted.toml").is_file()
