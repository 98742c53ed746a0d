"""Input beyond what a machine makes ends in one line of plain English, and nothing else on standard error."""

import os
import subprocess
import sys
import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.io import savemat

import cogging
from cogging.cli.main import main
from tests.fixtures.strokes import as_believed, drawn


@pytest.fixture(scope="module")
def strokes():
    machine, log = drawn(1, "nothing")
    return as_believed(machine, log), log


@pytest.fixture
def folder(tmp_path, monkeypatch, strokes):
    monkeypatch.chdir(tmp_path)
    strokes[0].write("m.toml")
    return tmp_path


WILD = {
    "no command": (lambda log: replace(log, command=0.0 * log.command), "command: must act on an axis that moves"),
    "tiny steps": (lambda log: replace(log, time=1e-300 * log.time), "time: must have rows at least 1e-12 s apart"),
    "huge command": (lambda log: replace(log, command=1e300 * log.command), "command: must be at most 1e+30 in size"),
    "huge travel": (lambda log: replace(log, position=1e300 * log.position), "position: must be at most 1e+30 in size"),
}


@pytest.mark.parametrize("kind", WILD)
def test_identify_says_what_is_wrong_with_a_wild_log(folder, strokes, capfd, kind):
    change, rule = WILD[kind]
    wild = change(strokes[1])
    columns = [wild.time, wild.position, wild.command]
    rows = [",".join(map(repr, map(float, row))) for row in zip(*columns, strict=True)]
    (folder / "w.csv").write_text("\n".join(["time,position,command", *rows]))
    assert main(["identify", "w.csv", "--model", "m.toml"]) == 2
    assert capfd.readouterr().err.startswith(f"cogging: w.csv: {rule}")


def test_a_stated_column_that_holds_no_numbers(folder, capfd):
    numbers = np.arange(100.0)
    savemat("A.mat", {"A": np.ones((100, 3)), "name": "x", "time": numbers, "position": numbers, "f": numbers[:50]})
    answers = {"A": "A: must be one column, got an array of 100 x 3", "name": "name: must be real numbers, got text"}
    answers["f"] = "column f: must be named once, and as long as the columns of numbers are"
    for column, answer in answers.items():
        assert main(["init", "A.mat", "--columns", f"command={column}"]) == 2
        assert capfd.readouterr().err == f"cogging: A.mat: {answer}\n"


@pytest.mark.skipif(os.name == "nt", reason="a current folder cannot be deleted there")
def test_a_current_folder_that_was_deleted_is_named(folder):
    for words in ("init run.csv", "simulate m.toml --reference r.toml --out s.csv", "identify run.csv --model m.toml"):
        gone = folder / "gone"
        gone.mkdir()
        script = f"import os; os.rmdir({str(gone)!r}); from cogging.cli.main import main; raise SystemExit(main())"
        done = subprocess.run(
            [sys.executable, "-c", script, *words.split()], cwd=gone, capture_output=True, text=True, check=False
        )
        assert done.returncode == 2
        assert done.stderr.startswith("cogging: the current folder: must be there, got one that was deleted")
        assert done.stderr.count("\n") == 1


def test_a_model_with_half_a_surrogate_pair_is_not_written(folder, strokes):
    model, log = strokes
    metadata = {"note": "\ud800"}
    wrong = {"m2.toml": model.replace(uncertainty={"m\ud800": 0.1}), "l.csv": replace(log, metadata=metadata)}
    for name, one in wrong.items():
        with pytest.raises(ValueError, match=r"\\ud800.*: must be text that UTF-8 holds"):
            one.write(folder / name)
        assert not (folder / name).exists()


def test_letters_that_the_font_of_the_page_lacks_are_no_warning(folder, strokes):
    from cogging.diagnosis.report.pictures import picture

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert "牛顿" in picture(lambda axes: axes.set_ylabel("牛顿"), "A word.").svg


def test_wild_sizes_lead_to_no_warning(strokes):
    model, log = strokes
    bare = model.replace(controller=None, controller_type=None, axis=model.axis.replace(coulomb=1e29))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cogging.diagnose(replace(log, command=1e-29 * log.command), bare)


def test_a_position_that_is_no_number_has_no_sign(strokes):
    model = strokes[0]
    heavy = model.replace(axis=model.axis.replace(viscous=1e30))
    motion = {"type": "point_to_point", "start": 0.03, "distance": 0.2, "velocity": 0.4, "acceleration": 4.0}
    with pytest.raises(cogging.DivergedError) as told:
        cogging.simulate(heavy, motion)
    assert "-nan" not in str(told.value)
