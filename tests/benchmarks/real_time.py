"""The step of every controller alone, against the 200 us of a 5 kHz loop: time, memory, stack.

Each controller runs the X axis of Lu et al. 2008 (its cogging, its encoder, its moves there and back) in closed loop at
5 kHz, with the gains of its paper. A step is `command` and `update`; every call is timed by the processor's counter.
The row "none" is a call that does nothing: it shows the clock and the machine's interrupts, which are in every other
row as well. docs/real_time.md says what each column is.

    python -m tests.benchmarks.real_time [--calls 10000000]
"""

import argparse
import platform
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from cogging.model.model import CONTROLLERS
from cogging.papers import comparison
from cogging.papers.lu2008 import gantry as lu2008
from cogging_command import run_command
from tests.benchmarks.lu2008_loop import compiler
from tests.fixtures.cpp_constants import generator
from tests.golden.logs import CONTROLLERS as FIELDS

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
FLAGS = ["-std=c++20", "-O3", "-DNDEBUG", "-ffp-contract=off", "-Wall", "-Wextra"]
AXIS = comparison.AXIS
#: Columns of the table: figure and width with its decimals.
COLUMNS = {
    "mean": "7.1f", "median": "8.0f", "99.99 %": "9.0f", "worst": "11.0f", "> 10 us": "9.0f", "own worst": "11.0f",
    "cold": "6.0f", "gap": "6.0f", "at rest": "9.1f", "tiny": "6.0f", "flushed": "9.0f", "bytes": "7.0f",
    "heap": "6.0f", "allocations": "13.0f", "denormal": "10.0f", "stack": "7.0f",
}  # fmt: skip


def settings():
    """Parameters of every controller of the list by its name: its paper's, else those of the golden logs."""
    tuned, made = comparison.controllers(), {}
    for name, (struct, _) in CONTROLLERS.items():
        found = tuned.get(name) or tuned.get(f"{name} C3")
        made[name] = found.parameters if found else struct(**FIELDS[name])
    return made


def plant():
    """The machine, with the cogging that was calibrated for it."""
    return lu2008.plant(AXIS, lu2008.cogging_map(AXIS, lu2008.shipped_amplitudes(AXIS)))


def motion():
    """The moves, longer than any run."""
    return lu2008.reference(AXIS, repeats=1_000_000).parameters


def setups():
    """The text of setups.hpp: what `settings`, `plant` and `motion` give to the program."""
    write, machine = generator(), plant()
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
    (folder / "setups.hpp").write_text(setups())
    program = folder / "real_time"
    sources = [HERE / f"{name}.cpp" for name in ("real_time", "real_time_step")]
    places = [f"-I{place}" for place in (folder, ROOT / "cpp", ROOT / "examples" / "cpp")]
    subprocess.run([compiler(), *FLAGS, *flags, *places, *sources, "-o", program], check=True)
    return program


def measure(program, calls):
    """Figures of each row by name; times in ns."""
    path = program.with_name("ticks")
    printed = subprocess.run([program, str(calls), path], check=True, capture_output=True, text=True).stdout
    ticks, rows, at = np.fromfile(path, dtype=np.uint32), {}, 0
    for line in printed.splitlines():
        row, figure, value = line.split()
        rows.setdefault(row, {})[figure] = float(value)
    per_nanosecond = rows.pop("clock")["ticks_per_nanosecond"]
    for row in rows.values():
        times = {}
        for series in [name for name in row if name.startswith("ticks_")]:
            count = int(row.pop(series))
            times[series.removeprefix("ticks_")] = ticks[at : at + count] / per_nanosecond
            at += count
        row.update(summarized(times))
    return rows


def mean_of_shortest(share, times):
    """Mean of the shortest durations, so many of all: finer than the counter's steps, without interruptions."""
    return np.sort(times)[: max(1, int(share * len(times)))].mean()


def summarized(times):
    """Figures of the table from the durations of each part, ns."""
    moving = times["moving"]
    found = {
        "calls": len(moving),
        "mean": mean_of_shortest(0.9999, moving),
        "median": np.median(moving),
        "99.99 %": np.quantile(moving, 0.9999, method="inverted_cdf"),
        "worst": moving.max(),
        "> 10 us": np.count_nonzero(moving > 10e3),
        "own worst": np.minimum(moving, times["again"]).max(),
        "cold": np.median(times["cold"]),
        "gap": np.median(times["gap"]),
        "at rest": mean_of_shortest(0.9999, times["resting"]),
        "tiny": mean_of_shortest(0.99, times["tiny"]),
    }
    return found | ({"flushed": mean_of_shortest(0.99, times["flushed"])} if len(times["flushed"]) else {})


# What the compiler reports of a step: the most stack it can take, and what it calls outside of its unit. -----------

NODE = re.compile(r'^node: \{ title: "([^"]*)" label: "[^"]*\\n(\d+) bytes \(([^)]*)\)')
EDGE = re.compile(r'^edge: \{ sourcename: "([^"]*)" targetname: "([^"]*)"')
STEP = re.compile(r"\d+stepIL[a-z](\d+)EE")
#: Bytes below its frame that a function which calls none may use, by the ABI of x86-64: gcc does not count them.
RED_ZONE = 128


class UnboundedStack(Exception):
    """A step whose stack has no bound that the compiler knows."""


def reports_stack():
    """Whether the compiler writes a call graph with its frames: gcc from version 10 on does."""
    printed = subprocess.run([compiler(), "--help=common"], capture_output=True, text=True)
    return "-fcallgraph-info" in printed.stdout


def compile_unit(folder, *flags):
    """Compile the unit of the steps with its report; returns the path of both without their suffix."""
    made, source = folder / "real_time_step", HERE / "real_time_step.cpp"
    flags = [*FLAGS, *flags, *(["-fcallgraph-info=su"] if reports_stack() else []), f"-I{ROOT / 'cpp'}", f"-I{HERE}"]
    subprocess.run([compiler(), *flags, "-c", source, "-o", f"{made}.o"], check=True, cwd=folder)
    return made


def stack_of_each(made):
    """Functions that return (bytes of stack, functions of other units) of each step of a compiled unit, by its number.

    The bytes are those of the deepest path, return addresses included; those of other units come on top. Such a
    function raises UnboundedStack where its step calls itself, or has a frame of no fixed size.
    """
    lines = made.with_suffix(".ci").read_text().splitlines()
    frames = {found[1]: (int(found[2]), found[3]) for found in map(NODE.match, lines) if found}
    calls = {}
    for caller, callee in (found.groups() for found in map(EDGE.match, lines) if found):
        calls.setdefault(caller, set()).add(callee)

    def reach(function, above=()):
        if function in above:
            raise UnboundedStack(f"{function}: calls itself")
        if function not in frames:  # a constructor of a whole object may be one name more of that of a part
            function = re.sub(r"([CD])1E", r"\g<1>2E", function)
        if function not in frames:
            if function == "__indirect_call" or ":" in function:
                raise UnboundedStack(f"{above[-1]}: calls {function}, which only the run knows")
            return 0, {function}
        size, kind = frames[function]
        if kind != "static":
            raise UnboundedStack(f"{function}: its frame is {kind}")
        below = [reach(callee, (*above, function)) for callee in calls.get(function, ())]
        return size + max((depth for depth, _ in below), default=RED_ZONE), set().union(*(names for _, names in below))

    steps = {int(number[1]): function for function in frames if (number := STEP.search(function))}
    return {number: lambda function=function: reach(function) for number, function in sorted(steps.items())}


def undefined_symbols(made):
    printed = subprocess.run(["nm", "-u", made.with_suffix(".o")], check=True, capture_output=True, text=True).stdout
    return {line.split()[-1] for line in printed.splitlines()} - {"_GLOBAL_OFFSET_TABLE_"}


# The table -----------------------------------------------------------------------------------------------------------


def processor():
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def rows(calls):
    with tempfile.TemporaryDirectory() as folder:
        found = measure(build(Path(folder)), calls)
        stacks = stack_of_each(compile_unit(Path(folder))) if reports_stack() else {}
        for number, stack in stacks.items():
            found[list(CONTROLLERS)[number]]["stack"] = stack()[0]
    return found


def main(calls):
    """Print the table; what a row does not have is a dash."""
    found = rows(calls)
    widths = {name: int(form.split(".")[0]) for name, form in COLUMNS.items()}
    print(f"{calls} calls of each step on {processor()}, in ns; a 5 kHz loop has 200000")
    print(" " * 20 + "".join(name.rjust(width) for name, width in widths.items()))
    for name, row in found.items():
        cells = [format(row[figure], form) if figure in row else "-" for figure, form in COLUMNS.items()]
        print(f"{name:20}" + "".join(map(str.rjust, cells, widths.values())))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--calls", type=int, default=10_000_000)
    options = parser.parse_args()
    sys.exit(run_command(lambda: main(options.calls)))
