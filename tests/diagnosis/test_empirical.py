"""Empirical terms."""

from dataclasses import replace

import numpy as np
import pytest

import cogging
from cogging.diagnosis.search.empirical import NoTerm, with_term
from cogging.diagnosis.search.search import search as search_logs
from tests.fixtures.pid_axis import MODEL, other, run

effects = cogging.effects


def test_what_no_effect_explains_is_added_where_it_is_asked_for(tmp_path):
    """A magnetic strip under a part of the travel, say: a force that no law of the vocabulary has."""
    places = np.linspace(0.0, 0.51, 103)
    bump = 0.08 * np.exp(-(((places - 0.26) / 0.06) ** 2))
    hidden = effects.EmpiricalForce(position_nodes=list(places), position_forces=list(bump))
    logs, confirm = [run(hidden), run(hidden, velocity=0.1, seed=5)], other(hidden)
    result = cogging.diagnose(logs, MODEL, confirm=confirm, empirical=True)
    assert result.verdict == "unlisted"
    assert result.unlisted["coordinate"] == "position"
    told = result.unlisted["added"]
    assert told["name"] == "empirical_force"
    assert told["signal"] == result.gap.signal
    assert told["gap_before"] == result.gap.after
    assert told["gap_after"] < 0.8 * told["gap_before"]
    assert told["confirm_after"] < 0.9 * told["confirm_before"]
    assert "empirical and names no cause" in result.text()
    assert "empirical and names no cause" in result.html()
    within = np.linspace(0.1, 0.38, 57)
    found = sum(effect.force_at(position=within) for effect in result.model.effects if hasattr(effect, "force_at"))
    assert np.corrcoef(found, np.interp(within, places, bump))[0, 1] > 0.95
    path = tmp_path / "patched.toml"
    result.model.write(path)
    again = cogging.Model.read(path)
    assert again.effects == result.model.effects
    assert len(run(*again.effects, duration=0.5)) > 500
    plain = cogging.diagnose(logs, MODEL, confirm=confirm)
    assert "added" not in plain.unlisted
    assert "empirical_force" not in [effect.NAME for effect in plain.model.effects]


def test_a_term_that_has_no_function_or_does_not_pay_is_not_added():
    log, confirm = run(effects.ConstantForce(force=0.02)), other(effects.ConstantForce(force=-0.02))
    found = search_logs([log], MODEL)
    with pytest.raises(NoTerm, match="no empirical term is a function of command: it is described, not added"):
        with_term(found, {"coordinate": "command", "places": [0.0, 1.0], "force": [0.0, 1.0]}, MODEL, [log])
    with pytest.raises(NoTerm, match="stands for what has no places: it is described, not added"):
        with_term(found, {"coordinate": "time", "shape": "bursts"}, MODEL, [log])
    rest = {"coordinate": "time", "places": [0.0, 4.0], "force": [0.02, 0.02]}
    assert with_term(found, rest, MODEL, [log])[1]["gap_after"] < 0.01
    elsewhere = replace(found, yardstick=replace(found.yardstick, confirm=[confirm]))
    with pytest.raises(NoTerm, match="an empirical term does not pay: the gap on the other motion goes from"):
        with_term(elsewhere, rest, MODEL, [log])
