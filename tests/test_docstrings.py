"""What is public says what it takes, gives and refuses, and shows it: the examples are run as a reader types them.

In an example stand `cogging`, `np`, and the `model`, `move` and `log` of the README's first lines.
"""

import doctest
import inspect
import re

import numpy as np
import pytest

import cogging
from tests.fixtures.examples import LOG, MODEL, MOVE

OPTIONS = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS
FUNCTIONS = [name for name in cogging.__all__ if inspect.isfunction(getattr(cogging, name))]
CLASSES = [
    name
    for name in cogging.__all__
    if inspect.isclass(getattr(cogging, name))
    and getattr(cogging, name).__module__.startswith("cogging.")
    and not getattr(cogging, name).__module__.startswith("cogging._core")
]
SECTION = re.compile(r"^(\w+):\n((?:[ ]{4}.*\n?|\n)+)", re.MULTILINE)


def documented():
    """Everything public with a docstring, by name: functions, classes and the methods that they define."""
    for name in cogging.__all__:
        value = getattr(cogging, name)
        yield name, value
        if inspect.isclass(value):
            for word, member in vars(value).items():
                if not word.startswith("_") and (callable(member) or isinstance(member, classmethod | property)):
                    yield f"{name}.{word}", getattr(value, word) if not isinstance(member, property) else member


def sections(text):
    """The named sections of a docstring."""
    return {found.group(1): found.group(2) for found in SECTION.finditer(text)}


DOCUMENTED = {name: inspect.getdoc(value) or "" for name, value in documented()}
SHOWN = sorted(name for name, text in DOCUMENTED.items() if ">>>" in text)


@pytest.mark.parametrize("name", SHOWN)
def test_examples_run(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    space = {"cogging": cogging, "np": np, "model": MODEL, "move": MOVE, "log": LOG}
    test = doctest.DocTestParser().get_doctest(DOCUMENTED[name], space, name, None, 0)
    assert test.examples
    told = []
    doctest.DocTestRunner(optionflags=OPTIONS, verbose=False).run(test, out=told.append)
    assert not told, "".join(told)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_says_what_it_takes_and_gives(name):
    function = getattr(cogging, name)
    found = sections(DOCUMENTED[name])
    parameters = inspect.signature(function).parameters
    if parameters:
        described = re.findall(r"^ {4}([\w, ]+):", found.get("Args", ""), re.MULTILINE)
        named = {word.strip() for line in described for word in line.split(",")}
        assert set(parameters) <= named, f"{name}: Args lack {sorted(set(parameters) - named)}"
        assert named <= set(parameters), f"{name}: Args have {sorted(named - set(parameters))} too many"
    if inspect.signature(function).return_annotation not in (None, "None"):
        assert found.get("Returns", "").strip(), f"{name}: lacks Returns"
    source = inspect.getsource(inspect.unwrap(function))
    assert "raise " not in source or found.get("Raises", "").strip(), f"{name}: lacks Raises"
    assert name in SHOWN, f"{name}: lacks an example"


def test_what_the_core_offers_is_shown():
    """Functions, and classes that users make; errors are raised, and a compiled controller needs a compiler."""
    values = {name: getattr(cogging, name) for name in cogging.__all__ if callable(getattr(cogging, name))}
    core = {name: value for name, value in values.items() if value.__module__.startswith("cogging._core")}
    raised = {name for name, value in core.items() if inspect.isclass(value) and issubclass(value, Exception)}
    lacking = set(core) - set(SHOWN) - raised
    assert len(core) > 30
    assert lacking == {"CompiledController", "Reference"}


@pytest.mark.parametrize("name", CLASSES)
def test_a_class_says_what_it_holds(name):
    kind = getattr(cogging, name)
    if issubclass(kind, Exception | tuple):
        return
    attributes = sections(DOCUMENTED[name]).get("Attributes", "")
    for field in getattr(kind, "__dataclass_fields__", ()):
        assert re.search(rf"\b{field}\b", attributes), f"{name}: Attributes lack {field}"
    for word, member in vars(kind).items():
        if not word.startswith("_") and (inspect.isfunction(member) or isinstance(member, classmethod)):
            assert inspect.getdoc(getattr(kind, word)), f"{name}.{word}: lacks a docstring"
