"""What every command with a result prints and writes: for a person, with --quiet, and with --json for a program."""

import json
import math

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from cogging.outputs import to_json
from cogging.papers.result import Reproduction, Row, Table
from tests.fixtures import command_files
from tests.fixtures.command_files import examples_of

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


TUNE = {key: value for key, value in command_files.TUNE.items() if key not in command_files.JOB}
PYTHON = {
    "audit": lambda: cogging.audit(cogging.read_log("log.csv")),
    "identify": lambda: cogging.identify(
        cogging.read_log("log.csv"), cogging.Model.read("model.toml"), names=["log.csv"]
    ),
    "map": lambda: cogging.fit_map(
        *np.loadtxt("sensor.csv", delimiter=",", skiprows=1).T * [[1e-3], [1.0]], pitch=0.05, force_sign=-1
    ),
    "predict": lambda: cogging.predict_error("model.toml", "ref.toml"),
    "tune": lambda: cogging.tune("model.toml", "ref.toml", **TUNE),
}


@pytest.mark.parametrize("command", KEYS)
def test_a_result_as_json_alone_on_standard_output(command, folder, monkeypatch, capsys):
    """With its keys, and with the numbers of Python to the last digit."""
    table = Table("table1", "Table 1", [Row("C1", "e_inf", "m", None, math.nan, "predicted")])
    answer = Reproduction("xu2001", [table], {})
    monkeypatch.setattr("cogging.cli.reproduce.reproduce", lambda paper, progress: answer)
    rows = ["--rows", "0:600"] if command == "diagnose" else []  # which is quick
    assert main([*examples_of(command)[command == "map"], *rows, "--quiet", "--json", "-"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    document = json.loads(out, parse_constant=pytest.fail)
    for path in KEYS[command].split():
        value = document
        for key in path.split("."):
            assert value if key == "[]" else key in value, path
            value = value[0 if key == "[]" else key]
    assert command != "reproduce" or document[0]["tables"][0]["rows"][0]["simulated"] is None, "no NaN in JSON"
    if command in PYTHON:
        result = json.loads(to_json(PYTHON[command]().to_dict()))
        assert {key: (document[0] if command == "audit" else document)[key] for key in result} == result


def test_an_error_is_printed_also_when_quiet(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for command in KEYS:
        words = ["reproduce", "lu2009"] if command == "reproduce" else examples_of(command)[0]
        assert main([*words, "--quiet", "--json", "-"]) == 2
        out, error = capsys.readouterr()
        assert (out, error[:9], error.count("\n")) == ("", "cogging: ", 1)
    assert list(tmp_path.iterdir()) == []


def test_json_in_a_file_is_that_of_standard_output(folder, capsys):
    assert main(["audit", "log.csv", "--json", "-"]) == 0
    out = capsys.readouterr().out
    assert main(["audit", "log.csv", "--json", "found.json"]) == 0
    named, following = capsys.readouterr().out.splitlines()[-2:]
    assert (named, following[:14]) == ("found.json written", "next: cogging ")
    assert main(["audit", "log.csv", "--json", "./-", "--quiet"]) == 0, "a file of that name"
    assert capsys.readouterr() == ("", "")
    assert (folder / "found.json").read_text() == (folder / "-").read_text() == out


def test_python_prints_nothing(folder, capsys):
    model, log = cogging.Model.read("model.toml"), cogging.read_log("log.csv")
    cogging.audit(log, model)
    cogging.sweep(model, "ref.toml", {"axis.mass": [0.11, 0.12]}, duration=0.1)
    cogging.diagnose(log[:600], model)
    assert capsys.readouterr() == ("", "")


def test_a_model_without_a_controller_runs_under_an_assumed_one(folder, capsys):
    cogging.Model.read("model.toml").replace(controller=None, controller_type=None).write("bare.toml")
    call = ["--reference", "ref.toml", "--controller", "pid"]
    assert main(["simulate", "bare.toml", *call, "--out", "run.csv"]) == 0
    assert main(["predict", "bare.toml", *call, "--samples", "2"]) == 0
    printed = capsys.readouterr().out
    assert printed.count("controller: a PID of three poles at 60 1/s at 1000 Hz, for the model's mass\n") == 2
    log = cogging.read_log("run.csv")
    assert cogging.repeat(log).error.tolist() == log.error.tolist(), "the same seed"
    poles = [log.metadata["model"]["controller"][gain] for gain in ("kp", "ki", "kd")]
    np.testing.assert_allclose(cogging.pid_poles(*poles, mass=0.12), -60.0, rtol=1e-4)
