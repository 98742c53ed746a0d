"""Log files: every number kept, every bad file answered in one line."""

import math

import numpy as np
import pytest

import cogging
from cogging.files import InputError
from tests.fixtures.measured import FOLDER

MODEL = cogging.Model(
    axis=cogging.AxisParameters(mass=0.12, viscous=0.166, coulomb=0.15, coulomb_width=1e-3, travel=[0.0, 0.5]),
    encoder=cogging.EncoderParameters(resolution=0.5e-6),
    controller=cogging.PidParameters(kp=9600.0, ki=1e5, kd=48.0),
    controller_type="pid",
)
REFERENCE = {"type": "point_to_point", "start": 0.1, "distance": 0.02, "velocity": 0.1, "acceleration": 2.0}


@pytest.mark.parametrize(
    "reference",
    [
        REFERENCE,
        "sampled.toml",
        cogging.Sampled(np.linspace(0, 0.5, 40), 0.1 + 0.02 * np.sin(np.linspace(0, 3, 40))),
    ],
    ids=["point_to_point", "a sampled file", "a sampled object"],
)
def test_a_written_log_is_repeated_bit_for_bit(reference, tmp_path, monkeypatch):
    """Whatever the reference was, and although its files are gone."""
    monkeypatch.chdir(tmp_path)
    time = np.linspace(0.0, 0.4, 33)
    rows = "".join(f"{t!r},{0.1 + 0.02 * math.sin(9 * t)!r}\n" for t in time.tolist())
    (tmp_path / "motion.csv").write_text(f"time,reference\n{rows}")
    (tmp_path / "sampled.toml").write_text('type = "sampled"\nfile = "motion.csv"\n')
    model = MODEL.replace(
        noise=cogging.NoiseParameters(force=0.02), encoder=cogging.EncoderParameters(resolution=1e-6, noise=1e-7)
    )
    log = cogging.simulate(
        model, reference, seed=9, steps_per_sample=2, initial_position=0.11, initial_velocity=0.01, duration=0.3
    )
    log.write("log.csv")
    (tmp_path / "motion.csv").unlink()
    (tmp_path / "sampled.toml").unlink()
    again = cogging.repeat(cogging.read_log("log.csv"))
    for name, column in log.columns().items():
        np.testing.assert_array_equal(getattr(again, name), column, err_msg=name)
    np.testing.assert_array_equal(again.true_position, log.true_position)


def test_what_cannot_be_repeated(tmp_path):
    log = cogging.simulate(MODEL, REFERENCE, controller=cogging.Pid(cogging.PidParameters(kp=9000.0, kd=48.0)))
    assert log.metadata["model"]["controller"]["kp"] == 9000.0
    with pytest.raises(ValueError, match="controller: must be the model's"):
        cogging.repeat(log)
    with pytest.raises(ValueError, match="metadata: model: must be there"):
        cogging.repeat(cogging.Log(log.time, log.position, log.command))


def test_columns_scale_and_rows(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("t [ms], qm,vir , extra\n" + "".join(f"{k}, {2 * k}, {3 * k}, x\n" for k in range(10)))
    log = cogging.read_log(
        path,
        columns={"time": "t", "position": "qm", "command": "vir"},
        scale={"time": 1e-3, "command": 35.15},
        rows=slice(2, 5),
    )
    np.testing.assert_array_equal(log.time, [2e-3, 3e-3, 4e-3])
    np.testing.assert_array_equal(log.position, [4, 6, 8])
    np.testing.assert_allclose(log.command, np.array([6, 9, 12]) * 35.15, rtol=1e-15)
    assert log.reference is None
    with pytest.raises(ValueError, match="reference: must be in the log"):
        _ = log.error


def test_a_column_mapped_to_one_that_is_not_there(tmp_path):
    (tmp_path / "log.csv").write_text("time,position,command\n0,1,2\n")
    with pytest.raises(InputError, match="column ref: must be in the header"):
        cogging.read_log(tmp_path / "log.csv", columns={"reference": "ref"})
    with pytest.raises(InputError, match="columns: speed: must be one of time"):
        cogging.read_log(tmp_path / "log.csv", columns={"speed": "v"})


def test_nothing_half_written_is_left(tmp_path):
    log = cogging.simulate(MODEL, REFERENCE)
    (tmp_path / "log.csv.toml").mkdir()
    with pytest.raises(InputError, match=r"log\.csv\.toml: cannot be written"):
        log.write(tmp_path / "log.csv")
    (tmp_path / "log.csv.toml").rmdir()
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(InputError, match=r"must be a CSV, \.mat or \.parquet file to be written, got \.mf4"):
        log.write(tmp_path / "log.mf4")


# --- formats ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".csv", ".mat", ".parquet"])
def test_every_format_that_is_written_is_read_to_the_last_bit(suffix, tmp_path):
    log = cogging.simulate(MODEL, REFERENCE, seed=2)
    log.write(tmp_path / f"log{suffix}")
    again = cogging.read_log(tmp_path / f"log{suffix}", rows=slice(10, 500))
    for name, column in log.columns().items():
        np.testing.assert_array_equal(getattr(again, name), column[10:500], err_msg=name)
    assert again.metadata["seed"] == 2


def test_a_struct_and_a_group_can_be_named(tmp_path):
    from scipy.io import savemat

    columns = {"t": [0.0, 1.0, 2.0], "x": [1, 2, 3], "u": np.array([3.0, 2.0, 1.0], dtype=np.float32)}
    savemat(tmp_path / "log.mat", {"log": columns, "gain": 3.0})
    names = {"time": "log.t", "position": "log.x", "command": "log.u"}
    log = cogging.read_log(tmp_path / "log.mat", columns=names, scale={"command": 10.0})
    np.testing.assert_array_equal(log.command, [30.0, 20.0, 10.0])
    import h5py

    with h5py.File(tmp_path / "log73.mat", "w", userblock_size=512) as file:
        for name, values in columns.items():
            file[f"log/{name}"] = np.asarray(values)[None, :]
    log = cogging.read_log(tmp_path / "log73.mat", columns=names)
    np.testing.assert_array_equal(log.position, [1.0, 2.0, 3.0])


@pytest.mark.parametrize("version", ["3.30", "4.10"])
def test_asam_mdf(version, tmp_path):
    pytest.importorskip("asammdf")
    from asammdf import MDF, Signal

    time = np.arange(50) * 1e-3
    with MDF(version=version) as mdf:
        units = {"qm": "m", "u": "V"}
        mdf.append([Signal(k * time, time, name=name, unit=unit) for k, (name, unit) in enumerate(units.items(), 1)])
        mdf.append([Signal(time[::5], time[::5], name="temperature", unit="K")])
        path = mdf.save(tmp_path / "log.dat", overwrite=True)
    log = cogging.read_log(path, columns={"position": "qm", "command": "u"})
    np.testing.assert_allclose(log.time, time, rtol=1e-12, atol=1e-15)
    np.testing.assert_array_equal(log.command, 2 * time)
    with pytest.raises(InputError, match="must stand in one channel group"):
        cogging.read_log(path, columns={"position": "qm", "command": "temperature"}, scale={"command": 1.0})


@pytest.mark.data
def test_real_file_with_lines_before_the_header_and_a_row_of_units():
    path = FOLDER / "tro2021/experiments/driveNo1/start_stop/200.csv"
    names = {"velocity": "Velocity actual value averaged", "force": "Torque actual value averaged"}
    with pytest.raises(InputError, match="unit 'rpm'"):
        cogging.logs.log.read_columns(path, ("velocity", "force"), columns=names)
    table = cogging.logs.log.read_columns(
        path, ("velocity", "force"), columns=names, scale={"velocity": np.pi / 30.0, "force": 0.01}
    )
    assert table["velocity"].size == 500
    assert table["velocity"].max() == pytest.approx(205 * np.pi / 30.0)
