"""The lines of the README and of the notebooks pass `mypy --strict`: what a user copies is typed."""

import importlib.metadata
import importlib.util
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parents[1]
#: What a notebook has of itself.
GIVEN = "from typing import Any\ndef display(*shown: Any) -> None: ...\n"
NOTEBOOKS = sorted((HERE / "notebooks").glob("*.ipynb"))


def snippets():
    """Python code by the name of what it stands in: all blocks of a text as one program, as a reader runs them."""
    for path in (HERE / "README.md", *sorted((HERE / "docs").glob("*.md"))):
        blocks = re.findall(r"```python\n(.*?)```", path.read_text(), flags=re.DOTALL)
        if blocks:
            yield path.stem, "\n".join(blocks)
    for path in NOTEBOOKS:
        cells = [cell for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == "code"]
        yield path.stem, GIVEN + "\n".join("".join(cell["source"]) for cell in cells)


#: As of an installed package, whose own errors nobody is shown.
CONFIG = """[mypy]
ignore_missing_imports = True
follow_imports = silent
[mypy-cogging._core.*]
ignore_errors = True
"""


@pytest.mark.study  # `.ci/run` has it beside the other checks of types
def test_what_a_user_copies_is_typed(tmp_path):
    made = dict(snippets())
    assert {"README", *(path.stem for path in NOTEBOOKS)} <= set(made)
    names = []
    for name, code in made.items():
        lines = ["pass  # " + line if line.startswith(("%", "!")) else line for line in code.splitlines()]
        path = tmp_path / (re.sub(r"\W", "_", f"of_{name}") + ".py")
        path.write_text("\n".join(lines) + "\n")
        names.append(path.name)
    (tmp_path / "mypy.ini").write_text(CONFIG)
    options = ["--config-file=mypy.ini", "--strict", f"--cache-dir={HERE / '.mypy_cache'}"]
    if tuple(map(int, importlib.metadata.version("numba").split(".")[:2])) < (0, 66):  # whose decorators have no types
        options.append("--allow-untyped-decorators")
    command = [sys.executable, "-m", "mypy", *options, *names]
    done = subprocess.run(command, cwd=tmp_path, env={"PATH": ""}, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
