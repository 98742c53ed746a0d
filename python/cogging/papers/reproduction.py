"""The published experiments by name."""

from __future__ import annotations

import importlib
import os

from cogging.calls import check_arguments
from cogging.papers.result import Reproduction
from cogging.progress import Progress, steps
from cogging.resources import on_one_blas_thread
from cogging.shown import not_one_of

#: The papers that can be reproduced; each is a package beside this file.
PAPERS = ("lu2008", "malaize2009", "xu2001")


@check_arguments()
@on_one_blas_thread(scipy=True)
def reproduce(paper: str, *, out: str | os.PathLike[str] | None = None, progress: Progress = False) -> Reproduction:
    """Reproduce the experiments of a paper.

    Args:
        paper: one of PAPERS.
        out: folder for `<paper>.json` and the figures; None writes nothing.
        progress: True shows a bar, a function is called with each step.

    Returns:
        The paper's tables beside the simulated ones, and figures; print it to read the tables.

    Raises:
        ValueError: the paper is not one of PAPERS.

    Example:
        >>> cogging.reproduce("lu2009")
        Traceback (most recent call last):
            ...
        ValueError: paper: must be one of lu2008, malaize2009, xu2001, got 'lu2009' (did you mean 'lu2008'?)
    """
    if paper not in PAPERS:
        raise ValueError(f"paper: {not_one_of(paper, PAPERS)}")
    return _run(paper, out, progress)


@check_arguments()
@on_one_blas_thread(scipy=True)
def compare(*, out: str | os.PathLike[str] | None = None, progress: Progress = False) -> Reproduction:
    """Compare the controllers of all papers on the same axes: error, effort, chatter, robustness, time of a step.

    Args:
        out: folder for `comparison.json` and the figures; None writes nothing.
        progress: True shows a bar, a function is called with each step.

    Returns:
        Tables and figures.

    Example:
        >>> result = cogging.compare()  # doctest: +SKIP
    """
    return _run("comparison", out, progress)


def _run(name: str, out: str | os.PathLike[str] | None, progress: Progress) -> Reproduction:
    module = importlib.import_module(f"cogging.papers.{name}")
    with steps(progress, name, module.STEPS) as done:
        result: Reproduction = module.reproduce(done)
    if out is not None:
        result.write(out)
    return result
