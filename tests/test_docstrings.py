"""The examples of docstrings run as a reader types them.

In an example stand `cogging`, `np`, and the `model`, `move` and `log` of the README's first lines.
"""

import doctest
import inspect

import numpy as np
import pytest

import cogging
from tests.fixtures.examples import LOG, MODEL, MOVE

OPTIONS = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS


def documented():
    """Everything public, by name: functions, classes and what they define."""
    for name in cogging.__all__:
        value = getattr(cogging, name)
        yield name, value
        if inspect.isclass(value):
            yield from ((f"{name}.{word}", member) for word, member in vars(value).items() if word[0] != "_")
    yield from ((f"plot.{name}", getattr(cogging.plot, name)) for name in cogging.plot.__all__)
    yield from ((f"effects.{name}", effect) for name, effect in cogging.EFFECTS.items())


TEXTS = {name: inspect.getdoc(value) or "" for name, value in documented()}
#: That of `ledger` takes a diagnosis.
STUDIES = {"plot.ledger"}
NAMES = sorted(name for name, text in TEXTS.items() if ">>>" in text)


@pytest.mark.parametrize("name", [pytest.param(one, marks=[pytest.mark.study] * (one in STUDIES)) for one in NAMES])
def test_examples_run(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    space = {"cogging": cogging, "np": np, "model": MODEL, "move": MOVE, "log": LOG}
    test = doctest.DocTestParser().get_doctest(TEXTS[name], space, name, None, 0)
    said = []
    doctest.DocTestRunner(optionflags=OPTIONS, verbose=False).run(test, out=said.append)
    assert not said, "".join(said)
