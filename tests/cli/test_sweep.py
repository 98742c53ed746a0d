"""`cogging sweep`: each rule of a sweep file, answered in one line that names file, field, rule and value."""

import pytest

from cogging.cli.main import main
from cogging.outputs import to_toml
from tests.fixtures.sweeps import DOCUMENT, MOVE

FILES = 'model = "model.toml"\nreference = "move.toml"\n'
MASS = '[vary]\n"axis.mass" = [0.1, 0.12]\n'


#: Beginnings of a sweep file, and the error after the name of the file.
FIELDS = [
    ("", "model: must be given, got nothing"),
    (FILES, "vary: must be given, got nothing"),
    (f'{FILES}metod = "grid"\n{MASS}', "line 3: metod: is unknown; did you mean method?"),
    (f'model = "no.toml"\nreference = "move.toml"\n{MASS}', "line 1: model: must be a file .* got 'no.toml'"),
    (f'model = "model.toml"\nreference = "no.toml"\n{MASS}', "line 2: reference: must be a file .* got 'no.toml'"),
    (f"{FILES}vary = 3\n", 'line 3: vary: must be a section or "bounds", got 3'),
    (f'{FILES}vary = "bounds"\n', "vary.axis.mass: must have values, or from, to and points, on a grid"),
    (f"{FILES}start = 1.0\nstop = 0.5\n{MASS}", "line 3: start: must be below stop = 0.5, got 1.0"),
    (f"{FILES}start = 0.2\n{MASS}", "no run could begin: start, stop: must hold at least 2 rows"),
]
#: Values of the fields of a run, in line 3.
VALUES = {
    'method = "gird"': "method: must be one of grid, random, latin_hypercube, sobol, got 'g",
    "seed = -1": "seed: must be from 0 to 4611686018427387904, got -1",
    'reductions = ["eror_max"]': "reductions: 'eror_max' is unknown; did you mean error_max?",
    'reductions = ["error_quantile(2)"]': "reductions: error_.*: must be from 0 to 1, got 2",
}
#: How a number varies, in line 4: path, value, and the error after the path.
VARIED = [
    ("axis.mas", "[1]", "is not a number of this run; did you mean axis.mass?"),
    ("axis.mass", "{from = 1, to = 1}", "from: must be below to = 1, got 1"),
    ("axis.mass", '{from = 0, to = 1, points = 2, scale = "log"}', "from: must be above 0"),
    ("axis.mass", '{from = 1, to = 2, points = 2, scale = "lin"}', "scale: .* got 'lin'"),
    ("axis.coulomb", '"bounds"', "must have a finite interval .* got [0.0, inf]"),
    ("seed", "[1, 1.5]", "must be whole numbers from 0 to 9007199254740992, got 1.5"),
    ("axis.mass", "[0.11]\naxis.mass = [0.13, 0.14]", "must be given once, got "),
]
FAULTY = [
    *FIELDS,
    *((f"{FILES}{text}\n{MASS}", f"line 3: {answer}") for text, answer in VALUES.items()),
    *((f'{FILES}[vary]\n"{path}" = {value}\n', f"line 4: vary.{path}: {answer}") for path, value, answer in VARIED),
    (f'{FILES}[vary]\n"axis.mass" = [-1.0]\n', "no run could begin: .*mass: must be finite and above 0, got -1"),
]


@pytest.fixture
def folder(folder):
    """The folder of tests/cli/conftest.py with another model and reference."""
    (folder / "model.toml").write_text(to_toml(DOCUMENT))
    (folder / "move.toml").write_text(to_toml(MOVE))
    return folder


@pytest.mark.parametrize(("text", "answer"), FAULTY)
def test_each_rule_is_one_line_and_nothing_is_written(text, answer, folder, refused):
    (folder / "sweep.toml").write_text(text)
    refused(["sweep", "sweep.toml", "--threads", "1"], *f"sweep.toml: {answer}".split(".*"))


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


def test_a_model_that_cannot_be_run_is_named(folder, refused):
    (folder / "sweep.toml").write_text(FILES + MASS)
    wrong = {**DOCUMENT, "controller": {"type": "pid", "kp": -1.0}}, {"axis": DOCUMENT["axis"]}
    for model, answer in zip(
        wrong, ("kp: must be", "controller: must be given to run the model, got none"), strict=True
    ):
        (folder / "model.toml").write_text(to_toml(model))
        refused(["sweep", "sweep.toml"], "cogging: model.toml: ", answer)
