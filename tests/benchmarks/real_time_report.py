"""What the compiler's own report says of a step: the most stack it can take, and what it calls outside of itself."""

import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

from tests.benchmarks.lu2008_loop import compiler

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
FLAGS = ["-std=c++20", "-O3", "-DNDEBUG", "-ffp-contract=off", "-Wall", "-Wextra"]

NODE = re.compile(r'^node: \{ title: "(?P<name>[^"]*)" label: "(?P<label>[^"]*)"')
EDGE = re.compile(r'^edge: \{ sourcename: "(?P<caller>[^"]*)" targetname: "(?P<callee>[^"]*)"')
FRAME = re.compile(r"\\n(?P<bytes>\d+) bytes \((?P<kind>[^)]*)\)")
STEP = re.compile(r"\d+stepIL[a-z](\d+)EE")
#: Bytes below its frame that a function which calls none may use, by the ABI of x86-64: gcc does not count them.
RED_ZONE = 128


class UnboundedStack(Exception):
    """A step whose stack has no bound that the compiler knows."""


@dataclass
class Reach:
    """What a step may take: the deepest path below it, and the functions of other units on any path.

    Attributes:
        bytes: of stack, return addresses with it; those of `outside` come on top.
        outside: names as the linker has them.
    """

    bytes: int
    outside: set[str]


@dataclass
class CallGraph:
    """The functions of a unit as gcc's -fcallgraph-info=su tells them.

    Attributes:
        frames: bytes and kind of each function that the unit holds.
        calls: what each calls.
    """

    frames: dict[str, tuple[int, str]]
    calls: dict[str, set[str]]

    @classmethod
    def read(cls, text):
        """The graph of a .ci file."""
        frames, calls = {}, {}
        for line in text.splitlines():
            if (node := NODE.match(line)) and (frame := FRAME.search(node["label"])):
                frames[node["name"]] = (int(frame["bytes"]), frame["kind"])
            elif edge := EDGE.match(line):
                calls.setdefault(edge["caller"], set()).add(edge["callee"])
        return cls(frames, calls)

    def reach(self, function, above=()):
        """What a function may take; UnboundedStack where it calls itself, or a frame's size is not fixed."""
        if function in above:
            raise UnboundedStack(f"{function}: calls itself")
        if function not in self.frames:  # a constructor of a whole object may be one name more of that of a part
            function = re.sub(r"([CD])1E", r"\g<1>2E", function)
        if function not in self.frames:
            if function == "__indirect_call":
                raise UnboundedStack(f"{above[-1]}: calls what only the run knows")
            if ":" in function:
                raise UnboundedStack(f"{function}: its frame is not told")
            return Reach(0, {function})
        size, kind = self.frames[function]
        if kind != "static":
            raise UnboundedStack(f"{function}: its frame is {kind}")
        below = [self.reach(callee, (*above, function)) for callee in self.calls.get(function, ())]
        deepest = max((one.bytes for one in below), default=RED_ZONE)
        return Reach(size + deepest, set().union(*(one.outside for one in below)))


def reports_stack():
    """Whether the compiler writes a call graph with its frames: gcc from version 10 on does."""
    said = subprocess.run([compiler(), "--help=common"], capture_output=True, text=True)
    return "-fcallgraph-info" in said.stdout


def compile_unit(folder, *flags, source=HERE / "real_time_step.cpp"):
    """Compiles the unit of the steps with its report; gives the path of both without their ending."""
    made = folder / source.stem
    asked = ["-fcallgraph-info=su"] if reports_stack() else []
    command = [compiler(), *FLAGS, *flags, *asked, f"-I{ROOT / 'cpp'}", f"-I{HERE}", "-c", source, "-o", f"{made}.o"]
    subprocess.run(command, check=True, cwd=folder)
    return made


def report(made, names):
    """The reach of each step of a compiled unit, by the controller's name; nothing where the compiler tells none."""
    if not made.with_suffix(".ci").exists():
        return {}
    graph = CallGraph.read(made.with_suffix(".ci").read_text())
    steps = {int(number[1]): function for function in graph.frames if (number := STEP.search(function))}
    return {name: graph.reach(steps[number]) for number, name in enumerate(names)}


def undefined_symbols(made):
    """What the object leaves to others, by `nm`."""
    said = subprocess.run(["nm", "-u", made.with_suffix(".o")], check=True, capture_output=True, text=True).stdout
    return {line.split()[-1] for line in said.splitlines()} - {"_GLOBAL_OFFSET_TABLE_"}
