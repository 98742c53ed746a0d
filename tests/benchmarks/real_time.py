"""The step of every controller alone, against the 200 us of a 5 kHz loop: time, memory, stack.

Each controller runs the X axis of Lu et al. 2008 (its cogging, its encoder, its moves there and back) in closed loop at
5 kHz, with the gains of its paper. A step is `command` and `update`; every call is timed by the processor's counter and
counted in a histogram. The row "none" is a call that does nothing: what it shows is the clock, and the machine's
interrupts, and both are in every other row as well. docs/real_time.md says what each column is.

    python -m tests.benchmarks.real_time [--calls 10000000]
"""

import argparse
import importlib.util
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

from cogging.model.model import CONTROLLERS
from cogging.papers import comparison
from cogging.papers.lu2008 import gantry as lu2008
from cogging_command import run_command
from tests.benchmarks.lu2008_loop import compiler
from tests.benchmarks.real_time_report import FLAGS, HERE, ROOT, compile_unit, report

AXIS = comparison.AXIS
#: Gains that no paper gives: a position loop of 16 Hz around a velocity loop of 54 Hz, and that velocity loop alone.
LOOPS = {"cascade": {"kp": 100.0, "kv": 40.0}, "speed": {"kp": 40.0, "delay": 0.0005}}
#: For a controller that is tuned nowhere: what is 0 by default, by its unit.
BY_UNIT = {"V/m": 9600.0, "V/(m/s)": 48.0, "V/(m s)": 1e5, "V/(m/s^2)": AXIS.mass, "1/s": 100.0}
#: Heads of the table, figures of the program, and how they are written.
COLUMNS = {
    "mean": ("mean", "7.1f"),
    "median": ("median", "8.0f"),
    "99.99 %": ("most", "9.0f"),
    "worst": ("worst", "11.0f"),
    "> 10 us": ("longer", "9.0f"),
    "own worst": ("own_worst", "11.0f"),
    "cold": ("cold", "6.0f"),
    "gap": ("gap", "6.0f"),
    "at rest": ("resting", "9.1f"),
    "tiny": ("tiny", "6.0f"),
    "flushed": ("flushed", "9.0f"),
    "bytes": ("bytes", "7.0f"),
    "heap": ("heap", "6.0f"),
    "allocations": ("allocations", "13.0f"),
    "denormal": ("denormal", "10.0f"),
    "stack": ("stack", "7.0f"),
    "touched": ("touched", "9.0f"),
}


def settings():
    """Parameters of every controller of the list, by its name."""
    tuned = comparison.controllers()
    made = {}
    for name, (struct, _) in CONTROLLERS.items():
        found = tuned.get(name) or tuned.get(f"{name} C3")
        made[name] = struct(**untuned(name, struct)) if found is None else found.parameters
    return made


def untuned(name, struct):
    """Fields of a controller that no paper tunes."""
    known = {"sample_rate": lu2008.SAMPLE_RATE, "mass": AXIS.mass, "viscous": AXIS.viscous, "coulomb": AXIS.coulomb}
    known["coulomb_width"] = lu2008.COULOMB_WIDTH
    by_unit = {field: BY_UNIT[unit] for field, (unit, _) in struct.FIELDS.items() if unit in BY_UNIT}
    fields = {field: value for field, value in by_unit.items() if struct().to_dict()[field] == 0.0}
    return {field: value for field, value in (fields | known | LOOPS.get(name, {})).items() if field in struct.FIELDS}


def plant():
    """The machine, with the cogging that was calibrated for it."""
    return lu2008.plant(AXIS, lu2008.cogging_map(AXIS, lu2008.shipped_amplitudes(AXIS)))


def motion():
    """The moves, more than any run takes."""
    return lu2008.reference(AXIS, repeats=1_000_000).parameters


def constants():
    """The functions of examples/cpp/generate.py, which write values as C++."""
    path = ROOT / "examples" / "cpp" / "generate.py"
    specification = importlib.util.spec_from_file_location("generate", path)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def setups():
    """The text of setups.hpp: what `setup`, `plant` and `motion` give to the program."""
    write, machine = constants(), plant()
    lines = ["#pragma once", "#include <limits>", '#include "cogging/control/list.hpp"']
    lines += ['#include "cogging/plant/plant.hpp"', '#include "cogging/reference/point_to_point.hpp"']
    lines += ["template <class C>", "typename C::Parameters setup() {", "  typename C::Parameters q;"]
    for name, parameters in settings().items():
        lines += [f'  if constexpr (C::name == "{name}") {{', *write.assignments("q", parameters.to_dict()), "  }"]
    lines += ["  return q;", "}", "inline cogging::Plant<> plant() {", "  cogging::Plant<> p;"]
    for part in ("axis", "encoder"):
        lines += write.assignments(f"p.{part}", getattr(machine, part).to_dict())
    lines += [*write.cogging_lines(machine.cogging), "  return p;", "}"]
    lines += ["inline cogging::PointToPointParameters motion() {", "  cogging::PointToPointParameters m;"]
    return "\n".join([*lines, *write.assignments("m", motion().to_dict()), "  return m;", "}"]) + "\n"


def build(folder, *flags):
    """Builds the program in a folder; gives it."""
    (folder / "setups.hpp").write_text(setups())
    program = folder / "real_time"
    sources = [HERE / f"{name}.cpp" for name in ("real_time", "real_time_step", "real_time_instruments")]
    places = [f"-I{place}" for place in (folder, ROOT / "cpp", ROOT / "examples" / "cpp")]
    subprocess.run([compiler(), *FLAGS, *flags, *places, *sources, "-o", program], check=True)
    return program


def measure(program, *arguments):
    """What the program says: figures by row and name."""
    said = subprocess.run([program, *map(str, arguments)], check=True, capture_output=True, text=True).stdout
    rows = {}
    for line in said.splitlines():
        row, figure, value = line.split()
        rows.setdefault(row, {})[figure] = float(value)
    return rows


def processor():
    """What the processor calls itself."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def printed(row):
    """A line of the table; what a row has not is a dash."""
    cells = []
    for figure, form in COLUMNS.values():
        width = int(form.split(".")[0])
        cells.append(format(row[figure], form) if figure in row else "-".rjust(width))
    return "".join(cells)


def rows(calls):
    """Figures of every controller's step, by its name."""
    with tempfile.TemporaryDirectory() as folder:
        found = measure(build(Path(folder)), calls)
        stacks = report(compile_unit(Path(folder)), list(CONTROLLERS))
    for name, row in found.items():
        row["denormal"] = row["denormal_moving"] + row["denormal_resting"]
        if name in stacks:
            row["stack"] = stacks[name].bytes
    return found


def main(calls):
    """Prints the table."""
    found = rows(calls)
    print(f"{calls} calls of each step on {processor()}, in ns; a 5 kHz loop has 200000")
    print(" " * 20 + "".join(head.rjust(int(form.split(".")[0])) for head, (_, form) in COLUMNS.items()))
    for name, row in found.items():
        print(f"{name:20}{printed(row)}")


def asked():
    """The number of calls on the command line; status 2 where it cannot be."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--calls", type=int, default=10_000_000)
    calls = parser.parse_args().calls
    if not 1 <= calls <= 1_000_000_000:
        parser.error(f"--calls: must be from 1 to 1000000000, got {calls}")
    if compiler() is None:
        parser.error("needs a C++ compiler: $CXX, c++, g++ or clang++")
    return calls


if __name__ == "__main__":
    sys.exit(run_command(lambda: main(asked())))
