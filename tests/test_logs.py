"""Log files: every number kept, every bad file answered in one line."""

import numpy as np
import pytest

import cogging
from cogging.files import InputError, parse_toml

MODEL = cogging.Model(
    axis=cogging.AxisParameters(mass=0.12, viscous=0.166, coulomb=0.15, coulomb_width=1e-3, travel=[0.0, 0.5]),
    encoder=cogging.EncoderParameters(resolution=0.5e-6),
    controller=cogging.PidParameters(kp=9600.0, ki=1e5, kd=48.0),
    controller_type="pid",
)
REFERENCE = {"type": "point_to_point", "start": 0.1, "distance": 0.02, "velocity": 0.1, "acceleration": 2.0}


def test_a_written_log_is_read_to_the_last_bit(tmp_path):
    log = cogging.simulate(MODEL, REFERENCE)
    log.write(tmp_path / "log.csv")
    again = cogging.read_log(tmp_path / "log.csv")
    for name, column in log.columns().items():
        np.testing.assert_array_equal(getattr(again, name), column, err_msg=name)
    assert not list(tmp_path.glob("*.part")), "nothing half written is left"


def test_a_run_can_be_repeated_from_its_log(tmp_path):
    model = MODEL.replace(
        noise=cogging.NoiseParameters(force=0.02), encoder=cogging.EncoderParameters(resolution=1e-6, noise=1e-7)
    )
    log = cogging.simulate(model, REFERENCE, seed=7)
    log.write(tmp_path / "log.csv")
    told = cogging.read_log(tmp_path / "log.csv").metadata
    assert told["version"] == cogging.__version__
    again = cogging.simulate(cogging.Model.from_dict(told["model"]), told["reference"], seed=told["seed"])
    np.testing.assert_array_equal(again.position, log.position)
    np.testing.assert_array_equal(again.command, log.command)


def test_metadata_stand_beside(tmp_path):
    cogging.simulate(MODEL, REFERENCE, seed=3).write(tmp_path / "log.csv")
    document = parse_toml((tmp_path / "log.csv.toml").read_text())
    assert document["seed"] == 3
    assert document["model"]["axis"]["mass"] == 0.12


def test_columns_scale_and_rows(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("t , qm,vir , extra\n" + "".join(f"{k}, {2 * k}, {3 * k}, x\n" for k in range(10)))
    log = cogging.read_log(
        path, columns={"time": "t", "position": "qm", "command": "vir"}, scale={"command": 35.15}, rows=slice(2, 5)
    )
    np.testing.assert_array_equal(log.time, [2, 3, 4])
    np.testing.assert_array_equal(log.position, [4, 6, 8])
    np.testing.assert_allclose(log.command, np.array([6, 9, 12]) * 35.15, rtol=1e-15)
    assert log.reference is None
    with pytest.raises(ValueError, match="reference: must be in the log"):
        _ = log.error


BAD = {
    "missing column": ("time,position\n0,1\n", r"column command: must be in the header, which has time, position"),
    "text": ("time,position,command\n0,1,2\n1,abc,2\n", r"line 3: position: must be a finite number, got 'abc'"),
    "nan": ("time,position,command\n0,1,2\n1,2,nan\n", r"line 3: command: must be a finite number, got 'nan'"),
    "truncated": ("time,position,command\n0,1,2\n1,2\n", r"line 3: command: must be there, got 2 columns"),
    "repeated time": (
        "time,position,command\n0,1,2\n0,1,2\n",
        r"row 1: time: must be strictly increasing, got 0 after 0",
    ),
    "no rows": ("time,position,command\n", r"rows: must be at least 1, got 0"),
    "empty": ("", r"column time: must be in the header, which has none"),
}


@pytest.mark.parametrize("case", sorted(BAD))
def test_a_bad_log_is_answered_in_one_line(case, tmp_path):
    text, message = BAD[case]
    (tmp_path / "log.csv").write_text(text)
    with pytest.raises(InputError, match=rf"log\.csv: {message}"):
        cogging.read_log(tmp_path / "log.csv")


def test_a_column_mapped_to_one_that_is_not_there(tmp_path):
    (tmp_path / "log.csv").write_text("time,position,command\n0,1,2\n")
    with pytest.raises(InputError, match="column ref: must be in the header"):
        cogging.read_log(tmp_path / "log.csv", columns={"reference": "ref"})
    with pytest.raises(InputError, match="columns: speed: must be one of time"):
        cogging.read_log(tmp_path / "log.csv", columns={"speed": "v"})


def test_a_log_that_cannot_be_written(tmp_path):
    log = cogging.simulate(MODEL, REFERENCE)
    with pytest.raises(InputError, match="cannot be written"):
        log.write(tmp_path / "nowhere" / "log.csv")
