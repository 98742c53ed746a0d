"""The published experiments: setup, numbers and what is calibrated or predicted of each paper."""

from __future__ import annotations

import importlib
import os

from cogging.papers.result import Reproduction, Row, Table

__all__ = ["PAPERS", "Reproduction", "Row", "Table", "reproduce"]

#: The papers that can be reproduced; each is a module of this folder.
PAPERS = ("lu2008", "xu2001")


def reproduce(paper: str, *, out: str | os.PathLike[str] | None = None, progress: bool = False) -> Reproduction:
    """Reproduce the experiments of a paper: its tables beside ours, and its figures.

    Args:
        paper: one of PAPERS.
        out: folder into which `<paper>.json` and the figures are written; None writes nothing.
        progress: show a progress bar on standard error.

    Raises:
        ValueError: the paper is not one of PAPERS.
    """
    if paper not in PAPERS:
        raise ValueError(f"paper: must be one of {', '.join(PAPERS)}, got {paper!r}")
    module = importlib.import_module(f"cogging.papers.{paper}")
    from tqdm import tqdm

    with tqdm(total=len(module.STEPS), desc=paper, unit="step", disable=not progress, leave=False) as bar:

        def done(step: str) -> None:
            bar.set_postfix_str(step)
            bar.update()

        result: Reproduction = module.reproduce(done)
    if out is not None:
        result.write(out)
    return result
