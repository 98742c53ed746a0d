"""The command: what it writes, what it says, and its exit status."""

import numpy as np
import pytest

import cogging
import cogging.cli
from cogging.cli.main import main
from cogging.papers.lu2008 import gantry as lu2008
from tests.fixtures.files import MODEL, REFERENCE


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "model.toml").write_text(MODEL)
    (tmp_path / "ref.toml").write_text(REFERENCE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_simulate_writes_a_log(folder, capsys):
    assert main(["simulate", "model.toml", "--reference", "ref.toml", "--out", "log.csv", "--seed", "4"]) == 0
    assert "rows" in capsys.readouterr().out
    log = cogging.read_log("log.csv")
    direct = cogging.simulate("model.toml", "ref.toml", seed=4)
    np.testing.assert_array_equal(log.position, direct.position)
    np.testing.assert_array_equal(log.command, direct.command)
    other = cogging.simulate("model.toml", "ref.toml", seed=5)
    assert not np.array_equal(log.command, other.command)


def test_a_model_without_a_controller_runs_under_an_assumed_one(folder, capsys):
    (folder / "bare.toml").write_text(MODEL[: MODEL.index("[controller]")])
    call = ["--reference", "ref.toml", "--controller", "pid"]
    assert main(["simulate", "bare.toml", *call, "--out", "log.csv"]) == 0
    assert main(["predict", "bare.toml", *call, "--samples", "2"]) == 0
    said = capsys.readouterr().out
    assert said.count("controller: a PID of three poles at 60 1/s at 1000 Hz, for the model's mass\n") == 2
    log = cogging.read_log("log.csv")
    assert cogging.repeat(log).error.tolist() == log.error.tolist()
    poles = [log.metadata["model"]["controller"][gain] for gain in ("kp", "ki", "kd")]
    np.testing.assert_allclose(cogging.pid_poles(*poles, mass=0.12), -60.0, rtol=1e-4)


def bad_calls():
    yield "unknown key", MODEL + "speed = 3\n", REFERENCE, r"model.toml: line 21: controller.speed: is unknown"
    yield "outside", MODEL, REFERENCE.replace("0.1\n", "0.9\n"), "reference: must stay within travel [0, 0.51]"
    yield "diverging", MODEL.replace("48.0", "4800.0"), REFERENCE, "the run diverged at 0."
    yield "no controller", MODEL[: MODEL.index("[controller]")], REFERENCE, "controller: must be given to simulate"
    yield "no reference", MODEL, 'type = "zigzag"\n', "ref.toml: line 1: type: must be one of"


@pytest.mark.parametrize(("case", "model", "reference", "message"), list(bad_calls()), ids=lambda value: value[:14])
def test_a_bad_input_is_one_line_and_status_2(case, model, reference, message, folder, capsys):
    (folder / "model.toml").write_text(model)
    (folder / "ref.toml").write_text(reference)
    assert main(["simulate", "model.toml", "--reference", "ref.toml", "--out", "log.csv"]) == 2
    error = capsys.readouterr().err
    assert message in error, case
    assert error.count("\n") == 1
    assert sorted(path.name for path in folder.iterdir()) == ["model.toml", "ref.toml"], "nothing is left behind"


def write_scan(path, count=510, noise=0.002):
    axis = lu2008.AXES["X"]
    truth = lu2008.cogging_map(axis, lu2008.shipped_amplitudes(axis))
    x = np.arange(count) * 1e-3
    force = truth.force(x) + np.random.default_rng(1).normal(0, noise, count)
    path.write_text("pos,f\n" + "".join(f"{a!r},{b!r}\n" for a, b in zip(x.tolist(), force.tolist(), strict=True)))
    return x, truth


def test_map_writes_a_model_part_and_a_figure(folder, capsys):
    x, truth = write_scan(folder / "scan.csv")
    call = ["map", "scan.csv", "--pitch", "0.05", "--columns", "position=pos,force=f", "--out", "map.toml"]
    assert main(call) == 0
    assert "harmonic" in capsys.readouterr().out
    assert (folder / "map.png").read_bytes().startswith(b"\x89PNG")
    part = cogging.files.read_toml("map.toml")
    fitted = cogging.Model.from_dict({"axis": {"mass": 1.0}, **part}).cogging
    inside = x[20:-20]
    assert np.std(fitted.force(inside) - truth.force(inside)) < 0.1 * np.std(truth.force(inside))
