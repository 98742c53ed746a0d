"""`cogging sweep`: each rule of a sweep file, answered in one line that names file, field, rule and value."""

import random
import re

import pytest

from cogging.cli.main import main
from cogging.files import parse_toml
from cogging.outputs import to_toml
from cogging.simulation.sweep import KEYS
from tests.fixtures.sweeps import DOCUMENT, MOVE

FILES = 'model = "model.toml"\nreference = "move.toml"\n'
MASS = '[vary]\n"axis.mass" = [0.1, 0.12]\n'


def vary(path, told):
    return f'{FILES}[vary]\n"{path}" = {told}\n'


#: Sweep files and what is said of them, after the name of the file.
FAULTY = [
    ("", "model: must be given, got nothing"),
    ("model = ", "must be TOML: "),
    ('model = "model.toml"\n' + MASS, "reference: must be given, got nothing"),
    (FILES, "vary: must be given, got nothing"),
    (f'{FILES}metod = "grid"\n{MASS}', "line 3: metod: is unknown; did you mean method?"),
    (f"{FILES}{MASS}[vari]\n", "vari: is unknown; did you mean vary?"),
    (f'model = 3\nreference = "move.toml"\n{MASS}', "line 1: model: must be a text, got 3"),
    (f'model = "no.toml"\nreference = "move.toml"\n{MASS}', "line 1: model: must be a file .* got 'no.toml'"),
    (f'model = "model.toml"\nreference = "no.toml"\n{MASS}', "line 2: reference: must be a file .* got 'no.toml'"),
    (f"{FILES}method = 3\n{MASS}", "line 3: method: must be a text, got 3"),
    (f'{FILES}method = "gird"\n{MASS}', "line 3: method: must be one of grid, random, latin_hypercube, sobol, got 'g"),
    (f"{FILES}runs = 0\n{MASS}", "line 3: runs: must be from 1 to 100000000, got 0"),
    (f"{FILES}runs = 1.5\n{MASS}", "line 3: runs: must be a whole number, got 1.5"),
    (f"{FILES}seed = -1\n{MASS}", "line 3: seed: must be from 0 to 4611686018427387904, got -1"),
    (f"{FILES}seed = 1.0\n{MASS}", "line 3: seed: must be a whole number, got 1.0"),
    (f'{FILES}duration = "long"\n{MASS}', "line 3: duration: must be a number, got 'long'"),
    (f"{FILES}duration = -1.0\n{MASS}", "line 3: duration: must be finite and at least 0, got -1.0"),
    (f"{FILES}duration = 1e9\n{MASS}", r"no run could begin: duration: .* got 1e\+09"),
    (f"{FILES}start = nan\n{MASS}", "line 3: start: must be a number, got nan"),
    (f"{FILES}start = 1.0\nstop = 0.5\n{MASS}", "line 3: start: must be below stop = 0.5, got 1.0"),
    (f"{FILES}start = 0.2\n{MASS}", "no run could begin: start, stop: must hold at least 2 rows"),
    (f"{FILES}final_window = 0\n{MASS}", "line 3: final_window: must be above 0, got 0"),
    (f'{FILES}reductions = "error_max"\n{MASS}', "line 3: reductions: must be a list of names, got 'error_max'"),
    (f"{FILES}reductions = [3]\n{MASS}", "line 3: reductions: must be names, got 3"),
    (f'{FILES}reductions = ["eror_max"]\n{MASS}', "line 3: reductions: 'eror_max' is unknown; did you mean error_max?"),
    (f'{FILES}reductions = ["error_quantile(2)"]\n{MASS}', "line 3: reductions: error_.*: must be from 0 to 1, got 2"),
    (f'{FILES}reductions = ["error_tone(0)"]\n{MASS}', "line 3: reductions: .*frequency: must be .* above 0, got 0"),
    (f'{FILES}reductions = ["error_wave(-1)"]\n{MASS}', "line 3: reductions: .*period: must be .* above 0, got -1"),
    (f'{FILES}reductions = ["error_max", "command_max", "command_max"]\n{MASS}', "line 3: reductions: .* twice"),
    (f"{FILES}vary = 3\n", 'line 3: vary: must be a section or "bounds", got 3'),
    (f"{FILES}[vary]\n", "vary: must give at least one number"),
    (f'{FILES}vary = "bounds"\n', "vary.axis.mass: must have values, or from, to and points, on a grid"),
    (vary("axis.mas", "[1]"), "line 4: vary.axis.mas: is not a number of this run; did you mean axis.mass?"),
    (vary("reference.freqency", "[1]"), "line 4: vary.reference.freqency: is .* did you mean reference.frequency?"),
    (vary("axis.mass", "[]"), "line 4: vary.axis.mass: values: must hold at least one number, got none"),
    (vary("axis.mass", "[nan]"), "line 4: vary.axis.mass: values: must be numbers .* got [nan]"),
    (vary("axis.mass", "0.1"), 'line 4: vary.axis.mass: must be a list, a table or "bounds", got 0.1'),
    (vary("axis.mass", "{}"), "line 4: vary.axis.mass: must be values, or from and to, or mean and deviation, got {}"),
    (vary("axis.mass", "{values = [1], points = 2}"), "line 4: vary.axis.mass: must be values, or from and to, or"),
    (vary("axis.mass", "{from = 1, to = 1}"), "line 4: vary.axis.mass: from: must be below to = 1, got 1"),
    (vary("axis.mass", '{from = "a", to = 1}'), "line 4: vary.axis.mass: from: must be a number .* got 'a'"),
    (vary("axis.mass", "{from = 0.1, to = 1}"), "line 4: vary.axis.mass: must have values, or from, to and points, on"),
    (vary("axis.mass", "{from = 0.1, to = 1, points = 1}"), "line 4: vary.axis.mass: points: must be a whole .* got 1"),
    (
        vary("axis.mass", '{from = 0, to = 1, points = 2, scale = "log"}'),
        "line 4: vary.axis.mass: from: must be above 0",
    ),
    (vary("axis.mass", '{from = 1, to = 2, points = 2, scale = "lin"}'), "line 4: vary.axis.mass: scale: .* got 'lin'"),
    (vary("axis.mass", "{mean = 1, deviation = -1}"), "line 4: vary.axis.mass: deviation: must be at least 0, got -1"),
    (vary("axis.mass", "{mean = 1, deviaton = 1}"), "vary.axis.mass.deviaton: is unknown; did you mean devia"),
    (vary("axis.coulomb", '"bounds"'), "line 4: vary.axis.coulomb: must have a finite interval .* got [0.0, inf]"),
    (vary("seed", "[1, 1.5]"), "line 4: vary.seed: must be whole numbers from 0 to 9007199254740992, got 1.5"),
    (vary("seed", "{from = 0, to = 9, points = 10}"), "line 4: vary.seed: must be a list of whole numbers, got"),
    (vary("axis.mass", "[-1.0]"), "no run could begin: .*mass: must be finite and above 0, got -1"),
    (vary("reference.amplitude", "[5.0]"), "no run could begin: reference: must stay within travel"),
    (vary("axis.mass", "[0.11]") + "axis.mass = [0.13, 0.14]\n", "line 4: vary.axis.mass: must be given once, got "),
    (vary("axis.mass", "[0.11]") + "[vary.axis]\nmass = [0.13]\n", "line 4: vary.axis.mass: must be given once, got "),
    (
        vary("axis.mass", "{from = 0.1, to = 1, points = 100000}")
        + '"axis.viscous" = {from = 0.1, to = 1, points = 1001}\n',
        "runs: must be from 1 to 100000000, got 100100000",
    ),
]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "model.toml").write_text(to_toml(DOCUMENT))
    (tmp_path / "move.toml").write_text(to_toml(MOVE))
    return tmp_path


def said(capsys, *words):
    """The one line on standard error of a sweep that is refused, without the name of the command."""
    assert main(["sweep", *words]) == 2
    out, error = capsys.readouterr()
    assert out == ""
    assert error.count("\n") == 1
    return error.removeprefix("cogging: ").rstrip("\n")


@pytest.mark.parametrize(("text", "answer"), FAULTY)
def test_each_rule_is_one_line_and_nothing_is_written(text, answer, folder, capsys):
    (folder / "sweep.toml").write_text(text)
    before = sorted(folder.iterdir())
    pattern = re.escape(f"sweep.toml: {answer}").replace(r"\.\*", ".*").replace(r"\\\+", r"\+")
    assert re.match(pattern, said(capsys, "sweep.toml", "--threads", "1"))
    assert sorted(folder.iterdir()) == before


def test_every_field_has_a_rule_that_was_tried():
    told = {answer.partition(": ")[0] for _, answer in FAULTY} | {answer.split(": ")[1] for _, answer in FAULTY}
    assert set(KEYS) - {"stop"} <= {name.partition(".")[0] for name in told}  # start is held against stop


@pytest.mark.parametrize("seed", range(12))
def test_a_sweep_file_with_anything_in_it_is_no_traceback(seed, folder, capsys):
    """One value of a good file at random is another's, or of another kind: done, or one line."""
    rng = random.Random(seed)
    good = parse_toml(
        f'{FILES}method = "sobol"\nruns = 4\nseed = 1\nduration = 0.1\nstart = 0.0\nstop = 0.08\nfinal_window = 0.05\n'
        'reductions = ["error_final"]\n[vary]\n"axis.mass" = "bounds"\n"controller.kp" = {from = 5e3, to = 9e3}\n'
        '"noise.force" = [0.0, 0.1]\n"axis.viscous" = {mean = 0.2, deviation = 0.01}\n'
    )
    odd = [0, -1, 3, 0.5, float("inf"), float("nan"), True, "", "x", [], ["x"], [1, 2], {}, {"x": 1}, 10**18, 1e300]
    owner = rng.choice([good, good["vary"], good["vary"]["controller.kp"], good["vary"]["axis.viscous"]])
    owner[rng.choice(list(owner))] = rng.choice([*odd, rng.choice(list(good.values()))])
    (folder / "sweep.toml").write_text(to_toml(good))
    status = main(["sweep", "sweep.toml", "--threads", "1"])
    out, error = capsys.readouterr()
    assert (status, out.count("\n") > 9, error.count("\n")) in [(0, True, 0), (2, False, 1)]
    assert (folder / "runs.csv").exists() == (status == 0)
    assert not (folder / "runs.csv.pieces").exists()


def test_paths_without_quotes_and_as_sections_are_paths(folder, capsys):
    texts = [
        f'{FILES}[vary]\n"axis.mass" = [0.1, 0.12]\n"controller.kp" = {{from = 5e3, to = 9e3, points = 2}}\n',
        f"{FILES}[vary]\naxis.mass = [0.1, 0.12]\ncontroller.kp = {{from = 5e3, to = 9e3, points = 2}}\n",
        f"{FILES}[vary.axis]\nmass = [0.1, 0.12]\n[vary.controller.kp]\nfrom = 5e3\nto = 9e3\npoints = 2\n",
    ]
    found = []
    for text in texts:
        (folder / "sweep.toml").write_text(text)
        assert main(["sweep", "sweep.toml", "--out", "runs.csv"]) == 0
        found.append((folder / "runs.csv").read_text())
    assert found[0] == found[1] == found[2]
    assert found[0].startswith("run,axis.mass,controller.kp,seed,")
    assert len(found[0].splitlines()) == 5
    assert "4 runs over axis.mass, controller.kp" in capsys.readouterr().out


def test_a_model_that_cannot_be_run_is_named(folder, capsys):
    (folder / "sweep.toml").write_text(FILES + MASS)
    (folder / "model.toml").write_text(to_toml({**DOCUMENT, "controller": {"type": "pid", "kp": -1.0}}))
    assert said(capsys, "sweep.toml").startswith("model.toml: ")
    (folder / "model.toml").write_text(to_toml({"axis": DOCUMENT["axis"]}))
    assert said(capsys, "sweep.toml") == "model.toml: controller: must be given to run the model, got none"


@pytest.mark.parametrize(
    ("words", "answer"),
    [("--threads 2000", "--threads: must be"), ("--out no/runs.csv", "no/runs.csv: cannot be written")],
)
def test_a_call_that_cannot_run_is_refused_before_anything_runs(words, answer, folder, capsys):
    (folder / "sweep.toml").write_text(FILES + MASS)
    before = {path: path.read_bytes() for path in folder.iterdir()}
    assert said(capsys, "sweep.toml", *words.split()).startswith(answer)
    assert {path: path.read_bytes() for path in folder.iterdir()} == before
