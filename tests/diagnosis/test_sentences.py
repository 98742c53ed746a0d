"""Sentences of a result, by rule over drawn results: no headline contradicts the shares and confidences beside it."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import cogging
from cogging.diagnosis.entries import Value
from cogging.diagnosis.report import sentences
from cogging.diagnosis.report.words import harmonic_text, plain
from cogging.effects.effect import VOCABULARY
from tests.fixtures.drawn_results import VERDICTS, drawn_result

SYMBOLS = {"x": "position", "v": "velocity", "t": "time"}
SHAPED = ("force", "friction_level", "command_gain", "shape_command", "reading")


def of_the_law(effect):
    """Coordinates of the formula as it is printed, without the S(v) that every friction level has."""
    formula = effect.LAW.replace("S(v)", "")
    found = {SYMBOLS[symbol] for symbol in re.findall(r"\b[xvt]\b", formula)}
    return found or ({"command"} if "shape_command" in effect.HOOKS else {"position"})


@pytest.fixture(scope="module")
def results():
    """Drawn results of every verdict, dozens of each."""
    generator = np.random.default_rng(19)
    return [drawn_result(generator, verdict) for verdict in VERDICTS for _ in range(30)]


def test_a_headline_says_what_was_found_before_what_was_not(results):
    """That nothing known explains the gap is said only where nothing was found."""
    for result in results:
        said = sentences.headline(result)
        assert ("no known effect explains" in said) is (result.verdict == "unlisted" and not result.effects)
        assert ("is unexplained" in said) is (result.verdict == "unlisted" and bool(result.effects))
        assert said.startswith("The model lacks ") is bool(result.effects)
        assert ("Nothing is missing" in said) is (result.verdict == "no_gap")


def test_a_headline_is_as_sure_as_its_names(results):
    """In the order of their shares; an uncertain name comes with `either`, `probably` or `perhaps`."""
    told = 0
    for result in (one for one in results if one.effects):
        said = sentences.headline(result)
        first = result.effects[0]
        doubted = said.removeprefix("The model lacks ").startswith(("either ", "probably ", "perhaps "))
        assert doubted is not first.is_sure
        assert f"{sentences.percent(first.share)} of the gap)" in said
        doubts = sum(not effect.is_sure for effect in result.effects[:2])
        assert sum(said.count(word) for word in ("either ", "probably ", "perhaps ")) == doubts
        assert ("some of them uncertain" in said) is not all(effect.is_sure for effect in result.effects[2:])
        for effect in result.effects[:2]:
            if not effect.is_sure and not effect.alternatives:
                word = "probably" if effect.confidence >= 0.5 else "perhaps"
                sure = sentences.percent(effect.confidence)
                assert f"{word} {sentences.name_text(effect)} (confidence {sure}" in said
                told += 1
    assert told > 10


def test_the_printed_answer_is_short_and_all_of_it_is_asked_for(results):
    """With the files written and the next command, 15 lines of 100 characters; mass and friction old and new."""
    for result in results:
        lines = result.text().splitlines()
        assert len(lines) <= 13
        assert max(map(len, lines)) <= 100
        assert lines[0] == f"verdict: {result.verdict}"
        assert "mass: 0.12 -> 0.12 V/(m/s^2)" in result.text() or "gap_before" not in result.series
        assert (len(result.text(verbose=True)) > len(result.text())) or not result.series
        for effect in result.effects[:1]:
            if effect.alternatives:
                assert f"{effect.name} or " in result.text()


def test_the_share_of_a_headline_is_that_of_the_gap(results):
    for result in (one for one in results if one.effects and one.verdict == "unlisted"):
        said, share = sentences.headline(result), re.search(r"explains (\d+) % of the gap", sentences.headline(result))
        if result.gap.closed is None:
            assert "explains" not in said
        elif share is None:
            assert sentences.HARDLY in said
            assert result.gap.closed < 0.05
            assert "most of it is unexplained" in said
        else:
            assert abs(int(share[1]) - 100.0 * result.gap.closed) <= 1.0
            assert "most of it" not in said


def test_that_something_is_there_is_not_what_it_is_called(results):
    """How far it stands out and how sure its name is are told apart, and neither lends itself to the other."""
    for result in results:
        for effect in result.effects:
            there, called = sentences.standing_text(effect), sentences.certainty_text(effect, result.vocabulary)
            assert plain(effect.name) not in there
            assert f"{np.sqrt(effect.statistic):.0f} standard deviations" in there
            assert plain(effect.name) in called
            assert sentences.percent(effect.confidence) in called
            assert "never" not in called
            assert "standard deviations" not in called
            assert ("not enough" in called or "instead" in called) is not effect.is_sure


def test_ambiguous_says_which_names_which_of_them_how_sure_and_what_they_share(results):
    """Also where the name itself has 97 %."""
    seen = set()
    for result in results:
        doubted = [effect for effect in result.effects if not effect.is_sure]
        for effect in doubted:
            told = sentences.doubt_text(effect, result.vocabulary)
            for name in (effect.name, *effect.alternatives):
                assert plain(name).casefold() in told.casefold()
            assert sentences.percent(effect.confidence) in told
            assert sentences.shared_text(effect, result.vocabulary) in told or not effect.alternatives
            seen.add((bool(effect.alternatives), effect.confidence >= 0.9))
        for effect in doubted[:2]:
            assert sentences.doubt_text(effect, result.vocabulary) in sentences.meaning(result)
        assert len(sentences.meaning(result)) <= 4
        assert all(sentences.doubt_text(effect, result.vocabulary) == "" for effect in result.effects if effect.is_sure)
    assert seen == {(True, True), (True, False), (False, False)}


@pytest.mark.parametrize("name", [name for name in VOCABULARY if set(VOCABULARY[name].HOOKS) & set(SHAPED)])
def test_an_effect_is_said_to_act_along_what_stands_in_its_formula(name):
    """By its parameters' roles alone, which a custom effect has too; a constant acts everywhere."""
    along = sentences.along_of(name, VOCABULARY)
    law = VOCABULARY[name]
    free = not re.search(r"\b[xvt]\b", law.LAW.replace("S(v)", "")) and "force" in law.HOOKS
    assert (along == "") if free or name == "empirical_force" else along in of_the_law(law)


def test_screen_and_page_say_the_same(found):
    """Of a true result, and of one whose name is doubted."""
    assert re.fullmatch(r"The model lacks viscous asymmetry \(\d+ % of the gap\)", sentences.headline(found))
    doubted = replace(found.effects[0], confidence=0.36, alternatives=("quadratic_drag",))
    told = replace(found, verdict="ambiguous", effects=(doubted,))
    for said in (found.text(), told.text()):
        assert said.splitlines()[1].startswith("The model lacks ")
    assert sentences.headline(told).startswith("The model lacks either viscous asymmetry or quadratic drag (")
    assert "viscous_asymmetry or quadratic_drag: confidence 0.36" in told.text(verbose=True)
    assert "confidence that it is viscous_asymmetry: 36 %; both depend on velocity" in told.text(verbose=True)
    assert sentences.explained_text(found.gap).endswith("of the gap")


@pytest.mark.parametrize(
    ("period", "said"), [(0.012, " (harmonic 2 of the known 0.024 m)"), (0.0125, ""), (0.03, "")], ids=str
)
def test_a_wave_is_said_to_be_a_harmonic_of_the_known_pitch(period, said):
    known = cogging.CoggingModel(cogging.SplineHarmonics(pitch=0.024, harmonics=[1]), sine=[[0.1]], cosine=[[0.0]])
    model = cogging.Model(cogging.AxisParameters(mass=1.0), cogging=known)
    wave = SimpleNamespace(parameters={"period": Value(period, "m", (None, None))})
    assert harmonic_text(wave, model) == said
