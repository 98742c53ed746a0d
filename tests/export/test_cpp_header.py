"""A controller as one C++ header: compiled without the library, it gives the library's commands to the bit."""

import math
import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import cogging
from cogging.model.model import CONTROLLERS
from tests.golden.logs import CONTROLLERS as USUAL

WORDS = {"feedforward_velocity": ("reference", "measured"), "rotation": ("reference", "measured")}
COUNTS = {"cogging_harmonics": (1, 13), "cogging_order": (1, 6), "cogging_control_points": (6, 15)}


def draw_parameters(kind, rng):
    """Parameters of a listed controller: those of the golden log, each field drawn and kept where the rules allow."""
    parameters = CONTROLLERS[kind][0](**USUAL.get(kind, {}))
    for name, value in parameters.to_dict().items():
        factor, ends = 10 ** rng.uniform(-0.4, 0.4), 10 ** rng.uniform(0.0, 0.4, 2)
        if name in WORDS:
            drawn = str(rng.choice(WORDS[name]))
        elif name == "cogging_harmonics":
            drawn = sorted(int(h) for h in rng.choice(range(*COUNTS[name]), rng.integers(0, 6), replace=False))
        elif name in COUNTS:
            drawn = int(rng.integers(*COUNTS[name]))
        elif name == "cogging_estimates":
            count = 2 * len(parameters.cogging_harmonics) * parameters.cogging_control_points
            drawn = rng.uniform(-0.02, 0.02, count).tolist()
        elif isinstance(value, bool):
            drawn = bool(rng.random() < 0.3)
        elif isinstance(value, float):
            drawn = float((3.0 if name == "command_limit" else value) * factor * rng.choice([0.0, 1.0], p=[0.2, 0.8]))
        elif name.endswith("_bounds"):
            drawn = [value[0] / ends[0], value[1] * ends[1]]
        else:
            drawn = value if isinstance(value, str) else [float(one * factor) for one in value]
        try:
            parameters = parameters.replace(**{name: drawn})
        except ValueError:  # a rule that binds it to another field
            continue
    return parameters


#: As a drive's compiler would have it: no exceptions; nothing that the strictest warnings find.
FLAGS = ["-std=c++20", "-O1", "-ffp-contract=off", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror"]
WITHOUT = ["-fno-exceptions", "-fno-rtti"]
COMPILERS = [path for name in (os.environ.get("CXX", "g++"), "clang++") if (path := shutil.which(name))]
ROOT = Path(__file__).resolve().parents[2]
ROWS, FAULTS = 3000, [math.nan, math.inf, -1e308, 1e12]
#: Every kind once, and two of them again: all in one program.
NAMES = {**{kind: kind for kind in CONTROLLERS}, "second_pid": "pid", "second_arc": "arc"}

PROGRAM = """
#include <cstdio>
#include <new>
{includes}

static std::size_t allocations = 0;
void* operator new(std::size_t size) {{ ++allocations; return std::malloc(size); }}
void operator delete(void* place) noexcept {{ std::free(place); }}
void operator delete(void* place, std::size_t) noexcept {{ std::free(place); }}

// Reads a line of {rows} samples; writes the commands of two passes, the second behind reset(), then what it is like.
template <class C>
void run() {{
  static double rows[{rows}][8], commands[2][{rows}];
  if (std::fread(rows, sizeof rows, 1, stdin) != 1) std::abort();
  C controller;
  C copy = controller;
  copy = controller;
  const std::size_t before = allocations;
  for (auto& pass : commands) {{
    controller.reset();
    for (int k = 0; k < {rows}; ++k) {{
      const double* r = rows[k];
      const typename C::Reference reference{{r[0], r[1], r[2]}}, ahead{{r[3], r[4], r[5]}};
      if constexpr (requires {{ C::preview; }})
        pass[k] = controller.command(reference, ahead, r[6]);
      else
        pass[k] = controller.command(reference, r[6]);
      controller.update(r[7]);
    }}
  }}
  double facts[8] = {{C::sample_rate, C::command_limit, C::limited(1e9), controller.samples_refused(),
                    double(allocations - before), double(controller.estimates().size())}};
  if constexpr (requires {{ C::preview; }}) facts[6] = C::preview;
  std::fwrite(commands, sizeof commands, 1, stdout);
  std::fwrite(facts, sizeof facts, 1, stdout);
  for (double estimate : controller.estimates()) std::fwrite(&estimate, sizeof estimate, 1, stdout);
}}

int main() {{
  {runs}
}}
"""


def compile_with(compiler, *arguments):
    done = subprocess.run([compiler, *FLAGS, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-4000:]


def model_of(kind, seed):
    rng = np.random.default_rng([seed, *kind.encode()])
    return cogging.Model(cogging.AxisParameters(mass=0.12), controller=draw_parameters(kind, rng), controller_type=kind)


def stream(model, seed):
    """Samples of a motion under a controller, with lost readings, bursts of them and lost answers of the drive.

    Returns rows (reference, reference ahead, reading, applied), the library's commands, and the controller behind them.
    """
    rng = np.random.default_rng(seed)
    controller = model.make_controller()
    ahead = getattr(controller, "preview", 0.0)
    time, w, size = np.arange(ROWS) / model.controller.sample_rate, rng.uniform(3, 20), rng.uniform(0.01, 0.2)
    phases = [w * time, w * (time + ahead)]
    motions = [np.stack([size * np.sin(p), size * w * np.cos(p), -size * w * w * np.sin(p)], axis=1) for p in phases]
    readings = np.round((motions[0][:, 0] + rng.normal(0, 1e-5, ROWS)) / 1e-6) * 1e-6
    for length in (1, 1, 2, 5, 16, 17, 40):
        start = rng.integers(0, ROWS - 100)
        readings[start : start + length] = rng.choice(FAULTS)
    rows, commands, limit = [], [], model.controller.command_limit
    for point, later, reading in zip(motions[0].tolist(), motions[1].tolist(), readings.tolist(), strict=True):
        command = controller.command(reference=point, reading=reading, **({"ahead": later} if ahead else {}))
        applied = min(max(command, -limit), limit) if limit else command
        applied = math.nan if rng.random() < 0.01 else applied * rng.choice([1.0, 0.5])
        controller.update(applied)
        commands.append(command)
        rows.append([*point, *later, reading, applied])
    return np.array(rows), np.array(commands), controller


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The headers of all, each of drawn gains, and the program that runs them."""
    place = tmp_path_factory.mktemp("headers")
    for seed, (name, kind) in enumerate(NAMES.items()):
        made = cogging.export.to(model_of(kind, seed), "cpp", name=name)
        (place / f"{name}.hpp").write_bytes(made.content)
    text = PROGRAM.format(
        rows=ROWS,
        includes="\n".join(f'#include "{name}.hpp"' for name in NAMES),
        runs="\n  ".join(f"run<{name}::Controller>();" for name in NAMES),
    )
    (place / "program.cpp").write_text(text)
    return place


@pytest.mark.parametrize("compiler", COMPILERS, ids=lambda path: Path(path).name)
def test_all_controllers_in_one_program_have_the_bits_of_the_library(folder, compiler):
    compile_with(compiler, *WITHOUT, folder / "program.cpp", "-o", folder / "program")
    models = [model_of(kind, seed) for seed, kind in enumerate(NAMES.values())]
    streams = [stream(model, seed) for seed, model in enumerate(models)]
    given = b"".join(rows.tobytes() for rows, _, _ in streams)
    printed = np.frombuffer(subprocess.run([folder / "program"], input=given, capture_output=True, check=True).stdout)
    place = 0
    for kind, model, (_, commands, controller) in zip(NAMES.values(), models, streams, strict=True):
        first, second, facts, after = np.split(printed[place:], np.cumsum([ROWS, ROWS, 8]))
        assert np.ptp(commands) > 0.1, kind  # V: it acts
        assert np.isfinite(commands).all(), kind
        np.testing.assert_array_equal(first, commands, kind)
        np.testing.assert_array_equal(second, commands, kind)
        limit = model.controller.command_limit
        count = len(controller.estimates)
        expected = [model.controller.sample_rate, limit, limit or 1e9, controller.samples_refused, 0, count]
        np.testing.assert_array_equal(facts[:7], [*expected, getattr(controller, "preview", 0.0)], kind)
        assert controller.samples_refused > 10
        np.testing.assert_array_equal(after[:count], controller.estimates, kind)
        place += 2 * ROWS + 8 + count
    assert place == len(printed)


@pytest.mark.parametrize("compiler", COMPILERS, ids=lambda path: Path(path).name)
def test_an_older_standard_gets_one_error_that_names_the_standard(folder, compiler):
    old = [compiler, "-std=c++17", "-fsyntax-only", "-x", "c++", str(folder / "pid.hpp"), "-w"]
    done = subprocess.run(old, capture_output=True, text=True)
    assert done.returncode != 0
    (line,) = re.findall(r"^.* error: .*$", done.stderr, re.MULTILINE)
    assert "needs C++20: compile with -std=c++20" in line


@pytest.mark.parametrize("kind", ["pid", "arc", "observer_based"])
def test_a_header_needs_the_standard_library_alone(folder, kind):
    text = (folder / f"{kind}.hpp").read_text()
    included = re.findall(r"^\s*#\s*include\s*(.*)$", text, re.MULTILINE)
    assert included
    assert all(re.fullmatch(r"<[a-z_]+>", name) for name in included)
    assert "Permission is hereby granted, free of charge" in text
    before, _, namespace = text.partition(f"\nnamespace {kind} {{\n")
    assert "#define" not in before
    defined = set(re.findall(r"^\s*#define (\w+)", namespace, re.MULTILINE))
    assert defined == set(re.findall(r"^#undef (\w+)", namespace, re.MULTILINE))  # nothing is left behind


def test_the_guide_s_loop_compiles(folder):
    (loop,) = re.findall(r"```cpp\n(.*?)```", (ROOT / "docs" / "cpp_export.md").read_text(), re.DOTALL)
    (folder / "controller.hpp").write_bytes(cogging.export.to(model_of("arc", 0), "cpp", name="x_axis").content)
    (folder / "loop.cpp").write_text(loop)
    compile_with(COMPILERS[0], "-fsyntax-only", folder / "loop.cpp")


def test_labels_are_those_of_the_model():
    model = model_of("pid", 0).replace(units=cogging.Units(command="A", position="rad"))
    facts = cogging.export.to(model, "cpp").content.decode().partition("// The controller")[2]
    assert "// A/rad: proportional gain" in facts
    assert not re.search(r"\bV\b", facts)
