"""What the command says of itself: examples that run, lines that fit the terminal, the nearest to a mistyped word."""

import shlex

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cogging.cli.main import COMMANDS, main
from cogging.cli.reproduce import PAPERS
from tests.fixtures.commands import diagnose_once, examples_of, of, words_of


@pytest.fixture
def examples(folder, monkeypatch):
    diagnose_once(monkeypatch)
    return folder


def help_of(capsys, *words):
    with pytest.raises(SystemExit) as ended:
        main([*words, "--help"])
    said = capsys.readouterr()
    assert (ended.value.code, said.err) == (0, "")
    return said.out


@pytest.mark.parametrize("command", COMMANDS)
def test_the_examples_run(command, examples, capsys):
    calls = examples_of(command)
    assert len(calls) >= (1 if command == "schema" else 2)
    shown = help_of(capsys, command)
    before = {path.name for path in examples.iterdir()}
    for words in calls:
        call = shlex.join(["cogging", *words])
        assert f"\n  {call}\n" in f"{shown}\n"
    for words in calls[1:] or calls:  # the first ones run in test_answers.py
        call = shlex.join(["cogging", *words])
        assert main(words) == 0, call
        said = capsys.readouterr()
        assert said.err == "", call
        assert said.out, call
        for output in (
            words[i + 1] for i, word in enumerate(words) if word in ("--out", "--json", "--report", "--figure")
        ):
            assert output == "-" or (examples / output).exists(), call
            assert output not in before, call


def test_the_commands_are_listed_also_without_one(capsys):
    whole = help_of(capsys)
    assert main(["help"]) == 0
    assert capsys.readouterr().out == whole
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
