"""The predicted tracking error: how often it is right, what moves it, and what is refused."""

import json
import math

import numpy as np
import pytest

import cogging
from cogging.cli.main import main
from cogging.design import error_prediction
from cogging.design.error_prediction import drawn_machines, predict_error
from cogging.model.intervals import Intervals
from cogging.model.parameters import with_values

SAMPLE_RATE = 1000.0
WIDTHS = {"axis.mass": 0.02, "axis.viscous": 0.06, "axis.coulomb": 0.05, "cogging.sine[0][0]": 0.03}
REFERENCE = {"type": "sine", "center": 0.25, "amplitude": 0.02, "frequency": 4.0, "duration": 0.75}


def machine(width=1.0, **changes):
    """An axis whose intervals are `width` times WIDTHS on either side, under a PID that knows its mass only roughly."""
    basis = cogging.SplineHarmonics(pitch=0.03, harmonics=[1])
    fields = {
        "axis": cogging.AxisParameters(mass=0.12, viscous=0.166, coulomb=0.15, coulomb_width=2e-3, travel=[0.0, 0.5]),
        "cogging": cogging.CoggingModel(basis, [[0.1]], [[0.05]]),
        "encoder": cogging.EncoderParameters(resolution=1e-6),
        "noise": cogging.NoiseParameters(force=0.005, bandwidth=50.0),
        "controller": cogging.PidParameters(sample_rate=SAMPLE_RATE, kp=2400.0, ki=4e4, kd=36.0, mass=0.1),
        "controller_type": "pid",
    }
    fields |= changes
    made = cogging.Model(**fields)
    values = Intervals(made)
    ends = {path: (values.value(path) - width * w, values.value(path) + width * w) for path, w in WIDTHS.items()}
    return made.replace(intervals=made.intervals or ends)


def held_out_rms(count, seed):
    """The rms error of machines drawn here, by numpy alone, as `simulate` runs them."""
    rng = np.random.default_rng(seed)
    found = []
    while len(found) < count:
        mass, viscous, coulomb, sine = (
            rng.normal(value, width / 1.96)
            for value, width in zip((0.12, 0.166, 0.15, 0.1), WIDTHS.values(), strict=True)
        )
        if min(mass, viscous, coulomb) < 0.0:
            continue
        base = machine()
        truth = base.replace(
            axis=base.axis.replace(mass=mass, viscous=viscous, coulomb=coulomb),
            cogging=cogging.CoggingModel(base.cogging.basis, [[sine]], [[0.05]]),
        )
        log = cogging.simulate(truth, REFERENCE, seed=int(rng.integers(2**40)))
        found.append(np.sqrt(np.mean(log.error[log.time >= 0.5 - 1e-9] ** 2)))
    return np.array(found)


def test_intervals_hold_the_errors_of_machines_drawn_elsewhere():
    """In 20 predictions of 40 machines against 200 others: 95 % within, and half of them below the median."""
    truths = held_out_rms(200, seed=11)
    inside, below = [], []
    for seed in range(20):
        found = predict_error(machine(), REFERENCE, ["own"], seed=seed)["own"].rms
        low, high = found.interval
        inside.append(np.mean((truths >= low) & (truths <= high)))
        below.append(np.mean(truths < found.median))
    # sigma: sqrt(0.95 0.05 / 200) of the machines and sqrt(0.95 0.05 / 42 / 20) of the predictions.
    assert abs(np.mean(inside) - 0.95) < 3 * math.hypot(0.0154, 0.0075)
    # A median of 40 varies by sqrt(0.25 / 40), that of 20 of them together by less than a quarter of it.
    assert abs(np.mean(below) - 0.5) < 3 * math.hypot(math.sqrt(0.25 / 200), math.sqrt(0.25 / 40 / 20))


def test_an_exact_model_without_noise_has_one_error():
    exact = machine(0.0, noise=cogging.NoiseParameters())
    found = predict_error(exact, REFERENCE, ["own"], samples=3)["own"]
    log = cogging.simulate(exact, REFERENCE)
    last = log.error[log.time >= 0.5 - 1e-9]
    assert found.rms.interval == (found.rms.median, found.rms.median)
    assert found.rms.median == pytest.approx(np.sqrt(np.mean(last**2)), rel=1e-12)
    assert found.max.median == np.abs(last).max()
    assert found.max_whole.median == np.abs(log.error).max()


def test_seeds_threads_and_samples():
    def values(**arguments):
        return predict_error(machine(), REFERENCE, ["own", "pid"], **{"samples": 8, **arguments})["pid"].rms.values

    first = values()
    np.testing.assert_array_equal(first, values(threads=3))
    np.testing.assert_array_equal(first, values(threads=1))
    np.testing.assert_array_equal(first, values(samples=12)[:8])
    assert not np.any(first == values(seed=1))


@pytest.mark.parametrize("duration", [0.75, 0.3])  # s: the last period of three, and the whole of one and a bit
def test_each_sample_is_the_run_of_its_machine(duration):
    """What is kept of it makes the machine anew, and its run gives its indexes to the last bit."""
    controllers = {"own": machine().make_controller(), "weak": cogging.Pid(machine().controller.replace(kp=1500.0))}
    found = predict_error(machine(), REFERENCE, controllers, samples=9, seed=4, duration=duration)
    drawn = found.machines
    assert set(drawn) == {*WIDTHS, "seed"}
    assert all(len(values) == len(set(values)) == 9 for values in drawn.values())
    frame = found.to_pandas()
    assert len(frame) == 18
    for row in frame.to_dict("records"):
        values = {path: row[path] for path in WIDTHS}
        assert values == {path: drawn[path][row["machine"]] for path in WIDTHS}
        model = with_values(machine(), values)
        motion = {**REFERENCE, "duration": duration}
        log = cogging.simulate(model, motion, controller=controllers[row["controller"]], seed=row["seed"])
        said = cogging.performance(log.time, log.error, log.command, start=found.window[0])
        assert (row["rms"], row["max"]) == (said.error_rms, said.error_max)
        assert row["max_whole"] == np.abs(log.error).max()
        assert row["rms"] == found[row["controller"]].rms.values[row["machine"]]


def test_few_rows_at_a_time_change_nothing(monkeypatch):
    whole = predict_error(machine(), REFERENCE, ["own"], samples=7)
    monkeypatch.setattr(error_prediction, "ROWS_MOST", 1600.0)  # two runs
    assert predict_error(machine(), REFERENCE, ["own"], samples=7) == whole


def test_all_controllers_of_the_library_are_predicted():
    found = predict_error(machine(), REFERENCE, samples=3, bandwidth=200.0)
    assert [entry.name for entry in found.controllers] == ["own", *error_prediction.DESIGNED]
    errors = {entry.name: entry.rms.median for entry in found.controllers}
    assert max(errors.values()) < 1e-3
    assert errors["dcarc"] < errors["own"], "with a cogging model and the right mass"
    assert all(entry.diverged == 0.0 for entry in found.controllers)
    assert found.window == pytest.approx((0.5, 0.75))


def test_without_the_design_extra_the_observer_is_left_out(monkeypatch):
    def missing(problem):
        raise ImportError("cvxpy is not installed: pip install 'cogging[design]'")

    monkeypatch.setattr(error_prediction, "design_observer", missing)
    found = predict_error(machine(), REFERENCE, samples=2)
    assert "observer_based left out: cvxpy is not installed: pip install 'cogging[design]'" in found.notes
    assert [entry.name for entry in found.controllers] == ["own", *error_prediction.DESIGNED[:-1]]
    with pytest.raises(ValueError, match=r"^observer_based: cvxpy is not installed"):
        predict_error(machine(), REFERENCE, ["observer_based"], samples=2)


def test_without_bounds_the_own_controller_is_predicted_and_the_rest_left_out():
    unknown = machine().replace(intervals={"axis.mass": (0.1, 0.14)})
    found = predict_error(unknown, REFERENCE, samples=3)
    assert [entry.name for entry in found.controllers] == ["own"]
    assert any(note.startswith("controllers from the bounds left out: axis.viscous: needs") for note in found.notes)
    assert any("axis.viscous" in note and "taken as exact" in note for note in found.notes)
    with pytest.raises(ValueError, match=r"own left out: controller: must be given .*; controllers from the bounds"):
        predict_error(unknown.replace(controller=None, controller_type=None), REFERENCE, samples=3)


def test_diverged_runs_are_infinite():
    """A derivative gain that a sampled mass bears only if it is heavy: some machines diverge, and are counted."""
    edge = machine(
        controller=cogging.PidParameters(sample_rate=SAMPLE_RATE, kp=2400.0, kd=240.0),
        intervals={"axis.mass": (0.08, 0.16)},
    )
    prediction = predict_error(edge, REFERENCE, ["own"], samples=40)
    found = prediction["own"]
    assert 0.1 < found.diverged < 0.9
    assert np.mean(np.isinf(found.rms.values)) == found.diverged
    assert found.rms.interval[1] == math.inf
    assert math.isfinite(found.rms.interval[0])
    entry = prediction.to_dict()["controllers"][0]
    assert entry["rms"]["interval"][1] is None
    json.dumps(entry, allow_nan=False)


# What is drawn --------------------------------------------------------------------------------------------------------


def test_drawn_machines_are_valid_and_move_only_what_has_an_interval():
    wide = machine(intervals={"axis.coulomb": (-0.3, 0.6), "axis.viscous": (0.166, 0.166), "axis.mass": (0.11, 0.16)})
    machines = drawn_machines(Intervals(wide), 1000, 0)[0]
    assert min(made.model.axis.coulomb for made in machines) >= 0.0
    assert np.std([made.model.axis.coulomb for made in machines]) > 0.1
    mass = np.array([made.model.axis.mass for made in machines])
    assert np.median(mass) == pytest.approx(0.12, abs=1e-3)
    assert np.mean((mass >= 0.11) & (mass <= 0.16)) == pytest.approx(0.95, abs=0.02)
    assert {made.model.axis.viscous for made in machines} == {0.166}
    assert len({made.seed for made in machines}) == 1000


def test_covariance_is_drawn():
    paths = ["axis.viscous", "axis.mass"]
    wanted = np.array([[1e-4, 0.9e-5], [0.9e-5, 1e-6]])
    drawn = [made.model.axis for made in drawn_machines(Intervals(machine()), 2000, 0, (paths, wanted))[0]]
    found = np.cov([[axis.viscous for axis in drawn], [axis.mass for axis in drawn]])
    np.testing.assert_allclose(found, wanted, rtol=0.1)
    assert np.std([axis.coulomb for axis in drawn]) == pytest.approx(0.05 / 1.96, rel=0.05), "by its interval"


def test_an_infinite_interval_is_said_and_what_is_known_is_predicted(folder, capsys):
    """As `identify` leaves a mass that the logs do not determine."""
    known = machine()
    open_ended = known.replace(intervals={**known.intervals, "axis.mass": (-math.inf, math.inf)})
    found = predict_error(open_ended, REFERENCE, samples=4)
    assert found.notes[0].startswith(
        "axis.mass held at 0.12: the interval of the error is unbounded. axis.mass: the logs"
    )
    assert "measure it with a log with larger accelerations" in found.notes[0]
    assert "controllers from the bounds left out: axis.mass" in found.text()
    assert set(found.machines) == {*WIDTHS, "seed"} - {"axis.mass"}
    held = predict_error(
        known.replace(intervals={**known.intervals, "axis.mass": (0.12, 0.12)}), REFERENCE, ["own"], samples=4
    )
    np.testing.assert_array_equal(found["own"].rms.values, held["own"].rms.values)
    given = predict_error(open_ended, REFERENCE, ["own"], samples=4, default={"axis.mass": (0.1, 0.14)})
    assert set(given.machines) == {*WIDTHS, "seed"}
    open_ended.write(folder / "open.toml")
    assert main(["predict", "open.toml", "--reference", "ref.toml", "--samples", "2"]) == 0
    assert "experiment --model open.toml --goal fit" in capsys.readouterr().out


def test_what_trades_against_each_other_spreads_the_error_less():
    """Viscous and Coulomb friction known by their sum only, against both alone and against both wrong alike."""
    paths = ["axis.viscous", "axis.coulomb"]
    sigma = np.array([0.03, 0.03 * 0.4])  # at the 0.4 m/s that the motion mostly has both push alike
    alone = np.diag(sigma**2)
    trade = alone - 0.98 * (np.outer(sigma, sigma) - alone)
    spans = [
        np.ptp(predict_error(machine(), REFERENCE, ["own"], covariance=(paths, matrix), samples=40)["own"].rms.interval)
        for matrix in (alone + 0.98 * (np.outer(sigma, sigma) - alone), alone, trade)
    ]
    assert spans[0] > spans[1] > spans[2]


def test_quantiles_of_few_samples():
    """Order statistic share (n + 1): between two values of 39 the next lies with 38 / 40; fewer cannot say so."""
    for samples, coverage in ((9, 0.8), (39, 0.95)):
        found = predict_error(machine(), REFERENCE, ["own"], samples=samples)
        values = np.sort(found["own"].rms.values)
        assert found["own"].rms.interval == pytest.approx((values[0], values[-1]))
        assert found["own"].rms.median == values[samples // 2]
        assert found.coverage == pytest.approx(coverage)


WINDOWS = {
    "three there and back": ({"distance": 0.1, "dwell": 0.1, "repeats": 3}, 0.0, "last"),
    "one there and back": ({"distance": 0.1, "dwell": 0.1}, 0.0, "whole"),
    "longer than the motion": ({"distance": 0.1, "repeats": 2}, 5.0, "last"),
}


@pytest.mark.parametrize("name", WINDOWS)
def test_window_is_the_last_period_or_the_whole_run(name):
    parameters, duration, kind = WINDOWS[name]
    motion = cogging.PointToPoint(cogging.PointToPointParameters(start=0.1, **parameters))
    found = predict_error(machine(), motion, ["own"], samples=2, duration=duration)
    start = motion.end - motion.period if kind == "last" else 0.0
    assert found.window == pytest.approx((start, duration or motion.end))


# What is refused ------------------------------------------------------------------------------------------------------

REFUSED = {
    "samples": ({"samples": 1}, r"samples: must be a whole number of at least 2, got 1"),
    "seed": ({"seed": -1}, r"seed: must be a whole number of at least 0, got -1"),
    "threads": ({"threads": True}, r"threads: must be a whole number of at least 0, got True"),
    "duration": ({"duration": -1.0}, r"duration: must be finite and at least 0, got -1\.0"),
    "no end": ({"reference": cogging.Sine(cogging.SineParameters())}, r"duration: must be given for a motion without"),
    "name": ({"controllers": ["pdi"]}, r"controllers: each must be one of own, pid, .*, got 'pdi'"),
    "one text": ({"controllers": "pid"}, r"controllers: must be a list of different names, got 'pid'"),
    "none given": ({"controllers": {}}, r"controllers: must be at least one, got none"),
    "bandwidth": ({"controllers": ["pid"], "bandwidth": 0.0}, r"pid: bandwidth: must be finite and above 0, got 0\.0"),
    "default": ({"default": {"axle": (0, 1)}}, r"default\['axle'\]: must be a parameter"),
    "covariance": ({"covariance": (["axis.mass"], [[-1.0]])}, r"covariance: must have no negative eigenvalue"),
    "covariance of nothing": ({"covariance": (["d"], [[1.0]])}, r"covariance: 'd' must be a parameter"),
    "covariance twice": ({"covariance": (["axis.mass"] * 2, np.eye(2))}, r"covariance: each path must be given once"),
    "covariance of one": (
        {"covariance": (["axis.mass"], np.eye(2))},
        r"covariance: must be finite, \(1, 1\), got \(2, 2\)",
    ),
    "covariance askew": ({"covariance": ([*WIDTHS][:2], [[1.0, 0.5], [0.0, 1.0]])}, r"covariance: must be symmetric"),
    "interval beside the value": (
        {"model": machine(intervals={"axis.mass": (0.13, 0.2)})},
        r"axis\.mass: its interval \[0\.13, 0\.2\] must hold the model's value, got 0\.12",
    ),
    "never valid": (
        {"covariance": (["axis.mass", "cogging.sine[0][0]"], [[1e-4, 0], [0, 1e-4]]), "model": "barely"},
        r"bounds: 1000 draws gave no valid machine; the last: viscous: must be finite and at least 0",
    ),
    "leaves the travel": ({"reference": REFERENCE | {"center": 5.0}}, r"reference: "),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refuses(case, monkeypatch):
    arguments, message = REFUSED[case]
    arguments = dict(arguments)
    if arguments.get("model") == "barely":  # every draw of the friction is negative
        monkeypatch.setattr("cogging.design.error_prediction.draw", lambda value, interval, normal: -1.0)
        arguments["model"] = machine()
    call = {"model": machine(), "reference": REFERENCE, "samples": 2, **arguments}
    with pytest.raises(ValueError, match=f"^{message}"):
        predict_error(call.pop("model"), call.pop("reference"), call.pop("controllers", ["own"]), **call)


# The command ----------------------------------------------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path, monkeypatch):
    machine().write(tmp_path / "model.toml")
    lines = [f"{key} = {json.dumps(value)}" for key, value in REFERENCE.items()]
    (tmp_path / "ref.toml").write_text("\n".join(lines))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_predict_prints_and_writes(folder, capsys):
    call = ["predict", "model.toml", "--reference", "ref.toml", "--samples", "3", "--seed", "5", "--json", "out.json"]
    assert main(call) == 0
    shown = capsys.readouterr().out
    assert "rms and max from 0.5 to 0.75 s" in shown
    assert "dcarc" in shown
    assert "out.json written" in shown
    written = json.loads((folder / "out.json").read_text())
    direct = predict_error("model.toml", "ref.toml", samples=3, seed=5)
    assert written == json.loads(json.dumps(direct.to_dict()))
    assert written["samples"] == 3
    assert written["coverage"] == 0.5
    assert written["controllers"][0]["controller"] == "own"
    low, high = written["controllers"][0]["rms"]["interval"]
    assert low <= written["controllers"][0]["rms"]["median"] <= high


def test_wider_intervals_of_the_model_widen_those_of_the_error():
    spans = []
    for width in (0.05, 0.3, 1.0, 2.0):
        found = predict_error(machine(width), REFERENCE, ["own"], samples=60)["own"]
        spans.append([np.ptp(found.rms.interval), np.ptp(found.max.interval)])
    assert np.all(np.diff(spans, axis=0) > 0.0)
    assert spans[-1][0] > 5 * spans[0][0]
