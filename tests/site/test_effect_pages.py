"""The catalogue shows of an effect what it does: the figure its force, the page its fields and its example."""

import numpy as np
import pytest
from effect_pages import lacking, page

from cogging.effects.effect import VOCABULARY, laws_of
from tests.fixtures.plants_by_hand import example

FORCES = sorted(name for name, law in VOCABULARY.items() if set(law.HOOKS) == {"force"})


@pytest.mark.parametrize("name", FORCES)
def test_what_the_figure_of_a_force_shows_is_its_law(name):
    effect = example(name)
    rows = lacking(effect)
    force = laws_of(effect).force_at(**{key: rows[key] for key in ("position", "velocity", "time")})
    moving = np.abs(rows["velocity"]) > 0.02  # below it, the steep friction of the readings' differences
    shown, force = rows["lacking"][moving], np.asarray(force)[moving]
    assert shown @ force / (force @ force) == pytest.approx(1.0, abs=0.05)
    assert shown @ force > 0.98 * np.linalg.norm(shown) * np.linalg.norm(force)


@pytest.mark.parametrize("name", VOCABULARY)
def test_a_page_has_law_fields_and_figure(name):
    effect = example(name)
    rows, text = lacking(effect), page(effect, "A figure.")
    assert np.isfinite(rows["lacking"]).all()
    assert np.abs(rows["lacking"]).max() > 1e-3
    assert effect.LAW in text
    assert all(f"| `{field}` |" in text for field in effect.FIELDS)
