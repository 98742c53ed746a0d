"""What the drawn calls of `python -m tests.attack bindings` found, and what no longer happens."""

import copy
import os
import pickle
import subprocess
import sys

import numpy as np
import pytest

import cogging
from tests.attack.binding_values import make_pool
from tests.attack.bindings import run_case

POOL = make_pool()
UNPICKLED = {"CompiledController", "Predictor", "Prediction", "StopFlag"}


@pytest.mark.parametrize("name", sorted(POOL))
def test_pickles_of_every_protocol(name):
    """Protocols 0 and 1 made a bare object of the bindings' library, which ended the process."""
    value = POOL[name]
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        if name in UNPICKLED:
            with pytest.raises(TypeError, match="cannot pickle"):
                pickle.dumps(value, protocol)
        else:
            again = pickle.loads(pickle.dumps(value, protocol))
            assert type(again) is type(value)
            assert again == value
    if name not in UNPICKLED:
        assert copy.deepcopy(value) == value


@pytest.mark.parametrize("along", [1.0, [1.0], None, "text", b"", {}])
def test_a_prediction_of_another_kind_is_refused(along):
    """It ended the process: what keeps a result's parts alive was asked of the mark of a failed conversion."""
    with pytest.raises(TypeError):
        POOL["Predictor"].plant_along(along, POOL["Plant"])


def test_a_plant_along_a_prediction_lives_as_long_as_it_is_held():
    time = np.linspace(0.0, 0.1, 200)
    plant = POOL["Plant"]
    effect, sizes = [cogging.effects.CableSpring(stiffness=1.0)], [1.0]

    def made():
        predictor = cogging._core.Predictor(time, 0.1 * time, time)
        return predictor.plant_along(predictor.predict(plant), plant)

    held = [made() for _ in range(20)]  # each of its own predictor, which nothing else holds
    first = held[0].added(effect, sizes)
    assert np.abs(first).max() > 0.0
    for one in held[1:]:
        np.testing.assert_array_equal(one.added(effect, sizes), first)


@pytest.mark.parametrize("value", [True, False, np.bool_(True)], ids=["True", "False", "numpy True"])
@pytest.mark.parametrize(
    ("kind", "field"),
    [("AxisParameters", "mass"), ("PidParameters", "kp"), ("PointToPointParameters", "repeats")],
)
def test_truth_values_are_no_numbers(kind, field, value):
    with pytest.raises(TypeError, match=rf"{kind}: {field}: must be a (whole )?number, got {bool(value)}"):
        getattr(cogging._core, kind)(**{field: value})


def test_truth_values_stay_what_they_are_where_they_are_asked_for():
    assert cogging.OutputFeedbackArcParameters(use_u_s2=True).use_u_s2 is True


@pytest.mark.parametrize(
    ("made", "line"),
    [
        (lambda: cogging.AxisParameters(mass=1e300), r"mass: must be at most 1e\+30 in size, got 1e\+300"),
        (lambda: cogging.SplineHarmonics(pitch=1e300, harmonics=[1]), r"pitch: must be at most 1e\+30 in size"),
        (lambda: cogging.SplineHarmonics(pitch=1e10, harmonics=[1]), r"pitch: must be from 1e-9 to 1e9, got 1e\+10"),
        (lambda: cogging.SplineHarmonics(pitch=1e-300, harmonics=[1]), r"pitch: must be from 1e-9 to 1e9, got 1e-300"),
        (
            lambda: cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2_000_000_000]),
            r"harmonics: each must leave a period of at least 1e-9, got 2e\+09",
        ),
        (lambda: cogging.SplineHarmonics(periods=[0.05, 1e-12]), r"periods: must be from 1e-9 to 1e9, got 1e-12"),
        (lambda: cogging.effects.CoggingHarmonic(period=1e-10), r"period: must be from 1e-9 to 1e9, got 1e-10"),
        (lambda: cogging.ObserverBasedParameters(periods=[1e-10]), r"periods: must be from 1e-9 to 1e9, got 1e-10"),
    ],
)
def test_sizes_that_no_axis_has_are_refused(made, line):
    with pytest.raises(ValueError, match=line):
        made()


@pytest.mark.parametrize("seed", range(0, 600, 3))
def test_a_drawn_call_ends_as_it_should(seed):
    """A few of those that the attack makes, in this process; the whole of it watches its processes from outside."""
    assert run_case(seed) is None


def test_the_attack_itself_sees_what_it_is_to_see(tmp_path):
    """A crash, a hang cut short, a traceback and nonsense are each counted; what ends well is not."""
    (tmp_path / "cases.py").write_text(
        "import os, time\n"
        "def run_case(seed):\n"
        "    if seed == 3: os.abort()\n"
        "    if seed == 5: time.sleep(1000)\n"
        "    if seed == 7: raise RuntimeError('inside')\n"
        "    return 'nonsense accepted' if seed == 9 else None\n"
    )
    code = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "from tests.attack import watched\n"
        "watched.HANG = 2.0\n"
        "if __name__ == '__main__':\n"
        "    tally = watched.attack('cases', range(12))\n"
        "    print(tally.cases, sorted(tally.crashes), sorted(tally.hangs), sorted(tally.faults))\n"
    )
    script = tmp_path / "run.py"
    script.write_text(code)
    path = os.pathsep.join([str(tmp_path), os.getcwd(), *sys.path])
    environment = {**os.environ, "PYTHONPATH": path}
    done = subprocess.run(
        [sys.executable, str(script), str(tmp_path)], capture_output=True, text=True, env=environment, check=False
    )
    assert done.stdout.split("\n")[0] == "12 [3] [5] [7, 9]", done.stderr[-2000:]
