"""The next command that every command ends with: it can be pasted, it runs, and it leads to a better model."""

import dataclasses
import os
import random
import shlex
import shutil
import subprocess

import numpy as np
import pytest

import cogging
import cogging.diagnosis.diagnosis
from cogging.cli.main import COMMANDS, main
from cogging.cli.next_command import command_line
from tests.fixtures import command_files
from tests.fixtures.command_files import examples_of
from tests.fixtures.drawn_results import drawn_result
from tests.fixtures.hostile_calls import NAMES

# On Windows bash may be one that runs nothing: that of a Linux that is not installed.
pytestmark = pytest.mark.skipif(os.name == "nt" or shutil.which("bash") is None, reason="hints are for a POSIX shell")

SILENT = ("schema", "completion", "help")  # what they print is not for a person, or is itself the advice
#: What stands in the folder for each file that only a user has.
OWN = {"OTHER_LOG.csv": "other.csv", "NEW_LOG.csv": "log.csv", "LOG.csv": "log.csv"}
OWN |= {f"{name.upper()}.toml": f"{name}.toml" for name in ("model", "ref", "limits", "tune")}


@pytest.fixture
def diagnosed(monkeypatch):
    """Give the command a result in place of a diagnosis, and see what it has read."""
    seen, drawn = [], drawn_result(np.random.default_rng(0), "insufficient_excitation")

    def answer(**changes):
        def diagnose(logs, model, **options):
            seen.append((logs, options))
            return dataclasses.replace(drawn, **{"model": model, **changes})

        monkeypatch.setattr(cogging.diagnosis.diagnosis, "diagnose", diagnose)
        return seen

    return answer


def words_of(line, shell="bash"):
    """The words that a shell makes of a line, as the bytes that a program gets."""
    done = subprocess.run([shell, "-c", f"printf '%s\\0' {line}"], capture_output=True, check=True, env={"LC_ALL": "C"})
    return done.stdout.split(b"\0")[:-1]


def run(words, capsys):
    """Run a call; the words of the next one, without `cogging`: the last line, and the only one of its kind."""
    capsys.readouterr()
    assert main(words) == 0, words
    out, err = capsys.readouterr()
    *before, last = out.splitlines()
    assert (err, last[:14]) == ("", "next: cogging "), out
    assert not any(line.startswith("next:") for line in before)
    return [os.fsdecode(word) for word in words_of(last.removeprefix("next: "))][1:]


def filled(words):
    """The words with files of the user's own in the places that are left for them."""
    return [OWN.get(word, word) for word in words]


@pytest.mark.parametrize("command", COMMANDS)
def test_every_example_runs_and_ends_with_a_next_command_that_runs(command, folder, capsys, diagnosed):
    """As the help shows it; what is printed for a program, and the help itself, have none."""
    diagnosed(verdict="named")
    calls = examples_of(command)
    assert calls
    with pytest.raises(SystemExit):
        main([command, "--help"])
    shown = capsys.readouterr().out
    before = {path.name for path in folder.iterdir()}
    for call in calls:
        assert f"\n  {shlex.join(['cogging', *call])}\n" in f"{shown}\n"
        if command in SILENT or "-" in call:
            assert main(call) == 0, call
            out, err = capsys.readouterr()
            assert (bool(out), err, "\nnext: " in out) == (True, "", False)
            continue
        following = run(call, capsys)
        outputs = {call[i + 1] for i, word in enumerate(call) if word in ("--out", "--json", "--report", "--figure")}
        assert all((folder / output).exists() and output not in before for output in outputs), call
        assert following[0] in COMMANDS
        assert following != call
        for word in following:
            assert not word.partition(".")[0].isupper() or word in OWN
        assert main(filled(following)) == 0
        capsys.readouterr()


CALL = "diagnose log.csv --model model.toml"
PLANT = command_files.model().replace(intervals={"axis.mass": [0.11, 0.13]})
UNSURE = PLANT.replace(intervals={"axis.mass": [-np.inf, np.inf]})
EXPERIMENT = "experiment --model {} --limits LIMITS.toml --out experiment.toml"
VERDICTS = [
    ("named", "", PLANT, f"{CALL} --out model_patched.toml"),
    ("named", "--out new.toml", PLANT, f"{CALL} --confirm OTHER_LOG.csv --out new.toml"),
    ("named", "--out new.toml --confirm other.csv", PLANT, "predict new.toml --reference REF.toml"),
    ("named", "--out new.toml --confirm other.csv", UNSURE, EXPERIMENT.format("new.toml")),
    ("unlisted", "", PLANT, f"{CALL} --out model_patched.toml --empirical"),
    ("unlisted", "--out a.toml --empirical", PLANT, f"{CALL} --confirm OTHER_LOG.csv --out a.toml --empirical"),
    ("ambiguous", "", PLANT, f"{CALL} --json result_2.json"),  # result.json is there already
    ("ambiguous", "--json r.json", PLANT, EXPERIMENT.format("model.toml --result r.json --logs log.csv")),
    ("no_gap", "", PLANT, "predict model.toml --reference REF.toml"),
    ("controller_mismatch", "--scale command=1", PLANT, "audit log.csv --model model.toml --scale command=1"),
    ("insufficient_excitation", "", PLANT, EXPERIMENT.format("model.toml")),
]


@pytest.mark.parametrize(("verdict", "options", "model", "expected"), VERDICTS)
def test_what_is_next_after_each_verdict(verdict, options, model, expected, folder, capsys, diagnosed):
    diagnosed(verdict=verdict, model=model)
    following = run([*CALL.split(), *options.split()], capsys)
    assert following == expected.split()
    if following[0] != "experiment":  # which is slow; the chain below runs it
        assert main(filled(following)) == 0


@pytest.mark.parametrize(("rows", "following"), [("0:400", "experiment"), ("0:600", "diagnose")])
def test_a_log_that_diagnose_would_refuse_is_not_given_to_it(rows, following, folder, capsys):
    machine = command_files.model().replace(effects=[cogging.effects.CableSpring(stiffness=3.0, center=0.2)])
    command_files.table(folder / "short.csv", cogging.simulate(machine, command_files.REFERENCE, seed=1).columns())
    assert run(["identify", "short.csv", "--model", "model.toml", "--rows", rows], capsys)[0] == following


def test_one_of_several_logs_confirms(folder, capsys, diagnosed):
    seen = diagnosed(verdict="named")
    following = run(["diagnose", "log.csv", "other.csv", "--model", "model.toml", "--rows", "other.csv:0:900"], capsys)
    assert following[:5] == ["diagnose", "log.csv", "--model", "model.toml", "--confirm"]
    assert main(following) == 0
    (logs, _), (given, options) = seen
    assert [len(logs[0]), len(logs[1])] == [len(given[0]), 900]
    assert len(options["confirm"][0]) == 900


@pytest.mark.parametrize("seed", range(2))
def test_a_misread_column_is_read_right_by_the_next_command(seed, folder, capsys, diagnosed):
    """Whatever was given before, for all files or for this one, and whatever the file is called."""
    draw = random.Random(seed)
    name = draw.choice(["a b.csv", "caf\u00e9's $x.csv", "plain.csv", "-dash.csv"])
    truth = cogging.read_log("log.csv")
    factor, given = draw.choice([-1.0, 1e3]), draw.choice([1.0, 2.0, -0.5, 1e-3])
    columns = {key: np.array(column) for key, column in truth.columns().items()}
    columns["command"] = columns["command"] / factor / given
    command_files.table(folder / name, columns)
    several = draw.random() < 0.5
    words = ["diagnose", f"./{name}", *(["other.csv"] if several else []), "--model", "model.toml"]
    if given != 1.0:
        own = several or draw.random() < 0.5
        words += [f"--scale={name if own else ''}{':' * own}command={given!r}"]
    following = run(words, capsys)
    assert following[0] == "diagnose"
    seen = diagnosed()
    assert main(following) == 0
    (log, *others), _ = seen[0]
    np.testing.assert_allclose(log.command, truth.command, rtol=1e-12)
    for other in others:
        np.testing.assert_array_equal(other.command, cogging.read_log("other.csv").command)


@pytest.mark.parametrize("shell", list(filter(shutil.which, ["bash", "zsh"])))
def test_words_come_back_from_the_shell(shell):
    draw = random.Random("utf-8")
    letters = " '\"\\$`!*?[]{}()<>|&;~#%^\u00e9\u4e2d\U0001f600"
    names = [name for name in NAMES if name.isprintable()]
    names += ["".join(draw.choices(letters, k=draw.randrange(1, 12))) for _ in range(60)]
    assert words_of(command_line(names), shell) == [b"cogging", *map(os.fsencode, names)]
