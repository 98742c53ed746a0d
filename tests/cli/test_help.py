"""Help of the command, and the nearest right word to a mistyped one."""

import random

import pytest

from cogging.cli.main import COMMANDS, main
from tests.fixtures.commands import of, words_of


def test_the_commands_are_listed_by_help_and_without_a_command(capsys):
    assert main(["help"]) == 0
    whole = capsys.readouterr().out
    assert all(f"    {command} " in whole for command in COMMANDS)
    with pytest.raises(SystemExit) as ended:
        main([])
    printed = capsys.readouterr()
    assert (ended.value.code, printed.out) == (2, whole)
    assert printed.err == "cogging: a command must be given, got none; see cogging --help\n"


def test_the_nearest_word_to_a_mistyped_one_is_offered(capsys):
    """A letter too few, too many, another one, or two that have changed places."""
    draw = random.Random(3)
    tried = 0
    while tried < 25:
        command = draw.choice(COMMANDS)
        known = [name for name in of(command)._option_string_actions if len(name) > 4]
        meant = draw.choice([command, *known])
        at, letter = draw.randrange(3 if meant.startswith("--") else 1, len(meant)), draw.choice("aeioutrx")
        before, here, after = meant[:at], meant[at], meant[at + 1 :]
        ways = [before + after, before + letter + here + after, before + letter + after]
        if at > 3:
            ways.append(before[:-1] + here + before[-1] + after)
        wrong = draw.choice(ways)
        if wrong in COMMANDS or any(name.startswith(wrong) for name in known):
            continue
        with pytest.raises(SystemExit) as ended:
            main([wrong] if meant == command else [*words_of(command), wrong])
        printed = capsys.readouterr()
        assert (ended.value.code, printed.out, printed.err.count("\n")) == (2, "", 1)
        assert f"(did you mean '{meant}'?)" in printed.err
        tried += 1


def test_an_option_that_hides_a_needed_one_and_a_mistyped_value(capsys):
    with pytest.raises(SystemExit):
        main(["identify", "log.csv", "--modle", "model.toml"])
    assert "required: --model, got '--modle' (did you mean '--model'?)" in capsys.readouterr().err
    assert main(["help", "dignose"]) == 2
    assert f"must be one of {', '.join(COMMANDS)}, got 'dignose' (did you mean '" in capsys.readouterr().err
