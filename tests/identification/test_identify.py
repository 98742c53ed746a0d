"""identify on simulated logs: truth within the intervals, and never found where the log cannot tell."""

import json

import numpy as np
import pytest

import cogging
from cogging import (
    EFFECTS,
    AxisParameters,
    CoggingModel,
    EncoderParameters,
    Log,
    Model,
    NoiseParameters,
    SplineHarmonics,
)
from cogging._core import instruction_sets
from cogging.cli.main import main
from cogging.identification.identification import identify
from tests.fixtures.identify_coverage import moves

RATE = 1000.0


def controller(mass=2.0):
    kp, ki, kd = cogging.pid_gains([-80.0] * 3, mass)
    return cogging.PidParameters(sample_rate=RATE, kp=kp, ki=ki, kd=kd)


def machine(*effects, width=1e-3, noise=0.02, tables=None, **axis):
    """An axis of 2 V/(m/s^2) with friction, its PID, a quantised encoder and coloured noise."""
    values = {"mass": 2.0, "viscous": 6.0, "coulomb": 2.0, "coulomb_width": width} | axis
    return Model(
        axis=AxisParameters(**values),
        cogging=tables,
        effects=effects,
        encoder=EncoderParameters(resolution=1e-7),
        noise=NoiseParameters(force=noise, bandwidth=50.0),
        controller=controller(),
        controller_type="pid",
    )


def prior_of(truth, **changes):
    """What is wrongly believed of a machine."""
    axis = truth.axis.replace(mass=1.9, viscous=7.0, coulomb=1.8)
    return truth.replace(axis=axis, noise=NoiseParameters(), **changes)


def run(truth, reference=None, seed=1, duration=10.0, **options):
    if reference is None:
        reference = moves(np.random.default_rng(seed), 0.4, 0.4, duration, RATE)
    return cogging.simulate(truth, reference, seed=seed, duration=duration, steps_per_sample=10, **options)


def strokes(speed, duration=8.0, distance=0.3, ramp=0.02):
    """Back and forth at one speed, with short ramps."""
    time = np.arange(int(duration * RATE) + 1) / RATE
    turn = distance / speed
    velocity = speed * np.clip(np.sin(2 * np.pi * time / (2 * turn)) / np.sin(np.pi * ramp / turn), -1.0, 1.0)
    position = np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1])) / RATE])
    return cogging.Sampled(time, position, velocity, None)


def holds(found, truth, slack=1.6):
    """Every determined parameter's truth lies within its interval, widened: 95 % intervals miss now and then."""
    true = cogging.parameters_of(truth)
    for p in found.parameters:
        if p.determined:
            half = 0.5 * (p.ci95[1] - p.ci95[0])
            assert abs(p.value - true[p.path].value) <= slack * half, (p.path, p.value, p.ci95, true[p.path].value)


def spring(stiffness=0.0):
    return EFFECTS["cable_spring"](stiffness=stiffness, center=0.0)


# What it finds --------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def fitted():
    basis = SplineHarmonics(pitch=0.03, harmonics=[1, 2], control_points=1)
    truth = machine(EFFECTS["constant_force"](force=0.5), tables=CoggingModel(basis, [[0.4], [-0.2]], [[0.1], [0.3]]))
    prior = prior_of(
        truth, effects=(EFFECTS["constant_force"](),), cogging=CoggingModel(basis, np.zeros((2, 1)), np.zeros((2, 1)))
    )
    log = run(truth)
    return truth, prior, log, identify(log, prior)


def test_a_log_that_the_model_explains(fitted):
    """Truth within the intervals, estimators that agree, the noise alone left, and a replay that repeats the log."""
    truth, prior, _, found = fitted
    assert {p.path for p in found.parameters} == set(cogging.parameters_of(truth))
    assert all(p.determined for p in found.parameters)
    holds(found, truth)
    assert found["axis.mass"].value == pytest.approx(2.0, rel=0.01)
    assert found["axis.mass"].prior == prior.axis.mass
    assert found.model.intervals["axis.mass"] == found["axis.mass"].ci95
    assert found.estimator == "inverse_dynamics"
    for p, variance in zip(found.parameters, np.diag(found.covariance), strict=True):
        assert abs(p.difference) < 4.0
        assert p.output_error == pytest.approx(p.inverse_dynamics, abs=5 * (p.ci95[1] - p.ci95[0]))
        assert 1.95 < 0.5 * (p.ci95[1] - p.ci95[0]) / np.sqrt(variance) < 5.0
    assert np.diag(found.correlation) == pytest.approx(1.0)
    assert (np.abs(found.correlation) <= 1.0 + 1e-12).all()
    log = found.logs[0]
    assert log.instruments
    assert log.residual_after < 0.1 * log.residual_before
    assert log.floor < log.residual_after < 0.03
    assert log.residual_free == log.residual_after
    assert log.replay["position"] < 1e-4
    assert log.replay["command"] < 0.1
    assert all(p.path in found.text() for p in found.parameters)
    assert "mass: determined to" in found.text()
    with pytest.raises(KeyError):
        found["axis.nothing"]


def test_only_the_parameters_asked_for_move(fitted):
    truth, _, log, _ = fitted
    prior = truth.replace(axis=truth.axis.replace(mass=1.9))
    found = identify(log, prior, free=["axis.mass"])
    assert [p.path for p in found.parameters] == ["axis.mass"]
    holds(found, truth)
    assert found.model.axis.viscous == prior.axis.viscous


# What a log cannot tell -----------------------------------------------------------------------------------------------


def test_nothing_is_found_at_one_constant_speed():
    truth = machine(EFFECTS["constant_force"](force=0.3), width=0.0)
    prior = prior_of(truth, effects=(EFFECTS["constant_force"](),))
    log = run(truth, strokes(0.1, duration=4.0, distance=1.0, ramp=0.001), duration=4.0)
    log = Log.of({name: column[1000:] for name, column in log.columns().items()})  # all of it at 0.1 m/s
    found = identify(log, prior)
    assert len(found.parameters) == 4
    for p in found.parameters:
        assert not p.determined
        assert p.ci95 == (-np.inf, np.inf)
        assert p.value == p.prior
        assert "not determined" in p.note
    assert found.model.axis == prior.axis
    assert found.to_dict()["parameters"]["axis.mass"]["ci95"] is None
    assert found.text().count("not determined") >= 8
    assert not found.covariance.any()


def test_viscous_and_quadratic_drag_trade_at_one_speed_and_part_at_many():
    truth = machine(EFFECTS["quadratic_drag"](coefficient=6.0), width=0.0, coulomb=0.0, noise=0.1)
    prior = prior_of(truth, effects=(EFFECTS["quadratic_drag"](),)).replace(axis=truth.axis.replace(mass=1.9))
    free = ["axis.mass", "axis.viscous", "effects.quadratic_drag.coefficient"]
    narrow = identify(run(truth, strokes(0.2, ramp=0.2)), prior, free=free, rest=0.195)
    for path in free[1:]:
        assert not narrow[path].determined
        assert narrow[path].value == narrow[path].prior
        assert narrow[path].output_error is None
    assert "trades against quadratic_drag" in narrow["axis.viscous"].note
    assert "speeds span only a factor 1" in narrow["axis.viscous"].note
    assert narrow["axis.mass"].determined
    holds(narrow, truth)
    wide = identify(run(truth), prior, free=free)
    assert all(p.determined for p in wide.parameters)
    holds(wide, truth)


def test_one_way_motion_cannot_tell_friction_from_a_constant_force():
    truth = machine(EFFECTS["constant_force"](force=0.3), width=0.0)
    prior = prior_of(truth, effects=(EFFECTS["constant_force"](),))
    time = np.arange(10001) / RATE
    reference = cogging.Sampled(time, 0.02 * time + 0.0199 / 6.0 * (1 - np.cos(6.0 * time)), None, None)
    found = identify(run(truth, reference), prior)
    for path in ("axis.coulomb", "effects.constant_force.force"):
        assert not found[path].determined
        assert found[path].value == found[path].prior
        assert "the axis moves one way only" in found[path].note
    assert found["axis.mass"].determined
    assert found["axis.viscous"].determined
    holds(found, truth)


def test_control_points_that_were_not_visited_keep_their_prior():
    basis = SplineHarmonics(pitch=0.05, harmonics=[1], order=3, control_points=12)
    sine = 0.3 + 0.1 * np.sin(np.arange(12.0))[None, :]
    truth = machine(tables=CoggingModel(basis, sine, np.zeros((1, 12))), width=0.0)
    prior = prior_of(truth, cogging=CoggingModel(basis, np.full((1, 12), 0.2), np.zeros((1, 12))))
    time = np.arange(10001) / RATE
    found = identify(run(truth, cogging.Sampled(time, 0.15 - 0.12 * np.cos(1.5 * time), None, None)), prior)
    assert found["cogging.sine[0][3]"].determined
    for column in (9, 10, 11):
        assert not found[f"cogging.sine[0][{column}]"].determined
        assert found.model.cogging.sine[0, column] == 0.2
    holds(found, truth, slack=2.0)


# Kinds of effects -----------------------------------------------------------------------------------------------------


#: What a machine has, what its model believes, values to be found with their relative tolerance, noise, and seed.
KINDS = {
    "the place of a spring": (
        [EFFECTS["cable_spring"](stiffness=8.0, center=0.1)],
        [spring(), EFFECTS["viscous_asymmetry"]()],  # the asymmetry is not there
        {"cable_spring.stiffness": (8.0, 0.05), "cable_spring.center": (0.1, 0.1)},
        0.02,
        2,
    ),
    "the shapes of a harmonic and of friction": (
        [
            EFFECTS["cogging_harmonic"](period=0.024, sine=0.5, cosine=0.2),
            EFFECTS["stribeck_friction"](static_excess=1.0, velocity=0.02),
        ],
        [
            EFFECTS["cogging_harmonic"](period=0.0243, sine=0.3, cosine=0.3),
            EFFECTS["stribeck_friction"](static_excess=0.7, velocity=0.03),
        ],
        {"cogging_harmonic.period": (0.024, 1e-3), "stribeck_friction.velocity": (0.02, 0.3)},
        0.02,
        4,
    ),
    "a false reading": (
        [EFFECTS["encoder_periodic_error"](period=0.02, sine=2e-5, cosine=-1e-5)],
        [EFFECTS["encoder_periodic_error"](period=0.02)],
        {"encoder_periodic_error.sine": (2e-5, 0.1), "encoder_periodic_error.cosine": (-1e-5, 0.2)},
        0.005,
        6,
    ),
}


@pytest.mark.parametrize("kind", KINDS)
def test_effects_are_found(kind):
    present, believed, values, noise, seed = KINDS[kind]
    truth = machine(*present, noise=noise)
    found = identify(run(truth, seed=seed), prior_of(truth, effects=tuple(believed)))
    for path, (value, tolerance) in values.items():
        assert found[f"effects.{path}"].value == pytest.approx(value, rel=tolerance)
    for p in found.parameters:
        if p.path.startswith("effects.viscous_asymmetry") and p.determined:
            assert abs(p.value) < 1.6 * 0.5 * (p.ci95[1] - p.ci95[0])
    with_all = joined_truth(truth, believed)
    holds(found, with_all, slack=2.0)


def joined_truth(truth, believed):
    """The machine with the effects that its model believes in beside, at nothing."""
    names = {effect.NAME for effect in truth.effects}
    return truth.replace(effects=(*truth.effects, *(e for e in believed if e.NAME not in names)))


def test_amplifier_delay_and_lists_of_levels():
    nodes = [-0.25, 0.0, 0.25]
    truth = machine(
        EFFECTS["command_delay"](delay=3e-3),
        EFFECTS["position_dependent_friction"](nodes=nodes, levels=[0.4, 0.0, -0.4]),
        noise=0.002,
    )
    prior = prior_of(
        truth,
        effects=(
            EFFECTS["command_delay"](delay=1e-3),
            EFFECTS["position_dependent_friction"](nodes=nodes, levels=[0.0, 0.0, 0.0]),
        ),
    )
    found = identify(run(truth, seed=5), prior)
    assert found["effects.command_delay.delay"].determined
    holds(found, truth, slack=2.0)
    levels = [found[f"effects.position_dependent_friction.levels[{i}]"] for i in range(3)]
    coulomb = found["axis.coulomb"]  # a constant over all nodes and the Coulomb level are one and the same
    assert not (coulomb.determined and all(level.determined for level in levels))
    assert "effects.position_dependent_friction.nodes[0]" not in {p.path for p in found.parameters}


def test_a_second_mass_is_seen_by_the_output_error_alone():
    truth = machine(EFFECTS["flexible_mode"](frequency=60.0, damping_ratio=0.05, mass_ratio=0.3), noise=0.01)
    prior = prior_of(truth, effects=(EFFECTS["flexible_mode"](frequency=55.0, damping_ratio=0.05, mass_ratio=0.25),))
    log = run(truth, moves(np.random.default_rng(0), 0.2, 0.8, 6.0, RATE), duration=6.0)
    found = identify(log, prior)
    assert found.estimator == "output_error"
    assert found["effects.flexible_mode.frequency"].inverse_dynamics is None
    assert found["effects.flexible_mode.frequency"].determined
    assert found["effects.flexible_mode.frequency"].value == pytest.approx(60.0, rel=0.02)
    assert found["effects.flexible_mode.mass_ratio"].value == pytest.approx(0.3, abs=0.08)
    holds(found, truth, slack=2.0)


def test_instruments_keep_noise_in_the_command_from_biasing_a_delay():
    truth = machine(EFFECTS["command_delay"](delay=3e-3))
    log = run(truth, moves(np.random.default_rng(5), 0.4, 0.4, 10.0, RATE), seed=11)
    holds(identify(log, prior_of(truth, effects=(EFFECTS["command_delay"](delay=1e-3),))), truth)


def test_infinite_parameters_settings_and_exact_ones_are_not_free():
    effects = (
        EFFECTS["command_saturation"](),
        EFFECTS["presliding_friction"](),
        EFFECTS["end_effect"](force=0.0, decay_length=0.02),
        EFFECTS["backlash"](),
    )
    truth = machine(*effects, travel=[-0.5, 0.5])
    prior = prior_of(truth).replace(uncertainty={"viscous": 0.0, "coulomb_width": 0.0})
    found = identify(run(truth), prior)
    paths = {p.path for p in found.parameters}
    for path in (
        "effects.command_saturation.limit",
        "effects.presliding_friction.stiffness",
        "effects.backlash.contact_frequency",
        "axis.viscous",
        "axis.coulomb_width",
    ):
        assert path not in paths
    assert not any("travel" in path for path in paths)
    assert found.model.axis.viscous == prior.axis.viscous


# Kinds of logs --------------------------------------------------------------------------------------------------------


def test_several_logs_are_fitted_together_and_one_by_one(fitted):
    truth, prior, log, single = fitted
    found = identify([log, run(truth, seed=7), run(truth, seed=8)], prior)
    holds(found, truth)
    assert len(found.logs) == len(found.audits) == 3
    for p in found.parameters:
        assert p.ci95[1] - p.ci95[0] < 0.9 * (single[p.path].ci95[1] - single[p.path].ci95[0])
        assert 0.0 < p.spread < 6.0 * p.single_sigma
    assert "logs one by one spread by" in found.text()
    assert single["axis.mass"].spread is None


def test_without_a_controller_the_reference_serves_as_instrument_and_without_both_least_squares(fitted):
    truth, prior, log, _ = fitted
    unknown = prior.replace(controller=None, controller_type=None)
    bare = Log(time=log.time, position=log.position, command=log.command)
    for which, model in ((log, unknown), (bare, prior)):
        found = identify(which, model)
        assert found.logs[0].instruments == (which is log)
        assert not found.logs[0].replay
        holds(found, truth, slack=1.6 if which is log else 2.5)  # without instruments: a little bias


def test_jitter_and_gaps(fitted):
    truth, prior, log, whole = fitted
    random = np.random.default_rng(0)
    keep = np.ones(len(log), dtype=bool)
    keep[3000:3080] = keep[7000:7009] = False
    keep[random.random(len(log)) < 0.01] = False
    rows = {name: column[keep] for name, column in log.columns().items()}
    shift = random.uniform(-1e-4, 1e-4, keep.sum())  # the row was read then, and says so
    velocity = np.gradient(rows["position"], rows["time"])
    jittered = Log.of({**rows, "time": rows["time"] + shift, "position": rows["position"] + velocity * shift})
    found = identify(jittered, prior)
    holds(found, truth, slack=2.5)
    assert found.logs[0].rows < whole.logs[0].rows - 150
    assert found.audits[0].gaps > 2


def test_a_log_that_starts_in_mid_motion(fitted):
    truth, prior, log, _ = fitted
    start = int(np.argmax(np.abs(np.gradient(log.position)) * (np.arange(len(log)) < 5000)))
    cut = Log.of({name: column[start:] for name, column in log.columns().items()})
    found = identify(cut, prior)
    holds(found, truth)
    assert found.logs[0].instruments
    assert found.logs[0].replay["position"] < 1e-4


def test_a_controller_whose_gains_are_stated_wrongly_is_shown_with_those_that_fit(fitted):
    truth, prior, log, right = fitted
    wrong = prior.replace(controller=prior.controller.replace(kp=0.97 * prior.controller.kp))
    found = identify(log, wrong)
    assert "gains that fit the log" in found.controller[0]
    assert "kp 38400 (stated 37248)" in found.controller[0]
    assert found.logs[0].replay["position"] == pytest.approx(right.logs[0].replay["position"], rel=0.05)
    assert found.model.controller == wrong.controller  # what was stated stays
    holds(found, truth)
    assert right.controller == ()


def test_a_log_of_another_controller_is_fitted_by_position_and_command(fitted):
    truth, prior, log, _ = fitted
    other = cogging.CascadeParameters(sample_rate=RATE, kp=30.0, kv=50.0)
    found = identify(log, prior.replace(controller=other, controller_type="cascade"))
    assert "did not make this log" in found.controller[0]
    assert not found.logs[0].replay
    holds(found, truth, slack=2.5)


def test_an_added_command_is_told(fitted):
    truth, prior, _, _ = fitted
    added = 0.5 * ((np.arange(10001) // 700) % 2)
    log = run(truth, seed=9, added_command=added)
    found = identify(log, prior, added_commands=[added])
    holds(found, truth)
    assert found.controller == ()
    assert found.logs[0].replay["command"] < 0.1


# Wrong calls ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"free": []}, "free: must name at least one"),
        ({"free": ["axis.weight"]}, "free: axis.weight: must be one of axis.mass"),
        ({"cutoff": 400.0}, "cutoff: must be above 0 and at most a fifth of 1000"),
        ({"rest": -1.0}, "rest: must be at least 0"),
        ({"names": ["a", "b"]}, "names: must be one for each of 1 logs, got 2"),
        ({"added_commands": [None, None]}, "added_commands: must be one for each of 1 logs, got 2"),
        ({"added_commands": [np.zeros(3)]}, r"added_commands: log 1: must have shape \(10001,\)"),
    ],
)
def test_wrong_calls_are_named(fitted, options, message):
    with pytest.raises(ValueError, match=message):
        identify(fitted[2], fitted[1], **options)


def test_wrong_free_parameters_are_named(fitted):
    _, prior, log, _ = fitted
    model = prior.replace(
        effects=(EFFECTS["command_saturation"](), EFFECTS["backlash"]()), axis=prior.axis.replace(coulomb_width=0.0)
    )
    for path, message in (
        ("effects.command_saturation.limit", "must start from a finite value"),
        ("effects.backlash.contact_frequency", "got a setting"),
        ("axis.coulomb_width", "must start above 0"),
    ):
        with pytest.raises(ValueError, match=message):
            identify(log, model, free=[path])


def test_wrong_logs_are_named(fitted):
    _, prior, log, _ = fitted

    def part(rows, **changes):
        return Log.of({name: column[rows] for name, column in log.columns().items()} | changes)

    with pytest.raises(ValueError, match="logs: must be at least 1"):
        identify([], prior)
    with pytest.raises(ValueError, match="log 1: rows: must be at least 200 to fit a model, got 50"):
        identify(part(slice(50)), prior)
    with pytest.raises(ValueError, match="log 1: position: must move"):
        identify(part(slice(300), position=np.zeros(300)), prior)
    with pytest.raises(ValueError, match="in motion, away from the ends"):
        identify(part(slice(210)), prior)
    with pytest.raises(cogging.InputError, match=r"log 1: position: spans .* --scale position=0.001"):
        identify(Log.of({**log.columns(), "position": 1e3 * log.position}), prior)


# The command ----------------------------------------------------------------------------------------------------------


def test_command_prints_writes_and_exits_with_0(fitted, tmp_path, capsys):
    fitted[1].write(tmp_path / "prior.toml")
    fitted[2].write(tmp_path / "log.csv")
    arguments = ["identify", str(tmp_path / "log.csv"), "--model", str(tmp_path / "prior.toml")]
    assert main([*arguments, "--out", str(tmp_path / "fit.toml"), "--json", str(tmp_path / "fit.json")]) == 0
    printed = capsys.readouterr().out
    assert "axis.mass" in printed
    assert "95 % interval" in printed
    model = Model.read(tmp_path / "fit.toml")
    assert model.axis.mass == fitted[3].model.axis.mass
    assert model.intervals["axis.mass"] == fitted[3]["axis.mass"].ci95
    told = json.loads((tmp_path / "fit.json").read_text())
    assert told["parameters"]["axis.mass"]["ci95"] == list(fitted[3]["axis.mass"].ci95)
    assert told["logs"][0]["audit"]["rows"] == 10001
    assert main([*arguments, "--rows", "0:6000", "--free", "axis.mass, axis.viscous", "--cutoff", "40"]) == 0
    printed = capsys.readouterr().out
    assert "below 40 Hz" in printed
    assert "6000 rows" in printed
    assert "axis.coulomb " not in printed


def test_every_instruction_set_finds_the_same_bits(fitted, monkeypatch):
    """As do replays one by one."""
    _, prior, log, _ = fitted
    log = Log.of({name: column[:4000] for name, column in log.columns().items()})
    found = []
    for instructions in ("none", *instruction_sets()):
        monkeypatch.setenv("COGGING_INSTRUCTIONS", instructions)
        found.append(json.dumps(identify(log, prior).to_dict()))
    assert found == found[:1] * len(found)


def test_mass_alone_is_not_determined_where_accelerations_drown_in_the_noise():
    truth = machine(EFFECTS["constant_force"](force=0.3), width=0.0, noise=0.2)
    prior = prior_of(truth, effects=(EFFECTS["constant_force"](),))
    time = np.arange(50001) / RATE
    slow = cogging.Sampled(time, 0.3 * np.sin(2 * np.pi * 0.02 * time), None, None)
    found = identify(run(truth, slow, duration=50.0), prior)
    mass = found["axis.mass"]
    assert not mass.determined
    assert mass.value == found.model.axis.mass == prior.axis.mass
    assert found["axis.coulomb"].determined
    assert found["effects.constant_force.force"].determined
    holds(found, truth)
