"""Every notebook runs from its first cell to its last and says what it said; `measured_*` need measured data.

The outputs that are committed are compared with those of a fresh run: the words exactly, the numbers within
`tests.fixtures.notebooks.RELATIVE` or two units of their last digit. They are written anew by
`python -m tests.fixtures.notebooks`.
"""

import pytest

from tests.fixtures.notebooks import MEASURED, NOTEBOOKS, differences, executed, pictures, texts


def marks_of(path):
    """What they compute other tests check: `.ci/run` and the weekly studies compare those without measured data."""
    return [pytest.mark.data] * (path in MEASURED) + [pytest.mark.study] * (path.stem != "measured_axes")


@pytest.mark.notebook
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("path", [pytest.param(path, id=path.stem, marks=marks_of(path)) for path in NOTEBOOKS])
def test_a_fresh_run_prints_what_is_committed(path):
    import nbformat

    committed = nbformat.read(path, as_version=4)
    for fresh, was in zip(executed(path).cells, committed.cells, strict=True):
        assert pictures(fresh) == pictures(was), fresh.source
        assert not [found for pair in zip(texts(fresh), texts(was), strict=True) for found in differences(*pair)]


def test_numbers_are_compared_within_what_is_stated():
    """One more in the last digit passes; three in a hundred, another word or another line does not."""
    for text in ("mass 1.23456 kg [1.11111, 1.235e+00]: named\nrow 2", "mass 98765 kg [0.9, 3.000e-05]: named\nrow 2"):
        number = text.split()[1]
        assert not differences(text, text)
        assert not differences(text, text.replace(number, f"{float(number) * (1 + 1e-6):.6g}", 1))
        assert len(differences(text, text.replace(number, f"{float(number) * 1.03:.6g}", 1))) == 1
        assert len(differences(text, text.replace("named", "ambiguous"))) == 1
        assert len(differences(text, text + "\nrow 3")) == 1
