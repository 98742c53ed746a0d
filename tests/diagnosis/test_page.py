"""The report."""

from dataclasses import replace

import numpy as np
import pytest
from markupsafe import escape

from cogging.diagnosis.entries import NearRest, ShapeTerm
from cogging.diagnosis.report.pictures import pictures_of
from tests.fixtures.drawn_results import drawn_result


def test_a_report_without_its_library_says_what_to_install(found, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "jinja2", None)
    with pytest.raises(ValueError, match=r"a report needs jinja2: pip install 'cogging\[report\]'"):
        found.html()


def test_the_report_says_what_why_and_what_next(found):
    page = found.html(title="log <1>")
    assert "log &lt;1&gt;" in page
    for words in (
        "viscous asymmetry",
        "standard deviations out of the noise",
        "Check on other motion",
        "Before and after",
        "Everything that was tried in earnest",
        "effects.viscous_asymmetry.difference",
        "How to read this page",
    ):
        assert words in page, words
    assert found.location.lines()
    assert all(str(escape(line)) in page for line in found.location.lines())
    assert len(found.plot().axes) == 4


def test_a_shape_of_its_own_and_friction_near_rest_stand_on_page_and_screen(found):
    term = ShapeTerm(
        "position near the ends",
        "m",
        [0.0, 0.01, 0.5, 0.49],
        [0.2, 0.1, -0.3, -0.1],
        [0.01, 0.02, 0.03, np.inf],
        812.0,
        0.3,
        {"coordinate": "position", "places": [0.0, 0.01], "force": [0.2, 0.1]},
    )
    friction = NearRest(93.0, 6, -40.0, -20.0, ("presliding_friction", "stribeck_friction"), "creep at five speeds")
    told = replace(found, effects=(replace(found.effects[0], shape_term=term),), near_rest=friction)
    page, text = told.html(), told.text()
    for words in (
        "viscous asymmetry of a shape of its own",
        "of another shape than its plainest law, T = 812 in position near the ends: +0.2 more about 0 m",
        "What viscous asymmetry has beside its plainest law",
        "Friction near rest",
        "this motion cannot tell which law it follows",
        "presliding friction or stribeck friction",
        "To tell the friction near rest: creep at five speeds.",
    ):
        assert words in page, words
    assert page.count("data:image/png") == found.html().count("data:image/png") + 1
    for words in ("of another shape than its plainest law, T = 812", "near rest the friction is not the model's"):
        assert words in text, words
        assert words not in found.text()
    assert "Friction near rest" not in found.html()


def test_a_way_that_the_axis_did_not_move_has_no_empty_picture():
    """Of an axis that only moved forward: neither a profile nor a folded period backward."""
    result = drawn_result(np.random.default_rng(1), "ambiguous")
    one_way = [np.asarray(result.series["velocity"][0]) > 0.01]
    pictures = pictures_of(replace(result, series={**result.series, "mask": one_way}))
    both = pictures_of(result)
    for part, lost in (("coordinates", 1), ("folded", 1), ("time", 0)):
        assert len(pictures[part]) == len(both[part]) - lost
    assert not any("backward" in one.finding for part in pictures.values() for one in part if "Gap" in one.finding)
