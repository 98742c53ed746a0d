"""A lead-screw drive at constant speeds: files as theirs with drawn numbers, and theirs."""

import numpy as np
import pytest

from cogging import InputError
from cogging.datasets import tro2021
from tests.fixtures.measured import FOLDER

HEAD = "\ufeffDate:;2020-07-08 21:30:14\nSampling period:;40.000\n;Velocity actual value averaged;Torque actual value\n"


def write(path, rng, rows):
    """A file as the drive's program writes it, with what stands behind its last values: (rows, 3)."""
    table = np.column_stack([np.arange(rows) * 40.0, rng.integers(-9, 200, rows), rng.normal(30.0, 9.0, rows).round(1)])
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [";".join(map(str, row)) for row in table]
    path.write_text(HEAD + "ms;rpm;%\n" + "\n".join([*lines, "800.0;;", ";;", ""]), encoding="utf-8")
    return table


@pytest.mark.parametrize(
    ("seed", "below"), [(0, "."), (1, "tro2021/experiments/driveNo1"), (2, "driveNo1"), (3, "experiments/driveNo1")]
)
def test_every_run_and_its_mean(tmp_path, seed, below):
    rng = np.random.default_rng(seed)
    names = [f"steady_state/0.096kg/{name}" for name in rng.permutation(["2", "n2", "10", "n10", "200"])[:3]]
    names += ["start_stop/50"]
    tables = {name: write(tmp_path / below / f"{name}.csv", rng, int(rng.integers(21, 90))) for name in names}
    files = tro2021.files(tmp_path)
    assert files.keys() == tables.keys()
    for name, table in tables.items():
        run = tro2021.read(files[name])
        np.testing.assert_allclose(run.time, 1e-3 * table[:, 0], rtol=1e-15)
        np.testing.assert_array_equal(run.speed, table[:, 1])
        np.testing.assert_array_equal(run.torque, table[:, 2])
    means = {name: table[20:, 1:].mean(axis=0) for name, table in tables.items() if name.startswith("steady")}
    found = tro2021.steady_speeds(tmp_path)
    np.testing.assert_allclose(np.column_stack(found), [means[name] for name in sorted(means)], rtol=1e-12)


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "must have a row of units"),
        ("ms;rpm;%\n", "rows: must be at least 1"),
        ("ms;rpm;%\n0;1;2\n40;one;2\n", "line 3: must be three finite numbers, got '40;one;2'"),
        ("ms;rpm;%\n0;1;nan\n", "line 2: must be three finite"),
        ("ms;rpm;%\n0;1;2\n40;1;2\n", "rows: must be more than 20, got 2"),
    ],
)
def test_a_broken_run_is_named(tmp_path, text, what):
    path = tmp_path / "steady_state" / "0.096kg" / "n7.csv"
    path.parent.mkdir(parents=True)
    path.write_text(text)
    with pytest.raises(InputError, match=what) as caught:
        tro2021.steady_speeds(tmp_path)
    assert str(path) in str(caught.value)
    path.unlink()
    write(tmp_path / "start_stop" / "50.csv", np.random.default_rng(0), 30)
    with pytest.raises(InputError, match="tro2021: steady_state"):
        tro2021.steady_speeds(tmp_path)


@pytest.mark.data
def test_theirs():
    files = tro2021.files(FOLDER)
    assert len(files) == 34
    speed, torque = tro2021.steady_speeds(FOLDER)
    assert len(speed) == 32
    np.testing.assert_array_equal(np.sort(speed[speed > 0]).round(-1), np.sort(-speed[speed < 0]).round(-1))
    assert np.all(np.sign(torque) == np.sign(speed))
    for rpm, percent in {-10: 28.1, -50: 25.7, -200: 32.6, 2: 36.1, 40: 32.6, 180: 38.6}.items():
        assert abs(torque[np.argmin(abs(speed - rpm))]) == pytest.approx(percent, abs=0.25)
    run = tro2021.read(files["start_stop/200"])
    assert len(run.time) == 500
    assert run.speed.max() == 205
