"""The nearest name to a mistyped one: a slip of the finger is understood, another word is not guessed at."""

import random
import string
from unittest import mock

import pytest

import cogging
from cogging.shown import nearest, nearest_name

FIELDS = sorted({field for effect in cogging.EFFECTS.values() for field in (effect.NAME, *effect.FIELDS)})
FIELDS = [name for name in FIELDS if len(name) > 5]
PATHS = ["axis.mass", "axis.viscous", "axis.coulomb", "axis.coulomb_width", "cogging.sine[0][1]", "encoder.resolution"]
OPTIONS = ["--columns", "--scale", "--rows", "--zero", "--model", "--out", "--json", "--confirm"]


def slip(name, draw):
    """A name with one letter left out, doubled, beside its place, or replaced; or capitals, or hyphens."""
    at = draw.randrange(1, len(name) - 1)
    kinds = [
        name[:at] + name[at + 1 :],
        name[:at] + name[at] + name[at:],
        name[:at] + name[at + 1] + name[at] + name[at + 2 :],
        name[:at] + draw.choice(string.ascii_lowercase) + name[at + 1 :],
        name.upper(),
        name.replace("_", "-"),
    ]
    return draw.choice(kinds)


@pytest.mark.parametrize("names", [FIELDS, PATHS, OPTIONS], ids=["fields", "paths", "options"])
def test_a_slip_is_understood(names):
    draw = random.Random(19)
    right = [nearest_name(slip(name, draw), names) == name for name in names for _ in range(10)]
    assert sum(right) > 0.97 * len(right)


@pytest.mark.parametrize("word", ["banana", "x", "", "qm", "temperature", "zzz", "\x1b[31m", "1e-3", "torque", "Zeit"])
def test_another_word_is_not_guessed_at(word):
    assert nearest(word, FIELDS) == nearest(word, PATHS) == nearest(word, OPTIONS) == ""


def test_the_end_of_a_message():
    assert nearest("mas", ["mass", "viscous"]) == " (did you mean 'mass'?)"
    assert nearest("mass", PATHS) == " (did you mean 'axis.mass'?)"
    assert nearest("pos", ["position", "command"]) == " (did you mean 'position'?)"  # the beginning of one alone
    assert nearest("ref", ["reference", "reference_velocity"]) == ""
    assert nearest("mass", []) == ""


def test_names_without_end_are_not_compared():
    """A header of many columns and a name of a megabyte: found by the attack, which waited for a minute."""
    many = [*(f"column_{number}" for number in range(16_384)), "x" * 100_000]
    with mock.patch("difflib.SequenceMatcher.find_longest_match", side_effect=AssertionError("compared")):
        assert nearest_name("x" * 100_000, many) is None
    assert nearest_name("x" * 200, ["x" * 199, "time"]) == "x" * 199
    assert nearest_name("colunm_777", many) == "column_777"
