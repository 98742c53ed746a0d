"""Help of the command, and numbers out of range."""

import re

import pytest

from cogging.cli.main import COMMANDS, main


def test_the_commands_are_listed_by_help_and_without_a_command(capsys):
    assert main(["help"]) == 0
    whole = capsys.readouterr().out
    assert all(f"    {command} " in whole for command in COMMANDS)
    with pytest.raises(SystemExit) as ended:
        main([])
    printed = capsys.readouterr()
    assert (ended.value.code, printed.out) == (2, whole)
    assert printed.err == "cogging: a command must be given, got none; see cogging --help\n"


@pytest.mark.parametrize(
    "words",
    ["sweep a.toml --threads 2000", "tune a.toml --threads -1", "predict a.toml --reference b.toml --samples 1"]
    + [f"simulate a.toml --reference b.toml --out c.csv {option}" for option in ("--seed -1", "--steps-per-sample x")],
)
def test_a_number_out_of_range_is_refused_with_its_option(words, capsys):
    with pytest.raises(SystemExit) as ended:
        main(words.split())
    option, value = words.split()[-2:]
    assert ended.value.code == 2
    assert re.search(
        f"argument {option}: must be a whole number from [012] to [0-9]+, got '{value}'", capsys.readouterr().err
    )
