"""Every notebook runs from its first cell to its last and says what it said; `measured_*` need measured data.

The outputs that are committed are compared with those of a fresh run: the words exactly, the numbers within
`tests.fixtures.notebooks.RELATIVE` or two units of their last digit. They are written anew by
`python -m tests.fixtures.notebooks`.
"""

import ast
import functools
import subprocess
import sys

import numpy as np
import pytest

from tests.fixtures.notebooks import (
    FOLDER_OF_NOTEBOOKS,
    MEASURED,
    METADATA,
    NOTEBOOKS,
    differences,
    executed,
    pictures,
    texts,
)

LARGEST = 500_000  # bytes of a notebook with its outputs
#: Calls that draw.
DRAWS = {
    "plot",
    "figure",
    "subplots",
    "figure_errors",
    "figure_increment",
    "cogging_map",
    "adaptation",
    "friction_curve",
}
EVERY = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
RUN = pytest.mark.parametrize(
    "path", [pytest.param(path, id=path.stem, marks=[pytest.mark.data] * (path in MEASURED)) for path in NOTEBOOKS]
)


@functools.cache
def read(path):
    import nbformat

    return nbformat.read(path, as_version=4)


def code_of(path):
    return [cell for cell in read(path).cells if cell.cell_type == "code"]


def draws(source):
    """Whether a cell draws: it calls what draws, or shows a figure of a result."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in DRAWS:
            return True
        if isinstance(node, ast.Subscript) and ast.unparse(node.value).endswith(".figures"):
            return True
    return False


def test_there_are_notebooks():
    assert len(NOTEBOOKS) - len(MEASURED) >= 6
    assert len(MEASURED) >= 2
    assert not list(FOLDER_OF_NOTEBOOKS.glob("*.py"))


#: What a notebook that shows a longer study says first: studies are no part of the package.
STUDIES = 'sys.path.insert(0, "..")  # the folder of `studies`'


@EVERY
def test_none_reaches_out_of_its_folder(path):
    """They use the package, what it needs and the examples' logs; studies and measured data where they say so."""
    source = "\n".join(cell.source for cell in code_of(path)).replace('"../examples/', '"examples/')
    beside = {"sys", "studies"} if STUDIES in source else set()
    source = source.replace(STUDIES, "")
    for word in ("sys.path", "tests.", "../", '".."', "__file__", "shared", "%matplotlib"):
        assert word not in source, word
    assert ("cogging.datasets" in source) == (path in MEASURED) == ("COGGING_DATA" in path.read_text(encoding="utf-8"))
    roots = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            roots |= {name.name.split(".")[0] for name in node.names}
        elif isinstance(node, ast.ImportFrom):
            roots.add(node.module.split(".")[0])
    assert roots - beside <= {"cogging", "matplotlib", "numpy", "os", "tempfile"}


@EVERY
def test_the_committed_notebook_shows_its_story(path):
    """Each cell that draws has its picture, none has an error; nothing in it changes from run to run."""
    assert path.stat().st_size < LARGEST
    notebook = read(path)
    assert notebook.metadata == METADATA
    drawing = 0
    for number, cell in enumerate(code_of(path), start=1):
        assert cell.metadata == {}
        assert cell.execution_count == number
        kinds = {output.output_type for output in cell.outputs}
        assert kinds <= {"stream", "execute_result", "display_data"}, cell.source
        assert all(output.get("name", "stdout") == "stdout" for output in cell.outputs), cell.source
        if draws(cell.source):
            drawing += 1
            assert pictures(cell) >= 1, cell.source
        shown = [text for text in texts(cell) if "Figure size" in text]
        assert len(shown) == pictures(cell) - sum("Axes" in text and "Figure" not in text for text in texts(cell))
    assert drawing >= 1
    assert any(len("".join(texts(cell))) > 100 for cell in code_of(path))


@pytest.mark.notebook
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@RUN
def test_a_fresh_run_says_what_is_committed(path):
    cells = [cell for cell in executed(path).cells if cell.cell_type == "code"]
    for fresh, committed in zip(cells, code_of(path), strict=True):
        assert pictures(fresh) == pictures(committed), fresh.source
        told = zip(texts(fresh), texts(committed), strict=True)
        assert not [found for pair in told for found in differences(*pair)], fresh.source


# How outputs are compared ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(20))
def test_numbers_are_compared_within_what_is_stated(seed):
    """One more in the last digit passes; one in a hundred, another word or another line does not."""
    rng = np.random.default_rng(seed)
    value, digits = 10.0 ** rng.uniform(-6, 6), int(rng.integers(3, 7))
    text = f"mass {value:.{digits}g} kg [{0.9 * value:.{digits}g}, {value:.3e}]: named\nrow 2"
    assert not differences(text, text)
    nudged = f"mass {value * (1 + 1e-6):.{digits}g} kg [{0.9 * value:.{digits}g}, {value:.3e}]: named\nrow 2"
    assert not differences(text, nudged)
    wrong = f"mass {value * 1.03:.{digits}g} kg [{0.9 * value:.{digits}g}, {value:.3e}]: named\nrow 2"
    assert len(differences(text, wrong)) == 1
    assert len(differences(text, text.replace("named", "ambiguous"))) == 1
    assert len(differences(text, text + "\nrow 3")) == 1


def test_figures_show_in_a_kernel_that_never_saw_pyplot():
    """Without a magic line: as the value of a cell, of axes, of panels; pyplot is not imported by it."""
    program = (
        "from IPython.core.interactiveshell import InteractiveShell; import sys, cogging\n"
        "shell = InteractiveShell.instance()\n"
        "axes = cogging.plot.spectrum([1.0, 2.0], [1.0, 2.0])\n"
        "panels = cogging.plot.log({'time': [0, 1], 'a': [0, 1]})\n"
        "for shown in (axes, axes.figure, panels):\n"
        "    data, _ = shell.display_formatter.format(shown)\n"
        "    assert data['image/png'][:4] == b'\\x89PNG', data\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
