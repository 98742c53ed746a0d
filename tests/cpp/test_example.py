"""The real-time loop of examples/cpp, built as a project of its own from an installed prefix, without Python."""

import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import cogging
from cogging.model.model import CONTROLLERS
from tests.fixtures.cpp_constants import generator

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "cpp"
MOTION = {"type": "point_to_point", "start": 0.05, "distance": 0.4, "velocity": 0.5, "acceleration": 10.0}
MOTION |= {"jerk": 1000.0, "dwell": 0.1, "repeats": 100}


@pytest.fixture(scope="module")
def loop(cmake, prefix):
    built = cmake.build(EXAMPLE, "example", f"-DCMAKE_PREFIX_PATH={prefix}", "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Werror")
    return cmake.program(built, "real_time_loop")


def generate(model, out):
    command = [sys.executable, EXAMPLE / "generate.py", model, "--out", out]
    return subprocess.run(command, capture_output=True, text=True)


def test_the_constants_are_those_of_the_model(tmp_path):
    done = generate(EXAMPLE / "model.toml", tmp_path / "constants.hpp")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "constants.hpp").read_text() == (EXAMPLE / "controller_constants.hpp").read_text()


def test_the_loop_does_what_the_simulation_does(cmake, loop):
    """Without waiting the loop is the closed loop of Python: the same errors."""
    said = cmake.run(loop, "1.2", "--no-wait")
    log = cogging.simulate(EXAMPLE / "model.toml", MOTION, duration=1.2)
    assert re.search(rf"samples: {len(log)} taken, 0 missed", said)
    rms, largest = map(float, re.search(r"error: rms (\S+) m, largest (\S+) m", said).groups())
    assert rms == pytest.approx(np.sqrt(np.mean(log.error**2)), rel=1e-9)
    assert largest == pytest.approx(np.abs(log.error).max(), rel=1e-9)


def test_the_loop_keeps_its_clock(cmake, loop):
    begin = time.monotonic()
    taken, missed = map(int, re.search(r"samples: (\d+) taken, (\d+) missed", cmake.run(loop, "0.3")).groups())
    assert time.monotonic() - begin > 0.3  # s: no sample before its deadline
    assert taken + missed == 1501
    assert taken > 0


def test_constants_of_every_controller_compile(cmake, compiler, prefix, tmp_path):
    """Values as they come: vectors, words, switches, infinities; each header in a namespace of its own."""
    waves = cogging.SplineHarmonics(periods=[0.03, 0.011])
    headers = ["plant/plant.hpp", *(f"control/{path.name}" for path in (prefix / "include/cogging/control").iterdir())]
    source = "".join(f"#include <cogging/{name}>\n" for name in headers)
    for name, (parameters, _) in CONTROLLERS.items():
        model = cogging.Model(
            axis=cogging.AxisParameters(mass=0.1, travel=[-np.inf, 0.5]),
            cogging=cogging.CoggingModel(waves, sine=[[0.1], [0.0]], cosine=[[1 / 3], [0.0]]),
            controller=parameters(),
            controller_type=name,
        )
        text = generator().header(model, "model.toml")
        assert repr(1 / 3) in text
        source += f"namespace of_{name} {{\n{text.replace('#pragma once', '')}\n}}\n"
        source += f"const of_{name}::constants::Controller {name}(of_{name}::constants::controller());\n"
    (tmp_path / "all.cpp").write_text(source)
    cmake.run(compiler, "-std=c++20", "-fsyntax-only", f"-I{prefix / 'include'}", tmp_path / "all.cpp")


def test_a_model_that_cannot_be_used(tmp_path):
    spring = "[[effects]]\nname = 'cable_spring'\nstiffness = 1.0\n"
    (tmp_path / "model.toml").write_text((EXAMPLE / "model.toml").read_text() + spring)
    done = generate(tmp_path / "model.toml", tmp_path / "constants.hpp")
    assert done.returncode == 2
    assert re.fullmatch(r".*effects: must be left out.*\n", done.stderr)
    assert not (tmp_path / "constants.hpp").exists()
