"""The hot code is generic over its scalar: four machines in one pack give the bits of four single runs.

lanes.cpp is built from the headers alone, so it also shows that the core needs no Python and no binding.
"""

import subprocess
from pathlib import Path

import pytest

from cogging.model.model import CONTROLLERS

ROOT = Path(__file__).resolve().parents[2]
FLAGS = ["-std=c++20", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-I", str(ROOT / "cpp")]


def errors(compiled):
    return "\n".join(line for line in compiled.stderr.splitlines() if "error" in line or "warning" in line)[:1000]


@pytest.fixture(scope="module")
def printed(cmake, programs):
    output = cmake.run(cmake.program(programs, "lanes"))
    return {name: float(value) for name, value in (line.split() for line in output.splitlines())}


@pytest.mark.parametrize("controller", ["dcarc", "arc", "pid", "mixed"])
def test_lanes_give_the_bits_of_single_runs(printed, controller):
    assert printed[controller + "_rows"] > 2000
    assert printed[controller + "_difference"] == 0.0
    assert printed[controller + "_spread"] > 0.5  # V: the lanes are different machines


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_a_lane_that_loses_readings_leaves_the_others_alone(printed, controller):
    assert printed[controller + "_lost"] > 100
    assert printed[controller + "_lost_difference"] == 0.0


def test_effects_with_a_state_are_refused_in_lanes(printed):
    assert printed["refused"] == 3


def test_lanes_of_mixed_friction_width(printed):
    """Each lane by its own width where that can be (with "mixed" above), else refused; a current loop alike."""
    assert 1 <= printed["mixed_sharp"] <= 3
    assert printed["mixed_refused"] == 1


def test_elementary_functions(printed):
    """The core's own functions against the library's, in units of the last place."""
    assert printed["at_zero"] == 1.0
    assert printed["at_infinity"] == 1.0
    assert printed["nan_stays_nan"] == 1.0
    assert printed["at_the_ends"] == 1.0
    assert printed["no_numbers"] == 1.0
    if printed["long_double_digits"] > 53:
        assert printed["sine_ulps"] < 2.5
        assert printed["atan_ulps"] < 1.0
        worst = {
            "exp_ulps": 1.0,
            "expm1_ulps": 2.0,
            "log_ulps": 1.0,
            "tanh_ulps": 2.5,
            "pow_share": 1.0,
            "root_ulps": 1.0,
        }
        assert {name: printed[name] for name, most in worst.items() if not printed[name] < most} == {}


@pytest.mark.parametrize(
    "header", ["basis/regressor", "control/sample_guard", "estimation/predictor", "lanes", "plant/body_with_states"]
)
def test_a_header_stands_alone(compiler, header):
    source = f'#include "cogging/{header}.hpp"\n'
    command = [compiler, *FLAGS, "-fsyntax-only", "-x", "c++", "-"]
    checked = subprocess.run(command, input=source, capture_output=True, text=True)
    assert checked.returncode == 0, errors(checked)
