"""Help of the command, and the nearest right word to a mistyped one."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cogging.cli.main import COMMANDS, main
from cogging.cli.reproduce import PAPERS
from tests.fixtures.commands import of, words_of


def test_the_commands_are_listed_by_help_and_without_a_command(capsys):
    assert main(["help"]) == 0
    whole = capsys.readouterr().out
    assert all(f"    {command} " in whole for command in COMMANDS)
    with pytest.raises(SystemExit) as ended:
        main([])
    said = capsys.readouterr()
    assert ended.value.code == 2, "a script that has lost its command is told"
    assert said.out == whole
    assert said.err == "cogging: a command must be given, got none; see cogging --help\n"


@settings(deadline=None, max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_mistyped_word_is_answered_with_the_nearest(data, capsys):
    """A letter too few, too many, another one, or two that have changed places."""
    command = data.draw(st.sampled_from(COMMANDS))
    known = [name for action in of(command)._actions for name in action.option_strings if len(name) > 4]
    meant = data.draw(st.sampled_from([command, *known]))
    at = data.draw(st.integers(3 if meant.startswith("--") else 1, len(meant) - 1))
    letter = data.draw(st.sampled_from("aeioutrx"))
    swapped = meant[: at - 1] + meant[at] + meant[at - 1] + meant[at + 1 :] if at > 3 else meant
    ways = [meant[:at] + meant[at + 1 :], meant[:at] + letter + meant[at:], meant[:at] + letter + meant[at + 1 :]]
    wrong = data.draw(st.sampled_from([*ways, swapped]))
    if wrong in (*known, *COMMANDS) or (wrong.startswith("--") and any(name.startswith(wrong) for name in known)):
        return  # a word, or the beginning of one
    words = [wrong] if meant == command else [*words_of(command), wrong, *data.draw(st.sampled_from([[], ["x"]]))]
    with pytest.raises(SystemExit) as ended:
        main(words)
    said = capsys.readouterr()
    assert (ended.value.code, said.out, said.err.count("\n")) == (2, "", 1)
    assert f"(did you mean '{meant}'?)" in said.err


def test_an_option_that_hides_a_needed_one_is_named(capsys):
    with pytest.raises(SystemExit):
        main(["identify", "log.csv", "--modle", "model.toml"])
    assert "required: --model, got '--modle' (did you mean '--model'?)" in capsys.readouterr().err


@pytest.mark.parametrize(("words", "known"), [(["help", "dignose"], COMMANDS), (["reproduce", "lu2009"], PAPERS)])
def test_a_mistyped_value_is_answered_with_the_nearest(words, known, capsys):
    assert main(words) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert f"must be one of {', '.join(known)}, got '{words[1]}' (did you mean '" in said
