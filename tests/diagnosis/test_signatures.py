"""The grid of candidates, and their columns."""

import numpy as np

from cogging.diagnosis.candidates.signatures import candidates
from cogging.diagnosis.candidates.tables import tables
from cogging.diagnosis.candidates.waves import is_wave
from cogging.effects.effect import VOCABULARY


def test_every_effect_has_candidates_or_is_a_wave(quiet_evidence):
    for name, effect in VOCABULARY.items():
        if is_wave(effect):
            continue
        found = list(candidates(quiet_evidence, effect))
        if any(field.endswith("_nodes") and role["role"] == "setting" for field, role in effect.ROLES.items()):
            assert not found  # its places are the user's choice: it is added where it is asked for
            continue
        assert found, name
        made = tables(quiet_evidence, found[:2])
        for candidate, table in zip(found[:2], made, strict=True):
            assert table[0].shape == (max(1, len(candidate.amplitudes)), len(quiet_evidence.residual))
            assert np.isfinite(table[0]).all(), name
            assert name == candidate.effect([0.0] * len(candidate.amplitudes)).NAME
