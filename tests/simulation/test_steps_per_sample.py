"""The fewest integration steps a sample, as a user asks for them: model file, command line, Python."""

import json

import pytest

import cogging
from cogging.cli.main import main

MODEL = """
[axis]
mass = 0.2
viscous = 1.0
coulomb = 0.1
coulomb_width = 0.001

[controller]
type = "pid"
sample_rate = 1000
kp = 400.0
kd = 10.0
"""
REFERENCE = 'type = "sine"\namplitude = 0.02\nfrequency = 2.0\nduration = 0.2\n'


@pytest.fixture
def files(tmp_path):
    (tmp_path / "ref.toml").write_text(REFERENCE)

    def write(section=""):
        path = tmp_path / "model.toml"
        path.write_text(MODEL + section)
        return path, tmp_path / "ref.toml", tmp_path / "log.csv"

    return write


def simulated(model, reference, log, *options):
    assert main(["simulate", str(model), "--reference", str(reference), "--out", str(log), *options]) == 0
    return cogging.read_log(log)


def test_a_model_file_states_the_fewest_steps(files):
    assert simulated(*files()).metadata["steps_per_sample"] == 1
    stated = files("[simulation]\nsteps_per_sample = 4\n")
    assert simulated(*stated).metadata["steps_per_sample"] == 4
    assert simulated(*stated, "--steps-per-sample", "7").metadata["steps_per_sample"] == 7
    model = cogging.Model.read(stated[0])
    assert model.steps_per_sample == 4
    assert cogging.Model.from_dict(model.to_dict()).steps_per_sample == 4
    assert cogging.simulate(model, stated[1]).metadata["steps_per_sample"] == 4
    assert cogging.simulate(model, stated[1], steps_per_sample=2).metadata["steps_per_sample"] == 2
    assert "simulation" not in model.replace(steps_per_sample=1).to_dict()


@pytest.mark.parametrize("value", ["0", "-1", "10001", "1.5", '"4"', "true", "[4]"])
def test_a_wrong_number_of_steps_is_one_line(value, files, capsys):
    model, reference, log = files(f"[simulation]\nsteps_per_sample = {value}\n")
    assert main(["simulate", str(model), "--reference", str(reference), "--out", str(log)]) == 2
    told = capsys.readouterr().err.strip()
    assert "\n" not in told
    assert "simulation.steps_per_sample: must be a whole number from 1 to 10000, got" in told
    assert not log.exists()


@pytest.mark.parametrize("value", ["0", "10001"])
def test_a_wrong_option_is_one_line(value, files, capsys):
    model, reference, log = files()
    call = ["simulate", str(model), "--reference", str(reference), "--out", str(log), "--steps-per-sample", value]
    assert main(call) == 2
    assert capsys.readouterr().err.startswith("cogging: --steps-per-sample: must be at ")
    assert not log.exists()


def test_the_schema_knows_it(capsys):
    assert main(["schema"]) == 0
    section = json.loads(capsys.readouterr().out)["$defs"]["model"]["properties"]["simulation"]
    assert section["properties"]["steps_per_sample"]["maximum"] == 10_000
