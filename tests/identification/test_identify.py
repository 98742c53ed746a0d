"""identify on simulated logs: truth within the intervals, and nothing stated that the log does not determine."""

import numpy as np
import pytest

import cogging
from cogging import CoggingModel, Log, Model, NoiseParameters, SplineHarmonics, effects, identify, parameters_of
from cogging.cli.main import main
from tests.fixtures import moving_axis
from tests.fixtures.identify_coverage import moves

RATE = 500.0


def machine(*present, width=1e-3, noise=0.02, tables=None, rate=RATE, **axis):
    """An axis of 2 V/(m/s^2) with friction, its PID, a quantised encoder and coloured noise."""
    made = moving_axis.machine(present, noise)
    values = {"viscous": 6.0, "coulomb": 2.0, "coulomb_width": width} | axis
    controller = made.controller.replace(sample_rate=rate)
    return made.replace(axis=made.axis.replace(**values), cogging=tables, controller=controller, uncertainty={})


def prior_of(truth, **changes):
    """What is wrongly believed of a machine."""
    axis = truth.axis.replace(mass=1.9, viscous=7.0, coulomb=1.8)
    return truth.replace(axis=axis, noise=NoiseParameters(), **changes)


def run(truth, reference=None, seed=1, duration=6.0, **options):
    if reference is None:
        reference = moves(np.random.default_rng(seed), 0.4, 0.4, duration, RATE)
    return cogging.simulate(truth, reference, seed=seed, duration=duration, steps_per_sample=10, **options)


def strokes(speed, duration=6.0, distance=0.3, ramp=0.02):
    """Back and forth at one speed, with short ramps."""
    time = np.arange(int(duration * RATE) + 1) / RATE
    turn = distance / speed
    velocity = speed * np.clip(np.sin(2 * np.pi * time / (2 * turn)) / np.sin(np.pi * ramp / turn), -1.0, 1.0)
    position = np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1])) / RATE])
    return cogging.Sampled(time, position, velocity, None)


def sampled(position, duration=6.0):
    time = np.arange(int(duration * RATE) + 1) / RATE
    return cogging.Sampled(time, position(time), None, None)


def check_intervals(found, truth, slack=1.6):
    """The truth lies within the interval of each determined parameter, widened: 95 % intervals miss now and then."""
    true = parameters_of(truth)
    for p in found.parameters:
        if p.determined:
            half = 0.5 * (p.ci95[1] - p.ci95[0])
            assert abs(p.value - true[p.path].value) <= slack * half, (p.path, p.value, p.ci95, true[p.path].value)


@pytest.fixture(scope="module")
def fitted():
    basis = SplineHarmonics(pitch=0.03, harmonics=[1, 2], control_points=1)
    truth = machine(effects.ConstantForce(force=0.5), tables=CoggingModel(basis, [[0.4], [-0.2]], [[0.1], [0.3]]))
    unknown = CoggingModel(basis, np.zeros((2, 1)), np.zeros((2, 1)))
    prior = prior_of(truth, effects=(effects.ConstantForce(),), cogging=unknown)
    log = run(truth)
    return truth, prior, log, identify(log, prior)


def test_a_log_that_the_model_explains(fitted):
    """Truth within the intervals, estimators that agree, the noise alone left, and a replay that repeats the log."""
    truth, prior, _, found = fitted
    assert {p.path for p in found.parameters} == set(parameters_of(truth))
    assert all(p.determined for p in found.parameters)
    check_intervals(found, truth)
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
    assert log.replay["position"] < 1e-4
    assert log.replay["command"] < 0.1
    assert "mass: determined to" in found.text()
    with pytest.raises(KeyError):
        found["axis.nothing"]


# What a log does not determine ----------------------------------------------------------------------------------------


def check_undetermined(found, *paths):
    for path in paths:
        p = found[path]
        assert not p.determined
        assert (p.value, p.ci95, p.output_error) == (p.prior, (-np.inf, np.inf), None)
        assert "not determined" in p.note
        assert found.to_dict()["parameters"][path]["ci95"] is None


def test_viscous_and_quadratic_drag_trade_at_one_speed_and_part_at_many():
    truth = machine(effects.QuadraticDrag(coefficient=6.0), width=0.0, coulomb=0.0, noise=0.1)
    prior = prior_of(truth, effects=(effects.QuadraticDrag(),)).replace(axis=truth.axis.replace(mass=1.9))
    free = ["axis.mass", "axis.viscous", "effects.quadratic_drag.coefficient"]
    narrow = identify(run(truth, strokes(0.2, ramp=0.2)), prior, free=free, rest=0.195)
    check_undetermined(narrow, *free[1:])
    assert "trades against quadratic_drag" in narrow["axis.viscous"].note
    assert "speeds span only a factor 1" in narrow["axis.viscous"].note
    assert narrow["axis.mass"].determined
    check_intervals(narrow, truth)
    wide = identify(run(truth), prior, free=free)
    assert all(p.determined for p in wide.parameters)
    check_intervals(wide, truth)


def test_one_way_motion_does_not_part_friction_from_a_constant_force():
    truth = machine(effects.ConstantForce(force=0.3), width=0.0)
    prior = prior_of(truth, effects=(effects.ConstantForce(),))
    reference = sampled(lambda time: 0.02 * time + 0.0199 / 6.0 * (1 - np.cos(6.0 * time)))
    found = identify(run(truth, reference), prior)
    check_undetermined(found, "axis.coulomb", "effects.constant_force.force")
    assert "the axis moves one way only" in found["axis.coulomb"].note
    assert found["axis.mass"].determined
    assert found["axis.viscous"].determined
    check_intervals(found, truth)


def test_control_points_that_were_not_visited_keep_their_prior():
    basis = SplineHarmonics(pitch=0.05, harmonics=[1], order=3, control_points=12)
    sine = 0.3 + 0.1 * np.sin(np.arange(12.0))[None, :]
    truth = machine(tables=CoggingModel(basis, sine, np.zeros((1, 12))), width=0.0)
    prior = prior_of(truth, cogging=CoggingModel(basis, np.full((1, 12), 0.2), np.zeros((1, 12))))
    found = identify(run(truth, sampled(lambda time: 0.15 - 0.12 * np.cos(1.5 * time))), prior)
    assert found["cogging.sine[0][3]"].determined
    check_undetermined(found, *(f"cogging.sine[0][{column}]" for column in (9, 10, 11)))
    assert found.model.cogging.sine[0, 9:] == pytest.approx(0.2)
    check_intervals(found, truth, slack=2.0)


# Kinds of effects -----------------------------------------------------------------------------------------------------


#: What a machine has, what its model believes, fields to be found with their relative tolerance, noise, and seed.
KINDS = {
    "the place of a spring": (
        [effects.CableSpring(stiffness=8.0, center=0.1)],
        [effects.CableSpring(), effects.ViscousAsymmetry()],  # the asymmetry is not there
        {"cable_spring.stiffness": 0.05, "cable_spring.center": 0.1},
        *(0.02, 2),
    ),
    "the shapes of a harmonic and of friction": (
        [
            effects.CoggingHarmonic(period=0.024, sine=0.5, cosine=0.2),
            effects.StribeckFriction(static_excess=1.0, velocity=0.02),
        ],
        [
            effects.CoggingHarmonic(period=0.0243, sine=0.3, cosine=0.3),
            effects.StribeckFriction(static_excess=0.7, velocity=0.03),
        ],
        {"cogging_harmonic.period": 1e-3, "stribeck_friction.velocity": 0.3},
        *(0.02, 4),
    ),
    "a wrong reading": (
        [effects.EncoderPeriodicError(period=0.02, sine=2e-5, cosine=-1e-5)],
        [effects.EncoderPeriodicError(period=0.02)],
        {"encoder_periodic_error.sine": 0.1, "encoder_periodic_error.cosine": 0.2},
        *(0.005, 6),
    ),
}


@pytest.mark.parametrize("kind", KINDS)
def test_effects_are_found(kind):
    present, believed, fields, noise, seed = KINDS[kind]
    truth = machine(*present, noise=noise)
    found, known = identify(run(truth, seed=seed), prior_of(truth, effects=tuple(believed))), parameters_of(truth)
    for path, tolerance in fields.items():
        assert found[f"effects.{path}"].determined
        assert found[f"effects.{path}"].value == pytest.approx(known[f"effects.{path}"].value, rel=tolerance)
    absent = [effect for effect in believed if effect.NAME not in {one.NAME for one in present}]
    check_intervals(found, truth.replace(effects=(*present, *absent)))


def test_a_second_mass_is_seen_by_the_output_error_alone():
    mode = effects.FlexibleMode(frequency=60.0, damping_ratio=0.05, mass_ratio=0.3)
    truth = machine(mode, noise=0.01, rate=1000.0)
    prior = prior_of(truth, effects=(effects.FlexibleMode(frequency=55.0, damping_ratio=0.05, mass_ratio=0.25),))
    found = identify(run(truth, moves(np.random.default_rng(0), 0.2, 0.8, 6.0, 1000.0), duration=6.0), prior)
    frequency = found["effects.flexible_mode.frequency"]
    assert found.estimator == "output_error"
    assert frequency.inverse_dynamics is None
    assert frequency.determined
    assert frequency.value == pytest.approx(60.0, rel=0.02)
    assert found["effects.flexible_mode.mass_ratio"].value == pytest.approx(0.3, abs=0.08)
    check_intervals(found, truth, slack=2.0)


def test_instruments_keep_noise_in_the_command_from_biasing_a_delay():
    truth = machine(effects.CommandDelay(delay=3e-3))
    log = run(truth, moves(np.random.default_rng(5), 0.4, 0.4, 10.0, RATE), seed=11)
    check_intervals(identify(log, prior_of(truth, effects=(effects.CommandDelay(delay=1e-3),))), truth)


# Kinds of logs --------------------------------------------------------------------------------------------------------


def test_several_logs_are_fitted_together_and_one_by_one(fitted):
    truth, prior, log, single = fitted
    found = identify([log, run(truth, seed=7)], prior)
    check_intervals(found, truth)
    assert len(found.logs) == len(found.audits) == 2
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
        check_intervals(found, truth, slack=1.6 if which is log else 2.5)  # without instruments: a little bias


def test_a_controller_whose_gains_are_stated_wrongly_is_reported_with_those_that_fit(fitted):
    truth, prior, log, right = fitted
    wrong = prior.replace(controller=prior.controller.replace(kp=0.97 * prior.controller.kp))
    found = identify(log, wrong)
    assert "gains that fit the log" in found.controller[0]
    assert "kp 38400 (stated 37248)" in found.controller[0]
    assert found.logs[0].replay["position"] == pytest.approx(right.logs[0].replay["position"], rel=0.05)
    assert found.model.controller == wrong.controller  # what was stated stays
    check_intervals(found, truth)
    assert right.controller == ()


def test_an_added_command_is_known(fitted):
    truth, prior, *_ = fitted
    added = 0.5 * ((np.arange(3001) // 350) % 2)
    found = identify(run(truth, seed=9, added_command=added), prior, added_commands=[added])
    check_intervals(found, truth)
    assert found.controller == ()
    assert found.logs[0].replay["command"] < 0.1


# Calls ----------------------------------------------------------------------------------------------------------------


WRONG = [
    ({"free": []}, "free: must name at least one"),
    ({"free": ["axis.weight"]}, "free: axis.weight: must be one of axis.mass"),
    ({"free": ["effects.command_saturation.limit"]}, "must start from a finite value"),
    ({"free": ["axis.coulomb_width"]}, "must start above 0"),
    ({"cutoff": 400.0}, "cutoff: must be above 0 and at most a fifth of 500"),
    ({"added_commands": [np.zeros(3)]}, r"added_commands: log 1: must have shape \(3001,\)"),
]


@pytest.mark.parametrize(("options", "message"), WRONG)
def test_wrong_calls_are_refused(fitted, options, message):
    _, prior, log, _ = fitted
    unusual = (effects.CommandSaturation(), effects.Backlash())
    model = prior.replace(effects=unusual, axis=prior.axis.replace(coulomb_width=0.0))
    with pytest.raises(ValueError, match=message):
        identify(log, model, **options)


def test_wrong_logs_are_refused(fitted):
    _, prior, log, _ = fitted
    still = Log.of({**log[:300].columns(), "position": np.zeros(300)})
    millimetres = Log.of({**log.columns(), "position": 1e3 * log.position})
    for logs, message in (
        ([], "logs: must be at least 1"),
        (log[:50], "log 1: rows: must be at least 200 to fit a model, got 50"),
        (still, "log 1: position: must move"),
        (log[:210], "in motion, away from the ends"),
        (millimetres, r"log 1: position: spans .* --scale position=0.001"),
    ):
        with pytest.raises(ValueError, match=message):
            identify(logs, prior)


def test_the_command_fits_what_its_options_name(fitted, tmp_path, monkeypatch, capsys):
    _, prior, log, _ = fitted
    monkeypatch.chdir(tmp_path)
    prior.write("prior.toml")
    log.write("log.csv")
    options = ["--rows", "0:1500", "--free", "axis.mass, axis.viscous", "--cutoff", "40", "--out", "fit.toml"]
    assert main(["identify", "log.csv", "--model", "prior.toml", *options]) == 0
    printed = capsys.readouterr().out
    assert all(words in printed for words in ("below 40 Hz", "1500 rows", "axis.viscous"))
    assert "axis.coulomb " not in printed
    assert set(Model.read("fit.toml").intervals) == {"axis.mass", "axis.viscous"}
