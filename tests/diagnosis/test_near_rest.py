"""Friction near rest that is not the model's."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from cogging import EFFECTS
from cogging.diagnosis.naming.near_rest import is_friction_at_rest, near_rest
from cogging.diagnosis.search.search import search
from cogging.effects.effect import VOCABULARY
from tests.fixtures.moving_axis import machine, record

STRIBECK = [EFFECTS["stribeck_friction"](static_excess=0.8, velocity=4e-3, exponent=1.0)]


@pytest.fixture(scope="module")
def searched():
    def of(effects):
        found = search([record(machine(effects), 3)], machine(), [record(machine(effects), 4)])
        return replace(found, added=[])  # as if no name stood

    return {"nothing": of([]), "stribeck": of(STRIBECK)}


def test_it_is_said_where_both_motions_show_it_and_not_where_nothing_is_hidden(searched):
    assert near_rest(searched["nothing"]) is None
    told = near_rest(searched["stribeck"])
    assert told is not None
    assert told.confirm_log_p_value < -12.0
    assert set(told.candidates) == {"stribeck_friction", "presliding_friction"}
    assert "cannot tell which law" in told.text()
    assert "creep" in told.experiment


def test_other_motion_that_does_not_show_it_silences_it(searched):
    quiet = replace(searched["stribeck"], confirm_evidence=searched["nothing"].confirm_evidence)
    assert near_rest(quiet) is None


def test_a_coarse_encoder_silences_it(searched):
    model = searched["stribeck"].evidence.model
    coarse = model.replace(encoder=model.encoder.replace(resolution=1e-4))
    evidence = replace(searched["stribeck"].evidence, model=coarse)
    assert near_rest(replace(searched["stribeck"], evidence=evidence)) is None


def test_a_name_for_friction_at_rest_says_it_already(searched):
    told = searched["stribeck"]
    law = SimpleNamespace(law=VOCABULARY["stribeck_friction"])
    added = [SimpleNamespace(finding=SimpleNamespace(candidate=law))]
    assert near_rest(replace(told, added=added)) is None


def test_which_effects_are_friction_at_rest():
    found = {name for name, law in VOCABULARY.items() if is_friction_at_rest(law)}
    assert found == {"stribeck_friction", "presliding_friction"}
