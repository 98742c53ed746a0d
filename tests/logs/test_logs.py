"""Log files: every number is kept, and a simulated log is repeated from its file."""

import math

import h5py
import numpy as np
import pytest
from scipy.io import savemat

import cogging
from cogging.files import InputError
from tests.fixtures import pid_axis

MODEL = pid_axis.MODEL.replace(encoder=cogging.EncoderParameters(resolution=1e-6, noise=1e-7))
REFERENCE = {"type": "point_to_point", "start": 0.1, "distance": 0.02, "velocity": 0.1, "acceleration": 2.0}
SAMPLED = cogging.Sampled(np.linspace(0, 0.5, 40), 0.1 + 0.02 * np.sin(np.linspace(0, 3, 40)))


@pytest.mark.parametrize(
    ("reference", "suffix"), [(REFERENCE, ".csv"), ("sampled.toml", ".mat"), (SAMPLED, ".parquet")]
)
def test_a_written_log_is_read_and_repeated_bit_for_bit(reference, suffix, tmp_path, monkeypatch):
    """Whatever the reference was, and although its files are gone."""
    monkeypatch.chdir(tmp_path)
    time = np.linspace(0.0, 0.4, 33)
    rows = "".join(f"{t!r},{0.1 + 0.02 * math.sin(9 * t)!r}\n" for t in time.tolist())
    (tmp_path / "motion.csv").write_text(f"time,reference\n{rows}")
    (tmp_path / "sampled.toml").write_text('type = "sampled"\nfile = "motion.csv"\n')
    options = {"steps_per_sample": 2, "initial_position": 0.11, "initial_velocity": 0.01, "duration": 0.3}
    log = cogging.simulate(MODEL, reference, seed=9, **options)
    log.write(f"log{suffix}")
    for name in ("motion.csv", "sampled.toml"):
        (tmp_path / name).unlink()
    read = cogging.read_log(f"log{suffix}", rows=slice(10, 200))
    assert read.metadata["seed"] == 9
    again = cogging.repeat(read)
    for name, column in log.columns().items():
        np.testing.assert_array_equal(getattr(read, name), column[10:200], err_msg=name)
        np.testing.assert_array_equal(getattr(again, name), column, err_msg=name)
    np.testing.assert_array_equal(again.true_position, log.true_position)


def test_a_log_of_another_controller_or_without_its_model_is_not_repeated():
    log = cogging.simulate(MODEL, REFERENCE, controller=cogging.Pid(cogging.PidParameters(kp=9000.0, kd=48.0)))
    assert log.metadata["model"]["controller"]["kp"] == 9000.0
    with pytest.raises(ValueError, match="controller: must be the model's"):
        cogging.repeat(log)
    with pytest.raises(ValueError, match="metadata: model: must be there"):
        cogging.repeat(cogging.Log(log.time, log.position, log.command))


def test_a_format_that_is_only_read_is_not_written(tmp_path):
    with pytest.raises(InputError, match=r"must be a CSV, \.mat or \.parquet file to be written, got \.mf4"):
        cogging.simulate(MODEL, REFERENCE).write(tmp_path / "log.mf4")


def test_a_struct_and_a_group_can_be_named(tmp_path):
    columns = {"t": [0.0, 1.0, 2.0], "x": [1, 2, 3], "u": np.array([3.0, 2.0, 1.0], dtype=np.float32)}
    savemat(tmp_path / "struct.mat", {"log": columns, "gain": 3.0})
    with h5py.File(tmp_path / "group.mat", "w", userblock_size=512) as file:
        for name, values in columns.items():
            file[f"log/{name}"] = np.asarray(values)[None, :]
    names = {"time": "log.t", "position": "log.x", "command": "log.u"}
    for name in ("struct.mat", "group.mat"):
        log = cogging.read_log(tmp_path / name, columns=names, scale={"command": 10.0})
        np.testing.assert_array_equal([log.position, log.command], [[1.0, 2.0, 3.0], [30.0, 20.0, 10.0]])
