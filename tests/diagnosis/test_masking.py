"""Masking: effects of the given model that hid what was missing."""

import cogging
from cogging.diagnosis.naming.masking import masking_notes
from tests.fixtures.pid_axis import MODEL

effects = cogging.effects


def test_masking_is_told():
    def with_effects(*present):
        return MODEL.replace(effects=present)

    before = with_effects(effects.ConstantForce(force=3.0))
    added = effects.ViscousAsymmetry(difference=-75.0)
    assert masking_notes(before, with_effects(effects.ConstantForce(force=2.0), added)) == []
    assert masking_notes(before, before) == []
    (note,) = masking_notes(before, with_effects(effects.ConstantForce(force=-0.1), added))
    assert note.startswith("constant_force of the given model nearly vanishes (3 to -0.1 V) once viscous_asymmetry")
