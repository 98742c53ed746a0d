"""The predicted tracking error: how often it is right, what moves it, and what is refused."""

import json
import math

import numpy as np
import pytest

import cogging
from cogging import predict_error
from cogging.design import error_prediction

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
        "controller": cogging.PidParameters(sample_rate=1000.0, kp=2400.0, ki=4e4, kd=36.0, mass=0.1),
        "controller_type": "pid",
    }
    made = cogging.Model(**fields | changes)
    values = cogging.parameters_of(made)
    ends = {path: (values[path].value - width * w, values[path].value + width * w) for path, w in WIDTHS.items()}
    return made.replace(intervals=made.intervals or ends)


def own(model, **options):
    """The predicted errors of the model's own controller."""
    return predict_error(model, REFERENCE, ["own"], **options)["own"]


def machine_with(values):
    """The machine with the values of WIDTHS."""
    base, (mass, viscous, coulomb, sine) = machine(), values
    axis = base.axis.replace(mass=mass, viscous=viscous, coulomb=coulomb)
    return base.replace(axis=axis, cogging=cogging.CoggingModel(base.cogging.basis, [[sine]], [[0.05]]))


def test_intervals_hold_the_errors_of_machines_drawn_elsewhere():
    """In 20 predictions of 40 machines against 200 others: 95 % within, and half of them below the median."""
    rng, truths, inside, below = np.random.default_rng(11), [], [], []
    for values in np.abs(rng.normal((0.12, 0.166, 0.15, 0.1), np.array(list(WIDTHS.values())) / 1.96, (200, 4))):
        log = cogging.simulate(machine_with(values), REFERENCE, seed=int(rng.integers(2**40)))
        truths.append(np.sqrt(np.mean(log.error[log.time >= 0.5 - 1e-9] ** 2)))
    for seed in range(20):
        found = own(machine(), samples=40, seed=seed).rms
        low, high = found.interval
        inside.append(np.mean((low <= np.array(truths)) & (np.array(truths) <= high)))
        below.append(np.mean(np.array(truths) < found.median))
    # sigma: sqrt(0.95 0.05 / 200) of the machines and sqrt(0.95 0.05 / 42 / 20) of the predictions.
    assert abs(np.mean(inside) - 0.95) < 3 * math.hypot(0.0154, 0.0075)
    # A median of 40 varies by sqrt(0.25 / 40), that of 20 of them together by less than a quarter of it.
    assert abs(np.mean(below) - 0.5) < 3 * math.hypot(math.sqrt(0.25 / 200), math.sqrt(0.25 / 40 / 20))


def test_seeds_threads_samples_and_rows_at_a_time(monkeypatch):
    def values(**arguments):
        return own(machine(), **{"samples": 8, **arguments}).rms.values

    first = values()
    np.testing.assert_array_equal(first, values(threads=3))
    np.testing.assert_array_equal(first, values(samples=12)[:8])
    assert not np.any(first == values(seed=1))
    monkeypatch.setattr(error_prediction, "ROWS_MOST", 1600.0)  # two runs
    np.testing.assert_array_equal(first, values())


@pytest.mark.parametrize("duration", [0.75, 0.3])  # s: the last period of three, and the whole of one and a bit
def test_each_sample_is_the_run_of_its_machine(duration):
    """What is kept of it makes the machine anew, and its run gives its indexes to the last bit."""
    controllers = {"own": machine().make_controller(), "weak": cogging.Pid(machine().controller.replace(kp=1500.0))}
    found = predict_error(machine(), REFERENCE, controllers, samples=5, seed=4, duration=duration)
    assert set(found.machines) == {*WIDTHS, "seed"}
    assert all(len(set(values)) == 5 for values in found.machines.values())
    frame = found.to_pandas()
    assert len(frame) == 10
    for row in frame.to_dict("records"):
        assert all(row[path] == found.machines[path][row["machine"]] for path in WIDTHS)
        model, motion = machine_with([row[path] for path in WIDTHS]), {**REFERENCE, "duration": duration}
        log = cogging.simulate(model, motion, controller=controllers[row["controller"]], seed=row["seed"])
        run = cogging.performance(log.time, log.error, log.command, start=found.window[0])
        assert (row["rms"], row["max"]) == (run.error_rms, run.error_max)
        assert row["max_whole"] == np.abs(log.error).max()
        assert row["rms"] == found[row["controller"]].rms.values[row["machine"]]


def test_quantiles_of_few_samples():
    """Order statistic share (n + 1): between two values of 39 the next lies with 38 / 40; fewer cannot say so."""
    found = predict_error(machine(), REFERENCE, ["own"], samples=9)
    values = np.sort(found["own"].rms.values)
    assert found["own"].rms.interval == pytest.approx((values[0], values[-1]))
    assert (found["own"].rms.median, found.coverage) == (values[4], pytest.approx(0.8))


def test_diverged_runs_are_infinite():
    """A derivative gain that a sampled mass bears only if it is heavy: some machines diverge, and are counted."""
    controller = cogging.PidParameters(sample_rate=1000.0, kp=2400.0, kd=240.0)
    edge = machine(controller=controller, intervals={"axis.mass": (0.08, 0.16)})
    prediction = predict_error(edge, REFERENCE, ["own"], samples=40)
    found = prediction["own"]
    assert 0.1 < found.diverged < 0.9
    assert np.mean(np.isinf(found.rms.values)) == found.diverged
    assert math.isfinite(found.rms.interval[0])
    assert found.rms.interval[1] == math.inf
    entry = prediction.to_dict()["controllers"][0]
    assert entry["rms"]["interval"][1] is None
    json.dumps(entry, allow_nan=False)


@pytest.mark.parametrize(("repeats", "duration", "is_last"), [(3, 0.0, True), (1, 0.0, False), (2, 5.0, True)])
def test_window_is_the_last_period_or_the_whole_run(repeats, duration, is_last):
    parameters = cogging.PointToPointParameters(start=0.1, distance=0.1, dwell=0.1, repeats=repeats)
    motion = cogging.PointToPoint(parameters)
    found = predict_error(machine(), motion, ["own"], samples=2, duration=duration)
    assert found.window == pytest.approx((motion.end - motion.period if is_last else 0.0, duration or motion.end))


def test_all_controllers_of_the_library_are_predicted(monkeypatch):
    found = predict_error(machine(), REFERENCE, samples=3, bandwidth=200.0)
    names = [entry.name for entry in found.controllers]
    assert set(names) == {"own", *cogging.CONTROLLERS} - {"speed"}
    errors = {entry.name: entry.rms.median for entry in found.controllers}
    assert max(errors.values()) < 1e-3
    assert errors["dcarc"] < errors["own"], "with a cogging model and the right mass"
    assert all(entry.diverged == 0.0 for entry in found.controllers)
    assert found.window == pytest.approx((0.5, 0.75))

    def missing(problem):
        raise ImportError("cvxpy is not installed: pip install 'cogging[design]'")

    monkeypatch.setattr(error_prediction, "design_observer", missing)
    found = predict_error(machine(), REFERENCE, samples=2)
    assert "observer_based left out: cvxpy is not installed: pip install 'cogging[design]'" in found.notes
    assert [entry.name for entry in found.controllers] == [name for name in names if name != "observer_based"]
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


def test_drawn_machines_are_valid_and_follow_intervals_or_covariance():
    wide = machine(intervals={"axis.coulomb": (-0.3, 0.6), "axis.viscous": (0.166, 0.166), "axis.mass": (0.11, 0.16)})
    drawn = predict_error(wide, REFERENCE, ["own"], samples=1000, duration=0.01).machines
    assert min(drawn["axis.coulomb"]) >= 0.0
    assert np.std(drawn["axis.coulomb"]) > 0.1
    mass = np.array(drawn["axis.mass"])
    assert np.median(mass) == pytest.approx(0.12, abs=1e-3)
    assert np.mean((mass >= 0.11) & (mass <= 0.16)) == pytest.approx(0.95, abs=0.02)
    assert set(drawn.get("axis.viscous", [0.166])) == {0.166}
    paths, wanted = ["axis.viscous", "axis.mass"], np.array([[1e-4, 0.9e-5], [0.9e-5, 1e-6]])
    options = {"samples": 2000, "duration": 0.01, "covariance": (paths, wanted)}
    drawn = predict_error(machine(), REFERENCE, ["own"], **options).machines
    np.testing.assert_allclose(np.cov([drawn[path] for path in paths]), wanted, rtol=0.1)
    assert np.std(drawn["axis.coulomb"]) == pytest.approx(0.05 / 1.96, rel=0.05), "by its interval"


def test_an_infinite_interval_is_reported_and_what_is_known_is_predicted():
    """As `identify` leaves a mass that the logs do not determine."""
    known = machine()
    open_ended = known.replace(intervals={**known.intervals, "axis.mass": (-math.inf, math.inf)})
    found = predict_error(open_ended, REFERENCE, samples=4)
    held = "axis.mass held at 0.12: the interval of the error is unbounded. axis.mass: the logs"
    assert found.notes[0].startswith(held)
    assert "measure it with a log with larger accelerations" in found.notes[0]
    assert "controllers from the bounds left out: axis.mass" in found.text()
    assert set(found.machines) == {*WIDTHS, "seed"} - {"axis.mass"}
    exact = own(known.replace(intervals={**known.intervals, "axis.mass": (0.12, 0.12)}), samples=4)
    np.testing.assert_array_equal(found["own"].rms.values, exact.rms.values)
    given = predict_error(open_ended, REFERENCE, ["own"], samples=4, default={"axis.mass": (0.1, 0.14)})
    assert set(given.machines) == {*WIDTHS, "seed"}


REFUSED = {
    "samples": ({"samples": 1}, r"samples: must be at least 2 for an interval, got 1"),
    "no end": ({"reference": cogging.Sine(cogging.SineParameters())}, r"duration: must be given for a motion without"),
    "name": ({"controllers": ["pdi"]}, r"controllers: each must be one of own, pid, .*, got 'pdi'"),
    "none given": ({"controllers": {}}, r"controllers: must be at least one, got none"),
    "bandwidth": ({"controllers": ["pid"], "bandwidth": 0.0}, r"pid: bandwidth: must be finite and above 0, got 0\.0"),
    "covariance": ({"covariance": (["axis.mass"], [[-1.0]])}, r"covariance: must have no negative eigenvalue"),
    "covariance of nothing": ({"covariance": (["d"], [[1.0]])}, r"covariance: 'd' must be a parameter"),
    "covariance of one": ({"covariance": (["axis.mass"], np.eye(2))}, r"covariance: must be finite, \(1, 1\), got"),
    "covariance askew": ({"covariance": ([*WIDTHS][:2], [[1.0, 0.5], [0.0, 1.0]])}, r"covariance: must be symmetric"),
    "leaves the travel": ({"reference": REFERENCE | {"center": 5.0}}, r"reference: "),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refuses(case):
    arguments, message = REFUSED[case]
    call = {"model": machine(), "reference": REFERENCE, "samples": 2, "controllers": ["own"], **arguments}
    with pytest.raises(ValueError, match=f"^{message}"):
        predict_error(**call)
