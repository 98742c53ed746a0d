"""Empirical terms."""

import numpy as np

import cogging
from tests.fixtures.pid_axis import MODEL, other, run

effects = cogging.effects


def test_what_no_effect_explains_is_added_where_it_is_asked_for(tmp_path):
    """A magnetic strip under a part of the travel, say: a force that no law of the vocabulary has."""
    places = np.linspace(0.0, 0.51, 103)
    bump = 0.08 * np.exp(-(((places - 0.26) / 0.06) ** 2))
    hidden = effects.EmpiricalForce(position_nodes=list(places), position_forces=list(bump))
    result = cogging.diagnose(run(hidden), MODEL, confirm=other(hidden), empirical=True)
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
