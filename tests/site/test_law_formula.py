"""The laws that the core writes in plain characters, set as formulas: nothing of them is lost on the way."""

import re

import numpy as np
import pytest
from law_formula import formula

from cogging.effects.effect import VOCABULARY

WORDS = re.compile(r"[A-Za-z]\w*|\d+")


def words_of(tex):
    """Names and numbers of a formula, in their order, as they were before they were set."""
    plain = tex.replace(r"\_", "_").replace(r"\,", " ")
    plain = re.sub(r"([A-Za-z])_\{(\w+)\}", r"\1\2", plain)
    plain = re.sub(r"\\ddot\{(.*?)\}", r"\1''", plain)
    plain = re.sub(r"\\(mathsf|text|operatorname|dot)\b|\\(begin|end)\{gathered\}|\\quad|\\\\", " ", plain)
    return WORDS.findall(plain.replace("\\", " "))


@pytest.mark.parametrize("name", VOCABULARY)
def test_each_word_of_a_law_stands_in_its_formula(name):
    law = VOCABULARY[name]
    tex = formula(law.LAW, law.FIELDS)
    wanted = WORDS.findall(law.LAW.replace("<=", "le"))
    assert words_of(tex) == wanted
    assert tex.count("{") == tex.count("}")
    assert tex.count("(") == tex.count(")")
    spelled = set(re.findall(r"\\mathsf\{(.*?)\}", tex))
    named = {field.replace("_", r"\_") for field in law.FIELDS if re.search(rf"\b{field}\b", law.LAW)}
    assert named <= spelled


@pytest.mark.parametrize("seed", range(20))
def test_drawn_laws_keep_their_words(seed):
    random = np.random.default_rng(seed)
    fields = [f"{a}_{b}" for a in ("static", "decay") for b in ("excess", "length")] + ["gain", "x1y"]
    symbols = ["x", "v", "t", "x0", "m1", "sin", "exp", "pi", "2", "17"]
    words = [str(random.choice([*fields, *symbols])) for _ in range(random.integers(2, 12))]
    law = "".join(f" {random.choice(['+', '-', '/', ''])} {word}" for word in words)
    assert words_of(formula(law, fields)) == words
