"""The first page, from a CSV to a better model: its commands run as printed and print what it says."""

import os
import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import cogging
from tests.fixtures.shown_commands import missing, printed, shown

pytestmark = pytest.mark.skipif(os.name == "nt", reason="the page is for a shell of POSIX")

ROOT = Path(__file__).parents[1]
EXAMPLE = ROOT / "examples" / "first_model"
PAGE = ROOT / "docs" / "first_model.md"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The folder in which the page was run, its commands, and what they printed."""
    folder = tmp_path_factory.mktemp("page")
    for name in ("run.csv", "other.csv"):
        shutil.copy(EXAMPLE / name, folder)
    commands = shown(PAGE)
    return folder, commands, printed([command for command, _ in commands], folder)


def test_every_command_prints_what_the_page_says(run):
    _, commands, outputs = run
    assert len(commands) == len(outputs) >= 8
    for (command, said), (lines, status) in zip(commands, outputs, strict=True):
        assert status == 0, (command, lines)
        assert missing(said, lines) is None, (command, "\n".join(lines))
    how = next(command for command, _ in commands if command.startswith("HOW=")).removeprefix("HOW=").strip('"')
    assert outputs[0][0][-1].endswith(how)  # the next command, as `init` printed it


def test_the_patched_model_is_the_machine_that_made_the_logs(run):
    folder, _, _ = run
    better = cogging.Model.read(folder / "better.toml")
    (spring,) = better.effects
    assert spring.NAME == "cable_spring"
    assert spring.stiffness == pytest.approx(14.0, rel=0.02)
    assert spring.center == pytest.approx(0.2, abs=2e-3)
    assert better.axis.mass == pytest.approx(3.2, rel=0.01)
    assert better.units.command == "N"
    for name, true in (("mass", 3.2), ("viscous", 9.0), ("coulomb", 4.5), ("coulomb_width", 2e-3)):
        low, high = better.intervals[f"axis.{name}"]
        assert low < true < high < 1.2 * low, name


def test_the_figure_of_the_readme_is_that_of_the_page(run, tmp_path):
    """Its words exactly, its numbers within half a point."""
    draw = runpy.run_path(str(ROOT / "docs" / "pictures" / "diagnosis.py"))["main"]
    draw(run[0] / "page.html", tmp_path)
    for name in ("diagnosis_light.svg", "diagnosis_dark.svg"):
        made, shipped = ((folder / name).read_text() for folder in (tmp_path, ROOT / "docs" / "pictures"))
        words = [re.findall(r">([^<>]+)</text>", one) for one in (made, shipped)]
        assert words[0] == words[1]
        points = [re.findall(r"[ML] (\S+) (\S+)", one) for one in (made, shipped)]
        assert np.array(points[0], float) == pytest.approx(np.array(points[1], float), abs=0.5)


def test_the_logs_are_what_the_script_beside_them_makes(tmp_path):
    subprocess.run([sys.executable, EXAMPLE / "make_logs.py", tmp_path], check=True)
    for name in ("run.csv", "other.csv"):
        made, shipped = (path.read_text().splitlines() for path in (tmp_path / name, EXAMPLE / name))
        assert made[0] == shipped[0]
        assert len(made) == len(shipped)
        same = sum(a == b for a, b in zip(made, shipped, strict=True))
        assert same > 0.99 * len(made)  # the last digit may be another's on another machine
