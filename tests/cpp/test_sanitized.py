"""What `python -m tests.attack.sanitized` runs."""

from pathlib import Path

import pytest

from tests.attack.sanitized import LONG, PROGRAMS, ROOMS

TESTS = Path(__file__).parents[1]


@pytest.mark.parametrize("name", LONG)
def test_what_is_left_out_is_there_and_would_run(name):
    """Pytest says nothing of a test to leave out that has another name by now."""
    file, test = name.split("::")
    assert f"\ndef {test}(" in (TESTS / file).read_text()
    assert any(file.startswith(f"{room}/") or file == room for rooms in ROOMS for room in rooms)


def test_rooms_and_programs_are_there():
    assert all((TESTS / room).exists() for rooms in ROOMS for room in rooms)
    assert all((TESTS / "cpp" / f"{program}.cpp").exists() for program in PROGRAMS)
