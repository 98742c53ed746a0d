"""What every command with a result prints and writes: for a person, with --quiet, and with --json for a program."""

import contextlib
import json
import math
import os

import pytest

import cogging
from cogging.cli.main import COMMANDS, main
from cogging.papers.result import Reproduction, Row, Table
from tests.fixtures import command_files
from tests.fixtures.commands import diagnose_once, examples_of, of

#: The keys that programs may rely on, as docs/command_line.md has them; a dot leads into an object, [] into a list.
KEYS = {
    "init": "source columns.time.in_file audit.rows motion balance.mass.value units.command options",
    "audit": "[].log [].rows [].duration [].rate [].gaps [].encoder_quantum [].travel [].controller",
    "identify": "warnings explained estimator parameters logs notes",
    "diagnose": "verdict effects unlisted gap.floor gap.before separating_experiment limits nominal",
    "experiment": "goal expected elements limits.velocity taken duration seed notes",
    "map": "cogging.pitch order amplitudes offset coulomb residual_rms noise points notes",
    "predict": "controllers window samples seed coverage notes",
    "tune": "present tuned improved front trials limits machines notes",
    "simulate": "log rows duration seed error_max error_rms error_final_max command_rms",
    "sweep": "out runs failed varied indexes.error_rms.median",
    "export": "form files said",
    "reproduce": "[].paper [].tables",
}
RESULTS = [name for name in COMMANDS if name in KEYS]


def reproduction(paper, progress):
    return Reproduction(paper, [Table("table1", "Table 1", [Row("C1", "e_inf", "m", None, math.nan, "predicted")])], {})


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """What each command printed and wrote, once for a person with --json to a file, with --json -, and with --quiet."""
    answers = {}
    before = os.getcwd()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("cogging.cli.reproduce.reproduce", reproduction)
        diagnose_once(patch)
        for command in RESULTS:
            for way, words in {"file": ["--json", "told.json"], "-": ["--json", "-"], "quiet": ["--quiet"]}.items():
                folder = tmp_path_factory.mktemp(command)
                command_files.write(folder)
                os.chdir(folder)
                try:
                    answers[command, way] = folder, *said([*examples_of(command)[0], *words])
                finally:
                    os.chdir(before)
    return answers


def said(words):
    with contextlib.ExitStack() as stack:
        streams = [stack.enter_context(open(name, "w+", encoding="utf-8")) for name in ("out", "err")]
        stack.enter_context(contextlib.redirect_stdout(streams[0]))
        stack.enter_context(contextlib.redirect_stderr(streams[1]))
        status = main(words)
        for stream in streams:
            stream.seek(0)
        told = [stream.read() for stream in streams]
    for name in ("out", "err"):
        os.remove(name)
    return status, *told


def test_every_command_that_computes_has_keys():
    assert {name for name in COMMANDS if "--json" in of(name)._option_string_actions} == set(KEYS)


@pytest.mark.parametrize("command", RESULTS)
def test_standard_output_is_json_alone_and_that_of_the_file(command, done):
    folder, status, out, err = done[command, "file"]
    assert (status, err) == (0, "")
    named, following = out.splitlines()[-2:]
    assert "told.json" in named.removesuffix(" written").split(", ")
    assert following.startswith("next: cogging ")
    written = (folder / "told.json").read_text()
    _, status, printed, err = done[command, "-"]
    assert (status, err) == (0, "")
    assert printed == written.replace(str(folder), "")
    json.loads(printed, parse_constant=pytest.fail)


@pytest.mark.parametrize("command", RESULTS)
def test_quiet_prints_nothing_and_writes_the_same(command, done):
    folder, status, out, err = done[command, "quiet"]
    assert (status, err) == (0, "")
    assert out == ""
    loud = {path.name for path in done[command, "file"][0].iterdir()}
    assert {path.name for path in folder.iterdir()} == loud - {"told.json"}


@pytest.mark.parametrize("command", RESULTS)
def test_the_keys_stay(command, done):
    document = json.loads(done[command, "-"][2])
    for path in KEYS[command].split():
        value = document
        for key in path.split("."):
            if key == "[]":
                assert value, path
                value = value[0]
            else:
                assert key in value, path
                value = value[key]


def numbers(value):
    if isinstance(value, dict | list):
        for entry in value.values() if isinstance(value, dict) else value:
            yield from numbers(entry)
    elif isinstance(value, float):
        yield value


@pytest.mark.parametrize("command", [name for name in RESULTS if name not in ("export", "reproduce", "sweep")])
def test_numbers_have_all_their_digits(command, done):
    """Not those of a text: most of a result's numbers need more than twelve to come back."""
    found = [value for value in numbers(json.loads(done[command, "-"][2])) if value != round(value, 3)]
    if command == "experiment":  # whose motion is made of round numbers
        assert found
        return
    long = [value for value in found if float(f"{value:.12g}") != value]
    assert len(long) > 0.5 * len(found) > 1


def test_numbers_are_those_of_python(done):
    folder = done["map", "-"][0]
    told = json.loads(done["map", "-"][2])
    rows = [line.split(",") for line in (folder / "scan.csv").read_text().splitlines()[1:]]
    fit = cogging.fit_map([float(a) for a, _ in rows], [float(b) for _, b in rows], pitch=0.05)
    assert told["noise"] == fit.noise
    assert told["amplitudes"][0]["amplitude"] == fit.amplitudes[0].amplitude
    assert told["cogging"]["pitch"] == 0.05


def test_what_is_not_a_number_is_null(done):
    assert json.loads(done["reproduce", "-"][2])[0]["tables"][0]["rows"][0]["simulated"] is None


@pytest.mark.parametrize("command", RESULTS)
def test_an_error_is_told_also_when_quiet(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = [*examples_of(command)[0], "--quiet", "--json", "-"]
    words = ["reproduce", "lu2009", *words[2:]] if command == "reproduce" else words
    assert main(words) == 2
    out, error = capsys.readouterr()
    assert out == ""
    assert (error.startswith("cogging: "), error.count("\n")) == (True, 1)
    assert list(tmp_path.iterdir()) == []


def test_a_file_called_minus_is_written_by_its_path(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    command_files.write(tmp_path)
    assert main(["audit", "log.csv", "--json", "./-"]) == 0
    assert capsys.readouterr().out.splitlines()[-2] == "./- written"
    assert json.loads((tmp_path / "-").read_text())[0]["log"] == "log.csv"


def test_python_prints_nothing(tmp_path, monkeypatch, capsys):
    """What the commands call says what it found to its caller alone."""
    monkeypatch.chdir(tmp_path)
    command_files.write(tmp_path)
    model = cogging.Model.read("model.toml")
    log = cogging.read_log("log.csv")
    cogging.audit(log, model)
    cogging.identify(log, model, free=["axis.mass"])
    cogging.simulate("model.toml", "ref.toml").write("run.csv")
    cogging.predict_error("model.toml", "ref.toml", ["own"], samples=2)
    cogging.sweep(model, "ref.toml", {"axis.mass": [0.11, 0.12]}, duration=0.1)
    cogging.diagnose(cogging.Log(log.time[:600], log.position[:600], log.command[:600]), model)
    assert capsys.readouterr() == ("", "")
