"""The line of a key in a text, for errors that name it."""

import pytest

from cogging.files import line_of


@pytest.mark.parametrize(
    ("text", "section", "key", "line"),
    [
        ('[axis]\n"mass" = 1', "axis", "mass", 2),
        ("  [ axis ]  # of it\n  mass=1", "axis", "mass", 2),
        ("[[effects]]\nname = 'a'\n[[effects]]\nname = 'b'", "effects", "name", 2),
        ("[axis]\nmass = 1", "axis", "", 1),
        ("mass = 1\n[axis]\nmassive = 2", "axis", "mass", None),
        ("mass = 1\n[axis]\nmass = 2", "", "mass", 1),
    ],
)
def test_the_line_of_a_key(text, section, key, line):
    assert line_of(text, section, key) == line
