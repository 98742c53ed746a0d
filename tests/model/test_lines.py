"""The line of a key in a text, for errors that name it."""

import pytest

from cogging.files import line_of


@pytest.mark.parametrize("blank", [" " * 200_000, "[" + " " * 200_000, "[[" + " \t" * 100_000 + "x", "'" * 200_000])
def test_the_line_of_a_fault_is_found_behind_lines_without_end(blank):
    text = f"a = '''\n{blank}\n'''\n[axis]\nmass = -1.0\n"
    assert line_of(text, "axis", "mass") == 5


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
