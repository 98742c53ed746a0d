"""Thresholds of the diagnosis: in one file, each with its meaning, and none that anybody can move."""

import ast
import re
from dataclasses import FrozenInstanceError, fields, is_dataclass
from pathlib import Path

import pytest

from cogging.diagnosis import thresholds

ROOM = Path(thresholds.__file__).parent
MODULES = {str(path.relative_to(ROOM)): ast.parse(path.read_text()) for path in sorted(ROOM.rglob("*.py"))}
OTHERS = {name: tree for name, tree in MODULES.items() if name != "thresholds.py"}
STEPS = {name: value for name, value in vars(thresholds).items() if name.isupper()}
#: `name: type = value  # unit: meaning [what set it]`
MEANING = re.compile(r"\s+(\w+): [^#]* = [^#]*  # [^:\n]+: [^\[\]\n]{8,} \[[^\[\]\n]+\]")


def numbers(node):
    """Numbers that stand in a piece of code, places in a sequence apart."""
    if isinstance(node, ast.Subscript):
        return numbers(node.value)
    if isinstance(node, ast.Constant):
        return [node.value] if type(node.value) in (int, float) else []
    return [value for child in ast.iter_child_nodes(node) for value in numbers(child)]


def constants(tree):
    """What a module assigns at its top from numbers."""
    for node in tree.body:
        if isinstance(node, ast.Assign | ast.AnnAssign | ast.AugAssign) and node.value and numbers(node.value):
            yield ast.unparse(node)


def compared(tree):
    """Comparisons with a number, but with a count, a unit, or what keeps a divisor from zero."""
    for node in ast.walk(tree):
        sides = (node.left, *node.comparators) if isinstance(node, ast.Compare) else ()
        if any(abs(value) not in (0, 1, 2, 1e-300) for side in sides for value in numbers(side)):
            yield ast.unparse(node)


@pytest.mark.parametrize("name", OTHERS)
def test_no_other_module_has_a_constant_of_its_own(name):
    assert list(constants(OTHERS[name])) == []


@pytest.mark.parametrize("name", OTHERS)
def test_nothing_is_decided_by_a_number_without_a_name(name):
    assert list(compared(OTHERS[name])) == []


def test_a_constant_and_a_nameless_number_would_be_seen():
    tree = ast.parse("A = 3.0\nB: int = 2 * A\nC = ('a', None)\nif x > 0.85 or x == 2 or -60.0 < x: pass")
    assert list(constants(tree)) == ["A = 3.0", "B: int = 2 * A"]
    assert list(compared(tree)) == ["x > 0.85", "-60.0 < x"]


def test_every_threshold_has_unit_meaning_and_what_set_it():
    lines = Path(thresholds.__file__).read_text().splitlines()
    told = [match[1] for match in map(MEANING.fullmatch, lines) if match]
    assert told == [field.name for step in STEPS.values() for field in fields(step)]
    assert len(told) > 200


def test_no_name_has_two_meanings():
    names = [field.name for step in STEPS.values() for field in fields(step)]
    assert sorted(set(names)) == sorted(names)
    classes = {name for name, value in vars(thresholds).items() if is_dataclass(value) and isinstance(value, type)}
    assert sorted(type(step).__name__ for step in STEPS.values()) == sorted(classes)


@pytest.mark.parametrize("step", STEPS)
def test_thresholds_are_frozen(step):
    values = STEPS[step]
    for field in fields(values):
        with pytest.raises(FrozenInstanceError):
            setattr(values, field.name, 0.0)
        hash(getattr(values, field.name))  # a list could be changed in place


def test_every_threshold_is_read():
    read = {node.attr for tree in OTHERS.values() for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    assert {field.name for step in STEPS.values() for field in fields(step)} <= read
