"""A closed loop in a C++ program without Python gives the bits of the same loop in Python."""

import numpy as np

import cogging
from cogging.model.model import CONTROLLERS
from tests.fixtures.cpp_constants import generator
from tests.fixtures.plants_by_hand import EXAMPLES, effect
from tests.golden.logs import CONTROLLERS as FIELDS

EXCLUSIVE = ("presliding_friction", "backlash", "flexible_mode")
PROGRAM = """
#include <cstdio>
#include <limits>

#include "cogging/control/list.hpp"
#include "cogging/reference/point_to_point.hpp"
#include "cogging/simulation/closed_loop.hpp"

using namespace cogging;

template <class C>
void run(std::FILE* file, const typename C::Parameters& q, const Plant<>& p, const PointToPointParameters& m) {
  RunOptions options;
  options.seed = 5;
  const Log<> log = closed_loop<double>(p, C(q), PointToPoint(m), options);
  for (const auto* column : {&log.position, &log.command})
    std::fwrite(column->data(), sizeof(double), column->size(), file);
}

int main(int, char** arguments) {
  std::FILE* file = std::fopen(arguments[1], "wb");
"""


def draw_plant(rng):
    """A plant with about a third of all effects, friction that sticks or does not, and noise."""
    basis = cogging.SplineHarmonics(pitch=0.05, harmonics=[1, 2, 3], control_points=13)
    names = [name for name in EXAMPLES if name not in EXCLUSIVE and rng.random() < 0.3]
    names += [str(rng.choice(EXCLUSIVE))] if rng.random() < 0.5 else []
    return cogging.Plant(
        cogging.AxisParameters(
            mass=rng.uniform(0.1, 0.2),
            viscous=rng.uniform(0.1, 0.3),
            coulomb=rng.uniform(0.1, 0.2),
            coulomb_width=float(rng.choice([0.0, 2e-3])),
            travel=[-5.0, 5.0],
        ),
        cogging=cogging.CoggingModel(basis, *rng.uniform(-0.05, 0.05, (2, 3, 13))),
        effects=[effect(name, **EXAMPLES[name][0]) for name in names],
        encoder=cogging.EncoderParameters(resolution=0.5e-6, noise=1e-7),
        noise=cogging.NoiseParameters(force=0.01),
    )


def written(kind, parameters, plant, motion):
    """The block of the program that makes one run."""
    write = generator().assignments
    lines = ["  {", "  Plant<> p;", f"  {kind.__name__}<>::Parameters q;", "  PointToPointParameters m;"]
    lines += [*write("q", parameters.to_dict()), *write("m", motion.to_dict())]
    for part in ("axis", "encoder", "noise"):
        lines += write(f"p.{part}", getattr(plant, part).to_dict())
    lines += generator().cogging_lines(plant.cogging)
    for number, one in enumerate(plant.effects):
        fields = {"level" if name == "force" else name: value for name, value in one.to_dict().items()}
        lines += [f"  {type(one).__name__}<> e{number};", *write(f"e{number}", fields)]
        lines += [f"  p.effects.push_back(e{number});"]
    return "\n".join([*lines, f"  run<{kind.__name__}<>>(file, q, p, m);", "  }\n"])


def test_a_loop_without_python_gives_the_same_bits(cmake, compiler, prefix, tmp_path):
    program, columns = PROGRAM, []
    for number, (name, (struct, kind)) in enumerate(CONTROLLERS.items()):
        rng = np.random.default_rng(number)
        for _ in range(3):
            plant, parameters = draw_plant(rng), struct(**FIELDS[name])
            move = {"distance": rng.uniform(0.02, 0.05), "velocity": 0.3, "acceleration": 10.0}
            motion = cogging.PointToPointParameters(start=0.1, jerk=rng.uniform(500, 2000), **move)
            log = cogging.closed_loop(plant, kind(parameters), cogging.PointToPoint(motion), seed=5)
            assert np.ptp(log.command) > 0.1  # V: the axis moves
            program += written(kind, parameters, plant, motion)
            columns += [log.position, log.command]
    (tmp_path / "runs.cpp").write_text(program + "  return std::fclose(file);\n}\n")
    flags = ["-std=c++20", "-O1", "-ffp-contract=off", f"-I{prefix / 'include'}"]
    cmake.run(compiler, *flags, tmp_path / "runs.cpp", "-o", tmp_path / "runs")
    cmake.run(tmp_path / "runs", tmp_path / "columns")
    found = np.fromfile(tmp_path / "columns")
    assert len(found) > 20_000
    np.testing.assert_array_equal(found, np.concatenate(columns))
