"""Every notebook runs from its first cell to its last, with the measured data and without them."""

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

from tests.fixtures.measured import FOLDER

FOLDER_OF_NOTEBOOKS = Path(__file__).parents[1] / "notebooks"
NOTEBOOKS = sorted(FOLDER_OF_NOTEBOOKS.glob("*.ipynb"))


def run(path):
    """The notebook with its outputs."""
    notebook = nbformat.read(path, as_version=4)
    assert notebook.cells
    return NotebookClient(
        notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(path.parent)}}
    ).execute()


def test_there_are_notebooks():
    assert NOTEBOOKS


@pytest.mark.parametrize("path", [*NOTEBOOKS, *sorted(FOLDER_OF_NOTEBOOKS.glob("*.py"))], ids=lambda path: path.name)
def test_none_reaches_out_of_its_folder(path):
    """They use the package, and what stands beside them: not the tests, and no place of its own choice."""
    if path.suffix == ".ipynb":
        source = "\n".join(cell.source for cell in nbformat.read(path, as_version=4).cells if cell.cell_type == "code")
    else:
        source = path.read_text(encoding="utf-8")
    for word in ("sys.path", "tests.", "../", '".."', "__file__", "shared"):
        assert word not in source, word


@pytest.mark.notebook
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs(path, monkeypatch):
    monkeypatch.setenv("COGGING_DATA", str(FOLDER))
    run(path)
    assert not any(cell.get("outputs") for cell in nbformat.read(path, as_version=4).cells if cell.cell_type == "code")


@pytest.mark.notebook
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_without_data_a_notebook_says_where_to_get_them(tmp_path, monkeypatch):
    """On to its last cell. A package of that name that fetches nothing stands in the way of one that would."""
    (tmp_path / "nonlinear_benchmarks.py").write_text("raise ImportError")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setenv("COGGING_DATA", str(tmp_path))
    cells = run(FOLDER_OF_NOTEBOOKS / "05_from_log_to_model.ipynb").cells
    said = ["".join(output.get("text", "?") for output in cell.get("outputs", [])) for cell in cells]
    first, *rest = [text for text in said if text]
    assert not rest
    lines = first.splitlines()
    for line, (name, licence) in zip(lines, {"emps": "cite", "laas": "BSD", "tro2021": "MIT"}.items(), strict=False):
        assert line.startswith(f"{name}: ")
        assert str(tmp_path) in line
        assert licence in line
    assert lines[3] == "the cells that need these data print nothing"
