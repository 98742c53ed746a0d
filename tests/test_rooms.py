"""The rooms of the house: packages are nouns, nothing shadows, and each uses only what stands above it."""

import ast
import importlib
import pkgutil
import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import cogging

PACKAGE = Path(cogging.__file__).parent
TESTS = Path(__file__).parent
#: What every room may use.
BASE = {"_core", "arrays", "blas_threads", "calls", "core_values", "correlation", "cpp_library", "effects"}
BASE |= {"file_locks", "file_sets", "files", "linear", "memory", "outputs", "progress", "shown", "tables", "threads"}
BASE |= {"values"}
#: The rooms in their order: packages, and one module.
ROOMS = ["plot", "model", "logs", "simulation", "file_schema", "log_check", "estimation", "mapping", "friction"]
ROOMS += ["identification", "first_model", "diagnosis", "design", "export", "papers", "datasets", "cli"]
#: The same within `diagnosis`.
DIAGNOSIS = ["labelled", "thresholds", "physical", "evidence", "candidates", "large", "residual", "discrepancy"]
DIAGNOSIS += ["entries", "balance", "separating"]
DIAGNOSIS += [
    "next_step",
    "report",
    "location",
    "locate",
    "result",
    "search",
    "patched",
    "naming",
    "limits",
    "gaps",
    "assembly",
    "diagnose",
]
FACE = {"__init__", "__main__"}  # they use rooms, and no room uses them


def modules():
    """Path of every module of the package by its dotted name."""
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
        yield ".".join(parts[:-1] if parts[-1] == "__init__" else parts), path


MODULES = dict(modules())


def imports(path):
    """What a module imports of the package when it runs, at its top or in a function; not for types alone."""
    tree = ast.parse(path.read_text())
    typing = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
        for inner in ast.walk(node)
    }
    for node in ast.walk(tree):
        if id(node) in typing:
            continue
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "cogging":
            assert node.level == 0
            for name in node.names:
                full = f"{node.module}.{name.name}"
                yield full if full in MODULES or full == "cogging._core" else node.module
        elif isinstance(node, ast.Import):
            yield from (name.name for name in node.names if name.name.split(".")[0] == "cogging")


GRAPH = {name: {used for used in imports(path) if used != name} for name, path in MODULES.items()}


def test_every_module_is_what_its_name_says():
    """`import a.b as c` gives the module a.b: nothing of another kind stands at its name."""
    found = [module.name for module in pkgutil.walk_packages(cogging.__path__, "cogging.")]
    assert len(found) > 90
    for name in found:
        if name.endswith("__main__"):
            continue
        space = {}
        exec(f"import {name} as module", space)
        assert space["module"] is sys.modules[name]


def test_what_the_package_shows_is_all():
    assert dir(cogging) == sorted(cogging.__all__)
    for name in cogging.__all__:
        assert hasattr(cogging, name), name
    packages = {path.name for path in PACKAGE.iterdir() if path.is_dir()}
    verbs = {name for name in cogging.__all__ if callable(getattr(cogging, name))}
    assert not packages & verbs


def test_no_circle():
    graph = {name: {used for used in uses if used in GRAPH} for name, uses in GRAPH.items() if name != "cogging"}
    for uses in graph.values():
        uses.discard("cogging")  # `from cogging import effects`: a base module, asked for below
    order = list(TopologicalSorter(graph).static_order())  # raises CycleError
    assert len(order) == len(MODULES) - 1


def room(module):
    parts = module.split(".")
    return parts[1] if len(parts) > 1 else "__init__"


def test_the_order_of_rooms():
    order = [*sorted(BASE), *ROOMS, *sorted(FACE)]
    for module, uses in GRAPH.items():
        for own, other in ((room(module), room(used)) for used in uses):
            if {own, other} <= BASE:
                continue
            assert order.index(other) <= order.index(own) or module == "cogging.__main__", f"{module} uses {other}"
            assert other not in FACE or own in FACE, f"{module} uses {other}"


def test_the_order_within_diagnosis():
    for module, uses in GRAPH.items():
        if not module.startswith("cogging.diagnosis."):
            continue
        for used in uses:
            if used.startswith("cogging.diagnosis."):
                own, other = (name.split(".")[2] for name in (module, used))
                assert DIAGNOSIS.index(other) <= DIAGNOSIS.index(own), f"{module} uses {used}"


def test_a_report_only_renders():
    """A result, its location and their pages rest on nothing that fits, predicts or tests."""
    shown = {name for name in GRAPH if name.startswith("cogging.diagnosis.report.")}
    shown |= {f"cogging.diagnosis.{name}" for name in ("result", "location", "entries", "next_step")}
    assert len(shown) > 6
    todo, seen = set(shown), set()
    while todo:
        name = todo.pop()
        seen.add(name)
        todo |= {used for used in GRAPH.get(name, ()) if used.startswith("cogging.diagnosis.")} - seen
    held = {f"cogging.diagnosis.residual{name}" for name in ("", ".shape", ".location_words")}
    held |= {"cogging.diagnosis.thresholds", "cogging.diagnosis.labelled"}
    assert seen <= shown | held | {"cogging.diagnosis", "cogging.diagnosis.report"}
    estimation = {used for name in seen for used in GRAPH.get(name, ()) if used.startswith("cogging.estimation")}
    assert estimation <= {"cogging.estimation.statistics"}  # the moving average of a drawn trace


def test_rooms_are_all_there():
    inside = [path for path in PACKAGE.iterdir() if path.name != "__pycache__"]
    packages = {path.name for path in inside if path.is_dir()} - {"include", "share"}  # of C++, where it is installed
    files = {path.stem for path in inside if path.suffix == ".py"}
    assert packages | files == BASE | set(ROOMS) | FACE


def test_importing_one_module_needs_no_other_first():
    """A module of every room, each in a process of its own."""
    for name in ("cogging.model.intervals", "cogging.diagnosis.residual.shapes", "cogging.papers.xu2001.setup"):
        done = subprocess.run([sys.executable, "-c", f"import {name}"], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr


# The tests ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", sorted(TESTS.rglob("*.py")), ids=lambda path: str(path.relative_to(TESTS)))
def test_no_test_imports_a_test(path):
    for node in ast.walk(ast.parse(path.read_text())):
        names = []
        if isinstance(node, ast.ImportFrom):
            names = [node.module or "", *(name.name for name in node.names)]
        elif isinstance(node, ast.Import):
            names = [name.name for name in node.names]
        assert not any(part.startswith("test_") for name in names for part in name.split(".")), path


def test_the_tests_mirror_the_rooms():
    folders = {path.name for path in TESTS.iterdir() if path.is_dir() and any(path.glob("test_*.py"))}
    core = {"basis", "reference", "plant", "control", "simulation", "estimation"}
    assert {name for name in ROOMS if (PACKAGE / name).is_dir()} | core <= folders
    assert folders - set(ROOMS) - core <= {"golden", "benchmarks", "bindings", "blind", "cpp", "site"}
    assert not list((TESTS / "fixtures").glob("test_*.py"))


def test_modules_say_what_they_hold():
    for name in MODULES:
        assert importlib.import_module(name).__doc__ or name.endswith("__main__"), name
