"""What a log tells about itself, and whether the stated controller made it."""

import json

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from cogging.log_check.encoder_readings import encoder_quantum, find_outliers
from cogging.model.model import CONTROLLERS
from tests.fixtures.measured import FOLDER

AXIS = cogging.AxisParameters(mass=0.12, viscous=0.166, coulomb=0.15, coulomb_width=1e-3, travel=[0.0, 0.5])
REFERENCE = {
    "type": "point_to_point",
    "start": 0.1,
    "distance": 0.05,
    "velocity": 0.2,
    "acceleration": 5.0,
    "jerk": 500.0,
    "dwell": 0.1,
}
PID = cogging.PidParameters(kp=9600.0, ki=1e5, kd=48.0)
FULL = PID.replace(mass=0.12, viscous=0.16, coulomb=0.15, coulomb_width=2e-3)
CASCADE = cogging.CascadeParameters(sample_rate=5000.0, kp=150.0, kv=40.0, mass=0.12)


def make(parameters=PID, kind="pid", resolution=0.5e-6, **more):
    encoder = cogging.EncoderParameters(resolution=resolution)
    return cogging.Model(axis=AXIS, encoder=encoder, controller=parameters, controller_type=kind, **more)


def test_time_base():
    rng = np.random.default_rng(0)
    steps = np.full(9999, 1e-3)
    steps[rng.choice(9999, 300, replace=False)] *= 1.0 + 0.05 * rng.choice([-1.0, 1.0], 300)
    steps[5000] = 0.2
    time = np.concatenate([[0.0], np.cumsum(steps)])
    found = cogging.audit(cogging.Log(time, np.sin(time), np.cos(time)))
    assert found.rate == pytest.approx(1000.0)
    assert found.jitter_share == pytest.approx(0.03, abs=0.001)
    assert found.jitter_rms == pytest.approx(5e-5 * np.sqrt(0.03), rel=0.05)
    assert found.gaps == 1
    assert found.gap_longest == pytest.approx(0.2)
    assert found.gap_times == (pytest.approx(time[5000]),)
    assert found.repeated_times == 0
    assert found.speed[1] == pytest.approx(1.0, abs=0.01), "the gap is no motion"


@pytest.mark.parametrize("kind", ["exact", "spurious readings", "written with 9 digits", "single precision"])
def test_encoder_quantum(kind):
    for quantum in [1e-6, 1e-6 / 3.0, 2.0 * np.pi / 20000] + [5e-8, 2e-10] * (kind != "single precision"):
        rng = np.random.default_rng(1)
        x = 0.25 + 0.2 * np.sin(np.arange(30000) * 1e-3) + 1e-7 * rng.normal(size=30000)
        readings, expected = quantum * np.round(x / quantum), quantum
        if kind == "spurious readings":
            readings += (rng.random(30000) < 0.0002) * 0.4 * quantum
        elif kind == "written with 9 digits":
            readings, expected = np.round(readings, 9), max(quantum, 1e-9)
        elif kind == "single precision":
            readings = readings.astype(np.float32).astype(float)
        assert encoder_quantum(readings) == pytest.approx(expected, rel=1e-3)
    ideal = np.cumsum(np.random.default_rng(2).normal(size=20000)) * 1e-5
    assert encoder_quantum(ideal) == 0.0
    assert encoder_quantum(np.zeros(100)) == encoder_quantum([0.0, 1.0]) == 0.0


def test_motion_and_command():
    log = cogging.simulate(make(PID.replace(command_limit=0.3)), REFERENCE)
    found = cogging.audit(log)
    assert found.encoder_quantum == pytest.approx(0.5e-6)
    assert found.travel == (log.position.min(), log.position.max())
    assert found.speed[1] == pytest.approx(log.true_velocity.max(), rel=0.05)
    assert 1.0 < found.acceleration[1] < 6.0, "not the encoder's noise, differentiated twice: 12500 m/s^2 a count"
    plateau = np.abs(log.command) == 0.3
    assert plateau.sum() > 20
    assert found.saturation_share == pytest.approx(plateau.mean(), abs=0.01)
    assert found.outliers == 0
    free = cogging.audit(cogging.simulate(make(), REFERENCE))
    assert free.saturation_share == 0.0
    assert free.share_at_rest == pytest.approx(0.2 / 0.8, abs=0.1)


def test_outliers():
    log = cogging.simulate(make(), REFERENCE)
    position = log.position.copy()
    position[[700, 1500]] += [3e-3, -2e-3]
    assert find_outliers(position).tolist() == [700, 1500]
    found = cogging.audit(cogging.Log(log.time, position, log.command))
    assert found.outliers == 2
    assert found.outlier_rows == (700, 1500)
    assert found.travel == cogging.audit(log).travel


@pytest.mark.parametrize("kind", sorted(CONTROLLERS))
def test_the_replay_of_a_controller_is_its_run(kind):
    """Every controller, whatever its parameters mean: what it commanded, to the bit."""
    struct, made = CONTROLLERS[kind]
    model = make(struct(), kind)
    motion = cogging.Sine(cogging.SineParameters(center=0.2, amplitude=1e-3, frequency=1.0))
    log = cogging.simulate(model, motion, duration=0.05)
    # The previews of a controller that looks ahead come from the rows, whose last ones see the end of the log.
    command = cogging.replay_controller(
        made(struct()),
        time=log.time,
        reference=log.reference,
        reference_velocity=log.reference_velocity,
        reference_acceleration=log.reference_acceleration,
        position=log.position,
    )
    if hasattr(made, "preview"):
        np.testing.assert_allclose(command[:-2], log.command[:-2], rtol=0, atol=1e-6 * np.abs(log.command).max())
    else:
        np.testing.assert_array_equal(command, log.command)
    with pytest.raises(ValueError, match="position: must be as long as time"):
        cogging.replay_controller(made(struct()), time=log.time, reference=log.reference, position=log.position[1:])


@pytest.mark.parametrize(
    ("parameters", "kind"),
    [
        (PID, "pid"),
        (FULL, "pid"),
        (CASCADE.replace(viscous=0.1, coulomb=0.1, coulomb_width=2e-3), "cascade"),
    ],
)
@pytest.mark.parametrize("first", [0, 1300])
def test_a_stated_controller_that_made_the_log(parameters, kind, first):
    model = make(parameters, kind)
    check = cogging.check_controller(cogging.simulate(model, REFERENCE)[first:], model)
    assert check.reproduces
    assert check.relative < 1e-10
    assert check.best_shift == 0
    assert check.ratio == pytest.approx(1.0)
    for name, stated in check.stated.items():
        assert stated == getattr(parameters, name)
        assert check.fitted[name] == pytest.approx(stated, rel=1e-4)
    if kind == "pid" and first:
        assert abs(check.start) > 1e-3, "the integral at the cut"


def test_a_command_limit_is_replayed_with_its_anti_windup():
    model = make(PID.replace(command_limit=0.3))
    check = cogging.check_controller(cogging.simulate(model, REFERENCE), model)
    assert check.reproduces
    assert check.relative < 1e-12


def test_a_stated_controller_that_did_not():
    log = cogging.simulate(make(), REFERENCE)
    check = cogging.check_controller(log, make(PID.replace(kd=60.0)))
    assert check.reproduces is False
    assert check.fitted["kd"] == pytest.approx(48.0, rel=1e-6)
    assert check.fitted_rms < 1e-10
    late = cogging.Log(log.time[:-2], log.position[:-2], log.command[2:], log.reference[:-2])
    early = cogging.Log(log.time[1:], log.position[1:], log.command[:-1], log.reference[1:])
    assert cogging.check_controller(late, make()).best_shift == -2
    assert cogging.check_controller(early, make()).best_shift == 1
    amperes = cogging.Log(log.time, log.position, 0.5 * log.command, log.reference)
    check = cogging.check_controller(amperes, make())
    assert check.reproduces is False
    assert check.ratio == pytest.approx(0.5)
    assert any("in another unit" in note for note in check.notes)


def test_what_cannot_be_told():
    log = cogging.simulate(make(), REFERENCE)
    assert cogging.audit(log).controller is None
    assert cogging.check_controller(log, make().replace(controller=None, controller_type=None)) is None
    without = cogging.Log(log.time, log.position, log.command)
    check = cogging.check_controller(without, make())
    assert check.reproduces is None
    assert "no reference" in check.notes[0]
    check = cogging.check_controller(log[::5], make())
    assert check.reproduces is None
    assert "1000 rows a second" in check.notes[0]
    adaptive = make(cogging.AdaptiveRobustParameters(mass_adaptation=10.0, coulomb_adaptation=100.0), "arc")
    log = cogging.simulate(adaptive, REFERENCE)
    assert cogging.check_controller(log, adaptive).reproduces


@pytest.mark.parametrize("first", [0, 1300])
@pytest.mark.parametrize(
    ("parameters", "kind"),
    [
        (FULL, "pid"),
        (FULL.replace(feedforward_velocity="measured"), "pid"),
        (CASCADE.replace(coulomb=0.1, coulomb_width=1e-3), "cascade"),
    ],
)
def test_a_controller_is_recovered(parameters, kind, first):
    log = cogging.simulate(make(parameters, kind), REFERENCE)
    found = cogging.recover_controller(log[first:])
    assert found is not None
    assert found.type == kind
    assert found.residual_rms < 1e-6
    for name, value in parameters.to_dict().items():
        if isinstance(value, float):
            assert getattr(found.parameters, name) == pytest.approx(value, rel=1e-4, abs=1e-9), name


def test_a_controller_of_another_kind_is_not_recovered():
    basis = cogging.SplineHarmonics(pitch=0.02, harmonics=[1, 2])
    model = make(cogging.ObserverBasedParameters(mass=0.12, periods=[0.02]), "observer_based")
    model = model.replace(cogging=cogging.CoggingModel(basis, [[0.1], [0.2]], [[0.0], [0.1]]))
    assert cogging.recover_controller(cogging.simulate(model, REFERENCE)) is None
    log = cogging.simulate(make(), REFERENCE)
    noise = 0.02 * np.random.default_rng(3).normal(size=len(log))
    assert cogging.recover_controller(cogging.Log(log.time, log.position, log.command + noise, log.reference)) is None
    assert cogging.recover_controller(cogging.Log(log.time, log.position, log.command)) is None


def test_the_command(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    model = make()
    model.write("model.toml")
    cogging.simulate(model, REFERENCE).write("log.csv")
    assert main(["audit", "log.csv", "--model", "model.toml", "--json", "out.json"]) == 0
    assert "the stated pid reproduces the command" in capsys.readouterr().out
    (answer,) = json.loads((tmp_path / "out.json").read_text())
    assert (answer["log"], answer["controller"]["reproduces"]) == ("log.csv", True)
    assert answer["encoder_quantum"] == pytest.approx(0.5e-6)


# --- a real log -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def emps():
    path = FOLDER / "emps" / "DATA_EMPS.mat"
    return cogging.read_log(path, columns={"time": "t", "position": "qm", "command": "vir", "reference": "qg"})


@pytest.mark.data
def test_real_log(emps):
    controller = cogging.CascadeParameters(sample_rate=1000.0, kp=160.18, kv=243.45, command_limit=10.0)
    found = cogging.audit(emps, make(controller, "cascade"))
    assert found.encoder_quantum == pytest.approx(50e-9, rel=1e-6)
    assert found.rate == pytest.approx(1000.0, rel=1e-4)
    assert found.gaps == 0
    check = found.controller
    assert check.reproduces
    # The data's README: kv kp 40,680, kv 254.5; its residuals count the first row, whose velocity is not known.
    assert check.fitted["kp"] * check.fitted["kv"] == pytest.approx(40680.0, rel=5e-4)
    assert check.fitted["kv"] == pytest.approx(254.5, rel=5e-4)
    assert check.difference_rms == pytest.approx(0.0502, abs=0.0005)
    assert check.fitted_rms == pytest.approx(0.0157, abs=0.0005)
    assert check.best_shift == 0
