"""What the package writes, each kind in two versions, by the calls that users make: for `tests.attack.disks`."""

from __future__ import annotations

import argparse
import functools
import os
import re
import zlib
from collections.abc import Callable
from pathlib import Path
from unittest import mock

import numpy as np

import cogging
from cogging.cli.answer import give
from cogging.export import forms
from cogging.model.model import Model
from cogging.papers import result as papers
from tests.fixtures.command_files import MODEL as DOCUMENT
from tests.fixtures.sweeps import MANY, MOVE, SMALL

VERSIONS = ("old", "new")
ROWS = 400
PAPER = "paper"
FIGURES = ("paper_fig1", "paper_fig2", "paper_fig3")
MAPPED = {**DOCUMENT, "cogging": {"pitch": 0.05, "harmonics": [1, 2], "sine": [[0.2], [0.1]], "cosine": [[0.0], [0.1]]}}


def _noise(version: str, name: str, size: int) -> bytes:
    """Content that no disk makes smaller, of a picture or a page."""
    return np.random.default_rng(zlib.crc32(f"{version} {name}".encode())).bytes(size)


@functools.cache
def _log(version: str, told: bool) -> cogging.Log:
    draw = np.random.default_rng(VERSIONS.index(version))
    columns = {name: draw.normal(size=ROWS) for name in ("position", "command", "reference")}
    return cogging.Log(time=np.arange(ROWS) * 1e-3, **columns, metadata={"seed": version} if told else {})


def _write_log(suffix: str, folder: Path, version: str) -> None:
    _log(version, True).write(folder / f"log{suffix}")


def _write_bare(folder: Path, version: str) -> None:
    """A log with metadata, replaced by one without: what stood beside it goes with it."""
    _log(version, version == "old").write(folder / "log.csv")


@functools.cache
def _model(version: str) -> Model:
    changed = {"axis": {"mass": 0.1}, "cogging": {"sine": [[0.3], [0.2]]}, "controller": {"kp": 2100.0}}
    changed = {section: {**MAPPED[section], **fields} for section, fields in changed.items()}
    return Model.from_dict(MAPPED if version == "old" else {**MAPPED, **changed})


def _write_model(folder: Path, version: str) -> None:
    _model(version).write(folder / "model.toml")


@functools.cache
def _fit(version: str) -> cogging.MapFit:
    x = np.arange(510) * 1e-3
    force = np.sin(2.0 * np.pi * x / 0.05) * (1.0 if version == "old" else 2.0)
    return cogging.fit_map(x, force, pitch=0.05, harmonics=[1], order=0)


def _write_map(folder: Path, version: str) -> None:
    """Model part and figure; what draws the figure is left out, which takes longer than all the rest."""
    picture = _noise(version, "map", 6000)
    figure = mock.Mock(savefig=lambda to, **_: to.write(picture))
    with (
        mock.patch.object(cogging.MapFit, "plot", return_value=figure),
        mock.patch("cogging.mapping.result.grid_to_write"),
    ):
        _fit(version).write(folder / "map.toml")


def _give(folder: Path, version: str) -> None:
    """A diagnosis as its command gives it: result, report and patched model."""
    files = {f"{folder / 'report.html'}": [_noise(version, "page", 9000)]}
    files[f"{folder / 'patched.toml'}"] = [f'version = "{version}"\n'.encode() * 100]
    asked = argparse.Namespace(json=f"{folder / 'result.json'}", quiet=True)
    give(asked, "", document={"version": version, "numbers": list(range(500))}, files=files)


@functools.cache
def _exported(version: str, form: str) -> dict[str, bytes]:
    made = forms.to(_model(version), form)
    return {"": made.content, **made.beside}


def _export(form: str, folder: Path, version: str) -> None:
    asked = argparse.Namespace(json=None, quiet=True)
    files = {f"{folder / 'out'}{suffix}": [content] for suffix, content in _exported(version, form).items()}
    give(asked, "", files=files)


def _reproduce(folder: Path, version: str) -> None:
    """Tables, figures and JSON of a paper, in a folder that is made; the pictures are of no figures."""
    rows = [papers.Row("C1", "e_inf", "m", 1.0, float(i + 10 * VERSIONS.index(version)), "predicted") for i in range(9)]
    found = papers.Reproduction(PAPER, [papers.Table("table1", "Table 1", rows)], {name: name for name in FIGURES})
    with mock.patch.object(papers, "png", lambda name: _noise(version, name, 5000)):
        found.write(folder / "results")


def _sweep(suffix: str, folder: Path, version: str) -> None:
    """A whole sweep, its pieces too."""
    masses = {"axis.mass": {"from": 0.1, "to": 0.14 if version == "old" else 0.15}}
    assert masses.keys() == MANY.keys()
    move = {**MOVE, "duration": 0.02}
    cogging.sweep(SMALL, move, masses, method="random", runs=24, seed=5, threads=1, out=folder / f"runs{suffix}")


#: Kinds by name: what writes a version of one into a folder.
KINDS: dict[str, Callable[[Path, str], None]] = {
    "log.csv": functools.partial(_write_log, ".csv"),
    "log.csv without its metadata": _write_bare,
    "log.mat": functools.partial(_write_log, ".mat"),
    "log.parquet": functools.partial(_write_log, ".parquet"),
    "model": _write_model,
    "fitted map and figure": _write_map,
    "result, report, model": _give,
    "drive table": functools.partial(_export, "csv"),
    "C++ header": functools.partial(_export, "cpp"),
    "FMU": functools.partial(_export, "fmi"),
    "reproduce": _reproduce,
    "sweep.csv": functools.partial(_sweep, ".csv"),
    "sweep.parquet": functools.partial(_sweep, ".parquet"),
}
TIME_OF_WRITING = re.compile(rb"Created on: .{24}")  # in a MATLAB file


def state(folder: Path) -> dict[str, bytes]:
    """The files below a folder by name, without what a sweep keeps to go on from and names that are no result."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = os.path.relpath(path, folder)
        if path.is_file() and ".pieces" not in name and not path.name.startswith(".cogging-"):
            found[name] = TIME_OF_WRITING.sub(b"", path.read_bytes())
    return found


def left(folder: Path) -> list[str]:
    """Names of files that are no result and none that a sweep goes on from."""
    return [path.name for path in folder.rglob(".cogging-*") if ".pieces" not in str(path.parent)]
