"""Gains for an uncertain machine: better on machines not seen, within the limits, and the margins are true."""

import math
import random

import numpy as np
import pytest

import cogging
from cogging import effects
from cogging.design.tuning import Judge
from tests.export.test_control import stable

DOCUMENT = {
    "axis": {"mass": 0.12, "viscous": 0.2, "coulomb": 0.15, "coulomb_width": 5e-3, "travel": [-0.1, 0.5]},
    "cogging": {"pitch": 0.01, "harmonics": [1], "sine": [[0.05]], "cosine": [[0.02]]},
    "encoder": {"resolution": 0.5e-6},
    "controller": {"type": "pid", "kp": 1500.0, "ki": 1e4, "kd": 15.0, "mass": 0.12, "sample_rate": 1000.0},
    "noise": {"force": 0.02},
    "bounds": {"axis.mass": [0.11, 0.135], "axis.viscous": [0.1, 0.3], "axis.coulomb": [0.1, 0.2]},
}
SMALL = cogging.Model.from_dict(DOCUMENT)
MOVE = {"type": "sine", "amplitude": 0.01, "frequency": 5.0, "duration": 0.3}
SINE = cogging.Sine(cogging.SineParameters(amplitude=0.01, frequency=5.0))
KP = {"controller.kp": {"from": 500, "to": 5000}}
GAINS = KP | {"controller.ki": {"from": 1e3, "to": 2e5}, "controller.kd": {"from": 5, "to": 50}}
LIMITS = {"delay_margin": 2e-3, "command_max": {"present": 1.2}}
FEW = {"machines": 2, "held_out": 1}
FIELDS = {
    "pid": {"kp": 1500.0, "kd": 15.0, "ki": 1e4, "command_limit": 3.0},
    "cascade": {"kp": 60.0, "kv": 15.0},
    "speed": {"kp": 10.0},
    "arc": {"error_gain": 80.0, "feedback_gain": 12.0, "disturbance_adaptation": 200.0, "epsilon": 0.1},
    "dcarc": {"error_gain": 80.0, "feedback_gain": 12.0, "cogging_harmonics": [1], "cogging_adaptation": 20.0},
    "output_feedback_arc": {"theta": [8.0, 2.0, 0.0], "theta_min": [4.0, 0.0, -50.0], "gain_1": 60.0, "gain_2": 90.0},
    "observer_based": {"mass": 0.12, "periods": [0.01]},
}


@pytest.fixture(scope="module")
def tuning():
    return cogging.tune(SMALL, MOVE, GAINS, limits=LIMITS, trials=30, machines=3, held_out=3, seed=3)


# Gains ----------------------------------------------------------------------------------------------------------------


def test_tuned_gains_are_better_on_machines_that_were_not_seen(tuning):
    """And by no more than a loop can be at all: a tenth of the error would be another machine."""
    before, after = tuning.present, tuning.tuned
    assert tuning.improved
    for one, other in ((before.drawn, after.drawn), (before.held_out, after.held_out)):
        assert 0.1 * one.error_rms < other.error_rms < 0.7 * one.error_rms
        assert other.command_max <= 1.25 * one.command_max
        assert other.failed == 0
    assert after.drawn.command_max <= 1.2 * before.drawn.command_max
    assert 2e-3 <= after.drawn.delay_margin < before.drawn.delay_margin, "it costs robustness, and no more than allowed"
    assert after.held_out.delay_margin == pytest.approx(after.drawn.delay_margin, rel=0.2)
    assert after.drawn.modulus_margin < before.drawn.modulus_margin
    assert tuning.model.controller.kp == after.gains["controller.kp"] != 1500.0
    assert tuning.model.replace(controller=SMALL.controller) == SMALL


def test_the_same_seed_gives_the_same_tuning_on_any_number_of_threads():
    options = {"limits": LIMITS, "trials": 4, **FEW}
    variants = ({"threads": 1}, {"threads": 3}, {"seed": 1})
    one, other, another = (cogging.tune(SMALL, MOVE, GAINS, **which, **options) for which in variants)
    assert one == other
    assert another.present.drawn != one.present.drawn, "other machines"
    assert (another.trials["controller.kp"][1:] != one.trials["controller.kp"][1:]).all()


def test_each_number_is_that_of_a_run():
    quiet = SMALL.replace(noise=cogging.NoiseParameters())
    found = cogging.tune(quiet, MOVE, GAINS, vary={}, trials=3, **FEW)
    for setting, model in ((found.present, quiet), (found.tuned, found.model)):
        log = cogging.simulate(model, MOVE)
        run = cogging.performance(log)
        assert (setting.drawn.error_rms, setting.drawn.error_max) == (run.error_rms, run.error_max)
        assert setting.drawn.command_chatter == run.command_chatter
        assert setting.drawn.command_max == abs(log.command).max()


def check_front(found, against, sign):
    """The best is the best of the kept trials, and none of them beats a point of the trade-off in both."""
    kept = found.trials["kept"]
    error, other = found.trials["error_rms"][kept], sign * found.trials[against][kept]
    assert found.tuned.drawn.error_rms == error.min()
    assert len(found.front["trial"]) > 2
    for one, cost in zip(found.front["error_rms"], sign * found.front[against], strict=True):
        assert not ((error <= one) & (other < cost)).any()
        assert not ((error < one) & (other <= cost)).any()
    assert (np.diff(found.front["error_rms"]) < 0).all()
    assert (np.diff(sign * found.front[against]) > 0).all()


def test_the_best_keeps_the_limits_and_nothing_beats_the_trade_off(tuning):
    found = tuning
    kept = found.trials["kept"]
    assert 3 < kept.sum() < 30
    assert (found.trials["command_max"][kept] <= 1.2 * found.present.drawn.command_max).all()
    assert found.trials["controller.kp"][0] == 1500.0, "the present gains come first"
    check_front(found, "command_chatter", 1.0)
    assert (found.front["delay_margin"] >= 2e-3 * 0.96).all()
    other = cogging.tune(SMALL, MOVE, GAINS, against="delay_margin", trials=10, seed=1, **FEW)
    check_front(other, "delay_margin", -1.0)
    assert other.front["delay_margin"].max() > 1.3 * other.front["delay_margin"].min()


def test_a_users_own_controller_is_tuned_by_its_arguments():
    class LeadLag:
        sample_rate = 1000.0

        def __init__(self, gain=1500.0, lead=8.0):
            self.gain, self.lead, self.last = gain, lead, None

        def command(self, reference, reading):
            error = reading - reference.position
            change = 0.0 if self.last is None else error - self.last
            self.last = error
            return -self.gain * (error + self.lead * change)

    gains = {"gain": {"from": 500, "to": 5000}, "lead": {"from": 2.0, "to": 20.0, "scale": "linear"}}
    model = SMALL.replace(controller=None, controller_type=None)
    options = {"limits": {"delay_margin": 1.5e-3}, "trials": 8, "machines": 1, "held_out": 1, "duration": 0.2}
    found = cogging.tune(model, SINE, gains, controller=LeadLag, **options)
    assert found.present.gains == {"gain": 1500.0, "lead": 8.0}
    assert found.tuned.held_out.error_rms < 0.8 * found.present.held_out.error_rms
    assert found.tuned.drawn.delay_margin >= 1.5e-3
    assert found.tuned.drawn.modulus_margin is found.model is None


MOTIONS = [
    MOVE,
    {"type": "point_to_point", "distance": 0.02, "velocity": 0.2, "acceleration": 5.0, "jerk": 500.0, "dwell": 0.05},
    {"type": "sampled", "time": [0.0, 0.1, 0.2, 0.3], "reference": [0.0, 0.005, 0.02, 0.02]},
]


@pytest.mark.parametrize("kind", sorted(cogging.CONTROLLERS))
def test_every_controller_is_tuned_by_its_usual_gains(kind):
    """On a drawn motion; the margin of the present gains marks where the loop is lost."""
    rng = random.Random(kind)
    struct = cogging.CONTROLLERS[kind].PARAMETERS
    model = SMALL.replace(controller=struct(**{"sample_rate": 1000.0, **FIELDS[kind]}), controller_type=kind)
    motion, counts = rng.choice(MOTIONS), {"machines": rng.randint(1, 2), "held_out": 1, "seed": rng.randrange(2**20)}
    found = cogging.tune(model, motion, trials=3, quantile=rng.uniform(0.3, 1.0), **counts)
    assert 0.0 < found.tuned.drawn.error_rms <= found.present.drawn.error_rms
    assert found.model.controller_type == kind
    assert found.tuned.gains
    for path, value in found.tuned.gains.items():
        assert found.trials[path].min() <= value <= found.trials[path].max()
        present = found.present.gains[path]
        assert present / 10 <= found.trials[path].min() <= found.trials[path].max() <= 10 * present
        assert path in found.text()
    found.plot()
    delay = found.present.drawn.delay_margin
    assert 1.0 < found.present.drawn.gain_margin < 200.0
    late = model.replace(effects=[effects.CommandDelay(delay=1.15 * delay)])
    assert cogging.tune(late, motion, trials=1, **counts).present.drawn.delay_margin < 0.1 * delay


# Margins --------------------------------------------------------------------------------------------------------------


def reached(model):
    """Indexes and margins of a model's own gains."""
    return cogging.tune(model, SINE, vary={}, trials=1, machines=1, held_out=1, duration=1.0).present.drawn


@pytest.mark.parametrize("kind", ["pid", "cascade"])
def test_margins_are_those_of_the_linear_loop_where_there_is_one(kind):
    """Measured by a force pulse; tests/export/test_control.py holds the linear loop to the simulator."""
    model, loop = stable(np.random.default_rng(3), kind, rigid=True)
    assert reached(model).delay_margin == pytest.approx(loop.margins().delay, rel=0.08)
    later = model.replace(effects=[effects.CommandDelay(delay=1e-3)])
    assert reached(later).gain_margin == pytest.approx(later.to_control().margins().gain, rel=0.06)


def test_an_unstable_linear_loop_has_no_margin():
    found = reached(SMALL.replace(effects=[effects.CommandDelay(delay=0.05)]))
    assert found.modulus_margin == found.delay_margin == 0.0


# What goes wrong ------------------------------------------------------------------------------------------------------


WRONG = [
    ({"controller.kq": {"from": 1, "to": 2}}, {}, r"^gains.controller.kq: is no number of .*mean controller.k[pid]\?"),
    ({}, {}, r"^gains: must name at least one"),
    ({"controller.kp": [1, 2]}, {}, r"^gains.controller.kp: must be a table"),
    ({"controller.kp": {"from": 2, "to": 1}}, {}, r"from: must be below to"),
    (KP, {"limits": {"command_mx": 1.0}}, r"^limits.command_mx: is unknown; did you mean command_max"),
    (KP, {"limits": {"command_max": {"present": "twice"}}}, r"^limits.command_max: must be a number above 0"),
    (KP, {"against": "chater"}, r"^against: is none"),
    (KP, {"duration": -1.0}, r"^duration: must be finite and at least 0"),
    (KP, {"vary": {"controller.kd": [1]}}, r"^vary.controller.kd: .*one for all machines"),
    (KP, {"vary": {"axis.mass": [-1.0]}}, r"^vary: 1000 draws gave no valid machine; the last: .*mass"),
    (KP, {"controller": lambda gain: None}, r"^gains.controller.kp: is no argument of the controller; known: gain"),
]


@pytest.mark.parametrize(("gains", "options", "text"), WRONG)
def test_a_wrong_tuning_is_refused_in_one_line(gains, options, text):
    with pytest.raises(ValueError, match=text) as found:
        cogging.tune(SMALL, MOVE, gains, **{"trials": 2, **FEW, **options})
    assert "\n" not in str(found.value)


def test_limits_that_no_trial_keeps_are_reported_and_nothing_is_best():
    found = cogging.tune(SMALL, MOVE, GAINS, limits={"command_max": 0.1, "delay_margin": 1e-3}, trials=3, **FEW)
    assert found.tuned is found.model is found.to_dict()["tuned"] is None
    assert not found.improved
    least = found.trials["command_max"].min()
    assert f"failed most is command_max: in 3 of 3 trials, at best by {100 * (least / 0.1 - 1):.3g} %" in found.text()
    assert "nearest is controller.kp" in found.text()
    found.plot()


def test_present_gains_that_are_the_best_or_fail_are_reported(tuning):
    gains = {path: {"from": value / 20, "to": 1.02 * value} for path, value in tuning.tuned.gains.items()}
    found = cogging.tune(tuning.model, MOVE, gains, limits={"delay_margin": 2e-3}, trials=3, seed=3, **FEW)
    assert not found.improved
    assert found.tuned == found.present
    assert "the present gains are the best that were tried" in found.notes
    loose = SMALL.replace(controller=SMALL.controller.replace(kp=9e6, kd=400.0))
    found = cogging.tune(loose, MOVE, GAINS, trials=8, **FEW)
    assert (found.present.drawn.failed, found.present.drawn.error_rms) == (2, math.inf)
    assert found.tuned.held_out.failed == 0
    assert "the present gains break a limit: all runs complete" in found.notes


def test_an_interrupted_tuning_continues_with_its_trials(tmp_path, monkeypatch):
    """In the end all is as if it had not been interrupted; the best so far is in the file."""
    out, options = tmp_path / "tuned.toml", {"limits": {"delay_margin": 1e-3}, "trials": 6, "seed": 3, **FEW}
    plain, judged = cogging.tune(SMALL, MOVE, GAINS, **options), Judge.trial

    def interrupt(name):
        if name.startswith("trial 4"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cogging.tune(SMALL, MOVE, GAINS, out=out, progress=interrupt, **options)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["tuned.toml", "tuned.toml.kept"]
    assert cogging.Model.read(out).controller.kp in plain.trials["controller.kp"][:4]
    for other in ({"seed": 4}, {"limits": {}}, {"machines": 4}, {"quantile": 0.5}, {"duration": 0.2}):
        with pytest.raises(cogging.InputError, match=r"tuned\.toml\.kept: holds the work of another call"):
            cogging.tune(SMALL, MOVE, GAINS, out=out, **{**options, **other})
    made = []
    monkeypatch.setattr(Judge, "trial", lambda judge, gains: made.append(gains) or judged(judge, gains))
    found = cogging.tune(SMALL, MOVE, GAINS, out=out, **options)
    assert [gains["controller.kp"] for gains in made] == plain.trials["controller.kp"][4:].tolist()
    assert (found, [p.name for p in tmp_path.iterdir()]) == (plain, ["tuned.toml"])
